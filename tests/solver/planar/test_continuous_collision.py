"""Fast bodies never tunnel."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.core.broadphase import encode_exclusion
from gsenv.solver.core.continuous_collision import keep_start, resolve_continuous_collisions
from gsenv.solver.planar import Box, Circle, HalfPlane, Polygon, Shape, Terrain
from gsenv.solver.records.model import Array, BodyKind
from tests.solver.planar.narrowphase.collision import DYNAMIC, STATIC, TIMESTEP, Arrays, body, world

REST = np.zeros(2)
NOTHING = np.zeros(0, np.int64)


def moved(arrays: Arrays, exclusions: Array = NOTHING) -> int:
    """One step of free motion, then the sweep."""
    kernels_world = arrays.world(REST, exclusions=exclusions)
    start_poses = kernels_world.scratch.start_poses
    keep_start(kernels_world, start_poses)
    for state, model in zip(arrays.bodies, arrays.body_models, strict=True):
        if model["kind"] != STATIC:
            state["position"] += TIMESTEP * state["velocity"][:2]
            state["angle"] += TIMESTEP * state["velocity"][2]
            state["rotation"] = np.cos(state["angle"]), np.sin(state["angle"])
    return int(resolve_continuous_collisions(kernels_world, start_poses))


def fast(shape: Shape, x: float, y: float, vx: float, vy: float, spin: float = 0.0) -> dict[str, object]:
    return body(shape, at=(x, y), velocity=(vx, vy, spin), continuous=True)


WALLS = {
    "box": Box(half_extents=(0.005, 5.0)),
    "polygon": Polygon(vertices=[(-0.005, -5), (0.005, -5), (0.005, 5), (-0.005, 5)]),
    "terrain": Terrain(vertices=[(0.0, -5.0), (0.0, 5.0)]),
    "half-plane": HalfPlane(normal=(-1.0, 0.0)),
}


@pytest.mark.parametrize("kind", [STATIC, DYNAMIC])
@pytest.mark.parametrize("wall", WALLS)
def test_ball_at_500_m_per_s_against_a_centimetre(wall: str, kind: BodyKind) -> None:
    shape = WALLS[wall]
    if kind == DYNAMIC and not shape.solid:
        return
    arrays = world(body(shape, kind=kind), fast(Circle(radius=0.5), -4.0, 0.3, 500.0, 0.0))
    assert moved(arrays) == 1
    front = arrays.bodies["position"][1, 0] + 0.5
    assert -0.015 < front <= 0.0
    assert arrays.bodies["velocity"][1, 0] == 500.0


@pytest.mark.parametrize("angle", [-np.pi / 2, 0.5, 3.0])
def test_ball_against_rotated_terrain(angle: float) -> None:
    """The chain's normal counts in the world, not in the frame of the terrain's body."""
    normal = -np.array([np.cos(angle), np.sin(angle)])
    ball = fast(Circle(radius=0.5), *(4.0 * normal), *(-500.0 * normal))
    arrays = world(body(WALLS["terrain"], kind=STATIC, angle=angle), ball)
    assert moved(arrays) == 1
    distance = arrays.bodies["position"][1] @ normal
    assert 0.5 <= distance < 0.515


@pytest.mark.parametrize("radius", [0.002, 0.01, 0.1])
def test_small_balls_do_not_tunnel_either(radius: float) -> None:
    for speed in (20.0, 100.0, 500.0):
        for gap in (0.01, 0.3 * speed * TIMESTEP, 0.8 * speed * TIMESTEP):
            ball = fast(Circle(radius=radius), -0.005 - radius - gap, 0.3, speed, 0.3 * speed)
            arrays = world(body(WALLS["box"], kind=STATIC), ball)
            assert moved(arrays) == 1
            assert arrays.bodies["position"][1, 0] + radius < -0.004


def test_the_next_step_sees_the_hit() -> None:
    arrays = world(body(WALLS["box"], kind=STATIC), fast(Circle(radius=0.5), -4.0, 0.3, 500.0, 0.0))
    moved(arrays)
    contacts = arrays.contacts(REST)
    np.testing.assert_allclose(contacts["normal"], [(1.0, 0.0)] if contacts["body_a"][0] else [(-1.0, 0.0)])
    assert abs(contacts["separation"][0]) < 0.01


def test_a_miss_is_left_alone() -> None:
    arrays = world(body(WALLS["box"], kind=STATIC), fast(Circle(radius=0.5), -4.0, 5.6, 500.0, 0.0))
    assert moved(arrays) == 0
    assert arrays.bodies["position"][1, 0] == pytest.approx(-4.0 + 500.0 / 60.0)


def test_sliding_and_resting_are_left_alone() -> None:
    floor = body(Box(half_extents=(50.0, 0.5)), at=(0.0, -0.5), kind=STATIC)
    for height in (0.2, 0.1999, 0.2001):
        arrays = world(floor, fast(Box(half_extents=(0.2, 0.2)), 0.0, height, 100.0, -0.2))
        assert moved(arrays) == 0


def test_thin_spinning_rod() -> None:
    """Half a turn within a step, over a thin post beside it."""
    post = body(Box(half_extents=(0.02, 0.02)), at=(0.0, 0.8), kind=STATIC)
    arrays = world(post, fast(Box(half_extents=(1.0, 0.01)), 0.0, 0.0, 0.0, 0.0, 180.0))
    assert moved(arrays) == 1
    assert 0.0 < arrays.bodies["angle"][1] < np.pi / 2
    np.testing.assert_allclose(np.hypot(*arrays.bodies["rotation"][1]), 1.0)
    c, s = arrays.bodies["rotation"][1]
    assert abs(s * 0.0 - c * 0.8) < 0.08  # the post is just beside the rod's line
    far = body(Box(half_extents=(0.02, 0.02)), at=(0.0, 1.2), kind=STATIC)
    assert moved(world(far, fast(Box(half_extents=(1.0, 0.01)), 0.0, 0.0, 0.0, 0.0, 180.0))) == 0


def test_first_of_several_walls_counts() -> None:
    walls = [body(WALLS["box"], at=(x, 0.0), kind=STATIC) for x in (2.0, 0.0, 1.0)]
    arrays = world(*walls, fast(Circle(radius=0.5), -4.0, 0.0, 500.0, 0.0))
    moved(arrays)
    assert arrays.bodies["position"][3, 0] + 0.5 <= 0.0


def test_filters_hold() -> None:
    wall = body(Box(half_extents=(0.005, 5.0), category=2), kind=STATIC)
    ghost = fast(Circle(radius=0.5, mask=1), -4.0, 0.0, 500.0, 0.0)
    assert moved(world(wall, ghost)) == 0
    wall = body(WALLS["box"], kind=STATIC)
    ball = fast(Circle(radius=0.5), -4.0, 0.0, 500.0, 0.0)
    assert moved(world(wall, ball), np.array([encode_exclusion(1, 0)])) == 0
    sensor = body(Box(half_extents=(0.005, 5.0), sensor=True), kind=STATIC)
    assert moved(world(sensor, ball)) == 0


def test_slow_bodies_are_not_swept() -> None:
    ball = body(Circle(radius=0.5), at=(-4.0, 0.0), velocity=(500.0, 0.0, 0.0))
    arrays = world(body(WALLS["box"], kind=STATIC), ball)
    assert moved(arrays) == 0
