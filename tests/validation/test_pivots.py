"""Bodies that turn about a contact: closed forms, and what contacts say of their own separation."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial

G = 9.81
GRIP = 5.0  # friction coefficient at which nothing slips
HALF_WIDTH, HALF_HEIGHT = 0.02, 0.1  # m, of the block that tips
TIME = 0.15  # s


def box(dim: int, half_width: float, half_height: float) -> planar.Box | spatial.Box:
    if dim == 2:
        return planar.Box(half_extents=(half_width, half_height), friction=GRIP)
    return spatial.Box(half_extents=(half_width, 0.1, half_height), friction=GRIP)


def placed(dim: int, x: float, z: float, angle: float) -> dict[str, Any]:
    """Return the pose of a body turned clockwise by ``angle`` about the axis that leads out of the plane."""
    if dim == 2:
        return {"position": (x, z), "angle": -angle}
    return {"position": (x, 0.0, z), "orientation": (math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0)}


def clockwise(world: World) -> float:
    """Return the angle of the last body."""
    if world.model.dim == 2:
        return -float(world.angle[0, -1])
    q = world.orientation[0, -1]
    return 2.0 * math.atan2(q[2], q[0])


def pendulum(half_width: float, half_height: float, arm: tuple[float, float], time: float) -> float:
    """Return the angle by which a box turns clockwise about a point below it; ``arm``: from there to its centre."""
    length = math.hypot(*arm)
    stiffness = G * length / ((half_width**2 + half_height**2) / 3.0 + length**2)
    start = math.atan2(arm[0], arm[1])  # from the vertical
    angle, rate, h = start, 0.0, 1e-4
    for _ in range(round(time / h)):  # leapfrog: its error is 1e-8 here
        rate += 0.5 * h * stiffness * math.sin(angle)
        angle += h * rate
        rate += 0.5 * h * stiffness * math.sin(angle)
    return angle - start


def tipping_block(dim: int) -> tuple[Scene, tuple[float, float]]:
    """A block that leans over its lower right corner, which is at the origin of a plane."""
    lean = 0.4
    c, s = math.cos(lean), math.sin(lean)
    arm = (s * HALF_HEIGHT - c * HALF_WIDTH, c * HALF_HEIGHT + s * HALF_WIDTH)
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[(planar.HalfPlane if dim == 2 else spatial.Plane)(friction=GRIP)])
    scene.add_body("block", shapes=[box(dim, HALF_WIDTH, HALF_HEIGHT)], **placed(dim, *arm, lean))
    return scene, arm


def plank_on_edge(dim: int) -> tuple[Scene, tuple[float, float]]:
    """A plank whose face lies off its middle on the edge of a block: its face turns, not the corner below it."""
    arm = (0.02, HALF_WIDTH)
    side = 0.2
    scene = Scene(dim=dim)
    post = placed(dim, 0.0, -math.sqrt(2.0) * side, 0.25 * math.pi)
    scene.add_body("post", "static", shapes=[box(dim, side, side)], **post)
    scene.add_body("plank", shapes=[box(dim, HALF_HEIGHT, HALF_WIDTH)], **placed(dim, *arm, 0.0))
    return scene, arm


def error_of(build: Callable[[int], tuple[Scene, tuple[float, float]]], dim: int, rate: int) -> float:
    """Return the error of the angle after TIME at ``rate`` steps per second, rad."""
    scene, arm = build(dim)
    world = World(scene, options=Options(timestep=1.0 / rate))
    start = clockwise(world)
    world.step(round(TIME * rate))
    sizes = (HALF_WIDTH, HALF_HEIGHT)
    return abs(clockwise(world) - start - pendulum(*sizes, arm, TIME))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("build", [tipping_block, plank_on_edge])
def test_a_body_turns_about_its_contact_as_a_pendulum_to_second_order(
    build: Callable[[int], tuple[Scene, tuple[float, float]]], dim: int
) -> None:
    coarse, fine = error_of(build, dim, 20), error_of(build, dim, 60)
    assert coarse < 3e-3
    assert fine < 4e-4
    assert coarse > 6.0 * fine


def geometric_separation(world: World, build: Callable[[int], tuple[Scene, tuple[float, float]]]) -> float:
    """Return the height of the lowest corner of the block, or of the plank's face above the edge at the origin, m."""
    angle = clockwise(world)
    c, s = math.cos(angle), math.sin(angle)
    x, z = float(world.position[0, -1, 0]), float(world.position[0, -1, -1])
    if build is tipping_block:
        return z - abs(c) * HALF_HEIGHT - abs(s) * HALF_WIDTH
    return s * x + c * z - HALF_WIDTH


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("build", [tipping_block, plank_on_edge])
def test_the_separation_of_a_contact_is_that_of_the_poses_also_where_bodies_turn(
    build: Callable[[int], tuple[Scene, tuple[float, float]]], dim: int
) -> None:
    world = World(build(dim)[0], options=Options(timestep=1.0 / 60.0))
    for _ in range(10):
        world.step()
        contacts = world.contacts()
        loaded = contacts.impulse[:, 0] > 0.0
        assert loaded.any()
        # in 3D the two points of an edge are not quite level
        tolerance = 1e-12 if dim == 2 else 1e-7
        np.testing.assert_allclose(contacts.separation[loaded], geometric_separation(world, build), atol=tolerance)
        assert abs(geometric_separation(world, build)) < 2e-5
    assert abs(float(world.state.bodies["velocity"][0, -1, 2 if dim == 2 else 4])) > 1.5  # rad/s


