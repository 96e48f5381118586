"""GRagdoll2D's kernels: initialize, apply actions, evaluate, observe. The docstring of RagdollEnv states the rules."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsenv.envs.core.kernels import active_contacts, between, clip, first_not_finite
from gsenv.envs.ragdoll2d import scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.shared_rules import (
    CONTROL_TIME,
    FALL_HEIGHT,
    FALL_TILT,
    PUSH_STEPS,
    SHOWN_STEPS,
)
from gsenv.solver.core.edit import place_body, set_mass
from gsenv.solver.core.trig import sin_cos
from gsenv.solver.jit import njit
from gsenv.solver.planar.geometry import bounding_box, shape_pose
from gsenv.solver.records.bundle import select_world

ACTIONS = len(scene.AXES)
JOINTS = len(scene.JOINTS)
DRAW_COUNT = JOINTS + 2 + shared.PUSH_DRAWS

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    *shared.task_state_fields(ACTIONS),
    ("apart", "f8"),  # s with the feet apart
    ("gaze", "f8"),  # m, where the camera looks
]

START_ANGLE = 0.06  # rad, largest deviation of a joint from the stand at the start
START_TILT = 0.03  # rad
START_SPEED = 0.1  # m/s

APART = 0.2  # m between the ankles, beyond which the feet are apart
MOST_APART = 2.0  # s
APART_WEIGHT = -0.02
FREE_STRIDE = 0.1  # m between the ankles
STRIDE = 0.3  # m beyond that, which cost the whole weight

_PELVIS, _TORSO, _ARROW, _FIRST = scene.PELVIS, scene.TORSO, scene.ARROW_BODY, scene.FIRST_PART
_FEET = scene.FEET
_NEAR_FOOT, _FAR_FOOT = _FEET
_BODIES = len(scene.BODIES)
_PARENTS = tuple(axis.parent for axis in scene.JOINTS)
_CHILDREN = tuple(axis.child for axis in scene.JOINTS)
_ANCHOR_X = tuple(axis.anchor[0] for axis in scene.JOINTS)
_ANCHOR_Y = tuple(axis.anchor[1] for axis in scene.JOINTS)
_STAND = tuple(axis.stand for axis in scene.JOINTS)
_SPAN = tuple(0.5 * scene.REACH * (axis.limits[1] - axis.limits[0]) for axis in scene.AXES)
_BELOW = tuple(axis.stand - axis.limits[0] for axis in scene.AXES)  # rad, from the stand to either limit
_ABOVE = tuple(axis.limits[1] - axis.stand for axis in scene.AXES)
_EFFORT = tuple(axis.effort for axis in scene.AXES)
_TILT = -sum(axis.stand for axis in scene.AXES[1:4])  # of the pelvis where the soles are level
_STAND_HEIGHT, _HIPS_HEIGHT = scene.stand_height(), scene.hips_height()
_LEGS = (scene.NEAR_THIGH, scene.FAR_THIGH, scene.NEAR_SHIN, scene.FAR_SHIN, scene.NEAR_FOOT, scene.FAR_FOOT)
_HEEL, _TOE, _ANKLE, _CROWN = scene.HEEL, scene.TOE, scene.ANKLE, scene.CROWN
_ARROW_LENGTH, _ARROW_HEAD, _ARROW_GAP = scene.ARROW_LENGTH, scene.ARROW_HEAD, scene.ARROW_GAP
_PARKED_X, _PARKED_Y = scene.PARKED
_ACTUATED = tuple(range(ACTIONS))  # their joints
_BALANCE_ENTRIES = 17 + 2 * JOINTS + ACTIONS  # of the observations of standing figures
_SPRING_SLOT = 4  # of a revolute joint's impulses
_FRICTION, _TRUNK, _LEG, _STRENGTH, _DELAY = range(5)  # of BalanceTask.quantities


# ---------------------------------------------------------------- initialize


@njit
def _apply_physics(world):  # type: ignore[no-untyped-def]
    """Write the quantities of the episode, in the order of BalanceTask.quantities, to a world's parameters."""
    physics, parameters = world.task.physics, world.parameters
    for s in range(len(parameters.shapes)):
        parameters.shapes[s].friction = physics[_FRICTION]
    mass = 0.0
    for b in range(_FIRST, _BODIES):
        body = parameters.bodies[b]
        factor = physics[_TRUNK]
        for k in range(len(_LEGS)):
            if b == _LEGS[k]:
                factor = physics[_LEG]
        set_mass(body, factor * body.mass)
        mass += body.mass
    world.task.state.mass = mass
    for j in range(ACTIONS):
        parameters.joints[j].spring_effort = physics[_STRENGTH] * _EFFORT[j]


