"""Rays in random scenes against MuJoCo's mj_ray, which shares no code with gsenv."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import RayHits, Scene, World
from gsenv.solver.records.model import Array
from gsenv.solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere

mujoco = pytest.importorskip("mujoco")


def numbers(values: Any) -> str:
    return " ".join(repr(float(x)) for x in np.ravel(values))


def geom(shape: Shape, k: int) -> tuple[str, str]:
    """(geom, asset) of a shape in MJCF."""
    place = f'name="g{k}" pos="{numbers(shape.position)}" quat="{numbers(shape.orientation)}"'
    if isinstance(shape, Sphere):
        return f'<geom type="sphere" size="{shape.radius!r}" {place}/>', ""
    if isinstance(shape, Box):
        return f'<geom type="box" size="{numbers(shape.half_extents)}" {place}/>', ""
    if isinstance(shape, (Capsule, Cylinder)):
        kind = type(shape).__name__.lower()
        return f'<geom type="{kind}" size="{numbers((shape.radius, shape.half_length))}" {place}/>', ""
    if isinstance(shape, Plane):
        return f'<geom type="plane" size="0 0 1" {place}/>', ""
    assert isinstance(shape, Hull)
    # a convex mesh has the faces of its hull
    asset = f'<mesh name="m{k}" vertex="{numbers(shape.vertices)}" inertia="convex" maxhullvert="64"/>'
    return f'<geom type="mesh" mesh="m{k}" {place}/>', asset


def both(bodies: list[tuple[Array, Array, list[Shape]]]) -> tuple[World, Any, Any]:
    """The same bodies (position, quaternion, shapes) in gsenv and in MuJoCo."""
    scene = Scene(dim=3)
    text, assets, k = "", "", 0
    for b, (position, turn, shapes) in enumerate(bodies):
        scene.add_body(f"b{b}", "kinematic", shapes, position=position, orientation=turn)
        inner = ""
        for shape in shapes:
            one, asset = geom(shape, k)
            inner, assets, k = inner + one, assets + asset, k + 1
        text += f'<body pos="{numbers(position)}" quat="{numbers(turn)}">{inner}</body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><asset>{assets}</asset><worldbody>{text}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return World(scene), model, data


def mj_ray(model: Any, data: Any, origin: Array, way: Array) -> tuple[float, int, Array]:
    """(distance, geom, normal), -1 without a hit."""
    found, normal = np.full((1, 1), -1, np.int32), np.zeros((3, 1))
    distance = mujoco.mj_ray(model, data, origin, way, None, True, -1, found, normal)
    return distance, int(found[0, 0]), normal[:, 0]


def compare(hits: RayHits, model: Any, data: Any, origin: Array, way: Array, length: float, error: float) -> int:
    """Assert equal distances, shapes and normals of rays that start outside all shapes; returns their hits."""
    count = 0
    for r in range(len(origin)):
        if hits.distance[0, r] == 0.0:
            continue  # MuJoCo reports where a ray leaves a solid
        distance, shape, normal = mj_ray(model, data, origin[r], way[r])
        if distance < 0.0 or distance > length:
            assert hits.shape[0, r] == -1
            continue
        count += 1
        slope = max(-float(normal @ way[r]), 1e-3)  # a grazing ray doubles errors of the surface
        assert hits.shape[0, r] == shape
        assert hits.distance[0, r] == pytest.approx(distance, abs=error / slope)
        np.testing.assert_allclose(hits.normal[0, r], normal, atol=10 * error / slope)
    return count


def random_shapes(kinds: tuple[type[Shape], ...], count: int, rng: np.random.Generator) -> list[Shape]:
    shapes: list[Shape] = []
    for k in range(count):
        kind = kinds[k % len(kinds)]
        given: dict[str, Any] = {"position": rng.normal(size=3) * 0.4, "orientation": rng.normal(size=4)}
        size = rng.uniform(0.1, 0.7, 3)
        if kind is Box:
            given["half_extents"] = size
        elif kind is Hull:
            given["vertices"] = rng.normal(size=(12, 3)) * 0.5
        elif kind is not Plane:
            given["radius"] = float(size[0])
            if kind is not Sphere:
                given["half_length"] = float(size[1])
        shapes.append(kind(**given))
    return shapes


def random_bodies(shapes: list[Shape], rng: np.random.Generator) -> list[tuple[Array, Array, list[Shape]]]:
    """Two shapes on each body."""
    pairs = [shapes[k : k + 2] for k in range(0, len(shapes), 2)]
    return [(rng.uniform(-3, 3, 3), rng.normal(size=4), pair) for pair in pairs]


def random_rays(count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    origin = rng.uniform(-6, 6, (count, 3))
    way = rng.uniform(-3, 3, (count, 3)) - origin
    return origin, way / np.linalg.norm(way, axis=1, keepdims=True)


@pytest.mark.parametrize("seed", range(5))
def test_scenes_of_round_and_box_like_shapes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shapes = random_shapes((Sphere, Box, Capsule, Cylinder), 24, rng)
    world, model, data = both(random_bodies(shapes, rng))
    origin, way = random_rays(400, rng)
    hits = world.cast_rays(origin, way, 12.0)
    assert compare(hits, model, data, origin, way, 12.0, 1e-9) > 100


def test_a_scene_with_planes() -> None:
    rng = np.random.default_rng(9)
    shapes: list[Shape] = [*random_shapes((Sphere, Box), 8, rng), Plane(), Plane()]
    bodies = random_bodies(shapes[:8], rng)
    bodies.append((np.array((0, 0, -3.0)), np.array((1, 0.1, -0.2, 0.4)), [shapes[8]]))
    bodies.append((np.array((-4.0, 0, 0)), np.array((1, 0.0, 0.8, 0.1)), [shapes[9]]))
    world, model, data = both(bodies)
    origin, way = random_rays(400, rng)
    hits = world.cast_rays(origin, way, 30.0)
    assert {8, 9} <= set(hits.shape[0].tolist())
    assert compare(hits, model, data, origin, way, 30.0, 1e-9) > 100


@pytest.mark.parametrize("seed", range(3))
def test_hulls(seed: int) -> None:
    """MuJoCo keeps the corners of a mesh as float32."""
    rng = np.random.default_rng(seed)
    world, model, data = both(random_bodies(random_shapes((Hull,), 8, rng), rng))
    origin, way = random_rays(400, rng)
    hits = world.cast_rays(origin, way, 12.0)
    assert compare(hits, model, data, origin, way, 12.0, 1e-6) > 50


@pytest.mark.parametrize("shape", [(6, 9), (25, 14)])
def test_heightfields(shape: tuple[int, int]) -> None:
    """Heights that float32 holds exactly; from above, since MuJoCo's field has walls and a floor."""
    rng = np.random.default_rng(shape[0])
    heights = rng.integers(0, 257, shape) / 256.0
    heights[0, 0], heights[0, 1] = 0.0, 1.0
    turn, place = rng.normal(size=4), rng.normal(size=3)
    scene = Scene(dim=3)
    scene.add_body("land", "kinematic", [Heightfield(heights=heights, size=(4, 6))], position=place, orientation=turn)
    world = World(scene)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><asset><hfield name="h" nrow="{shape[0]}" ncol="{shape[1]}" size="2 3 1 0.5"/></asset><worldbody>'
        f'<geom type="hfield" hfield="h" pos="{numbers(place)}" quat="{numbers(turn)}"/></worldbody></mujoco>'
    )
    model.hfield_data[:] = heights.ravel()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axes = data.geom_xmat[0].reshape(3, 3)
    local = np.concatenate([rng.uniform((-2, -3), (2, 3), (400, 2)), rng.uniform(1.0, 4.0, (400, 1))], 1)
    target = np.concatenate([rng.uniform((-3, -4), (3, 4), (400, 2)), np.zeros((400, 1))], 1)
    origin, aim = local @ axes.T + place, target @ axes.T + place
    way = (aim - origin) / np.linalg.norm(aim - origin, axis=1, keepdims=True)
    hits = world.cast_rays(origin, way, 20.0)
    assert compare(hits, model, data, origin, way, 20.0, 1e-9) > 200
