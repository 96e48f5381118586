"""Text overlay (head-up display) in the corner of a picture: dark text on a translucent panel."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gsenv.render.stroke_font import CAP_HEIGHT, text_coverage
from gsenv.render.theme import INK_COLOR, PANEL_ALPHA, PANEL_COLOR

CAP_SHARE = 0.023  # height of a capital letter, as a fraction of the picture's height
CAP_MIN = 5.5  # px, least height of a capital letter
PADDING = 0.6  # in heights of a capital letter
CORNER = 0.5  # radius of the panel's corners, in heights of a capital letter


def draw_hud(image: NDArray[np.uint8], lines: tuple[str, ...], below: bool = False) -> None:
    """Write lines of text into the top left corner of an image (height, width, 3), or the one below it, in place."""
    height, width = image.shape[:2]
    cap = max(CAP_SHARE * height, CAP_MIN)
    padding = round(PADDING * cap)
    edge = round(0.5 * cap)
    room = width - 2 * (padding + edge)
    if room < 1:
        return
    texts = [text_coverage(line, cap / CAP_HEIGHT, room) for line in lines]
    columns = max(text.shape[1] for text in texts)
    ink = np.concatenate([np.pad(text, ((0, 0), (0, columns - text.shape[1]))) for text in texts])
    # A line is higher than its letters, so vertical padding is smaller.
    ink = np.pad(ink, ((padding // 3, padding // 3), (padding, padding)))[: height - edge]
    panel = panel_coverage(*ink.shape, CORNER * cap)
    top = height - edge - ink.shape[0] if below else edge
    view = image[top : top + ink.shape[0], edge : edge + ink.shape[1]]
    mixed = view + (np.array(PANEL_COLOR, np.float32) - view) * (PANEL_ALPHA * panel)[..., None]
    mixed += (np.array(INK_COLOR, np.float32) - mixed) * ink[..., None]
    view[...] = np.rint(mixed)


@lru_cache(maxsize=32)
def panel_coverage(rows: int, columns: int, radius: float) -> NDArray[np.float32]:
    """Return the (row, column) coverage, 0 to 1, of a rounded rectangle that fills the array."""
    x = np.abs(np.arange(columns) + 0.5 - 0.5 * columns) - (0.5 * columns - radius)
    y = np.abs(np.arange(rows) + 0.5 - 0.5 * rows) - (0.5 * rows - radius)
    corner = np.hypot(np.maximum(x, 0.0)[None, :], np.maximum(y, 0.0)[:, None])
    distance = corner + np.minimum(np.maximum(x[None, :], y[:, None]), 0.0) - radius
    return np.clip(0.5 - distance, 0.0, 1.0).astype(np.float32)
