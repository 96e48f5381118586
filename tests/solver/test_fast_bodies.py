"""Bodies marked fast never pass through anything, however thin."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Box, Circle, Options, Scene, World

BALL = Circle(radius=0.5)
THIN = 0.005  # half of 1 cm
SPEED = 500.0


def shot(
    angle: float = 0.0, dynamic: float = 0.0, fast: bool = True, shape: Any = BALL, start: float = -4.0,
    speed: float = SPEED, spin: float = 0.0, restitution: float = 0.0,
) -> World:  # fmt: skip
    """A shot along x at a wall of 40 m x 1 cm through the origin; of ``dynamic`` kg, 0 is static."""
    scene = Scene(gravity=(0, 0))
    wall = Box(half_extents=(THIN, 20.0), restitution=restitution)
    given: dict[str, Any] = {"mass": dynamic} if dynamic else {"kind": "static"}
    scene.add_body("wall", shapes=[wall], angle=angle, **given)
    scene.add_body(
        "shot", shapes=[shape], position=(start, 0), linear_velocity=(speed, 0), angular_velocity=spin, fast=fast
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


@pytest.mark.parametrize("restitution", [0.0, 0.9, 1.0])
def test_a_ball_stays_in_a_thin_box(restitution: float) -> None:
    scene = Scene()
    for k, (x, y) in enumerate([(-2, 0), (2, 0), (0, -2), (0, 2)]):
        half = (THIN, 2.0) if y == 0 else (2.0, THIN)
        scene.add_body(f"wall_{k}", kind="static", shapes=[Box(half_extents=half)], position=(x, y))
    ball = Circle(radius=0.1, restitution=restitution)
    scene.add_body("ball", shapes=[ball], linear_velocity=(400, 300), fast=True)
    world = World(scene, options=Options(sleep=False))
    for _ in range(600):
        world.step()
        assert np.abs(world.position[0, 4]).max() < 2.0


RODS = list(itertools.product((0.0, 20.0, 200.0, 1000.0), (20.0, 100.0, 500.0)))
ROD = Box(half_extents=(0.5, 0.01))


@pytest.mark.parametrize(("spin", "speed"), RODS)
def test_a_spinning_rod_never_passes(spin: float, speed: float) -> None:
    for start in STARTS:
        assert beyond(shot(shape=ROD, start=start, spin=spin, speed=speed), 60) < 0.0


def test_a_fast_body_that_rests_is_like_any_other() -> None:
    heights = []
    for fast in (True, False):
        scene = Scene()
        scene.add_body("floor", kind="static", shapes=[Box(half_extents=(3, 0.5))], position=(0, -0.5))
        scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 1.5), fast=fast)
        world = World(scene)
        world.step(180)
        assert world.asleep[0, 1]
        heights.append(world.position[0, 1, 1])
    np.testing.assert_allclose(heights, 0.5, atol=1e-3)


def test_without_the_flag_round_bodies_stop_and_spinning_rods_may_pass() -> None:
    # what the flag is for: the cheap prediction follows the linear motion, not a fast spin
    for angle, start in itertools.product(ANGLES, STARTS):
        assert beyond(shot(angle, fast=False, start=start)) < -0.5 * 0.95
    passed = [beyond(shot(shape=ROD, spin=spin, speed=speed, fast=False), 60) > 0.5 for spin, speed in RODS]
    assert any(passed)
    assert not any(p for p, (spin, _) in zip(passed, RODS, strict=True) if spin == 0.0)
