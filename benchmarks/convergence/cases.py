"""Scenes with known answers, what is measured in them, and the order of convergence to expect."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from gsenv.scenes import (
    bouncing_balls,
    box_on_incline,
    chain,
    cradle,
    disk_on_incline,
    double_pendulum,
    pendulum,
    projectile,
    sliding_disk,
    spring_mass,
)
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, Distance, HalfPlane

Array = NDArray[np.float64]
G = 9.81
FINE = 3840  # Runge-Kutta steps in a second: its errors are below 1e-11
SPEEDS = np.linspace(1.7, 2.3, 8)  # m/s: sliding ends at different parts of a step


@dataclass(frozen=True)
class Case:
    """A scene, what is measured in it, and the order expected."""

    group: str
    scene: str
    quantity: str
    measure: Callable[[int], float]  # steps in a second -> error
    order: float | None  # expected; None: exact
    limit: str  # what limits the order


def world_at(scene: Scene, rate: int, articulated: bool = True) -> World:
    return World(scene, options=Options(timestep=1.0 / rate, sleep=False, articulated=articulated))


def worst(world: World, seconds: float, error: Callable[[float], float]) -> float:
    """Return the largest ``error(time)`` of all steps."""
    largest = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        largest = max(largest, abs(error(float(world.time[0]))))
    return largest


def free_flight(rate: int) -> float:
    world = world_at(projectile((5.0, 7.0), 3.0), rate)

    def error(t: float) -> float:
        x, y = world.position[0, 0]
        return max(abs(x - 5.0 * t), abs(y - 1.0 - 7.0 * t + 0.5 * G * t * t), abs(world.angle[0, 0] - 3.0 * t))

    return worst(world, 2.0, error)


def drag(rate: int) -> float:
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("ball", shapes=[Circle(radius=0.1)], linear_velocity=(1.0, 0.0), linear_damping=1.0)
    world = world_at(scene, rate)
    return worst(world, 2.0, lambda t: world.position[0, 0, 0] - (1.0 - math.exp(-t)))


def ellipse(rate: int) -> float:
    """Return the error of x = cos(w t), y = (2/w) sin(w t) on a spring of relaxed length 0, with w = pi."""
    omega = math.pi
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("sun", "static")
    disk = Circle(radius=0.1)
    scene.add_body("ball", shapes=[disk], mass=1.0, position=(1.0, 0.0), linear_velocity=(0.0, 2.0))
    middle = (0.0, 0.0)
    scene.add_joint("spring", Distance("sun", "ball", anchor_a=middle, anchor_b=middle, length=0.0, stiffness=omega**2))
    world = world_at(scene, rate)

    def error(t: float) -> float:
        x, y = world.position[0, 1]
        return math.hypot(x - math.cos(omega * t), y - 2.0 / omega * math.sin(omega * t))

    return worst(world, 2.0, error)


def travelled(scene: Scene, acceleration: float, rate: int) -> float:
    world = world_at(scene, rate)
    start = world.position[0, 1]
    return worst(world, 2.0, lambda t: math.hypot(*(world.position[0, 1] - start)) - 0.5 * acceleration * t * t)


def slide_down(rate: int) -> float:
    alpha = math.radians(35.0)
    return travelled(box_on_incline(35.0), G * (math.sin(alpha) - 0.5 * math.cos(alpha)), rate)


def roll_down(rate: int) -> float:
    return travelled(disk_on_incline(20.0), 2.0 / 3.0 * G * math.sin(math.radians(20.0)), rate)


def slide_to_rest(rate: int) -> float:
    """Return the largest error of the path v^2 / (2 mu g), over several speeds v."""
    errors = []
    for speed in SPEEDS:
        scene = Scene()
        scene.add_body("ground", "static", [HalfPlane(friction=0.3)])
        box = Box(half_extents=(0.25, 0.1), friction=0.3)
        scene.add_body("box", shapes=[box], position=(0.0, 0.1), linear_velocity=(speed, 0.0))
        world = world_at(scene, rate)
        world.step(rate)
        errors.append(abs(world.position[0, 1, 0] - speed**2 / (0.6 * G)))
    return max(errors)


def slide_to_roll(rate: int) -> float:
    """Return the largest error over several speeds v: sliding ends at v / (3 mu g), rolling has 2/3 v."""
    errors = []
    for speed in SPEEDS:
        world = world_at(sliding_disk(speed), rate)
        world.step(rate)
        t = speed / (0.9 * G)
        expected = speed * t - 0.15 * G * t * t + 2.0 / 3.0 * speed * (1.0 - t)
        errors.append(abs(world.position[0, 1, 0] - expected))
    return max(errors)


def bounces(rate: int) -> float:
    """Return the error of the height of the lowest point over three apexes, e = .8, dropped from 1 m."""
    world = world_at(bouncing_balls([0.8]), rate)
    fall = math.sqrt(2.0 / G)

    def error(t: float) -> float:
        since, speed = t + fall, G * fall  # as if thrown up from the ground
        while since > 2.0 * speed / G:
            since -= 2.0 * speed / G
            speed *= 0.8
        return float(world.position[0, 1, 1] - 0.1 - speed * since + 0.5 * G * since * since)

    return worst(world, 2.2, error)


def oblique_bounce(rate: int) -> float:
    """Return the largest relative error, over several heights, of the spin of a ball that slides during its impact.

    Friction takes mu (1 + e) of the normal speed u from the motion, which gives the spin 2 mu (1 + e) u / r.
    """
    mu, e, radius = 0.2, 0.7, 0.1
    errors = []
    for height in np.linspace(0.8, 1.2, 8):
        scene = Scene()
        scene.add_body("ground", "static", [HalfPlane(friction=mu)])
        ball = Circle(radius=radius, friction=mu, restitution=e)
        place = (0.0, height + radius)
        scene.add_body("ball", shapes=[ball], position=place, linear_velocity=(9.0, 0.0))
        world = world_at(scene, rate)
        world.step(round(0.6 * rate))
        spin = 2.0 * mu * (1.0 + e) * math.sqrt(2.0 * G * height) / radius
        errors.append(abs(-world.angular_velocity[0, 1] / spin - 1.0))
    return max(errors)


def cradle_heights(rate: int) -> float:
    """Return the error of five touching balls, of which as many swing out as come in, relative to the height."""
    errors = []
    for raised in (1, 2, 3, 4):
        world = world_at(cradle(raised), rate)
        world.step(round(0.9 * rate))
        angle, spin = world.angle[0, 1:], world.angular_velocity[0, 1:]
        inertia = 1.0 + world.parameters.inertia[0, 1:] / world.parameters.mass[0, 1:]  # about the hinge, over the mass
        heights = (1.0 - np.cos(angle) + inertia * spin**2 / (2.0 * G)) / (1.0 - math.cos(math.radians(30.0)))
        errors.append(np.abs(heights - (np.arange(5) >= 5 - raised)).max())
    return float(max(errors))


def swing(state: Array) -> Array:
    """Return the derivative of (angle, rate) of a uniform rod of 1 m."""
    return np.array([state[1], -1.5 * G * math.sin(state[0])])


def double_swing(state: Array) -> Array:
    """Return the derivative of angles a, b from hanging and their rates, for two equal uniform rods of 1 m."""
    a, b, p, q = state
    c, s = math.cos(a - b), math.sin(a - b)
    mass = np.array([[4.0 / 3.0, 0.5 * c], [0.5 * c, 1.0 / 3.0]])
    force = (-0.5 * q * q * s - 1.5 * G * math.sin(a), 0.5 * p * p * s - 0.5 * G * math.sin(b))
    return np.array([p, q, *np.linalg.solve(mass, force)])


@cache
def runge_kutta(derivative: Callable[[Array], Array], start: tuple[float, ...], seconds: float) -> Array:
    """Return the states at FINE per second, from the start on."""
    h, states = 1.0 / FINE, [np.array(start)]
    for _ in range(round(seconds * FINE)):
        x = states[-1]
        k1 = derivative(x)
        k2 = derivative(x + 0.5 * h * k1)
        k3 = derivative(x + 0.5 * h * k2)
        k4 = derivative(x + h * k3)
        states.append(x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    return np.array(states)


def pendulum_angle(rate: int, articulated: bool = True) -> float:
    world = world_at(pendulum(90.0), rate, articulated)
    exact = runge_kutta(swing, (0.5 * math.pi, 0.0), 2.0)

    def error(t: float) -> float:
        x, y = world.center_of_mass[0, 1]
        return math.atan2(x, -y) - exact[round(t * FINE), 0]

    return worst(world, 2.0, error)


def double_pendulum_place(rate: int, articulated: bool = True) -> float:
    """Return the position of the lower rod's middle."""
    world = world_at(double_pendulum(90.0), rate, articulated)
    exact = runge_kutta(double_swing, (0.5 * math.pi, 0.5 * math.pi, 0.0, 0.0), 1.0)

    def error(t: float) -> float:
        a, b = exact[round(t * FINE), :2]
        x, y = world.center_of_mass[0, 2]
        return math.hypot(x - math.sin(a) - 0.5 * math.sin(b), y + math.cos(a) + 0.5 * math.cos(b))

    return worst(world, 1.0, error)


