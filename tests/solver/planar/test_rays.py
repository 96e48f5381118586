"""Rays against every shape: convex functions and linear solves as oracles; rims and insides."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

from gsenv.solver import RayHits, Scene, World
from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon, Shape, Terrain
from gsenv.solver.planar.kinds import ShapeKind
from gsenv.solver.records.model import Array

INF = float("inf")
Height = Callable[[Array], Any]  # of a point: negative inside, convex

WEDGE = [(-0.3, -0.4), (0.8, -0.2), (0.6, 0.5), (-0.1, 0.7)]
SHAPES: dict[str, Shape] = {
    "circle": Circle(radius=0.6, position=(0.2, -0.1)),
    "box": Box(half_extents=(0.8, 0.3), position=(0.1, 0.2), angle=0.4),
    "capsule": Capsule(half_length=0.7, radius=0.25, angle=-0.9),
    "polygon": Polygon(vertices=WEDGE, position=(-0.2, 0.1), angle=1.1),
    "half-plane": HalfPlane(normal=(0.3, 1.0), offset=-0.2),
}


# ---------------------------------------------------------------- the oracles


def turned(angle: float, points: Any) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points, float) @ np.array([[c, s], [-s, c]])


def placed(shape: Shape, pose: Any, points: Any) -> Array:
    """Points of a shape's frame in the world; pose: x, y, angle of the body."""
    return turned(pose[2], turned(shape.angle, points) + np.asarray(shape.position)) + np.asarray(pose[:2])


def height_of(shape: Shape, pose: Any) -> Height:
    """A convex function that is negative inside of a shape."""
    if isinstance(shape, Circle):
        center, radius = placed(shape, pose, (0.0, 0.0)), shape.radius
        return lambda p: np.hypot(*(p - center)) - radius
    if isinstance(shape, Capsule):
        ends, width = placed(shape, pose, [(-shape.half_length, 0.0), (shape.half_length, 0.0)]), shape.radius
        axis = ends[1] - ends[0]

        def from_segment(p: Array) -> Any:
            part = np.clip((p - ends[0]) @ axis / (axis @ axis), 0.0, 1.0)
            return np.hypot(*(p - ends[0] - part * axis)) - width

        return from_segment
    if isinstance(shape, HalfPlane):
        up = np.asarray(shape.normal) / np.hypot(*shape.normal)
        foot = placed(shape, pose, up * shape.offset / np.hypot(*shape.normal))
        direction = turned(pose[2] + shape.angle, up)
        return lambda p: (p - foot) @ direction
    if isinstance(shape, Box):
        hx, hy = shape.half_extents
        corners = placed(shape, pose, [(-hx, -hy), (hx, -hy), (hx, hy), (-hx, hy)])
    else:
        assert isinstance(shape, Polygon)
        corners = placed(shape, pose, shape.vertices)
    edges = np.roll(corners, -1, axis=0) - corners
    out = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.hypot(*edges.T)[:, None]
    return lambda p: ((p - corners) * out).sum(-1).max()


def entry(height: Height, origin: Array, way: Array, length: float) -> tuple[float, float]:
    """(distance or infinity, depth of the deepest point on the ray); 0 for a start inside."""

    def along(t: float) -> float:
        return float(height(origin + t * way))

    lowest = minimize_scalar(along, bounds=(0.0, length), method="bounded", options={"xatol": 1e-13}).x
    lowest = min((0.0, length, float(lowest)), key=along)
    depth = -along(lowest)
    if depth <= 0.0:
        return INF, depth
    if along(0.0) < 0.0:
        return 0.0, depth
    return float(brentq(along, 0.0, lowest, xtol=1e-14)), depth


def chain_entry(points: Array, closed: bool, origin: Array, way: Array, length: float) -> float:
    """Nearest crossing of a chain's front: two linear equations for each edge."""
    best = INF
    ends = np.roll(points, -1, axis=0)
    for a, edge in list(zip(points, ends - points, strict=True))[: None if closed else -1]:
        if way @ (-edge[1], edge[0]) < 0.0:  # the solid is on the right
            t, part = np.linalg.solve(np.stack([way, -edge], axis=1), a - origin)
            if 0.0 <= t <= length and 0.0 <= part <= 1.0:
                best = min(best, float(t))
    return best


# ---------------------------------------------------------------- scenes


