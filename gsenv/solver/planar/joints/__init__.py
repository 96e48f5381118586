"""The rows of 2D joints: one file for each kind, and one branch here."""

from __future__ import annotations

from typing import Any

from ...core.coupled import add_coupled_rows, is_coupled
from ...core.distance_joint import add_distance_rows
from ...core.joints import OFF_CENTER, Joint
from ...jit import njit
from ...records.model import JointKind
from ..math import cross
from .gear import add_gear_rows
from .point import arm, turned
from .prismatic import add_prismatic_rows
from .revolute import add_revolute_rows
from .wheel import add_wheel_rows

_REVOLUTE = int(JointKind.REVOLUTE)
_PRISMATIC = int(JointKind.PRISMATIC)
_DISTANCE = int(JointKind.DISTANCE)
_WHEEL = int(JointKind.WHEEL)


@njit
def add_linked_rows(
    world: Any, rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a joint of the kinds from revolute on."""
    kind = joint.model.kind
    if kind == _REVOLUTE:
        add_revolute_rows(rows, row, joint, bodies, body_parameters, substep_bodies, h)
    elif kind == _PRISMATIC:
        add_prismatic_rows(rows, row, joint, bodies, body_parameters, substep_bodies, h)
    elif kind == _DISTANCE:
        add_distance_rows(rows, row, joint.parameters, bodies, body_parameters, substep_bodies, h)
    elif kind == _WHEEL:
        add_wheel_rows(rows, row, joint, bodies, body_parameters, substep_bodies, h)
    else:
        models = world.model.joints
        parameters = world.parameters.joints
        a = joint.model.joint_a
        b = joint.model.joint_b
        first = Joint(models[a], parameters[a], joint.state)
        second = Joint(models[b], parameters[b], joint.state)
        if is_coupled(joint):
            add_coupled_rows(world, row, joint, first, second, h)
        else:
            add_gear_rows(rows[row], joint, first, second, bodies, body_parameters, substep_bodies, h)


@njit
def add_reaction(
    row: Any, parameters: Any, body: Any, body_parameters: Any, substep_body: Any, state: Any, ahead: Any
) -> None:
    """Add force and torque of a row on body b at its anchor; ``ahead``: s, time of the row's pose in the substep."""
    j = row.jacobian_b
    bx, by = arm(body, body_parameters, parameters.anchor_b)
    back = substep_body.correction[2] - ahead * substep_body.start_velocity[2]  # rotation of the body since that pose
    bx, by = turned(bx, by, -back)
    state.reaction[0] += row.impulse * j[0]
    state.reaction[1] += row.impulse * j[1]
    state.reaction[2] += row.impulse * (j[2] - cross(bx, by, j[0], j[1]))


@njit
def tension_of(state: Any) -> Any:
    """Return the norm of the reaction of the last step, N s."""
    reaction = state.reaction
    return (reaction[0] * reaction[0] + reaction[1] * reaction[1]) ** 0.5


@njit
def arm_over_inertia(masses: Any, anchor: Any) -> Any:
    """Return r / I in 1/(kg m) of a body that swings about an anchor at r."""
    return _reach(masses, anchor) * masses.inv_inertia


@njit
def swing_of_side(body: Any, masses: Any, anchor: Any) -> Any:
    """Return (r / I, speed, 0) of a body that swings about an anchor at r: 1/(kg m), rad/s of its arm, no nutation."""
    speed = abs(body.velocity[2]) if _reach(masses, anchor) > OFF_CENTER * masses.radius else 0.0
    return arm_over_inertia(masses, anchor), speed, 0.0


@njit
def _reach(masses: Any, anchor: Any) -> Any:
    x = anchor[0] - masses.center[0]
    y = anchor[1] - masses.center[1]
    return (x * x + y * y) ** 0.5
