"""Reference scenes of joints with known answers, at default and accurate settings.

Each answer is a closed form, derived here or standard; tolerances are upper limits.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes import (
    car,
    chain,
    cradle,
    double_pendulum,
    hanging_chain,
    hanging_mode,
    motor_rig,
    pendulum,
    spring_mass,
)
from gsenv.solver import Scene, World
from tests.validation.fidelity import BOTH, G, awake_world, tolerance
from tests.validation.swings import period


@BOTH
@pytest.mark.parametrize("point", [False, True])
@pytest.mark.parametrize(("degrees", "ratio"), [(45, 1.0399733), (90, 1.1803406), (120, 1.3728805), (150, 1.7622037)])
def test_2_pendulum(fidelity: str, point: bool, degrees: float, ratio: float) -> None:
    world = awake_world(pendulum(degrees, point=point), fidelity)
    small = 2.0 * math.pi * math.sqrt((1.0 if point else 2.0 / 3.0) / G)  # sqrt(I_O / (m g d)) of unit length

    def swing() -> tuple[float, float]:
        x, y = world.center_of_mass[0, 1]
        v = world.linear_velocity[0, 1]
        return math.atan2(x, -y), (v[0] * -y + v[1] * x) / (x * x + y * y)

    assert period(world, swing) == pytest.approx(small * ratio, rel=tolerance(fidelity, 1e-2, 1e-4))


@BOTH
@pytest.mark.parametrize(("count", "omega"), [(1, 1.224745), (2, 1.210135), (10, 1.202777), (20, 1.202505)])
def test_3_hanging_chain(fidelity: str, count: int, omega: float) -> None:
    assert hanging_mode(count)[0] == pytest.approx(omega, abs=1e-6)
    world = awake_world(hanging_chain(count), fidelity)
    hanging = -0.5 * math.pi  # links lie along their own x axis
    measured = period(world, lambda: (world.angle[0, count] - hanging, world.angular_velocity[0, count]))
    assert 2.0 * math.pi / measured / math.sqrt(G) == pytest.approx(omega, rel=tolerance(fidelity, 1e-2, 1e-4))


def swing_heights(world: World) -> np.ndarray:
    """How high the cradle's balls swing by their energy now, over the height at which they start."""
    angle, rate = world.angle[0, 1:], world.angular_velocity[0, 1:]
    inertia = 1.0 + world.parameters.inertia[0, 1:] / world.parameters.mass[0, 1:]  # about the hinge, over the mass
    return np.asarray((1.0 - np.cos(angle) + inertia * rate**2 / (2.0 * G)) / (1.0 - math.cos(math.radians(30.0))))


@BOTH
@pytest.mark.parametrize("raised", [1, 2, 3, 4])
@pytest.mark.parametrize("rate", [30, 60, 240, 960])
def test_11_cradle(fidelity: str, raised: int, rate: int) -> None:
    """As many as come in go out to the same height, whatever the timestep; the others stay."""
    world = awake_world(cradle(raised), fidelity, timestep=1.0 / rate)
    world.step(round(0.95 * rate))  # most of the way out again
    assert world.angle[0, 5] > 0.4
    expected = np.where(np.arange(5) >= 5 - raised, 1.0, 0.0)
    np.testing.assert_allclose(swing_heights(world), expected, atol=tolerance(fidelity, 1e-2, 1e-3))


@BOTH
def test_11_cradle_that_loses(fidelity: str) -> None:
    """e = .9: each of four impacts passes on (1 + e)/2 of the speed."""
    world = awake_world(cradle(1, restitution=0.9), fidelity)
    world.step(54)
    assert math.sqrt(swing_heights(world)[4]) == pytest.approx(0.81450625, rel=tolerance(fidelity, 1e-2, 1e-3))


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
def test_13_car_grips_up_to_its_limit(fidelity: str, part: float) -> None:
    friction = 0.5
    limit = Car(awake_world(car(friction=friction), fidelity), friction).grip_limit()
    torque = part * limit
    measured, slip, built = acceleration(car(torque=torque, friction=friction), fidelity, friction)
    expected = built.gripping(torque) if part < 1.0 else built.slipping(torque)
    assert measured == pytest.approx(expected, rel=tolerance(fidelity, 2e-2, 1e-3))
    assert slip > 0.05 if part > 1.0 else abs(slip) < 1e-3


