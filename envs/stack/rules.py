"""GStack's kernels: apply actions, evaluate, observe. The docstring of StackEnv states the rules."""

from __future__ import annotations

import numpy as np

from gsenv.envs.core.kernels import active_contacts, clip, first_not_finite
from gsenv.envs.stack import blocks as parts
from gsenv.envs.stack import impacts, scene
from gsenv.envs.stack import shared_rules as shared
from gsenv.envs.stack.blocks import TILT_WEIGHT
from gsenv.envs.stack.shared_rules import ARRIVAL_MARGIN
from gsenv.envs.stack.start import hand_over, initialize_world
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import select_world

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


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, 4) to drive and magnet; return -1, or the first world whose actions are not finite."""
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
    task.effort = shared.clipped_effort(action, 3)
    task.impact = 0.0
    drive = world.state.joints[_DRIVE]
    parts.steer(world.state.control, drive, action[0], action[1], action[2], -_REACH_X, _REACH_X)
    impacts.add_sway(world.state.control, task, shared.CONTROL_TIME * world.state.world.step * 0.5, 2)
    if action[3] > 0.0 and task.held >= 0:
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
    """Whether the circle around block k's place in the gripper is clear of blocks and ground."""
    bodies, parameters = world.state.bodies, world.parameters
    x, y, _, _ = parts.grasp_pose(bodies[_GRIPPER], parameters.joints[_WELD + k])
    reach = parameters.bodies[_BLOCK + k].radius + ARRIVAL_MARGIN
    if y < reach:
        return False
    shapes = parameters.shapes
    for j in range(k):
        if parts.meets(x, y, reach, bodies[_BLOCK + j], shapes[_SHAPE + j]):
            return False
    return True


@njit
def _top(world, released):  # type: ignore[no-untyped-def]
    return parts.tower_top(released, 0.0, _ORDER, world.state.bodies[_BLOCK:], world.parameters.shapes[_SHAPE:])


@njit
def _rise(world):  # type: ignore[no-untyped-def]
    """Return how much higher, in m, the gripper must be for the next block if it is above the tower."""
    task = world.task.state
    k = task.arrived
    if task.held >= 0 or k >= task.blocks:
        return 0.0
    _, y, _, _ = parts.grasp_pose(world.state.bodies[_GRIPPER], world.parameters.joints[_WELD + k])
    return max(_top(world, k) + world.parameters.bodies[_BLOCK + k].radius + ARRIVAL_MARGIN - y, 0.0)


@njit
def _support(world, k):  # type: ignore[no-untyped-def]
    """Return (x, top y, half-width, angle) of the support of block k; the ground counts as centred below it."""
    bodies = world.state.bodies
    if k == 0:
        return bodies[_BLOCK].position[0], 0.0, 1.0, 0.0
    below = bodies[_BLOCK + k - 1]
    shape = world.parameters.shapes[_SHAPE + k - 1]
    top = below.position[1] + parts.vertical_reach(below, shape)
    return below.position[0], top, shape.size[0], below.angle


@njit
def _distance(world):  # type: ignore[no-untyped-def]
    """Return the distance in m of the held block from its place, or of the gripper from where the next one comes."""
    k = world.task.state.held
    if k < 0:
        return _rise(world)
    block = world.state.bodies[_BLOCK + k]
    x, top, _, _ = _support(world, k)
    gap, speed = parts.landing(block, world.parameters.shapes[_SHAPE + k], top, world.parameters.world.gravity)
    return abs(block.position[0] - x) + impacts.descent(gap, speed) + TILT_WEIGHT * abs(block.angle)


@njit
def _evaluate_tower(world):  # type: ignore[no-untyped-def]
    """Update task state and info with the blocks that stand; return (newly placed, fallen, success)."""
    task, blocks = world.task.state, world.state.bodies[_BLOCK:]
    released = task.arrived if task.held < 0 else task.held
    steady = parts.steady_blocks(active_contacts(world), _ORDER, blocks, _GROUND, _GRIPPER, _BLOCK)
    fallen = parts.any_fallen(released, 0.0, _ORDER, blocks, world.parameters.shapes[_SHAPE:])
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
def _observe_block(world, out, k, held):  # type: ignore[no-untyped-def]
    """Write the block in the gripper, or the last one that was, relative to its support."""
    task, bodies, parameters = world.task.state, world.state.bodies, world.parameters
    block = bodies[_BLOCK + k]
    x, top, width, angle = _support(world, k)
    parts.observe_block(
        out, held, block, parameters.bodies[_BLOCK + k], parameters.shapes[_SHAPE + k], bodies[_GRIPPER], x, top
    )
    out[21] = width
    out[22] = angle
    out[23] = block.position[0] - bodies[_BLOCK].position[0]
    shape = parameters.shapes[_SHAPE + k]
    gap, speed = parts.landing(block, shape, top, parameters.world.gravity)
    impacts.observe_landing(out, 30, gap, speed, task.crack_speed)


@njit
def _observe_tower(world, out, released):  # type: ignore[no-untyped-def]
    task, bodies = world.task.state, world.state.bodies
    out[24] = parts.fastest(released, _ORDER, bodies[_BLOCK:])
    out[25] = bodies[_GRIPPER].position[1] - _LIFT - _top(world, released)
    out[26] = _rise(world)
    shared.observe_progress(out, 27, task, _MAX_BLOCKS)


@njit
def observe_world(world, timestep):  # type: ignore[no-untyped-def]
    """Write all observations of a world, clipped to their bounds."""
    task, out = world.task.state, world.task.observation
    held = task.held >= 0
    parts.observe_gripper(out, world.state.bodies[_GRIPPER], world.state.joints[_DRIVE], timestep)
    _observe_block(world, out, task.arrived - 1, held)
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
