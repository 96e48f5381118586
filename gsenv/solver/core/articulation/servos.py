"""Limits, motors, springs, friction and rotors of the joints of trees, on one degree of freedom each.

Springs without bound, given efforts and rotors on a degree of freedom of its own go into the factor, as do springs of
balls that are equal about all axes; all else is rows.
"""

from __future__ import annotations

from typing import Any

from numba import int64

from ...jit import njit
from ...records.articulation import LinkKind
from ...records.model import JointKind
from ..dispatch import by_dimension
from ..joint_rows import (
    has_armature,
    has_friction,
    has_limit,
    has_motor,
    set_armature_row,
    set_friction_row,
    set_limit_row,
    set_motor_row,
    set_spring_row,
    soften_limit,
    speeds_within,
)
from ..joints import Joint, start_impulse
from ..rows import IDLE, LIMIT_SLOP, NO_CORRECTION, UNILATERAL
from ..slices import part
from ..springs import has_spring, is_slow, mean_reach
from .equations import dot_with
from .other_joints import main_joint


@njit
def _no_inverses(row: Any, links: Any, k: Any, bodies: Any, body_parameters: Any, substep_bodies: Any) -> None:
    """Do nothing: 2D moments of inertia have no direction."""


numbers_of = by_dimension("articulation", "numbers_of")
coordinate_of = by_dimension("articulation", "coordinate_of")
set_servo_direction = by_dimension("articulation", "set_servo_direction")
set_servo_inverses = by_dimension("articulation", "set_servo_inverses", otherwise=_no_inverses)
set_pivot_direction = by_dimension("articulation", "set_pivot_direction")
reference_give = by_dimension("joints.reference", "reference_give")
is_isotropic = by_dimension("articulation", "is_isotropic")
add_ball_spring = by_dimension("articulation", "add_ball_spring")

_AXES = int(LinkKind.AXES)
_WHEEL = int(JointKind.WHEEL)
_INFINITY = float("inf")
# slots of the impulses after those of locked axes
LIMIT, MOTOR, SPRING, FRICTION = 0, 1, 2, 3


@njit
def list_servos(world: Any, island: Any, articulation: Any, joints: Any) -> Any:
    """List the coordinates of the joints of the island, and set the rotors; returns the number of their rows."""
    trees = world.model.trees
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    links = articulation.links
    servos = articulation.servos
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    island.coordinates = 0
    island.servos = 0
    for f in range(island.freedoms):
        articulation.freedoms[f].armature = 0.0
    rows = 0
    for n in range(len(island_joints)):
        j = island_joints[n]
        main = main_joint(joint_models, j)
        model = joint_models[main]
        k = articulation.places[model.body_a if trees[model.body_a].joint == main else model.body_b]
        if links[k].joint != main:
            continue
        number, turning = numbers_of(joint_models[j], joint_parameters[j])
        if number < 0:
            continue
        servo = servos[island.coordinates]
        island.coordinates += 1
        servo.joint = j
        servo.link = k
        servo.number = number
        servo.turning = turning
        servo.place = _place_of(links[k], number)
        servo.driven = _place_of(links[k], turning)
        joint = Joint(joint_models[j], joint_parameters[j], joints[j])
        servo.limited = int(has_limit(joint.parameters))
        servo.isotropic = int(servo.place < 0 and is_isotropic(joint_models, joint_parameters, j))
        rows += _count_rows(servo, joint.model, joint.parameters)
        if _acts(joint_parameters[j]):
            island.servos = 1
        if servo.driven >= 0:
            articulation.freedoms[links[k].first + servo.driven].armature += joint_parameters[j].armature
    return rows


@njit
def _place_of(link: Any, number: Any) -> Any:
    """Return which degree of freedom of a link a coordinate is, -1 if it is none of them."""
    if link.kind == _AXES:
        for i in range(link.count):
            if link.numbers[i] == number:
                return i
    return -1


@njit
def _acts(parameters: Any) -> Any:
    """Whether a joint has a spring, a motor, a limit, friction or a rotor."""
    if has_spring(parameters) or has_motor(parameters) or has_limit(parameters):
        return True
    return has_friction(parameters) or has_armature(parameters)


@njit
def _count_rows(servo: Any, model: Any, parameters: Any) -> Any:
    given = model.effort_controlled != 0 and servo.driven >= 0
    count = servo.limited + int(has_friction(parameters)) + int(has_motor(parameters) and not given)
    count += int(has_armature(parameters) and servo.driven < 0)
    return count + int(has_spring(parameters) and not _in_factor(servo, parameters))


