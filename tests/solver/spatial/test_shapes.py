"""Authored spatial shapes: refusals, mass against a fine grid, compiled records."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from gsenv.solver.planar import Circle
from gsenv.solver.records.model import shape_parameter_dtype
from gsenv.solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere
from gsenv.solver.spatial.shapes import (
    bounding_radius,
    mass_properties,
    rotation_matrix,
    shape_record,
    unit_rotation,
    validate,
)

POSITION = np.array([0.7, -0.4, 0.2])
PLACED: dict[str, Any] = {"position": POSITION, "orientation": (0.9, 0.3, -0.4, 0.2)}
CORNERS = np.array([(0.0, 0.0, 0.0), (1.2, 0.0, 0.0), (0.0, 0.9, 0.0), (0.1, 0.1, 0.7), (1.0, 0.6, 0.5)])
SOLID = [
    Sphere(radius=0.7, **PLACED),
    Box(half_extents=(0.5, 0.2, 0.8), **PLACED),
    Capsule(half_length=0.6, radius=0.3, **PLACED),
    Cylinder(half_length=0.4, radius=0.5, **PLACED),
    Hull(vertices=CORNERS, **PLACED),
]
CUBE = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
RING = np.array([(np.cos(t), np.sin(t), z) for t in np.arange(33) * (2 * np.pi / 33) for z in (0.0, 1.0)])


def named(value: Any) -> str:
    return type(value).__name__ if isinstance(value, Shape) else ""


@pytest.mark.parametrize(
    ("shape", "sentence"),
    [
        (Sphere(radius=-1.0), "Sphere radius must be positive, got -1.0"),
        (Sphere(radius=np.nan), "Sphere radius must be positive, got nan"),
        (Sphere(radius="big"), "Sphere radius must be positive, got 'big'"),  # type: ignore[arg-type]
        (Sphere(radius=1.0, friction=-0.1), "Sphere friction must be finite and not negative, got -0.1"),
        (Sphere(radius=1.0, rolling_friction=-1.0), "Sphere rolling_friction must be finite and not negative"),
        (Sphere(radius=1.0, torsional_friction=np.inf), "Sphere torsional_friction must be finite and not negative"),
        (Sphere(radius=1.0, restitution=1.5), "Sphere restitution must not exceed 1, got 1.5"),
        (Sphere(radius=1.0, density=-2.0), "Sphere density must be finite and not negative, got -2.0"),
        (Sphere(radius=1.0, position=(0.0, 1.0)), "Sphere position must be three finite numbers, got (0.0, 1.0)"),
        (Sphere(radius=1.0, orientation=(1.0, 0.0, 0.0)), "Sphere orientation must be four finite numbers"),
        (Sphere(radius=1.0, orientation=(0.0, 0.0, 0.0, 0.0)), "Sphere orientation must not be zero"),
        (Sphere(radius=1.0, category=2**65), "Sphere category must be an integer of 64 bits"),
        (Box(half_extents=(1.0, 0.0, 1.0)), "Box half_extents must be positive, got 0.0"),
        (Box(half_extents=(1.0, 1.0)), "Box half_extents must be three finite numbers, got (1.0, 1.0)"),
        (Box(half_extents=0.5), "Box half_extents must be three finite numbers, got 0.5"),  # type: ignore[arg-type]
        (Box(half_extents="abc"), "Box half_extents must be three finite numbers, got 'abc'"),  # type: ignore[arg-type]
        (Capsule(half_length=0.0, radius=1.0), "Capsule half_length must be positive, got 0.0"),
        (Cylinder(half_length=1.0, radius=-1.0), "Cylinder radius must be positive, got -1.0"),
        (Plane(normal=(0.0, 0.0, 0.0)), "Plane normal must not be zero"),
        (Plane(offset=np.nan), "Plane offset must be finite, got nan"),
        (Hull(vertices=CUBE[:3]), "Hull needs at least 4 vertices, got 3"),
        (Hull(vertices=[0, 1, 2]), "Hull vertices must be triples (x, y, z), got [0, 1, 2]"),
        (Hull(vertices=CUBE[:, :2]), "Hull vertices must be triples"),
        (Hull(vertices=[*CUBE.tolist(), (0, np.nan, 0)]), "Hull vertices must be finite, got (0.0, nan, 0.0)"),
        (Hull(vertices=CUBE[:4]), "Hull vertices must not lie in one plane"),
        (Hull(vertices=[(k, 2 * k, -k) for k in range(6)]), "Hull vertices must not lie on one line"),
        (Hull(vertices=np.ones((5, 3))), "Hull vertices must not all be the same, got 5 at one point"),
        (Hull(vertices=RING), "Hull may have 64 corners at most, got 66 vertices"),
        (Heightfield(heights=[1.0, 2.0], size=(1, 1)), "Heightfield heights must be an array (rows, columns)"),
        (Heightfield(heights=[[1.0, 2.0]], size=(1, 1)), "of at least 2 x 2, got shape (1, 2)"),
        (Heightfield(heights=[[1.0], [2.0, 3.0]], size=(1, 1)), "Heightfield heights must be an array"),
        (Heightfield(heights=np.zeros((2, 2)), size=(1, 0.0)), "Heightfield size must be positive, got 0.0"),
        (Heightfield(heights=np.zeros((2, 2)), size=(1, 1, 1)), "Heightfield size must be two finite numbers"),
        (
            Heightfield(heights=[[0, 0], [np.inf, 0]], size=(1, 1)),
            "Heightfield heights must be finite, got inf at [1, 0]",
        ),
    ],
    ids=named,
)
def test_nonsense_is_refused_with_a_sentence(shape: Shape, sentence: str) -> None:
    with pytest.raises(ValueError, match=re.escape(sentence)) as caught:
        validate(shape)
    assert len(str(caught.value)) < 200


def test_dimensions_do_not_mix() -> None:
    with pytest.raises(ValueError, match="cannot be used in 2D"):
        validate(Sphere(radius=1.0), 2)
    assert not isinstance(Circle(radius=1.0), Shape)


@pytest.mark.parametrize("shape", SOLID, ids=named)
def test_mass_against_a_fine_grid(shape: Shape) -> None:
    """Cells whose middle is inside, counted in the body's frame."""
    n, width = 160, 3.4
    grid = (np.arange(n) + 0.5) / n * width - 0.5 * width
    points = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3) + POSITION
    w, *q = np.array(shape.orientation) / np.linalg.norm(shape.orientation)
    d = points - POSITION
    # inverse rotation, by another formula than the code's
    u, v, h = (d - 2.0 * w * np.cross(q, d) + 2.0 * np.cross(q, np.cross(q, d))).T
    if isinstance(shape, Sphere):
        inside = u**2 + v**2 + h**2 < 0.7**2
    elif isinstance(shape, Box):
        inside = (abs(u) < 0.5) & (abs(v) < 0.2) & (abs(h) < 0.8)
    elif isinstance(shape, Capsule):
        inside = u**2 + v**2 + (h - np.clip(h, -0.6, 0.6)) ** 2 < 0.3**2
    elif isinstance(shape, Cylinder):
        inside = (u**2 + v**2 < 0.5**2) & (abs(h) < 0.4)
    else:
        from scipy.spatial import ConvexHull

        planes = ConvexHull(CORNERS).equations
        inside = (np.stack([u, v, h], axis=-1) @ planes[:, :3].T + planes[:, 3] < 0.0).all(axis=1)
    cell = (width / n) ** 3
    volume, center, inertia = mass_properties(shape)
    assert volume == pytest.approx(inside.sum() * cell, rel=4e-3)
    middle = points[inside].mean(axis=0)
    assert center == pytest.approx(middle, abs=2e-3)
    r = points[inside] - middle
    wanted = ((r**2).sum() * np.eye(3) - r.T @ r) * cell
    assert np.abs(inertia - wanted).max() < 6e-3 * np.abs(wanted).max()


