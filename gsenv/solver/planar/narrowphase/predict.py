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
from gsenv.solver.planar.narrowphase.motion import Motion, advanced
from gsenv.solver.planar.narrowphase.table import collide

Array = NDArray[Any]

MAX_ADVANCES = 12


@njit
def approach_speed(m: Manifold, one: Motion, other: Motion) -> float:
    """Upper bound in m/s of how fast the gap along the normal can close."""
    linear = m.normal_x * (one.velocity_x - other.velocity_x) + m.normal_y * (
        one.velocity_y - other.velocity_y
    )
    return linear + abs(one.spin) * one.swing + abs(other.spin) * other.swing


@njit
def predict(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    motion_a: Motion,
    motion_b: Motion,
    now: Manifold,
    margin: float,
    touching: float,
    timestep: float,
) -> tuple[Manifold, float]:
    """(manifold at the time of contact, that time in s); no points if there is none in the step.

    `now` is the manifold at the present poses; a gap of `touching` m counts as contact.
    """
    m = now
    time = 0.0
    for _ in range(MAX_ADVANCES):
        if not m.separation < np.inf:
            return no_manifold(), time
        speed = approach_speed(m, motion_a, motion_b)
        if not speed * (timestep - time) > m.separation:
            return no_manifold(), time
        time += m.separation / speed
        m = collide(
            shape_models, shape_parameters, vertices, a, b,
            advanced(pose_a, motion_a, time), advanced(pose_b, motion_b, time), margin,
        )  # fmt: skip
        if m.separation <= touching:
            break
    return m, time
