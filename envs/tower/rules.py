"""tower_v0's kernels: apply actions, evaluate, observe. The docstring of TowerParallelEnv states the rules.

Gripper a is 0 (left) or 1 (right). Each acts and sees in its own frame: x from its side inwards, so
the right one's is mirrored and one policy serves both.
"""

from __future__ import annotations

import math

from gsenv.envs.core.kernels import active_contacts, clip, first_not_finite
from gsenv.envs.stack import blocks as parts
from gsenv.envs.stack import impacts
from gsenv.envs.stack import scene as stack
from gsenv.envs.stack import shared_rules as shared
from gsenv.envs.stack.blocks import TILT_WEIGHT
from gsenv.envs.stack.shared_rules import ARRIVAL_MARGIN, is_touching
from gsenv.envs.tower import scene
from gsenv.envs.tower.start import hand_over, initialize_world
from gsenv.solver.jit import njit
from gsenv.solver.records.bundle import select_world

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
_LIFT = stack.MAGNET_RADIUS + stack.GAP
_FROM_X, _TO_X = scene.REACH_X
_DEPOT_X = scene.DEPOT_X

# Entries of an observation that change their sign in the mirror.
_MIRRORED = (0, 2, 3, 5, 6, 8, 10, 12, 13, 15, 20, 22, 23, 28, 30, 32, 34)


@njit
def _side(a):  # type: ignore[no-untyped-def]
    """Return the direction inwards: 1 for the left gripper, -1 for the right one."""
    return 1.0 - 2.0 * a


# ---------------------------------------------------------------- apply actions


@njit
def apply_actions(world, actions):  # type: ignore[no-untyped-def]
    """Apply actions (world, agent, 4) to drives and magnets; return -1, or the first world with one not finite."""
    bad = first_not_finite(actions)
    if bad >= 0:
        return bad
    for w in range(len(actions)):
        select_world(world, w)
        world.task.state.impact = 0.0
        for a in range(2):
            _apply_action(world, a, actions[w, a])
    return -1


@njit
def _apply_action(world, a, action):  # type: ignore[no-untyped-def]
    task = world.task.state
    task.effort[a] = shared.clipped_effort(action, 3)
    side = _side(a)
    low_x = min(side * _FROM_X, side * _TO_X)
    high_x = max(side * _FROM_X, side * _TO_X)
    control = world.state.control[3 * a : 3 * a + 3]
    parts.steer(control, world.state.joints[a], side * action[0], action[1], side * action[2], low_x, high_x)
    if action[3] > 0.0 and task.held[a] == 1:
        k = task.block[a]
        shared.release(world, _GRIPPER + a, _BLOCK + k, _WELD + k)
        task.held[a] = 0
        task.level[k] = task.released
        task.order[task.released] = k
        task.released += 1
        task.stand = 0
        # The tower's top is another one now, for both.
        task.distance[0] = -1.0
        task.distance[1] = -1.0


@njit
def note_impacts(world, before):  # type: ignore[no-untyped-def]
    """Note the impacts of a step in all worlds; `before` (world, body): the bodies at its start."""
    for w in range(len(before)):
        select_world(world, w)
        task = world.task.state
        falling = _BLOCK + task.order[task.released - 1] if task.released > 0 else -1
        impacts.note_impacts(world, before[w], falling, _GRIPPER, _BLOCK)


# ---------------------------------------------------------------- evaluate


@njit
def has_turn(task, a):  # type: ignore[no-untyped-def]
    """Whether gripper a is the one to build: it has released fewer blocks; of equals the left one."""
    own = task.arrived[a] - task.held[a]
    other = task.arrived[1 - a] - task.held[1 - a]
    return own < other or (own == other and a == 0)


@njit
def _hand_of(body, task):  # type: ignore[no-untyped-def]
    """Return the gripper that a body is or that holds it, or -1."""
    for a in range(2):
        if body == _GRIPPER + a or (task.held[a] == 1 and body == _BLOCK + task.block[a]):
            return a
    return -1


@njit
def _bump(contacts, task):  # type: ignore[no-untyped-def]
    """Whether the grippers touch each other, with what they hold."""
    for i in range(len(contacts)):
        contact = contacts[i]
        if not is_touching(contact):
            continue
        a = _hand_of(contact.body_a, task)
        b = _hand_of(contact.body_b, task)
        if a >= 0 and b >= 0 and a != b:
            return True
    return False


@njit
def _has_next(task, a):  # type: ignore[no-untyped-def]
    return task.held[a] == 0 and 2 * task.arrived[a] + a < task.blocks


@njit
def _to_depot(world, a):  # type: ignore[no-untyped-def]
    """Return how far, in m, gripper a must go outwards to get a block."""
    return max(_side(a) * world.state.bodies[_GRIPPER + a].position[0] - _DEPOT_X, 0.0)