def still(*shapes: Shape) -> World:
    """One kinematic body at the origin for each shape."""
    scene = Scene()
    for k, shape in enumerate(shapes):
        scene.add_body(f"b{k}", "kinematic", [shape])
    return World(scene)


def first(hits: RayHits) -> tuple[float, int, tuple[float, float]]:
    """Of the only ray: distance, shape, normal."""
    assert hits.distance.shape == (1, 1)
    x, y = hits.normal[0, 0]
    return float(hits.distance[0, 0]), int(hits.shape[0, 0]), (float(x), float(y))


WORLDS = {name: still(shape) for name, shape in SHAPES.items()}
coordinate = st.floats(-3.0, 3.0)
angles = st.floats(-7.0, 7.0)


@pytest.mark.parametrize("name", SHAPES)
@settings(max_examples=150)
@given(pose=st.tuples(coordinate, coordinate, angles), start=st.tuples(coordinate, coordinate), angle=angles,
       length=st.floats(0.1, 9.0))  # fmt: skip
def test_each_shape_against_its_height(name: str, pose: Any, start: Any, angle: float, length: float) -> None:
    world, height = WORLDS[name], height_of(SHAPES[name], pose)
    world.set_pose("b0", position=pose[:2], angle=pose[2])
    origin, way = np.array(start), np.array([np.cos(angle), np.sin(angle)])
    expected, depth = entry(height, origin, way, length)
    hits = world.cast_rays(origin, 7.0 * way, length)
    distance, shape, normal = first(hits)
    if abs(depth) < 1e-9 or abs(height(origin)) < 1e-9 or abs(height(origin + length * way)) < 1e-9:
        return  # touching, by rounding
    if expected == INF:
        assert (distance, shape, normal) == (length, -1, (0.0, 0.0))
        np.testing.assert_allclose(hits.point[0, 0], origin + length * way, atol=1e-12)
        assert not hits.hit.any()
        return
    assert (shape, hits.body[0, 0], hits.hit[0, 0]) == (0, 0, True)
    assert distance == pytest.approx(expected, abs=1e-9 / np.sqrt(min(depth, 1.0)))
    np.testing.assert_allclose(hits.point[0, 0], origin + distance * way, atol=1e-12)
    if expected == 0.0:
        np.testing.assert_allclose(normal, -way, atol=1e-12)
        return
    assert abs(height(hits.point[0, 0])) < 1e-9
    assert np.hypot(*normal) == pytest.approx(1.0, abs=1e-12)
    # a step out along the normal is as high as it is long
    out = height(hits.point[0, 0] + 1e-5 * np.array(normal))
    assert out == pytest.approx(1e-5, rel=1e-4)
    assert np.dot(normal, way) < 0.0


def random_shape(kind: ShapeKind, rng: np.random.Generator) -> Shape:
    position, angle = rng.normal(size=2) * 0.3, rng.uniform(-4, 4)
    if kind == ShapeKind.CIRCLE:
        return Circle(radius=rng.uniform(0.1, 0.8), position=position)
    if kind == ShapeKind.BOX:
        return Box(half_extents=rng.uniform(0.1, 0.8, 2), position=position, angle=angle)
    if kind == ShapeKind.CAPSULE:
        half_length, radius = rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.4)
        return Capsule(half_length=half_length, radius=radius, position=position, angle=angle)
    corners = np.sort((np.arange(n := rng.integers(3, 9)) + rng.uniform(-0.3, 0.3, n)) * 2 * np.pi / n)
    vertices = np.stack([np.cos(corners), np.sin(corners)], axis=1) * rng.uniform(0.3, 0.8)
    return Polygon(vertices=vertices, position=position, angle=angle)


