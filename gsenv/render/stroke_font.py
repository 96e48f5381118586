"""A small stroke font: glyphs are pen strokes on a grid, rasterised with anti-aliasing at any size.

A stroke is a sequence of points "xy", one digit each. The baseline is y = 2, the x-height y = 6, the
cap height y = 8. A leading "~" smooths a stroke into an open curve, "@" into a closed one.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Coverage = NDArray[np.float32]

CAP_HEIGHT, LINE_HEIGHT = 6.0, 11.0  # grid units; a line extends from y = -1 to y = 10
PEN_RADIUS = 0.46
GAP = 1.7  # between glyphs
SPACE = 2.4
MIN_WIDTH = 0.7
SMOOTHING_ROUNDS = 3
RING = "@06464202"

_LETTERS = {
    "a": f"{RING} 4642", "b": f"{RING} 0802", "c": "~454606024243", "d": f"{RING} 4842",
    "e": "0444 ~4446060242", "f": "~481814 1412 0636", "g": f"{RING} ~46404010",
    "h": "0802 ~04064642", "i": "0602 0808", "j": "~262000 2828", "k": "0802 3604 1532",
    "l": "0804 ~040222", "m": "0602 ~04063632 ~34366662", "n": "0602 ~04064642", "o": RING,
    "p": f"{RING} 0600", "q": f"{RING} 4640", "r": "0602 ~040636", "s": "~4546060444420203",
    "t": "1814 ~141232 0636", "u": "~06024244 4642", "v": "062246", "w": "0622364266",
    "x": "0642 0246", "y": "0622 4610", "z": "06460242",
    "A": "022842 1434", "B": "0802 0828 ~28484525 0525 ~25454222 0222", "C": "~474808024243",
    "D": "0802 0818 ~18484212 0212", "E": "48080242 0535", "F": "480802 0535",
    "G": "~474808024244 4424", "H": "0802 4842 0545", "I": "0828 1812 0222", "J": "4844 ~44420203",
    "K": "0802 4804 1542", "L": "080242", "M": "0208356862", "N": "02084248",
    "O": "@08585202", "P": "0802 0828 ~28484424 0424", "Q": "@08585202 2452",
    "R": "0802 0828 ~28484424 0424 2442", "S": "~4748080545420203", "T": "0848 2822",
    "U": "0804 ~04024244 4448", "V": "082248", "W": "0822364268", "X": "0842 0248",
    "Y": "0825 4825 2522", "Z": "08480242",
}  # fmt: skip
_DIGITS = {
    "0": "@08484202", "1": "172822", "2": "~0708484502 0242",
    "3": "~0708484515 ~1545420203", "4": "32380444", "5": "480805 ~0546420203",
    "6": "@06464202 ~380804", "7": "084812", "8": "@08484505 @05454202",
    "9": "@04444808 ~464212",
}  # fmt: skip
_SIGNS = {
    ".": "0202", ",": "1201", ":": "0202 0505", ";": "1201 1515", "=": "0343 0545",
    "+": "0444 2226", "-": "0434", "/": "0138", "%": "0248 @08282606 @24444222",
    "(": "~19070311", ")": "~09171301", "[": "19090111", "]": "09191101", "<": "460442",
    ">": "064402", "_": "0141", "'": "0807", '"': "0807 1817", "!": "0804 0202",
    "?": "~070848452524 2222", "|": "0901", "*": "2426 1535", "^": "062846", "°": "@08282606",
    "#": "1218 3238 0444 0646",
}  # fmt: skip
GLYPHS = _LETTERS | _DIGITS | _SIGNS
UNKNOWN = "0848420208"


def smooth(points: FloatArray, closed: bool) -> FloatArray:
    """Smooth a polyline (point, 2) by repeated corner cutting; the ends of an open one stay."""
    for _ in range(SMOOTHING_ROUNDS):
        a = points if closed else points[:-1]
        b = np.roll(points, -1, axis=0) if closed else points[1:]
        cut = np.stack([0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b], axis=1).reshape(-1, 2)
        points = cut if closed else np.concatenate([points[:1], cut[1:-1], points[-1:]])
    return np.concatenate([points, points[:1]]) if closed else points


@lru_cache(maxsize=256)
def glyph_segments(character: str) -> FloatArray:
    """Return the glyph's segments (segment, 4): x, y of both ends in grid units."""
    segments = []
    for stroke in GLYPHS.get(character, UNKNOWN).split():
        digits = [float(digit) for digit in stroke if digit.isdigit()]
        points = np.array(digits).reshape(-1, 2)
        if not stroke[0].isdigit():
            points = smooth(points, closed=stroke[0] == "@")
        segments.append(np.concatenate([points[:-1], points[1:]], axis=1))
    return np.concatenate(segments)


def glyph_width(character: str) -> float:
    """Return the glyph's width in grid units; all digits are equally wide, so that changing numbers stay in place."""
    if character in _DIGITS:
        return 4.0
    return max(float(glyph_segments(character)[:, ::2].max()), MIN_WIDTH)


@lru_cache(maxsize=1024)
def glyph_coverage(character: str, unit: float) -> Coverage:
    """Return the (row, column) coverage, 0 to 1, of a glyph and its gap; `unit` is px per grid unit."""
    rows = round(LINE_HEIGHT * unit)
    if character == " ":
        return np.zeros((rows, round(SPACE * unit)), np.float32)
    columns = round((glyph_width(character) + GAP) * unit)
    x = (np.arange(columns) + 0.5) / unit - 0.5 * GAP
    y = LINE_HEIGHT - 1.0 - (np.arange(rows) + 0.5) / unit
    ax, ay, bx, by = glyph_segments(character).T[:, :, None, None]
    dx, dy = bx - ax, by - ay
    px, py = x[None, None, :] - ax, y[None, :, None] - ay
    t = np.clip((px * dx + py * dy) / np.maximum(dx * dx + dy * dy, 1e-12), 0.0, 1.0)
    distance = np.hypot(px - t * dx, py - t * dy).min(axis=0) - PEN_RADIUS
    return np.clip(0.5 - distance * unit, 0.0, 1.0).astype(np.float32)


def text_coverage(text: str, unit: float, max_width: int) -> Coverage:
    """Return the (row, column) coverage of one line; text beyond `max_width` px is replaced by "..."."""
    tiles = [glyph_coverage(character, unit) for character in text]
    widths = np.cumsum([tile.shape[1] for tile in tiles])
    if len(tiles) and widths[-1] > max_width:
        dots = [glyph_coverage(".", unit)] * 3
        room = max_width - sum(dot.shape[1] for dot in dots)
        tiles = tiles[: int(np.searchsorted(widths, room, side="right"))] + dots
    if not tiles:
        return np.zeros((round(LINE_HEIGHT * unit), 0), np.float32)
    return np.concatenate(tiles, axis=1)[:, :max_width]
