"""Limits, motors and springs of the joints of trees: rows on one degree of freedom."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import LinkKind
from ..dispatch import by_dimension
from ..joint_rows import (
    has_armature,
    has_friction,
    has_limit,
    has_motor,
    set_friction_row,
    set_limit_row,
    set_motor_row,
    set_spring_row,
    speeds_within,
)
from ..joints import Joint, start_impulse
from ..springs import has_spring

coordinate_of = by_dimension("articulation", "coordinate_of")
set_servo_direction = by_dimension("articulation", "set_servo_direction")

_TURN = int(LinkKind.TURN)
_INFINITY = float("inf")
# slots of the impulses after those of locked axes, which are as many as the degrees of freedom
LIMIT, MOTOR, SPRING, FRICTION = 0, 1, 2, 3


@njit
def count_servo_rows(world: Any, island: Any, articulation: Any) -> Any:
    """Return the number of rows of limits, motors and bounded springs; also whether joints have any forces at all."""
    links = articulation.links
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    count = 0
    island.servos = 0
    for k in range(island.body_count):
        if links[k].kind >= _TURN:
            parameters = joint_parameters[links[k].joint]
            sprung = has_spring(parameters)
            driven = has_motor(parameters)
            given = joint_models[links[k].joint].effort_controlled != 0
            count += int(has_limit(parameters)) + int(driven and not given) + int(has_friction(parameters))
            count += int(sprung and parameters.spring_effort < _INFINITY)
            if sprung or driven or has_armature(parameters):
                island.servos = 1
    if count > 0:
        island.servos = 1
    return count


@njit
def keep_coordinates(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Keep the coordinates of turns and slides at the start of the substep."""
    links = articulation.links
    joint_parameters = world.parameters.joints
    joint_models = world.model.joints
    bodies = world.state.bodies
    for k in range(island.body_count):
        link = links[k]
        if link.kind >= _TURN:
            j = link.joint
            joint = Joint(joint_models[j], joint_parameters[j], joints[j])
            link.begin = coordinate_of(link, bodies[joint.model.body_a], bodies[joint.model.body_b], joint)


@njit
def add_servo_rows(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Write the rows of limits, motors and bounded springs; other springs and given efforts go into the factor."""
    links = articulation.links
    row = island.other_rows
    for k in range(island.body_count):
        if links[k].kind >= _TURN:
            row = _add_rows(world, island, articulation, joints, k, row)


@njit
def _add_rows(world: Any, island: Any, articulation: Any, joints: Any, k: Any, row: Any) -> Any:
    """Write the rows of link k from ``rows[row]`` on; returns the place after them."""
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    link = articulation.links[k]
    j = link.joint
    joint = Joint(world.model.joints[j], world.parameters.joints[j], joints[j])
    parameters = joint.parameters
    h = island.h
    slot = slots(joint.state)
    freedom = articulation.freedoms[link.first]
    freedom.pull = 0.0
    if has_spring(parameters):
        bounded = parameters.spring_effort < _INFINITY
        made = rows[row if bounded else island.rows]  # a spring without bound needs a row only here
        _start_row(world, made, articulation.links, k)
        set_spring_row(made, slot + SPRING, link.begin - joint.state.rest, 0.0, parameters, substep_bodies, h)
        if bounded:
            made.impulse = start_impulse(made, joint.state, island.warm_start)
            row += 1
        elif made.softness > 0.0:
            freedom.stiffness = 1.0 / made.softness
            freedom.pull = -made.bias / made.softness
    if joint.model.effort_controlled:
        freedom.pull += given_impulse(joint, h)
    elif has_motor(parameters):
        made = rows[row]
        _start_row(world, made, articulation.links, k)
        speeds = speeds_within(link.begin, 0.0, parameters, h)
        set_motor_row(made, slot + MOTOR, joint, speeds, 0.0, substep_bodies, h)
        made.impulse = start_impulse(made, joint.state, island.warm_start)
        row += 1
    if has_friction(parameters):
        made = rows[row]
        _start_row(world, made, articulation.links, k)
        set_friction_row(made, slot + FRICTION, parameters, 0.0, substep_bodies, h)
        made.impulse = start_impulse(made, joint.state, island.warm_start)
        row += 1
    if has_limit(parameters):
        made = rows[row]
        _start_row(world, made, articulation.links, k)
        set_limit_row(made, slot + LIMIT, link.begin, 0.0, parameters, substep_bodies, h)
        made.impulse = start_impulse(made, joint.state, island.warm_start)
        row += 1
    return row


@njit
def given_impulse(joint: Any, h: Any) -> Any:
    """Return the impulse in N s or N m s of a motor with a given effort, 0 for other motors."""
    if not joint.model.effort_controlled:
        return 0.0
    effort = joint.parameters.motor_effort
    return h * min(max(joint.state.effort, -effort), effort)


@njit
def slots(state: Any) -> Any:
    """Return the first slot after those of locked axes: 2 in 2D, 6 in 3D."""
    return len(state.reaction) if len(state.reaction) > 3 else 2


@njit
def _start_row(world: Any, row: Any, links: Any, k: Any) -> None:
    model = world.model.joints[links[k].joint]
    row.body_a = model.body_a
    row.body_b = model.body_b
    row.source = links[k].joint
    bodies = world.state.bodies
    set_servo_direction(row, links, k, bodies, world.parameters.bodies, world.scratch.substep_bodies)


@njit
def store_servo_impulses(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Store the impulses of limits, motors, springs and rotors for the next substep, and add them to the step's."""
    rows = world.scratch.rows
    links = articulation.links
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    for r in range(island.other_rows, island.joint_rows):
        row = rows[r]
        state = joints[row.source]
        slot = -1 - row.slot if row.slot < 0 else row.slot
        impulse = -row.impulse if row.slot < 0 else row.impulse
        _store(state, slot, impulse, island.stored_scale)
    for k in range(island.body_count):
        if links[k].kind >= _TURN:
            j = links[k].joint
            _store_forces(island, articulation, links[k].first, Joint(joint_models[j], joint_parameters[j], joints[j]))


@njit
def _store_forces(island: Any, articulation: Any, f: Any, joint: Any) -> None:
    """Store the impulses on a degree of freedom that have no rows."""
    freedom = articulation.freedoms[f]
    state = joint.state
    rate = articulation.rate[f]
    given = given_impulse(joint, island.h)
    if given != 0.0:
        _store(state, slots(state) + MOTOR, given, island.stored_scale)
    if freedom.stiffness > 0.0:
        _store(state, slots(state) + SPRING, freedom.pull - given - freedom.stiffness * rate, island.stored_scale)
    if freedom.armature > 0.0:
        impulse = freedom.armature * (articulation.start[f] - rate)
        _store(state, len(state.impulse) - 1, impulse, island.stored_scale)
        state.rate = rate


@njit
def _store(state: Any, slot: Any, impulse: Any, scale: Any) -> None:
    state.impulse[slot] = scale * impulse
    state.total_impulse[slot] += impulse
