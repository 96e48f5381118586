"""Contacts that are still to come: the manifold where and when the shapes meet. See planar/narrowphase/predict.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.spatial.math import Pose, Vec, add, dot, norm, scaled, sub, vec
from gsenv.solver.spatial.narrowphase.motion import Motion, advanced, motion_of, velocity_of
from gsenv.solver.spatial.narrowphase.table import collide

Array = NDArray[Any]

MAX_ADVANCES = 12
APART, MISS, MEET = 0, 1, 2


@njit
def predict(
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    gravity: Array,
    timestep: float,
    margin: float,
    touching: float,
    m: Any,
    scratch: Any,
    convex: Any,
) -> tuple[int, float]:
    """Manifold at the time of contact, told for the present, and by how much the two miss each other, m.

    MEET, or MISS: that of the time when this is known; of no use if its separation is infinite.

    `m` holds the manifold at the present poses, and still does if they can't meet in the step at all (APART);
    a gap of `touching` m counts as contact.
    """
    body_a = shape_models[a].body
    body_b = shape_models[b].body
    parameter_a = body_parameters[body_a]
    parameter_b = body_parameters[body_b]
    motion_a = motion_of(bodies[body_a], parameter_a, body_models[body_a].kind, gravity, timestep)
    motion_b = motion_of(bodies[body_b], parameter_b, body_models[body_b].kind, gravity, timestep)
    swing = norm(motion_a.spin) * motion_a.swing + norm(motion_b.spin) * motion_b.swing
    time = 0.0
    for _ in range(MAX_ADVANCES):
        if not m.separation < np.inf:
            return MISS, np.inf
        # the gap closes no faster
        speed = swing + dot(vec(m.normal), sub(motion_a.velocity, motion_b.velocity))
        miss = m.separation - speed * (timestep - time)
        if not miss < 0.0:
            if time == 0.0:
                return APART, miss
            bring_back(m, motion_a, motion_b, parameter_a.inv_mass, parameter_b.inv_mass, time)
            return MISS, miss
        time += m.separation / speed
        collide(
            shape_models, shape_parameters, vertices, a, b,
            advanced(pose_a, motion_a, time), advanced(pose_b, motion_b, time), margin, m, scratch, convex,
        )  # fmt: skip
        if m.separation <= touching:
            break
    bring_back(m, motion_a, motion_b, parameter_a.inv_mass, parameter_b.inv_mass, time)
    return MEET, 0.0


@njit
def bring_back(m: Any, a: Motion, b: Motion, inv_mass_a: float, inv_mass_b: float, time: float) -> None:
    """A manifold of `time` s ahead, told for the present.

    Each separation grows by what is covered until then, so that the bound "normal velocity >=
    -separation / timestep" stops the bodies just where they meet.  The points move back with the
    lighter body, whose lever arm they must have.
    """
    weight = inv_mass_a / (inv_mass_a + inv_mass_b) if inv_mass_a + inv_mass_b > 0.0 else 0.5
    back = scaled(add(scaled(a.velocity, weight), scaled(b.velocity, 1.0 - weight)), time)
    n = vec(m.normal)
    for k in range(m.count):
        p = (m.point[k, 0], m.point[k, 1], m.point[k, 2])
        gap = time * closing_speed(n, a, b, p, time)
        m.gap[k] += gap
        if k == 0:
            m.separation += gap
        for d in range(3):
            m.point[k, d] -= back[d]


@njit
def closing_speed(n: Vec, a: Motion, b: Motion, p: Vec, time: float) -> float:
    """How fast the material points at p come together along the normal after `time` s."""
    return dot(n, sub(velocity_of(a, p, time), velocity_of(b, p, time)))
