"""GCar's jitted passes: start, act, judge, observe. The rules are in the docstring of car.CarEnv."""

from __future__ import annotations

import math
from typing import Any

from gsenv.envs import car_scene as scene
from gsenv.envs.car_course import DRAW_COUNT as DRAW_COUNT
from gsenv.envs.car_course import build_course, height_at
from gsenv.solver.jit import njit

RECORD_FIELDS: list[tuple[Any, ...]] = [
    ("kinds", "i8", (scene.SLOTS,)),  # obstacle of each slot, -1: none
    ("place", "f8"),  # m, of the chassis at the last step
    ("best", "f8"),  # m, the farthest it came
    ("action", "f8", (2,)),
    ("change", "f8"),  # mean square change of the last action
    ("power", "f8"),  # W, of the motors at the end of the last step
    ("roof", "i8"),  # control steps on the roof
    ("gaze", "f8", (2,)),  # m, where the camera looks
]

CONTROL_TIME = 1.0 / 30.0  # s
ROOF_STEPS = 30
HEIGHTS = 16
FIRST_HEIGHT = 0.6  # m ahead of the chassis' middle
HEIGHT_SPACING = 0.6  # m
REVERSE_BELOW = 0.3  # m/s: at lower speeds a negative action drives backwards

GAZE_AHEAD = 2.0  # m, of the camera

PROGRESS_WEIGHT = 0.1  # per m
FINISH_REWARD = 5.0
ROOF_REWARD = -5.0
ENERGY_WEIGHT = -0.01  # per kJ
SMOOTH_WEIGHT = -0.002

_CHASSIS = scene.CHASSIS_BODY
_REAR = scene.REAR_BODY
_FRONT = scene.FRONT_BODY
_FIRST_OBSTACLE = scene.FIRST_PLANK
_FULCRUM = scene.FIRST_FULCRUM
_BOX = scene.FIRST_BOX
_LAST_OBSTACLE = scene.LAST_OBSTACLE
_SHAPE_OFFSET = scene.FIRST_OBSTACLE_SHAPE - scene.FIRST_PLANK
_FINISH = scene.FINISH
_RADIUS = scene.RADIUS
_TRAVEL = scene.TRAVEL
_TOP_SPEED = scene.TOP_SPEED
_REVERSE_SPEED = scene.REVERSE_SPEED
_BRAKE_SHARE = scene.BRAKE_TORQUE / scene.TORQUE
_CHASSIS_MASS = scene.CHASSIS_MASS
_AXLE = scene.REAR_AXLE
_MOTOR_SLOT = 3  # of a wheel joint's impulses


# ---------------------------------------------------------------- start


@njit
def _apply_physics(  # type: ignore[no-untyped-def]
    physics, world_parameters, body_parameters, shape_parameters, joint_parameters
):
    """Quantities of the episode, in the order of car.CarTask.quantities."""
    for s in range(len(shape_parameters)):
        shape_parameters[s].friction = physics[0]
    chassis = body_parameters[_CHASSIS]
    share = physics[1] / _CHASSIS_MASS
    chassis.mass *= share
    chassis.inertia *= share
    chassis.inv_mass /= share
    chassis.inv_inertia /= share
    for k in range(2):
        joint_parameters[_AXLE + k].stiffness = physics[3]
    world_parameters.gravity[1] = -physics[4]


@njit
def start_worlds(  # type: ignore[no-untyped-def]
    worlds, draws, difficulty, records, physics, world_parameters, bodies, body_parameters,
    shape_parameters, joint_parameters, vertices,
):  # fmt: skip
    """Episodes begin: a new course, the car at rest at its start."""
    for i in range(len(worlds)):
        w = worlds[i]
        _apply_physics(
            physics[w], world_parameters[w], body_parameters[w], shape_parameters[w],
            joint_parameters[w],
        )  # fmt: skip
        record = records[w]
        build_course(
            difficulty, draws[i], record.kinds, bodies[w], body_parameters[w], shape_parameters[w],
            joint_parameters[w], vertices[w],
        )  # fmt: skip
        record.place = bodies[w, _CHASSIS].position[0]
        record.best = record.place
        record.gaze[0], record.gaze[1] = _gaze(bodies[w, _CHASSIS], vertices[w])


# ---------------------------------------------------------------- act


