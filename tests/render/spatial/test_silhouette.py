"""Convex hulls in pictures, and the pixels they cover."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from gsenv.render.spatial.silhouette import coverage, find_hull, measure

SIDE = 240  # px
X, Y = np.arange(0.5, SIDE)[None, :], np.arange(0.5, SIDE)[:, None]


def strip(angle: float, length: float, width: float) -> NDArray[np.float64]:
    """Return the corners of a strip around the middle of the picture, in px."""
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    corners = [s * length * along + t * width * across for s in (-0.5, 0.5) for t in (-0.5, 0.5)]
    return 0.5 * SIDE + np.array(corners)


def test_a_hull_has_the_outer_corners_in_order() -> None:
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    inner = [(0.5, 0.0), (0.5, 0.5), (1.0, 0.25), (0.0, 0.0)]  # one on an edge, one inside, a corner twice
    assert_allclose(find_hull(np.array(inner + square[::-1])), square)


@pytest.mark.parametrize("width", [0.4, 1.0, 4.0])  # px
@pytest.mark.parametrize("degrees", [0.0, 1.9, 3.75, 10.0, 43.0, 61.3, 90.0])
def test_a_thin_strip_covers_its_area(degrees: float, width: float) -> None:
    cover = coverage(*measure(strip(np.radians(degrees), 160.0, width), X, Y))
    assert cover.sum() == pytest.approx(160.0 * width, rel=0.03)
    assert cover.max() <= min(width, 1.0) + 1e-9


def test_distances_are_negative_inside_and_a_line_covers_nothing() -> None:
    outside, width = measure(strip(0.3, 100.0, 20.0), X[:, 120], Y[120])
    assert_allclose(outside, -10.0, atol=0.7)
    assert width == pytest.approx(20.0)
    for points in (strip(0.0, 100.0, 0.0), strip(0.0, 0.0, 0.0)):
        assert not coverage(*measure(points, X, Y)).any()