@njit
def _arrival(world, a):  # type: ignore[no-untyped-def]
    """Return (x, y, radius), in m, of the circle that gripper a's next block needs."""
    k = 2 * world.task.state.arrived[a] + a
    x, y, _, _ = parts.grasp_pose(world.state.bodies[_GRIPPER + a], world.parameters.joints[_WELD + k])
    return x, y, world.parameters.bodies[_BLOCK + k].radius + ARRIVAL_MARGIN


@njit
def _rise(world, a):  # type: ignore[no-untyped-def]
    """Return how much higher, in m, the empty gripper must be so that its next block hangs clear of the ground."""
    if not _has_next(world.task.state, a):
        return 0.0
    _, y, reach = _arrival(world, a)
    return max(reach - y, 0.0)


@njit
def _arrives(world, a):  # type: ignore[no-untyped-def]
    """Whether gripper a's next block arrives now."""
    task = world.task.state
    if not _has_next(task, a) or _to_depot(world, a) > 0.0:
        return False
    if task.level[task.block[a]] >= task.placed:
        return False
    x, y, reach = _arrival(world, a)
    bodies, parameters, shapes = world.state.bodies, world.parameters.bodies, world.parameters.shapes
    other = bodies[_GRIPPER + 1 - a].position
    if y < reach or math.hypot(x - other[0], y - other[1]) < reach + GRIPPER_SIZE:
        return False
    for j in range(_MAX_BLOCKS):
        if parameters[_BLOCK + j].enabled == 1:
            if parts.meets(x, y, reach, bodies[_BLOCK + j], shapes[_SHAPE + j]):
                return False
    return True


@njit
def _support(world, a):  # type: ignore[no-untyped-def]
    """Return (x, top y, half-width, angle) of the support of gripper a's block."""
    task, bodies = world.task.state, world.state.bodies
    level = task.released if task.held[a] == 1 else task.level[task.block[a]]
    if level == 0:
        return bodies[_PLINTH].position[0], _BASE, _BASE_WIDTH, 0.0
    k = task.order[level - 1]
    below = bodies[_BLOCK + k]
    shape = world.parameters.shapes[_SHAPE + k]
    return below.position[0], below.position[1] + parts.vertical_reach(below, shape), shape.size[0], below.angle


@njit
def _distance(world, a):  # type: ignore[no-untyped-def]
    """Return the distance in m of the held block from its place, or of a gripper without the turn from its depot."""
    task = world.task.state
    if task.held[a] == 0:
        return _to_depot(world, a) + _rise(world, a)
    if not has_turn(task, a):
        return _to_depot(world, a)
    k = task.block[a]
    block = world.state.bodies[_BLOCK + k]
    x, top, _, _ = _support(world, a)
    gap, speed = parts.landing(block, world.parameters.shapes[_SHAPE + k], top, world.parameters.world.gravity)
    return abs(block.position[0] - x) + impacts.descent(gap, speed) + TILT_WEIGHT * abs(block.angle)


@njit
def _evaluate_tower(world):  # type: ignore[no-untyped-def]
    """Update task state and info with the blocks that stand; return (placed before, fallen, success)."""
    task, info = world.task.state, world.task.info
    contacts, blocks = active_contacts(world), world.state.bodies[_BLOCK:]
    steady = parts.steady_blocks(contacts, task.level, blocks, _PLINTH, _GRIPPER, _BLOCK)
    fallen = parts.any_fallen(task.released, _BASE, task.order, blocks, world.parameters.shapes[_SHAPE:])
    failed = fallen or task.cracked != 0
    placed = task.placed
    _, success = shared.evaluate_tower(task, info, task.released, task.order, steady, failed)
    info.bump = _bump(contacts, task)
    return placed, fallen, success


@njit
def _reward(world, a, placed, fallen, success):  # type: ignore[no-untyped-def]
    """Set gripper a's reward and its terms; `placed` is the number of blocks that were placed before this step."""
    task, term = world.task.state, world.task.terms[a]
    before = task.distance[a]
    now = _distance(world, a)
    task.distance[a] = now
    # 0 in the first step of a phase, so nothing is paid twice
    term.approach = task.approach_weight * (before - now) if before >= 0.0 else 0.0
    own = 0
    for level in range(placed, task.placed):
        own += task.order[level] % 2 == a
    term.placed = task.placed_weight * own
    term.partner = task.partner_weight * (task.placed - placed - own)
    term.success = task.success_weight if success else 0.0
    term.fall = task.fall_weight if fallen else 0.0
    term.crack = task.crack_weight if task.cracked != 0 else 0.0
    term.bump = task.bump_weight if world.task.info.bump else 0.0
    term.time = task.time_weight
    term.effort = task.effort_weight * task.effort[a]
    earned = term.approach + term.placed + term.partner + term.success
    return earned + term.fall + term.crack + term.bump + term.time + term.effort


