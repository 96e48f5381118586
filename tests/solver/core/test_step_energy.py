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


def whirl(dim: int, speed: float, held: bool) -> World:
    """A heavy ball at the end of light links on a pivot, or two such balls joined by them, at 20 Hz."""
    scene = Scene(dim=dim, gravity=vector(dim))
    ball = planar.Circle(radius=0.1, mask=0) if dim == 2 else spatial.Sphere(radius=0.1, mask=0)
    links = 6
    joint = {2: "Revolute", 3: "Ball"}[dim]
    for k in range(links):
        scene.add_body(f"link {k}", shapes=[ball], mass=1e-3, position=vector(dim, 0.25 * (k + 1)))
    scene.add_body("ball", shapes=[ball], mass=10.0, position=vector(dim, 0.25 * (links + 1)),
                   linear_velocity=vector(dim, last=speed))  # fmt: skip
    if held:
        scene.add_body("other", "static")
    else:
        scene.add_body("other", shapes=[ball], mass=10.0, linear_velocity=vector(dim, last=-speed))
    names = ["other", *(f"link {k}" for k in range(links)), "ball"]
    for k in range(len(names) - 1):
        anchor = vector(dim, 0.25 * k + 0.125)
        scene.add_joint(f"joint {k}", getattr(module(dim), joint)(names[k], names[k + 1], anchor=anchor))
    return World(scene, options=Options(timestep=0.05, articulated=False))


@DIMS
@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("speed", [3.0, 30.0])
def test_light_links_of_a_whirling_load_gain_no_energy(dim: int, held: bool, speed: float) -> None:
    world = whirl(dim, speed, held)
    start = float(world.diagnostics().energy[0])
    for _ in range(100):
        world.step()
        assert float(world.diagnostics().energy[0]) <= 1.001 * start
