"""Font and text panel."""

import string

import numpy as np
import pytest

from gsenv.render.hud import draw_hud
from gsenv.render.stroke_font import GLYPHS, LINE_HEIGHT, glyph_coverage, text_coverage

UNIT = 2.0  # px per grid unit


def test_letters_and_digits_are_there_and_differ() -> None:
    assert set(string.ascii_letters + string.digits + ".,:=+-/%()") <= set(GLYPHS)
    seen: dict[tuple[tuple[int, ...], bytes], str] = {}
    for character in GLYPHS:
        ink = glyph_coverage(character, UNIT)
        assert ink.sum() > 2.0, character
        key = (ink.shape, ink.tobytes())
        assert key not in seen, (character, seen.get(key))
        seen[key] = character


def test_glyphs_are_whole() -> None:
    """No ink is cut at the border of a tile, so neighbours neither touch nor overlap."""
    for character in GLYPHS:
        ink = glyph_coverage(character, 4.0)
        border = np.concatenate([ink[0], ink[-1], ink[:, 0], ink[:, -1]])
        assert border.max() == 0.0, character


def test_digits_are_equally_wide() -> None:
    assert len({glyph_coverage(digit, UNIT).shape for digit in string.digits}) == 1


def test_unknown_characters_show() -> None:
    assert glyph_coverage("\N{SNOWMAN}", UNIT).sum() > 3.0


@pytest.mark.parametrize("width", [30, 100])
def test_long_text_is_shortened(width: int) -> None:
    full = text_coverage("reward 1234.5678", UNIT, 10_000)
    short = text_coverage("reward 1234.5678", UNIT, width)
    dots = text_coverage("...", UNIT, 10_000)
    assert short.shape[1] <= width < full.shape[1]
    np.testing.assert_array_equal(short[:, -dots.shape[1] :], dots)


def test_no_text_is_fine() -> None:
    assert text_coverage("", UNIT, 100).shape == (LINE_HEIGHT * UNIT, 0)


def test_text_is_dark_on_light_and_stays_in_its_corner() -> None:
    image = np.full((480, 640, 3), 128, np.uint8)
    draw_hud(image, ("t = 3.2 s", "reward -1.5"))
    changed = (image != 128).any(axis=2)
    assert changed[:60, :160].any()
    assert not changed[60:].any()
    assert not changed[:, 160:].any()
    panel = image[8:45, 8:120]
    assert panel.min() < 60
    assert np.median(panel) > 180


def test_text_in_the_lower_corner_is_that_of_the_upper_one() -> None:
    texts = ("t = 3.2 s", "reward -1.5")
    upper, lower = np.full((480, 640, 3), 128, np.uint8), np.full((480, 640, 3), 128, np.uint8)
    draw_hud(upper, texts)
    draw_hud(lower, texts, below=True)
    rows = np.flatnonzero((upper != 128).any(axis=(1, 2)))
    moved = np.flatnonzero((lower != 128).any(axis=(1, 2)))
    assert rows[0] + moved[-1] == 479  # equal distances to the edge
    np.testing.assert_array_equal(lower[moved[0] : moved[-1] + 1], upper[rows[0] : rows[-1] + 1])


@pytest.mark.parametrize("shape", [(84, 84), (16, 16), (4, 4), (1, 1)])
def test_small_pictures_do_not_fail(shape: tuple[int, int]) -> None:
    image = np.zeros((*shape, 3), np.uint8)
    draw_hud(image, ("t = 3.2 s", "reward -1.5", "third"))
    assert image.shape == (*shape, 3)
    assert image.any() or min(shape) < 16  # text wherever there is room for it