def test_the_nearest_of_many_shapes_in_two_worlds() -> None:
    rng = np.random.default_rng(5)
    shapes = [random_shape(ShapeKind(k % 4), rng) for k in range(20)]
    scene = Scene()
    for k, shape in enumerate(shapes):
        scene.add_body(f"b{k}", shapes=[shape])
    world = World(scene, world_count=2)
    poses = np.concatenate([rng.uniform(-5, 5, (2, 20, 2)), rng.uniform(-4, 4, (2, 20, 1))], -1)
    for k in range(20):
        world.set_pose(k, position=poses[:, k, :2], angle=poses[:, k, 2])
    origin, direction = rng.uniform(-6, 6, (2, 60, 2)), rng.normal(size=(2, 60, 2))
    length = rng.uniform(1.0, 12.0, (2, 60))
    hits = world.cast_rays(origin, direction, length)
    way = direction / np.hypot(direction[..., 0], direction[..., 1])[..., None]
    found = 0
    for w in range(2):
        heights = [height_of(shape, pose) for shape, pose in zip(shapes, poses[w], strict=True)]
        for r in range(60):
            reach = [entry(height, origin[w, r], way[w, r], length[w, r])[0] for height in heights]
            nearest = int(np.argmin(reach))
            if reach[nearest] == INF:
                assert hits.shape[w, r] == -1
                assert hits.distance[w, r] == length[w, r]
            else:
                found += 1
                assert hits.distance[w, r] == pytest.approx(reach[nearest], abs=1e-7)
                assert reach[hits.shape[w, r]] == pytest.approx(reach[nearest], abs=1e-7)
                assert hits.body[w, r] == hits.shape[w, r]
    assert 40 < found < 110


def hills(closed: bool, count: int, rng: np.random.Generator) -> Array:
    """A chain from left to right, or a star-shaped island, clockwise."""
    if not closed:
        return np.stack([np.linspace(-10, 10, count), np.cumsum(rng.normal(0, 0.4, count))], axis=1)
    turn = -np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([np.cos(turn), np.sin(turn)], axis=1) * rng.uniform(2.0, 6.0, (count, 1))


@pytest.mark.parametrize("count", [2, 4, 5, 9, 40, 200])
@pytest.mark.parametrize("closed", [False, True])
def test_a_terrain_against_linear_solves(closed: bool, count: int) -> None:
    if closed and count == 2:
        count = 3
    rng = np.random.default_rng(count)
    points = hills(closed, count, rng)
    scene = Scene()
    scene.add_body("land", "kinematic", [Terrain(vertices=points, closed=closed, position=(0.5, 1.0), angle=0.2)])
    world = World(scene, world_count=2)
    pose = np.array([(1.0, -2.0, 0.7), (0.0, 3.0, -2.0)])
    world.set_pose("land", position=pose[:, :2], angle=pose[:, 2])
    origin = rng.uniform(-9, 9, (2, 150, 2))
    direction = rng.normal(size=(2, 150, 2))
    hits = world.cast_rays(origin, direction, 15.0)
    way = direction / np.hypot(direction[..., 0], direction[..., 1])[..., None]
    for w in range(2):
        chain = turned(pose[w, 2], turned(0.2, points) + np.array((0.5, 1.0))) + pose[w, :2]
        for r in range(150):
            expected = chain_entry(chain, closed, origin[w, r], way[w, r], 15.0)
            if expected == INF:
                assert hits.shape[w, r] == -1
                assert hits.distance[w, r] == 15.0
            else:
                assert hits.distance[w, r] == pytest.approx(expected, abs=1e-9)
                assert np.dot(hits.normal[w, r], way[w, r]) < 0.0
                np.testing.assert_allclose(np.hypot(*hits.normal[w, r]), 1.0, atol=1e-12)
    assert 20 < hits.hit.sum() < 280


@pytest.mark.parametrize("seed", range(5))
def test_no_ray_slips_through_between_two_edges(seed: int) -> None:
    """Aimed at each vertex of a closed terrain from within a cave."""
    rng = np.random.default_rng(seed)
    turn = np.sort(rng.uniform(0, 2 * np.pi, 50))
    points = 4.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)  # counter-clockwise: solid outside
    world = still(Terrain(vertices=points, closed=True))
    world.set_pose("b0", position=rng.normal(size=2) * 3, angle=rng.uniform(-3, 3))
    corners = turned(float(world.angle[0, 0]), points) + world.position[0, 0]
    origin = world.position[0, 0] + rng.uniform(-1, 1, (500, 2))
    target = corners[rng.integers(0, 50, 500)]
    hits = world.cast_rays(origin, target - origin, 100.0)
    np.testing.assert_allclose(hits.distance[0], np.hypot(*(target - origin).T), atol=1e-12)
    assert hits.hit.all()