def ball_scene(dim: int, offset: float, ground: str) -> Scene:
    """A ball that rolls on a plane, or with much friction on a board that slides freely; off its body's centre."""
    scene = Scene(dim=dim)
    flat = (planar.HalfPlane if dim == 2 else spatial.Plane)(friction=0.0 if ground == "board" else GRIP)
    scene.add_body("ground", "static", shapes=[flat])
    height = 0.0
    if ground == "board":
        scene.add_body("board", shapes=[box(dim, 2.0, 0.05)], mass=1.0, **placed(dim, 0.0, 0.05, 0.0))
        height = 0.1
    kind: Any = planar.Circle if dim == 2 else spatial.Sphere
    place = (offset, 0.0) if dim == 2 else (offset, 0.0, 0.0)
    ball = kind(radius=0.1, friction=GRIP, position=place)
    inertia = 0.005 if dim == 2 else (0.005, 0.005, 0.005)
    motion = {"linear_velocity": (1.0, 0.0)} if dim == 2 else {"linear_velocity": (1.0, 0.0, 0.0)}
    at = (-offset, height + 0.1) if dim == 2 else (-offset, 0.0, height + 0.1)
    center = (0.0,) * dim
    scene.add_body("ball", shapes=[ball], mass=1.0, inertia=inertia, center=center, position=at, **motion)
    return scene


@pytest.mark.parametrize("ground", ["plane", "board"])
@pytest.mark.parametrize("offset", [0.0, 0.03])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_ball_stays_on_what_it_rolls_on_also_off_its_bodys_centre(dim: int, offset: float, ground: str) -> None:
    """The rows of a centred ball on a fixed face need not turn; those of an eccentric one must."""
    world = World(ball_scene(dim, offset, ground), options=Options(timestep=1.0 / 60.0))
    for _ in range(60):
        world.step()
        angle = clockwise(world)
        top = float(world.position[0, 1, -1]) + 0.05 if ground == "board" else 0.0
        # the ball's centre from its body's: the offset, turned clockwise
        gap = float(world.position[0, -1, -1]) - math.sin(angle) * offset - 0.1 - top
        contacts = world.contacts()
        touching = contacts.body_b == len(world.model.bodies) - 1
        np.testing.assert_allclose(contacts.separation[touching].min(), gap, atol=1e-9 if ground == "plane" else 2e-5)
        assert abs(gap) < 2e-4
    assert abs(clockwise(world)) > 0.5


@pytest.mark.parametrize("dim", [2, 3])
def test_the_force_of_a_contact_that_turns_changes_the_momentum_as_it_says(dim: int) -> None:
    world = World(plank_on_edge(dim)[0], options=Options(timestep=1.0 / 60.0))
    mass = float(world.parameters.mass[0, -1])
    for _ in range(20):
        before = world.state.bodies["velocity"][0, -1, :dim].copy()
        world.step()
        change = mass * (world.state.bodies["velocity"][0, -1, :dim] - before)
        change[-1] += mass * G / 60.0
        total = world.contacts().force_vector(1.0 / 60.0).sum(axis=0) / 60.0
        np.testing.assert_allclose(total, change, atol=1e-12)
