"""GCar3D's kernels: initialize, apply actions, evaluate. The docstring of Car3DEnv states the rules."""

from __future__ import annotations

from typing import Any

from gsenv.envs.car3d import scene as n
from gsenv.envs.car3d.course import (
    DRAW_COUNT as DRAW_COUNT,
)
from gsenv.envs.car3d.course import (
    KINDS,
    build_course,
    gate_place,
    place_thing,
)
from gsenv.envs.car3d.observe import FLIGHT_STEPS, observe_world
from gsenv.envs.car3d.road import COLUMNS, HEADING, nearest, path_at
from gsenv.envs.core.kernels import active_contacts, first_not_finite
from gsenv.solver.core.edit import disable_body, set_mass
from gsenv.solver.core.trig import sin_cos
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import select_world
from gsenv.solver.spatial.math import quaternion, sub, turned, vec

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    ("kinds", "i8", (KINDS,)),  # obstacle of each slot, -1: none; of the rest of the deck, -1
    ("places", "f8", (n.SLOTS,)),  # m along the centre line, of the obstacles
    ("path", "f8", (n.NODES, COLUMNS)),  # m and rad, centre line of the road: x, y, z, heading
    ("place", "f8"),  # m along the centre line, of the nearest point
    ("aside", "f8"),  # m, distance to the left of it
    ("best", "f8"),  # m, the largest place
    ("steps", "i8"),  # control steps since the start
    ("action", "f8", (2,)),
    ("change", "f8"),  # mean square change of the last action
    ("steering", "f8"),  # rad, the target of the front wheels
    ("touch", "f8", (4,)),  # 1 where a wheel is pushed
    ("flight", "i8"),  # control steps since a wheel touched something
    ("slot", "i8"),  # of the next gate; SLOTS: none
    ("gates", "i8"),  # that were passed
    ("missed", "i8"),  # gates
    ("off_road_steps", "i8"),  # beside the road
    ("off_road_streak", "i8"),  # those of them since the car was last on it
    ("jumping", "i8"),  # 1 while the next gate has been missed, and an axle has not touched anything since
    (
        "down",
        "i8",
        (2,),
    ),  # 1 once a wheel of the rear, the front axle has touched something at the next gate or later
    ("gaze", "f8", (4,)),  # m, point (x, y, z) that the camera follows, and rad, its heading
]

CONTROL_TIME = 1.0 / 30.0  # s
STRAY_STEPS = 30  # on end beside the road, after which it has strayed
LEAST_UP = 0.2  # cosine of the tilt at which the car has rolled over

PROGRESS_WEIGHT = 0.1  # per m
PAID_SPEED = 8.0  # m/s: progress beyond costs, else a learner's first habit is to be fast
FAST_WEIGHT = -0.1  # per m beyond it
TIME_REWARD = -0.005  # per step
FINISH_REWARD = 5.0
FAILURE_REWARD = -0.5  # and TIME_REWARD for each step that is left: giving up saves no time
MISS_REWARD = -1.0  # for each missed gate
JUMP_WEIGHT = -1.0  # per m forwards after a miss, until both axles have touched something
OFF_ROAD_REWARD = -0.02  # for each step beside the road
OFF_ROAD_WEIGHT = -0.01  # per m and step beyond OFF_ROAD
SMOOTH_WEIGHT = -0.002

_PAID_PROGRESS = PAID_SPEED * CONTROL_TIME
_CHASSIS, _WHEEL, _CABIN = n.CHASSIS_BODY, n.FIRST_WHEEL, n.CABIN_BODY
_SLOTS, _FINISH = n.SLOTS, n.FINISH
_AXLES = n.AXLE_JOINTS
_STEER = n.FIRST_STEERING
_TOP_SPEED, _BRAKE_SHARE = n.TOP_SPEED, n.BRAKE_TORQUE / n.TORQUE
_STEERING, _STEERING_STEP = n.STEERING, n.STEERING_RATE * CONTROL_TIME
_GATE_HALF, _GATE_WIDTH = n.GATE_HALF, n.GATE_WIDTH
_OFF_ROAD, _STRAY, _STRAY_BEHIND = n.OFF_ROAD, n.STRAY, n.STRAY_BEHIND
_RED, _GREEN = n.FIRST_RED, n.FIRST_GREEN


# ---------------------------------------------------------------- initialize


