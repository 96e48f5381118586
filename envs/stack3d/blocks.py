"""Blocks in a gripper and on a 3D tower: the jitted parts of GStack3D-v0's rules.

`blocks` and `shapes` are records of the blocks alone; block k belongs at level k, the first one on the ground.
"""

from __future__ import annotations

import math

from gsenv.envs.core.kernels import active_contacts, between
from gsenv.envs.stack import impacts
from gsenv.envs.stack.shared_rules import REST_SPEED, SUNK, TIPPED, is_touching, within
from gsenv.envs.stack3d import scene
from gsenv.solver.core.edit import enable_body, enable_joint, place_body, set_box
from gsenv.solver.core.trig import atan2
from gsenv.solver.jit import njit
from gsenv.solver.spatial.math import (
    add,
    conjugate,
    cross,
    multiply,
    norm,
    normalised,
    quaternion,
    sub,
    turn_of,
    turned,
    vec,
)

DRAWS_PER_BLOCK = 8
TWISTED = 0.3  # rad, against the sides of the block below
TWIST_WEIGHT = 0.3  # m per rad, in the distance of the approach

LIFT = scene.PAD_HEIGHT + scene.GAP
UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # quaternion
AT_REST = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # velocity

_LIFT = LIFT
_MAST_RISE = scene.MAST_FOOT + scene.MAST_HALF_LENGTH
_SPEED = scene.SPEED
_TURN_SPEED = scene.TURN_SPEED
_REACH = scene.REACH
_LOW_Z, _HIGH_Z = scene.REACH_Z
_REACH_ANGLE = scene.REACH_ANGLE
_BLOCK = scene.FIRST_BLOCK
_GRIPPER = scene.GRIPPER_BODY
_GROUND = scene.GROUND_BODY
_LEAST_UP = math.cos(TIPPED)
_QUARTER = 0.5 * math.pi


# ---------------------------------------------------------------- rotations


@njit
def heading(q):  # type: ignore[no-untyped-def]
    """Return the heading in rad of a rotation (4,): its angle about the vertical."""
    return atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]))


@njit
def upwards(q):  # type: ignore[no-untyped-def]
    """Return the body's own z axis in the world."""
    return 2.0 * (q[1] * q[3] + q[0] * q[2]), 2.0 * (q[2] * q[3] - q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2])


@njit
def to_sides(angle):  # type: ignore[no-untyped-def]
    """Return an angle relative to the nearest of four sides, from -pi/4 to pi/4."""
    return angle - _QUARTER * math.floor(angle / _QUARTER + 0.5)


# ---------------------------------------------------------------- initialize


@njit
def make_block(task, draws, body, shape, weld):  # type: ignore[no-untyped-def]
    """Set size, mass, friction and grasp of a block from its eight draws; `task`, the task state, has the ranges."""
    x = between(task.half_width[0], task.half_width[1], draws[0])
    y = between(task.half_width[0], task.half_width[1], draws[1])
    z = between(task.half_height[0], task.half_height[1], draws[2])
    set_box(body, shape, (x, y, z), between(task.mass[0], task.mass[1], draws[3]))
    shape.friction = between(task.friction[0], task.friction[1], draws[4])
    offset = task.grasp_offset
    weld.anchor_a[0] = 0.0
    weld.anchor_a[1] = 0.0
    weld.anchor_a[2] = -_LIFT
    weld.anchor_b[0] = between(-offset, offset, draws[5]) * x
    weld.anchor_b[1] = between(-offset, offset, draws[6]) * y
    weld.anchor_b[2] = z
    q = turn_of((0.0, 0.0, between(-task.grasp_turn, task.grasp_turn, draws[7])))
    for d in range(4):
        weld.reference[d] = q[d]


@njit
def place_upright(world, body, at):  # type: ignore[no-untyped-def]
    """Place a body at rest and not rotated."""
    place_body(body, world.state.bodies, world.parameters.bodies, active_contacts(world), at, UPRIGHT, AT_REST)


@njit
def grasp_pose(gripper, weld):  # type: ignore[no-untyped-def]
    """Return (position, quaternion) of a block in the gripper."""
    own = quaternion(gripper.rotation)
    q = multiply(own, quaternion(weld.reference))
    anchor = add(vec(gripper.position), turned(own, vec(weld.anchor_a)))
    return sub(anchor, turned(q, vec(weld.anchor_b))), q