@BOTH
def test_13_locked_wheels_slide(fidelity: str) -> None:
    speed, friction = 8.0, 0.5
    world = awake_world(car(speed=speed, locked=True, friction=friction), fidelity)
    chassis = world.model.body_names.index("chassis")
    start = world.position[0, chassis, 0]
    world.step(150)
    assert abs(world.linear_velocity[0, chassis, 0]) < 1e-3
    slid = world.position[0, chassis, 0] - start
    assert slid == pytest.approx(speed**2 / (2.0 * friction * G), rel=tolerance(fidelity, 2e-2, 1e-3))


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
def test_17_heavy_chain(fidelity: str) -> None:
    assert max(drift_and_gap(chain(20, 0.25, 30.0, last_mass=100.0), fidelity, 10.0, 0.25)) < tolerance(
        fidelity, 3e-2, 1e-3
    )


@BOTH
def test_18_double_pendulum(fidelity: str) -> None:
    drift, gap = drift_and_gap(double_pendulum(90.0), fidelity, 10.0, 1.0)
    assert drift < tolerance(fidelity, 1e-1, 1e-2)
    assert gap < 1e-3


@BOTH
@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0])
def test_21_mass_on_a_spring(fidelity: str, ratio: float) -> None:
    world = awake_world(spring_mass(2.0, ratio), fidelity)
    omega = 2.0 * math.pi * 2.0
    damped = math.sqrt(max(1.0 - ratio**2, 0.0)) * omega
    sag = G / omega**2
    amplitude = 0.1 - sag  # below the place of rest
    for _ in range(round(5.0 / 2.0 / world.timestep)):
        world.step()
        t = float(world.time[0])
        shape = math.cos(damped * t) + ratio * omega * (math.sin(damped * t) / damped if damped else t)
        expected = amplitude * math.exp(-ratio * omega * t) * shape
        here = -1.0 - sag - world.position[0, 1, 1]
        assert here == pytest.approx(expected, abs=tolerance(fidelity, 5e-2, 1e-3) * amplitude)
    if ratio == 1.0:
        world.step(300)
        assert -1.0 - world.position[0, 1, 1] == pytest.approx(sag, rel=1e-9)


@BOTH
def test_22_motor_pushes_with_its_bound_and_stops_at_its_speed(fidelity: str) -> None:
    speed, effort, inertia = 10.0, 2.0, 0.5
    world = awake_world(motor_rig(speed, effort, inertia=inertia), fidelity)
    close = tolerance(fidelity, 1e-3, 1e-6)
    while world.time[0] < 5.0:
        world.step()
        torque = float(world.joint_reaction("hinge")[0, 2])
        assert torque <= effort * (1.0 + 1e-12)
        if world.time[0] <= inertia * speed / effort - world.timestep:
            assert torque == pytest.approx(effort, rel=close)
            assert world.angular_velocity[0, 1] == pytest.approx(effort / inertia * world.time[0], rel=close)
    assert world.angular_velocity[0, 1] == pytest.approx(speed, rel=close)
    assert world.joint_reaction("hinge")[0, 2] == pytest.approx(0.0, abs=close)


@BOTH
def test_22_stalled_motor_shows_its_bound(fidelity: str) -> None:
    world = awake_world(motor_rig(10.0, 2.0, limits=(-1.0, 0.0)), fidelity)
    for _ in range(30):
        world.step()
        assert world.joint_coordinate("hinge")[0] == pytest.approx(0.0, abs=tolerance(fidelity, 1e-3, 1e-6))
    impulses = world.state.joints["total_impulse"][0, 0] / world.timestep
    assert impulses[3] == pytest.approx(2.0, rel=1e-12)  # the motor's row
    assert impulses[2] == pytest.approx(-2.0, rel=1e-6)  # the limit's
    assert world.joint_reaction("hinge")[0, 2] == pytest.approx(0.0, abs=1e-5)


@BOTH
def test_22_limit_hit_at_speed(fidelity: str) -> None:
    world = awake_world(motor_rig(0.0, 0.0, spin=8.0, limits=(-1.0, 1.0)), fidelity)
    farthest = 0.0
    while world.time[0] < 1.0:
        world.step()
        farthest = max(farthest, float(world.joint_coordinate("hinge")[0]))
    close = tolerance(fidelity, 1e-3, 1e-6)
    assert farthest == pytest.approx(1.0, abs=close)
    assert world.joint_coordinate("hinge")[0] == pytest.approx(1.0, abs=close)
    assert world.angular_velocity[0, 1] == pytest.approx(0.0, abs=close)
