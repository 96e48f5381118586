"""Blocks in grippers and on towers: the jitted parts that GStack-v0 and tower_v0 share.

`blocks` and `shapes` are records of the blocks alone; `order` says which block lies at which level,
`levels` at which level a block lies. Levels are counted from the base, whose top is at the height `base`.
"""

from __future__ import annotations

import math

from gsenv.envs.core.kernels import active_contacts, between
from gsenv.envs.stack import impacts, scene
from gsenv.envs.stack.shared_rules import REST_SPEED, SUNK, TIPPED, is_touching, within
from gsenv.solver.core.edit import enable_body, enable_joint, place_body, set_box
from gsenv.solver.core.trig import sin_cos
from gsenv.solver.jit import njit

DRAWS_PER_BLOCK = 6
TILT_WEIGHT = 0.5  # m per rad, in the distance of the approach

UPRIGHT = (1.0, 0.0, 0.0)  # cos, sin, angle
AT_REST = (0.0, 0.0, 0.0)  # velocity

_LIFT = scene.MAGNET_RADIUS + scene.GAP
_MAST_LENGTH = scene.MAST_HALF_LENGTH
_SPEED = scene.SPEED
_TURN_SPEED = scene.TURN_SPEED
_LOW_Y, _HIGH_Y = scene.REACH_Y
_REACH_ANGLE = scene.REACH_ANGLE
_MAX_FORCE = scene.MAX_FORCE
_MAX_TORQUE = scene.MAX_TORQUE


# ---------------------------------------------------------------- initialize


@njit
def make_block(task, draws, body, shape, weld):  # type: ignore[no-untyped-def]
    """Set size, mass, friction and grasp of a block from its six draws; `task`, the task state, has the ranges."""
    x = between(task.half_width[0], task.half_width[1], draws[0])
    y = between(task.half_height[0], task.half_height[1], draws[1])
    set_box(body, shape, (x, y), between(task.mass[0], task.mass[1], draws[2]))
    shape.friction = between(task.friction[0], task.friction[1], draws[3])
    c, s = sin_cos(between(-task.grasp_tilt, task.grasp_tilt, draws[5]))
    weld.reference[0] = c
    weld.reference[1] = s
    # The magnet is round: it meets the block's tilted top where the top's normal points at it.
    weld.anchor_a[0] = _LIFT * s
    weld.anchor_a[1] = -_LIFT * c
    weld.anchor_b[0] = between(-task.grasp_offset, task.grasp_offset, draws[4]) * x
    weld.anchor_b[1] = y


@njit
def make_blocks(world, draws, first_block, first_shape, first_weld, count):  # type: ignore[no-untyped-def]
    """Set size, mass, friction and grasp of all blocks, six draws each."""
    parameters = world.parameters
    for k in range(count):
        make_block(
            world.task.state, draws[DRAWS_PER_BLOCK * k :], parameters.bodies[first_block + k],
            parameters.shapes[first_shape + k], parameters.joints[first_weld + k],
        )  # fmt: skip


@njit
def place_upright(world, body, x, y):  # type: ignore[no-untyped-def]
    """Place a body at rest and not rotated."""
    place_body(body, world.state.bodies, world.parameters.bodies, active_contacts(world), (x, y), UPRIGHT, AT_REST)


@njit
def place_gripper(world, gripper, drive, x, y):  # type: ignore[no-untyped-def]
    """Place a gripper at rest and not rotated, with the target of its drive."""
    place_upright(world, gripper, x, y)
    target = world.state.joints[drive].target_position
    target[0] = x
    target[1] = y


@njit
def grasp_pose(gripper, weld):  # type: ignore[no-untyped-def]
    """Return the pose (x, y, cos, sin) of a block in its gripper."""
    gc, gs = gripper.rotation[0], gripper.rotation[1]
    c = gc * weld.reference[0] - gs * weld.reference[1]
    s = gs * weld.reference[0] + gc * weld.reference[1]
    x = gripper.position[0] + gc * weld.anchor_a[0] - gs * weld.anchor_a[1]
    y = gripper.position[1] + gs * weld.anchor_a[0] + gc * weld.anchor_a[1]
    x -= c * weld.anchor_b[0] - s * weld.anchor_b[1]
    y -= s * weld.anchor_b[0] + c * weld.anchor_b[1]
    return x, y, c, s


