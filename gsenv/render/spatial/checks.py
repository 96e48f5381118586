"""What 3D renderers refuse: arrows and stripes that kernels would read out of bounds or draw as nothing sensible."""

from __future__ import annotations

from typing import Any

import numpy as np

from gsenv.render.spatial.arrows import Arrow
from gsenv.render.spatial.stripes import Stripes

SIZES = {"places": (2, 2, 3), "grid": (5,), "bands": (0, 7)}  # least shapes; the last entry is exact
MEANINGS = {"places": "(row, column, 3) of at least two rows and columns", "grid": "(5,)", "bands": "(band, 7)"}


def checked_arrows(arrows: Any) -> tuple[Arrow, ...]:
    """Return arrows as a tuple, their places as float64; raises ValueError, in one sentence, for anything else."""
    if isinstance(arrows, Arrow) or not hasattr(arrows, "__iter__"):
        raise ValueError(f"render: arrows must be a sequence of Arrow, got {arrows!r}.")
    return tuple(_checked_arrow(arrow) for arrow in arrows)


def _checked_arrow(arrow: Any) -> Arrow:
    if not isinstance(arrow, Arrow):
        raise ValueError(f"render: arrows must be a sequence of Arrow, got one entry {arrow!r}.")
    tail, tip, color, head = (_numbers(value) for value in arrow)
    for name, place in (("tail", tail), ("tip", tip)):
        if place.shape != (3,) or not np.isfinite(place).all():
            raise ValueError(f"render: the {name} of an arrow must be three finite numbers, got {arrow[:2]}.")
    if color.shape != (3,) or not ((color >= 0.0) & (color <= 255.0)).all():
        raise ValueError(f"render: the color of an arrow must be three numbers from 0 to 255, got {arrow.color}.")
    if head.shape != (2,) or not ((head > 0.0) & (head < np.inf)).all():
        raise ValueError(f"render: the head of an arrow must be a length and a radius above 0 m, got {arrow.head}.")
    return arrow._replace(tail=tail, tip=tip)


def _numbers(value: Any) -> Any:
    """Return an array of float64, which is one NaN where there are no numbers."""
    try:
        return np.asarray(value, np.float64)
    except (TypeError, ValueError):
        return np.full(1, np.nan)


def check_stripes(stripes: Any) -> None:
    """Raise ValueError, in one sentence, for stripes whose arrays are not as `Stripes` says."""
    if stripes is None:
        return
    if not isinstance(stripes, Stripes):
        raise ValueError(f"render: stripes must be a Stripes or None, got {type(stripes).__name__}.")
    for name, least in SIZES.items():
        array = getattr(stripes, name)
        if not isinstance(array, np.ndarray) or array.dtype != np.float32 or not array.flags.c_contiguous:
            kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
            raise ValueError(f"render: the {name} of stripes must be a C-contiguous array of float32, got {kind}.")
        fits = array.ndim == len(least) and array.shape[-1] == least[-1]
        if not fits or any(size < wanted for size, wanted in zip(array.shape, least, strict=True)):
            raise ValueError(f"render: the {name} of stripes must be {MEANINGS[name]}, got {array.shape}.")
        if not np.isfinite(array).all():
            raise ValueError(f"render: the {name} of stripes must be finite.")
    if not stripes.grid[2] > 0.0:
        raise ValueError(f"render: the grid of stripes must have more than 0 points per m, got {stripes.grid[2]}.")
    if (stripes.bands[:, [0, 2, 3]] < 0.0).any():
        raise ValueError("render: half width, period and mark of a band of stripes must be at least 0 m.")
