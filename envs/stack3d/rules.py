"""GStack3D's kernels: apply actions, evaluate, observe. The docstring of Stack3DEnv states the rules."""

from __future__ import annotations

import math

import numpy as np

from gsenv.envs.core.kernels import active_contacts, clip, first_not_finite
from gsenv.envs.stack import impacts
from gsenv.envs.stack import shared_rules as shared
from gsenv.envs.stack.shared_rules import ARRIVAL_MARGIN
from gsenv.envs.stack3d import blocks as parts
from gsenv.envs.stack3d import scene
from gsenv.envs.stack3d.start import hand_over, initialize_world
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import select_world

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

_ORDER = np.arange(_MAX_BLOCKS)  # block k belongs at level k


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, 5) to drive and magnet; return -1, or the first world whose actions are not finite."""
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
    task.effort = shared.clipped_effort(action, 4)
    task.impact = 0.0
    parts.steer(world.state.control, world.state.joints[_DRIVE], action)
    impacts.add_sway(world.state.control, task, shared.CONTROL_TIME * world.state.world.step * 0.5, 3)
    if action[4] > 0.0 and task.held >= 0:
        shared.release_held(world, _GRIPPER, _BLOCK, _WELD)


@njit
def note_impacts(world, before):  # type: ignore[no-untyped-def]
    """Note the impacts of a step in all worlds; `before` (world, body): the bodies at its start."""
    for w in range(len(before)):
        select_world(world, w)
        task = world.task.state
        falling = _BLOCK + task.arrived - 1 if task.held < 0 else -1
        impacts.note_impacts(world, before[w], falling, _GRIPPER, _BLOCK)


# ---------------------------------------------------------------- evaluate


@njit
def _is_free(world, k):  # type: ignore[no-untyped-def]
    """Whether the ball around block k's place in the gripper is clear of blocks and ground."""
    bodies, parameters = world.state.bodies, world.parameters
    at, _ = parts.grasp_pose(bodies[_GRIPPER], parameters.joints[_WELD + k])
    reach = parameters.bodies[_BLOCK + k].radius + ARRIVAL_MARGIN
    if at[2] < reach:
        return False
    shapes = parameters.shapes
    for j in range(k):
        if parts.meets(at, reach, bodies[_BLOCK + j], shapes[_SHAPE + j]):
            return False
    return True


@njit
def _top(world, released):  # type: ignore[no-untyped-def]
    return parts.tower_top(released, world.state.bodies[_BLOCK:], world.parameters.shapes[_SHAPE:])


@njit
def _rise(world):  # type: ignore[no-untyped-def]
    """Return how much higher, in m, the gripper must be for the next block if it is above the tower."""
    task = world.task.state
    k = task.arrived
    if task.held >= 0 or k >= task.blocks:
        return 0.0
    at, _ = parts.grasp_pose(world.state.bodies[_GRIPPER], world.parameters.joints[_WELD + k])
    return max(_top(world, k) + world.parameters.bodies[_BLOCK + k].radius + ARRIVAL_MARGIN - at[2], 0.0)


@njit
def _support(world, k):  # type: ignore[no-untyped-def]
    """Return (x, y, top) of the support of block k; the ground counts as centred below it."""
    bodies = world.state.bodies
    if k == 0:
        return bodies[_BLOCK].position[0], bodies[_BLOCK].position[1], 0.0
    below = bodies[_BLOCK + k - 1]
    top = below.position[2] + parts.vertical_reach(below, world.parameters.shapes[_SHAPE + k - 1])
    return below.position[0], below.position[1], top


@njit
def _distance(world):  # type: ignore[no-untyped-def]
    """Return the distance in m of the held block from its place, or of the gripper from where the next one comes."""
    k = world.task.state.held
    if k < 0:
        return _rise(world)
    bodies = world.state.bodies
    block = bodies[_BLOCK + k]
    x, y, top = _support(world, k)
    gap, speed = parts.landing(block, world.parameters.shapes[_SHAPE + k], top, world.parameters.world.gravity)
    dx = block.position[0] - x
    dy = block.position[1] - y
    return (
        math.sqrt(dx * dx + dy * dy)
        + impacts.descent(gap, speed)
        + _TWIST_WEIGHT * abs(parts.twist(k, bodies[_BLOCK:]))
    )


@njit
def _evaluate_tower(world):  # type: ignore[no-untyped-def]
    """Update task state and info with the blocks that stand; return (newly placed, fallen, success)."""
    task, blocks = world.task.state, world.state.bodies[_BLOCK:]
    released = task.arrived if task.held < 0 else task.held
    steady = parts.steady_blocks(active_contacts(world), blocks)
    fallen = parts.any_fallen(released, blocks, world.parameters.shapes[_SHAPE:])
    failed = fallen or task.cracked != 0
    placed, success = shared.evaluate_tower(task, world.task.info, released, _ORDER, steady, failed)
    return placed, fallen, success


