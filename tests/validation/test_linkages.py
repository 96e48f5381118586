"""Pendulums, chains, cradles and a gyroscope against closed forms, at default and accurate settings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes import chain, cradle, double_pendulum, hanging_chain, hanging_mode, pendulum
from gsenv.scenes.spatial import ball_chain, gyroscope, precession, rod_pendulum, sphere_cradle, two_rods
from gsenv.solver import World
from tests.validation.reference import (
    BOTH,
    CHAIN,
    CRADLE,
    DOUBLE_PENDULUM,
    MOTION,
    NUTATION,
    PLANE_AND_SPACE,
    Array,
    G,
    awake_world,
    drift_and_gap,
)
from tests.validation.slopes import Direction
from tests.validation.swings import period

CRADLES = {2: cradle, 3: sphere_cradle}
HEADINGS = pytest.mark.parametrize("direction", [Direction(2), Direction(3), Direction(3, 30.0)], ids=str)


@BOTH
@pytest.mark.parametrize(
    ("direction", "point"),
    [
        (Direction(2), False), (Direction(2), True),
        (Direction(3), False), (Direction(3, 40.0), False), (Direction(3), True),
    ],
    ids=lambda value: str(value) if isinstance(value, Direction) else "point" if value else "rod",
)  # fmt: skip
@pytest.mark.parametrize(("degrees", "ratio"), [(45, 1.0399733), (90, 1.1803406), (120, 1.3728805), (150, 1.7622037)])
def test_pendulum_period(fidelity: str, direction: Direction, point: bool, degrees: float, ratio: float) -> None:
    """Over that of small swings: complete elliptic integrals."""
    if direction.dim == 2:
        scene = pendulum(degrees, point=point)
    else:
        scene = rod_pendulum(degrees, heading=direction.heading, point=point)
    world = awake_world(scene, fidelity)
    small = 2.0 * math.pi * math.sqrt((1.0 if point else 2.0 / 3.0) / G)  # sqrt(I_O / (m g d)) of unit length
    forward = direction.forward()

    def swing() -> tuple[float, float]:
        place, velocity = world.center_of_mass[0, 1], world.linear_velocity[0, 1]
        (x, y), (u, v) = (place @ forward, place[-1]), (velocity @ forward, velocity[-1])
        return math.atan2(x, -y), (u * -y + v * x) / (x * x + y * y)

    assert period(world, swing) == pytest.approx(small * ratio, rel=MOTION.at(fidelity))


@BOTH
@pytest.mark.parametrize(("count", "omega"), [(1, 1.224745), (2, 1.210135), (10, 1.202777), (20, 1.202505)])
def test_hanging_chain_swings_in_its_lowest_mode(fidelity: str, count: int, omega: float) -> None:
    assert hanging_mode(count)[0] == pytest.approx(omega, abs=1e-6)
    world = awake_world(hanging_chain(count), fidelity)
    hanging = -0.5 * math.pi  # links lie along their own x axis
    measured = period(world, lambda: (world.angle[0, count] - hanging, world.angular_velocity[0, count]))
    assert 2.0 * math.pi / measured / math.sqrt(G) == pytest.approx(omega, rel=MOTION.at(fidelity))


@BOTH
def test_gyroscope_precesses(fidelity: str) -> None:
    """m g d / (I spin) about z, and the arm stays level."""
    assert precession() == pytest.approx(0.981)
    world = awake_world(gyroscope(), fidelity)
    angles, lowest = [0.0], 0.0
    for _ in range(round(5.0 / world.timestep)):
        world.step()
        x, y, z = world.center_of_mass[0, 1]
        angles.append(math.atan2(y, x))
        lowest = min(lowest, float(z))
    assert np.unwrap(angles)[-1] / world.time[0] == pytest.approx(0.981, rel=MOTION.at(fidelity))
    assert -lowest < NUTATION.at(fidelity) * 0.1


def swing_heights(world: World) -> Array:
    """How high the cradle's balls swing by their energy now, over the height at which they start."""
    speed = (world.linear_velocity[0, 1:] ** 2).sum(-1)
    spin = (world.angular_velocity[0, 1:].reshape(5, -1) ** 2).sum(-1)
    inertia = world.parameters.inertia[0, 1:].reshape(5, -1)[:, 0] / world.parameters.mass[0, 1:]
    energy = G * world.center_of_mass[0, 1:, -1] + 0.5 * (speed + inertia * spin)
    return np.asarray(energy / (G * (1.0 - math.cos(math.radians(30.0)))))


@BOTH
@PLANE_AND_SPACE
@pytest.mark.parametrize("raised", [1, 2, 3, 4])
@pytest.mark.parametrize("rate", [30, 60, 240, 960])
def test_cradle_passes_as_many_as_come_in(fidelity: str, dim: int, raised: int, rate: int) -> None:
    """They go out to the same height, whatever the timestep; the others stay."""
    world = awake_world(CRADLES[dim](raised), fidelity, timestep=1.0 / rate)
    world.step(round(0.95 * rate))  # most of the way out again
    assert world.center_of_mass[0, 5, 0] > 0.4 + math.sin(0.4)  # m: its hinge's place and .4 rad
    expected = np.where(np.arange(5) >= 5 - raised, 1.0, 0.0)
    np.testing.assert_allclose(swing_heights(world), expected, atol=CRADLE.at(fidelity))


@BOTH
@PLANE_AND_SPACE
def test_cradle_with_restitution_below_one(fidelity: str, dim: int) -> None:
    """e = .9: each of four impacts passes on (1 + e)/2 of the speed."""
    world = awake_world(CRADLES[dim](1, restitution=0.9), fidelity)
    world.step(54)
    assert math.sqrt(swing_heights(world)[4]) == pytest.approx(0.81450625, rel=CRADLE.at(fidelity))


@BOTH
@HEADINGS
def test_chain_with_a_heavy_end_holds_and_keeps_its_energy(fidelity: str, direction: Direction) -> None:
    if direction.dim == 2:
        scene = chain(20, 0.25, 30.0, last_mass=100.0)
    else:
        scene = ball_chain(20, 0.25, 30.0, last_mass=100.0, heading=direction.heading)
    assert max(drift_and_gap(awake_world(scene, fidelity), 10.0, 0.25)) < CHAIN.at(fidelity)


@BOTH
@HEADINGS
def test_double_pendulum_keeps_its_energy(fidelity: str, direction: Direction) -> None:
    scene = double_pendulum(90.0) if direction.dim == 2 else two_rods(90.0, heading=direction.heading)
    drift, gap = drift_and_gap(awake_world(scene, fidelity), 10.0, 1.0)
    assert drift < DOUBLE_PENDULUM.at(fidelity)
    assert gap < 1e-3  # of a link, at either fidelity
