"""GRagdoll's kernels: initialize, apply actions, evaluate, observe. The docstring of RagdollEnv states the rules.

`figure` has the tables of figure.py. x points forwards, y to the left, z up.
"""

from __future__ import annotations

import math
from typing import Any

from gsenv.envs.core.kernels import active_contacts, between, clip, first_not_finite
from gsenv.envs.ragdoll import scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.shared_rules import (
    FALL_HEIGHT,
    FALL_TILT,
    PUSH_STEPS,
    PUSHES,
    SHOWN_STEPS,
)
from gsenv.solver.core.edit import place_body, set_mass
from gsenv.solver.core.trig import sin_cos
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import select_world
from gsenv.solver.spatial.geometry import bounding_box, shape_place
from gsenv.solver.spatial.joints.axes import FIRST_TURN, NODE_TURN, turn_coordinate, turn_direction
from gsenv.solver.spatial.math import (
    add,
    conjugate,
    dot,
    multiply,
    normalised,
    pose_of,
    quaternion,
    scaled,
    sub,
    turn_about,
    turn_of,
    turned,
    vec,
)

ACTIONS = scene.AXIS_COUNT
DRAW_COUNT = ACTIONS + 4 + shared.PUSH_DRAWS + PUSHES

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    *shared.task_state_fields(ACTIONS),
    ("headings", "f8", (PUSHES,)),  # rad, of each push
    ("heading", "f8"),  # rad, of the last push
    ("angles", "f8", (ACTIONS,)),  # rad, from the stand
    ("rates", "f8", (ACTIONS,)),  # rad/s
    ("gaze", "f8", (2,)),  # m, where the camera looks
]

START_ANGLE = 0.04  # rad, largest deviation of a joint from the stand at the start
START_TILT = 0.02  # rad
START_HEADING = -0.5 * math.pi  # towards the camera and its sun
START_SPEED = 0.1  # m/s

_MOST_TILTED = math.cos(FALL_TILT)
_TILT = scene.STAND_TILT
_STAND_HEIGHT, _HIPS_HEIGHT = scene.STAND_HEIGHT, scene.HIPS_HEIGHT
_HEEL, _TOE, _ANKLE, _CROWN = scene.HEEL, scene.TOE, scene.ANKLE, scene.CROWN
_HALF_SOLE = scene.HALF_SOLE
_HAND = scene.HAND
_ARROW_LENGTH, _ARROW_GAP, _PARKED = scene.ARROW_LENGTH, scene.ARROW_GAP, scene.PARKED
_SPRING_SLOT = 8  # of a joint's impulses
_FRICTION, _TRUNK, _LEG, _STRENGTH, _DELAY = range(5)  # of BalanceTask.quantities
_GRAVITY = 9.81
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_STILL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


# ---------------------------------------------------------------- initialize


@njit
def _apply_physics(world, figure):  # type: ignore[no-untyped-def]
    """Write the quantities of the episode, in the order of BalanceTask.quantities, to a world's parameters."""
    physics, parameters = world.task.physics, world.parameters
    for s in range(len(parameters.shapes)):
        parameters.shapes[s].friction = physics[_FRICTION]
    mass = 0.0
    for b in range(figure.parts.first, figure.parts.last + 1):
        body = parameters.bodies[b]
        set_mass(body, physics[_LEG if figure.legs[b] else _TRUNK] * body.mass)
        mass += body.mass
    world.task.state.mass = mass
    for a in range(ACTIONS):
        parameters.joints[figure.joints[a]].spring_effort = physics[_STRENGTH] * figure.bounds[a]


@njit
def _place(world, b, at, turn, velocity):  # type: ignore[no-untyped-def]
    place_body(b, world.state.bodies, world.parameters.bodies, active_contacts(world), at, turn, velocity)


@njit
def point_of(world, b, point):  # type: ignore[no-untyped-def]
    """Return where a point (x, y, z) in m of a body's own frame is in the world."""
    body = world.state.bodies[b]
    local = sub(point, vec(world.parameters.bodies[b].center))
    return add(vec(body.position), turned(quaternion(body.rotation), local))


