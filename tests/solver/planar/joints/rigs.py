"""Small mechanisms that the tests of joints share, and the closed forms they are held against."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import Handle, Options, Scene, World
from gsenv.solver.planar import Box, Revolute
from tests.solver.joints import make_joint

Array = NDArray[Any]
G = 9.81
INF = math.inf
AWAKE = Options(sleep=False)
FINE = Options.preset("accurate", sleep=False)
FIDELITIES = {"balanced": AWAKE, "accurate": FINE}


def joint(world: World, name: str = "joint") -> Handle:
    return Handle("joint", name, world.model.joint_names.index(name))


def held(
    kind: str,
    gravity: float = 0.0,
    position: tuple[float, float] = (0.0, 0.0),
    velocity: tuple[float, float] = (0.0, 0.0),
    spin: float = 0.0,
    angle: float = 0.0,
    solid: bool = True,
    actuator: dict[str, Any] | None = None,
    options: Options = AWAKE,
    worlds: int = 1,
    **given: Any,
) -> World:
    """A bar of 1 x 0.4 m, 2 kg and 3 kg m^2 on a joint to the static "frame"; body 1."""
    scene = Scene(gravity=(0.0, -gravity))
    scene.add_body("frame", "static")
    scene.add_body(
        "bar",
        shapes=[Box(half_extents=(0.5, 0.2))] if solid else [],
        position=position,
        angle=angle,
        linear_velocity=velocity,
        angular_velocity=spin,
        mass=2.0,
        inertia=3.0,
    )
    scene.add_joint("joint", make_joint(kind, "frame", "bar", **given))
    if actuator is not None:
        scene.add_actuator("actuator", "joint", **actuator)
    return World(scene, worlds, options=options)


def travel(world: World, steps: int, name: str = "joint") -> Array:
    """Coordinate of a joint after each of ``steps`` steps of the first world."""
    q = np.zeros(steps)
    for k in range(steps):
        world.step()
        q[k] = world.joint_coordinate(name)[0]
    return q


def slot(world: World, number: int, name: str = "joint") -> float:
    """Mean force or torque of one row of a joint over the last step, of the first world."""
    return float(world.state.joints["total_impulse"][0, joint(world, name), number] / world.timestep)


def energy(world: World) -> float:
    return float(world.diagnostics().energy[0])


def angular_momentum(world: World) -> float:
    """kg m^2/s about the origin, of the dynamic bodies of the first world."""
    p, x, v = world.parameters, world.center_of_mass[0], world.linear_velocity[0]
    orbit = p.mass[0] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
    dynamic = world.model.bodies["kind"] == 2
    return float((orbit + p.inertia[0] * world.angular_velocity[0])[dynamic].sum())


def oscillator(t: Array, x: float, v: float, omega: float, ratio: float) -> Array:
    """Damped oscillator x'' + 2 ratio omega x' + omega^2 x = 0 from x and v."""
    if ratio < 1.0:
        damped = omega * math.sqrt(1.0 - ratio**2)
        wave = x * np.cos(damped * t) + (v + ratio * omega * x) / damped * np.sin(damped * t)
        return np.asarray(np.exp(-ratio * omega * t) * wave)
    if ratio == 1.0:
        return np.asarray(np.exp(-omega * t) * (x + (v + omega * x) * t))
    root = omega * math.sqrt(ratio**2 - 1.0)
    fast, slow = -ratio * omega - root, -ratio * omega + root
    return np.asarray(((v - fast * x) * np.exp(slow * t) - (v - slow * x) * np.exp(fast * t)) / (slow - fast))


def chain(links: int, gravity: float = G, options: Options = AWAKE, **given: Any) -> World:
    """Bars of 1 x 0.2 m and 1 kg hinged one to the next, level, the first to the static "frame" at the origin."""
    scene = Scene(gravity=(0.0, -gravity))
    before = scene.add_body("frame", "static")
    for k in range(links):
        bar = scene.add_body(f"bar_{k}", shapes=[Box(half_extents=(0.5, 0.1))], mass=1.0, position=(0.5 + k, 0.0))
        scene.add_joint(f"hinge_{k}", Revolute(before, bar, anchor=(k, 0.0), **given))
        before = bar
    return World(scene, options=options)