@pytest.mark.nojit
def test_a_terrain_is_open_from_behind_but_not_where_the_carrier_has_sunk_in() -> None:
    scene = Scene()
    scene.add_body("land", "static", [Terrain(vertices=[(-9, 0), (0, 0), (9, 0)])])
    scene.add_body("ball", shapes=[Circle(radius=0.2)], position=(5, 5))
    scene.add_body("ghost", "kinematic")
    world = World(scene)
    ways = [(0, 1), (0, -1), (1, 0), (1, 0.1)]

    def seen(depth: float, exclude: str | None) -> list[float]:
        hits = world.cast_rays((1.0, -depth), ways, 3.0, exclude=exclude)
        against = np.array([np.divide(way, -np.hypot(*way)) for way in ways])
        inside = hits.distance[0] == 0.0
        np.testing.assert_allclose(hits.normal[0, inside], against[inside])
        return hits.distance[0].tolist()

    assert seen(1e-9, "ball") == [0.0] * 4
    assert seen(0.19, "ball") == [0.0] * 4
    assert seen(0.21, "ball") == [3.0] * 4
    assert seen(1e-9, None) == [3.0] * 4
    assert seen(1e-9, "ghost") == [3.0] * 4  # without an extent
    assert seen(-0.5, "ball") == [3.0, 0.5, 3.0, 3.0]
    assert first(world.cast_rays((1.0, 0.5), (0, -1), 3.0)) == (0.5, 0, (0.0, 1.0))
    assert first(world.cast_rays((-12.0, -0.1), (0, -1), 3.0, exclude="ball"))[0] == 3.0  # beside its end


def test_rays_along_flat_ground_meet_the_slope() -> None:
    world = still(Terrain(vertices=[(-4, 1), (-2, 0), (-1, 0), (1, 0), (2, 0), (4, 1)]))
    for side in (-1.0, 1.0):
        distance, _, normal = first(world.cast_rays((0.0, 0.0), (side, 0.0), 9.0))
        assert distance == 2.0
        np.testing.assert_allclose(normal, np.array([-side, 2.0]) / np.sqrt(5.0))


# ---------------------------------------------------------------- rims and insides


@pytest.mark.nojit
@pytest.mark.parametrize("name", SHAPES)
def test_a_start_inside_is_at_distance_0(name: str) -> None:
    world = WORLDS[name]
    pose = (1.0, 2.0, 0.3)
    world.set_pose("b0", position=pose[:2], angle=pose[2])
    middle = placed(SHAPES[name], pose, (0.0, 0.0))
    if name == "half-plane":
        middle = np.array([1.0, -4.0])
    for angle in np.linspace(0, 6, 7):
        way = np.array([np.cos(angle), np.sin(angle)])
        hits = world.cast_rays(middle, way, 9.0)
        assert (hits.distance[0, 0], hits.shape[0, 0]) == (0.0, 0)
        np.testing.assert_allclose(hits.normal[0, 0], -way, atol=1e-15)
        np.testing.assert_array_equal(hits.point[0, 0], middle)


