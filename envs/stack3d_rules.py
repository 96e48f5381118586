"""GStack3D's jitted passes act, judge and observe. The rules are in the docstring of stack3d.Stack3DEnv."""

from __future__ import annotations

import math

from gsenv.envs import stack3d_blocks as parts
from gsenv.envs import stack3d_scene as scene
from gsenv.envs.blocks import ARRIVAL_MARGIN, CONTROL_TIME, clip
from gsenv.envs.stack3d_start import hand_over
from gsenv.solver.jit import njit

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.GRIPPER_BODY
_MAST = scene.MAST_BODY
_DRIVE = scene.DRIVE_JOINT
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_LIFT = parts.LIFT
_MAX_FORCE = scene.MAX_FORCE
_MAX_TORQUE = scene.MAX_TORQUE
_TWIST_WEIGHT = parts.TWIST_WEIGHT


# ---------------------------------------------------------------- act


@njit
def act(actions, records, control, joint_parameters, joint_states):  # type: ignore[no-untyped-def]
    """Actions to the drive and the pad; -1, or the first world whose actions are not finite."""
    for w in range(len(actions)):
        for a in range(5):
            if not math.isfinite(actions[w, a]):
                return w
    for w in range(len(actions)):
        record = records[w]
        record.effort = 0.0
        for a in range(5):
            actions[w, a] = min(max(actions[w, a], -1.0), 1.0)
            if a < 4:
                record.effort += actions[w, a] * actions[w, a] / 4.0
        parts.steer(control[w], joint_states[w, _DRIVE], actions[w])
        if actions[w, 4] > 0.0 and record.held >= 0:
            joint_parameters[w, _WELD + record.held].enabled = 0
            record.held = -1
            record.stand = 0
            record.distance = -1.0
    return -1


# ---------------------------------------------------------------- judge