@njit
def _place(world, b, x, y, angle, speed):  # type: ignore[no-untyped-def]
    c, s = sin_cos(angle)
    place_body(
        b, world.state.bodies, world.parameters.bodies, active_contacts(world), (x, y), (c, s, angle), (speed, 0.0, 0.0)
    )


@njit
def _place_figure(world, x, y, tilt, speed, angles):  # type: ignore[no-untyped-def]
    """Place the figure, the hips at (x, y) m and the pelvis tilted; all bodies move at `speed` m/s.

    `angles`: rad, by which its joints are off the stand.
    """
    bodies, parameters = world.state.bodies, world.parameters.bodies
    _place(world, _PELVIS, x, y, tilt, speed)
    for j in range(JOINTS):
        parent = bodies[_PARENTS[j]]
        c, s = parent.rotation[0], parent.rotation[1]
        ax = _ANCHOR_X[j] - parameters[_PARENTS[j]].center[0]
        ay = _ANCHOR_Y[j] - parameters[_PARENTS[j]].center[1]
        angle = parent.angle + _STAND[j] + angles[j]
        _place(
            world, _CHILDREN[j], parent.position[0] + c * ax - s * ay, parent.position[1] + s * ax + c * ay,
            angle, speed,
        )  # fmt: skip


@njit
def point_of(body, parameters, x, y):  # type: ignore[no-untyped-def]
    """Return where a point (x, y) in m of a body's own frame is in the world."""
    c, s = body.rotation[0], body.rotation[1]
    dx, dy = x - parameters.center[0], y - parameters.center[1]
    return body.position[0] + c * dx - s * dy, body.position[1] + s * dx + c * dy


@njit
def _lowest_sole(world):  # type: ignore[no-untyped-def]
    bodies, parameters = world.state.bodies, world.parameters.bodies
    low = math.inf
    for b in (_NEAR_FOOT, _FAR_FOOT):
        for x in (_HEEL, _TOE):
            low = min(low, point_of(bodies[b], parameters[b], x, -_ANKLE)[1])
    return low


@njit
def _stand(world, draws):  # type: ignore[no-untyped-def]
    tilt = _TILT + between(-START_TILT, START_TILT, draws[JOINTS])
    speed = between(-START_SPEED, START_SPEED, draws[JOINTS + 1])
    angles = np.empty(JOINTS)
    for j in range(JOINTS):
        angles[j] = between(-START_ANGLE, START_ANGLE, draws[j])
    _place_figure(world, 0.0, 0.0, tilt, speed, angles)
    _place_figure(world, 0.0, -_lowest_sole(world), tilt, speed, angles)


@njit
def _lowest_point(world):  # type: ignore[no-untyped-def]
    """Return the height in m of the figure's lowest point."""
    parameters, low = world.parameters, math.inf
    for s in range(len(world.model.shapes)):
        b = world.model.shapes[s].body
        if b >= _FIRST and world.model.shapes[s].mask != 0:
            pose = shape_pose(world.state.bodies[b], parameters.bodies[b], parameters.shapes[s])
            lower, _ = bounding_box(world.model.shapes[s], parameters.shapes[s], parameters.vertices, pose)
            low = min(low, lower[1])
    return low


@njit
def _lie(world, lying, draws):  # type: ignore[no-untyped-def]
    """Lay the figure down as one of the falls left it, at rest on its lowest point."""
    world.task.state.getting_up = 1
    pose = lying[int(draws[JOINTS] * len(lying))]
    _place_figure(world, 0.0, 0.0, pose[0], 0.0, pose[1:])
    _place_figure(world, 0.0, -_lowest_point(world), pose[0], 0.0, pose[1:])


