"""Sizes of pictures."""

from typing import Any

import numpy as np

MOST_SIDE = 8192  # px


def check_size(width: Any, height: Any) -> None:
    """Raise ValueError for a size in px that no picture can have, before memory for it is asked for."""
    for value in (width, height):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= MOST_SIDE:
            raise ValueError(f"width and height must be 1 to {MOST_SIDE} px, got {width!r} x {height!r}.")
