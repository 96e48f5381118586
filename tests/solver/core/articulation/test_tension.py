"""Taut chains whose vibrations no substep resolves: Lagrange's equations by DOP853, energy, forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from gsenv.scenes import chain
from gsenv.scenes.spatial import ball_chain
from gsenv.solver import Options, Scene, World
from tests.solver.core.articulation.opened import articulated

Array = np.ndarray[Any, Any]
G = 9.81
COUNT, LINK, HEAVY = 20, 0.25, 100.0


def heavy_chain(dim: int, degrees: float = 30.0, last_mass: float = HEAVY) -> Scene:
    """20 rods of 0.25 m and 1 kg, the last of 100 kg, straight and at rest."""
    build = chain if dim == 2 else ball_chain
    return build(COUNT, LINK, degrees, last_mass=last_mass)


def swung(world: World, seconds: float) -> Array:
    """Return the centre of mass of the last rod by Lagrange's equations, from the masses of a world."""
    mass = world.parameters.mass[0, 1:]
    inertia = world.parameters.inertia[0, 1:]
    inertia = inertia.max(-1) if inertia.ndim == 2 else inertia
    lever = np.tril(np.full((COUNT, COUNT), LINK), -1) + 0.5 * LINK * np.eye(COUNT)  # of each centre on each angle
    coupling = lever.T @ (mass[:, None] * lever)
    weight = G * mass @ lever

    def rate(_: float, y: Array) -> Array:
        a, w = y[:COUNT], y[COUNT:]
        apart = a[:, None] - a[None, :]
        matrix = coupling * np.cos(apart) + np.diag(inertia)
        force = -(coupling * np.sin(apart)) @ (w * w) - weight * np.sin(a)
        return np.concatenate([w, np.linalg.solve(matrix, force)])

    start = np.concatenate([np.full(COUNT, np.radians(30.0)), np.zeros(COUNT)])
    a = solve_ivp(rate, (0.0, seconds), start, "DOP853", rtol=1e-9, atol=1e-9).y[:COUNT, -1]
    return np.array([lever[-1] @ np.sin(a), -lever[-1] @ np.cos(a)])


@pytest.mark.parametrize("dim", [2, 3])
def test_a_heavy_chain_swings_by_its_equations(dim: int) -> None:
    """The error of the end, 5 m below the hook, falls with the square of the timestep."""
    exact = swung(articulated(heavy_chain(dim)), 4.0)
    for rate in (30, 60, 120):
        world = articulated(heavy_chain(dim), timestep=1.0 / rate, substeps=1, sleep=False)
        world.step(4 * rate)
        last = world.state.bodies[0, -1]["position"]
        assert np.linalg.norm(last[[0, -1]] - exact) < 1.5 / rate**2
        diagnostics = world.diagnostics()
        assert diagnostics.unconverged[0] == 0
        assert diagnostics.joint_error[0] < 1e-14


@pytest.mark.parametrize("dim", [2, 3])
def test_a_heavy_chain_keeps_its_energy(dim: int) -> None:
    """Over a minute at 30 steps per second: errors stay as small as in the first seconds."""
    world = articulated(heavy_chain(dim), timestep=1.0 / 30, substeps=1, sleep=False)
    energy = [float(world.diagnostics().energy[0])]
    for _ in range(60):
        world.step(30)
        energy.append(float(world.diagnostics().energy[0]))
    error = np.abs(np.array(energy) - energy[0]) / (world.parameters.mass[0].sum() * G * COUNT * LINK)
    assert error.max() < 1e-4


@pytest.mark.filterwarnings("ignore:World. the mass ratio:UserWarning")
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("last_mass", [1e5, 1e8])
def test_growing_tension_makes_no_vibration_grow(dim: int, last_mass: float) -> None:
    """A straight chain on whose end all mass is swings as one rigid rod; with the tension of the substep before, the
    implicit rule is unstable while the tension grows.
    """
    world = World(heavy_chain(dim, last_mass=last_mass))
    first = float(world.diagnostics().energy[0])
    lever = (COUNT - 0.5) * LINK
    inertia = float(np.max(world.parameters.inertia[0, -1]) / world.parameters.mass[0, -1]) + lever**2
    end = solve_ivp(lambda _, y: [y[1], -G * lever / inertia * np.sin(y[0])], (0.0, 5.0), [np.pi / 6, 0.0], "DOP853",
                    rtol=1e-10, atol=1e-10).y[0, -1]  # fmt: skip
    for _ in range(60):
        world.step(5)
        assert abs(float(world.diagnostics().energy[0]) - first) < 1e-6 * last_mass * G * COUNT * LINK
    assert world.diagnostics().unconverged[0] == 0
    last = world.state.bodies[0, -1]["position"][[0, -1]]
    assert np.linalg.norm(last - lever * np.array([np.sin(end), -np.cos(end)])) < 1e-3
    assert np.abs(world.angular_velocity).max() < 1.0


@pytest.mark.filterwarnings("ignore:World. the mass ratio:UserWarning")
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("fidelity", ["fast", "accurate"])
@pytest.mark.parametrize(("degrees", "last_mass"), [(90.0, 1e6), (90.0, 1e8), (150.0, 1e4), (150.0, 1e6)])
def test_whips_too_fast_for_any_step_stay_finite(dim: int, fidelity: str, degrees: float, last_mass: float) -> None:
    """The end falls, and pulls the chain taut: rods of a millionth of its mass rotate at up to thousands of rad/s.

    Nothing is gained then.  What is lost is most where the end is pulled back, and little where it swings.
    """
    world = World(heavy_chain(dim, degrees, last_mass), options=Options.preset(fidelity))
    first = float(world.diagnostics().energy[0])
    scale = last_mass * G * COUNT * LINK
    gain = 0.0
    for _ in range(300):
        world.step()
        diagnostics = world.diagnostics()
        assert diagnostics.finite[0]
        assert diagnostics.joint_error[0] < 1e-12
        gain = (float(diagnostics.energy[0]) - first) / scale
        assert gain < 1e-3
    if (degrees, last_mass) == (90.0, 1e6):
        assert gain > (-0.1 if fidelity == "fast" else -1e-3)


@pytest.mark.parametrize("dim", [2, 3])
def test_forces_of_a_hanging_chain_are_the_weights_below(dim: int) -> None:
    world = articulated(heavy_chain(dim, 0.0), timestep=1.0 / 30, substeps=1, sleep=False)
    world.step(60)
    mass = world.parameters.mass[0, 1:]
    for k, name in enumerate(world.model.joint_names):
        force = world.joint_reaction(name)[0]
        assert_allclose(np.delete(force, dim - 1), 0.0, atol=1e-8)
        assert_allclose(force[dim - 1], G * mass[k:].sum(), rtol=1e-9)