def chain_energy(rate: int, articulated: bool = True) -> float:
    world = world_at(chain(20, 0.25, 30.0), rate, articulated)
    start = world.diagnostics().energy[0]
    scale = 20.0 * G * 20 * 0.25  # m g L
    return worst(world, 2.0, lambda t: float(world.diagnostics().energy[0] - start) / scale)


def oscillation(ratio: float, rate: int) -> float:
    """Return the error of an oscillation of 2 Hz, divided by the amplitude."""
    world = world_at(spring_mass(2.0, ratio), rate)
    omega = 4.0 * math.pi
    damped = omega * math.sqrt(1.0 - ratio**2)
    sag = G / omega**2
    amplitude = 0.1 - sag

    def error(t: float) -> float:
        shape = math.cos(damped * t) + ratio * omega / damped * math.sin(damped * t)
        return (-1.0 - sag - world.position[0, 1, 1]) / amplitude - math.exp(-ratio * omega * t) * shape

    return worst(world, 2.5, error)


TURNING = "joint directions are those of the middle of each substep"
SWINGING = "the Runge-Kutta method of trees that swing freely; it takes more steps where its tolerance asks for them"
EVENT = "one friction impulse for the substep in which sliding ends"
EXACT = "nothing: velocity is linear in time"
ITS_TIME = "nothing: each impact happens at its own time within the step"
CASES = (
    Case("smooth motion", "spinning flight", "position m, angle rad", free_flight, None, EXACT),
    Case("smooth motion", "drag of 1/s", "position m", drag, 1.0, "damping is one implicit Euler factor"),
    Case("smooth motion", "ellipse on a spring", "position m", ellipse, 2.0, "the spring turns within a substep"),
    Case("smooth motion", "oscillator", "height, relative", lambda rate: oscillation(0.0, rate), None,
         "nothing: discrete map of the closed form"),
    Case("smooth motion", "oscillator, damped", "height, relative", lambda rate: oscillation(0.2, rate), 2.0,
         "frequency and decay are exact, amplitude and phase are not"),
    Case("sliding", "block down 35 deg", "distance m", slide_down, 2.0, "settling: nanometres"),
    Case("sliding", "disk rolls down 20 deg", "distance m", roll_down, None, EXACT),
    Case("sliding", "block slides to rest", "position m", slide_to_rest, 2.0, EVENT),
    Case("sliding", "disk slides, then rolls", "position m", slide_to_roll, 2.0, EVENT),
    Case("impact", "ball, e = .8", "height m", bounces, None, ITS_TIME),
    Case("impact", "oblique ball", "spin, relative", oblique_bounce, None, ITS_TIME),
    Case("impact", "cradle of five", "heights, relative", cradle_heights, 2.0,
         "joints; contacts are found once per step"),
    Case("joints", "pendulum, 90 deg", "angle rad", pendulum_angle, 4.0, SWINGING),
    Case("joints", "double pendulum", "position m", double_pendulum_place, 4.0, SWINGING),
    Case("joints", "chain of 20", "energy over m g L", chain_energy, 4.0, SWINGING),
    Case("joints by rows", "pendulum, 90 deg, by rows", "angle rad", partial(pendulum_angle, articulated=False), 2.0,
         TURNING),
    Case("joints by rows", "double pendulum, by rows", "position m", partial(double_pendulum_place, articulated=False),
         2.0, TURNING),
    Case("joints by rows", "chain of 20, by rows", "energy over m g L", partial(chain_energy, articulated=False), 2.0,
         TURNING),
)  # fmt: skip
