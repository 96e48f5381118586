"""Future contacts of the step: the manifold at the pose and time at which the shapes touch.

A fast body may be far from what it will hit in this step, and the normal at the present pose may
be wrong (a ball that passes over a corner would be thrown back by it).  So the pair is moved ahead
until it touches (conservative advancement: no step is longer than gap / largest approach speed;
B. Mirtich, "Impulse-based Dynamic Simulation", 1996), and the manifold found there is used.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.faces import NO_FACE
from ...core.geometry import APART, MAX_ADVANCES, MEET, MISS, MovingShape, placed, share_of, swing_speed
from ...jit import njit
from .manifold import Manifold, no_manifold
from .motion import Motion, velocity_of
from .table import collide


@njit
def predict(
    shapes: Any, a: MovingShape, b: MovingShape, now: Manifold, timestep: float, margin: float, touching: float
) -> tuple[int, float, Manifold]:
    """Return (outcome, distance in m of a miss, manifold at the time of contact, expressed at the present).

    `now` is the manifold at the present poses; a gap of `touching` m counts as contact.  The outcome is MEET;
    or MISS with the manifold at the time when this is known, without points if the shapes are beyond the margin
    then; or APART with the present one if the shapes cannot touch in the step.
    """
    one = a.motion
    other = b.motion
    swing = swing_speed(a, b)
    m = now
    time = 0.0
    for _ in range(MAX_ADVANCES):
        if not m.separation < np.inf:
            return MISS, np.inf, no_manifold()
        speed = (
            swing + m.normal_x * (one.velocity_x - other.velocity_x) + m.normal_y * (one.velocity_y - other.velocity_y)
        )  # largest speed at which the gap closes
        miss = m.separation - speed * (timestep - time)
        if not miss < 0.0:
            if time == 0.0:
                return APART, miss, now
            return MISS, miss, brought_back(m, a, b, time)
        time += m.separation / speed
        m = collide(shapes, shapes.vertices, placed(a, time), placed(b, time), margin)
        if m.separation <= touching:
            break
    return MEET, 0.0, brought_back(m, a, b, time)


@njit
def brought_back(m: Manifold, a: MovingShape, b: MovingShape, time: float) -> Manifold:
    """Return a manifold of `time` s ahead, expressed at the present.

    Each separation grows by the approach until then, so that the bound "normal velocity >=
    -separation / timestep" stops the bodies where they touch.  The points move back with the
    lighter body, whose lever arm they must have.
    """
    one = a.motion
    other = b.motion
    share = share_of(a, b)
    back_x = time * (share * one.velocity_x + (1.0 - share) * other.velocity_x)
    back_y = time * (share * one.velocity_y + (1.0 - share) * other.velocity_y)
    gap0 = time * closing_speed(m, one, other, m.x0, m.y0, time)
    gap1 = time * closing_speed(m, one, other, m.x1, m.y1, time)
    return Manifold(
        m.points, m.normal_x, m.normal_y, m.separation + gap0,
        m.x0 - back_x, m.y0 - back_y, m.separation0 + gap0, m.feature0,
        m.x1 - back_x, m.y1 - back_y, m.separation1 + gap1, m.feature1, NO_FACE, 0.0,
    )  # fmt: skip


@njit
def closing_speed(m: Manifold, a: Motion, b: Motion, x: float, y: float, time: float) -> float:
    """Return the approach speed along the normal of the material points at (x, y) after `time` s, m/s."""
    ax, ay = velocity_of(a, x, y, time)
    bx, by = velocity_of(b, x, y, time)
    return m.normal_x * (ax - bx) + m.normal_y * (ay - by)
