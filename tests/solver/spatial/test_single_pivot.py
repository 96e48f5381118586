"""One body on a ball joint to what stands still: tops and pendulums of any shape, against Runge-Kutta steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.scenes.spatial import gyroscope, precession
from gsenv.scenes.spatial.turning import about, turned
from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Ball, Box
from gsenv.solver.spatial.math import conjugate, multiply
from gsenv.solver.spatial.math import turned as turned_by
from gsenv.solver.spatial.single_pivot import moments_about
from tests.solver.spatial.one_kernel import full_world, space

G = 9.81
DISK, BRICK = (0.0025, 0.0025, 0.005), (0.0022, 0.003, 0.005)  # kg m^2
ALONG, ASIDE = (0.0, 0.0, 0.1), (0.03, 0.02, 0.1)  # m, from the pin to the centre
TOPS = [(DISK, ALONG, 200.0), (DISK, ALONG, 5.0), (BRICK, ALONG, 100.0), (BRICK, ASIDE, 20.0), (BRICK, ASIDE, 0.0)]
IDS = ["disk-200", "disk-5", "brick-100", "aside-20", "aside-0"]
ALL_TOPS = pytest.mark.parametrize(("inertia", "arm", "spin"), TOPS, ids=IDS)


def top(inertia: Any, arm: Any, spin: float, swapped: bool = False, **body: Any) -> Scene:
    """1 kg whose axis is 20 degrees above level, turning about it and not else, pinned at the origin."""
    scene = space(G)
    scene.add_body("hook", "static")
    turn = about(1, 70.0)
    place, w = np.array(turned(turn, arm)), np.array(turned(turn, (0.0, 0.0, spin)))
    given = {"linear_velocity": np.cross(w, place), "angular_velocity": w, **body}
    box = Box(half_extents=(0.05, 0.06, 0.07))
    scene.add_body("top", shapes=[box], position=place, orientation=turn, mass=1.0, inertia=inertia, **given)
    scene.add_joint("pin", Ball(*(("top", "hook") if swapped else ("hook", "top")), anchor=(0, 0, 0)))
    return scene


def at_rate(scene: Scene, rate: int, **options: Any) -> World:
    return full_world(scene, options=Options(timestep=1.0 / rate, sleep=False, **options))


def runge_kutta(world: World, seconds: float, steps: int) -> np.ndarray:
    """Where the centre of the top is in the end: Euler's equations about the pin, arms and moments of the start."""
    q, w = world.orientation[0, 1], world.angular_velocity[0, 1]
    inertia = np.diag(world.parameters.inertia[0, 1])
    arm = np.array(turned_by(conjugate(q), world.center_of_mass[0, 1]))
    tensor = inertia + (arm @ arm) * np.eye(3) - np.outer(arm, arm)
    inverse = np.linalg.inv(tensor)

    def rate(y: np.ndarray) -> np.ndarray:
        turn, own = tuple(y[:4]), y[4:]
        weight = np.array(turned_by(conjugate(turn), (0.0, 0.0, -G)))
        change = inverse @ (np.cross(arm, weight) - np.cross(own, tensor @ own))
        return np.concatenate([0.5 * np.array(multiply(turn, (0.0, *own))), change])

    y = np.concatenate([q, turned_by(conjugate(q), tuple(w))])
    h = seconds / steps
    for _ in range(steps):
        k1 = rate(y)
        k2 = rate(y + 0.5 * h * k1)
        k3 = rate(y + 0.5 * h * k2)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(y + h * k3))
    return np.array(turned_by(tuple(y[:4] / np.linalg.norm(y[:4])), tuple(arm)))


@ALL_TOPS
def test_follows_fine_steps_at_a_coarse_timestep(inertia: Any, arm: Any, spin: float) -> None:
    world = at_rate(top(inertia, arm, spin), 15)
    expected = runge_kutta(world, 1.0, 2000 + 40 * int(spin))
    world.step(15)
    assert np.linalg.norm(world.center_of_mass[0, 1] - expected) < 1e-5 * np.linalg.norm(arm)
    assert world.diagnostics().joint_error[0] < 1e-15


