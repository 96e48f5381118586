"""The benchmark of bodies on joints: both engines get the same states, and errors are measured in the right places."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from benchmarks.articulation import chains, crowds, robots
from benchmarks.articulation.engines import JOINTS, Ours, Theirs, machine


def test_ends_of_links_are_those_of_mujoco() -> None:
    one = Theirs(chains.chain_file(4, 100.0), 1e-3, "RK4")
    qpos = np.array([0.3, -0.2, 0.5, 1.0])
    one.place(qpos, np.zeros(4))
    mujoco.mj_kinematics(one.model, one.data)
    ends = [one.data.xpos[k] + one.data.xmat[k].reshape(3, 3) @ (0.0, 0.0, -0.25) for k in range(1, 5)]
    np.testing.assert_allclose(chains.places(qpos), np.array(ends)[:, [0, 2]], atol=1e-12)
    assert one.model.body_mass[4] == pytest.approx(100.0 * one.model.body_mass[1])


def test_both_engines_start_from_the_same_state() -> None:
    source = robots.assets() / "humanoid.xml"
    qpos, qvel = robots.starts(source)["lying"]
    ours, theirs = Ours(source, 0.003, False), Theirs(source, 0.003, "Euler")
    for one in (ours, theirs):
        one.place(qpos, qvel)
        np.testing.assert_allclose(one.state()[0], qpos, atol=1e-9)
    assert ours.penetration() == pytest.approx(theirs.penetration(), abs=1e-5)


def test_the_heap_has_its_bodies() -> None:
    model = Theirs(crowds.heap_file(), 0.003, "Euler").model
    assert model.nbody == 1 + 13 * crowds.COUNT
    one = machine(JOINTS, crowds.heap_file(), 0.003)
    assert one.penetration() == 0.0


def test_the_cheapest_run_at_a_level() -> None:
    runs = {"60": {"us": 5.0, "error": 0.2}, "120": {"us": 9.0, "error": 0.05}, "240": {"us": 20.0, "error": 0.01}}
    assert chains.least(runs, 0.1) == (9.0, "120")
    assert chains.least(runs, 1e-3) is None