@njit
def _frame_in_b(joint):  # type: ignore[no-untyped-def]
    """Return the rotation of a joint's axes in body b."""
    return multiply(conjugate(quaternion(joint.reference)), quaternion(joint.frame))


@njit
def _axis_of(turn):  # type: ignore[no-untyped-def]
    return _X if turn == FIRST_TURN else _Y if turn == NODE_TURN else _Z


@njit
def _place_figure(world, figure, hips, turn, velocity):  # type: ignore[no-untyped-def]
    """Place the figure, the hips at a point in m, the pelvis rotated; all bodies have one velocity.

    Its joints are off the stand by the angles of the task state.
    """
    _place(world, figure.parts.pelvis, hips, turn, velocity)
    for n in range(len(figure.links)):
        link = figure.links[n]
        joint = world.parameters.joints[link.joint]
        rotation = multiply(quaternion(world.state.bodies[link.parent].rotation), quaternion(joint.frame))
        for a in range(link.first, link.first + link.count):
            axis = figure.axes[a]
            angle = figure.stand[a] + world.task.state.angles[a]
            rotation = multiply(rotation, turn_about(_axis_of(axis.turn), axis.sign * angle))
        rotation = multiply(rotation, conjugate(_frame_in_b(joint)))
        anchor = point_of(world, link.parent, vec(joint.anchor_a))
        _place(world, link.body, sub(anchor, turned(rotation, vec(joint.anchor_b))), rotation, velocity)


@njit
def _corner(k):  # type: ignore[no-untyped-def]
    """Return one of the four corners of a sole in m from the ankle."""
    return _TOE if k < 2 else _HEEL, _HALF_SOLE if k % 2 == 0 else -_HALF_SOLE, -_ANKLE


@njit
def _lowest_sole(world, figure):  # type: ignore[no-untyped-def]
    low = math.inf
    for foot in range(2):
        for k in range(4):
            low = min(low, point_of(world, figure.parts.feet[foot], _corner(k))[2])
    return low


@njit
def _stand(world, figure, draws, own):  # type: ignore[no-untyped-def]
    """Place the figure on its feet with bent knees, nearly at rest, with one foot on the ground."""
    tilt = (between(-START_TILT, START_TILT, own[0]), between(-START_TILT, START_TILT, own[1]) - _TILT, 0.0)
    vx, vy = between(-START_SPEED, START_SPEED, own[2]), between(-START_SPEED, START_SPEED, own[3])
    velocity = (vx, vy, 0.0, 0.0, 0.0, 0.0)
    turn = multiply(turn_about(_Z, START_HEADING), turn_of(tilt))
    for a in range(ACTIONS):
        world.task.state.angles[a] = between(-START_ANGLE, START_ANGLE, draws[a])
    _place_figure(world, figure, (0.0, 0.0, 0.0), turn, velocity)
    _place_figure(world, figure, (0.0, 0.0, -_lowest_sole(world, figure)), turn, velocity)


@njit
def _lowest_point(world, figure):  # type: ignore[no-untyped-def]
    """Return the height in m of the figure's lowest point."""
    parameters, low = world.parameters, math.inf
    for s in range(len(world.model.shapes)):
        b = world.model.shapes[s].body
        if figure.parts.first <= b <= figure.parts.last and world.model.shapes[s].mask != 0:
            at, turn = shape_place(world.state.bodies[b], parameters.bodies[b], parameters.shapes[s])
            lower, _ = bounding_box(world.model.shapes[s], parameters.shapes[s], parameters.vertices, pose_of(at, turn))
            low = min(low, lower[2])
    return low