@njit
def _apply_physics(physics, parameters):  # type: ignore[no-untyped-def]
    """Write the quantities of the episode, in the order of Car3DTask.quantities, to a world's parameters."""
    for s in range(len(parameters.shapes)):
        parameters.shapes[s].friction = physics[0]
    set_mass(parameters.bodies[_CHASSIS], physics[1])
    for k in range(4):
        parameters.joints[_AXLES[k]].stiffness = physics[3]
    parameters.world.gravity[2] = -physics[4]


@njit
def _next_gate(kinds, slot):  # type: ignore[no-untyped-def]
    """Return the first slot with an obstacle from `slot` on, or the number of slots."""
    while slot < _SLOTS and kinds[slot] < 0:
        slot += 1
    return slot


@njit
def initialize_world(world, difficulty, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: build a new course; the car is at rest at its start."""
    _apply_physics(world.task.physics, world.parameters)
    build_course(world, difficulty, draws)
    task, position = world.task.state, world.state.bodies[_CHASSIS].position
    task.slot = _next_gate(task.kinds, 0)
    for d in range(3):
        task.gaze[d] = position[d]


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, 2) to motors and steering; return -1, or the first world whose actions are not finite."""
    bad = first_not_finite(actions)
    if bad >= 0:
        return bad
    for w in range(len(actions)):
        select_world(world, w)
        _apply_action(world, actions[w])
    return -1


@njit
def _apply_action(world, action):  # type: ignore[no-untyped-def]
    task = world.task.state
    task.change = 0.0
    for a in range(2):
        share = min(max(action[a], -1.0), 1.0)
        task.change += 0.5 * (share - task.action[a]) * (share - task.action[a])
        task.action[a] = share
    throttle = task.action[0]
    torque, speed = world.task.physics[2] * abs(throttle), _TOP_SPEED
    if throttle < 0.0:  # no reverse gear: to back out of the course was what slow learners learned first
        torque *= _BRAKE_SHARE
        speed = 0.0
    for k in range(4):
        world.parameters.joints[_AXLES[k]].motor_effort = torque
        world.state.control[k] = speed
    turn = _STEERING * task.action[1] - task.steering
    task.steering += min(max(turn, -_STEERING_STEP), _STEERING_STEP)
    for k in range(2):
        world.state.control[_STEER + k] = task.steering


# ---------------------------------------------------------------- evaluate


@njit
def _feel(contacts, touch):  # type: ignore[no-untyped-def]
    """Set `touch` to 1 where a wheel is pushed, else to 0."""
    for k in range(4):
        touch[k] = 0.0
    for i in range(len(contacts)):
        contact = contacts[i]
        if contact.total_impulse[0] <= 0.0:
            continue
        for k in range(4):
            if contact.body_a == _WHEEL + k or contact.body_b == _WHEEL + k:
                touch[k] = 1.0


@njit
def _update_task(world):  # type: ignore[no-untyped-def]
    """Update what the car has done; return the progress in m in this step."""
    task, chassis = world.task.state, world.state.bodies[_CHASSIS]
    _feel(active_contacts(world), task.touch)
    on_ground = task.touch[0] + task.touch[1] + task.touch[2] + task.touch[3] > 0.0
    task.flight = 0 if on_ground else task.flight + 1
    task.steps += 1
    place, task.aside = nearest(task.path, task.place, chassis.position[0], chassis.position[1])
    progress = place - task.place
    task.place = place
    task.best = max(task.best, place)
    return progress


@njit
def _ahead_of_gate(world, axle):  # type: ignore[no-untyped-def]
    """Return how far in m an axle is beyond the next gate."""
    task, bodies = world.task.state, world.state.bodies
    cosine, sine = sin_cos(path_at(task.path, task.place, HEADING))
    middle = bodies[_CHASSIS].position
    ahead = task.place - gate_place(task, task.slot)
    for k in range(2 * axle, 2 * axle + 2):
        wheel = bodies[_WHEEL + k].position
        ahead += 0.5 * (cosine * (wheel[0] - middle[0]) + sine * (wheel[1] - middle[1]))
    return ahead


@njit
def _pass_gates(world, progress):  # type: ignore[no-untyped-def]
    """Note axles whose wheels touch something at the next gate or behind it; return the reward for gates."""
    task = world.task.state
    if task.slot >= _SLOTS:
        return 0.0
    reward = 0.0
    for axle in range(2):
        ahead = _ahead_of_gate(world, axle)
        beyond = ahead > _GATE_HALF
        if beyond and task.down[axle] + task.jumping == 0:
            task.jumping = 1
            task.missed += 1
            reward = MISS_REWARD
        touches = task.touch[2 * axle] + task.touch[2 * axle + 1] > 0.0
        if touches and (beyond or (ahead >= -_GATE_HALF and abs(task.aside) <= _GATE_WIDTH)):
            task.down[axle] = 1
    if task.down[0] + task.down[1] < 2:
        return reward + task.jumping * JUMP_WEIGHT * max(progress, 0.0)
    if task.jumping == 0:
        _turn_green(world, task.slot)
        task.gates += 1
    task.jumping = task.down[0] = task.down[1] = 0
    task.slot = _next_gate(task.kinds, task.slot + 1)
    return reward


@njit
def _turn_green(world, slot):  # type: ignore[no-untyped-def]
    """Replace the red bar of a gate by a green one."""
    bodies = world.state.bodies
    red = bodies[_RED + slot]
    turn = quaternion(red.rotation)
    center = turned(turn, vec(world.parameters.bodies[_RED + slot].center))
    place_thing(world, _GREEN + slot, sub(vec(red.position), center), turn)
    disable_body(_RED + slot, bodies, world.parameters.bodies, active_contacts(world))


@njit
def _follow(world):  # type: ignore[no-untyped-def]
    """Move the camera's point and heading smoothly after the car, and the drawn cabin with it."""
    task, chassis = world.task.state, world.state.bodies[_CHASSIS]
    for d in range(3):
        task.gaze[d] += (0.35 if d < 2 else 0.12) * (chassis.position[d] - task.gaze[d])
    task.gaze[3] += 0.1 * (path_at(task.path, task.place + 4.0, HEADING) - task.gaze[3])
    place_thing(world, _CABIN, vec(chassis.position), quaternion(chassis.rotation))


@njit
def evaluate_world(world, time_limit):  # type: ignore[no-untyped-def]
    """Set reward terms and info of one world after a control step; return (reward, terminated)."""
    task, term, info = world.task.state, world.task.terms, world.task.info
    progress = _update_task(world)
    gates = _pass_gates(world, progress)
    up = turned(quaternion(world.state.bodies[_CHASSIS].rotation), (0.0, 0.0, 1.0))
    rolled = up[2] < LEAST_UP
    beyond = abs(task.aside) - _OFF_ROAD
    off = beyond > 0.0
    task.off_road_steps += int(off)
    task.off_road_streak = task.off_road_streak + 1 if off else 0
    strayed = abs(task.aside) > _STRAY or task.place < -_STRAY_BEHIND or task.off_road_streak >= STRAY_STEPS
    failed = rolled or strayed
    finished = task.place >= _FINISH and not failed
    success = finished and task.missed + task.off_road_steps == 0
    _follow(world)
    counts = (task.flight <= FLIGHT_STEPS and not off) or progress < 0.0
    fast = max(progress - _PAID_PROGRESS, 0.0)
    term.progress = PROGRESS_WEIGHT * (progress - fast) + FAST_WEIGHT * fast if counts else 0.0
    term.time = TIME_REWARD
    term.finish = FINISH_REWARD if finished else 0.0
    term.failure = FAILURE_REWARD + TIME_REWARD * max(time_limit - task.steps, 0) if failed else 0.0
    term.gates = gates
    term.off_road = OFF_ROAD_REWARD + OFF_ROAD_WEIGHT * beyond if off else 0.0
    term.smoothness = SMOOTH_WEIGHT * task.change
    info.success = success
    info.is_success = success
    info.distance = max(task.best, 0.0)
    info.gates = task.gates
    info.missed_gates = task.missed
    info.rolled_over = rolled
    info.off_road = off
    info.off_road_time = CONTROL_TIME * task.off_road_steps
    info.strayed = strayed
    reward = term.progress + term.time + term.finish + term.failure + term.gates + term.off_road + term.smoothness
    return reward, finished or failed


# ---------------------------------------------------------------- all worlds


@njit
def initialize_worlds(world, worlds, difficulty, draws):  # type: ignore[no-untyped-def]
    """Begin episodes in chosen worlds; `draws` is (chosen world, number), uniform in [0, 1)."""
    for i in range(len(worlds)):
        select_world(world, worlds[i])
        initialize_world(world, difficulty, draws[i])
        observe_world(world)


@njit
def evaluate_worlds(world, time_limit):  # type: ignore[no-untyped-def]
    """Set rewards, terminations and observations of all worlds; `time_limit` is that of the episodes in steps."""
    rewards, terminated = world.task.rewards, world.task.terminated
    for w in range(len(rewards)):
        select_world(world, w)
        rewards[w], terminated[w] = evaluate_world(world, time_limit)
        observe_world(world)
