"""Arrows and dots in pixels."""

import numpy as np
import pytest

from gsenv.render.camera import Camera
from gsenv.render.canvas import Canvas
from gsenv.render.draw_list import DrawList
from gsenv.render.overlay import Pen, arrows, dots, lines
from gsenv.render.theme import Theme

SIZE = 100
GRAY = Theme(sky_top=(128.0,) * 3, sky_bottom=(128.0,) * 3)
WHITE = (255.0, 255.0, 255.0)
PEN = Pen(2.0, 1.5)


def draw(draw_list: DrawList) -> np.ndarray:
    """(SIZE, SIZE) brightness around gray; 1 px is 1 m and the middle is the origin."""
    return Canvas(SIZE, SIZE, GRAY).draw(draw_list, Camera((0.0, 0.0), SIZE))[..., 0].astype(int) - 128


def test_a_line_has_a_bright_core_and_a_dark_halo() -> None:
    column = draw(lines([(-20.0, 0.0)], [(20.0, 0.0)], PEN, WHITE))[:, 50]
    assert (column[48:52] == 127).all()
    assert column[47] < -50
    assert column[52] < -50
    assert (column[:45] == 0).all()
    assert (column[55:] == 0).all()


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, -1.9])
def test_an_arrow_is_wide_at_its_head_and_points_the_right_way(angle: float) -> None:
    direction = np.array([np.cos(angle), np.sin(angle)])
    image = draw(arrows([(0.0, 0.0)], [30.0 * direction], PEN, WHITE)) > 60
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5 - SIZE / 2
    along = x * direction[0] - y * direction[1]
    assert along[image].max() == pytest.approx(30.0, abs=2.0)
    assert along[image].min() == pytest.approx(-2.0, abs=1.2)
    shaft, head = ((along > a) & (along < a + 3.0) & image for a in (8.0, 19.0))
    assert head.sum() > 1.8 * shaft.sum()


def test_arrows_without_length_are_dropped() -> None:
    assert (draw(arrows([(1.0, 1.0)], [(1.0, 1.0)], PEN, WHITE)) == 0).all()
    assert (draw(arrows(np.empty((0, 2)), np.empty((0, 2)), PEN, WHITE)) == 0).all()


def test_dots_are_discs() -> None:
    bright = draw(dots([(10.0, 20.0), (-30.0, -5.0)], Pen(4.0, 1.0), WHITE)) > 0
    assert bright.sum() == pytest.approx(2.0 * np.pi * 16.0, rel=0.05)
    assert bright[30, 60]
    assert bright[55, 20]