@njit
def _lie(world, figure, own):  # type: ignore[no-untyped-def]
    """Lay the figure down as one of the falls left it, turned about the vertical, at rest on its lowest point."""
    task = world.task.state
    task.getting_up = 1
    pose = figure.lying[int(own[1] * len(figure.lying))]
    turn = multiply(turn_about(_Z, math.pi * between(-1.0, 1.0, own[0])), normalised(quaternion(pose)))
    for a in range(ACTIONS):
        task.angles[a] = pose[4 + a]
    _place_figure(world, figure, (0.0, 0.0, 0.0), turn, _STILL)
    _place_figure(world, figure, (0.0, 0.0, -_lowest_point(world, figure)), turn, _STILL)


@njit
def initialize_world(world, figure, most, getting_up, assist, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: the figure stands, or lies where it is to get up."""
    task = world.task.state
    _apply_physics(world, figure)
    task.assist = assist
    own = draws[ACTIONS:]
    shared.plan_pushes(task, most, own[4:])
    for k in range(PUSHES):
        task.headings[k] = math.pi * own[4 + shared.PUSH_DRAWS + k]
    if getting_up:
        _lie(world, figure, own)
    else:
        _stand(world, figure, draws, own)
    task.gaze[0] = world.state.bodies[figure.parts.pelvis].position[0]
    task.gaze[1] = world.state.bodies[figure.parts.pelvis].position[1]


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, figure, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, axis) to the drives, and the pushes; return -1, or the first world with a bad action."""
    bad = first_not_finite(actions)
    if bad >= 0:
        return bad
    for w in range(len(actions)):
        select_world(world, w)
        task = world.task.state
        delay = world.task.physics[_DELAY]
        if task.getting_up != 0:
            shared.act(task, world.state.control, actions[w], figure.stand, figure.below, figure.above, delay)
            world.state.bodies[figure.parts.torso].force[2] += shared.assist_force(task, _GRAVITY)
        else:
            shared.act(task, world.state.control, actions[w], figure.stand, figure.span, figure.span, delay)
        shared.begin_push(task)
        if task.pushed == 0:
            task.heading = task.headings[(task.push_count - 1) % PUSHES]
        c, s = sin_cos(task.heading)
        force = shared.push_force(task)
        pelvis = world.state.bodies[figure.parts.pelvis]
        pelvis.force[0] += c * force
        pelvis.force[1] += s * force
    return -1


# ---------------------------------------------------------------- evaluate


@njit
def mass_motion(world, figure):  # type: ignore[no-untyped-def]
    """Return place in m and velocity in m/s of the figure's centre of mass."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    at, velocity, mass = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    for b in range(figure.parts.first, figure.parts.last + 1):
        m = parameters[b].mass
        at = add(at, scaled(vec(bodies[b].position), m))
        velocity = add(velocity, scaled(vec(bodies[b].velocity), m))
        mass += m
    return scaled(at, 1.0 / mass), scaled(velocity, 1.0 / mass)


@njit
def _read_joints(world, figure):  # type: ignore[no-untyped-def]
    """Write angles from the stand and rates of all joints to the task state."""
    task, bodies = world.task.state, world.state.bodies
    for n in range(len(figure.links)):
        link = figure.links[n]
        joint = world.parameters.joints[link.joint]
        parent, child = bodies[link.parent], bodies[link.body]
        on_a = multiply(quaternion(parent.rotation), quaternion(joint.frame))
        on_b = multiply(quaternion(child.rotation), _frame_in_b(joint))
        spin = sub(vec(child.velocity[3:]), vec(parent.velocity[3:]))
        for a in range(link.first, link.first + link.count):
            axis = figure.axes[a]
            task.angles[a] = axis.sign * turn_coordinate(axis.turn, on_a, on_b) - figure.stand[a]
            task.rates[a] = axis.sign * dot(turn_direction(axis.turn, on_a, on_b), spin)


@njit
def _posture(task):  # type: ignore[no-untyped-def]
    """Return the sum of the squares of the joints' deviations from the stand, rad^2."""
    total = 0.0
    for a in range(ACTIONS):
        total += task.angles[a] * task.angles[a]
    return total


@njit
def _upright(world, b):  # type: ignore[no-untyped-def]
    """Return the cosine of the tilt of a body."""
    q = world.state.bodies[b].rotation
    return 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2])


