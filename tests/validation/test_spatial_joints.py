"""Reference scenes of ball joints with known answers, at default and accurate settings.

Each answer is a closed form, derived here or standard; tolerances are upper limits.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes.spatial import ball_chain, gyroscope, precession, rod_pendulum, sphere_cradle, two_rods
from gsenv.scenes.spatial.turning import level
from gsenv.solver import Scene, World
from tests.validation.fidelity import BOTH, G, awake_world, tolerance
from tests.validation.swings import period


@BOTH
@pytest.mark.parametrize(("point", "heading"), [(False, 0.0), (False, 40.0), (True, 0.0)])
@pytest.mark.parametrize(("degrees", "ratio"), [(45, 1.0399733), (90, 1.1803406), (120, 1.3728805), (150, 1.7622037)])
def test_2_pendulum(fidelity: str, point: bool, heading: float, degrees: float, ratio: float) -> None:
    world = awake_world(rod_pendulum(degrees, heading=heading, point=point), fidelity)
    small = 2.0 * math.pi * math.sqrt((1.0 if point else 2.0 / 3.0) / G)  # sqrt(I_O / (m g d)) of unit length
    forward = np.array(level(heading))

    def swing() -> tuple[float, float]:
        place, velocity = world.center_of_mass[0, 1], world.linear_velocity[0, 1]
        (x, z), (u, v) = (place @ forward, place[2]), (velocity @ forward, velocity[2])
        return math.atan2(x, -z), (u * -z + v * x) / (x * x + z * z)

    assert period(world, swing) == pytest.approx(small * ratio, rel=tolerance(fidelity, 1e-2, 1e-4))


@BOTH
def test_5_gyroscope_precesses(fidelity: str) -> None:
    """m g d / (I spin) about z, and the arm stays level."""
    assert precession() == pytest.approx(0.981)
    world = awake_world(gyroscope(), fidelity)
    angles, lowest = [0.0], 0.0
    for _ in range(round(5.0 / world.timestep)):
        world.step()
        x, y, z = world.center_of_mass[0, 1]
        angles.append(math.atan2(y, x))
        lowest = min(lowest, float(z))
    close = tolerance(fidelity, 1e-2, 1e-4)
    assert np.unwrap(angles)[-1] / world.time[0] == pytest.approx(0.981, rel=close)
    assert -lowest < tolerance(fidelity, 1e-2, 1e-3) * 0.1  # it nutates by what the substep's splitting leaves


def swing_heights(world: World) -> np.ndarray:
    """How high the cradle's balls swing by their energy now, over the height at which they start."""
    v2 = (world.linear_velocity[0, 1:] ** 2).sum(-1)
    w2 = (world.angular_velocity[0, 1:] ** 2).sum(-1)
    turning = 0.4 * 0.1**2 * w2  # of a ball, over its mass
    energy = G * world.center_of_mass[0, 1:, 2] + 0.5 * (v2 + turning)
    return np.asarray(energy / (G * (1.0 - math.cos(math.radians(30.0)))))


@BOTH
@pytest.mark.parametrize("raised", [1, 2, 3, 4])
@pytest.mark.parametrize("rate", [30, 60, 240, 960])
def test_11_cradle(fidelity: str, raised: int, rate: int) -> None:
    """As many as come in go out to the same height, whatever the timestep; the others stay."""
    world = awake_world(sphere_cradle(raised), fidelity, timestep=1.0 / rate)
    world.step(round(0.95 * rate))  # most of the way out again
    assert world.center_of_mass[0, 5, 0] > 0.4 + math.sin(0.4)
    expected = np.where(np.arange(5) >= 5 - raised, 1.0, 0.0)
    np.testing.assert_allclose(swing_heights(world), expected, atol=tolerance(fidelity, 1e-2, 1e-3))


@BOTH
def test_11_cradle_that_loses(fidelity: str) -> None:
    """e = .9: each of four impacts passes on (1 + e)/2 of the speed."""
    world = awake_world(sphere_cradle(1, restitution=0.9), fidelity)
    world.step(54)
    assert math.sqrt(swing_heights(world)[4]) == pytest.approx(0.81450625, rel=tolerance(fidelity, 1e-2, 1e-3))


def drift_and_gap(scene: Scene, fidelity: str, seconds: float, link: float) -> tuple[float, float]:
    """Largest change of energy over m g L of all, and largest joint error over a link."""
    world = awake_world(scene, fidelity)
    mass = np.where(world.model.bodies["kind"] == 2, world.parameters.mass[0], 0.0)
    scale = float(mass.sum()) * G * link * int((mass > 0.0).sum())
    start = world.diagnostics().energy[0]
    drift = gap = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        d = world.diagnostics()
        drift = max(drift, abs(float(d.energy[0] - start)) / scale)
        gap = max(gap, float(d.joint_error[0]) / link)
    return drift, gap


@BOTH
@pytest.mark.parametrize("heading", [0.0, 30.0])
def test_17_heavy_chain(fidelity: str, heading: float) -> None:
    scene = ball_chain(20, 0.25, 30.0, last_mass=100.0, heading=heading)
    assert max(drift_and_gap(scene, fidelity, 10.0, 0.25)) < tolerance(fidelity, 3e-2, 1e-3)


@BOTH
@pytest.mark.parametrize("heading", [0.0, 30.0])
def test_18_two_rods(fidelity: str, heading: float) -> None:
    drift, gap = drift_and_gap(two_rods(90.0, heading=heading), fidelity, 10.0, 1.0)
    assert drift < tolerance(fidelity, 1e-1, 1e-2)
    assert gap < 1e-3