@njit
def act(actions, records, physics, control, bodies, joint_parameters):  # type: ignore[no-untyped-def]
    """Actions to the motors; -1, or the first world whose actions are not finite."""
    for w in range(len(actions)):
        for a in range(2):
            if not math.isfinite(actions[w, a]):
                return w
    for w in range(len(actions)):
        record = records[w]
        chassis = bodies[w, _CHASSIS]
        forwards = chassis.velocity[0] * chassis.rotation[0] + chassis.velocity[1] * chassis.rotation[1]
        record.change = 0.0
        for a in range(2):
            action = min(max(actions[w, a], -1.0), 1.0)
            record.change += 0.5 * (action - record.action[a]) * (action - record.action[a])
            record.action[a] = action
            torque = physics[w, 2] * abs(action)
            speed = _TOP_SPEED
            if action < 0.0 and forwards > REVERSE_BELOW:
                torque *= _BRAKE_SHARE
                speed = 0.0
            elif action < 0.0:
                speed = -_REVERSE_SPEED
            joint_parameters[w, _AXLE + a].motor_effort = torque
            control[w, a] = -speed  # forwards is clockwise
    return -1


# ---------------------------------------------------------------- judge


@njit
def _touches(contacts, count):  # type: ignore[no-untyped-def]
    """Whether (rear wheel, front wheel, chassis) are pushed."""
    rear = False
    front = False
    chassis = False
    for i in range(count):
        contact = contacts[i]
        if contact.total_impulse[0] <= 0.0:
            continue
        rear = rear or contact.body_a == _REAR or contact.body_b == _REAR
        front = front or contact.body_a == _FRONT or contact.body_b == _FRONT
        chassis = chassis or contact.body_a == _CHASSIS or contact.body_b == _CHASSIS
    return rear, front, chassis


@njit
def _power(bodies, joint_states, time):  # type: ignore[no-untyped-def]
    """W that the motors put in; what brakes take out does not count."""
    power = 0.0
    for k in range(2):
        torque = joint_states[_AXLE + k].total_impulse[_MOTOR_SLOT] / time
        rate = bodies[_REAR + k].velocity[2] - bodies[_CHASSIS].velocity[2]
        power += max(torque * rate, 0.0)
    return power


@njit
def _gaze(chassis, vertices):  # type: ignore[no-untyped-def]
    """m, where a camera should look: ahead of the car, between it and the ground there."""
    x, y = chassis.position[0], chassis.position[1]
    ahead = 0.5 * (height_at(x + 4.0, vertices) + height_at(x + 8.0, vertices))
    return x + GAZE_AHEAD, 0.5 * (y + ahead)


@njit
def _follow(record, chassis, vertices):  # type: ignore[no-untyped-def]
    """The camera swings after the car smoothly; it is part of the state, so pictures are, too."""
    x, y = _gaze(chassis, vertices)
    record.gaze[0] += 0.2 * (x + 0.2 * chassis.velocity[0] - record.gaze[0])
    record.gaze[1] += 0.08 * (y - record.gaze[1])


@njit
def judge_world(  # type: ignore[no-untyped-def]
    record, term, fact, contacts, contact_count, bodies, joint_states, vertices, time
):
    """Rewards and facts of one world after a control step; returns (reward, terminated)."""
    chassis = bodies[_CHASSIS]
    _, _, touches = _touches(contacts, contact_count)
    if chassis.rotation[0] >= 0.0:
        record.roof = 0
    elif touches:
        record.roof += 1
    x = chassis.position[0]
    success = x >= _FINISH
    overturned = record.roof >= ROOF_STEPS and not success
    record.power = _power(bodies, joint_states, time)
    term.progress = PROGRESS_WEIGHT * (x - record.place)
    term.finish = FINISH_REWARD if success else 0.0
    term.roof = ROOF_REWARD if overturned else 0.0
    term.energy = ENERGY_WEIGHT * 1e-3 * record.power * CONTROL_TIME
    term.smoothness = SMOOTH_WEIGHT * record.change
    record.place = x
    record.best = max(record.best, x)
    fact.success = success
    fact.is_success = success
    fact.distance = min(max(record.best, 0.0), _FINISH)
    fact.on_roof = record.roof * CONTROL_TIME
    _follow(record, chassis, vertices)
    reward = term.progress + term.finish + term.roof + term.energy + term.smoothness
    return reward, success or overturned


# ---------------------------------------------------------------- observe


@njit
def _raise_heights(out, first, x, body, size, radius):  # type: ignore[no-untyped-def]
    """Heights ahead are at least the top of a box (or capsule) that stands there."""
    c, s = body.rotation[0], body.rotation[1]
    half_y = size[1] + radius
    reach = abs(c) * size[0] + abs(s) * half_y
    near = math.ceil((body.position[0] - reach - x) / HEIGHT_SPACING)
    far = math.floor((body.position[0] + reach - x) / HEIGHT_SPACING)
    for k in range(max(near, 0), min(far, HEIGHTS - 1) + 1):
        dx = x + k * HEIGHT_SPACING - body.position[0]
        top = math.inf  # of the vertical line inside the box: between its sides, and its ends
        if abs(c) > 1e-9:
            top = min(top, (s * dx + half_y * (1.0 if c > 0.0 else -1.0)) / c)
        if abs(s) > 1e-9:
            top = min(top, (-c * dx + size[0] * (1.0 if s > 0.0 else -1.0)) / s)
        out[first + k] = max(out[first + k], body.position[1] + top)


