"""A rear-driven car's grip, wheelspin and locked wheels against closed forms, at default and accurate settings."""

from __future__ import annotations

import pytest

from gsenv.scenes import car
from gsenv.solver import Scene, World
from tests.validation.reference import BOTH, TRACTION, G, awake_world


class Car:
    """The built car's numbers, and its accelerations in closed form.

    With masses M (chassis), m (each wheel), inertia I of a wheel, radius R, wheelbase L, height H of the
    chassis' centre midway between the axles, all forces on the whole car about the front wheel's lowest point:
    L N_rear = M g L/2 + m g L + a (M H + 2 m R + I/R) + I alpha_rear; forwards (M + 2 m + I/R^2) a = F_rear, the
    front wheel taking I a/R^2; the rear wheel I alpha_rear = torque - F_rear R.
    """

    def __init__(self, world: World, friction: float) -> None:
        names = world.model.body_names
        self.chassis, self.rear, self.front = (names.index(name) for name in ("chassis", "rear", "front"))
        mass, inertia = world.parameters.mass[0], world.parameters.inertia[0]
        place = world.center_of_mass[0]
        self.M, self.m, self.I = mass[self.chassis], mass[self.rear], inertia[self.rear]
        self.R = place[self.rear, 1]
        self.L = place[self.front, 0] - place[self.rear, 0]
        self.H = place[self.chassis, 1]
        self.mu = friction

    def gripping(self, torque: float) -> float:
        """m/s^2 without slip: alpha = a/R."""
        return float(torque / self.R / (self.M + 2.0 * self.m + 2.0 * self.I / self.R**2))

    def slipping(self, torque: float) -> float:
        """m/s^2 with F_rear = mu N_rear."""
        forward = self.M + 2.0 * self.m + self.I / self.R**2
        weight = G * self.L * (0.5 * self.M + self.m)
        height = self.M * self.H + 2.0 * self.m * self.R + self.I / self.R
        return float(self.mu * (weight + torque) / (forward * (self.L + self.mu * self.R) - self.mu * height))

    def grip_limit(self) -> float:
        """N m up to which the wheel does not slip."""
        return (self.mu * self._load(0.0)) / (self.gripping(1.0) * self._forward() - self.mu * self._load(1.0, True))

    def _forward(self) -> float:
        return float(self.M + 2.0 * self.m + self.I / self.R**2)

    def _load(self, torque: float, change: bool = False) -> float:
        """N_rear of a gripping wheel; or what 1 N m adds to it."""
        height = self.M * self.H + 2.0 * self.m * self.R + 2.0 * self.I / self.R
        weight = 0.0 if change else G * self.L * (0.5 * self.M + self.m)
        return float((weight + self.gripping(torque) * height) / self.L)


def acceleration(scene: Scene, fidelity: str, friction: float) -> tuple[float, float, Car]:
    """(m/s^2 forwards, rad/s of slip at the end, the car) from rest, over the second half of a second."""
    world = awake_world(scene, fidelity)
    built = Car(world, friction)
    world.step(30)
    before = world.linear_velocity[0, built.chassis, 0]
    world.step(30)
    after = world.linear_velocity[0, built.chassis, 0]
    slip = -world.angular_velocity[0, built.rear] * built.R - after
    return 2.0 * (after - before), slip, built


@BOTH
@pytest.mark.parametrize("part", [0.5, 0.99, 1.03, 2.0])
def test_car_grips_up_to_its_limit(fidelity: str, part: float) -> None:
    friction = 0.5
    limit = Car(awake_world(car(friction=friction), fidelity), friction).grip_limit()
    torque = part * limit
    measured, slip, built = acceleration(car(torque=torque, friction=friction), fidelity, friction)
    expected = built.gripping(torque) if part < 1.0 else built.slipping(torque)
    assert measured == pytest.approx(expected, rel=TRACTION.at(fidelity))
    assert slip > 0.05 if part > 1.0 else abs(slip) < 1e-3  # m/s


@BOTH
def test_locked_wheels_slide(fidelity: str) -> None:
    speed, friction = 8.0, 0.5
    world = awake_world(car(speed=speed, locked=True, friction=friction), fidelity)
    chassis = world.model.body_names.index("chassis")
    start = world.position[0, chassis, 0]
    world.step(150)
    assert abs(world.linear_velocity[0, chassis, 0]) < 1e-3
    slid = world.position[0, chassis, 0] - start
    assert slid == pytest.approx(speed**2 / (2.0 * friction * G), rel=TRACTION.at(fidelity))