@njit
def _show_push(world, figure):  # type: ignore[no-untyped-def]
    """Move the arrow to the hips while a push is shown; it grows to its length and then withdraws."""
    task, parts = world.task.state, figure.parts
    if task.pushed >= SHOWN_STEPS:
        if world.state.bodies[parts.arrow].position[2] != _PARKED[2]:
            _place(world, parts.arrow, _PARKED, (1.0, 0.0, 0.0, 0.0), _STILL)
        return
    half = 0.5 * _ARROW_LENGTH * abs(task.push)
    shaft = world.parameters.shapes[parts.shaft]
    shaft.size[2] = half
    shaft.local_position[0] = -half
    heading = task.heading if task.push >= 0.0 else task.heading + math.pi
    c, s = sin_cos(heading)
    away = _ARROW_GAP + 0.015 * max(task.pushed - PUSH_STEPS, 0)
    hips = vec(world.state.bodies[parts.pelvis].position)
    _place(world, parts.arrow, sub(hips, (away * c, away * s, 0.0)), turn_about(_Z, heading), _STILL)


@njit
def evaluate_world(world, figure, timestep):  # type: ignore[no-untyped-def]
    """Set reward terms and info of one world after a control step; return (reward, terminated)."""
    task, term, parts = world.task.state, world.task.terms, figure.parts
    task.steps += 1
    _read_joints(world, figure)
    _, velocity = mass_motion(world, figure)
    height = point_of(world, parts.torso, (0.0, 0.0, _CROWN))[2] / _STAND_HEIGHT
    hips = point_of(world, parts.pelvis, (0.0, 0.0, 0.0))[2] / _HIPS_HEIGHT
    upright = _upright(world, parts.torso)
    _, _, others = shared.foot_loads(active_contacts(world), parts.feet, timestep)
    tilted = min(upright, _upright(world, parts.pelvis)) < _MOST_TILTED
    fell = task.getting_up == 0 and (height < FALL_HEIGHT or tilted or others)
    if task.getting_up != 0:
        shared.count_stood(task, height, upright, others)
    square = velocity[0] * velocity[0] + velocity[1] * velocity[1]
    effort = shared.effort(world.state.joints, figure.joints, _SPRING_SLOT, figure.bounds, timestep)
    shared.write_terms(task, term, (height, hips, upright, square, _posture(task), effort), fell)
    shared.write_info(task, world.task.info, fell, fell)
    hips = world.state.bodies[parts.pelvis].position
    for d in range(2):
        task.gaze[d] += 0.12 * (hips[d] - task.gaze[d])
    _show_push(world, figure)
    return term.stand + term.posture + term.smoothness + term.effort + term.fall, fell


# ---------------------------------------------------------------- observe


@njit
def _heading_frame(q):  # type: ignore[no-untyped-def]
    """Return cosine and sine of the heading of a rotation: of its x axis, seen from above."""
    x = turned(q, _X)
    length = math.sqrt(x[0] * x[0] + x[1] * x[1])
    return (x[0] / length, x[1] / length) if length > 1e-6 else (1.0, 0.0)


@njit
def _support(world, figure, loads):  # type: ignore[no-untyped-def]
    """Return (x, y) in m of the middle of the soles that stand on the ground, of both where none does."""
    x, y, count = 0.0, 0.0, 0.0
    flying = loads[0] + loads[1] <= 0.0
    for foot in range(2):
        if flying or loads[foot] > 0.0:
            middle = point_of(world, figure.parts.feet[foot], (0.5 * (_TOE + _HEEL), 0.0, -_ANKLE))
            x += middle[0]
            y += middle[1]
            count += 1.0
    return x / count, y / count


