"""Springs and dampers of joints against the damped oscillator, by frequency and by stiffness."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, World
from tests.solver.planar.joints.rigs import FIDELITIES, INF, G, energy, held, joint, oscillator, travel

KINDS: dict[str, dict[str, Any]] = {
    "revolute": {"spin": 1.0},
    "prismatic": {"velocity": (0.6, 0.8), "axis": (0.6, 0.8)},
    "wheel": {"velocity": (0.6, 0.8), "axis": (0.6, 0.8)},
}
INERTIA = {"revolute": 3.0, "prismatic": 2.0, "wheel": 2.0}  # kg m^2 or kg, of the bar
T = np.arange(1, 151) / 60.0  # 5 periods of 2 Hz


def error(world: World, omega: float, ratio: float) -> float:
    """Largest deviation from the oscillator that starts with 1 rad/s or m/s, as a part of its amplitude."""
    exact = oscillator(T, 0.0, 1.0, omega, ratio)
    return float(abs(travel(world, len(T)) - exact).max() / abs(exact).max())


@pytest.mark.parametrize(("ratio", "bound"), [(0.0, 1e-3), (0.2, 1e-3), (1.0, 3e-3), (3.0, 4e-2)])
@pytest.mark.parametrize("kind", KINDS)
def test_frequency_and_decay(kind: str, ratio: float, bound: float) -> None:
    omega = 4.0 * math.pi
    by_frequency = held(kind, frequency=2.0, damping_ratio=ratio, **KINDS[kind])
    assert error(by_frequency, omega, ratio) < bound
    m = INERTIA[kind]
    by_stiffness = held(kind, stiffness=m * omega**2, damping=2.0 * ratio * omega * m, **KINDS[kind])
    assert error(by_stiffness, omega, ratio) < bound
    np.testing.assert_allclose(by_stiffness.position, by_frequency.position, atol=1e-12)
    np.testing.assert_allclose(by_stiffness.angle, by_frequency.angle, atol=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0])
def test_second_order(ratio: float) -> None:
    errors = []
    for substeps in (1, 2, 4):
        world = held("revolute", spin=1.0, frequency=2.0, damping_ratio=ratio, options=Options(substeps=substeps))
        errors.append(error(world, 4.0 * math.pi, ratio))
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 4.0, rtol=0.02)


@pytest.mark.parametrize("kind", ["prismatic", "wheel"])
@pytest.mark.parametrize("spring", [{"frequency": 2.0}, {"stiffness": 500.0, "damping": 30.0}], ids=["hertz", "newton"])
def test_static_sag(kind: str, spring: dict[str, Any]) -> None:
    stiffness = spring.get("stiffness", 2.0 * (4.0 * math.pi) ** 2)
    world = held(kind, gravity=G, axis=(0, 1), rest=0.2, **spring)
    world.step(600)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.2 - 2.0 * G / stiffness, abs=1e-9)
    np.testing.assert_allclose(world.joint_reaction("joint")[0], (0, 2 * G, 0), atol=1e-6)


def test_loaded_hinge_sags_to_where_the_torques_balance() -> None:
    world = held("revolute", gravity=G, anchor=(-0.5, 0), stiffness=100.0, damping=20.0)
    world.step(900)
    q = world.joint_coordinate("joint")[0]
    assert q == pytest.approx(-G * math.cos(q) / 100.0, abs=1e-6)


def test_hanging_spring_is_an_oscillator_about_its_sag() -> None:
    world = held("distance", gravity=G, position=(0, -1), anchor_a=(0, 0), frequency=2.0, damping_ratio=0.2)
    sag = G / (4.0 * math.pi) ** 2
    exact = 1.0 + sag + oscillator(T, -sag, 0.0, 4.0 * math.pi, 0.2)
    np.testing.assert_allclose(travel(world, len(T)), exact, atol=1e-3 * sag)


def test_a_longer_or_shorter_rest_length() -> None:
    world = held("distance", gravity=G, position=(0, -1), anchor_a=(0, 0), stiffness=100.0, damping=10.0, length=0.8)
    world.step(900)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.8 + 2.0 * G / 100.0, abs=1e-9)
    world.parameters.set(joint(world), length=1.1, stiffness=200.0)
    world.step(900)
    assert world.joint_coordinate("joint")[0] == pytest.approx(1.1 + 2.0 * G / 200.0, abs=1e-9)


def test_damper_alone() -> None:
    # m v' = -c v from 1 m/s with c / m = 1 / 2s
    world = held("prismatic", velocity=(1, 0), axis=(1, 0), damping=1.0)
    np.testing.assert_allclose(travel(world, len(T)), 2.0 * (1.0 - np.exp(-T / 2.0)), atol=1e-5)
    fall = held("prismatic", gravity=G, axis=(0, 1), damping=4.0)
    fall.step(1200)
    assert fall.joint_rate("joint")[0] == pytest.approx(-2.0 * G / 4.0, rel=1e-9)


def test_spring_effort_is_a_bound() -> None:
    # 1000 N/m stretched by 3 m would pull with 3000 N: it pulls with 5
    world = held("prismatic", axis=(1, 0), stiffness=1000.0, spring_effort=5.0, rest=3.0)
    for k in range(1, 61):
        world.step()
        assert world.linear_velocity[0, 1, 0] == pytest.approx(2.5 * k / 60, rel=1e-12)
        np.testing.assert_allclose(world.joint_reaction("joint")[0], (5, 0, 0), rtol=1e-12, atol=1e-9)
    world.parameters.set(joint(world), spring_effort=INF)
    world.step()
    assert world.joint_reaction("joint")[0, 0] > 100.0


@pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)
@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0, 3.0])
def test_very_stiff_spring_is_calm(ratio: float, options: Options) -> None:
    # 200 Hz, 3 turns a step: it can't be followed, so it is damped to where it belongs
    world = held("revolute", spin=1.0, frequency=200.0, damping_ratio=ratio, options=options)
    rates = []
    for _ in range(60):
        world.step()
        rates.append(abs(world.joint_rate("joint")[0]))
    assert max(rates) < 1.0  # never faster than it was pushed
    assert rates[-1] < 1e-3
    assert world.joint_coordinate("joint")[0] == pytest.approx(0, abs=1e-4)
    loaded = held("prismatic", gravity=G, axis=(0, 1), frequency=200.0, damping_ratio=ratio, options=options)
    loaded.step(120)
    assert loaded.joint_coordinate("joint")[0] == pytest.approx(-G / (400.0 * math.pi) ** 2, rel=1e-6)


@pytest.mark.parametrize("ratio", [0.0, 1.0, 3.0])
def test_very_weak_spring(ratio: float) -> None:
    world = held("revolute", spin=1.0, frequency=0.01, damping_ratio=ratio)
    assert error(world, 0.02 * math.pi, ratio) < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_undamped_springs_keep_their_energy(kind: str) -> None:
    world = held(kind, frequency=1.0, damping_ratio=0.0, **KINDS[kind])
    start = energy(world)
    for _ in range(600):
        world.step()
        assert energy(world) == pytest.approx(start, rel=5e-4)
    assert energy(world) == pytest.approx(start, rel=1e-5)  # ten whole periods


def test_elastic_pendulum_keeps_its_energy() -> None:
    energies = []
    for substeps in (2, 4):
        world = held(
            "distance", gravity=G, position=(1, 0), anchor_a=(0, 0), frequency=2.0, damping_ratio=0.0,
            options=Options(substeps=substeps, sleep=False),
        )  # fmt: skip
        start = energy(world)
        drift = []
        for _ in range(300):
            world.step()
            drift.append(abs(energy(world) - start) / (2.0 * G))
        energies.append(max(drift))
    assert energies[0] < 1e-2
    assert energies[1] < energies[0] / 3.0


def test_springs_tuned_at_run_time_are_of_one_form() -> None:
    world = held("revolute", frequency=2.0)
    with pytest.raises(ValueError, match="a frequency or a stiffness and damping; set the other to 0"):
        world.parameters.set(joint(world), stiffness=10.0)
    assert world.parameters.joints["stiffness"][0, 0] == 0.0
    world.parameters.set(joint(world), frequency=0.0, stiffness=3.0 * (4.0 * math.pi) ** 2)
    world.set_velocity("bar", angular=1.0)
    assert error(world, 4.0 * math.pi, 0.0) < 1e-3