@njit
def _observe_heights(out, first, bodies, body_parameters, shape_parameters, vertices):  # type: ignore[no-untyped-def]
    """What the wheels would meet ahead, over the chassis' own height as authored."""
    chassis = bodies[_CHASSIS]
    x = chassis.position[0] + FIRST_HEIGHT
    for k in range(HEIGHTS):
        out[first + k] = height_at(x + k * HEIGHT_SPACING, vertices)
    last = x + (HEIGHTS - 1) * HEIGHT_SPACING
    for b in range(_FIRST_OBSTACLE, _LAST_OBSTACLE):
        if body_parameters[b].enabled == 0 or (_FULCRUM <= b < _BOX):
            continue
        reach = body_parameters[b].radius
        if bodies[b].position[0] + reach < x or bodies[b].position[0] - reach > last:
            continue
        shape = shape_parameters[_SHAPE_OFFSET + b]
        _raise_heights(out, first, x, bodies[b], shape.size, shape.radius)
    for k in range(HEIGHTS):
        out[first + k] -= chassis.position[1] - scene.CHASSIS_Y


@njit
def _observe_wheel(out, k, wheel, chassis, axle, center):  # type: ignore[no-untyped-def]
    """Rolling speed, suspension and its rate of wheel k."""
    c, s = chassis.rotation[0], chassis.rotation[1]
    dx = wheel.position[0] - chassis.position[0]
    dy = wheel.position[1] - chassis.position[1]
    ux = wheel.velocity[0] - chassis.velocity[0] + chassis.velocity[2] * dy
    uy = wheel.velocity[1] - chassis.velocity[1] - chassis.velocity[2] * dx
    out[7 + k] = -wheel.velocity[2] * _RADIUS / 10.0
    out[9 + k] = (c * dy - s * dx - axle.anchor_a[1] + center[1]) / _TRAVEL
    out[11 + k] = c * uy - s * ux


@njit
def observe_world(  # type: ignore[no-untyped-def]
    out, low, high, record, contacts, contact_count, bodies, body_parameters, shape_parameters,
    joint_parameters, vertices,
):  # fmt: skip
    """All observations of a world, into `out` and within its bounds."""
    chassis = bodies[_CHASSIS]
    out[0] = (_FINISH - chassis.position[0]) / 100.0
    out[1] = chassis.position[1] - height_at(chassis.position[0], vertices)
    out[2] = chassis.rotation[1]
    out[3] = chassis.rotation[0]
    out[4] = chassis.velocity[0] / 10.0
    out[5] = chassis.velocity[1] / 10.0
    out[6] = chassis.velocity[2]
    center = body_parameters[_CHASSIS].center
    for k in range(2):
        _observe_wheel(out, k, bodies[_REAR + k], chassis, joint_parameters[_AXLE + k], center)
    rear, front, touches = _touches(contacts, contact_count)
    out[13] = 1.0 if rear else 0.0
    out[14] = 1.0 if front else 0.0
    out[15] = 1.0 if touches else 0.0
    out[16] = record.action[0]
    out[17] = record.action[1]
    out[18] = record.roof / ROOF_STEPS
    _observe_heights(out, 19, bodies, body_parameters, shape_parameters, vertices)
    for i in range(len(out)):
        out[i] = min(max(out[i], low[i]), high[i])


@njit
def observe_worlds(  # type: ignore[no-untyped-def]
    worlds, out, low, high, records, world_states, contacts, bodies, body_parameters,
    shape_parameters, joint_parameters, vertices,
):  # fmt: skip
    """Observations of chosen worlds."""
    for i in range(len(worlds)):
        w = worlds[i]
        observe_world(
            out[w], low, high, records[w], contacts[w], world_states[w].contact_count, bodies[w],
            body_parameters[w], shape_parameters[w], joint_parameters[w], vertices[w],
        )  # fmt: skip


@njit
def judge_worlds(  # type: ignore[no-untyped-def]
    out, low, high, rewards, terms, facts, terminated, records, world_states, contacts, bodies,
    body_parameters, shape_parameters, joint_parameters, joint_states, vertices, time,
):  # fmt: skip
    """Rewards, ends and observations of all worlds."""
    for w in range(len(records)):
        count = world_states[w].contact_count
        rewards[w], terminated[w] = judge_world(
            records[w], terms[w], facts[w], contacts[w], count, bodies[w], joint_states[w],
            vertices[w], time,
        )  # fmt: skip
        observe_world(
            out[w], low, high, records[w], contacts[w], count, bodies[w], body_parameters[w],
            shape_parameters[w], joint_parameters[w], vertices[w],
        )  # fmt: skip