@njit
def _write_level(out, place, x, y, frame):  # type: ignore[no-untyped-def]
    """Write a level vector in the heading frame."""
    out[place] = frame[0] * x + frame[1] * y
    out[place + 1] = frame[0] * y - frame[1] * x


@njit
def _observe_trunk(world, figure, out, frame):  # type: ignore[no-untyped-def]
    """Write entries 0 to 9 but for the velocity: height, gravity in the pelvis, spin."""
    pelvis = world.state.bodies[figure.parts.pelvis]
    out[0] = 5.0 * (point_of(world, figure.parts.torso, (0.0, 0.0, _CROWN))[2] / _STAND_HEIGHT - 1.0)
    down = turned(conjugate(quaternion(pelvis.rotation)), (0.0, 0.0, -1.0))
    for d in range(3):
        out[1 + d] = down[d]
    _write_level(out, 7, pelvis.velocity[3] / 5.0, pelvis.velocity[4] / 5.0, frame)
    out[9] = pelvis.velocity[5] / 5.0


@njit
def _observe_limbs(world, figure, out, at, frame):  # type: ignore[no-untyped-def]
    """Write entries 16 to 27: feet and hands from the centre of mass `at`, m."""
    for k in range(4):
        limb = figure.parts.feet[k] if k < 2 else figure.parts.hands[k - 2]
        point = point_of(world, limb, (0.0, 0.0, -_ANKLE) if k < 2 else _HAND)
        _write_level(out, 16 + 3 * k, (point[0] - at[0]) / 0.5, (point[1] - at[1]) / 0.5, frame)
        out[18 + 3 * k] = point[2] / 0.2 if k < 2 else (point[2] - at[2]) / 0.5


@njit
def observe_world(world, figure, timestep):  # type: ignore[no-untyped-def]
    """Write all observations of a world, clipped to their bounds."""
    task, out = world.task.state, world.task.observation
    first, second, _ = shared.foot_loads(active_contacts(world), figure.parts.feet, timestep)
    at, velocity = mass_motion(world, figure)
    frame = _heading_frame(quaternion(world.state.bodies[figure.parts.pelvis].rotation))
    x, y = _support(world, figure, (first, second))
    _observe_trunk(world, figure, out, frame)
    _write_level(out, 4, velocity[0], velocity[1], frame)
    out[6] = velocity[2]
    rest = math.sqrt(max(at[2], 0.1) / _GRAVITY)
    _write_level(out, 10, (at[0] - x) / 0.2, (at[1] - y) / 0.2, frame)
    _write_level(out, 12, (at[0] + rest * velocity[0] - x) / 0.2, (at[1] + rest * velocity[1] - y) / 0.2, frame)
    weight = task.mass * _GRAVITY
    out[14] = first / weight
    out[15] = second / weight
    _observe_limbs(world, figure, out, at, frame)
    for a in range(ACTIONS):
        out[28 + a] = task.angles[a]
        out[28 + ACTIONS + a] = task.rates[a] / 10.0
        out[28 + 2 * ACTIONS + a] = task.action[a]
    clip(out, world.task.low, world.task.high)


# ---------------------------------------------------------------- all worlds


@njit
def initialize_worlds(world, figure, worlds, most, getting_up, assist, draws, timestep):  # type: ignore[no-untyped-def]
    """Begin episodes in chosen worlds; `draws` is (chosen world, number), uniform in [0, 1)."""
    for i in range(len(worlds)):
        select_world(world, worlds[i])
        initialize_world(world, figure, most, getting_up, assist, draws[i])
        _read_joints(world, figure)
        observe_world(world, figure, timestep)


@njit
def evaluate_worlds(world, figure, timestep):  # type: ignore[no-untyped-def]
    """Set rewards, terminations and observations of all worlds."""
    rewards, terminated = world.task.rewards, world.task.terminated
    for w in range(len(rewards)):
        select_world(world, w)
        rewards[w], terminated[w] = evaluate_world(world, figure, timestep)
        observe_world(world, figure, timestep)
