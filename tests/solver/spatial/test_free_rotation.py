"""Free rotation against Euler's equations, integrated in extended precision."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.spatial.free_rotation import ONE_STEP, rotate_with_velocity

Extended = np.ndarray[tuple[int, ...], np.dtype[np.longdouble]]


def _rates(state: Extended, inertia: Extended) -> Extended:
    """Rates of a quaternion (w, x, y, z) and of the angular velocity in the body's axes."""
    q, w = state[:4], state[4:]
    turning = 0.5 * np.concatenate([[-(q[1:] @ w)], q[0] * w + np.cross(q[1:], w)])
    return np.concatenate([turning, np.cross(inertia * w, w) / inertia])


def _reference(state: Extended, inertia: Extended, h: np.longdouble, steps: int) -> Extended:
    """Runge-Kutta of order four."""
    t = h / steps
    for _ in range(steps):
        a = _rates(state, inertia)
        b = _rates(state + 0.5 * t * a, inertia)
        c = _rates(state + 0.5 * t * b, inertia)
        d = _rates(state + t * c, inertia)
        state = state + t / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return state


def _turn(q: Extended, v: Extended) -> Extended:
    return v + 2.0 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v)


@pytest.mark.parametrize("reach", [1e-9, 1e-3, 0.1, 0.5, 1.0, 2.5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rotation_and_spin_are_those_of_eulers_equations(reach: float, sign: float) -> None:
    """`reach`: the angle, times the ratio of moments, over that of one step."""
    rng = np.random.default_rng(3)
    for case in range(20):
        moments = rng.uniform(1.0, 10.0 if case % 2 else 1.5, 3)
        moments[0] = min(moments[0], moments[1] + moments[2])
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        own = rng.normal(size=3)
        own *= reach * ONE_STEP * moments.min() / (moments.max() * np.abs(own).sum())
        h = sign * 0.01
        q_long, inertia = q.astype(np.longdouble), moments.astype(np.longdouble)
        q_long /= np.sqrt(q_long @ q_long)
        start = np.concatenate([q_long, own.astype(np.longdouble) / 0.01])
        end = _reference(start, inertia, np.longdouble(h), 200)
        spin = _turn(q_long, start[4:]).astype(np.float64)
        rotation, velocity = rotate_with_velocity(tuple(q), tuple(moments), tuple(spin), h)
        assert np.abs(np.array(rotation) - end[:4]).max() < 2e-15
        expected = _turn(end[:4], end[4:])
        assert np.abs(np.array(velocity) - expected).max() < 4e-15 * np.sqrt(spin @ spin)
