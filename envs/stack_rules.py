"""GStack's jitted passes: start, act, judge. The rules are in the docstring of stack.StackEnv."""

from __future__ import annotations

import math
from typing import Any

from gsenv.envs import stack_scene as scene
from gsenv.solver.jit import njit
from gsenv.solver.planar.math import sin_cos

RECORD_FIELDS: list[tuple[Any, ...]] = [
    ("blocks", "i8"),  # levels of the goal
    ("arrived", "i8"),  # blocks that are or were in the gripper
    ("held", "i8"),  # block in the gripper, or -1
    ("placed", "i8"),  # blocks that came to rest at their level
    ("stand", "i8"),  # control steps that the released blocks have stood
    ("distance", "f8"),  # to go, as the approach term sees it; negative: not yet known
    ("effort", "f8"),  # mean square of the last action
]

DRAWS_PER_BLOCK = 6
DRAW_COUNT = 2 + DRAWS_PER_BLOCK * scene.MAX_BLOCKS
CONTROL_TIME = 1.0 / 30.0  # s

REST_SPEED = 0.08  # m/s, and rad/s half as much again: what counts as standing
TOUCH = 1e-3  # m, nearer counts as touching
TIPPED = 0.5  # rad
SUNK = 0.5  # of its half-height: a block this far below its level has fallen
STAND_STEPS = 30
ARRIVAL_MARGIN = 0.05  # m, free space around an arriving block

PLACED_REWARD = 1.0
SUCCESS_REWARD = 5.0
FALL_REWARD = -2.0
EFFORT_WEIGHT = -0.002
APPROACH_WEIGHT = 0.5  # per m
TILT_WEIGHT = 0.5  # m per rad, in the distance of the approach

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.GRIPPER_BODY
_GROUND = scene.GROUND_BODY
_MAST = scene.MAST_BODY
_DRIVE = scene.DRIVE_JOINT
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_LIFT = scene.MAGNET_RADIUS + scene.GAP
_SPEED = scene.SPEED
_TURN_SPEED = scene.TURN_SPEED
_REACH_X = scene.REACH_X
_LOW_Y, _HIGH_Y = scene.REACH_Y
_REACH_ANGLE = scene.REACH_ANGLE
_START_X = scene.START_X
_START_Y, _START_TOP = scene.START_Y
_WIDTH, _WIDTH_TOP = scene.HALF_WIDTH
_HEIGHT, _HEIGHT_TOP = scene.HALF_HEIGHT
_DENSITY, _DENSITY_TOP = scene.DENSITY
_FRICTION, _FRICTION_TOP = scene.FRICTION
_OFFSET = scene.GRASP_OFFSET
_TILT = scene.GRASP_TILT
_MAST_LENGTH = scene.MAST_HALF_LENGTH
_MAX_FORCE = scene.MAX_FORCE
_MAX_TORQUE = scene.MAX_TORQUE


# ---------------------------------------------------------------- start


@njit
def _between(low, high, draw):  # type: ignore[no-untyped-def]
    return low + (high - low) * draw


