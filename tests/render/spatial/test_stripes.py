"""Stripes on heightfields, in pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.scene_renderer import SpatialRenderer
from gsenv.render.spatial.stripes import UNKNOWN, Stripes, band
from gsenv.solver import Scene, World
from gsenv.solver.spatial import Heightfield

RED = (200, 20, 20)
SIDE = 200  # px
ABOVE = SpatialCamera((0.0, 0.0, 10.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), width=SIDE, height=SIDE)
SCALE = 0.5 * SIDE / np.tan(0.5 * ABOVE.fov) / 10.0  # px per m


@pytest.fixture
def renderer() -> SpatialRenderer:
    """A field of 8 x 8 m, level, seen from above; x is to the right."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", [Heightfield(heights=np.zeros((9, 9)), size=(8.0, 8.0))])
    return SpatialRenderer(World(scene), SIDE, SIDE, ABOVE)


def along_x(*bands: list[float], first: float = -9.0, last: float = 9.0, wide: float = 0.0) -> Stripes:
    """Stripes along the x axis, whose zero of lengths is in the middle."""
    x, y = np.meshgrid(np.linspace(-4.0, 4.0, 17), np.linspace(-4.0, 4.0, 17))
    places = np.stack([y, x, np.full_like(x, wide)], -1).astype(np.float32)
    grid = np.array([-4.0, -4.0, 2.0, first, last], np.float32)
    return Stripes(places, grid, np.array(bands, np.float32))


def painted(renderer: SpatialRenderer, stripes: Stripes) -> NDArray[np.bool_]:
    image: Any = renderer.render(stripes=stripes)
    return np.asarray(image[..., 0].astype(int) - image[..., 1] > 60)


def test_a_stripe_is_as_wide_as_it_says_and_has_no_seams(renderer: SpatialRenderer) -> None:
    seen = painted(renderer, along_x(band(0.6, RED)))
    widths = seen.sum(axis=0)
    assert np.abs(widths - 1.2 * SCALE).max() < 2.0  # in every column
    assert np.abs(np.flatnonzero(seen.any(axis=1)).mean() - 0.5 * (SIDE - 1)) < 1.0
    colors = renderer.render(stripes=along_x(band(0.6, RED)))[SIDE // 2].astype(int)
    assert np.abs(np.diff(colors, axis=0)).max() <= 2  # even along the stripe


def test_marks_have_their_period_and_length(renderer: SpatialRenderer) -> None:
    row = painted(renderer, along_x(band(0.6, RED, period=2.0, mark=0.8)))[SIDE // 2]
    starts = np.flatnonzero(row[1:] & ~row[:-1])
    ends = np.flatnonzero(row[:-1] & ~row[1:])
    assert np.abs(np.diff(starts) - 2.0 * SCALE).max() < 2.0
    assert (
        np.abs(ends[ends > starts[0]][: len(starts)] - starts[: len(ends[ends > starts[0]])] - 0.8 * SCALE).max() < 2.0
    )
    middle = 0.5 * SIDE + SCALE  # of the period that begins at x = 0
    assert row[round(middle)]
    assert not row[round(middle + 0.6 * SCALE)]


def test_stripes_end_widen_and_are_painted_in_order(renderer: SpatialRenderer) -> None:
    row = painted(renderer, along_x(band(0.6, RED), first=-1.0, last=1.5))[SIDE // 2]
    assert np.abs(np.flatnonzero(row)[[0, -1]] - (0.5 * SIDE + SCALE * np.array([-1.0, 1.5]))).max() < 2.0
    assert not painted(renderer, along_x(band(0.0, RED, widening=1.0))).any()
    wide = painted(renderer, along_x(band(0.0, RED, widening=1.0), wide=0.5))
    assert np.abs(wide.sum(axis=0) - SCALE).max() < 2.0
    covered = painted(renderer, along_x(band(0.6, RED), band(0.6, (20, 20, 20))))
    assert not covered.any()


def test_nothing_is_painted_where_the_place_is_unknown(renderer: SpatialRenderer) -> None:
    stripes = along_x(band(0.6, RED))
    stripes.places[:, 8:, 0] = UNKNOWN
    row = painted(renderer, stripes)[SIDE // 2]
    assert row[: SIDE // 2 - round(0.6 * SCALE)].all()
    assert not row[SIDE // 2 :].any()


def test_quality_fast_paints_too(renderer: SpatialRenderer) -> None:
    fast = SpatialRenderer(renderer.world, SIDE, SIDE, ABOVE, "fast")
    assert painted(fast, along_x(band(0.6, RED))).sum() > 0.9 * 1.2 * SCALE * SIDE


def spoilt(name: str, array: Any) -> Stripes:
    """Stripes of which one array is another."""
    return along_x(band(0.6, RED))._replace(**{name: array})


def filled(shape: tuple[int, ...], value: float) -> NDArray[np.float32]:
    return np.full(shape, value, np.float32)


@pytest.mark.parametrize(
    ("stripes", "said"),
    [
        ("road", "a Stripes or None, got str"),
        (spoilt("bands", filled((1, 6), 0.1)), r"the bands of stripes must be \(band, 7\), got \(1, 6\)"),
        (spoilt("bands", filled((7,), 0.1)), r"the bands of stripes must be \(band, 7\), got \(7,\)"),
        (spoilt("bands", filled((1, 7), np.inf)), "the bands of stripes must be finite"),
        (spoilt("bands", filled((1, 7), -0.1)), "must be at least 0 m"),
        (spoilt("bands", np.zeros((1, 7))), "float32, got float64"),
        (spoilt("bands", [[0.1] * 7]), "float32, got list"),
        (spoilt("grid", filled((4,), 1.0)), r"the grid of stripes must be \(5,\), got \(4,\)"),
        (spoilt("grid", filled((5,), np.nan)), "the grid of stripes must be finite"),
        (spoilt("grid", filled((5,), 0.0)), "more than 0 points per m"),
        (spoilt("places", filled((1, 17, 3), 0.0)), "at least two rows and columns, got"),
        (spoilt("places", filled((17, 17, 2), 0.0)), r"\(row, column, 3\)"),
        (spoilt("places", filled((17, 17, 3), np.nan)), "the places of stripes must be finite"),
        (spoilt("places", filled((17, 17, 6), 0.0)[..., ::2]), "a C-contiguous array"),
    ],
)
def test_what_kernels_would_read_out_of_bounds_is_refused(renderer: SpatialRenderer, stripes: Any, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        renderer.render(stripes=stripes)
    with pytest.raises(ValueError, match=said):
        renderer.frame(stripes=stripes)


def test_no_bands_paint_nothing(renderer: SpatialRenderer) -> None:
    np.testing.assert_array_equal(renderer.render(stripes=spoilt("bands", filled((0, 7), 0.0))), renderer.render())
