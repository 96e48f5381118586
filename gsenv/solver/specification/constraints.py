"""Checks of user constraints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..records.model import NDOF, Array
from . import check
from .handles import Reference, find
from .specs import JointSpec, SceneSpec


def constraint_spec(
    name: str, bodies: Sequence[Reference] | Reference, jacobian: Any, bounds: Mapping[str, Any], frame: str,
    update: Callable[[Any], Mapping[str, Any]] | None, enabled: bool, scene: SceneSpec,
) -> JointSpec:  # fmt: skip
    """Return the checked constraint; ``bounds`` has lower, upper, bias and softness.

    Raises:
        ValueError: an unknown body, or rows that are no numbers, too many or of the wrong width.
    """
    what = f"constraint {name!r}"
    if not isinstance(bodies, Sequence) or isinstance(bodies, str):
        bodies = (bodies,)
    index = [find(body, "body", list(scene.bodies), what) for body in bodies]
    if len(index) not in (1, 2) or len(set(index)) != len(index):
        raise ValueError(f"{what} needs one body or two different ones, got {len(index)}.")
    ndof = NDOF[scene.dim]
    rows = _jacobian(jacobian, ndof, len(index), what)
    low = check.bounds(bounds["lower"], (len(rows),), f"{what}: lower")
    high = check.bounds(bounds["upper"], (len(rows),), f"{what}: upper")
    check.ordered_bounds(low, high, what)
    bias = check.values(bounds["bias"], (len(rows),), f"{what}: bias")
    softness = check.values(bounds["softness"], (len(rows),), f"{what}: softness")
    if (softness < 0.0).any():
        raise ValueError(f"{what}: softness must not be negative.")
    check.choice(frame, ("world", "body"), f"{what}: frame")
    if update is not None and not callable(update):
        raise ValueError(f"{what}: update must be a function of the world, got {update!r}.")
    on = check.flag(enabled, f"{what}: enabled")
    made = [
        {
            "jacobian_a": row[:ndof] if len(index) == 2 else np.zeros(ndof),
            "jacobian_b": row[-ndof:],
            "lower": low[r],
            "upper": high[r],
            "bias": bias[r],
            "softness": softness[r],
        }
        for r, row in enumerate(rows)
    ]
    return JointSpec(name, "rows", index[0], index[-1], on, len(rows), rows=made, frame=frame, update=update)


def _jacobian(jacobian: Any, ndof: int, bodies: int, what: str) -> Array:
    """Return a checked Jacobian (row, bodies * ndof), a copy."""
    rows = np.atleast_2d(check.numbers(jacobian, f"{what}: jacobian"))
    if rows.ndim != 2 or rows.shape[1] != ndof * bodies or not 1 <= len(rows) <= ndof:
        raise ValueError(
            f"{what}: jacobian must have 1 to {ndof} rows of {ndof * bodies} numbers, "
            f"got an array of shape {np.shape(jacobian)}."
        )
    return rows
