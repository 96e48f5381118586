"""Bodies jammed between moving kinematic bodies, whose rows have no solution."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial

SPEED = 1.0  # m/s, of each wall


def press(dim: int, count: int, offset: float) -> World:
    """Two kinematic walls that approach each other at SPEED, with a row of boxes between them."""
    module: Any = planar if dim == 2 else spatial
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    rng = np.random.default_rng(count)
    wall = module.Box(half_extents=(0.1, *(2.0,) * (dim - 1)))
    gap = 0.2 * count + 0.02
    for name, side in (("left", -1.0), ("right", 1.0)):
        place = np.zeros(dim)
        place[0] = side * (0.5 * gap + 0.1)
        velocity = np.zeros(dim)
        velocity[0] = -side * SPEED
        scene.add_body(name, "kinematic", shapes=[wall], position=place, linear_velocity=velocity)
    for k in range(count):
        place = np.zeros(dim)
        place[0] = 0.2 * (k - 0.5 * (count - 1))
        place[1] = offset * rng.uniform(-0.1, 0.1)
        box = module.Box(half_extents=(0.1,) * dim, density=float(rng.uniform(100.0, 3000.0)))
        scene.add_body(f"box {k}", shapes=[box], position=place)
    return World(scene, options=Options(timestep=1 / 60))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("offset", [0.0, 1.0])
@pytest.mark.parametrize("count", [1, 3, 6])
def test_a_press_throws_nothing_out(dim: int, count: int, offset: float) -> None:
    world = press(dim, count, offset)
    unfinished = 0
    for _ in range(20):
        world.step()
        unfinished += int(world.diagnostics().unconverged[0])
        speeds = np.linalg.norm(world.linear_velocity[0, 2:], axis=-1)
        assert np.isfinite(speeds).all()
        assert speeds.max() <= 20.0 * SPEED
    assert unfinished > 0  # no velocity obeys both walls


def test_what_a_wall_pushes_is_not_held_back() -> None:
    """A row of ten boxes without friction, pushed from one side, moves at the speed of the wall."""
    scene = Scene(gravity=(0.0, -9.81))
    scene.add_body("ground", "static", shapes=[planar.HalfPlane(friction=0.0)])
    wall = planar.Box(half_extents=(0.1, 0.5), friction=0.0)
    scene.add_body("wall", "kinematic", shapes=[wall], position=(-0.5, 0.6), linear_velocity=(3.0, 0.0))
    for k in range(10):
        box = planar.Box(half_extents=(0.1, 0.1), friction=0.0, density=100.0 * (1 + k % 3))
        scene.add_body(f"box {k}", shapes=[box], position=(0.25 * k, 0.1))
    world = World(scene, options=Options(timestep=1 / 60))
    world.step(120)
    np.testing.assert_allclose(world.linear_velocity[0, 2:, 0], 3.0, rtol=5e-3)