@njit
def hand_over(world, gripper, block, weld):  # type: ignore[no-untyped-def]
    """Place a block in the gripper, so that it moves with it; both are indices of bodies."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    holder = bodies[gripper]
    joint = world.parameters.joints[weld]
    at, q = grasp_pose(holder, joint)
    v = holder.velocity
    spin = (v[3], v[4], v[5])
    swing = cross(spin, sub(at, vec(holder.position)))
    velocity = (v[0] + swing[0], v[1] + swing[1], v[2] + swing[2], v[3], v[4], v[5])
    place_body(block, bodies, parameters, active_contacts(world), at, normalised(q), velocity)
    enable_body(parameters[block])
    enable_joint(joint, holder, bodies[block])


@njit
def move_mast(world, mast, gripper):  # type: ignore[no-untyped-def]
    """Move the mast, which collides with nothing, onto the gripper."""
    at = world.state.bodies[gripper].position
    place_upright(world, mast, (at[0], at[1], at[2] + _MAST_RISE))


# ---------------------------------------------------------------- apply actions


@njit
def steer(control, drive, action):  # type: ignore[no-untyped-def]
    """Apply actions in [-1, 1] to the four actuators of the gripper; its target stays within reach and upright."""
    place = drive.target_position
    control[0] = within(_SPEED * action[0], _SPEED, place[0], -_REACH, _REACH)
    control[1] = within(_SPEED * action[1], _SPEED, place[1], -_REACH, _REACH)
    control[2] = within(_SPEED * action[2], _SPEED, place[2], _LOW_Z, _HIGH_Z)
    angle = heading(drive.target_rotation)
    control[3] = within(_TURN_SPEED * action[3], _TURN_SPEED, angle, -_REACH_ANGLE, _REACH_ANGLE)
    # where the gripper is pushed over, the target has gone with it
    q = turn_of((0.0, 0.0, angle))
    for d in range(4):
        drive.target_rotation[d] = q[d]


# ---------------------------------------------------------------- evaluate


@njit
def touches(contacts):  # type: ignore[no-untyped-def]
    """Return bit masks of the blocks: (resting on the level below, touched by the gripper)."""
    resting = 0
    gripped = 0
    for i in range(len(contacts)):
        contact = contacts[i]
        if not is_touching(contact):
            continue
        a = min(contact.body_a, contact.body_b)
        b = max(contact.body_a, contact.body_b) - _BLOCK
        if b < 0:
            continue
        if a == _GRIPPER:
            gripped |= 1 << b
        elif (a == _GROUND and b == 0) or a - _BLOCK == b - 1 >= 0:
            resting |= 1 << b
    return resting, gripped


@njit
def _calm(body):  # type: ignore[no-untyped-def]
    v = body.velocity
    slow = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < REST_SPEED**2
    return slow and v[3] * v[3] + v[4] * v[4] + v[5] * v[5] < (1.5 * REST_SPEED) ** 2


@njit
def steady_blocks(contacts, blocks):  # type: ignore[no-untyped-def]
    """Return the bit mask of the blocks that rest on the level below, slow, with no gripper on them."""
    resting, gripped = touches(contacts)
    steady = resting & ~gripped
    for k in range(len(blocks)):
        if not _calm(blocks[k]):
            steady &= ~(1 << k)
    return steady


@njit
def twist(k, blocks):  # type: ignore[no-untyped-def]
    """Return the twist in rad of block k relative to the sides of the one below; 0 for the first block."""
    if k == 0:
        return 0.0
    return to_sides(heading(blocks[k].rotation) - heading(blocks[k - 1].rotation))


@njit
def any_fallen(released, blocks, shapes):  # type: ignore[no-untyped-def]
    """Whether a released block has tipped, sunk below its level or lies across the one below."""
    below = 0.0
    for k in range(released):
        half = shapes[k].size[2]
        if blocks[k].position[2] < below + half - SUNK * half or upwards(blocks[k].rotation)[2] < _LEAST_UP:
            return True
        if abs(twist(k, blocks)) > TWISTED:
            return True
        below += 2.0 * half
    return False


@njit
def vertical_reach(block, shape):  # type: ignore[no-untyped-def]
    """Return half the height in m that a rotated block takes up."""
    q = block.rotation
    x = 2.0 * (q[1] * q[3] - q[0] * q[2])
    y = 2.0 * (q[2] * q[3] + q[0] * q[1])
    z = 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2])
    return shape.size[0] * abs(x) + shape.size[1] * abs(y) + shape.size[2] * abs(z)


@njit
def landing(block, shape, top, gravity):  # type: ignore[no-untyped-def]
    """Return (gap in m, drop speed in m/s) of a block above its support, whose top is at `top`."""
    gap = block.position[2] - vertical_reach(block, shape) - top
    spin = math.sqrt(block.velocity[3] ** 2 + block.velocity[4] ** 2)
    sinking = -block.velocity[2] + spin * max(shape.size[0], shape.size[1])
    return gap, impacts.drop_speed(gap, sinking, -gravity[2])


@njit
def tower_top(released, blocks, shapes):  # type: ignore[no-untyped-def]
    """Return the height in m of the highest point of the released blocks, or of the ground."""
    top = 0.0
    for k in range(released):
        top = max(top, blocks[k].position[2] + vertical_reach(blocks[k], shapes[k]))
    return top


@njit
def fastest(released, blocks):  # type: ignore[no-untyped-def]
    """Return the speed in m/s of the fastest released block."""
    speed = 0.0
    for k in range(released):
        v = blocks[k].velocity
        speed = max(speed, norm((v[0], v[1], v[2])))
    return speed


@njit
def meets(at, reach, block, shape):  # type: ignore[no-untyped-def]
    """Whether a ball meets a block."""
    local = turned(conjugate(quaternion(block.rotation)), sub(at, vec(block.position)))
    square = 0.0
    for d in range(3):
        out = max(abs(local[d]) - shape.size[d], 0.0)
        square += out * out
    return square < reach * reach
