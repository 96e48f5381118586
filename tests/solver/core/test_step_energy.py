"""The energy of islands with joints by rows: scaled masses make none, and springs and forces are left alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial

DIMS = pytest.mark.parametrize("dim", [2, 3])
SIZE = {2: (0.3, 0.1), 3: (0.3, 0.1, 0.2)}


def module(dim: int) -> Any:
    return planar if dim == 2 else spatial


def vector(dim: int, first: float = 0.0, last: float = 0.0) -> Any:
    out = np.zeros(dim)
    out[0], out[-1] = first, last
    return out


def sprung_pair(dim: int, gravity: float = 0.0, **joint: Any) -> Scene:
    """Two boxes that do not touch, joined by a spring of 0.8 m."""
    scene = Scene(dim=dim, gravity=vector(dim, last=-gravity))
    box = module(dim).Box(half_extents=SIZE[dim])
    scene.add_body("a", shapes=[box])
    scene.add_body("b", shapes=[box], position=vector(dim, 1.0))
    scene.add_joint("spring", module(dim).Distance("a", "b", length=0.8, **joint))
    return scene


BY_ROWS = pytest.mark.parametrize("articulated", [True, False])


@DIMS
def test_a_push_on_a_sprung_pair_does_its_work(dim: int) -> None:
    """The guard knows of the work of forces and gravity: the centre of mass moves as if the pair were one body."""
    world = World(sprung_pair(dim, gravity=9.81, frequency=2.0, damping_ratio=0.0), options=Options(timestep=1 / 60))
    start = world.position[0].mean(0)
    for _ in range(120):
        world.apply_force(0, force=vector(dim, 300.0))
        world.step()
    mass = world.parameters.bodies["mass"][0, :2]
    t = float(world.time[0])
    expected = start + 0.5 * t * t * (vector(dim, 300.0) / mass.sum() - vector(dim, last=9.81))
    np.testing.assert_allclose(world.position[0].mean(0), expected, atol=1e-6)


@DIMS
def test_a_torque_on_a_sprung_body_does_its_work(dim: int) -> None:
    world = World(sprung_pair(dim, frequency=2.0, damping_ratio=0.0), options=Options(timestep=1 / 60))
    torque: Any = 2.0 if dim == 2 else (0.0, 0.0, 2.0)
    for _ in range(60):
        world.apply_force(0, torque=torque)
        world.step()
    inertia = world.parameters.bodies["inertia"][0, 0]
    spin = float(np.atleast_1d(world.angular_velocity[0, 0])[-1])
    assert spin == pytest.approx(2.0 / float(np.atleast_1d(inertia)[-1]), rel=1e-6)


@DIMS
def test_overlaps_that_separate_brake_nothing(dim: int) -> None:
    """A sprung pair that slides without friction at 0.05 m/s while it is raised out of the ground by 1 cm.

    Raising it takes 80 times its kinetic energy, which the position pass gives it.
    """
    scene = Scene(dim=dim)
    plane = planar.HalfPlane(friction=0.0) if dim == 2 else spatial.Plane(friction=0.0)
    scene.add_body("ground", "static", shapes=[plane])
    for name, x in (("a", 0.0), ("b", 1.0)):
        box = module(dim).Box(half_extents=SIZE[dim], friction=0.0)
        place = vector(dim, x, SIZE[dim][-1] - 0.01)
        scene.add_body(name, shapes=[box], position=place, linear_velocity=vector(dim, 0.05))
    scene.add_joint("spring", module(dim).Distance("a", "b", length=1.0, frequency=2.0, damping_ratio=0.0))
    world = World(scene, options=Options(timestep=1 / 60, sleep=False))
    assert float(world.diagnostics().penetration[0]) > 0.009
    world.step(240)
    assert float(world.diagnostics().penetration[0]) < 1e-3
    np.testing.assert_allclose(world.linear_velocity[0, 1:, 0], 0.05, rtol=1e-3)


@DIMS
@BY_ROWS
@pytest.mark.parametrize("frequency", [0.5, 3.0])
def test_a_weight_on_a_spring_keeps_its_amplitude(dim: int, articulated: bool, frequency: float) -> None:
    """A weight of 1 kg, let go where its spring is relaxed, swings to twice its static deflection for a minute."""
    scene = Scene(dim=dim)
    scene.add_body("ceiling", "static")
    ball = planar.Circle(radius=0.1) if dim == 2 else spatial.Sphere(radius=0.1)
    scene.add_body("weight", shapes=[ball], mass=1.0, position=vector(dim, last=-3.0))
    spring = module(dim).Distance("ceiling", "weight", length=3.0, frequency=frequency, damping_ratio=0.0)
    scene.add_joint("spring", spring)
    world = World(scene, options=Options(timestep=1 / 60, articulated=articulated))
    world.step(50 * 60)
    depths = []
    for _ in range(10 * 60):
        world.step()
        depths.append(-3.0 - float(world.position[0, 1, -1]))
    deflection = 9.81 / (2.0 * np.pi * frequency) ** 2
    assert max(depths) == pytest.approx(2.0 * deflection, rel=3e-3)  # of which 60 Hz may miss the turning point by 1e-3
    assert abs(min(depths)) < 3e-3 * deflection


@DIMS
@BY_ROWS
def test_a_spring_of_bounded_force_stores_what_it_takes(dim: int, articulated: bool) -> None:
    """1 kg at 1 m/s against at most 1 N: 0.5 J over 0.505 m, of which the spring holds all."""
    scene = Scene(dim=dim, gravity=vector(dim))
    scene.add_body("wall", "static")
    ball = planar.Circle(radius=0.1) if dim == 2 else spatial.Sphere(radius=0.1)
    place = vector(dim, 1.0)
    scene.add_body("ball", shapes=[ball], mass=1.0, position=place, linear_velocity=place)
    spring = module(dim).Distance("wall", "ball", length=1.0, stiffness=100.0, damping=0.0, spring_effort=1.0)
    scene.add_joint("spring", spring)
    world = World(scene, options=Options(timestep=1e-3, articulated=articulated))
    for _ in range(9):
        world.step(100)
        t = float(world.time[0])
        assert float(world.linear_velocity[0, 1, 0]) == pytest.approx(1.0 - t, abs=6e-3)  # it takes 0.01 m to reach 1 N
        assert float(world.diagnostics().energy[0]) == pytest.approx(0.5, rel=2e-3)


def loaded_chain(dim: int, links: int, gravity: float, angle: float) -> World:
    """A load of 10 kg at the end of links of 10 g, together 1 m, at an angle from the vertical; by rows."""
    scene = Scene(dim=dim, gravity=vector(dim, last=-gravity))
    scene.add_body("ceiling", "static")
    along = vector(dim, np.sin(angle), -np.cos(angle))
    ball = planar.Circle(radius=0.05, mask=0) if dim == 2 else spatial.Sphere(radius=0.05, mask=0)
    joint = planar.Revolute if dim == 2 else spatial.Ball
    names = ["ceiling", *(f"link {k}" for k in range(links)), "load"]
    for k in range(1, links + 2):
        place = along * min((k - 0.5) / links, 1.0)
        scene.add_body(names[k], shapes=[ball], mass=0.01 if k <= links else 10.0, position=place)
        scene.add_joint(f"joint {k}", joint(names[k - 1], names[k], anchor=along * (k - 1) / links))
    return World(scene, options=Options(timestep=1 / 60, articulated=False, sleep=False))


@DIMS
@pytest.mark.parametrize("links", [4, 8])
@pytest.mark.parametrize("applied", [False, True])
def test_a_chain_of_light_links_keeps_the_energy_of_its_load(dim: int, links: int, applied: bool) -> None:
    """Twenty seconds of a pendulum whose links have scaled masses, pulled by gravity or by forces equal to it."""
    world = loaded_chain(dim, links, 0.0 if applied else 9.81, 0.3)
    weight = 9.81 * world.parameters.bodies["mass"][0]
    weight[0] = 0.0
    mass = world.parameters.bodies["mass"][0]

    def energy() -> float:
        height = world.position[0, :, -1]
        return float(world.diagnostics().kinetic_energy[0] + weight @ height)

    start, swing = energy(), 10.0 * 9.81 * (1.0 - np.cos(0.3))
    energies, swings = [], []
    for _ in range(1200):
        if applied:
            for body in range(1, len(mass)):
                world.apply_force(body, force=vector(dim, last=-float(weight[body])))
        world.step()
        energies.append(energy())
        swings.append(abs(float(world.position[0, -1, 0])))
    assert max(energies) - start < 1e-4 * swing  # 1e-3 to 3e-3 without the guard
    assert max(swings[-240:]) > 0.99 * np.sin(0.3)
