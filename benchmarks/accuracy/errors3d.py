"""Errors of trajectories that only spatial scenes have; the others are in errors.py."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from .errors import crossings, energies
from .geometry3d import conjugate, deepest_ball_overlap, rotated
from .trajectory import Trajectory

Array = NDArray[np.float64]

__all__ = ["ball_overlap", "crossings", "flip_times", "precession_error", "slope_error", "tumbling_error"]


def slope_error(trajectory: Trajectory, law: Callable[[Array], Array], direction: Sequence[float]) -> float:
    """How far body 1 is from where it should be along ``direction``, at worst, over its distance at the end; m if
    that is 0. Going astray sideways counts."""
    moved = trajectory.position[:, 1] - trajectory.position[0, 1]
    expected = law(trajectory.times)
    away = np.linalg.norm(moved - expected[:, None] * np.asarray(direction), axis=-1)
    return float(away.max()) / (float(expected[-1]) or 1.0)


def flip_times(inertia: Sequence[float], spin: Sequence[float], seconds: float, step: float = 1e-3) -> Array:
    """s: when the spin about the middle axis of a free body changes its sign, by Runge-Kutta steps of Euler's
    equations I w' = (I w) x w."""
    a, b, c = inertia
    k = ((b - c) / a, (c - a) / b, (a - b) / c)

    def rate(w: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = w
        return k[0] * y * z, k[1] * z * x, k[2] * x * y

    def ahead(w: tuple[float, float, float], r: tuple[float, float, float], h: float) -> tuple[float, float, float]:
        return w[0] + h * r[0], w[1] + h * r[1], w[2] + h * r[2]

    state, middle = (float(spin[0]), float(spin[1]), float(spin[2])), [float(spin[1])]
    for _ in range(round(seconds / step)):
        p = rate(state)
        q = rate(ahead(state, p, 0.5 * step))
        r = rate(ahead(state, q, 0.5 * step))
        s = rate(ahead(state, r, step))
        mean = tuple((p[i] + 2.0 * q[i] + 2.0 * r[i] + s[i]) / 6.0 for i in range(3))
        state = ahead(state, (mean[0], mean[1], mean[2]), step)
        middle.append(state[1])
    return crossings(np.arange(len(middle)) * np.float64(step), np.array(middle))


def tumbling_error(trajectory: Trajectory, expected: Array) -> float:
    """Worst of the relative errors of the times of flips, of the energy and of the angular momentum vector, at any
    time, of body 0 that turns freely."""
    turn, spin, inertia = trajectory.rotation[:, 0], trajectory.angular_velocity[:, 0], trajectory.inertia[0]
    own = rotated(conjugate(turn), spin)
    found = crossings(trajectory.times, own[:, 1])
    if len(found) != len(expected):
        return math.inf
    momentum = rotated(turn, inertia * own)
    turned = np.linalg.norm(momentum - momentum[0], axis=-1).max() / np.linalg.norm(momentum[0])
    energy = energies(trajectory)
    kept = np.abs(energy - energy[0]).max() / energy[0]
    return float(max(np.abs(found / expected - 1.0).max(), turned, kept))


def precession_error(trajectory: Trajectory, rate: float) -> float:
    """Relative error of the mean speed, rad/s, at which body 1 has gone around z."""
    x, y = trajectory.position[:, 1, 0], trajectory.position[:, 1, 1]
    angles = np.unwrap(np.arctan2(y, x))
    return abs(float(angles[-1] - angles[0]) / (float(trajectory.times[-1]) * rate) - 1.0)


def ball_overlap(trajectory: Trajectory) -> float:
    """m: deepest overlap of balls, and into the ground, at any sample."""
    balls = trajectory.dynamic
    radius = trajectory.model.nominal_shapes["radius"][trajectory.model.bodies["shape_first"][balls]]
    return max(deepest_ball_overlap(sample, radius) for sample in trajectory.position[:, balls])
