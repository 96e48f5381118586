"""The inverse masses on which the frequencies of springs are given: of a joint's coordinate at its reference pose.

Those at the present pose would change with it, and the forces of springs would have no potential. Springs between two
anchors and soft welds act in all directions, so theirs are means over the directions.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..math import Vec, conjugate, cross, dot, quaternion, sub, turned, vec
from .axes import axis_of, turn_direction


@njit
def reference_give(joint: Any, a: Any, b: Any) -> float:
    """Return J M^-1 J^T where the coordinates are 0, 1/kg or 1/(kg m^2); a, b: parameters of the bodies."""
    p = joint.parameters
    number = joint.model.coordinate
    frame = quaternion(p.frame)
    back = conjugate(quaternion(p.reference))
    if number >= 3:
        u = turn_direction(number, frame, frame)
        return _turning(a, u) + _turning(b, turned(back, u))
    u = axis_of(frame, number)
    arm_a = sub(vec(p.anchor_a), vec(a.center))
    arm_b = sub(vec(p.anchor_b), vec(b.center))
    give: float = a.inv_mass + b.inv_mass
    return give + _turning(a, cross(arm_a, u)) + _turning(b, cross(arm_b, turned(back, u)))


@njit
def anchor_give(parameters: Any, a: Any, b: Any) -> float:
    """Return the inverse mass in 1/kg of the anchors of a joint, the mean over all directions; a, b: parameters."""
    arms = _arm_give(parameters.anchor_a, a) + _arm_give(parameters.anchor_b, b)
    give: float = a.inv_mass + b.inv_mass + arms / 3.0
    return give


@njit
def _arm_give(anchor: Any, body: Any) -> float:
    """Return the trace of [r] I^-1 [r]^T of the arm r of an anchor, 1/kg."""
    r = turned(conjugate(quaternion(body.axes)), sub(vec(anchor), vec(body.center)))
    give = 0.0
    for k in range(3):
        give += body.inv_inertia[k] * (dot(r, r) - r[k] * r[k])
    return give


@njit
def turn_give(a: Any, b: Any) -> float:
    """Return the inverse inertia in 1/(kg m^2) of the rotation of a body in another, the mean over all axes."""
    total = 0.0
    for k in range(3):
        total += a.inv_inertia[k] + b.inv_inertia[k]
    return total / 3.0


@njit
def _turning(parameters: Any, u: Vec) -> float:
    """u I^-1 u of a vector in the body's own frame, 1/(kg m^2)."""
    own = turned(conjugate(quaternion(parameters.axes)), u)
    return dot(vec(parameters.inv_inertia), (own[0] * own[0], own[1] * own[1], own[2] * own[2]))
