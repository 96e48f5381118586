"""GCar's kernels: initialize, apply actions, evaluate, observe. The docstring of CarEnv states the rules."""

from __future__ import annotations

import math
from typing import Any

from gsenv.envs.car import scene
from gsenv.envs.car.course import DRAW_COUNT as DRAW_COUNT
from gsenv.envs.car.course import build_course, height_at, place_thing, slot_x
from gsenv.envs.car.gates import pass_gates, place_gates
from gsenv.envs.core.kernels import active_contacts, clip, first_not_finite
from gsenv.solver.core.edit import set_mass
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import select_world

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    ("kinds", "i8", (scene.SLOTS,)),  # obstacle of each slot, -1: none
    ("place", "f8"),  # m, of the chassis at the last step
    ("best", "f8"),  # m, the farthest it came
    ("action", "f8", (2,)),
    ("change", "f8"),  # mean square change of the last action
    ("power", "f8"),  # W, of the motors at the end of the last step
    ("roof", "i8"),  # control steps on the roof
    ("touch", "f8", (3,)),  # 1 where rear wheel, front wheel and chassis are pushed
    ("flight", "i8"),  # control steps since a wheel touched something
    ("velocity", "f8", (2,)),  # m/s, of the chassis at the last step
    ("shock", "f8"),  # of the last step, in multiples of the limit
    ("gate", "i8"),  # slot of the next gate; SLOTS: none
    ("below", "f8", (2,)),  # 1 where rear and front wheel have touched something below its bar
    ("gates", "i8"),  # that were passed
    ("gaze", "f8", (2,)),  # m, where the camera looks
]

CONTROL_TIME = 1.0 / 30.0  # s
ROOF_STEPS = 30
HEIGHTS = 16
FIRST_HEIGHT = 0.6  # m ahead of the chassis' middle
HEIGHT_SPACING = 0.6  # m
HEIGHT_UNIT = 2.0  # m, of observed heights
RATE_UNIT = 3.0  # rad/s and m/s, of observed rates
REVERSE_BELOW = 0.3  # m/s: at lower speeds a negative action drives backwards
FLIGHT_STEPS = 15  # without a wheel on anything, after which progress is not paid
G = 9.81  # m/s^2, the unit of shocks, whatever the gravity
SHOCK_LIMIT = 10.0  # G, mean over a control step
FREE_SHOCK = 0.5  # of the limit, that costs nothing
GATE_SIGHT = 20.0  # m

GAZE_AHEAD = 2.0  # m, of the camera

PROGRESS_WEIGHT = 0.1  # per m
TIME_REWARD = -0.005  # per step
FINISH_REWARD = 5.0
FAILURE_REWARD = -1.0
SHOCK_WEIGHT = -0.5
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
_AXLE = scene.REAR_AXLE
_BURST = scene.BURST_BODY
_SLOTS = scene.SLOTS
_MOTOR_SLOT = 3  # of a wheel joint's impulses


# ---------------------------------------------------------------- initialize


@njit
def _apply_physics(physics, parameters):  # type: ignore[no-untyped-def]
    """Write the quantities of the episode, in the order of CarTask.quantities, to a world's parameters."""
    for s in range(len(parameters.shapes)):
        parameters.shapes[s].friction = physics[0]
    set_mass(parameters.bodies[_CHASSIS], physics[1])
    for k in range(2):
        parameters.joints[_AXLE + k].stiffness = physics[3]
    parameters.world.gravity[1] = -physics[4]


