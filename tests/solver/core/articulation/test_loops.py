"""Closed loops in joint coordinates: linkages against Lagrange's equation, a closed chain, breaking, snapshots."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Distance, Revolute
from tests.solver.bits import everything
from tests.solver.core.articulation.linkages import (
    PINS,
    G,
    add_bar,
    four_bar,
    four_bar_poses,
    ring,
    slider_crank,
    slider_crank_poses,
    turn_after,
)
from tests.solver.core.articulation.opened import articulated

Array = np.ndarray[Any, Any]
BARS = np.linalg.norm(np.diff(PINS, axis=0), axis=1) ** 2 / 12.0  # kg m^2
LINKAGES = [
    (four_bar, four_bar_poses, BARS),
    (slider_crank, slider_crank_poses, np.array([0.3**2 / 12.0, 1.0 / 12.0, 1.0])),
]


@pytest.mark.parametrize(("build", "poses", "inertias"), LINKAGES, ids=["four-bar", "slider-crank"])
def test_a_linkage_converges_with_second_order(
    build: Callable[[], Scene], poses: Callable[[float], Array], inertias: Array
) -> None:
    exact = turn_after(poses, inertias, 1.5, 3000)
    errors = []
    for rate in (120, 240, 480):
        world = articulated(build(), timestep=1.0 / rate, substeps=1, sleep=False)
        world.step(rate * 3 // 2)
        errors.append(abs(world.angle[0, 1] - poses(0.0)[0, 2] - exact))
        diagnostics = world.diagnostics()
        assert diagnostics.rows[0] == 2
        assert diagnostics.relative_joint_error[0] < 1e-4
    assert errors[-1] < 2e-3
    assert errors[0] / errors[-1] > 9.0  # 16 at second order


@pytest.mark.parametrize("build", [four_bar, slider_crank, ring])
def test_a_loop_stays_closed_and_gains_no_energy(build: Callable[[], Scene]) -> None:
    world = articulated(build(), sleep=False)
    start = world.diagnostics()
    most = worst = 0.0
    kinetic = 0.0
    for _ in range(600):
        world.step()
        now = world.diagnostics()
        most = max(most, now.energy[0] - start.energy[0])
        kinetic = max(kinetic, now.kinetic_energy[0])
        worst = max(worst, now.relative_joint_error[0])
    assert worst < 1e-3
    assert most < 1e-6 * kinetic
    if build is not ring:  # which passes a pose in which its loop is singular
        assert now.energy[0] - start.energy[0] > -1e-6 * kinetic


def test_a_whipping_ring_converges_with_the_timestep() -> None:
    """At 240 Hz its bars turn as far in a substep as those of other linkages; at 60 Hz some substeps are divided."""
    world = articulated(ring(), timestep=1.0 / 240.0, sleep=False)
    start = world.diagnostics().energy[0]
    world.step(960)
    assert abs(world.diagnostics().energy[0] - start) < 1e-6 * 20 * 0.1 * G


@pytest.mark.parametrize("build", [four_bar, slider_crank])
def test_forces_do_the_work_that_gravity_does(build: Callable[[], Scene]) -> None:
    sideways = 3.0  # m/s^2
    tilted, pushed = build(), build()
    tilted.gravity = np.array([sideways, -G])
    one, other = articulated(tilted, sleep=False), articulated(pushed, sleep=False)
    for _ in range(240):
        for name in pushed.bodies:
            if name != "frame":
                other.apply_force(name, force=(sideways, 0.0))
        one.step()
        other.step()
    assert_allclose(other.position, one.position, rtol=0.0, atol=1e-9)


def test_the_reactions_of_a_loop_carry_its_weight() -> None:
    scene = ring(12)
    world = articulated(scene)
    for body in range(1, 13):
        world.parameters.set(f"bar_{body - 1}", linear_damping=3.0, angular_damping=3.0)
    world.step(1200)
    assert world.joint_reaction("top")[0, 1] == pytest.approx(12 * 0.1 * G, rel=1e-3)
    assert world.diagnostics().relative_joint_error[0] < 1e-3


def test_a_loop_that_is_cut_is_a_chain() -> None:
    cut, chain = articulated(four_bar(), sleep=False), articulated(four_bar(), sleep=False)
    chain.parameters.set("c", enabled=False)
    cut.step(10)
    assert cut.diagnostics().rows[0] == 2
    cut.parameters.set("c", enabled=False)
    for name in ("bodies", "joints"):
        getattr(chain.state, name)[:] = getattr(cut.state, name)
    for world in (cut, chain):
        world.step(30)
        assert world.diagnostics().rows[0] == 0
    assert_allclose(cut.position, chain.position, rtol=0.0, atol=1e-12)


def test_worlds_and_threads_do_not_matter() -> None:
    batch = World(four_bar(), 3, threads=2, options=Options(articulated=True))
    one = [articulated(four_bar()) for _ in range(3)]
    for w, world in enumerate(one):
        for target in (world, batch):
            target.parameters.set("coupler", mass=1.0 + w, worlds=None if target is world else w)
    for world in [*one, batch]:
        world.step(60)
    for w, world in enumerate(one):
        assert_array_equal(batch.state.bodies[w], world.state.bodies[0])
        assert_array_equal(batch.state.joints[w], world.state.joints[0])
    assert batch.angle[0, 1] != batch.angle[1, 1]


def test_a_snapshot_continues_bit_for_bit() -> None:
    world = articulated(ring())
    world.step(20)
    saved = world.save()
    world.step(20)
    again = articulated(ring())
    again.restore(saved)
    again.step(20)
    assert everything(again) == everything(world)


HELD = [(four_bar, {"a": 1.0, "d": -1.0}), (slider_crank, {"pin": 1.0, "guide": 1.0}), (ring, {"top": 1.0})]


@pytest.mark.parametrize("rate", [60, 240])
@pytest.mark.parametrize(("build", "held"), HELD, ids=["four-bar", "slider-crank", "ring"])
def test_reactions_are_the_change_of_momentum(build: Callable[[], Scene], held: dict[str, float], rate: int) -> None:
    """The joints to the ground and gravity alone change the momentum; ``held``: joint and sign of its reaction."""
    world = articulated(build(), timestep=1.0 / rate, sleep=False)
    weight = np.array([0.0, G * world.parameters.bodies["mass"][0, 1:].sum()])
    before = world.diagnostics().momentum[0]
    forces, given = [], []
    for _ in range(2 * rate):
        world.step()
        now = world.diagnostics().momentum[0]
        forces.append((now - before) * rate + weight)
        given.append(sum((sign * world.joint_reaction(name)[0, :2] for name, sign in held.items()), np.zeros(2)))
        before = now
    assert_allclose(given, forces, rtol=0.0, atol=1e-12 * float(np.abs(forces).max()))


def test_each_joint_of_a_loop_carries_its_bar() -> None:
    """The joint that closes the loop, too: what both ends of the rocker take is the change of its momentum."""
    rate = 60
    world = articulated(four_bar(), timestep=1.0 / rate, sleep=False)
    before = world.linear_velocity[0, 3]
    forces, given = [], []
    for _ in range(2 * rate):
        world.step()
        now = world.linear_velocity[0, 3]
        forces.append((now - before) * rate + (0.0, G))
        given.append(world.joint_reaction("c")[0, :2] - world.joint_reaction("d")[0, :2])
        before = now
    assert_allclose(given, forces, rtol=0.0, atol=1e-12 * float(np.abs(forces).max()))


def test_a_loop_that_cannot_close_falls_as_its_centre_must() -> None:
    """A rod 3 mm longer than the stretched chain that it is on; what corrects it must not move the centre of mass."""
    scene = Scene(gravity=(0.0, -G))
    for k in range(4):
        add_bar(scene, f"bar_{k}", (0.1 * k, 0.03 * k), (0.1 * (k + 1), 0.03 * (k + 1)), mass=1.0 + k)
        if k:
            scene.add_joint(f"joint_{k}", Revolute(f"bar_{k - 1}", f"bar_{k}", anchor=(0.1 * k, 0.03 * k)))
    scene.add_joint("rod", Distance("bar_0", "bar_2", length=0.212, anchor_a=(0.05, 0.015), anchor_b=(0.25, 0.075)))
    world = articulated(scene, sleep=False)
    masses = world.parameters.bodies["mass"][0]
    start: Array = masses @ world.position[0] / masses.sum()
    energy = world.diagnostics().energy[0]
    for step in range(1, 181):
        world.step()
        time = step / 60.0
        fall = masses @ world.position[0] / masses.sum() - start
        assert_allclose(fall, (0.0, -0.5 * G * time * time), rtol=1e-9, atol=1e-9)
        assert world.diagnostics().energy[0] < energy + 1e-9 * abs(energy)
        assert np.abs(world.angular_velocity).max() < 1e-6
