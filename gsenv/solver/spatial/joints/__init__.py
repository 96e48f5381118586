"""The rows of 3D joints: one file for each kind, and one branch here."""

from __future__ import annotations

from typing import Any

from ...core.coupled import add_coupled_rows, is_coupled
from ...core.distance_joint import add_distance_rows
from ...core.joints import OFF_CENTER, Joint
from ...jit import njit
from ...records.model import JointKind
from ..math import Vec, along, conjugate, cross, multiply, norm, quaternion, scaled, sub, turn_of, turned, vec
from ..rotation import in_world, spin_of
from .axis_joints import add_axis_rows
from .ball import add_ball_rows
from .gear import add_gear_rows
from .point import arm, bend_across

_BALL = int(JointKind.BALL)
_DISTANCE = int(JointKind.DISTANCE)
_GEAR = int(JointKind.GEAR)


@njit
def add_linked_rows(
    world: Any, rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a ball or distance joint, of a joint with axes or of a gear."""
    if joint.model.kind == _BALL:
        add_ball_rows(rows, row, joint.parameters, bodies, body_parameters, substep_bodies, h)
    elif joint.model.kind == _DISTANCE:
        add_distance_rows(rows, row, joint.parameters, bodies, body_parameters, substep_bodies, h)
    else:
        _add_further_rows(world, row, joint, h, world.variant.axes)


@njit
def _add_further_rows(world: Any, row: Any, joint: Any, h: Any, axes: Any) -> None:
    """Write the rows of joints with axes and of gears; ``axes`` is None in a scene without them."""
    if axes is None:
        return
    rows = world.scratch.rows
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    if joint.model.kind != _GEAR:
        add_axis_rows(rows, row, joint, bodies, body_parameters, substep_bodies, h)
        return
    models = world.model.joints
    parameters = world.parameters.joints
    states = world.state.joints
    a = joint.model.joint_a
    b = joint.model.joint_b
    first = Joint(models[a], parameters[a], states[a])
    second = Joint(models[b], parameters[b], states[b])
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
    back = in_world(substep_body, spin_of(substep_body.correction))  # rotation of the body since that pose
    if ahead > 0.0:
        back = along(back, -ahead, in_world(substep_body, spin_of(substep_body.start_velocity)))
    to_anchor = turned(turn_of(scaled(back, -1.0)), arm(body, body_parameters, parameters.anchor_b))
    force = scaled(vec(j), row.impulse)
    torque = sub(scaled(in_world(substep_body, spin_of(j)), row.impulse), cross(to_anchor, force))
    for d in range(3):
        state.reaction[d] += force[d]
        state.reaction[3 + d] += torque[d]


@njit
def tension_of(state: Any) -> Any:
    """Return the norm in N s of the reaction force of the last step."""
    return norm(vec(state.reaction))


@njit
def arm_over_inertia(masses: Any, anchor: Any) -> Any:
    """Return r / I in 1/(kg m) of a body that swings about an anchor at r."""
    reach = _reach(masses, anchor)
    length = norm(reach)
    return length * _swing_inverse(masses, reach, length)


@njit
def swing_of_side(body: Any, masses: Any, anchor: Any) -> Any:
    """Return (r / I, speed, nutation) of a body that swings about an anchor at r: 1/(kg m), and ``_swing_speeds``."""
    length = norm(_reach(masses, anchor))
    speed = 0.0
    nutation = 0.0
    if length > OFF_CENTER * masses.radius:
        speed, nutation = _swing_speeds(body, masses, arm(body, masses, anchor), length)
    return arm_over_inertia(masses, anchor), speed, nutation


@njit
def _reach(masses: Any, anchor: Any) -> Vec:
    """Return an anchor relative to the centre of mass, in principal axes."""
    return turned(conjugate(quaternion(masses.axes)), sub(vec(anchor), vec(masses.center)))


@njit
def _swing_inverse(masses: Any, reach: Vec, length: Any) -> Any:
    """Return the inverse inertia for rotation across an arm, 1/(kg m^2): the mean of the two directions."""
    inverse = masses.inv_inertia
    trace = inverse[0] + inverse[1] + inverse[2]
    if length <= 0.0:
        return trace / 3.0
    about = inverse[0] * reach[0] ** 2 + inverse[1] * reach[1] ** 2 + inverse[2] * reach[2] ** 2
    return 0.5 * (trace - about / (length * length))


@njit
def _swing_speeds(body: Any, masses: Any, to_anchor: Vec, length: Any) -> Any:
    """Return in rad/s the speed at which the arm changes direction, without rotation about it, and the speed at which
    the body's own inertia rotates that velocity."""
    w = spin_of(body.velocity)
    speed = norm(cross(w, to_anchor))
    axes = multiply(quaternion(body.rotation), quaternion(masses.axes))
    own = turned(conjugate(axes), w)
    i = masses.inertia
    if speed <= 0.0 or i[0] <= 0.0 or i[1] <= 0.0 or i[2] <= 0.0:
        return speed / length, 0.0
    turning = cross((i[0] * own[0], i[1] * own[1], i[2] * own[2]), own)
    change = turned(axes, (turning[0] / i[0], turning[1] / i[1], turning[2] / i[2]))
    return speed / length, norm(bend_across(w, change, to_anchor)) / speed
