"""Checks of the arguments of ``World.cast_rays``."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..records.model import Array
from ..specification import check


def _scaled(direction: Any) -> Any:
    """Return finite directions over their largest component, which may have any size; others as they are."""
    try:
        given = np.asarray(direction)
        if given.dtype.kind not in "uif":
            return direction  # refused with all others
        given = given.astype(float)
        largest = np.abs(given).max(-1, keepdims=True)
    except (TypeError, ValueError, OverflowError):
        return direction
    return given / largest if np.isfinite(given).all() and (largest > 0.0).all() else direction


def checked_rays(origin: Any, direction: Any, length: Any, worlds: int, dim: int) -> tuple[Array, Array, Array]:
    """Return origin (world, ray, dim) m, direction (world, ray, dim) unit and length (world, ray) m.

    Raises:
        ValueError: no numbers, shapes that do not fit, a length that is not positive, a direction of zero.
    """
    parts = {"origin": origin, "direction": _scaled(direction), "length": length}
    given = {name: check.numbers(value, f"cast_rays: {name}") for name, value in parts.items()}
    shapes = (given["origin"].shape, given["direction"].shape, (*given["length"].shape, 1))
    try:
        shape = np.broadcast_shapes((worlds, 1, dim), *shapes)
    except ValueError:
        shape = ()
    are_vectors = all(given[name].shape[-1:] == (dim,) for name in ("origin", "direction"))
    if not are_vectors or len(shape) != 3 or shape[0] != worlds or shape[2] != dim:
        got = ", ".join(str(array.shape) for array in given.values())
        raise ValueError(
            f"cast_rays: origin, direction and length must fit ({worlds}, rays, {dim}), ({worlds}, rays, {dim}) and "
            f"({worlds}, rays), got arrays of shape {got}."
        )
    if (given["length"] <= 0.0).any():
        raise ValueError(f"cast_rays: length must be positive, got {given['length'].min()!r}.")
    largest = np.abs(given["direction"]).max(-1, initial=0.0, keepdims=True)
    if (largest == 0.0).any():
        raise ValueError("cast_rays: direction must not be zero.")
    way = given["direction"] / largest  # squares of large numbers might overflow
    unit = way / np.sqrt((way * way).sum(-1, keepdims=True))
    return (
        np.broadcast_to(given["origin"], shape),
        np.broadcast_to(unit, shape),
        np.broadcast_to(given["length"], shape[:2]),
    )