@njit
def hand_over(world, gripper, block, weld):  # type: ignore[no-untyped-def]
    """Place a block in a gripper, so that it moves with it; both are indices of bodies."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    holder = bodies[gripper]
    joint = world.parameters.joints[weld]
    x, y, c, s = grasp_pose(holder, joint)
    turn = (c, s, holder.angle + math.asin(joint.reference[1]))
    v = holder.velocity
    velocity = (v[0] - v[2] * (y - holder.position[1]), v[1] + v[2] * (x - holder.position[0]), v[2])
    place_body(block, bodies, parameters, active_contacts(world), (x, y), turn, velocity)
    enable_body(parameters[block])
    enable_joint(joint, holder, bodies[block])


@njit
def move_mast(world, mast, gripper):  # type: ignore[no-untyped-def]
    """Move the mast, which collides with nothing, onto the gripper."""
    at = world.state.bodies[gripper].position
    place_upright(world, mast, at[0], at[1] + 0.1 + _MAST_LENGTH)


# ---------------------------------------------------------------- apply actions


@njit
def steer(control, drive, right, up, turn, low_x, high_x):  # type: ignore[no-untyped-def]
    """Apply actions in [-1, 1] to the three actuators of a gripper; its target stays within reach."""
    place = drive.target_position
    control[0] = within(_SPEED * right, _SPEED, place[0], low_x, high_x)
    control[1] = within(_SPEED * up, _SPEED, place[1], _LOW_Y, _HIGH_Y)
    control[2] = within(_TURN_SPEED * turn, _TURN_SPEED, drive.target_angle, -_REACH_ANGLE, _REACH_ANGLE)


# ---------------------------------------------------------------- evaluate


@njit
def touches(contacts, levels, base, first_gripper, first_block):  # type: ignore[no-untyped-def]
    """Return bit masks of the blocks: (resting on the level below, touched by a gripper).

    `base`, `first_gripper`, `first_block` are indices of bodies, in this order.
    """
    resting = 0
    gripped = 0
    for i in range(len(contacts)):
        contact = contacts[i]
        if not is_touching(contact):
            continue
        a = min(contact.body_a, contact.body_b)
        b = max(contact.body_a, contact.body_b) - first_block
        if b < 0:
            continue
        if a >= first_block:
            a -= first_block
            if levels[b] == levels[a] + 1:
                resting |= 1 << b
            elif levels[a] == levels[b] + 1:
                resting |= 1 << a
        elif a >= first_gripper:
            gripped |= 1 << b
        elif a == base and levels[b] == 0:
            resting |= 1 << b
    return resting, gripped


@njit
def _calm(body):  # type: ignore[no-untyped-def]
    v = body.velocity
    return v[0] * v[0] + v[1] * v[1] < REST_SPEED**2 and abs(v[2]) < 1.5 * REST_SPEED


@njit
def steady_blocks(contacts, levels, blocks, base, first_gripper, first_block):  # type: ignore[no-untyped-def]
    """Return the bit mask of the blocks that rest on the level below, slow, with no gripper on them."""
    resting, gripped = touches(contacts, levels, base, first_gripper, first_block)
    steady = resting & ~gripped
    for k in range(len(levels)):
        if not _calm(blocks[k]):
            steady &= ~(1 << k)
    return steady


@njit
def any_fallen(released, base, order, blocks, shapes):  # type: ignore[no-untyped-def]
    """Whether a released block has tipped or sunk below its level."""
    below = base
    for level in range(released):
        k = order[level]
        half = shapes[k].size[1]
        if abs(blocks[k].angle) > TIPPED or blocks[k].position[1] < below + half - SUNK * half:
            return True
        below += 2.0 * half
    return False


@njit
def vertical_reach(block, shape):  # type: ignore[no-untyped-def]
    """Return half the height in m that a rotated block takes up."""
    return shape.size[0] * abs(block.rotation[1]) + shape.size[1] * abs(block.rotation[0])


@njit
def tower_top(released, base, order, blocks, shapes):  # type: ignore[no-untyped-def]
    """Return the height in m of the highest point of the released blocks, or of the base."""
    top = base
    for level in range(released):
        k = order[level]
        top = max(top, blocks[k].position[1] + vertical_reach(blocks[k], shapes[k]))
    return top


@njit
def fastest(released, order, blocks):  # type: ignore[no-untyped-def]
    """Return the speed in m/s of the fastest released block."""
    square = 0.0
    for level in range(released):
        v = blocks[order[level]].velocity
        square = max(square, v[0] * v[0] + v[1] * v[1])
    return math.sqrt(square)


@njit
def meets(x, y, reach, block, shape):  # type: ignore[no-untyped-def]
    """Whether a circle meets a block."""
    dx = x - block.position[0]
    dy = y - block.position[1]
    c, s = block.rotation[0], block.rotation[1]
    u = max(abs(c * dx + s * dy) - shape.size[0], 0.0)
    v = max(abs(c * dy - s * dx) - shape.size[1], 0.0)
    return u * u + v * v < reach * reach


# ---------------------------------------------------------------- observe


@njit
def observe_gripper(out, gripper, drive, time):  # type: ignore[no-untyped-def]
    """Write nine numbers: pose, velocity, and the drive's forces relative to their bounds."""
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
def observe_block(out, held, block, body, shape, gripper, x, top):  # type: ignore[no-untyped-def]
    """Write entries 9 to 20: a block relative to its support, whose middle is at x and whose top is at `top`."""
    out[9] = 1.0 if held else 0.0
    out[10] = block.position[0] - x
    out[11] = block.position[1] - vertical_reach(block, shape) - top
    out[12] = block.angle
    out[13] = block.velocity[0]
    out[14] = block.velocity[1]
    out[15] = block.velocity[2]
    out[16] = shape.size[0]
    out[17] = shape.size[1]
    out[18] = body.mass / 10.0
    out[19] = shape.friction
    out[20] = gripper.position[0] - block.position[0]


@njit
def landing(block, shape, top, gravity):  # type: ignore[no-untyped-def]
    """Return (gap in m, drop speed in m/s) of a block above its support, whose top is at `top`."""
    gap = block.position[1] - vertical_reach(block, shape) - top
    sinking = -block.velocity[1] + abs(block.velocity[2] * block.rotation[0]) * shape.size[0]
    return gap, impacts.drop_speed(gap, sinking, -gravity[1])
