"""Authored shapes: refusals, mass against sampling, compiled records, derived vertices."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon, Shape, Terrain
from gsenv.solver.planar.shapes import bounding_radius, mass_properties, shape_record, validate
from gsenv.solver.planar.vertices import Turn, derive_vertices, leaf_count, leaf_span, linked_vertices
from gsenv.solver.records.model import shape_model_dtype, shape_parameter_dtype

TRIANGLE = [(0.0, 0.0), (2.0, 0.0), (0.5, 1.0)]
PLACED: dict[str, Any] = {"position": (0.7, -0.4), "angle": 0.6}
SOLID = [
    Circle(radius=0.7, **PLACED),
    Box(half_extents=(0.5, 0.2), **PLACED),
    Capsule(half_length=0.6, radius=0.3, **PLACED),
    Polygon(vertices=TRIANGLE, **PLACED),
]


@pytest.mark.parametrize(
    ("shape", "sentence"),
    [
        (Circle(radius=-1.0), "Circle radius must be positive, got -1.0"),
        (Circle(radius=0.0), "Circle radius must be positive, got 0.0"),
        (Circle(radius=np.nan), "Circle radius must be positive, got nan"),
        (Circle(radius=np.inf), "Circle radius must be positive, got inf"),
        (Circle(radius=1.0, friction=-0.1), "Circle friction must be finite and not negative, got -0.1"),
        (Circle(radius=1.0, restitution=np.nan), "Circle restitution must be finite and not negative, got nan"),
        (Circle(radius=1.0, density=-2.0), "Circle density must be finite and not negative, got -2.0"),
        (Circle(radius=1.0, position=(0.0, np.nan)), "Circle position must be two finite numbers"),
        (Circle(radius=1.0, angle=np.inf), "Circle angle must be finite, got inf"),
        (Circle(radius=1.0, category=2**65), "Circle category must be an integer of 64 bits"),
        (Box(half_extents=(1.0, 0.0)), "Box half_extents must be positive, got 0.0"),
        (Box(half_extents=(1.0, 1.0, 1.0)), "Box half_extents must be two finite numbers"),
        (Capsule(half_length=0.0, radius=1.0), "Capsule half_length must be positive, got 0.0"),
        (Capsule(half_length=1.0, radius=-1.0), "Capsule radius must be positive, got -1.0"),
        (HalfPlane(normal=(0.0, 0.0)), "HalfPlane normal must not be zero"),
        (HalfPlane(offset=np.nan), "HalfPlane offset must be finite, got nan"),
        (Polygon(vertices=[(0, 0), (1, 0)]), "Polygon needs at least 3 vertices, got 2"),
        (Polygon(vertices=[(0, 0), (1, 0), (2, 0)]), "Polygon must have no three vertices in line"),
        (Polygon(vertices=[(0, 0), (1, 0), (1, 0), (0, 1)]), "Polygon vertices must differ, got (1.0, 0.0) twice"),
        (Polygon(vertices=[(0, 0), (2, 0), (1, 0.2), (1, 2)]), "Polygon must be convex, got a turn back at (1.0, 0.2)"),
        (Polygon(vertices=[(0, 0), (1, 1), (1, 0), (0, 1)]), "Polygon must be convex"),
        (
            Polygon(vertices=[(np.cos(t), np.sin(t)) for t in np.arange(5) * 4 * np.pi / 5]),
            "Polygon must be convex",
        ),
        (Polygon(vertices=[(0, 0), (1, np.nan), (0, 1)]), "Polygon vertices must be finite"),
        (Polygon(vertices=[0, 1, 2]), "Polygon vertices must be pairs"),
        (Terrain(vertices=[(0, 0)]), "Terrain needs at least 2 vertices, got 1"),
        (Terrain(vertices=[(0, 0), (0, 0)]), "Terrain neighbours must differ, got (0.0, 0.0) twice in a row"),
        (Terrain(vertices=[(0, 0), (1, 0), (0, 0)], closed=True), "Terrain neighbours must differ"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Shape) else "",
)
def test_nonsense_is_refused_with_a_sentence(shape: Shape, sentence: str) -> None:
    with pytest.raises(ValueError, match=re.escape(sentence)):
        validate(shape)


def test_winding_is_free() -> None:
    for vertices in (TRIANGLE, TRIANGLE[::-1]):
        compiled = shape_record(Polygon(vertices=vertices), shape_parameter_dtype(2))
        p = compiled.vertices["position"]
        assert np.cross(np.append(p[1] - p[0], 0), np.append(p[2] - p[0], 0))[2] > 0
        middle = p.mean(axis=0)
        assert (((p - middle) * compiled.vertices["normal"]).sum(axis=1) > 0).all()
        assert (compiled.vertices["turn"] == Turn.CONVEX).all()


@pytest.mark.parametrize("shape", SOLID, ids=lambda s: type(s).__name__)
def test_mass_against_a_fine_grid(shape: Shape) -> None:
    n = 1500
    grid = (np.arange(n) + 0.5) / n * 5.0 - 2.5
    x, y = (v.ravel() for v in np.meshgrid(grid + 0.7, grid - 0.4))
    c, s = np.cos(shape.angle), np.sin(shape.angle)
    u, v = x - 0.7, y + 0.4
    u, v = c * u + s * v, c * v - s * u
    if isinstance(shape, Circle):
        inside = u**2 + v**2 < shape.radius**2
    elif isinstance(shape, Box):
        inside = (abs(u) < 0.5) & (abs(v) < 0.2)
    elif isinstance(shape, Capsule):
        inside = (u - np.clip(u, -0.6, 0.6)) ** 2 + v**2 < 0.3**2
    else:
        inside = (v > 0) & (v < 2.0 * u) & (v < (2.0 - u) / 1.5)
    cell = (5.0 / n) ** 2
    area, (cx, cy), inertia = mass_properties(shape)
    assert area == pytest.approx(inside.sum() * cell, rel=2e-3)
    assert (cx, cy) == pytest.approx((x[inside].mean(), y[inside].mean()), abs=2e-3)
    assert inertia == pytest.approx((((x - cx) ** 2 + (y - cy) ** 2)[inside]).sum() * cell, rel=4e-3)


@pytest.mark.parametrize("shape", SOLID, ids=lambda s: type(s).__name__)
def test_extent_and_radius(shape: Shape) -> None:
    wanted = {Circle: 0.7, Box: 0.2, Capsule: 0.3}
    if type(shape) in wanted:
        assert shape.extent() == wanted[type(shape)]
    else:  # the narrowest strip lies along the longest side
        assert shape.extent() == pytest.approx(0.5)
    far = {Circle: 0.7, Box: np.hypot(0.5, 0.2), Capsule: 0.9, Polygon: 2.0}[type(shape)]
    assert bounding_radius(shape, shape.position) == pytest.approx(far)


def test_a_far_polygon_keeps_its_inertia() -> None:
    near = mass_properties(Polygon(vertices=TRIANGLE))
    far = mass_properties(Polygon(vertices=np.array(TRIANGLE) + 1e6))
    assert far[0] == pytest.approx(near[0], rel=1e-9)
    assert far[2] == pytest.approx(near[2], rel=1e-6)


def test_half_plane_record() -> None:
    plane = HalfPlane(normal=(3.0, 4.0), offset=10.0)
    record = shape_record(plane, shape_parameter_dtype(2)).record
    c, s = record["local_rotation"]
    assert (-s, c) == pytest.approx((0.6, 0.8))
    assert record["local_position"] @ (0.6, 0.8) == pytest.approx(2.0)
    assert record["density"] == 0.0


def test_terrain_is_solid_on_the_right() -> None:
    points = np.array([(-1.0, 0.0), (0.0, 0.0), (1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (4.0, 0.0)])
    vertices = shape_record(Terrain(vertices=points), shape_parameter_dtype(2)).vertices
    assert (vertices["normal"][:-1, 1] > 0.0).all()
    assert vertices["turn"].tolist() == [-1, Turn.CONCAVE, Turn.CONVEX, Turn.FLAT, Turn.CONVEX, -1]
    assert vertices["run"].tolist()[:5] == [0, 1, 2, 2, 4]
    assert (vertices["previous"][0], vertices["next"][-1]) == (-1, -1)


def test_derived_data_follow_the_vertices() -> None:
    """Randomised vertices of one world: the same as compiled from scratch."""
    rng = np.random.default_rng(1)
    models = np.zeros(2, shape_model_dtype())
    models["vertex_first"], models["vertex_count"] = [0, 20], [20, 3]
    points = np.stack([np.arange(20.0), rng.normal(size=20)], axis=1)
    world = np.concatenate(
        [
            linked_vertices(np.zeros((20, 2)) + np.arange(20)[:, None], False, -1.0),
            linked_vertices(np.array(TRIANGLE), True, 1.0),
        ]
    )
    world["position"][:20] = points
    derive_vertices(models, world)
    assert (world[:20] == linked_vertices(points, False, -1.0)).all()


def test_tree_finds_every_edge() -> None:
    rng = np.random.default_rng(2)
    for count in (2, 3, 4, 5, 9, 17, 100):
        points = rng.normal(size=(count, 2)).cumsum(axis=0)
        for closed in (False, True) if count > 2 else (False,):
            vertices = linked_vertices(points, closed, -1.0)
            leaves = leaf_count(count)
            ends = np.roll(points, -1, axis=0)
            for _ in range(20):
                low = rng.normal(size=2) * np.sqrt(count)
                high = low + rng.uniform(0, 2, 2)
                start, stop = leaf_span(vertices, 0, leaves, *low, *high)
                found = range(4 * start, 4 * stop)
                for i in range(count if closed else count - 1):
                    box_low, box_high = np.minimum(points[i], ends[i]), np.maximum(points[i], ends[i])
                    if (box_low <= high).all() and (box_high >= low).all():
                        assert i in found
