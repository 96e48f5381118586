"""Continuous bodies in 3D never pass through anything, however thin."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import World
from gsenv.solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Sphere
from tests.solver.spatial.one_kernel import CORNERS, full_world, space

THIN = 0.005  # half of 1 cm
SHAPES: dict[str, Any] = {
    "sphere": Sphere(radius=0.05),
    "box": Box(half_extents=(0.1, 0.05, 0.03)),
    "capsule": Capsule(half_length=0.1, radius=0.02),
    "cylinder": Cylinder(half_length=0.1, radius=0.04),
    "hull": Hull(vertices=0.15 * np.array(CORNERS)),
}
SPEEDS = (50.0, 120.0, 200.0)
STARTS = (-1.0, -1.37, -2.2, -3.01)  # m, where in the step the hit comes
TURN = (0.7, 0.3, -0.5, 0.4)


def plate(tilt: float) -> tuple[float, float, float, float]:
    """Turned about y: its normal is x turned towards z."""
    return (math.cos(0.5 * tilt), 0.0, math.sin(0.5 * tilt), 0.0)


def shot(shape: Any, speed: float, tilt: float = 0.0, **wall: Any) -> World:
    """One world a start: a shot along x at a plate of 1 cm through the origin."""
    scene = space()
    given = {"kind": "static", **wall}
    scene.add_body("wall", shapes=[Box(half_extents=(THIN, 10.0, 10.0))], orientation=plate(tilt), **given)
    scene.add_body("shot", shapes=[shape], linear_velocity=(speed, 0, 0), orientation=TURN, continuous=True)
    world = full_world(scene, len(STARTS))
    world.set_pose("shot", position=[(x, 0.01, -0.02) for x in STARTS])
    return world


def beyond(world: World, steps: int = 24) -> float:
    """Farthest that a shot's middle came behind the plate's, m, in the plate's own frame and beside it."""
    farthest = -np.inf
    for _ in range(steps):
        world.step()
        apart = world.center_of_mass[:, 1] - world.center_of_mass[:, 0]
        w, x, y, z = world.orientation[:, 0].T
        normal = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
        behind = (apart * normal).sum(1)
        beside = np.sqrt((apart**2).sum(1) - behind**2) < 9.0
        farthest = max([farthest, *behind[beside]])
    assert np.isfinite(world.position).all()
    return float(farthest)


@pytest.mark.parametrize(("name", "speed"), list(itertools.product(SHAPES, SPEEDS)))
def test_nothing_passes_a_static_plate(name: str, speed: float) -> None:
    for tilt in (0.0, 0.6, -1.2):
        assert beyond(shot(SHAPES[name], speed, tilt)) < 0.0


@pytest.mark.parametrize("mass", [0.01, 100.0])
@pytest.mark.parametrize("name", SHAPES)
def test_nothing_passes_a_plate_that_can_move(name: str, mass: float) -> None:
    for speed in SPEEDS:
        world = shot(SHAPES[name], speed, 0.4, kind="dynamic", mass=mass)
        momentum = world.diagnostics().momentum
        assert beyond(world, 12) < 0.0
        np.testing.assert_allclose(world.diagnostics().momentum, momentum, atol=1e-8 * abs(momentum).max())


@pytest.mark.parametrize("velocity", [-30.0, -3.0, 30.0])
@pytest.mark.parametrize("name", SHAPES)
def test_nothing_passes_a_moving_plate(name: str, velocity: float) -> None:
    """Kinematic, towards the shot or away from it."""
    for speed in SPEEDS:
        world = shot(SHAPES[name], speed, 0.3, kind="kinematic", linear_velocity=(velocity, 0, 0))
        assert beyond(world, 12) < 0.0


@pytest.mark.parametrize("name", SHAPES)
def test_nothing_passes_a_heightfield(name: str) -> None:
    rng = np.random.default_rng(3)
    field = Heightfield(heights=rng.uniform(0.0, 0.3, (21, 21)), size=(10, 10))
    scene = space(9.81)
    scene.add_body("field", "static", shapes=[field])
    scene.add_body("shot", shapes=[SHAPES[name]], orientation=TURN, continuous=True)
    world = full_world(scene, 24)
    world.set_pose("shot", position=np.column_stack([rng.uniform(-1, 1, (24, 2)), rng.uniform(1.0, 4.0, 24)]))
    way = np.column_stack([rng.normal(0.0, 0.2, (24, 2)), -np.ones(24)])
    world.set_velocity("shot", linear=way * rng.uniform(50.0, 200.0, (24, 1)))
    for _ in range(60):
        world.step()
        x, y, z = world.position[:, 1].T
        inside = np.maximum(abs(x), abs(y)) < 4.9
        assert (z[inside] > -0.01).all()
    assert np.isfinite(world.position).all()
