"""Rays against every shape in space: convex functions and linear solves as oracles; rims and insides."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from gsenv.solver import RayHits, Scene, World
from gsenv.solver.records.model import Array
from gsenv.solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere

INF = float("inf")
Height = Callable[[Array], Any]  # of a point: negative inside, convex

WEDGE = [(-0.3, -0.4, -0.2), (0.8, -0.2, 0.0), (0.6, 0.5, -0.3), (-0.1, 0.7, 0.1), (0.2, 0.1, 0.9)]
TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TURN = (0.8, 0.1, -0.5, 0.3)
SHAPES: dict[str, Shape] = {
    "sphere": Sphere(radius=0.6, position=(0.2, -0.1, 0.3)),
    "box": Box(half_extents=(0.8, 0.3, 0.5), position=(0.1, 0.2, -0.1), orientation=TURN),
    "capsule": Capsule(half_length=0.7, radius=0.25, orientation=(0.3, 1, 0, 0.2)),
    "cylinder": Cylinder(half_length=0.4, radius=0.5, position=(0, 0.1, 0), orientation=(1, -0.7, 0.2, 0)),
    "hull": Hull(vertices=WEDGE, position=(-0.2, 0.1, 0.1), orientation=TURN),
    "plane": Plane(normal=(0.3, 0.2, 1.0), offset=-0.2),
}


# ---------------------------------------------------------------- the oracles


def rotation(quaternion: Any) -> Rotation:
    w, x, y, z = quaternion
    return Rotation.from_quat((x, y, z, w))


def placed(shape: Shape, pose: Any, points: Any) -> Array:
    """Points of a shape's frame in the world; pose: position and quaternion of the body."""
    local = rotation(shape.orientation).apply(np.asarray(points, float)) + np.asarray(shape.position)
    return np.asarray(rotation(pose[3:]).apply(local) + np.asarray(pose[:3]))


def height_of(shape: Shape, pose: Any) -> Height:
    """A convex function that is negative inside of a shape."""
    origin, *axes = placed(shape, pose, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    turn = np.array(axes) - origin
    if isinstance(shape, Plane):
        up = np.asarray(shape.normal) / np.linalg.norm(shape.normal)
        foot, tip = placed(shape, pose, [up * shape.offset / np.linalg.norm(shape.normal), up * 9])
        direction = (tip - origin) / 9
        return lambda p: (p - foot) @ direction
    if isinstance(shape, Hull):
        faces = ConvexHull(shape.vertices).equations
        return lambda p: (faces[:, :3] @ (turn @ (p - origin)) + faces[:, 3]).max()

    def own_height(p: Array) -> Any:
        x, y, z = turn @ (p - origin)
        if isinstance(shape, Sphere):
            return np.sqrt(x * x + y * y + z * z) - shape.radius
        if isinstance(shape, Box):
            return max(abs(x) - shape.half_extents[0], abs(y) - shape.half_extents[1], abs(z) - shape.half_extents[2])
        assert isinstance(shape, (Capsule, Cylinder))
        beyond = max(abs(z) - shape.half_length, 0.0)
        if isinstance(shape, Capsule):
            return np.sqrt(x * x + y * y + beyond * beyond) - shape.radius
        return max(np.hypot(x, y) - shape.radius, abs(z) - shape.half_length)

    return own_height


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


def field_entry(samples: Array, origin: Array, way: Array, length: float) -> float:
    """Nearest crossing of a field's triangles from above: three linear equations for each."""
    rows, columns = samples.shape[:2]
    best = INF
    for r in range(rows - 1):
        for c in range(columns - 1):
            a, b, d, e = samples[r, c], samples[r, c + 1], samples[r + 1, c + 1], samples[r + 1, c]
            for p, q, s in ((a, b, d), (a, d, e)):
                normal = np.cross(q - p, s - p)
                if way @ normal < 0.0:
                    t, u, v = np.linalg.solve(np.stack([way, p - q, p - s], axis=1), p - origin)
                    if 0.0 <= t <= length and u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                        best = min(best, float(t))
    return best


# ---------------------------------------------------------------- scenes


def still(*shapes: Shape) -> World:
    """One kinematic body at the origin for each shape."""
    scene = Scene(dim=3)
    for k, shape in enumerate(shapes):
        scene.add_body(f"b{k}", "kinematic", [shape])
    return World(scene)


def first(hits: RayHits) -> tuple[float, int, tuple[float, float, float]]:
    """Of the only ray: distance, shape, normal."""
    assert hits.distance.shape == (1, 1)
    x, y, z = hits.normal[0, 0]
    return float(hits.distance[0, 0]), int(hits.shape[0, 0]), (float(x), float(y), float(z))


def hills(rows: int, columns: int, seed: int = 0, rough: float = 0.4) -> Array:
    return np.random.default_rng(seed).uniform(0.0, rough, (rows, columns))


def samples_of(field: Heightfield) -> Array:
    heights, (width, depth) = np.asarray(field.heights), field.size
    y, x = np.meshgrid(*(np.linspace(-0.5, 0.5, n) for n in heights.shape), indexing="ij")
    return np.stack([x * width, y * depth, heights], -1)


WORLDS = {name: still(shape) for name, shape in SHAPES.items()}
coordinate = st.floats(-3.0, 3.0)
points = st.tuples(coordinate, coordinate, coordinate)
ways = points.filter(lambda v: max(map(abs, v)) > 1e-3)
turns = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: max(map(abs, q)) > 1e-3)


