"""Friction in 3D against closed forms: along the slip, about the normal, against rolling; and bounces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options
from gsenv.solver.spatial import Box, Capsule, Cylinder, Hull, Sphere
from tests.solver.spatial.one_kernel import AWAKE, full_world, on_plane

G = 9.81
FINE = Options(timestep=1.0 / 240.0, sleep=False)
HEADINGS = (0.0, 0.7, math.pi / 2, 2.3, -2.9)


def level(heading: float) -> np.ndarray:
    return np.array((math.cos(heading), math.sin(heading), 0.0))


def lying(heading: float) -> tuple[float, float, float, float]:
    """Turns the z axis to the level direction across ``heading``."""
    turn, tilt = 0.5 * heading, -0.25 * math.pi  # first about x by -90 degrees: z to y
    cos, sin = math.cos(tilt), math.sin(tilt)
    return (math.cos(turn) * cos, math.cos(turn) * sin, math.sin(turn) * sin, math.sin(turn) * cos)


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("kind", ["cylinder", "capsule", "drum"])
def test_a_roller_rolls_straight(kind: str, heading: float) -> None:
    """Where it goes: straight on at its speed, its axis as it was."""
    shape = {
        "cylinder": Cylinder(half_length=0.5, radius=0.3),
        "capsule": Capsule(half_length=0.5, radius=0.3),
        "drum": Cylinder(half_length=0.05, radius=0.3),
    }[kind]
    scene = on_plane(G, friction=0.5)
    way, axis = level(heading), level(heading + math.pi / 2)
    scene.add_body(
        "it", shapes=[shape], position=(0, 0, 0.3), orientation=lying(heading),
        linear_velocity=2.0 * way, angular_velocity=2.0 / 0.3 * axis,
    )  # fmt: skip
    world = full_world(scene)
    world.step(120)
    place = world.position[0, 1]
    assert abs(place @ axis) < 1e-3
    assert place @ way == pytest.approx(4.0, rel=1e-2)
    assert_allclose(world.linear_velocity[0, 1], 2.0 * way, atol=0.02)
    assert_allclose(world.angular_velocity[0, 1], 2.0 / 0.3 * axis, atol=0.1)


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("shape", [Box(half_extents=(0.3, 0.2, 0.05)), Cylinder(half_length=0.05, radius=0.3)])
def test_friction_acts_along_the_slip(shape: Box | Cylinder, heading: float) -> None:
    """A sliding block stops after v^2 / (2 mu g), straight on, in any direction of the plane."""
    scene = on_plane(G, friction=0.4)
    block = type(shape)(**{**shape.__dict__, "friction": 0.4})
    way = level(heading)
    scene.add_body("it", shapes=[block], position=(0, 0, 0.05), linear_velocity=2.0 * way)
    world = full_world(scene)
    world.step(15)
    assert_allclose(world.linear_velocity[0, 1], (2.0 - 0.4 * G * 0.25) * way, atol=2e-3)
    world.step(60)
    assert_allclose(world.position[0, 1], 2.0**2 / (2 * 0.4 * G) * way + (0, 0, 0.05), atol=3e-3)
    assert np.abs(world.angular_velocity[0, 1]).max() < 1e-3


@pytest.mark.parametrize("heading", HEADINGS)
def test_a_sliding_ball_starts_to_roll(heading: float) -> None:
    """At 5/7 of its speed; its path is straight."""
    scene = on_plane(G, friction=0.3)
    way = level(heading)
    scene.add_body("it", shapes=[Sphere(radius=0.2, friction=0.3)], position=(0, 0, 0.2), linear_velocity=3.0 * way)
    world = full_world(scene)
    world.step(60)
    assert_allclose(world.linear_velocity[0, 1], 15.0 / 7.0 * way, atol=2e-3)
    assert_allclose(world.angular_velocity[0, 1], 15.0 / 7.0 / 0.2 * level(heading + math.pi / 2), atol=2e-2)


@pytest.mark.parametrize("spin", [10.0, -4.0])
def test_torsional_friction_stops_a_spinning_ball(spin: float) -> None:
    """After I |w| / (c m g) with c in m; not before, and not farther."""
    c, r = 0.02, 0.3
    scene = on_plane(G, torsional_friction=c)
    ball = Sphere(radius=r, torsional_friction=c)
    scene.add_body("it", shapes=[ball], position=(0, 0, r), angular_velocity=(0, 0, spin))
    world = full_world(scene, options=FINE)
    inertia = 0.4 * r * r  # over m
    end = inertia * abs(spin) / (c * G)
    world.step(round(0.5 * end * 240))
    assert world.angular_velocity[0, 1, 2] == pytest.approx(spin - math.copysign(c * G / inertia, spin) * world.time[0])
    world.step(round(0.4 * end * 240))
    assert abs(world.angular_velocity[0, 1, 2]) > 0.05 * abs(spin)
    world.step(round(0.11 * end * 240) + 1)
    assert np.abs(world.angular_velocity[0, 1]).max() < 1e-6
    assert_allclose(world.position[0, 1], (0, 0, r), atol=1e-3)


@pytest.mark.parametrize("heading", HEADINGS)
def test_rolling_friction_stops_a_rolling_ball(heading: float) -> None:
    """The torque c m g, c in m, on a ball that rolls: a = c g / r / (7/5), the way v^2 / (2 a), straight on."""
    c, r, v = 0.01, 0.2, 2.0
    scene = on_plane(G, friction=0.8, rolling_friction=c)
    way = level(heading)
    ball = Sphere(radius=r, friction=0.8, rolling_friction=c)
    spin = v / r * level(heading + math.pi / 2)
    scene.add_body("it", shapes=[ball], position=(0, 0, r), linear_velocity=v * way, angular_velocity=spin)
    world = full_world(scene)
    a = c * G / r / 1.4
    world.step(round(v / a * 60) + 30)
    assert_allclose(world.linear_velocity[0, 1], 0.0, atol=1e-6)
    assert_allclose(world.position[0, 1], v * v / (2 * a) * way + (0, 0, r), rtol=2e-2, atol=2e-3)


def test_without_rolling_friction_a_ball_rolls_on() -> None:
    scene = on_plane(G)
    ball = Sphere(radius=0.2)
    scene.add_body("it", shapes=[ball], position=(0, 0, 0.2), linear_velocity=(2, 1, 0), angular_velocity=(-5, 10, 0))
    world = full_world(scene)
    world.step(300)
    assert_allclose(world.linear_velocity[0, 1], (2, 1, 0), atol=1e-4)


# ---------------------------------------------------------------- bounces


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("kind", ["box", "cylinder", "hull"])
def test_a_flat_landing_keeps_the_height_and_makes_no_spin(kind: str, turn: float) -> None:
    corners = [(x, y, z) for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (-0.1, 0.1)]
    shape = {
        "box": Box(half_extents=(0.3, 0.2, 0.1), restitution=1.0),
        "cylinder": Cylinder(half_length=0.1, radius=0.3, restitution=1.0),
        "hull": Hull(vertices=corners, restitution=1.0),
    }[kind]
    scene = on_plane(G, restitution=1.0)
    scene.add_body("it", shapes=[shape], position=(0, 0, 1.1), orientation=(math.cos(turn), 0, 0, math.sin(turn)))
    world = full_world(scene)
    start = world.diagnostics().energy[0]
    for _ in range(300):
        world.step()
        assert world.diagnostics().energy[0] == pytest.approx(start, rel=1e-6)
        assert np.abs(world.angular_velocity[0, 1]).max() < 1e-6
    assert world.linear_velocity[0, 1, :2] == pytest.approx(0.0, abs=1e-6)


def test_oblique_bounces_never_make_energy() -> None:
    """50 cubes of any size, turn, spin, speed, friction and restitution, one a world."""
    scene = on_plane(G)
    scene.add_body("it", shapes=[Box(half_extents=(0.3, 0.2, 0.1), restitution=0.5)], position=(0, 0, 1))
    world = full_world(scene, 50, options=AWAKE)
    rng = np.random.default_rng(8)
    world.parameters.set("it", half_extents=np.tile(rng.uniform(0.05, 0.5, (50, 1)), 3))
    for body in ("ground", "it"):
        world.parameters.set(body, friction=rng.choice([0.0, 0.3, 1.0], 50), restitution=rng.uniform(0.0, 1.0, 50))
    world.set_pose("it", position=np.tile((0, 0, 1.0), (50, 1)), orientation=rng.normal(size=(50, 4)))
    world.set_velocity("it", linear=rng.normal(0.0, 3.0, (50, 3)), angular=rng.normal(0.0, 5.0, (50, 3)))
    d = world.diagnostics()
    scale = d.kinetic_energy + world.parameters.mass[:, 1] * G * 1.0
    least = d.energy
    for _ in range(300):
        world.step()
        energy = world.diagnostics().energy
        assert (energy <= least + 1e-3 * scale).all()
        least = np.minimum(least, energy)
    assert (world.position[:, 1, 2] > 0.0).all()
