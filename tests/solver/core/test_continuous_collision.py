"""Continuous bodies never pass through anything, however thin."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, spatial
from gsenv.solver.planar import Box, Circle

BALL = Circle(radius=0.5)
THIN = 0.005  # half of 1 cm
SPEED = 500.0


def shot(
    angle: float = 0.0, dynamic: float = 0.0, continuous: bool = True, shape: Any = BALL, start: float = -4.0,
    speed: float = SPEED, spin: float = 0.0, restitution: float = 0.0,
) -> World:  # fmt: skip
    """A shot along x at a wall of 40 m x 1 cm through the origin; of ``dynamic`` kg, 0 is static."""
    scene = Scene(gravity=(0, 0))
    wall = Box(half_extents=(THIN, 20.0), restitution=restitution)
    given: dict[str, Any] = {"mass": dynamic} if dynamic else {"kind": "static"}
    scene.add_body("wall", shapes=[wall], angle=angle, **given)
    scene.add_body(
        "shot",
        shapes=[shape],
        position=(start, 0),
        linear_velocity=(speed, 0),
        angular_velocity=spin,
        continuous=continuous,
    )
    return World(scene)


def beyond(world: World, steps: int = 30) -> float:
    """Farthest that the shot's middle came behind the wall's, m, in the wall's own frame and beside it."""
    farthest = -np.inf
    for _ in range(steps):
        world.step()
        cos, sin = world.state.bodies["rotation"][0, 0]
        x, y = world.center_of_mass[0, 1] - world.center_of_mass[0, 0]
        if abs(cos * y - sin * x) > 20.0:
            break  # slid off its end
        farthest = max(farthest, cos * x + sin * y)
    assert np.isfinite(world.position).all()
    return float(farthest)


ANGLES = (0.0, 0.3, -0.7, 1.1, 1.4)
STARTS = (-3.0, -4.0, -4.123, -6.7, -8.0)  # where in the step the hit comes: 8.3 m a step


@pytest.mark.parametrize("angle", ANGLES)
def test_a_ball_never_passes_a_static_wall(angle: float) -> None:
    for start in STARTS:
        world = shot(angle, start=start)
        assert beyond(world) < -0.5 * 0.95
        # what is left is the speed along the wall, less than that of sliding without friction
        along = np.array([-np.sin(angle), np.cos(angle)])
        assert abs(world.linear_velocity[0, 1] @ along) <= SPEED * abs(np.sin(angle)) * (1 + 1e-9)


@pytest.mark.parametrize("mass", [0.01, 1.0, 1000.0])
@pytest.mark.parametrize("angle", ANGLES)
def test_a_ball_never_passes_a_wall_that_moves(angle: float, mass: float) -> None:
    for start in STARTS:
        world = shot(angle, mass, start=start)
        momentum = world.diagnostics().momentum.copy()
        energy = world.diagnostics().energy[0]
        assert beyond(world, 12) < 0.0
        np.testing.assert_allclose(world.diagnostics().momentum, momentum, rtol=1e-9, atol=1e-9 * SPEED)
        assert world.diagnostics().energy[0] <= energy * (1 + 1e-9)


def test_a_ball_bounces_off_with_its_speed() -> None:
    for start in STARTS:
        world = shot(start=start, restitution=1.0)
        assert beyond(world) < -0.5 * 0.95
        assert world.linear_velocity[0, 1, 0] == pytest.approx(-SPEED, rel=1e-9)


def box_of(dim: int, half: Sequence[float]) -> Any:
    return Box(half_extents=half) if dim == 2 else spatial.Box(half_extents=half)


@pytest.mark.parametrize(("dim", "restitution"), [(2, 0.0), (2, 0.9), (2, 1.0), (3, 0.0), (3, 0.9)])
def test_a_ball_stays_in_a_thin_box(dim: int, restitution: float) -> None:
    scene = Scene(dim=dim)
    for k, axis in enumerate(np.repeat(np.eye(dim), 2, axis=0)):
        half = np.where(axis > 0.0, THIN, 2.0).tolist()
        scene.add_body(f"wall_{k}", "static", shapes=[box_of(dim, half)], position=2.0 * (-1) ** k * axis)
    material: dict[str, Any] = {"radius": 0.1, "restitution": restitution}
    ball: Any = Circle(**material) if dim == 2 else spatial.Sphere(**material)
    velocity = (400.0, 300.0) if dim == 2 else (100.0, 150.0, 80.0)
    scene.add_body("ball", shapes=[ball], linear_velocity=velocity, continuous=True)
    world = World(scene, options=Options(sleep=False))
    for _ in range(600):
        world.step()
        assert np.abs(world.position[0, 2 * dim]).max() < 2.0


RODS = list(itertools.product((0.0, 20.0, 200.0, 1000.0), (20.0, 100.0, 500.0)))
ROD = Box(half_extents=(0.5, 0.01))


@pytest.mark.parametrize(("spin", "speed"), RODS)
def test_a_spinning_rod_never_passes(spin: float, speed: float) -> None:
    for start in STARTS:
        assert beyond(shot(shape=ROD, start=start, spin=spin, speed=speed), 60) < 0.0


@pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
def test_a_continuous_body_that_rests_is_like_any_other(dim: int) -> None:
    up = np.eye(dim)[-1]
    heights = []
    for continuous in (True, False):
        scene = Scene(dim=dim)
        floor = box_of(dim, np.where(up > 0.0, 0.5, 3.0).tolist())
        scene.add_body("floor", "static", shapes=[floor], position=-0.5 * up)
        scene.add_body("box", shapes=[box_of(dim, [0.5] * dim)], position=1.5 * up, continuous=continuous)
        world = World(scene)
        world.step(180)
        assert world.asleep[0, 1]
        heights.append(world.position[0, 1, -1])
    np.testing.assert_allclose(heights, 0.5, atol=1e-3)  # m


def test_without_the_flag_round_bodies_stop_and_spinning_rods_may_pass() -> None:
    # what the flag is for: the cheap prediction follows the linear motion, not a fast spin
    for angle, start in itertools.product(ANGLES, STARTS):
        assert beyond(shot(angle, continuous=False, start=start)) < -0.5 * 0.95
    passed = [beyond(shot(shape=ROD, spin=spin, speed=speed, continuous=False), 60) > 0.5 for spin, speed in RODS]
    assert any(passed)
    assert not any(p for p, (spin, _) in zip(passed, RODS, strict=True) if spin == 0.0)
