"""Equations that no velocity makes true: impulses must not grow along what moves no body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

from gsenv.solver.records.model import NDOF
from tests.solver.methods.random_island import Island

pytestmark = pytest.mark.nojit
LOOP = [(1, 2), (2, 3), (3, 1)]


def contradictory(dim: int, seed: int) -> Island:
    """A loop of three bodies with three rows too many and random biases."""
    island = Island(LOOP, rows_per_edge=NDOF[dim] + 1, dim=dim, seed=seed)
    assert null_space(island.jacobian().T).shape[1] == 3  # impulses that move no body
    island.rows["bias"] = np.random.default_rng(seed + 100).normal(size=len(island.rows))
    return island


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("dim", [2, 3])
def test_impulses_stay_bounded(dim: int, seed: int) -> None:
    island = contradictory(dim, seed)
    free, jacobian, bias = island.velocities(), island.jacobian(), island.rows["bias"].copy()
    n = island.factorise()
    changes = [island.solve(n) for _ in range(12)]
    assert changes[-1] < 1e-6 * changes[0]  # what can be true is true
    impulse = island.rows["impulse"]
    np.testing.assert_allclose(island.mass() @ (island.velocities() - free), jacobian.T @ impulse, atol=1e-5)
    # impulses of the size of the least that have this effect, where they were 1e7 times as large
    least = np.linalg.lstsq(jacobian.T, jacobian.T @ impulse, rcond=1e-9)[0]
    assert np.linalg.norm(impulse) < 10.0 * np.linalg.norm(least)
    # the equations are obeyed up to what contradicts: their least squares in the metric of the rows
    root = np.sqrt(island.rows["diagonal"])
    best = np.linalg.lstsq(jacobian / root[:, None], -bias / root, rcond=1e-9)[0]
    left = np.linalg.norm((jacobian @ island.velocities() + bias) / root)
    assert left == pytest.approx(float(np.linalg.norm((jacobian @ best + bias) / root)), rel=1e-3)


@pytest.mark.parametrize("load", [1e3, 1e6, 1e9])
def test_heavy_loads_are_no_contradiction(load: float) -> None:
    """A chain that pulls a load of up to 1e9 of its links' masses: its equations are hard to solve, but true."""
    island = Island([(k, k + 1) for k in range(6)])
    for name, sign, lever in (("jacobian_a", -1.0, -0.5), ("jacobian_b", 1.0, -0.5)):  # pins at the ends of rods of 1 m
        island.rows[name] = 0.0
        island.rows[name][0::2, 0] = sign
        island.rows[name][1::2, 1] = sign
        island.rows[name][1::2, 2] = lever
    island.substep_bodies["mass_matrix"][6] *= load
    island.substep_bodies["inverse"][6] /= load
    island.refresh()
    n = island.factorise()
    before = np.linalg.norm(island.jacobian() @ island.velocities())
    for _ in range(60):
        island.solve(n)
    assert (island.rows["bias"] == 0.0).all()
    left = np.linalg.norm(island.jacobian() @ island.velocities())
    assert left < (1e-6 if load <= 1e6 else 0.2) * before  # beyond 1e7 the softness of rigid rows slows it down


def test_springs_in_a_contradictory_loop_keep_their_forces() -> None:
    island = contradictory(2, 1)
    island.rows["softness"][-2:] = 0.3
    island.rows["diagonal"] += island.rows["softness"]
    island.rows["effective_mass"] = 1.0 / island.rows["diagonal"]
    free = island.velocities()
    n = island.factorise()
    for _ in range(12):
        island.solve(n)
    momentum = island.mass() @ (island.velocities() - free)
    np.testing.assert_allclose(momentum, island.jacobian().T @ island.rows["impulse"], atol=1e-5)
    w = island.jacobian() @ island.velocities() + island.rows["bias"] + island.rows["softness"] * island.rows["impulse"]
    np.testing.assert_allclose(w[-2:], 0.0, atol=1e-6)