@njit
def evaluate_world(world):  # type: ignore[no-untyped-def]
    """Set reward terms and info of one world after a control step; return (reward, terminated)."""
    task = world.task.state
    nearer = shared.approach(task, _distance(world))
    placed, fallen, success = _evaluate_tower(world)
    reward = shared.write_terms(task, world.task.terms, nearer, placed, fallen, success)
    failed = fallen or task.cracked != 0
    if shared.is_due(task, failed) and _is_free(world, task.arrived):
        hand_over(world, task.arrived)
    parts.move_mast(world, _MAST, _GRIPPER)
    return reward, failed or success


# ---------------------------------------------------------------- observe


@njit
def _observe_gripper(out, gripper, drive, timestep):  # type: ignore[no-untyped-def]
    """Write entries 0 to 15: pose, velocity, and the drive's forces relative to their bounds."""
    v = gripper.velocity
    up = parts.upwards(gripper.rotation)
    for d in range(3):
        out[d] = gripper.position[d]
        out[6 + d] = v[d]
        out[10 + d] = drive.total_impulse[d] / (timestep * _MAX_FORCE)
        out[13 + d] = drive.total_impulse[3 + d] / (timestep * _MAX_TORQUE)
    out[3] = parts.heading(gripper.rotation)
    out[4] = up[0]
    out[5] = up[1]
    out[9] = v[5]


@njit
def _observe_block(world, out, k, held):  # type: ignore[no-untyped-def]
    """Write entries 16 to 35, 41, 42, 49 and 50: the block in the gripper, or the last one that was, by its support."""
    bodies = world.state.bodies
    block = bodies[_BLOCK + k]
    shape = world.parameters.shapes[_SHAPE + k]
    x, y, top = _support(world, k)
    up = parts.upwards(block.rotation)
    out[16] = 1.0 if held else 0.0
    out[17] = block.position[0] - x
    out[18] = block.position[1] - y
    gap, speed = parts.landing(block, shape, top, world.parameters.world.gravity)
    out[19] = gap
    impacts.observe_landing(out, 49, gap, speed, world.task.state.crack_speed)
    out[20] = parts.twist(k, bodies[_BLOCK:])
    out[21] = up[0]
    out[22] = up[1]
    for d in range(6):
        out[23 + d] = block.velocity[d]
    for d in range(3):
        out[29 + d] = shape.size[d]
    out[32] = world.parameters.bodies[_BLOCK + k].mass / 10.0
    out[33] = shape.friction
    out[34] = bodies[_GRIPPER].position[0] - block.position[0]
    out[35] = bodies[_GRIPPER].position[1] - block.position[1]
    out[41] = block.position[0] - bodies[_BLOCK].position[0]
    out[42] = block.position[1] - bodies[_BLOCK].position[1]


@njit
def _observe_support(world, out, k):  # type: ignore[no-untyped-def]
    """Write entries 36 to 40: the support of block k."""
    out[36] = 1.0
    out[37] = 1.0
    out[38] = 0.0
    out[39] = 0.0
    out[40] = 0.0
    if k > 0:
        below = world.state.bodies[_BLOCK + k - 1]
        shape = world.parameters.shapes[_SHAPE + k - 1]
        up = parts.upwards(below.rotation)
        out[36] = shape.size[0]
        out[37] = shape.size[1]
        out[38] = parts.to_sides(parts.heading(below.rotation))
        out[39] = up[0]
        out[40] = up[1]


@njit
def _observe_tower(world, out, released):  # type: ignore[no-untyped-def]
    """Write entries 43 to 48: the tower and the progress."""
    task, bodies = world.task.state, world.state.bodies
    out[43] = parts.fastest(released, bodies[_BLOCK:])
    out[44] = bodies[_GRIPPER].position[2] - _LIFT - _top(world, released)
    out[45] = _rise(world)
    shared.observe_progress(out, 46, task, _MAX_BLOCKS)


@njit
def observe_world(world, timestep):  # type: ignore[no-untyped-def]
    """Write all observations of a world, clipped to their bounds."""
    task, out = world.task.state, world.task.observation
    held = task.held >= 0
    k = task.arrived - 1
    _observe_gripper(out, world.state.bodies[_GRIPPER], world.state.joints[_DRIVE], timestep)
    _observe_block(world, out, k, held)
    _observe_support(world, out, k)
    _observe_tower(world, out, task.held if held else task.arrived)
    clip(out, world.task.low, world.task.high)


# ---------------------------------------------------------------- all worlds


@njit
def initialize_worlds(world, worlds, draws, timestep):  # type: ignore[no-untyped-def]
    """Begin episodes in chosen worlds; `draws` is (chosen world, number), uniform in [0, 1)."""
    for i in range(len(worlds)):
        select_world(world, worlds[i])
        initialize_world(world, draws[i])
        shared.apply_physics(world.task.physics, world.parameters, _BLOCK, _SHAPE, _MAX_BLOCKS, 1)
        observe_world(world, timestep)


@njit
def evaluate_worlds(world, timestep):  # type: ignore[no-untyped-def]
    """Set rewards, terminations and observations of all worlds."""
    rewards, terminated = world.task.rewards, world.task.terminated
    for w in range(len(rewards)):
        select_world(world, w)
        rewards[w], terminated[w] = evaluate_world(world)
        observe_world(world, timestep)
