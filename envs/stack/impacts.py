"""Impacts that crack blocks, in 2D and 3D: how fast what has just touched came together, and the gantry's sway.

An impact's speed is that at which the two bodies of a contact approach along its normal, at its point, when they
meet. Contacts of a gripper, and of what carries it, crack nothing.
"""

from __future__ import annotations

import math
from typing import Any

from gsenv.envs.core.kernels import active_contacts, between
from gsenv.solver.core.trig import sin_cos
from gsenv.solver.jit import njit

DROP_WEIGHT = 0.4  # m per m/s, in the distance of the approach
CLOSE = (-0.05, 0.1)  # m, bounds of `near_gap`

# Fields of the task state.
FIELDS: list[tuple[Any, ...]] = [
    ("impact", "f8"),  # m/s, the fastest impact of the last control step
    ("cracked", "i8"),  # bit mask of the blocks
]

SWAY_DRAWS = 4  # of each axis: frequency and phase of two sines
SWAY_SHARES = (0.6, 0.4)  # of the amplitude
SLOW, FAST = (0.2, 0.5), (0.6, 1.2)  # Hz, of the two sines


def sway_fields(axes: int) -> list[tuple[Any, ...]]:
    """Return the fields of a gantry that sways along a number of axes."""
    return [("sway", "f8"), ("sway_rate", "f8", (2 * axes,)), ("sway_phase", "f8", (2 * axes,))]  # m/s, rad/s, rad


_SLOW_SHARE, _FAST_SHARE = SWAY_SHARES
_LEAST_SLOW, _MOST_SLOW = SLOW
_LEAST_FAST, _MOST_FAST = FAST
_DROP_WEIGHT = DROP_WEIGHT
_LOWEST_GAP, _HIGHEST_GAP = CLOSE


# ---------------------------------------------------------------- impacts


@njit
def _velocity_along(body, point, normal):  # type: ignore[no-untyped-def]
    """Return the velocity along the normal of a body's material point."""
    v, x = body.velocity, body.position
    if len(normal) == 2:
        return normal[0] * (v[0] - v[2] * (point[1] - x[1])) + normal[1] * (v[1] + v[2] * (point[0] - x[0]))
    r0, r1, r2 = point[0] - x[0], point[1] - x[1], point[2] - x[2]
    along = normal[0] * (v[0] + v[4] * r2 - v[5] * r1) + normal[1] * (v[1] + v[5] * r0 - v[3] * r2)
    return along + normal[2] * (v[2] + v[3] * r1 - v[4] * r0)


@njit
def _moved_along(before, after, point, normal):  # type: ignore[no-untyped-def]
    """Return how far, to first order, a body's material point has moved along the normal since `before`."""
    x = before.position
    moved = 0.0
    for d in range(len(normal)):
        moved += normal[d] * (after.position[d] - x[d])
    p, q = before.rotation, after.rotation
    if len(normal) == 2:
        turn = p[0] * q[1] - p[1] * q[0]
        return moved + turn * (normal[1] * (point[0] - x[0]) - normal[0] * (point[1] - x[1]))
    r0, r1, r2 = point[0] - x[0], point[1] - x[1], point[2] - x[2]
    t0 = 2.0 * (p[0] * q[1] - p[1] * q[0] - p[3] * q[2] + p[2] * q[3])
    t1 = 2.0 * (p[0] * q[2] - p[2] * q[0] - p[1] * q[3] + p[3] * q[1])
    t2 = 2.0 * (p[0] * q[3] - p[3] * q[0] - p[2] * q[1] + p[1] * q[2])
    moved += normal[0] * (t1 * r2 - t2 * r1) + normal[1] * (t2 * r0 - t0 * r2)
    return moved + normal[2] * (t0 * r1 - t1 * r0)