# shape, start, direction, expected distance of 9 m
EDGES: dict[str, tuple[Shape, Any, Any, float]] = {
    "touches a circle": (Circle(radius=1), (-3, 1), (1, 0), 9.0),
    "cuts a circle": (Circle(radius=1), (-3, 1 - 1e-9), (1, 0), 3.0),
    "passes a circle": (Circle(radius=1), (-3, 1 + 1e-9), (1, 0), 9.0),
    "circle behind": (Circle(radius=1), (-3, 0), (-1, 0), 9.0),
    "off a circle": (Circle(radius=1), (1, 0), (1, 0), 9.0),
    "onto a circle": (Circle(radius=1), (1, 0), (-1, 0), 0.0),
    "just out of reach": (Circle(radius=1), (-10.001, 0), (1, 0), 9.0),
    "along a box": (Box(half_extents=(1, 1)), (-3, 1), (1, 0), 9.0),
    "just in a box": (Box(half_extents=(1, 1)), (-3, 1 - 1e-9), (1, 0), 2.0),
    "beside a box": (Box(half_extents=(1, 1)), (-3, 1.5), (1, 0), 9.0),
    "box behind": (Box(half_extents=(1, 1)), (-3, 0), (-1, 0), 9.0),
    "from a box's face on": (Box(half_extents=(1, 1)), (0, 1), (0, 1), 9.0),
    "from a box's face in": (Box(half_extents=(1, 1)), (0, 1), (0, -1), 0.0),
    "touches a box's corner": (Box(half_extents=(1, 1)), (0, 2), (1, -1), 9.0),
    "along a capsule": (Capsule(half_length=1, radius=0.5), (-3, 0.5), (1, 0), 9.0),
    "onto a capsule's end": (Capsule(half_length=1, radius=0.5), (-3, 0), (1, 0), 1.5),
    "down on a capsule's seam": (Capsule(half_length=1, radius=0.5), (1, 3), (0, -1), 2.5),
    "just past a capsule's end": (Capsule(half_length=1, radius=0.5), (1.5, 3), (0, -1), 9.0),
    "capsule behind": (Capsule(half_length=1, radius=0.5), (0, 3), (0, 1), 9.0),
    "along a polygon": (Polygon(vertices=[(0, 0), (1, 0), (0, 1)]), (-3, 0), (1, 0), 9.0),
    "just in a polygon": (Polygon(vertices=[(0, 0), (1, 0), (0, 1)]), (-3, 1e-9), (1, 0), 3.0),
    "polygon behind": (Polygon(vertices=[(0, 0), (1, 0), (0, 1)]), (-3, 0.2), (-1, 0), 9.0),
    "along a half-plane": (HalfPlane(), (0, 0), (1, 0), 9.0),
    "off a half-plane": (HalfPlane(), (0, 0), (1, 1), 9.0),
    "from a half-plane in": (HalfPlane(), (0, 0), (0, -1), 0.0),
    "nearly along a half-plane": (HalfPlane(), (0, 1e-9), (1, -1e-9), 1.0),
    "terrain's end": (Terrain(vertices=[(0, 0), (1, 0)]), (1, 2), (0, -1), 2.0),
    "beside a terrain": (Terrain(vertices=[(0, 0), (1, 0)]), (1.001, 2), (0, -1), 9.0),
}


@pytest.mark.nojit
@pytest.mark.parametrize("case", EDGES)
def test_rims(case: str) -> None:
    shape, start, way, expected = EDGES[case]
    distance, found, _ = first(still(shape).cast_rays(start, way, 9.0))
    assert distance == pytest.approx(expected, abs=1e-4 if "cuts" in case else 1e-9)
    assert (found == 0) == (expected < 9.0)


def test_the_end_of_a_ray_counts() -> None:
    world = still(Box(half_extents=(1, 1)))
    assert first(world.cast_rays((-3, 0), (1, 0), 2.0)) == (2.0, 0, (-1.0, 0.0))
    assert first(world.cast_rays((-3, 0), (1, 0), np.nextafter(2.0, 0.0)))[1] == -1


def test_far_away_and_long() -> None:
    scene = Scene()
    scene.add_body("ball", shapes=[Circle(radius=0.5)], position=(1e6, -1e6))
    scene.add_body("land", "static", [Terrain(vertices=[(-1e6, 0), (0, 0), (1e6, 0)])])
    world = World(scene)
    assert first(world.cast_rays((1e6 - 3, -1e6), (1, 0), 1e7))[0] == pytest.approx(2.5, abs=1e-9)
    assert first(world.cast_rays((0, 1e5), (0, -1e300), 1e7))[0] == pytest.approx(1e5, rel=1e-12)
    assert first(world.cast_rays((0, 1e5), (0, -1e-300), 1e7))[0] == pytest.approx(1e5, rel=1e-12)


def test_of_equals_the_first() -> None:
    assert first(still(*[Box(half_extents=(1, 1))] * 3).cast_rays((-3, 0), (1, 0), 9.0))[1] == 0
    assert first(still(*[Box(half_extents=(1, 1))] * 3).cast_rays((0, 0), (1, 0), 9.0))[1] == 0


def test_a_ray_is_what_it_is_alone() -> None:
    """Bit for bit, whatever is cast beside it."""
    rng = np.random.default_rng(3)
    world = still(*SHAPES.values(), Terrain(vertices=hills(False, 30, rng)))
    origin, direction = rng.uniform(-3, 3, (40, 2)), rng.normal(size=(40, 2))
    together = world.cast_rays(origin, direction, 9.0)
    for r in range(40):
        alone = world.cast_rays(origin[r], direction[r], 9.0)
        for name in ("distance", "shape", "normal", "point"):
            assert getattr(alone, name)[0, 0].tobytes() == getattr(together, name)[0, r].tobytes()
