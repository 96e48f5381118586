"""tower_v0's jitted passes act, judge and observe. The rules are in the docstring of tower.TowerParallelEnv.

Gripper a is 0 (left) or 1 (right). Each acts and sees in its own frame: x from its side inwards, so
the right one's is mirrored and one policy serves both.
"""

from __future__ import annotations

import math

from gsenv.envs import blocks as parts
from gsenv.envs import stack_scene
from gsenv.envs import tower_scene as scene
from gsenv.envs.blocks import ARRIVAL_MARGIN, CONTROL_TIME, TILT_WEIGHT, TOUCH
from gsenv.envs.tower_start import hand_over
from gsenv.solver.jit import njit

GRIPPER_SIZE = 0.3  # m, free space for the other gripper beside an arriving block

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.FIRST_GRIPPER
_MAST = scene.FIRST_MAST
_PLINTH = scene.PLINTH_BODY
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_BASE = scene.PLINTH_HEIGHT
_BASE_WIDTH = scene.PLINTH_HALF_WIDTH
_LIFT = stack_scene.MAGNET_RADIUS + stack_scene.GAP
_FROM_X, _TO_X = scene.REACH_X
_DEPOT_X = scene.DEPOT_X

# Entries of an observation that change their sign in the mirror.
_MIRRORED = (0, 2, 3, 5, 6, 8, 10, 12, 13, 15, 20, 22, 23, 28, 30, 32, 34)


@njit
def _side(a):  # type: ignore[no-untyped-def]
    """1 left, -1 right: the direction inwards."""
    return 1.0 - 2.0 * a


# ---------------------------------------------------------------- act


@njit
def act(actions, records, control, joint_parameters, joint_states):  # type: ignore[no-untyped-def]
    """Actions to drives and magnets; -1, or the first world whose actions are not finite."""
    for w in range(len(actions)):
        for a in range(2):
            for i in range(4):
                if not math.isfinite(actions[w, a, i]):
                    return w
    for w in range(len(actions)):
        for a in range(2):
            _act_one(actions[w, a], a, records[w], control[w], joint_parameters[w], joint_states[w, a])
    return -1


@njit
def _act_one(action, a, record, control, joint_parameters, drive):  # type: ignore[no-untyped-def]
    record.effort[a] = 0.0
    for i in range(4):
        action[i] = min(max(action[i], -1.0), 1.0)
        if i < 3:
            record.effort[a] += action[i] * action[i] / 3.0
    side = _side(a)
    low_x = min(side * _FROM_X, side * _TO_X)
    high_x = max(side * _FROM_X, side * _TO_X)
    parts.steer(control[3 * a : 3 * a + 3], drive, side * action[0], action[1], side * action[2], low_x, high_x)
    if action[3] > 0.0 and record.held[a] == 1:
        k = record.block[a]
        joint_parameters[_WELD + k].enabled = 0
        record.held[a] = 0
        record.level[k] = record.released
        record.order[record.released] = k
        record.released += 1
        record.stand = 0
        # The tower's top is another one now, for both.
        record.distance[0] = -1.0
        record.distance[1] = -1.0


# ---------------------------------------------------------------- judge


@njit
def _hand_of(body, record):  # type: ignore[no-untyped-def]
    """The gripper that a body is, or that holds it; or -1."""
    for a in range(2):
        if body == _GRIPPER + a or (record.held[a] == 1 and body == _BLOCK + record.block[a]):
            return a
    return -1


@njit
def _bump(contacts, count, record):  # type: ignore[no-untyped-def]
    """Whether the grippers touch each other, with what they hold."""
    for i in range(count):
        contact = contacts[i]
        if contact.total_impulse[0] <= 0.0 and contact.separation > TOUCH:
            continue
        a = _hand_of(contact.body_a, record)
        b = _hand_of(contact.body_b, record)
        if a >= 0 and b >= 0 and a != b:
            return True
    return False


@njit
def _has_next(record, a):  # type: ignore[no-untyped-def]
    return record.held[a] == 0 and 2 * record.arrived[a] + a < record.blocks


@njit
def _to_depot(a, bodies):  # type: ignore[no-untyped-def]
    """m, how far gripper a must go outwards to get a block."""
    return max(_side(a) * bodies[_GRIPPER + a].position[0] - _DEPOT_X, 0.0)


