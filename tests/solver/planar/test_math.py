"""Own trigonometry against mpmath; poses."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from gsenv.solver.core.trig import atan2, sin_cos
from gsenv.solver.planar.math import Pose, relative, to_local, to_world, turn

# rng of [-pi, pi], many turns, tiny, and close to multiples of pi/2
rng = np.random.default_rng(0)
ANGLES = np.concatenate(
    [
        rng.uniform(-np.pi, np.pi, 400),
        rng.uniform(-1e5, 1e5, 400),
        rng.normal(size=100) * 1e-9,
        np.arange(-40, 41) * np.pi / 2,
        np.arange(-40, 41) * np.pi / 4,
        [0.0, -0.0, 1e-300, 1e6],
    ]
)


def ulps(value: float, exact: mpmath.mpf) -> float:
    return float(abs(mpmath.mpf(value) - exact)) / np.spacing(abs(float(exact)))


def test_sin_cos() -> None:
    with mpmath.workprec(200):
        for x in ANGLES:
            cos, sin = sin_cos(x)
            assert ulps(cos, mpmath.cos(mpmath.mpf(x))) < 2.0 or abs(cos - float(mpmath.cos(x))) < 1e-17
            assert ulps(sin, mpmath.sin(mpmath.mpf(x))) < 2.0 or abs(sin - float(mpmath.sin(x))) < 1e-17


def test_sin_cos_of_nothing_is_nothing() -> None:
    assert np.isnan(sin_cos(np.nan)).all()
    assert np.isnan(sin_cos(np.inf)).all()
    assert sin_cos(0.0) == (1.0, 0.0)


def test_atan2() -> None:
    points = np.concatenate([rng.normal(size=(500, 2)), rng.normal(size=(100, 2)) * [1.0, 1e-9]])
    points = np.vstack([points, points[:, ::-1], [[1, 1], [-1, 1], [1, -1], [-1, -1], [0, 1], [0, -1], [1, 0]]])
    with mpmath.workprec(200):
        for y, x in points:
            assert ulps(atan2(y, x), mpmath.atan2(mpmath.mpf(y), mpmath.mpf(x))) < 2.5
    assert atan2(0.0, -1.0) == np.pi
    assert atan2(0.0, 0.0) == 0.0
    assert np.isnan(atan2(np.nan, 1.0))


def test_turning_stays_on_the_unit_circle() -> None:
    cos, sin = 1.0, 0.0
    for _ in range(1000):
        cos, sin = turn(cos, sin, 0.1)
    assert cos == pytest.approx(np.cos(100.0), abs=1e-13)
    assert cos * cos + sin * sin == pytest.approx(1.0, abs=1e-15)


def test_poses() -> None:
    frame = Pose(1.0, 2.0, np.cos(0.4), np.sin(0.4))
    pose = Pose(-3.0, 0.5, np.cos(1.1), np.sin(1.1))
    assert to_local(frame, *to_world(frame, 0.3, -0.7)) == pytest.approx((0.3, -0.7))
    seen = relative(frame, pose)
    assert to_world(frame, *to_world(seen, 0.3, 0.2)) == pytest.approx(to_world(pose, 0.3, 0.2))
    assert (seen.cos, seen.sin) == pytest.approx((np.cos(0.7), np.sin(0.7)))
