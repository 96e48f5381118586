"""Inverse masses on which frequencies of springs are given, the same at all poses; see spatial/joints/reference.py."""

from __future__ import annotations

from typing import Any

from ...jit import njit


@njit
def reference_give(joint: Any, a: Any, b: Any) -> Any:
    """Return 0 for that of the row: coordinates in the plane have the same inverse mass at each pose."""
    return 0.0


@njit
def anchor_give(parameters: Any, a: Any, b: Any) -> Any:
    """Return the inverse mass in 1/kg of the anchors of a joint, the mean over all directions; a, b: parameters."""
    return a.inv_mass + b.inv_mass + 0.5 * (_arm_give(parameters.anchor_a, a) + _arm_give(parameters.anchor_b, b))


@njit
def _arm_give(anchor: Any, body: Any) -> Any:
    x, y = anchor[0] - body.center[0], anchor[1] - body.center[1]
    return body.inv_inertia * (x * x + y * y)


@njit
def turn_give(a: Any, b: Any) -> Any:
    """Return the inverse inertia in 1/(kg m^2) of the rotation of a body in another; a, b: parameters."""
    return a.inv_inertia + b.inv_inertia
