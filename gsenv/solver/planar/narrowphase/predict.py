"""Contacts that are still to come: the manifold where and when the shapes meet.

A fast body may be far from what it will hit in this step, and the normal at the present pose may
be wrong (a ball that passes over a corner would be thrown back by it).  So the pair is moved ahead
until it touches (conservative advancement: no step is longer than gap / greatest approach speed;
B. Mirtich, "Impulse-based Dynamic Simulation", 1996), and the manifold found there is used.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose
from gsenv.solver.planar.narrowphase.manifold import Manifold, no_manifold
from gsenv.solver.planar.narrowphase.motion import Motion, advanced, motion_of, velocity_of
from gsenv.solver.planar.narrowphase.table import collide

Array = NDArray[Any]

MAX_ADVANCES = 12


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
    now: Manifold,
    gravity: Array,
    timestep: float,
    margin: float,
    touching: float,
) -> Manifold:
    """Manifold at the time of contact, told for the present; without points if there is none.

    `now` is the manifold at the present poses; a gap of `touching` m counts as contact.
    """
    body_a = shape_models[a].body
    body_b = shape_models[b].body
    parameter_a = body_parameters[body_a]
    parameter_b = body_parameters[body_b]
    motion_a = motion_of(bodies[body_a], parameter_a, body_models[body_a].kind, gravity, timestep)
    motion_b = motion_of(bodies[body_b], parameter_b, body_models[body_b].kind, gravity, timestep)
    swing = abs(motion_a.spin) * motion_a.swing + abs(motion_b.spin) * motion_b.swing
    m = now
    time = 0.0
    for _ in range(MAX_ADVANCES):
        if not m.separation < np.inf:
            return no_manifold()
        speed = (
            swing
            + m.normal_x * (motion_a.velocity_x - motion_b.velocity_x)
            + m.normal_y * (motion_a.velocity_y - motion_b.velocity_y)
        )  # the gap closes no faster
        if not speed * (timestep - time) > m.separation:
            return no_manifold()
        time += m.separation / speed
        m = collide(
            shape_models, shape_parameters, vertices, a, b,
            advanced(pose_a, motion_a, time), advanced(pose_b, motion_b, time), margin,
        )  # fmt: skip
        if m.separation <= touching:
            break
    return brought_back(m, motion_a, motion_b, parameter_a.inv_mass, parameter_b.inv_mass, time)


@njit
def brought_back(
    m: Manifold, a: Motion, b: Motion, inv_mass_a: float, inv_mass_b: float, time: float
) -> Manifold:
    """A manifold of `time` s ahead, told for the present.

    Each separation grows by what is covered until then, so that the bound "normal velocity >=
    -separation / timestep" stops the bodies just where they meet.  The points move back with the
    lighter body, whose lever arm they must have.
    """
    weight = inv_mass_a / (inv_mass_a + inv_mass_b) if inv_mass_a + inv_mass_b > 0.0 else 0.5
    back_x = time * (weight * a.velocity_x + (1.0 - weight) * b.velocity_x)
    back_y = time * (weight * a.velocity_y + (1.0 - weight) * b.velocity_y)
    gap0 = time * closing_speed(m, a, b, m.x0, m.y0, time)
    gap1 = time * closing_speed(m, a, b, m.x1, m.y1, time)
    return Manifold(
        m.points, m.normal_x, m.normal_y, m.separation + gap0,
        m.x0 - back_x, m.y0 - back_y, m.separation0 + gap0, m.feature0,
        m.x1 - back_x, m.y1 - back_y, m.separation1 + gap1, m.feature1,
    )  # fmt: skip


@njit
def closing_speed(m: Manifold, a: Motion, b: Motion, x: float, y: float, time: float) -> float:
    """How fast the material points at (x, y) come together along the normal after `time` s."""
    ax, ay = velocity_of(a, x, y, time)
    bx, by = velocity_of(b, x, y, time)
    return m.normal_x * (ax - bx) + m.normal_y * (ay - by)