@njit
def _make_block(k, draws, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Size, mass, friction and grasp of block k from its draws."""
    first = 2 + DRAWS_PER_BLOCK * k
    x = _between(_WIDTH, _WIDTH_TOP, draws[first])
    y = _between(_HEIGHT, _HEIGHT_TOP, draws[first + 1])
    density = _between(_DENSITY, _DENSITY_TOP, draws[first + 2])
    shape = shape_parameters[_SHAPE + k]
    shape.size[0] = x
    shape.size[1] = y
    shape.extent = min(x, y)
    shape.density = density
    shape.friction = _between(_FRICTION, _FRICTION_TOP, draws[first + 3])
    body = body_parameters[_BLOCK + k]
    body.mass = 4.0 * x * y * density
    body.inertia = body.mass * (x * x + y * y) / 3.0
    body.extent = min(x, y)
    body.radius = math.sqrt(x * x + y * y)
    c, s = sin_cos(_between(-_TILT, _TILT, draws[first + 5]))
    weld = joint_parameters[_WELD + k]
    weld.reference[0] = c
    weld.reference[1] = s
    # The magnet is round: it meets the block's tilted top where the top's normal points at it.
    weld.anchor_a[0] = _LIFT * s
    weld.anchor_a[1] = -_LIFT * c
    weld.anchor_b[0] = _between(-_OFFSET, _OFFSET, draws[first + 4]) * x
    weld.anchor_b[1] = y


@njit
def _grasp_pose(k, bodies, joint_parameters):  # type: ignore[no-untyped-def]
    """(x, y, cos, sin) of block k in the gripper."""
    gripper = bodies[_GRIPPER]
    weld = joint_parameters[_WELD + k]
    gc, gs = gripper.rotation[0], gripper.rotation[1]
    c = gc * weld.reference[0] - gs * weld.reference[1]
    s = gs * weld.reference[0] + gc * weld.reference[1]
    x = gripper.position[0] + gc * weld.anchor_a[0] - gs * weld.anchor_a[1]
    y = gripper.position[1] + gs * weld.anchor_a[0] + gc * weld.anchor_a[1]
    x -= c * weld.anchor_b[0] - s * weld.anchor_b[1]
    y -= s * weld.anchor_b[0] + c * weld.anchor_b[1]
    return x, y, c, s


@njit
def _hand_over(record, k, bodies, body_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Block k appears in the gripper and moves with it."""
    x, y, c, s = _grasp_pose(k, bodies, joint_parameters)
    gripper = bodies[_GRIPPER]
    block = bodies[_BLOCK + k]
    block.position[0] = x
    block.position[1] = y
    block.rotation[0] = c
    block.rotation[1] = s
    weld = joint_parameters[_WELD + k]
    block.angle = gripper.angle + math.asin(weld.reference[1])
    spin = gripper.velocity[2]
    block.velocity[0] = gripper.velocity[0] - spin * (y - gripper.position[1])
    block.velocity[1] = gripper.velocity[1] + spin * (x - gripper.position[0])
    block.velocity[2] = spin
    block.asleep = 0
    block.sleep_time = 0.0
    body = body_parameters[_BLOCK + k]
    body.enabled = 1
    body.inv_mass = 1.0 / body.mass
    body.inv_inertia = 1.0 / body.inertia
    weld.enabled = 1
    record.held = k
    record.arrived = k + 1
    record.distance = -1.0


@njit
def start_worlds(  # type: ignore[no-untyped-def]
    worlds, draws, blocks, records, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states,
):  # fmt: skip
    """Episodes begin: the gripper at a drawn place, the first block in it."""
    for i in range(len(worlds)):
        w = worlds[i]
        gripper = bodies[w, _GRIPPER]
        gripper.position[0] = _between(-_START_X, _START_X, draws[i, 0])
        gripper.position[1] = _between(_START_Y, _START_TOP, draws[i, 1])
        drive = joint_states[w, _DRIVE]
        drive.target_position[0] = gripper.position[0]
        drive.target_position[1] = gripper.position[1]
        for k in range(_MAX_BLOCKS):
            _make_block(k, draws[i], body_parameters[w], shape_parameters[w], joint_parameters[w])
        record = records[w]
        record.blocks = blocks
        _hand_over(record, 0, bodies[w], body_parameters[w], joint_parameters[w])
        _move_mast(bodies[w])


# ---------------------------------------------------------------- act


@njit
def _within(speed, limit, here, low, high):  # type: ignore[no-untyped-def]
    """A speed that leaves the range [low, high] no further than it is already."""
    speed = min(speed, max((high - here) / CONTROL_TIME, 0.0))
    speed = max(speed, min((low - here) / CONTROL_TIME, 0.0))
    return min(max(speed, -limit), limit)


@njit
def act(actions, records, control, joint_parameters, joint_states):  # type: ignore[no-untyped-def]
    """Actions to the drive and the magnet; -1, or the first world whose actions are not finite."""
    for w in range(len(actions)):
        for a in range(4):
            if not math.isfinite(actions[w, a]):
                return w
    for w in range(len(actions)):
        record = records[w]
        record.effort = 0.0
        for a in range(4):
            actions[w, a] = min(max(actions[w, a], -1.0), 1.0)
            if a < 3:
                record.effort += actions[w, a] * actions[w, a] / 3.0
        drive = joint_states[w, _DRIVE]
        place = drive.target_position
        x = _SPEED * actions[w, 0]
        y = _SPEED * actions[w, 1]
        turn = _TURN_SPEED * actions[w, 2]
        control[w, 0] = _within(x, _SPEED, place[0], -_REACH_X, _REACH_X)
        control[w, 1] = _within(y, _SPEED, place[1], _LOW_Y, _HIGH_Y)
        control[w, 2] = _within(turn, _TURN_SPEED, drive.target_angle, -_REACH_ANGLE, _REACH_ANGLE)
        if actions[w, 3] > 0.0 and record.held >= 0:
            joint_parameters[w, _WELD + record.held].enabled = 0
            record.held = -1
            record.stand = 0
            record.distance = -1.0
    return -1


# ---------------------------------------------------------------- judge


@njit
def _touches(contacts, count):  # type: ignore[no-untyped-def]
    """Bit masks of the blocks: (resting on the level below, touched by the gripper)."""
    resting = 0
    gripped = 0
    for i in range(count):
        contact = contacts[i]
        if contact.total_impulse[0] <= 0.0 and contact.separation > TOUCH:
            continue
        a = min(contact.body_a, contact.body_b)
        b = max(contact.body_a, contact.body_b)
        if b < _BLOCK:
            continue
        if a == _GRIPPER:
            gripped |= 1 << (b - _BLOCK)
        elif (a == _GROUND and b == _BLOCK) or (a >= _BLOCK and b == a + 1):
            resting |= 1 << (b - _BLOCK)
    return resting, gripped


@njit
def _calm(body):  # type: ignore[no-untyped-def]
    v = body.velocity
    return v[0] * v[0] + v[1] * v[1] < REST_SPEED**2 and abs(v[2]) < 1.5 * REST_SPEED


@njit
def _standing(first, last, resting, gripped, bodies):  # type: ignore[no-untyped-def]
    """Whether blocks first..last-1 rest at their levels, slow, and the gripper off them."""
    for k in range(first, last):
        bit = 1 << k
        if resting & bit == 0 or gripped & bit != 0 or not _calm(bodies[_BLOCK + k]):
            return False
    return True


@njit
def _any_fallen(released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """Whether a released block has tipped or sunk below its level."""
    below = 0.0
    for k in range(released):
        half = shape_parameters[_SHAPE + k].size[1]
        block = bodies[_BLOCK + k]
        if abs(block.angle) > TIPPED or block.position[1] < below + half - SUNK * half:
            return True
        below += 2.0 * half
    return False


@njit
def _vertical_reach(k, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """m, half the height that block k takes up as it is turned."""
    rotation = bodies[_BLOCK + k].rotation
    size = shape_parameters[_SHAPE + k].size
    return size[0] * abs(rotation[1]) + size[1] * abs(rotation[0])


@njit
def _tower_top(released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """m, highest point of the released blocks, or the ground."""
    top = 0.0
    for k in range(released):
        reach = _vertical_reach(k, bodies, shape_parameters)
        top = max(top, bodies[_BLOCK + k].position[1] + reach)
    return top


@njit
def _is_free(k, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Whether the circle around block k's place in the gripper is clear of blocks and ground."""
    x, y, _, _ = _grasp_pose(k, bodies, joint_parameters)
    reach = body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN
    if y < reach:
        return False
    for j in range(k):
        block = bodies[_BLOCK + j]
        size = shape_parameters[_SHAPE + j].size
        dx = x - block.position[0]
        dy = y - block.position[1]
        c, s = block.rotation[0], block.rotation[1]
        u = max(abs(c * dx + s * dy) - size[0], 0.0)
        v = max(abs(c * dy - s * dx) - size[1], 0.0)
        if u * u + v * v < reach * reach:
            return False
    return True


@njit
def _rise(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m, how much higher the gripper must be for the next block, were it above the tower."""
    k = record.arrived
    if record.held >= 0 or k >= record.blocks:
        return 0.0
    _, y, _, _ = _grasp_pose(k, bodies, joint_parameters)
    top = _tower_top(k, bodies, shape_parameters)
    return max(top + body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN - y, 0.0)


@njit
def _support(k, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """(x, top y, half-width, angle) of what block k belongs on; the ground lies right below it."""
    if k == 0:
        return bodies[_BLOCK].position[0], 0.0, 1.0, 0.0
    below = bodies[_BLOCK + k - 1]
    size = shape_parameters[_SHAPE + k - 1].size
    top = below.position[1] + _vertical_reach(k - 1, bodies, shape_parameters)
    return below.position[0], top, size[0], below.angle


@njit
def _distance(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m to go: of the held block to its place, or of the gripper to where the next one comes."""
    if record.held < 0:
        return _rise(record, bodies, body_parameters, shape_parameters, joint_parameters)
    k = record.held
    block = bodies[_BLOCK + k]
    x, top, _, _ = _support(k, bodies, shape_parameters)
    gap = block.position[1] - _vertical_reach(k, bodies, shape_parameters) - top
    return abs(block.position[0] - x) + abs(gap) + TILT_WEIGHT * abs(block.angle)


@njit
def _approach(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m nearer since the last step; 0 in the first one of a phase, so nothing is paid twice."""
    before = record.distance
    record.distance = _distance(record, bodies, body_parameters, shape_parameters, joint_parameters)
    return before - record.distance if before >= 0.0 else 0.0


@njit
def _move_mast(bodies):  # type: ignore[no-untyped-def]
    """The mast is only to be seen: it stands on the gripper wherever that is."""
    bodies[_MAST].position[0] = bodies[_GRIPPER].position[0]
    bodies[_MAST].position[1] = bodies[_GRIPPER].position[1] + 0.1 + _MAST_LENGTH


@njit
def judge_world(  # type: ignore[no-untyped-def]
    record, term, fact, contacts, contact_count, bodies, body_parameters, shape_parameters,
    joint_parameters,
):  # fmt: skip
    """Rewards and facts of one world after a control step; returns (reward, terminated)."""
    resting, gripped = _touches(contacts, contact_count)
    released = record.arrived if record.held < 0 else record.held
    fallen = _any_fallen(released, bodies, shape_parameters)
    term.approach = APPROACH_WEIGHT * _approach(
        record, bodies, body_parameters, shape_parameters, joint_parameters
    )
    term.placed = 0.0
    if released > record.placed and not fallen:
        if _standing(record.placed, released, resting, gripped, bodies):
            record.placed = released
            term.placed = PLACED_REWARD
    stands = released > 0 and not fallen and _standing(0, released, resting, gripped, bodies)
    record.stand = record.stand + 1 if stands else 0
    success = record.placed == record.blocks and record.stand >= STAND_STEPS
    term.success = SUCCESS_REWARD if success else 0.0
    term.fall = FALL_REWARD if fallen else 0.0
    term.effort = EFFORT_WEIGHT * record.effort
    fact.success = success
    fact.is_success = success
    fact.placed = record.placed
    fact.stand_time = record.stand * CONTROL_TIME
    k = record.arrived
    if record.held < 0 and record.placed == k and k < record.blocks and not fallen:
        if _is_free(k, bodies, body_parameters, shape_parameters, joint_parameters):
            _hand_over(record, k, bodies, body_parameters, joint_parameters)
    _move_mast(bodies)
    reward = term.approach + term.placed + term.success + term.fall + term.effort
    return reward, fallen or success


# ---------------------------------------------------------------- observe


@njit
def _observe_gripper(out, bodies, drive, time):  # type: ignore[no-untyped-def]
    gripper = bodies[_GRIPPER]
    out[0] = gripper.position[0]
    out[1] = gripper.position[1]
    out[2] = gripper.angle
    out[3] = gripper.velocity[0]
    out[4] = gripper.velocity[1]
    out[5] = gripper.velocity[2]
    out[6] = drive.total_impulse[0] / (time * _MAX_FORCE)
    out[7] = drive.total_impulse[1] / (time * _MAX_FORCE)
    out[8] = drive.total_impulse[2] / (time * _MAX_TORQUE)


@njit
def _observe_block(out, k, held, bodies, body_parameters, shape_parameters):  # type: ignore[no-untyped-def]
    """The block in the gripper, or the last one that was, against what it belongs on."""
    block = bodies[_BLOCK + k]
    size = shape_parameters[_SHAPE + k].size
    x, top, width, angle = _support(k, bodies, shape_parameters)
    out[9] = 1.0 if held else 0.0
    out[10] = block.position[0] - x
    out[11] = block.position[1] - _vertical_reach(k, bodies, shape_parameters) - top
    out[12] = block.angle
    out[13] = block.velocity[0]
    out[14] = block.velocity[1]
    out[15] = block.velocity[2]
    out[16] = size[0]
    out[17] = size[1]
    out[18] = body_parameters[_BLOCK + k].mass / 10.0
    out[19] = shape_parameters[_SHAPE + k].friction
    out[20] = bodies[_GRIPPER].position[0] - block.position[0]
    out[21] = width
    out[22] = angle
    out[23] = block.position[0] - bodies[_BLOCK].position[0]


@njit
def _observe_tower(out, record, released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    fastest = 0.0
    for k in range(released):
        v = bodies[_BLOCK + k].velocity
        fastest = max(fastest, v[0] * v[0] + v[1] * v[1])
    out[24] = math.sqrt(fastest)
    top = _tower_top(released, bodies, shape_parameters)
    out[25] = bodies[_GRIPPER].position[1] - _LIFT - top
    out[27] = record.placed / _MAX_BLOCKS
    out[28] = (record.blocks - record.placed) / _MAX_BLOCKS
    out[29] = min(record.stand / STAND_STEPS, 1.0)


@njit
def observe_world(  # type: ignore[no-untyped-def]
    out, low, high, record, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states, time,
):  # fmt: skip
    """All observations of a world, into `out` and within its bounds."""
    _observe_gripper(out, bodies, joint_states[_DRIVE], time)
    held = record.held >= 0
    _observe_block(out, record.arrived - 1, held, bodies, body_parameters, shape_parameters)
    released = record.held if held else record.arrived
    _observe_tower(out, record, released, bodies, shape_parameters)
    out[26] = _rise(record, bodies, body_parameters, shape_parameters, joint_parameters)
    for i in range(len(out)):
        out[i] = min(max(out[i], low[i]), high[i])


@njit
def observe_worlds(  # type: ignore[no-untyped-def]
    worlds, out, low, high, records, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states, time,
):  # fmt: skip
    """Observations of chosen worlds."""
    for i in range(len(worlds)):
        w = worlds[i]
        observe_world(
            out[w], low, high, records[w], bodies[w], body_parameters[w], shape_parameters[w],
            joint_parameters[w], joint_states[w], time,
        )  # fmt: skip


@njit
def judge_worlds(  # type: ignore[no-untyped-def]
    out, low, high, rewards, terms, facts, terminated, records, world_states, contacts, bodies,
    body_parameters, shape_parameters, joint_parameters, joint_states, time,
):  # fmt: skip
    """Rewards, ends and observations of all worlds."""
    for w in range(len(records)):
        rewards[w], terminated[w] = judge_world(
            records[w], terms[w], facts[w], contacts[w], world_states[w].contact_count, bodies[w],
            body_parameters[w], shape_parameters[w], joint_parameters[w],
        )  # fmt: skip
        observe_world(
            out[w], low, high, records[w], bodies[w], body_parameters[w], shape_parameters[w],
            joint_parameters[w], joint_states[w], time,
        )  # fmt: skip