@njit
def _rise(record, a, bodies, body_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m, how much higher the empty gripper must be for its next block to hang clear of the ground."""
    if not _has_next(record, a):
        return 0.0
    k = 2 * record.arrived[a] + a
    _, y, _, _ = parts.grasp_pose(bodies[_GRIPPER + a], joint_parameters[_WELD + k])
    return max(body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN - y, 0.0)


@njit
def _comes(record, a, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Whether gripper a's next block arrives now."""
    if not _has_next(record, a) or _to_depot(a, bodies) > 0.0:
        return False
    if record.level[record.block[a]] >= record.placed:
        return False
    k = 2 * record.arrived[a] + a
    x, y, _, _ = parts.grasp_pose(bodies[_GRIPPER + a], joint_parameters[_WELD + k])
    reach = body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN
    other = bodies[_GRIPPER + 1 - a].position
    if y < reach or math.hypot(x - other[0], y - other[1]) < reach + GRIPPER_SIZE:
        return False
    for j in range(_MAX_BLOCKS):
        if body_parameters[_BLOCK + j].enabled == 1:
            if parts.meets(x, y, reach, bodies[_BLOCK + j], shape_parameters[_SHAPE + j]):
                return False
    return True


@njit
def _support(record, a, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """(x, top y, half-width, angle) of what gripper a's block belongs on."""
    level = record.released if record.held[a] == 1 else record.level[record.block[a]]
    if level == 0:
        return bodies[_PLINTH].position[0], _BASE, _BASE_WIDTH, 0.0
    k = record.order[level - 1]
    below = bodies[_BLOCK + k]
    shape = shape_parameters[_SHAPE + k]
    return below.position[0], below.position[1] + parts.vertical_reach(below, shape), shape.size[0], below.angle


@njit
def _distance(record, a, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m to go: of the held block to its place, or of the empty gripper to its depot."""
    if record.held[a] == 0:
        return _to_depot(a, bodies) + _rise(record, a, bodies, body_parameters, joint_parameters)
    k = record.block[a]
    block = bodies[_BLOCK + k]
    x, top, _, _ = _support(record, a, bodies, shape_parameters)
    gap = block.position[1] - parts.vertical_reach(block, shape_parameters[_SHAPE + k]) - top
    return abs(block.position[0] - x) + abs(gap) + TILT_WEIGHT * abs(block.angle)


@njit
def _judge_tower(record, fact, contacts, contact_count, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """Facts of the tower; returns (blocks placed before this step, fallen, success)."""
    blocks, shapes = bodies[_BLOCK:], shape_parameters[_SHAPE:]
    resting, gripped = parts.touches(contacts, contact_count, record.level, _PLINTH, _GRIPPER, _BLOCK)
    fallen = parts.any_fallen(record.released, _BASE, record.order, blocks, shapes)
    placed = record.placed
    if record.released > placed and not fallen:
        if parts.standing(placed, record.released, record.order, resting, gripped, blocks):
            record.placed = record.released
    stands = record.released > 0 and not fallen
    stands = stands and parts.standing(0, record.released, record.order, resting, gripped, blocks)
    record.stand = record.stand + 1 if stands else 0
    success = record.placed == record.blocks and record.stand >= record.stand_steps
    fact.success = success
    fact.is_success = success
    fact.placed = record.placed
    fact.stand_time = record.stand * CONTROL_TIME
    fact.bump = _bump(contacts, contact_count, record)
    return placed, fallen, success


@njit
def judge_world(  # type: ignore[no-untyped-def]
    record, rewards, terms, fact, contacts, contact_count, bodies, body_parameters,
    shape_parameters, joint_parameters,
):  # fmt: skip
    """Rewards and facts of one world after a control step; returns whether it has ended."""
    placed, fallen, success = _judge_tower(record, fact, contacts, contact_count, bodies, shape_parameters)
    for a in range(2):
        term = terms[a]
        before = record.distance[a]
        now = _distance(record, a, bodies, body_parameters, shape_parameters, joint_parameters)
        record.distance[a] = now
        # 0 in the first step of a phase, so nothing is paid twice
        term.approach = record.approach_weight * (before - now) if before >= 0.0 else 0.0
        own = 0
        for level in range(placed, record.placed):
            own += record.order[level] % 2 == a
        term.placed = record.placed_weight * own
        term.partner = record.partner_weight * (record.placed - placed - own)
        term.success = record.success_weight if success else 0.0
        term.fall = record.fall_weight if fallen else 0.0
        term.bump = record.bump_weight if fact.bump else 0.0
        term.effort = record.effort_weight * record.effort[a]
        rewards[a] = (
            term.approach + term.placed + term.partner + term.success + term.fall + term.bump + term.effort
        )
    for a in range(2):
        if not fallen and _comes(record, a, bodies, body_parameters, shape_parameters, joint_parameters):
            hand_over(record, a, bodies, body_parameters, joint_parameters)
        parts.move_mast(bodies[_MAST + a], bodies[_GRIPPER + a])
    return fallen or success


# ---------------------------------------------------------------- observe


@njit
def _observe_other(out, record, a, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """Entries 28 to 37: the other gripper and its block."""
    b = 1 - a
    me, other = bodies[_GRIPPER + a], bodies[_GRIPPER + b]
    k = record.block[b]
    block = bodies[_BLOCK + k]
    shape = shape_parameters[_SHAPE + k]
    x, top, _, _ = _support(record, b, bodies, shape_parameters)
    out[28] = other.position[0] - me.position[0]
    out[29] = other.position[1] - me.position[1]
    out[30] = other.velocity[0] - me.velocity[0]
    out[31] = other.velocity[1] - me.velocity[1]
    out[32] = other.angle
    out[33] = record.held[b]
    out[34] = block.position[0] - x
    out[35] = block.position[1] - parts.vertical_reach(block, shape) - top
    out[36] = shape.size[0]
    out[37] = shape.size[1]


@njit
def _to_go(record, a):  # type: ignore[no-untyped-def]
    """Gripper a's blocks that are yet to be let go, of 4."""
    return ((record.blocks + 1 - a) // 2 - record.arrived[a] + record.held[a]) / 4.0


@njit
def observe_one(  # type: ignore[no-untyped-def]
    out, record, a, bodies, body_parameters, shape_parameters, joint_parameters, drive, time
):
    """All observations of gripper a, in the world's frame, then mirrored into its own."""
    gripper = bodies[_GRIPPER + a]
    k = record.block[a]
    x, top, width, angle = _support(record, a, bodies, shape_parameters)
    parts.observe_gripper(out, gripper, drive, time)
    parts.observe_block(
        out, record.held[a] == 1, bodies[_BLOCK + k], body_parameters[_BLOCK + k], shape_parameters[_SHAPE + k],
        gripper, x, top,
    )  # fmt: skip
    blocks = bodies[_BLOCK:]
    out[21] = width
    out[22] = angle
    out[23] = x - bodies[_PLINTH].position[0]
    out[24] = parts.fastest(record.released, record.order, blocks)
    highest = parts.tower_top(record.released, _BASE, record.order, blocks, shape_parameters[_SHAPE:])
    out[25] = gripper.position[1] - _LIFT - highest
    out[26] = _to_depot(a, bodies)
    out[27] = _rise(record, a, bodies, body_parameters, joint_parameters)
    _observe_other(out, record, a, bodies, shape_parameters)
    out[38] = record.placed / _MAX_BLOCKS
    out[39] = _to_go(record, a)
    out[40] = _to_go(record, 1 - a)
    out[41] = min(record.stand / record.stand_steps, 1.0)
    if a == 1:
        for i in _MIRRORED:
            out[i] = -out[i]


@njit
def observe_worlds(  # type: ignore[no-untyped-def]
    worlds, out, low, high, records, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states, time,
):  # fmt: skip
    """Observations (world, gripper, entry) of chosen worlds, within their bounds."""
    for i in range(len(worlds)):
        w = worlds[i]
        for a in range(2):
            observe_one(
                out[w, a], records[w], a, bodies[w], body_parameters[w], shape_parameters[w],
                joint_parameters[w], joint_states[w, a], time,
            )  # fmt: skip
            parts.clip(out[w, a], low, high)


@njit
def judge_worlds(  # type: ignore[no-untyped-def]
    rewards, terms, facts, terminated, records, world_states, contacts, bodies, body_parameters,
    shape_parameters, joint_parameters,
):  # fmt: skip
    """Rewards, facts and ends of all worlds."""
    for w in range(len(records)):
        terminated[w] = judge_world(
            records[w], rewards[w], terms[w], facts[w], contacts[w], world_states[w].contact_count, bodies[w],
            body_parameters[w], shape_parameters[w], joint_parameters[w],
        )  # fmt: skip