@pytest.mark.parametrize("name", SHAPES)
@settings(max_examples=100)
@given(place=points, turn=turns, start=points, direction=ways, aimed=st.booleans(), length=st.floats(0.1, 9.0))
def test_each_shape_against_its_height(
    name: str, place: Any, turn: Any, start: Any, direction: Any, aimed: bool, length: float
) -> None:
    world, pose = WORLDS[name], (*place, *turn)
    height = height_of(SHAPES[name], pose)
    world.set_pose("b0", position=place, orientation=turn)
    origin = np.array(start)
    if aimed and not np.allclose(place, start):
        direction = np.array(place) - origin
    way = np.asarray(direction) / np.linalg.norm(direction)
    expected, depth = entry(height, origin, way, length)
    hits = world.cast_rays(origin, 7.0 * way, length)
    distance, shape, normal = first(hits)
    if abs(depth) < 1e-9 or abs(height(origin)) < 1e-9 or abs(height(origin + length * way)) < 1e-9:
        return  # touching, by rounding
    if expected == INF:
        assert (distance, shape, normal) == (length, -1, (0.0, 0.0, 0.0))
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
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    # a step out along the normal is as high as it is long
    out = height(hits.point[0, 0] + 1e-5 * np.array(normal))
    assert out == pytest.approx(1e-5, rel=1e-4)
    assert np.dot(normal, way) < 0.0


def random_shape(k: int, rng: np.random.Generator) -> Shape:
    place: dict[str, Any] = {"position": rng.normal(size=3) * 0.3, "orientation": rng.normal(size=4)}
    size = rng.uniform(0.1, 0.7, 3)
    made: tuple[Shape, ...] = (
        Sphere(radius=size[0], **place),
        Box(half_extents=size, **place),
        Capsule(half_length=size[0], radius=size[1], **place),
        Cylinder(half_length=size[0], radius=size[1], **place),
        Hull(vertices=rng.normal(size=(9, 3)) * 0.5, **place),
    )
    return made[k % len(made)]