@njit
def initialize_world(world, most, getting_up, assist, lying, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: the figure stands with bent knees, nearly at rest, with one foot on the ground, or lies."""
    _apply_physics(world)
    world.task.state.assist = assist
    shared.plan_pushes(world.task.state, most, draws[JOINTS + 2 :])
    if getting_up:
        _lie(world, lying, draws)
    else:
        _stand(world, draws)
    world.task.state.gaze = world.state.bodies[_PELVIS].position[0]


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, axis) to the drives, and the pushes; return -1, or the first world with a bad action."""
    bad = first_not_finite(actions)
    if bad >= 0:
        return bad
    for w in range(len(actions)):
        select_world(world, w)
        task = world.task.state
        delay = world.task.physics[_DELAY]
        if task.getting_up != 0:
            shared.act(task, world.state.control, actions[w], _STAND, _BELOW, _ABOVE, delay)
            world.state.bodies[_TORSO].force[1] += shared.assist_force(task, -world.parameters.world.gravity[1])
        else:
            shared.act(task, world.state.control, actions[w], _STAND, _SPAN, _SPAN, delay)
        shared.begin_push(task)
        world.state.bodies[_PELVIS].force[0] += shared.push_force(task)
    return -1


# ---------------------------------------------------------------- evaluate


@njit
def _crown(world):  # type: ignore[no-untyped-def]
    """Return the height in m of the top of the head."""
    return point_of(world.state.bodies[_TORSO], world.parameters.bodies[_TORSO], 0.0, _CROWN)[1]


@njit
def mass_motion(world):  # type: ignore[no-untyped-def]
    """Return place (x, y) in m and velocity (vx, vy) in m/s of the figure's centre of mass."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    x, y, vx, vy, mass = 0.0, 0.0, 0.0, 0.0, 0.0
    for b in range(_FIRST, _BODIES):
        m = parameters[b].mass
        x += m * bodies[b].position[0]
        y += m * bodies[b].position[1]
        vx += m * bodies[b].velocity[0]
        vy += m * bodies[b].velocity[1]
        mass += m
    return x / mass, y / mass, vx / mass, vy / mass


@njit
def _joint_angle(bodies, j):  # type: ignore[no-untyped-def]
    return bodies[_CHILDREN[j]].angle - bodies[_PARENTS[j]].angle


@njit
def _posture(bodies):  # type: ignore[no-untyped-def]
    """Return the sum of the squares of the axes' deviations from the stand, rad^2."""
    total = 0.0
    for j in range(ACTIONS):
        off = _joint_angle(bodies, j) - _STAND[j]
        total += off * off
    return total


@njit
def _show_push(world):  # type: ignore[no-untyped-def]
    """Move the arrow to the hips while a push is shown; it grows to its length and then withdraws."""
    task, bodies = world.task.state, world.state.bodies
    if task.pushed >= SHOWN_STEPS:
        if bodies[_ARROW].position[1] != _PARKED_Y:
            _place(world, _ARROW, _PARKED_X, _PARKED_Y, 0.0, 0.0)
        return
    half = 0.5 * _ARROW_LENGTH * abs(task.push)
    shaft = world.parameters.shapes[1]  # the ground's is the first
    shaft.size[0] = half
    shaft.local_position[0] = -0.9 * _ARROW_HEAD - half
    side = 1.0 if task.push >= 0.0 else -1.0
    back = 0.015 * max(task.pushed - PUSH_STEPS, 0)
    x = bodies[_PELVIS].position[0] - side * (_ARROW_GAP + back)
    _place(world, _ARROW, x, bodies[_PELVIS].position[1], 0.0 if side > 0.0 else math.pi, 0.0)


@njit
def _stride(world):  # type: ignore[no-untyped-def]
    """Return the distance in m between the ankles along the ground."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    near = point_of(bodies[_NEAR_FOOT], parameters[_NEAR_FOOT], 0.0, 0.0)[0]
    far = point_of(bodies[_FAR_FOOT], parameters[_FAR_FOOT], 0.0, 0.0)[0]
    return abs(near - far)


@njit
def evaluate_world(world, timestep):  # type: ignore[no-untyped-def]
    """Set reward terms and info of one world after a control step; return (reward, terminated)."""
    task, term, info, bodies = world.task.state, world.task.terms, world.task.info, world.state.bodies
    task.steps += 1
    _, _, vx, _ = mass_motion(world)
    height = _crown(world) / _STAND_HEIGHT
    hips = point_of(bodies[_PELVIS], world.parameters.bodies[_PELVIS], 0.0, 0.0)[1] / _HIPS_HEIGHT
    upright = bodies[_TORSO].rotation[0]
    _, _, others = shared.foot_loads(active_contacts(world), _FEET, timestep)
    tilt = max(abs(bodies[_TORSO].angle), abs(bodies[_PELVIS].angle))
    balances = task.getting_up == 0
    fell = balances and (height < FALL_HEIGHT or tilt > FALL_TILT or others)
    stride = _stride(world)
    if balances:
        task.apart = max(task.apart + (CONTROL_TIME if stride > APART else -CONTROL_TIME), 0.0)
    else:
        shared.count_stood(task, height, upright, others)
    failed = fell or task.apart > MOST_APART
    effort = shared.effort(world.state.joints, _ACTUATED, _SPRING_SLOT, _EFFORT, timestep)
    shared.write_terms(task, term, (height, hips, upright, vx * vx, _posture(bodies), effort), failed)
    term.apart = APART_WEIGHT * min(max(stride - FREE_STRIDE, 0.0) / STRIDE, 1.0) if balances else 0.0
    shared.write_info(task, info, fell, failed)
    task.gaze += 0.12 * (bodies[_PELVIS].position[0] - task.gaze)
    _show_push(world)
    return term.stand + term.posture + term.apart + term.smoothness + term.effort + term.fall, failed


# ---------------------------------------------------------------- observe


@njit
def _support(world, near_load, far_load):  # type: ignore[no-untyped-def]
    """Return x in m of the middle of the soles that stand on the ground, of both where none does."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    low, high = math.inf, -math.inf
    flying = near_load + far_load <= 0.0
    for k in range(2):
        if flying or (near_load if k == 0 else far_load) > 0.0:
            b = _NEAR_FOOT if k == 0 else _FAR_FOOT
            heel = point_of(bodies[b], parameters[b], _HEEL, -_ANKLE)[0]
            toe = point_of(bodies[b], parameters[b], _TOE, -_ANKLE)[0]
            low = min(low, min(heel, toe))
            high = max(high, max(heel, toe))
    return 0.5 * (low + high)


@njit
def _observe_joints(task, bodies, out):  # type: ignore[no-untyped-def]
    """Write angles from the stand and rates of all joints, and the last action; return the next place."""
    place = 0
    for j in range(JOINTS):
        out[place + j] = _joint_angle(bodies, j) - _STAND[j]
        rate = bodies[_CHILDREN[j]].velocity[2] - bodies[_PARENTS[j]].velocity[2]
        out[place + JOINTS + j] = rate / 10.0
    place += 2 * JOINTS
    for a in range(ACTIONS):
        out[place + a] = task.action[a]
    return place + ACTIONS


@njit
def observe_world(world, timestep):  # type: ignore[no-untyped-def]
    """Write all observations of a world, clipped to their bounds."""
    task, out, bodies = world.task.state, world.task.observation, world.state.bodies
    near, far, _ = shared.foot_loads(active_contacts(world), _FEET, timestep)
    x, y, vx, vy = mass_motion(world)
    support = _support(world, near, far)
    weight = task.mass * -world.parameters.world.gravity[1]
    out[0] = 5.0 * (_crown(world) / _STAND_HEIGHT - 1.0)
    out[1] = bodies[_PELVIS].rotation[1]
    out[2] = bodies[_TORSO].rotation[1]
    out[3] = bodies[_PELVIS].velocity[2] / 5.0
    out[4] = vx
    out[5] = vy
    out[6] = (x - support) / 0.2
    out[7] = (x + vx * math.sqrt(max(y, 0.1) / scene.GRAVITY) - support) / 0.2
    out[8] = near / weight
    out[9] = far / weight
    for k in range(2):
        foot = bodies[_NEAR_FOOT if k == 0 else _FAR_FOOT]
        out[10 + 3 * k] = (foot.position[0] - x) / 0.5
        out[11 + 3 * k] = foot.position[1] / 0.2
        out[12 + 3 * k] = foot.rotation[1]
    if len(out) == _BALANCE_ENTRIES:
        out[16] = task.apart / MOST_APART
        _observe_joints(task, bodies, out[17:])
    else:  # where the figure may lie, the sines do not tell its tilt
        end = 16 + _observe_joints(task, bodies, out[16:])
        out[end] = bodies[_PELVIS].rotation[0]
        out[end + 1] = bodies[_TORSO].rotation[0]
    clip(out, world.task.low, world.task.high)


# ---------------------------------------------------------------- all worlds


@njit
def initialize_worlds(world, worlds, most, getting_up, assist, lying, draws, timestep):  # type: ignore[no-untyped-def]
    """Begin episodes in chosen worlds; `draws` is (chosen world, number), uniform in [0, 1); `lying`: lying_poses."""
    for i in range(len(worlds)):
        select_world(world, worlds[i])
        initialize_world(world, most, getting_up, assist, lying, draws[i])
        observe_world(world, timestep)


@njit
def evaluate_worlds(world, timestep):  # type: ignore[no-untyped-def]
    """Set rewards, terminations and observations of all worlds."""
    rewards, terminated = world.task.rewards, world.task.terminated
    for w in range(len(rewards)):
        select_world(world, w)
        rewards[w], terminated[w] = evaluate_world(world, timestep)
        observe_world(world, timestep)