@njit
def _is_free(k, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Whether the ball around block k's place in the gripper is clear of blocks and ground."""
    at, _ = parts.grasp_pose(bodies[_GRIPPER], joint_parameters[_WELD + k])
    reach = body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN
    if at[2] < reach:
        return False
    for j in range(k):
        if parts.meets(at, reach, bodies[_BLOCK + j], shape_parameters[_SHAPE + j]):
            return False
    return True


@njit
def _top(released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    return parts.tower_top(released, bodies[_BLOCK:], shape_parameters[_SHAPE:])


@njit
def _rise(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m, how much higher the gripper must be for the next block, were it above the tower."""
    k = record.arrived
    if record.held >= 0 or k >= record.blocks:
        return 0.0
    at, _ = parts.grasp_pose(bodies[_GRIPPER], joint_parameters[_WELD + k])
    top = _top(k, bodies, shape_parameters)
    return max(top + body_parameters[_BLOCK + k].radius + ARRIVAL_MARGIN - at[2], 0.0)


@njit
def _support(k, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """(x, y, top) of what block k belongs on; the ground lies right below it."""
    if k == 0:
        return bodies[_BLOCK].position[0], bodies[_BLOCK].position[1], 0.0
    below = bodies[_BLOCK + k - 1]
    top = below.position[2] + parts.vertical_reach(below, shape_parameters[_SHAPE + k - 1])
    return below.position[0], below.position[1], top


@njit
def _distance(record, bodies, body_parameters, shape_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """m to go: of the held block to its place, or of the gripper to where the next one comes."""
    if record.held < 0:
        return _rise(record, bodies, body_parameters, shape_parameters, joint_parameters)
    k = record.held
    block = bodies[_BLOCK + k]
    x, y, top = _support(k, bodies, shape_parameters)
    gap = block.position[2] - parts.vertical_reach(block, shape_parameters[_SHAPE + k]) - top
    dx = block.position[0] - x
    dy = block.position[1] - y
    return math.sqrt(dx * dx + dy * dy) + abs(gap) + _TWIST_WEIGHT * abs(parts.twist(k, bodies[_BLOCK:]))


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
    resting, gripped = parts.touches(contacts, contact_count)
    released = record.arrived if record.held < 0 else record.held
    fallen = parts.any_fallen(released, blocks, shape_parameters[_SHAPE:])
    term.approach = record.approach_weight * _approach(
        record, bodies, body_parameters, shape_parameters, joint_parameters
    )
    term.placed = 0.0
    if released > record.placed and not fallen:
        if parts.standing(record.placed, released, resting, gripped, blocks):
            record.placed = released
            term.placed = record.placed_weight
    stands = released > 0 and not fallen and parts.standing(0, released, resting, gripped, blocks)
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
def _observe_gripper(out, gripper, drive, time):  # type: ignore[no-untyped-def]
    """Entries 0 to 15: pose, velocity, and the drive's forces of their bounds."""
    v = gripper.velocity
    up = parts.upwards(gripper.rotation)
    for d in range(3):
        out[d] = gripper.position[d]
        out[6 + d] = v[d]
        out[10 + d] = drive.total_impulse[d] / (time * _MAX_FORCE)
        out[13 + d] = drive.total_impulse[3 + d] / (time * _MAX_TORQUE)
    out[3] = parts.heading(gripper.rotation)
    out[4] = up[0]
    out[5] = up[1]
    out[9] = v[5]


@njit
def _observe_block(out, k, held, bodies, body_parameters, shape_parameters):  # type: ignore[no-untyped-def]
    """Entries 16 to 42: the block in the gripper, or the last one that was, against what it belongs on."""
    block = bodies[_BLOCK + k]
    shape = shape_parameters[_SHAPE + k]
    x, y, top = _support(k, bodies, shape_parameters)
    up = parts.upwards(block.rotation)
    out[16] = 1.0 if held else 0.0
    out[17] = block.position[0] - x
    out[18] = block.position[1] - y
    out[19] = block.position[2] - parts.vertical_reach(block, shape) - top
    out[20] = parts.twist(k, bodies[_BLOCK:])
    out[21] = up[0]
    out[22] = up[1]
    for d in range(6):
        out[23 + d] = block.velocity[d]
    for d in range(3):
        out[29 + d] = shape.size[d]
    out[32] = body_parameters[_BLOCK + k].mass / 10.0
    out[33] = shape.friction
    out[34] = bodies[_GRIPPER].position[0] - block.position[0]
    out[35] = bodies[_GRIPPER].position[1] - block.position[1]
    _observe_support(out, k, bodies, shape_parameters)
    out[41] = block.position[0] - bodies[_BLOCK].position[0]
    out[42] = block.position[1] - bodies[_BLOCK].position[1]


@njit
def _observe_support(out, k, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """Entries 36 to 40."""
    out[36] = 1.0
    out[37] = 1.0
    out[38] = 0.0
    out[39] = 0.0
    out[40] = 0.0
    if k > 0:
        below = bodies[_BLOCK + k - 1]
        up = parts.upwards(below.rotation)
        out[36] = shape_parameters[_SHAPE + k - 1].size[0]
        out[37] = shape_parameters[_SHAPE + k - 1].size[1]
        out[38] = parts.to_sides(parts.heading(below.rotation))
        out[39] = up[0]
        out[40] = up[1]


@njit
def _observe_tower(out, record, released, bodies, shape_parameters):  # type: ignore[no-untyped-def]
    """Entries 43, 44 and 46 to 48."""
    out[43] = parts.fastest(released, bodies[_BLOCK:])
    out[44] = bodies[_GRIPPER].position[2] - _LIFT - _top(released, bodies, shape_parameters)
    out[46] = record.placed / _MAX_BLOCKS
    out[47] = (record.blocks - record.placed) / _MAX_BLOCKS
    out[48] = min(record.stand / record.stand_steps, 1.0)


@njit
def observe_world(  # type: ignore[no-untyped-def]
    out, low, high, record, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states, time,
):  # fmt: skip
    """All observations of a world, into `out` and within its bounds."""
    _observe_gripper(out, bodies[_GRIPPER], joint_states[_DRIVE], time)
    held = record.held >= 0
    _observe_block(out, record.arrived - 1, held, bodies, body_parameters, shape_parameters)
    released = record.held if held else record.arrived
    _observe_tower(out, record, released, bodies, shape_parameters)
    out[45] = _rise(record, bodies, body_parameters, shape_parameters, joint_parameters)
    clip(out, low, high)


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