@njit
def initialize_world(world, difficulty, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: build a new course; the car is at rest at its start."""
    _apply_physics(world.task.physics, world.parameters)
    build_course(world, difficulty, draws)
    task, chassis = world.task.state, world.state.bodies[_CHASSIS]
    task.place = chassis.position[0]
    task.best = task.place
    task.gaze[0], task.gaze[1] = _gaze(chassis, world.parameters.vertices)
    place_gates(world)


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, 2) to the motors; return -1, or the first world whose actions are not finite."""
    bad = first_not_finite(actions)
    if bad >= 0:
        return bad
    for w in range(len(actions)):
        select_world(world, w)
        _apply_action(world, actions[w])
    return -1


@njit
def _apply_action(world, action):  # type: ignore[no-untyped-def]
    task, chassis = world.task.state, world.state.bodies[_CHASSIS]
    forwards = chassis.velocity[0] * chassis.rotation[0] + chassis.velocity[1] * chassis.rotation[1]
    task.change = 0.0
    for a in range(2):
        share = min(max(action[a], -1.0), 1.0)
        task.change += 0.5 * (share - task.action[a]) * (share - task.action[a])
        task.action[a] = share
        torque = world.task.physics[2] * abs(share)
        speed = _TOP_SPEED
        if share < 0.0 and forwards > REVERSE_BELOW:
            torque *= _BRAKE_SHARE
            speed = 0.0
        elif share < 0.0:
            speed = -_REVERSE_SPEED
        world.parameters.joints[_AXLE + a].motor_effort = torque
        world.state.control[a] = -speed  # forwards is clockwise


# ---------------------------------------------------------------- evaluate


@njit
def _feel(contacts, touch):  # type: ignore[no-untyped-def]
    """Set `touch` to 1 where rear wheel, front wheel and chassis are pushed, else to 0."""
    for k in range(3):
        touch[k] = 0.0
    for i in range(len(contacts)):
        contact = contacts[i]
        if contact.total_impulse[0] <= 0.0:
            continue
        if contact.body_a == _REAR or contact.body_b == _REAR:
            touch[0] = 1.0
        if contact.body_a == _FRONT or contact.body_b == _FRONT:
            touch[1] = 1.0
        if contact.body_a == _CHASSIS or contact.body_b == _CHASSIS:
            touch[2] = 1.0


@njit
def _measure_shock(task, velocity, gravity):  # type: ignore[no-untyped-def]
    """Set the shock of the last step: what an accelerometer on the chassis reads on average, over its limit."""
    ax = (velocity[0] - task.velocity[0]) / CONTROL_TIME - gravity[0]
    ay = (velocity[1] - task.velocity[1]) / CONTROL_TIME - gravity[1]
    task.shock = math.sqrt(ax * ax + ay * ay) / (SHOCK_LIMIT * G)
    task.velocity[0], task.velocity[1] = velocity[0], velocity[1]


@njit
def _power(bodies, joint_states, timestep):  # type: ignore[no-untyped-def]
    """Return the power in W that the motors put in; power that the brakes take out does not count."""
    power = 0.0
    for k in range(2):
        torque = joint_states[_AXLE + k].total_impulse[_MOTOR_SLOT] / timestep
        rate = bodies[_REAR + k].velocity[2] - bodies[_CHASSIS].velocity[2]
        power += max(torque * rate, 0.0)
    return power


@njit
def _gaze(chassis, vertices):  # type: ignore[no-untyped-def]
    """Return the point (x, y) in m that a camera should look at: ahead of the car, between it and the ground there."""
    x, y = chassis.position[0], chassis.position[1]
    ahead = 0.5 * (height_at(x + 4.0, vertices) + height_at(x + 8.0, vertices))
    return x + GAZE_AHEAD, 0.5 * (y + ahead)


@njit
def _follow(task, chassis, vertices):  # type: ignore[no-untyped-def]
    """Move the camera's point smoothly after the car; it is task state, so that a restored world looks the same."""
    x, y = _gaze(chassis, vertices)
    task.gaze[0] += 0.2 * (x + 0.2 * chassis.velocity[0] - task.gaze[0])
    task.gaze[1] += 0.08 * (y - task.gaze[1])


@njit
def _update_task(world, timestep):  # type: ignore[no-untyped-def]
    """Update what the car has done; return the progress in m in this step that counts."""
    task, chassis = world.task.state, world.state.bodies[_CHASSIS]
    _feel(active_contacts(world), task.touch)
    task.flight = 0 if task.touch[0] + task.touch[1] > 0.0 else task.flight + 1
    if chassis.rotation[0] >= 0.0:
        task.roof = 0
    elif task.touch[2] > 0.0:
        task.roof += 1
    _measure_shock(task, chassis.velocity, world.parameters.world.gravity)
    task.power = _power(world.state.bodies, world.state.joints, timestep)
    progress = chassis.position[0] - task.place
    task.place = chassis.position[0]
    task.best = max(task.best, task.place)
    _follow(task, chassis, world.parameters.vertices)
    return progress if task.flight <= FLIGHT_STEPS or progress < 0.0 else 0.0


@njit
def evaluate_world(world, timestep):  # type: ignore[no-untyped-def]
    """Set reward terms and info of one world after a control step; return (reward, terminated)."""
    task, term, info = world.task.state, world.task.terms, world.task.info
    progress = _update_task(world, timestep)
    missed = pass_gates(world)
    crashed = task.shock > 1.0
    failed = missed or crashed or task.roof >= ROOF_STEPS
    success = task.place >= _FINISH and not failed
    if crashed:
        chassis = world.state.bodies[_CHASSIS]
        place_thing(world, _BURST, chassis.position[0], chassis.position[1], 0.0)
    term.progress = PROGRESS_WEIGHT * progress
    term.time = TIME_REWARD
    term.finish = FINISH_REWARD if success else 0.0
    term.failure = FAILURE_REWARD if failed else 0.0
    rough = max(min(task.shock, 1.0) - FREE_SHOCK, 0.0)
    term.shock = SHOCK_WEIGHT * rough * rough
    term.energy = ENERGY_WEIGHT * 1e-3 * task.power * CONTROL_TIME
    term.smoothness = SMOOTH_WEIGHT * task.change
    info.success = success
    info.is_success = success
    info.distance = min(max(task.best, 0.0), _FINISH)
    info.gates = task.gates
    info.missed_gates = int(missed)
    info.crashed = crashed
    info.shock = SHOCK_LIMIT * task.shock
    info.roof_time = task.roof * CONTROL_TIME
    reward = term.progress + term.time + term.finish + term.failure + term.shock + term.energy + term.smoothness
    return reward, success or failed


# ---------------------------------------------------------------- observe


@njit
def _raise_heights(out, x, body, size, radius):  # type: ignore[no-untyped-def]
    """Raise the heights ahead to at least the top of a box or capsule that stands there."""
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
        out[k] = max(out[k], body.position[1] + top)
    if radius > 0.0:
        _raise_ends(out, x, body, size[0], radius)


@njit
def _raise_ends(out, x, body, half_length, radius):  # type: ignore[no-untyped-def]
    """Raise the heights ahead to at least the tops of the round ends of a capsule."""
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        end_x = body.position[0] + sign * half_length * body.rotation[0]
        end_y = body.position[1] + sign * half_length * body.rotation[1]
        near = math.ceil((end_x - radius - x) / HEIGHT_SPACING)
        far = math.floor((end_x + radius - x) / HEIGHT_SPACING)
        for k in range(max(near, 0), min(far, HEIGHTS - 1) + 1):
            dx = x + k * HEIGHT_SPACING - end_x
            out[k] = max(out[k], end_y + math.sqrt(max(radius * radius - dx * dx, 0.0)))


@njit
def _observe_heights(world, out):  # type: ignore[no-untyped-def]
    """Write the heights that the wheels would meet ahead (`HEIGHTS` entries), above the height of level ground."""
    bodies, parameters, shapes = world.state.bodies, world.parameters.bodies, world.parameters.shapes
    vertices = world.parameters.vertices
    chassis = bodies[_CHASSIS]
    x = chassis.position[0] + FIRST_HEIGHT
    for k in range(HEIGHTS):
        out[k] = height_at(x + k * HEIGHT_SPACING, vertices)
    last = x + (HEIGHTS - 1) * HEIGHT_SPACING
    for b in range(_FIRST_OBSTACLE, _LAST_OBSTACLE):
        if parameters[b].enabled == 0 or (_FULCRUM <= b < _BOX):
            continue
        reach = parameters[b].radius
        if bodies[b].position[0] + reach < x or bodies[b].position[0] - reach > last:
            continue
        shape = shapes[_SHAPE_OFFSET + b]
        _raise_heights(out, x, bodies[b], shape.size, shape.radius)
    for k in range(HEIGHTS):
        out[k] = (out[k] - chassis.position[1] + scene.CHASSIS_Y) / HEIGHT_UNIT


@njit
def _observe_wheel(out, k, wheel, chassis, axle, center):  # type: ignore[no-untyped-def]
    """Write the rolling speed of wheel k, the compression of its suspension, and the rate of compression."""
    c, s = chassis.rotation[0], chassis.rotation[1]
    dx = wheel.position[0] - chassis.position[0]
    dy = wheel.position[1] - chassis.position[1]
    ux = wheel.velocity[0] - chassis.velocity[0] + chassis.velocity[2] * dy
    uy = wheel.velocity[1] - chassis.velocity[1] - chassis.velocity[2] * dx
    out[7 + k] = -wheel.velocity[2] * _RADIUS / 10.0
    out[9 + k] = (c * dy - s * dx - axle.anchor_a[1] + center[1]) / _TRAVEL
    out[11 + k] = (c * uy - s * ux) / RATE_UNIT


@njit
def _observe_car(world, out):  # type: ignore[no-untyped-def]
    """Write entries 0 to 12: distance, height, pitch, velocity and wheels."""
    bodies, parameters = world.state.bodies, world.parameters
    chassis = bodies[_CHASSIS]
    out[0] = (_FINISH - chassis.position[0]) / 100.0
    out[1] = (chassis.position[1] - height_at(chassis.position[0], parameters.vertices)) / HEIGHT_UNIT
    out[2] = chassis.rotation[1]
    out[3] = chassis.rotation[0]
    out[4] = chassis.velocity[0] / 10.0
    out[5] = chassis.velocity[1] / 10.0
    out[6] = chassis.velocity[2] / RATE_UNIT
    center = parameters.bodies[_CHASSIS].center
    for k in range(2):
        _observe_wheel(out, k, bodies[_REAR + k], chassis, parameters.joints[_AXLE + k], center)


@njit
def observe_world(world):  # type: ignore[no-untyped-def]
    """Write all observations of a world, clipped to their bounds."""
    task, out = world.task.state, world.task.observation
    _observe_car(world, out)
    for k in range(3):
        out[13 + k] = task.touch[k]
    for a in range(2):
        out[16 + a] = task.action[a]
        out[18 + a] = task.below[a]
    out[20] = 2.0
    if task.gate < _SLOTS:
        out[20] = 2.0 * (slot_x(task.gate) - world.state.bodies[_CHASSIS].position[0]) / GATE_SIGHT
    out[21] = task.flight / FLIGHT_STEPS
    out[22] = task.shock
    out[23] = task.roof / ROOF_STEPS
    _observe_heights(world, out[24:])
    clip(out, world.task.low, world.task.high)


# ---------------------------------------------------------------- all worlds


@njit
def initialize_worlds(world, worlds, difficulty, draws):  # type: ignore[no-untyped-def]
    """Begin episodes in chosen worlds; `draws` is (chosen world, number), uniform in [0, 1)."""
    for i in range(len(worlds)):
        select_world(world, worlds[i])
        initialize_world(world, difficulty, draws[i])
        observe_world(world)


@njit
def evaluate_worlds(world, timestep):  # type: ignore[no-untyped-def]
    """Set rewards, terminations and observations of all worlds."""
    rewards, terminated = world.task.rewards, world.task.terminated
    for w in range(len(rewards)):
        select_world(world, w)
        rewards[w], terminated[w] = evaluate_world(world, timestep)
        observe_world(world)
