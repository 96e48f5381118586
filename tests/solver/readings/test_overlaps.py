"""Diagnostics.penetration against depths that the test computes from the poses alone."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.planar.narrowphase.boxes import REFERENCE_BIAS
from gsenv.solver.records.model import Array

BOXES = 9


def planar_scatter(seed: int) -> Scene:
    """Boxes with random sizes and poses in a small square, which overlap each other."""
    rng = np.random.default_rng(seed)
    scene = Scene(gravity=(0, 0))
    for k in range(BOXES):
        half = tuple(rng.uniform(0.1, 0.5, 2))
        place = tuple(rng.uniform(-1, 1, 2))
        scene.add_body(f"b{k}", shapes=[planar.Box(half_extents=half)], position=place, angle=rng.uniform(0, 7))
    return scene


def corners(world: World, w: int, k: int) -> Array:
    """The corners (4, 2) of a 2D box, m."""
    half = world.parameters.shapes["size"][w, k, :2]
    c, s = math.cos(world.angle[w, k]), math.sin(world.angle[w, k])
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return world.position[w, k] + (signs * half) @ np.array([(c, s), (-s, c)])


def depth_of_polygons(a: Array, b: Array) -> float:
    """The least translation that separates two convex polygons, by projection on all edge normals; 0 if apart."""
    depths = []
    for polygon in (a, b):
        edges = np.roll(polygon, -1, 0) - polygon
        normals = np.stack([edges[:, 1], -edges[:, 0]], -1)
        for n in normals / np.linalg.norm(normals, axis=1)[:, None]:
            p, q = a @ n, b @ n
            depths.append(min(p.max() - q.min(), q.max() - p.min()))
    return max(min(depths), 0.0)


def deepest(world: World, w: int) -> float:
    boxes = [corners(world, w, k) for k in range(BOXES)]
    return max(depth_of_polygons(a, b) for i, a in enumerate(boxes) for b in boxes[:i])


@pytest.mark.parametrize("seed", range(6))
def test_depth_of_2d_boxes_anywhere(seed: int) -> None:
    """Before any step and after some, in several worlds: the contacts of the step play no part."""
    world = World(planar_scatter(seed), world_count=2)
    world.set_pose("b0", position=(0.3, 0.2), worlds=1)
    for steps in (0, 1, 20):
        world.step(steps)
        expected = [deepest(world, w) for w in range(2)]
        # of two directions with nearly equal depths the narrowphase prefers a face of the first box
        bias = REFERENCE_BIAS * world.parameters.shapes["extent"].min()
        np.testing.assert_allclose(world.diagnostics().penetration, expected, atol=bias)


def drop(dim: int) -> Scene:
    """A box that is asleep 3 cm deep in the ground, and a ball 10 cm deep in the box."""
    scene = Scene(dim=dim)
    up = np.eye(dim)[-1]
    shapes: list[planar.Shape | spatial.Shape] = [
        planar.HalfPlane(),
        planar.Box(half_extents=(0.5, 0.5)),
        planar.Circle(radius=0.2),
    ]
    if dim == 3:
        shapes = [spatial.Plane(), spatial.Box(half_extents=(0.5, 0.5, 0.5)), spatial.Sphere(radius=0.2)]
    ground, box, ball = shapes
    scene.add_body("ground", "static", shapes=[ground])
    scene.add_body("box", shapes=[box], position=0.47 * up)
    scene.add_body("ball", shapes=[ball], position=(0.97 + 0.1) * up)
    return scene


def height_per_size(world: World) -> float:
    """The height of the box over its edge: the contacts of two sweeps leave it tilted a little."""
    if world.model.dim == 2:
        return abs(math.cos(world.angle[0, 1])) + abs(math.sin(world.angle[0, 1]))
    w, x, y, z = world.orientation[0, 1]
    return abs(2 * (x * z - w * y)) + abs(2 * (y * z + w * x)) + abs(w * w - x * x - y * y + z * z)


@pytest.mark.parametrize("dim", [2, 3])
def test_depth_follows_the_poses_and_the_filters(dim: int) -> None:
    world = World(drop(dim), options=Options(sleep_time=0.0, sleep_speed=1e9))
    up = np.eye(dim)[-1]
    assert world.diagnostics().penetration[0] == pytest.approx(0.1, abs=1e-12)
    world.step(2)  # asleep at once
    assert world.asleep[0, 1:].all()
    world.set_pose("ball", position=5.0 * up)
    low = world.position[0, 1] @ up - 0.5 * height_per_size(world)
    assert low < -0.01
    assert world.diagnostics().penetration[0] == pytest.approx(-low, abs=1e-12)
    world.parameters.set("box", enabled=False)
    assert world.diagnostics().penetration[0] == 0.0
    copy = pickle.loads(pickle.dumps(world))
    copy.parameters.set("box", enabled=True)
    assert copy.diagnostics().penetration[0] == pytest.approx(-low, abs=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_depth_below_uneven_ground(dim: int) -> None:
    scene = Scene(dim=dim)
    if dim == 2:
        scene.add_body("ground", "static", shapes=[planar.Terrain(vertices=[(-5, 0), (0, 0), (5, 0)])])
        scene.add_body("ball", shapes=[planar.Circle(radius=0.3)], position=(1.0, 0.18))
    else:
        field = spatial.Heightfield(heights=np.zeros((4, 4)), size=(10.0, 10.0))
        scene.add_body("ground", "static", shapes=[field])
        scene.add_body("ball", shapes=[spatial.Sphere(radius=0.3)], position=(1.0, 0.5, 0.18))
    assert World(scene).diagnostics().penetration[0] == pytest.approx(0.12, abs=1e-12)


def test_many_overlaps_need_more_room_for_pairs() -> None:
    scene = Scene(gravity=(0, 0))
    for k in range(60):
        scene.add_body(f"b{k}", shapes=[planar.Circle(radius=1.0)], position=(0.01 * k, 0))
    assert World(scene).diagnostics().penetration[0] == pytest.approx(1.99, abs=1e-12)