def test_the_nearest_of_many_shapes_in_two_worlds() -> None:
    rng = np.random.default_rng(5)
    shapes = [random_shape(k, rng) for k in range(30)]
    scene = Scene(dim=3)
    for k in range(15):  # two shapes on each body
        scene.add_body(f"b{k}", "kinematic", shapes=shapes[2 * k : 2 * k + 2])
    world = World(scene, world_count=2, threads=2)
    poses = np.concatenate([rng.uniform(-3, 3, (2, 15, 3)), rng.normal(size=(2, 15, 4))], -1)
    for k in range(15):
        world.set_pose(k, position=poses[:, k, :3], orientation=poses[:, k, 3:])
    origin = rng.uniform(-4, 4, (2, 60, 3))
    direction = rng.uniform(-2, 2, (2, 60, 3)) - origin
    length = rng.uniform(1.0, 12.0, (2, 60))
    hits = world.cast_rays(origin, direction, length)
    way = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    found = 0
    for w in range(2):
        heights = [height_of(shape, poses[w, k // 2]) for k, shape in enumerate(shapes)]
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
                assert hits.body[w, r] == hits.shape[w, r] // 2
    assert 30 < found < 110


# ---------------------------------------------------------------- heightfields


@pytest.mark.parametrize(("rows", "columns"), [(2, 2), (2, 9), (9, 2), (7, 5), (20, 30)])
def test_a_heightfield_against_linear_solves(rows: int, columns: int) -> None:
    rng = np.random.default_rng(rows * columns)
    field = Heightfield(heights=hills(rows, columns, 1, 1.5), size=(7.0, 4.0), position=(0.5, 1.0, 0.2),
                        orientation=(1, 0.1, -0.2, 0.3))  # fmt: skip
    scene = Scene(dim=3)
    scene.add_body("land", "kinematic", [field])
    world = World(scene, world_count=2)
    poses = np.concatenate([rng.uniform(-2, 2, (2, 3)), rng.normal(size=(2, 4))], -1)
    world.set_pose("land", position=poses[:, :3], orientation=poses[:, 3:])
    count = 60 if rows * columns > 100 else 150
    found = 0
    for w in range(2):
        samples = placed(field, poses[w], samples_of(field).reshape(-1, 3)).reshape(rows, columns, 3)
        middle = samples.reshape(-1, 3).mean(0)
        origin = middle + rng.uniform(-4, 4, (count, 3))
        target = samples.reshape(-1, 3)[rng.integers(0, rows * columns, count)] + rng.normal(size=(count, 3))
        way = (target - origin) / np.linalg.norm(target - origin, axis=1, keepdims=True)
        hits = world.cast_rays(origin, way, 9.0, worlds=w)
        for r in range(count):
            expected = field_entry(samples, origin[r], way[r], 9.0)
            if expected == INF:
                assert hits.shape[0, r] == -1
                assert hits.distance[0, r] == 9.0
            else:
                found += 1
                assert hits.distance[0, r] == pytest.approx(expected, abs=1e-9)
                assert np.dot(hits.normal[0, r], way[r]) < 0.0
                assert np.linalg.norm(hits.normal[0, r]) == pytest.approx(1.0, abs=1e-12)
    assert 0.1 * count < found < 1.8 * count


def test_normals_of_a_heightfield_are_those_of_its_triangles() -> None:
    world = still(Heightfield(heights=[[0, 0], [0, 1]], size=(2, 2)))
    hits = world.cast_rays([(0.5, -0.5, 5), (-0.5, 0.5, 5)], (0, 0, -1), 9.0)
    np.testing.assert_allclose(hits.normal[0], np.array([(0, -1, 2), (-1, 0, 2)]) / np.sqrt(5.0), atol=1e-15)
    np.testing.assert_allclose(hits.distance[0], [4.75, 4.75], atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_no_ray_slips_through_between_two_triangles(seed: int) -> None:
    """Aimed at samples and at points of edges, from far and near, along the grid's lines and across them."""
    rng = np.random.default_rng(seed)
    field = Heightfield(heights=hills(12, 9, seed, 0.1), size=(3.0, 4.0))
    world = still(field)
    pose = np.array([*rng.normal(size=3), *(rng.normal(size=4) if seed else (1, 0, 0, 0))])
    world.set_pose("b0", position=pose[:3], orientation=pose[3:])
    samples = samples_of(field)
    one, other = samples[1:-2, 1:-2], (samples[1:-2, 2:-1], samples[2:-1, 1:-2], samples[2:-1, 2:-1])[seed % 3]
    share = rng.choice([0.0, 0.3, 0.5], (*one.shape[:2], 1))
    target = (one + share * (other - one)).reshape(-1, 3)
    for far in (1.0, 30.0, 1e3):
        up = rng.normal(size=(len(target), 3)) * 0.2 + (0, 0, 1)
        if far == 1.0:
            up[:, :2] = 0.0
        origin = placed(field, pose, target + far * up)
        aim = placed(field, pose, target)
        hits = world.cast_rays(origin, aim - origin, 2 * far)
        np.testing.assert_allclose(hits.distance[0], np.linalg.norm(aim - origin, axis=1), atol=1e-9 + 1e-12 * far)
        assert hits.hit.all()


@pytest.mark.nojit
def test_a_heightfield_is_open_from_below_but_not_where_the_carrier_has_sunk_in() -> None:
    scene = Scene(dim=3)
    scene.add_body("land", "static", [Heightfield(heights=np.zeros((3, 5)), size=(8, 8))])
    scene.add_body("ball", shapes=[Sphere(radius=0.2)], position=(5, 5, 5))
    scene.add_body("ghost", "kinematic")
    world = World(scene)
    ways = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0.1)]

    def seen(depth: float, exclude: str | None) -> list[float]:
        hits = world.cast_rays((1.0, 0.3, -depth), ways, 3.0, exclude=exclude)
        against = np.array([np.divide(way, -np.linalg.norm(way)) for way in ways])
        inside = hits.distance[0] == 0.0
        np.testing.assert_allclose(hits.normal[0, inside], against[inside])
        return hits.distance[0].tolist()

    assert seen(1e-9, "ball") == [0.0] * 4
    assert seen(0.19, "ball") == [0.0] * 4
    assert seen(0.21, "ball") == [3.0] * 4
    assert seen(1e-9, None) == [3.0] * 4
    assert seen(1e-9, "ghost") == [3.0] * 4  # without an extent
    np.testing.assert_allclose(seen(-0.5, "ball"), [3.0, 0.5, 3.0, 3.0])
    assert first(world.cast_rays((-5.0, 0, -0.1), (0, 0, -1), 3.0, exclude="ball"))[0] == 3.0  # beside it


def test_below_a_steep_slope_the_nearest_point_counts() -> None:
    scene = Scene(dim=3)
    scene.add_body("land", "static", [Heightfield(heights=[[0, 9], [0, 9]], size=(3, 3))])  # z = 3 x + 4.5
    scene.add_body("ball", shapes=[Sphere(radius=0.2)], position=(5, 5, 5))
    world = World(scene)
    for depth, inside in ((0.19, True), (0.21, False)):  # from the surface; 3.16 times that below it
        below = np.array((0, 0, 4.5)) - depth * np.array((-3, 0, 1)) / np.sqrt(10)
        distance, shape, _ = first(world.cast_rays(below, (1, 0, 0), 0.5, exclude="ball"))
        assert (distance, shape) == ((0.0, 0) if inside else (0.5, -1))


def test_rays_along_flat_ground_meet_the_slope() -> None:
    world = still(Heightfield(heights=np.tile([1, 0, 0, 0, 0, 0, 1], (4, 1)), size=(6, 6)))
    for side in (-1.0, 1.0):
        distance, _, normal = first(world.cast_rays((0.0, 0.3, 0.0), (side, 0.0, 0.0), 9.0))
        assert distance == pytest.approx(2.0, abs=1e-9)
        np.testing.assert_allclose(normal, np.array([-side, 0.0, 1.0]) / np.sqrt(2.0))


# ---------------------------------------------------------------- rims and insides


@pytest.mark.nojit
@pytest.mark.parametrize("name", SHAPES)
def test_a_start_inside_is_at_distance_0(name: str) -> None:
    world = WORLDS[name]
    pose = (1.0, 2.0, 0.5, *TURN)
    world.set_pose("b0", position=pose[:3], orientation=pose[3:])
    middle = placed(SHAPES[name], pose, (0.1, 0.1, -4.0 if name == "plane" else 0.1))
    for way in (*np.eye(3), *-np.eye(3), (1, 1, 1), (-1, 2, 0.3)):
        hits = world.cast_rays(middle, way, 9.0)
        assert (hits.distance[0, 0], hits.shape[0, 0]) == (0.0, 0)
        np.testing.assert_allclose(hits.normal[0, 0], -np.asarray(way) / np.linalg.norm(way), atol=1e-15)
        np.testing.assert_array_equal(hits.point[0, 0], middle)


BOX, CAPSULE, CYLINDER = (
    Box(half_extents=(1, 1, 1)), Capsule(half_length=1, radius=0.5), Cylinder(half_length=1, radius=0.5)
)  # fmt: skip
# shape, start, direction, expected distance of 9 m
EDGES: dict[str, tuple[Shape, Any, Any, float]] = {
    "touches a sphere": (Sphere(radius=1), (-3, 0, 1), (1, 0, 0), 9.0),
    "cuts a sphere": (Sphere(radius=1), (-3, 1 - 1e-9, 0), (1, 0, 0), 3.0),
    "passes a sphere": (Sphere(radius=1), (-3, 1 + 1e-9, 0), (1, 0, 0), 9.0),
    "sphere behind": (Sphere(radius=1), (-3, 0, 0), (-1, 0, 0), 9.0),
    "off a sphere": (Sphere(radius=1), (1, 0, 0), (1, 0, 0), 9.0),
    "onto a sphere": (Sphere(radius=1), (1, 0, 0), (-1, 0, 0), 0.0),
    "just out of reach": (Sphere(radius=1), (-10.001, 0, 0), (1, 0, 0), 9.0),
    "along a box": (BOX, (-3, 1, 0), (1, 0, 0), 9.0),
    "along a box's edge": (BOX, (-3, 1, 1), (1, 0, 0), 9.0),
    "just in a box": (BOX, (-3, 1 - 1e-9, 0), (1, 0, 0), 2.0),
    "beside a box": (BOX, (-3, 0, 1.5), (1, 0, 0), 9.0),
    "box behind": (BOX, (-3, 0, 0), (-1, 0, 0), 9.0),
    "from a box's face on": (BOX, (0, 0, 1), (0, 0, 1), 9.0),
    "from a box's face in": (BOX, (0, 0, 1), (0, 0, -1), 0.0),
    "on a box's face along it": (BOX, (0, 0, 1), (1, 0, 0), 9.0),
    "touches a box's edge": (BOX, (0, 2, 0), (1, -1, 0), 9.0),
    "touches a box's corner": (BOX, (1, 2, 0), (0, -1, 1), 9.0),
    "along a capsule": (CAPSULE, (0.5, 0, -3), (0, 0, 1), 9.0),
    "within a capsule's tube": (CAPSULE, (0.3, 0, -3), (0, 0, 1), 1.6),
    "onto a capsule's end": (CAPSULE, (0, 0, -3), (0, 0, 1), 1.5),
    "down on a capsule's seam": (CAPSULE, (3, 0, 1), (-1, 0, 0), 2.5),
    "just past a capsule's end": (CAPSULE, (3, 0, 1.5), (-1, 0, 0), 9.0),
    "capsule behind": (CAPSULE, (3, 0, 0), (1, 0, 0), 9.0),
    "nearly along a capsule": (CAPSULE, (0.5, 0, -3), (-1e-9, 0, 1), 2.0 - np.sqrt(2e-9)),
    "along a cylinder": (CYLINDER, (0, 0.5, -3), (0, 0, 1), 9.0),
    "within a cylinder's tube": (CYLINDER, (0.4, 0, -3), (0, 0, 1), 2.0),
    "across a cylinder's end": (CYLINDER, (-3, 0, 1), (1, 0, 0), 9.0),
    "just in a cylinder's end": (CYLINDER, (-3, 0, 1 - 1e-9), (1, 0, 0), 2.5),
    "past a cylinder's rim": (CYLINDER, (0.5 + 1e-9, 0, 3), (0, 0, -1), 9.0),
    "above a cylinder": (CYLINDER, (0, 0, 1.2), (1, 0, 0.001), 9.0),
    "cylinder behind": (CYLINDER, (0, 0, 3), (0, 0, 1), 9.0),
    "along a hull": (Hull(vertices=TETRAHEDRON), (-3, 0.2, 0), (1, 0, 0), 9.0),
    "just in a hull": (Hull(vertices=TETRAHEDRON), (-3, 0.2, 1e-9), (1, 0, 0), 3.0),
    "hull behind": (Hull(vertices=TETRAHEDRON), (-3, 0.2, 0.2), (-1, 0, 0), 9.0),
    "along a plane": (Plane(), (0, 0, 0), (1, 0, 0), 9.0),
    "off a plane": (Plane(), (0, 0, 0), (1, 1, 1), 9.0),
    "from a plane in": (Plane(), (0, 0, 0), (0, 0, -1), 0.0),
    "nearly along a plane": (Plane(), (0, 0, 1e-9), (1, 0, -1e-9), 1.0),
    "a field's corner": (Heightfield(heights=np.zeros((2, 2)), size=(2, 2)), (1, 1, 2), (0, 0, -1), 2.0),
    "a field's diagonal": (Heightfield(heights=np.zeros((3, 3)), size=(2, 2)), (0, 0, 2), (0, 0, -1), 2.0),
    "beside a field": (Heightfield(heights=np.zeros((2, 2)), size=(2, 2)), (1.001, 0, 2), (0, 0, -1), 9.0),
    "along a field": (Heightfield(heights=np.zeros((2, 2)), size=(2, 2)), (-3, 0, 0), (1, 0, 0), 9.0),
    "above a field": (Heightfield(heights=np.zeros((2, 2)), size=(2, 2)), (0, 0, 1), (0, 0, 1), 9.0),
}


@pytest.mark.nojit
@pytest.mark.parametrize("case", EDGES)
def test_rims(case: str) -> None:
    shape, start, way, expected = EDGES[case]
    distance, found, _ = first(still(shape).cast_rays(start, way, 9.0))
    assert distance == pytest.approx(expected, abs=1e-4 if "cuts" in case else 1e-8)
    assert (found == 0) == (expected < 9.0)


def test_the_end_of_a_ray_counts() -> None:
    world = still(BOX)
    assert first(world.cast_rays((-3, 0, 0), (1, 0, 0), 2.0)) == (2.0, 0, (-1.0, 0.0, 0.0))
    assert first(world.cast_rays((-3, 0, 0), (1, 0, 0), np.nextafter(2.0, 0.0)))[1] == -1


def test_far_away_and_long() -> None:
    scene = Scene(dim=3)
    scene.add_body("ball", shapes=[Sphere(radius=0.5)], position=(1e6, -1e6, 1e6))
    scene.add_body("land", "static", [Heightfield(heights=np.zeros((9, 9)), size=(1e6, 1e6))])
    world = World(scene)
    assert first(world.cast_rays((1e6 - 3, -1e6, 1e6), (1, 0, 0), 1e7))[0] == pytest.approx(2.5, abs=1e-9)
    for size in (1e300, 1e-300):
        assert first(world.cast_rays((3, 2, 1e5), (0, 0, -size), 1e7))[0] == pytest.approx(1e5, rel=1e-12)


def test_of_equals_the_first() -> None:
    assert first(still(*[BOX] * 3).cast_rays((-3, 0, 0), (1, 0, 0), 9.0))[1] == 0
    assert first(still(*[BOX] * 3).cast_rays((0, 0, 0), (1, 0, 0), 9.0))[1] == 0


def test_a_ray_is_what_it_is_alone() -> None:
    """Bit for bit, whatever is cast beside it."""
    rng = np.random.default_rng(3)
    world = still(*(SHAPES[name] for name in SHAPES if name != "plane"), Heightfield(heights=hills(9, 9), size=(6, 6)))
    origin = rng.uniform(-3, 3, (40, 3))
    direction = rng.uniform(-1, 1, (40, 3)) - origin
    together = world.cast_rays(origin, direction, 9.0)
    assert 10 < together.hit.sum()
    for r in range(40):
        alone = world.cast_rays(origin[r], direction[r], 9.0)
        for name in ("distance", "shape", "normal", "point"):
            assert getattr(alone, name)[0, 0].tobytes() == getattr(together, name)[0, r].tobytes()
