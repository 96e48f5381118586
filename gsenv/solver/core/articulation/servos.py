"""Limits, motors and springs of the joints of trees: rows on one degree of freedom."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import LinkKind
from ..dispatch import by_dimension
from ..joint_rows import has_limit, has_motor, set_limit_row, set_motor_row, set_spring_row, speeds_within
from ..joints import Joint, start_impulse
from ..springs import has_spring

coordinate_of = by_dimension("articulation", "coordinate_of")
set_servo_direction = by_dimension("articulation", "set_servo_direction")

_TURN = int(LinkKind.TURN)
_INFINITY = float("inf")
LIMIT, MOTOR, SPRING = 2, 3, 4  # slots of their impulses


@njit
def count_servo_rows(world: Any, island: Any, articulation: Any) -> Any:
    """Return the number of rows of limits, motors and bounded springs; also whether there are springs at all."""
    links = articulation.links
    joint_parameters = world.parameters.joints
    count = 0
    island.servos = 0
    for k in range(island.body_count):
        if links[k].kind >= _TURN:
            parameters = joint_parameters[links[k].joint]
            sprung = has_spring(parameters)
            count += int(has_limit(parameters)) + int(has_motor(parameters))
            count += int(sprung and parameters.spring_effort < _INFINITY)
            if sprung:
                island.servos = 1
    if count > 0:
        island.servos = 1
    return count


@njit
def keep_coordinates(world: Any, island: Any, articulation: Any) -> None:
    """Keep the coordinates of turns and slides at the start of the substep."""
    links = articulation.links
    joint_parameters = world.parameters.joints
    joint_models = world.model.joints
    bodies = world.state.bodies
    for k in range(island.body_count):
        link = links[k]
        if link.kind >= _TURN:
            model = joint_models[link.joint]
            parameters = joint_parameters[link.joint]
            link.begin = coordinate_of(link, bodies[model.body_a], bodies[model.body_b], parameters)


@njit
def add_servo_rows(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Write the rows of limits, motors and bounded springs; other springs go into the factor."""
    links = articulation.links
    row = 0
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
    if has_spring(parameters):
        made = rows[row]
        _start_row(made, link, joint)
        set_spring_row(made, SPRING, link.begin - joint.state.rest, parameters, substep_bodies, h)
        if parameters.spring_effort < _INFINITY:
            made.impulse = start_impulse(made, joint.state, island.warm_start)
            row += 1
        elif made.softness > 0.0:
            freedom = articulation.freedoms[link.first]
            freedom.stiffness = 1.0 / made.softness
            freedom.pull = -made.bias / made.softness
    if has_motor(parameters):
        made = rows[row]
        _start_row(made, link, joint)
        set_motor_row(made, MOTOR, joint, speeds_within(link.begin, 0.0, parameters, h), substep_bodies, h)
        made.impulse = start_impulse(made, joint.state, island.warm_start)
        row += 1
    if has_limit(parameters):
        made = rows[row]
        _start_row(made, link, joint)
        set_limit_row(made, LIMIT, link.begin, 0.0, parameters, substep_bodies, h)
        made.impulse = start_impulse(made, joint.state, island.warm_start)
        row += 1
    return row


@njit
def _start_row(row: Any, link: Any, joint: Any) -> None:
    row.body_a = joint.model.body_a
    row.body_b = joint.model.body_b
    row.source = link.joint
    set_servo_direction(row, link)


@njit
def store_servo_impulses(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Store the impulses of limits, motors and springs for the next substep, and add them to those of the step."""
    rows = world.scratch.rows
    links = articulation.links
    freedoms = articulation.freedoms
    rate = articulation.rate
    scale = island.stored_scale
    for r in range(island.joint_rows):
        row = rows[r]
        state = joints[row.source]
        slot = -1 - row.slot if row.slot < 0 else row.slot
        impulse = -row.impulse if row.slot < 0 else row.impulse
        state.impulse[slot] = scale * impulse
        state.total_impulse[slot] += impulse
    for k in range(island.body_count):
        if links[k].kind >= _TURN:
            freedom = freedoms[links[k].first]
            if freedom.stiffness > 0.0:
                impulse = freedom.pull - freedom.stiffness * rate[links[k].first]
                joints[links[k].joint].impulse[SPRING] = scale * impulse
                joints[links[k].joint].total_impulse[SPRING] += impulse