@njit
def _in_factor(servo: Any, parameters: Any) -> Any:
    """Whether a spring is part of the factor instead of a row."""
    return servo.isotropic != 0 or (servo.place >= 0 and parameters.spring_effort == _INFINITY)


@njit
def keep_coordinates(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Keep the coordinates of the joints at the start of the substep; no plain limit without impulse is reached yet."""
    links = articulation.links
    servos = articulation.servos
    joint_parameters = world.parameters.joints
    joint_models = world.model.joints
    bodies = world.state.bodies
    for s in range(island.coordinates):
        servo = servos[s]
        j = servo.joint
        joint = Joint(joint_models[j], joint_parameters[j], joints[j])
        servo.begin = coordinate_of(links[servo.link], servo, bodies, joint)
        servo.side = 0
        servo.turned = 0
        servo.reached = int(servo.limited != 0 and not _may_wait(servo, joint))


@njit
def _may_wait(servo: Any, joint: Any) -> Any:
    """Whether a limit needs no row until rates come to it: it is rigid, and had no impulse in the last substep."""
    parameters = joint.parameters
    if servo.place < 0 or parameters.limit_frequency > 0.0 or parameters.limit_restitution > 0.0:
        return False
    return parameters.lower < parameters.upper and joint.state.impulse[slot_of(joint, LIMIT)] == 0.0


@njit
def reach_limits(world: Any, island: Any, articulation: Any, rates: Any) -> Any:
    """Mark the limits that coordinates come to within the substep at these rates; returns whether one is new.

    A row that takes no impulse changes nothing, so the solution without the rows of limits that it does not come to
    is the solution with them.
    """
    links = articulation.links
    servos = articulation.servos
    joint_parameters = world.parameters.joints
    new = False
    for s in range(island.coordinates):
        servo = servos[s]
        if servo.limited == 0 or servo.reached != 0:
            continue
        parameters = joint_parameters[servo.joint]
        end = servo.begin + island.h * rates[links[servo.link].first + servo.place]
        below = min(servo.begin, end) - parameters.lower
        above = parameters.upper - max(servo.begin, end)
        if not min(below, above) > LIMIT_SLOP:
            servo.reached = 1
            servo.side = 1 if above < below else -1
            new = True
    return new


@njit
def turn_limits(world: Any, island: Any, articulation: Any) -> Any:
    """Let the row of a limit be that of the other one where the solution passes that; returns whether any was.

    A narrow range, or a strong motor: the limit that is nearer at the start need not be the one that is reached.
    """
    rows = world.scratch.rows
    spans = articulation.spans
    servos = articulation.servos
    joint_parameters = world.parameters.joints
    turned = False
    for s in range(island.coordinates):
        servo = servos[s]
        if servo.limited == 0 or servo.reached == 0 or servo.turned != 0:
            continue
        row = rows[servo.row]
        span = spans[servo.row]
        if row.correction != UNILATERAL or row.impulse > 0.0:
            continue
        rate = span.free - row.bias + dot_with(span, articulation.ways, articulation.values, articulation.whitened)
        gap = row.error + island.h * (rate + servo.curve)
        parameters = joint_parameters[servo.joint]
        if gap - (parameters.upper - parameters.lower) > LIMIT_SLOP:
            servo.side = 1 if row.slot >= 0 else -1
            servo.turned = 1
            turned = True
    return turned


@njit
def any_row_acts(island: Any, articulation: Any) -> Any:
    """Whether the island has rows other than those of limits out of reach."""
    idle = 0
    for s in range(island.coordinates):
        idle += int(articulation.servos[s].limited != articulation.servos[s].reached)
    return island.rows > idle


@njit
def add_joint_forces(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Add springs without bound and given efforts to the degrees of freedom, before these are factorised."""
    joint_parameters = world.parameters.joints
    joint_models = world.model.joints
    servos = articulation.servos
    freedoms = articulation.freedoms
    for f in range(island.freedoms):
        freedoms[f].stiffness = 0.0
        freedoms[f].pull = 0.0
    for s in range(island.coordinates):
        servo = servos[s]
        j = servo.joint
        joint = Joint(joint_models[j], joint_parameters[j], joints[j])
        first = articulation.links[servo.link].first
        servo.stiffness = 0.0
        servo.pull = 0.0
        if servo.isotropic != 0:
            add_ball_spring(world, articulation, servo, joint, island.h)
        elif has_spring(joint.parameters) and _in_factor(servo, joint.parameters):
            if not _set_slow_spring(servo, joint, articulation.start[first + servo.place], island.h):
                _set_any_spring(world, island, articulation, servo, joint)
            freedoms[first + servo.place].stiffness += servo.stiffness
            freedoms[first + servo.place].pull += servo.pull
        if servo.driven >= 0:
            freedoms[first + servo.driven].pull += given_impulse(joint, island.h)


@njit
def _set_slow_spring(servo: Any, joint: Any, rate: Any, h: Any) -> Any:
    """Set impulse and stiffness of a spring beside a rotor that alone makes it slow, as its row would; else False.

    ``rate``: that of the coordinate at the start of the substep.
    """
    p = joint.parameters
    if not (p.stiffness > 0.0 or p.damping > 0.0) or not p.armature > 0.0:
        return False
    if not is_slow(p.stiffness, p.damping, 1.0 / p.armature, h):
        return False
    servo.stiffness = h * mean_reach(p.stiffness, p.damping, h)
    servo.pull = -h * p.stiffness * (servo.begin - joint.state.rest) - servo.stiffness * rate
    return True


@njit
def _set_any_spring(world: Any, island: Any, articulation: Any, servo: Any, joint: Any) -> None:
    """Set impulse and stiffness of a spring from its row, which is needed only here."""
    made = world.scratch.rows[island.rows]
    _set_spring(world, made, articulation, servo, joint, island.h)
    if made.softness > 0.0:
        servo.stiffness = 1.0 / made.softness
        servo.pull = -made.bias / made.softness


@njit
def _set_spring(world: Any, row: Any, articulation: Any, servo: Any, joint: Any, h: Any) -> None:
    curve = _start_row(world, row, articulation, servo, servo.place, servo.number, True, h)
    slot = slot_of(joint, SPRING)
    error = servo.begin - joint.state.rest
    give = _give_of(world, joint)
    set_spring_row(row, slot, error, curve, joint.parameters, give, world.scratch.substep_bodies, h)


@njit
def add_servo_rows(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Write the rows of limits, motors, friction and bounded springs, and all of balls, when free rates are known."""
    joint_parameters = world.parameters.joints
    joint_models = world.model.joints
    rows = world.scratch.rows
    servos = articulation.servos
    row = int64(island.other_rows)
    for s in range(island.coordinates):
        servo = servos[s]
        j = servo.joint
        joint = Joint(joint_models[j], joint_parameters[j], joints[j])
        end = _add_driven_rows(world, island, articulation, servo, joint, row)
        end = _add_coordinate_rows(world, island, articulation, servo, joint, end)
        for r in range(row, end):
            rows[r].impulse = start_impulse(rows[r], joint.state, island.warm_start)
        row = end


@njit
def _add_driven_rows(world: Any, island: Any, articulation: Any, servo: Any, joint: Any, row: Any) -> Any:
    """Write the rows of motor and friction, of a ball also that of the rotor; returns the place after them."""
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    parameters = joint.parameters
    h = island.h
    if has_armature(parameters) and servo.driven < 0:
        curve = _start_row(world, rows[row], articulation, servo, servo.driven, servo.turning, True, h)
        set_armature_row(rows[row], len(joint.state.impulse) - 1, joint, curve, substep_bodies)
        row += 1
    if has_motor(parameters) and not (joint.model.effort_controlled and servo.driven >= 0):
        curve = _start_row(world, rows[row], articulation, servo, servo.driven, servo.turning, True, h)
        limited = servo.turning == servo.number
        speeds = speeds_within(servo.begin, 0.0, parameters, h) if limited else (-_INFINITY, _INFINITY)
        set_motor_row(rows[row], slot_of(joint, MOTOR), joint, speeds, curve, substep_bodies, h)
        row += 1
    if has_friction(parameters):
        curve = _start_row(world, rows[row], articulation, servo, servo.driven, servo.turning, False, h)
        set_friction_row(rows[row], slot_of(joint, FRICTION), parameters, curve, substep_bodies, h)
        row += 1
    return row


@njit
def _add_coordinate_rows(world: Any, island: Any, articulation: Any, servo: Any, joint: Any, row: Any) -> Any:
    """Write the rows of spring and limit; returns the place after them."""
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    parameters = joint.parameters
    h = island.h
    if has_spring(parameters) and not _in_factor(servo, parameters):
        _set_spring(world, rows[row], articulation, servo, joint, h)
        row += 1
    if servo.limited != servo.reached:
        _set_idle(rows[row], slot_of(joint, LIMIT), servo)
        row += 1
    elif servo.limited != 0:
        weighed = parameters.limit_frequency > 0.0
        curve = _start_row(world, rows[row], articulation, servo, servo.place, servo.number, weighed, h)
        set_limit_row(rows[row], slot_of(joint, LIMIT), servo.begin, curve, parameters, substep_bodies, h, servo.side)
        if weighed:
            soften_limit(rows[row], parameters, _give_of(world, joint), substep_bodies, h)
        servo.row = row
        servo.curve = curve if rows[row].slot >= 0 else -curve
        row += 1
    return row


@njit
def _give_of(world: Any, joint: Any) -> Any:
    """Return the inverse mass on which frequencies of springs are given; 0: that of the row."""
    body_parameters = world.parameters.bodies
    return reference_give(joint, body_parameters[joint.model.body_a], body_parameters[joint.model.body_b])


@njit
def _set_idle(row: Any, slot: Any, servo: Any) -> None:
    """Make a row one that takes no impulse."""
    row.kind = IDLE
    row.correction = NO_CORRECTION
    row.source = servo.joint
    row.slot = slot
    row.lower = 0.0
    row.upper = 0.0
    row.bias = 0.0
    row.softness = 0.0
    row.error = 0.0


@njit
def given_impulse(joint: Any, h: Any) -> Any:
    """Return the impulse in N s or N m s of a motor with a given effort, 0 for other motors."""
    if not joint.model.effort_controlled:
        return 0.0
    effort = joint.parameters.motor_effort
    return h * min(max(joint.state.effort, -effort), effort)


@njit
def slot_of(joint: Any, part_number: Any) -> Any:
    """Return the slot of the impulse of a limit, motor, spring or friction."""
    if len(joint.state.reaction) > 3:
        return 6 + part_number
    if joint.model.kind == _WHEEL:
        return 1 if part_number == SPRING else 4 if part_number == FRICTION else 2 + part_number
    return 2 + part_number


@njit
def _start_row(
    world: Any, row: Any, articulation: Any, servo: Any, place: Any, number: Any, weighed: Any, h: Any
) -> Any:
    """Set bodies and Jacobian of a row on a coordinate; returns the change of J v by the end of the substep.

    ``weighed``: whether its spring or its gain refers to its effective mass in body space.
    """
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    links = articulation.links
    j = servo.joint
    row.body_a = joint_models[j].body_a
    row.body_b = joint_models[j].body_b
    row.source = j
    if place >= 0:
        set_servo_direction(row, links[servo.link], place)
        if weighed:
            bodies = world.state.bodies
            substep_bodies = world.scratch.substep_bodies
            set_servo_inverses(row, links, servo.link, bodies, world.parameters.bodies, substep_bodies)
        return 0.0
    joint = Joint(joint_models[j], joint_parameters[j], world.state.joints[j])
    return set_pivot_direction(world, row, links, servo.link, joint, number, h)


@njit
def store_servo_impulses(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Store the impulses of limits, motors, springs and rotors for the next substep, and add them to the step's."""
    rows = world.scratch.rows
    servos = articulation.servos
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    for r in range(island.other_rows, island.joint_rows):
        row = rows[r]
        state = joints[row.source]
        slot = -1 - row.slot if row.slot < 0 else row.slot
        impulse = -row.impulse if row.slot < 0 else row.impulse
        _store(state, slot, impulse, island.stored_scale)
        if slot == len(state.impulse) - 1:
            state.rate -= row.softness * row.impulse
    for s in range(island.coordinates):
        j = servos[s].joint
        _store_forces(island, articulation, servos[s], Joint(joint_models[j], joint_parameters[j], joints[j]))


@njit
def _store_forces(island: Any, articulation: Any, servo: Any, joint: Any) -> None:
    """Store the impulses on a degree of freedom that have no rows."""
    state = joint.state
    if servo.stiffness > 0.0:
        impulse = servo.pull - servo.stiffness * _rate_of(articulation, servo)
        _store(state, slot_of(joint, SPRING), impulse, island.stored_scale)
    if servo.driven < 0:
        return
    given = given_impulse(joint, island.h)
    if given != 0.0:
        _store(state, slot_of(joint, MOTOR), given, island.stored_scale)
    if has_armature(joint.parameters):
        f = articulation.links[servo.link].first + servo.driven
        rate = articulation.rate[f]
        impulse = joint.parameters.armature * (articulation.start[f] - rate)
        _store(state, len(state.impulse) - 1, impulse, island.stored_scale)
        state.rate = rate


@njit
def _rate_of(articulation: Any, servo: Any) -> Any:
    """Return the rate of a coordinate whose spring is in the factor."""
    first = articulation.links[servo.link].first
    if servo.place >= 0:
        return articulation.rate[first + servo.place]
    rate = 0.0
    for d in range(3):
        rate += servo.direction[d] * articulation.rate[first + d]
    return rate


@njit
def _store(state: Any, slot: Any, impulse: Any, scale: Any) -> None:
    state.impulse[slot] = scale * impulse
    state.total_impulse[slot] += impulse
