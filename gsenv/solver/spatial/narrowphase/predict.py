"""Future contacts of the step: the manifold when the shapes touch. See planar/narrowphase/predict.py."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.faces import NO_FACE
from ...core.geometry import APART, MAX_ADVANCES, MEET, MISS, MovingShape, placed, share_of, swing_speed
from ...jit import njit
from ..math import Vec, add, dot, scaled, sub, vec
from .motion import Motion, velocity_of
from .table import collide


@njit
def predict(
    shapes: Any, a: MovingShape, b: MovingShape, timestep: float, margin: float, touching: float, narrowphase: Any
) -> tuple[int, float]:
    """Find the manifold at the time of contact, expressed at the present, and the distance in m of a miss.

    The outcome is MEET, or MISS with the manifold at the time when this is known, which is invalid if its
    separation is infinite.  `narrowphase.manifold` is that of the present poses before the call, and remains
    so if the shapes cannot touch in the step (APART); a gap of `touching` m counts as contact.
    """
    m = narrowphase.manifold
    one = a.motion
    other = b.motion
    swing = swing_speed(a, b)
    time = 0.0
    for _ in range(MAX_ADVANCES):
        if not m.separation < np.inf:
            return MISS, np.inf
        # largest speed at which the gap closes
        speed = swing + dot(vec(m.normal), sub(one.velocity, other.velocity))
        miss = m.separation - speed * (timestep - time)
        if not miss < 0.0:
            if time == 0.0:
                return APART, miss
            bring_back(m, a, b, time)
            return MISS, miss
        time += m.separation / speed
        collide(shapes, placed(a, time), placed(b, time), margin, narrowphase)
        if m.separation <= touching:
            break
    bring_back(m, a, b, time)
    return MEET, 0.0


@njit
def bring_back(m: Any, a: MovingShape, b: MovingShape, time: float) -> None:
    """Express a manifold of `time` s ahead at the present.

    Each separation grows by the approach until then, so that the bound "normal velocity >=
    -separation / timestep" stops the bodies where they touch.  The points move back with the
    lighter body, whose lever arm they must have.
    """
    share = share_of(a, b)
    back = scaled(add(scaled(a.motion.velocity, share), scaled(b.motion.velocity, 1.0 - share)), time)
    n = vec(m.normal)
    m.face = NO_FACE
    for k in range(m.count):
        p = (m.point[k, 0], m.point[k, 1], m.point[k, 2])
        gap = time * closing_speed(n, a.motion, b.motion, p, time)
        m.gap[k] += gap
        if k == 0:
            m.separation += gap
        for d in range(3):
            m.point[k, d] -= back[d]


@njit
def closing_speed(n: Vec, a: Motion, b: Motion, p: Vec, time: float) -> float:
    """Return the approach speed along the normal of the material points at p after `time` s, m/s."""
    return dot(n, sub(velocity_of(a, p, time), velocity_of(b, p, time)))