@njit
def evaluate_world(world, rewards):  # type: ignore[no-untyped-def]
    """Set rewards (agent,) and info of one world after a control step; return whether it has ended."""
    placed, fallen, success = _evaluate_tower(world)
    for a in range(2):
        rewards[a] = _reward(world, a, placed, fallen, success)
    failed = fallen or world.task.state.cracked != 0
    for a in range(2):
        if not failed and _arrives(world, a):
            hand_over(world, a)
        parts.move_mast(world, _MAST + a, _GRIPPER + a)
    return failed or success


# ---------------------------------------------------------------- observe


@njit
def _observe_other(world, out, a):  # type: ignore[no-untyped-def]
    """Write entries 28 to 37: the other gripper and its block."""
    b = 1 - a
    task, bodies = world.task.state, world.state.bodies
    me, other = bodies[_GRIPPER + a], bodies[_GRIPPER + b]
    k = task.block[b]
    block = bodies[_BLOCK + k]
    shape = world.parameters.shapes[_SHAPE + k]
    x, top, _, _ = _support(world, b)
    out[28] = other.position[0] - me.position[0]
    out[29] = other.position[1] - me.position[1]
    out[30] = other.velocity[0] - me.velocity[0]
    out[31] = other.velocity[1] - me.velocity[1]
    out[32] = other.angle
    out[33] = task.held[b]
    out[34] = block.position[0] - x
    out[35] = block.position[1] - parts.vertical_reach(block, shape) - top
    out[36] = shape.size[0]
    out[37] = shape.size[1]


@njit
def _to_go(task, a):  # type: ignore[no-untyped-def]
    """Return the fraction of gripper a's blocks that it has not released yet, of 4."""
    return ((task.blocks + 1 - a) // 2 - task.arrived[a] + task.held[a]) / 4.0


@njit
def _observe_own(world, out, a, timestep):  # type: ignore[no-untyped-def]
    """Write entries 0 to 27 and 42 to 44: the gripper, its block, the support, and the tower."""
    task, bodies, parameters = world.task.state, world.state.bodies, world.parameters
    gripper = bodies[_GRIPPER + a]
    k = task.block[a]
    x, top, width, angle = _support(world, a)
    parts.observe_gripper(out, gripper, world.state.joints[a], timestep)
    body, shape = parameters.bodies[_BLOCK + k], parameters.shapes[_SHAPE + k]
    parts.observe_block(out, task.held[a] == 1, bodies[_BLOCK + k], body, shape, gripper, x, top)
    blocks = bodies[_BLOCK:]
    out[21] = width
    out[22] = angle
    out[23] = x - bodies[_PLINTH].position[0]
    out[24] = parts.fastest(task.released, task.order, blocks)
    highest = parts.tower_top(task.released, _BASE, task.order, blocks, parameters.shapes[_SHAPE:])
    out[25] = gripper.position[1] - _LIFT - highest
    out[26] = _to_depot(world, a)
    out[27] = _rise(world, a)
    out[42] = 1.0 if has_turn(task, a) else 0.0
    gap, speed = parts.landing(bodies[_BLOCK + k], shape, top, parameters.world.gravity)
    impacts.observe_landing(out, 43, gap, speed, task.crack_speed)


@njit
def observe_agent(world, a, timestep):  # type: ignore[no-untyped-def]
    """Write all observations of gripper a, mirrored from the world's frame into its own and clipped to their bounds."""
    task, out = world.task.state, world.task.observation[a]
    _observe_own(world, out, a, timestep)
    _observe_other(world, out, a)
    out[38] = task.placed / _MAX_BLOCKS
    out[39] = _to_go(task, a)
    out[40] = _to_go(task, 1 - a)
    out[41] = min(task.stand / task.stand_steps, 1.0)
    if a == 1:
        for i in _MIRRORED:
            out[i] = -out[i]
    clip(out, world.task.low, world.task.high)


# ---------------------------------------------------------------- all worlds


@njit
def initialize_worlds(world, worlds, draws, timestep):  # type: ignore[no-untyped-def]
    """Begin episodes in chosen worlds; `draws` is (chosen world, number), uniform in [0, 1)."""
    for i in range(len(worlds)):
        select_world(world, worlds[i])
        initialize_world(world, draws[i])
        shared.apply_physics(world.task.physics, world.parameters, _BLOCK, _SHAPE, _MAX_BLOCKS, 2)
        for a in range(2):
            observe_agent(world, a, timestep)


@njit
def evaluate_worlds(world, timestep):  # type: ignore[no-untyped-def]
    """Set rewards, terminations and observations of all worlds."""
    rewards, terminated = world.task.rewards, world.task.terminated
    for w in range(len(rewards)):
        select_world(world, w)
        terminated[w] = evaluate_world(world, rewards[w])
        for a in range(2):
            observe_agent(world, a, timestep)