def test_is_of_order_six_with_unequal_moments() -> None:
    ends = []
    for rate in (10, 20, 320):
        world = at_rate(top(BRICK, ASIDE, 20.0), rate)
        world.step(rate)
        ends.append(world.center_of_mass[0, 1])
    coarse, fine = (np.linalg.norm(end - ends[2]) for end in ends[:2])
    assert coarse > 20.0 * fine


@ALL_TOPS
def test_energy_and_momentum_about_the_vertical_stay(inertia: Any, arm: Any, spin: float) -> None:
    world = at_rate(top(inertia, arm, spin), 15)
    start = world.diagnostics()
    for _ in range(30):
        world.step(15)
        now = world.diagnostics()
        assert now.energy[0] == pytest.approx(start.energy[0], abs=2e-4 * G * 0.1)
        assert now.angular_momentum[0, 2] == pytest.approx(start.angular_momentum[0, 2], abs=1e-10)


@pytest.mark.parametrize("spin", [50.0, 200.0, 1000.0])
@pytest.mark.parametrize("rate", [15, 60])
def test_precession_at_any_spin(spin: float, rate: int) -> None:
    world = at_rate(gyroscope(spin), rate)
    angles = [0.0]
    for _ in range(2 * rate):
        world.step()
        x, y, _ = world.center_of_mass[0, 1]
        angles.append(float(np.arctan2(y, x)))
    assert np.unwrap(angles)[-1] / 2.0 == pytest.approx(precession(spin), rel=1e-6)


@pytest.mark.parametrize("swapped", [False, True])
def test_moves_as_by_rows(swapped: bool) -> None:
    """A damping of nothing makes the joint's rows do it: forces, weights and reactions are the same."""
    worlds = []
    for damping in (0.0, 1e-12):
        scene = top(BRICK, ASIDE, 3.0, swapped, gravity_scale=0.5, linear_damping=damping)
        worlds.append(at_rate(scene, 240, articulated=False))
    for _ in range(120):
        for world in worlds:
            world.apply_force("top", force=(0.3, -0.2, 0.1), torque=(0.01, 0.02, -0.03))
            world.step()
    pinned, by_rows = worlds
    assert pinned.diagnostics().rows[0] == 0
    assert by_rows.diagnostics().rows[0] == 3
    assert_allclose(pinned.center_of_mass[0, 1], by_rows.center_of_mass[0, 1], atol=1e-5)
    assert_allclose(pinned.linear_velocity[0, 1], by_rows.linear_velocity[0, 1], atol=2e-4)
    assert_allclose(pinned.joint_reaction("pin")[0], by_rows.joint_reaction("pin")[0], atol=2e-2)


def test_the_pin_takes_what_is_no_turning_about_it() -> None:
    """A push in the centre: the momentum about the pin stays, and the anchor does not move."""
    scene = top(BRICK, ASIDE, 0.0, linear_velocity=(0.3, 1.0, -0.2), angular_velocity=(0, 0, 0), gravity_scale=0.0)
    world = at_rate(scene, 60)
    place = world.center_of_mass[0, 1].copy()
    world.step()
    assert_allclose(world.diagnostics().angular_momentum[0], np.cross(place, (0.3, 1.0, -0.2)), atol=1e-12)
    assert world.diagnostics().joint_error[0] < 1e-15


def test_moments_about_a_point_have_the_tensor() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        inertia, r, mass = rng.uniform(1, 2, 3), rng.normal(size=3) * 10 ** rng.uniform(-6, 2), rng.uniform(0.1, 10)
        moments, turn = moments_about(tuple(inertia), mass, tuple(r))
        axes = np.stack([turned_by(turn, tuple(axis)) for axis in np.eye(3)], -1)
        tensor = np.diag(inertia) + mass * (r @ r * np.eye(3) - np.outer(r, r))
        assert_allclose(axes @ np.diag(moments) @ axes.T, tensor, atol=1e-8 * abs(tensor).max())
