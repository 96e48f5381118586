"""GStack's jitted passes act, judge and observe. The rules are in the docstring of stack.StackEnv."""

from __future__ import annotations

import math

import numpy as np

from gsenv.envs import blocks as parts
from gsenv.envs import stack_scene as scene
from gsenv.envs.blocks import ARRIVAL_MARGIN, CONTROL_TIME, TILT_WEIGHT
from gsenv.envs.stack_start import hand_over
from gsenv.solver.jit import njit

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.GRIPPER_BODY
_GROUND = scene.GROUND_BODY
_MAST = scene.MAST_BODY
_DRIVE = scene.DRIVE_JOINT
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_LIFT = scene.MAGNET_RADIUS + scene.GAP
_REACH_X = scene.REACH_X

_ORDER = np.arange(_MAX_BLOCKS)  # block k belongs at level k


# ---------------------------------------------------------------- act


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
        parts.steer(control[w], drive, actions[w, 0], actions[w, 1], actions[w, 2], -_REACH_X, _REACH_X)
        if actions[w, 3] > 0.0 and record.held >= 0:
            joint_parameters[w, _WELD + record.held].enabled = 0
            record.held = -1
            record.stand = 0
            record.distance = -1.0
    return -1


# ---------------------------------------------------------------- judge


@njit
def _is_free(k, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Whether the circle around block k's place in the gripper is clear of blocks and ground."""
    x, y, _, _ = parts.grasp_pose(bodies[_GRIPPER], joint_parameters[_WELD + k])
    reach = body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN
    if y < reach:
        return False
    for j in range(k):
        if parts.meets(x, y, reach, bodies[_BLOCK + j], shape_parameters[_SHAPE + j]):
            return False
    return True


@njit
def _top(released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    return parts.tower_top(released, 0.0, _ORDER, bodies[_BLOCK:], shape_parameters[_SHAPE:])


@njit
def _rise(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m, how much higher the gripper must be for the next block, were it above the tower."""
    k = record.arrived
    if record.held >= 0 or k >= record.blocks:
        return 0.0
    _, y, _, _ = parts.grasp_pose(bodies[_GRIPPER], joint_parameters[_WELD + k])
    top = _top(k, bodies, shape_parameters)
    return max(top + body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN - y, 0.0)


@njit
def _support(k, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """(x, top y, half-width, angle) of what block k belongs on; the ground lies right below it."""
    if k == 0:
        return bodies[_BLOCK].position[0], 0.0, 1.0, 0.0
    below = bodies[_BLOCK + k - 1]
    shape = shape_parameters[_SHAPE + k - 1]
    top = below.position[1] + parts.vertical_reach(below, shape)
    return below.position[0], top, shape.size[0], below.angle


@njit
def _distance(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m to go: of the held block to its place, or of the gripper to where the next one comes."""
    if record.held < 0:
        return _rise(record, bodies, body_parameters, shape_parameters, joint_parameters)
    k = record.held
    block = bodies[_BLOCK + k]
    x, top, _, _ = _support(k, bodies, shape_parameters)
    gap = block.position[1] - parts.vertical_reach(block, shape_parameters[_SHAPE + k]) - top
    return abs(block.position[0] - x) + abs(gap) + TILT_WEIGHT * abs(block.angle)


@njit
def _approach(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m nearer since the last step; 0 in the first one of a phase, so nothing is paid twice."""
    before = record.distance
    record.distance = _distance(record, bodies, body_parameters, shape_parameters, joint_parameters)
    return before - record.distance if before >= 0.0 else 0.0


@njit
def judge_world(  # type: ignore[no-untyped-def]
    record, term, fact, contacts, contact_count, bodies, body_parameters, shape_parameters,
    joint_parameters,
):  # fmt: skip
    """Rewards and facts of one world after a control step; returns (reward, terminated)."""
    blocks = bodies[_BLOCK:]
    resting, gripped = parts.touches(contacts, contact_count, _ORDER, _GROUND, _GRIPPER, _BLOCK)
    released = record.arrived if record.held < 0 else record.held
    fallen = parts.any_fallen(released, 0.0, _ORDER, blocks, shape_parameters[_SHAPE:])
    term.approach = record.approach_weight * _approach(
        record, bodies, body_parameters, shape_parameters, joint_parameters
    )
    term.placed = 0.0
    if released > record.placed and not fallen:
        if parts.standing(record.placed, released, _ORDER, resting, gripped, blocks):
            record.placed = released
            term.placed = record.placed_weight
    stands = released > 0 and not fallen and parts.standing(0, released, _ORDER, resting, gripped, blocks)
    record.stand = record.stand + 1 if stands else 0
    success = record.placed == record.blocks and record.stand >= record.stand_steps
    term.success = record.success_weight if success else 0.0
    term.fall = record.fall_weight if fallen else 0.0
    term.effort = record.effort_weight * record.effort
    fact.success = success
    fact.is_success = success
    fact.placed = record.placed
    fact.stand_time = record.stand * CONTROL_TIME
    k = record.arrived
    if record.held < 0 and record.placed == k and k < record.blocks and not fallen:
        if _is_free(k, bodies, body_parameters, shape_parameters, joint_parameters):
            hand_over(record, k, bodies, body_parameters, joint_parameters)
    parts.move_mast(bodies[_MAST], bodies[_GRIPPER])
    reward = term.approach + term.placed + term.success + term.fall + term.effort
    return reward, fallen or success


# ---------------------------------------------------------------- observe


@njit
def _observe_block(out, k, held, bodies, body_parameters, shape_parameters):  # type: ignore[no-untyped-def]
    """The block in the gripper, or the last one that was, against what it belongs on."""
    block = bodies[_BLOCK + k]
    x, top, width, angle = _support(k, bodies, shape_parameters)
    parts.observe_block(
        out, held, block, body_parameters[_BLOCK + k], shape_parameters[_SHAPE + k], bodies[_GRIPPER], x, top
    )
    out[21] = width
    out[22] = angle
    out[23] = block.position[0] - bodies[_BLOCK].position[0]


@njit
def _observe_tower(out, record, released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    out[24] = parts.fastest(released, _ORDER, bodies[_BLOCK:])
    out[25] = bodies[_GRIPPER].position[1] - _LIFT - _top(released, bodies, shape_parameters)
    out[27] = record.placed / _MAX_BLOCKS
    out[28] = (record.blocks - record.placed) / _MAX_BLOCKS
    out[29] = min(record.stand / record.stand_steps, 1.0)


@njit
def observe_world(  # type: ignore[no-untyped-def]
    out, low, high, record, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states, time,
):  # fmt: skip
    """All observations of a world, into `out` and within its bounds."""
    parts.observe_gripper(out, bodies[_GRIPPER], joint_states[_DRIVE], time)
    held = record.held >= 0
    _observe_block(out, record.arrived - 1, held, bodies, body_parameters, shape_parameters)
    released = record.held if held else record.arrived
    _observe_tower(out, record, released, bodies, shape_parameters)
    out[26] = _rise(record, bodies, body_parameters, shape_parameters, joint_parameters)
    parts.clip(out, low, high)


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
