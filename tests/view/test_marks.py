"""Arrows, lines and panels on a picture."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.view.marks import Marks
from gsenv.view.panels import draw_panel, draw_status, status_height

RED = (255.0, 0.0, 0.0)


def gray(height: int = 60, width: int = 100) -> np.ndarray:
    return np.full((height, width, 3), 128, np.uint8)


def test_a_line_has_its_colour_a_halo_and_nothing_beyond() -> None:
    image = gray()
    marks = Marks(2.0)
    marks.add_lines([(20.0, 30.0)], [(80.0, 30.0)], RED)
    marks.draw(image)
    assert (image[30, 20:80] == (255, 0, 0)).all()
    assert (image[33, 30:70] < 128).all()  # dark halo
    assert (image[:25] == 128).all()
    assert (image[36:] == 128).all()
    assert (image[:, :15] == 128).all()


def test_an_arrow_is_wide_at_its_head_and_ends_at_its_tip() -> None:
    image = gray()
    marks = Marks(2.0)
    marks.add_arrows([(20.0, 30.0)], [(80.0, 30.0)], RED)
    marks.draw(image)
    width = (image[..., 0] > 200).sum(axis=0)
    assert width[20:60].max() <= 5
    assert width[70:74].max() >= 8
    assert width[82:].max() == 0


@pytest.mark.parametrize("points", [[(np.nan, 1.0)], [(1e9, 1.0)], [(-500.0, -500.0)], np.zeros((0, 2))])
def test_marks_outside_of_the_picture_or_behind_the_eye_are_left_out(points: list[tuple[float, float]]) -> None:
    image = gray()
    marks = Marks(2.0)
    marks.add_dots(points, RED)
    marks.add_arrows(points, points, RED)
    marks.draw(image)
    assert (image == 128).all()


def test_panels_lie_where_they_are_asked_for() -> None:
    for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5)):
        image = gray(240, 320)
        draw_panel(image, [["one", "two"], ["1", "2"]], x, y, letter=8.0)
        rows, columns = np.nonzero((image != 128).any(axis=-1))
        center = 0.5 * (columns.min() + columns.max()) / 320, 0.5 * (rows.min() + rows.max()) / 240
        expected = 0.12 + 0.76 * x, 0.1 + 0.8 * y
        np.testing.assert_allclose(center, expected, atol=0.06)
    image = gray(240, 320)
    draw_panel(image, [[]], 0.0, 0.0, letter=8.0)
    assert (image == 128).all()


def test_the_status_bar_drops_its_middle_where_there_is_no_room() -> None:
    wide, empty = (draw_status(600, 240, "left", middle, "right") for middle in ("in the middle", ""))
    assert wide.shape == (status_height(240), 600, 3)
    assert (wide[:, 250:350] != empty[:, 250:350]).any()
    narrow = [draw_status(90, 240, "left", middle, "right") for middle in ("in the middle", "")]
    np.testing.assert_array_equal(narrow[0], narrow[1])