@njit
def impact_speed(contact, before, after, gravity, falling):  # type: ignore[no-untyped-def]
    """Return the speed in m/s at which the bodies of a contact met within the last step.

    That is their speed of approach at the start of the step; body `falling`, or none where it is negative, gains
    what gravity adds over the gap that it had then.
    """
    a, b = contact.body_a, contact.body_b
    point, normal = contact.point, contact.normal
    speed = _velocity_along(before[a], point, normal) - _velocity_along(before[b], point, normal)
    square = max(speed, 0.0) ** 2
    if a == falling or b == falling:
        closing = _moved_along(before[a], after[a], point, normal) - _moved_along(before[b], after[b], point, normal)
        pull = 0.0
        for d in range(len(normal)):
            pull += gravity[d] * normal[d]
        gain = (pull if a == falling else -pull) * (contact.separation + closing)
        square += 2.0 * max(gain, 0.0)
    return math.sqrt(square)


@njit
def note_impacts(world, before, falling, first_gripper, first_block):  # type: ignore[no-untyped-def]
    """Note the fastest impact of a step and the blocks that it cracked; `before`: the bodies at its start.

    `falling`, `first_gripper`, `first_block` are indices of bodies; those between the latter two are grippers.
    """
    task, contacts = world.task.state, active_contacts(world)
    for i in range(len(contacts)):
        contact = contacts[i]
        a, b = contact.body_a, contact.body_b
        if contact.total_impulse[0] <= 0.0 or max(a, b) < first_block:
            continue
        if first_gripper <= min(a, b) < first_block:
            continue
        speed = impact_speed(contact, before, world.state.bodies, world.parameters.world.gravity, falling)
        task.impact = max(task.impact, speed)
        if speed > task.crack_speed:
            if a >= first_block:
                task.cracked |= 1 << (a - first_block)
            if b >= first_block:
                task.cracked |= 1 << (b - first_block)


@njit
def drop_speed(gap, sinking, gravity):  # type: ignore[no-untyped-def]
    """Return the speed in m/s at which a block would land if it were let go.

    `gap`: m, of its lowest point above its support; `sinking`: m/s, speed of that downwards; `gravity`: m/s^2.
    """
    return math.sqrt(max(sinking, 0.0) ** 2 + 2.0 * gravity * max(gap, 0.0))


@njit
def descent(gap, speed):  # type: ignore[no-untyped-def]
    """Return the part of the distance of a block from its place, in m, that its height and its drop speed have."""
    return max(-gap, 0.0) + _DROP_WEIGHT * speed


@njit
def observe_landing(out, first, gap, speed, crack_speed):  # type: ignore[no-untyped-def]
    """Write two entries: the gap of a block above its support, and its drop speed over that which cracks it."""
    out[first] = min(max(gap, _LOWEST_GAP), _HIGHEST_GAP)
    out[first + 1] = speed / crack_speed


# ---------------------------------------------------------------- sway


@njit
def draw_sway(task, draws, axes):  # type: ignore[no-untyped-def]
    """Set frequencies and phases of the sway of each axis from four draws."""
    for k in range(axes):
        given = draws[4 * k : 4 * k + 4]
        task.sway_rate[2 * k] = 2.0 * math.pi * between(_LEAST_SLOW, _MOST_SLOW, given[0])
        task.sway_rate[2 * k + 1] = 2.0 * math.pi * between(_LEAST_FAST, _MOST_FAST, given[1])
        task.sway_phase[2 * k] = 2.0 * math.pi * given[2]
        task.sway_phase[2 * k + 1] = 2.0 * math.pi * given[3]


@njit
def add_sway(control, task, time, axes):  # type: ignore[no-untyped-def]
    """Add the velocity of the sway to the first `axes` actuators; `time`: s since the start of the episode."""
    if task.sway > 0.0:
        for k in range(axes):
            _, slow = sin_cos(task.sway_rate[2 * k] * time + task.sway_phase[2 * k])
            _, fast = sin_cos(task.sway_rate[2 * k + 1] * time + task.sway_phase[2 * k + 1])
            control[k] += task.sway * (_SLOW_SHARE * slow + _FAST_SHARE * fast)
