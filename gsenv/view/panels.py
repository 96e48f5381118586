"""Panels of text on a picture: dark text on a translucent ground, at any edge or corner."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gsenv.render.hud import panel_coverage
from gsenv.render.stroke_font import CAP_HEIGHT, text_coverage
from gsenv.render.theme import INK_COLOR, PANEL_COLOR, Rgb

Frame = NDArray[np.uint8]
Coverage = NDArray[np.float32]

CAP_SHARE = 0.0185  # height of a capital letter over that of the picture
CAP_MIN, CAP_MAX = 6.0, 16.0  # px
ALPHA = 0.80
BORDER_COLOR: Rgb = (196, 202, 212)
PADDING = 0.8  # in heights of a capital letter
GAP = 1.6  # between columns
STATUS_LINES = 2.6  # height of the status bar, in heights of a capital letter


def cap_height(height: int) -> float:
    """Return the height in px of a capital letter, for a picture of this height."""
    return min(max(CAP_SHARE * height, CAP_MIN), CAP_MAX)


def status_height(height: int) -> int:
    """Return the height in px of the status bar."""
    return round(STATUS_LINES * cap_height(height))


def draw_panel(
    image: Frame,
    columns: Sequence[Sequence[str]],
    x: float,
    y: float,
    *,
    letter: float,
    color: Rgb = PANEL_COLOR,
    alpha: float = ALPHA,
) -> None:
    """Draw columns of lines of text, in place.

    x, y: 0 is the left or upper edge, 1 the right or lower one
    letter: px, height of a capital letter
    """
    height, width = image.shape[:2]
    cap = letter
    margin = round(0.6 * cap)
    padding = round(PADDING * cap)
    ink = _columns(columns, cap, width - 2 * (margin + padding))
    if ink is None:
        return
    ink = np.pad(ink, ((padding // 2, padding // 2), (padding, padding)))
    ink = ink[: max(height - 2 * margin, 0), : width - 2 * margin]
    top = margin + round(y * (height - 2 * margin - ink.shape[0]))
    left = margin + round(x * (width - 2 * margin - ink.shape[1]))
    view = image[top : top + ink.shape[0], left : left + ink.shape[1]]
    _mix(view, alpha * panel_coverage(*ink.shape, 0.6 * cap), color)
    _mix(view, ink, INK_COLOR)


def draw_status(width: int, height: int, left: str, middle: str, right: str) -> Frame:
    """Return the status bar of a picture (height, width); what does not fit is left out, the middle part first."""
    cap = cap_height(height)
    bar = np.empty((status_height(height), width, 3), np.uint8)
    bar[:] = np.rint(PANEL_COLOR)
    bar[0] = np.rint(BORDER_COLOR)
    margin, gap = round(1.2 * cap), round(GAP * cap)
    room = max(width - 2 * margin, 1)
    first, last, other = (text_coverage(text, cap / CAP_HEIGHT, room) for text in (left, right, middle))
    start, end = margin, width - margin  # of the free room
    _write(bar, first, start)
    start += first.shape[1] + gap
    if last.shape[1] <= end - start:
        _write(bar, last, end - last.shape[1])
        end -= last.shape[1] + gap
    if other.shape[1] <= end - start:
        _write(bar, other, min(max((width - other.shape[1]) // 2, start), end - other.shape[1]))
    return bar


def _write(bar: Frame, text: Coverage, left: int) -> None:
    """Write a line of text into the bar, in place."""
    text = text[: bar.shape[0], : max(bar.shape[1] - left, 0)]
    top = (bar.shape[0] - text.shape[0]) // 2
    _mix(bar[top : top + text.shape[0], left : left + text.shape[1]], text, INK_COLOR)


def _columns(columns: Sequence[Sequence[str]], cap: float, room: int) -> Coverage | None:
    """Return the coverage of those columns of text that have room side by side, or None."""
    unit = cap / CAP_HEIGHT
    gap = round(GAP * cap)
    parts: list[Coverage] = []
    for lines in columns:
        used = sum(part.shape[1] + gap for part in parts)
        if room - used < 4 * cap or not lines:
            break
        texts = [text_coverage(line or " ", unit, room - used) for line in lines]
        widest = max((text.shape[1] for text in texts), default=0)
        parts.append(np.concatenate([np.pad(text, ((0, 0), (0, widest - text.shape[1]))) for text in texts]))
    if not parts:
        return None
    tallest = max(part.shape[0] for part in parts)
    padded = [np.pad(part, ((0, tallest - part.shape[0]), (0, gap))) for part in parts]
    return np.concatenate(padded, axis=1)[:, : -gap or None]


def _mix(view: Frame, coverage: Coverage, color: Rgb) -> None:
    mixed = view + (np.array(color, np.float32) - view) * coverage[..., None]
    view[...] = np.rint(mixed)