def test_closed_forms() -> None:
    assert mass_properties(Sphere(radius=2.0))[0] == pytest.approx(32 / 3 * np.pi)
    assert mass_properties(Sphere(radius=2.0))[2] == pytest.approx(np.eye(3) * 0.4 * 4 * 32 / 3 * np.pi)
    volume, _, inertia = mass_properties(Box(half_extents=(1.0, 2.0, 3.0)))
    assert volume == pytest.approx(48.0)
    assert inertia == pytest.approx(np.diag([208.0, 160.0, 80.0]))
    volume, _, inertia = mass_properties(Cylinder(half_length=1.5, radius=2.0))
    assert inertia == pytest.approx(np.diag([1.75, 1.75, 2.0]) * volume)  # (3 r^2 + l^2) / 12 and r^2 / 2
    assert mass_properties(Plane())[0] == 0.0


def test_a_short_capsule_is_a_ball_and_a_long_one_a_rod() -> None:
    short = mass_properties(Capsule(half_length=1e-9, radius=0.5))
    ball = mass_properties(Sphere(radius=0.5))
    assert short[0] == pytest.approx(ball[0], rel=1e-7)
    assert short[2] == pytest.approx(ball[2], rel=1e-7)
    volume, _, inertia = mass_properties(Capsule(half_length=100.0, radius=1e-3))
    assert inertia[0, 0] == pytest.approx(volume * 200.0**2 / 12.0, rel=1e-4)


@pytest.mark.parametrize("shape", SOLID, ids=named)
def test_extent_and_radius(shape: Shape) -> None:
    wanted = {Sphere: 0.7, Box: 0.2, Capsule: 0.3, Cylinder: 0.4}
    if type(shape) in wanted:
        assert shape.extent() == wanted[type(shape)]
    far: dict[type, float] = {
        Sphere: 0.7,
        Box: np.sqrt(0.25 + 0.04 + 0.64),
        Capsule: 0.9,
        Cylinder: np.hypot(0.4, 0.5),
        Hull: np.sqrt(1.0 + 0.36 + 0.25),
    }
    assert bounding_radius(shape, POSITION) == pytest.approx(far[type(shape)])


@pytest.mark.parametrize("shape", SOLID, ids=named)
def test_radius_about_another_point(shape: Shape) -> None:
    """Against the farthest of many surface points, found by the support of random directions."""
    rng = np.random.default_rng(1)
    about = np.array([0.1, 0.9, -0.3])
    axes = rotation_matrix(unit_rotation(shape))
    directions = rng.normal(size=(40000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    local = directions @ axes
    if isinstance(shape, Hull):
        points = CORNERS
    elif isinstance(shape, Box):
        points = np.sign(local) * shape.half_extents
    elif isinstance(shape, Cylinder):
        level = local[:, :2] / np.linalg.norm(local[:, :2], axis=1)[:, None]
        points = np.column_stack([0.5 * level, 0.4 * np.sign(local[:, 2])])
    else:
        half = getattr(shape, "half_length", 0.0)
        points = local * shape.radius + np.array([0, 0, half]) * np.sign(local[:, 2:])  # type: ignore[attr-defined]
    distance = np.linalg.norm(points @ axes.T + POSITION - about, axis=1).max()
    assert distance - 1e-12 <= bounding_radius(shape, about) < distance * (1 + 1e-3)


def test_rotation_is_normalised() -> None:
    for rotation in [(2.0, 0.0, 0.0, 0.0), (1e-200, 0.0, 0.0, 0.0)]:
        record = shape_record(Box(half_extents=(1, 1, 1), orientation=rotation), shape_parameter_dtype(3)).record
        assert record["local_rotation"].tolist() == [1.0, 0.0, 0.0, 0.0]
    record = shape_record(
        Box(half_extents=(1, 2, 3), orientation=(3.0, 0.0, 0.0, 4.0)), shape_parameter_dtype(3)
    ).record
    assert record["local_rotation"] == pytest.approx([0.6, 0.0, 0.0, 0.8])
    assert record["size"].tolist() == [1.0, 2.0, 3.0]


def test_axis_of_capsules_and_cylinders_is_z() -> None:
    for shape in (Capsule(half_length=2.0, radius=0.1), Cylinder(half_length=2.0, radius=0.1)):
        record = shape_record(shape, shape_parameter_dtype(3)).record
        assert record["size"].tolist() == [0.0, 0.0, 2.0]
        assert record["radius"] == 0.1
        inertia = mass_properties(shape)[2]
        assert inertia[2, 2] < 0.1 * inertia[0, 0]


@pytest.mark.parametrize(
    "normal", [(3.0, 4.0, 12.0), (0, 0, 1), (0, 0, -1), (1e-9, 0, -1), (1e-160, 0, -1), (-1, 0, 0), (1, -2, -3)]
)
def test_plane_record(normal: Any) -> None:
    """Its z is the normal and its origin lies on the surface, also where the shape itself is placed."""
    plane = Plane(normal=normal, offset=10.0, position=(1.0, 2.0, 3.0), orientation=(0.5, 0.5, 0.5, 0.5))
    record = shape_record(plane, shape_parameter_dtype(3)).record
    length = np.linalg.norm(np.array(normal, float))
    unit = np.array(normal, float) / length
    turned = np.roll(unit, 1)  # that quaternion takes x to y to z to x
    axes = rotation_matrix(tuple(record["local_rotation"].tolist()))
    assert axes[:, 2] == pytest.approx(turned, abs=1e-14)
    assert np.linalg.norm(record["local_rotation"]) == pytest.approx(1.0, abs=1e-15)
    assert (record["local_position"] - (1.0, 2.0, 3.0)) @ turned == pytest.approx(10.0 / length)
    assert record["density"] == 0.0
    assert record["extent"] == np.inf


def test_heightfield_record() -> None:
    heights = np.arange(6.0).reshape(2, 3)
    vertices = shape_record(Heightfield(heights=heights, size=(4.0, 1.0)), shape_parameter_dtype(3)).vertices
    assert (vertices["columns"][0], vertices["rows"][0], vertices["vertex_count"][0]) == (3, 2, 6)
    assert vertices["position"].tolist() == [
        [-2.0, -0.5, 0.0],
        [0.0, -0.5, 1.0],
        [2.0, -0.5, 2.0],
        [-2.0, 0.5, 3.0],
        [0.0, 0.5, 4.0],
        [2.0, 0.5, 5.0],
    ]


@pytest.mark.parametrize("shape", [*SOLID, Plane(), Heightfield(heights=np.zeros((3, 3)), size=(1, 1))], ids=named)
def test_record_holds_the_material(shape: Shape) -> None:
    record = shape_record(shape, shape_parameter_dtype(3)).record
    assert record["friction"] == 0.5
    assert record["enabled"] == 1
    assert record["density"] == (1.0 if shape.solid else 0.0)
    assert np.isfinite(record["local_rotation"]).all()
