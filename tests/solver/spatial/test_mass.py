"""Principal axes, masses of several shapes together, and sizes that differ from world to world."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gsenv.solver.core.edit import fit_solids
from gsenv.solver.records.model import (
    body_model_dtype,
    body_parameter_dtype,
    shape_model_dtype,
    shape_parameter_dtype,
)
from gsenv.solver.records.plain import as_records
from gsenv.solver.spatial import Box, Capsule, Cylinder, Hull, Shape, Sphere
from gsenv.solver.spatial.mass import principal_axes
from gsenv.solver.spatial.shapes import bounding_radius, mass_properties, rotation_matrix, shape_record
from gsenv.solver.specification.solids import solid_mass, solids

ROTATION = (0.9, 0.3, -0.4, 0.2)
CORNERS = [(0, 0, 0), (1.2, 0, 0), (0, 0.9, 0), (0.1, 0.1, 0.7), (1.0, 0.6, 0.5)]


def test_principal_axes_of_random_tensors() -> None:
    """They make the tensor diagonal and are a rotation; no other order or sign is nearer to the body's axes."""
    rng = np.random.default_rng(1)
    for k in range(100):
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        moments = rng.uniform(1.0, 2.0, 3)
        if k % 4 == 0:
            moments[1] = moments[0]
        tensor = q @ np.diag(moments) @ q.T
        found, rotation = principal_axes(tensor)
        axes = rotation_matrix(rotation)
        assert axes @ np.diag(found) @ axes.T == pytest.approx(tensor, abs=1e-13)
        assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-14)
        assert np.sort(found) == pytest.approx(np.sort(moments), rel=1e-13)
        if k % 4:
            for order in ((1, 2, 0), (2, 0, 1)):
                assert np.trace(axes[:, order]) <= np.trace(axes)
            for signs in ((1, -1, -1), (-1, 1, -1), (-1, -1, 1)):
                assert np.trace(axes * signs) <= np.trace(axes)


def test_aligned_boxes_keep_the_bodys_axes() -> None:
    for half in ((1, 2, 3), (3, 1, 2), (2, 2, 1), (1, 1, 1)):
        moments, rotation = principal_axes(mass_properties(Box(half_extents=half))[2])
        assert rotation == (1.0, 0.0, 0.0, 0.0)
        assert moments == pytest.approx(np.diag(mass_properties(Box(half_extents=half))[2]))


def test_equal_moments_do_not_turn_the_axes() -> None:
    noise = np.random.default_rng(2).normal(size=(3, 3)) * 1e-12
    _, rotation = principal_axes(np.eye(3) + noise + noise.T)
    assert rotation == (1.0, 0.0, 0.0, 0.0)
    # a drum turned about y: its axis turns with it, the two others no farther than that
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    for wobble in (0.0, 1e-12, -1e-12):
        tensor = turn @ np.diag([2.0, 2.0 + wobble, 1.0]) @ turn.T
        _, rotation = principal_axes(tensor)
        assert rotation == pytest.approx((np.cos(0.15), 0.0, np.sin(0.15), 0.0), abs=1e-9)


def test_one_shape_gives_its_own_axes() -> None:
    """Also where its moments are equal: they stay principal when its size changes."""
    for shape in (
        Box(half_extents=(1, 1, 1), orientation=ROTATION),
        Box(half_extents=(1, 2, 3), orientation=(0.1, 0, 0, 1)),
    ):
        _, _, moments, rotation = solid_mass(3, [shape])
        wanted = np.array(shape.orientation) / np.linalg.norm(shape.orientation)
        assert rotation == pytest.approx(wanted)
        own = mass_properties(Box(half_extents=shape.half_extents))[2]
        assert moments == pytest.approx(np.diag(own))


def test_parts_make_the_whole() -> None:
    """A box in two pieces of one density."""
    r = {"density": 3.0, "orientation": ROTATION}
    axes = rotation_matrix(solid_mass(3, [Box(half_extents=(1, 1, 1), orientation=ROTATION)])[3])
    whole = solid_mass(3, [Box(half_extents=(1.0, 0.5, 0.25), position=(1, 2, 3), **r)])  # type: ignore[arg-type]
    parts = [
        Box(half_extents=(0.7, 0.5, 0.25), position=axes[:, 0] * -0.3 + (1, 2, 3), **r),  # type: ignore[arg-type]
        Box(half_extents=(0.3, 0.5, 0.25), position=axes[:, 0] * 0.7 + (1, 2, 3), **r),  # type: ignore[arg-type]
        Sphere(radius=5.0, sensor=True),
    ]
    mass, center, moments, rotation = solid_mass(3, parts)
    assert mass == pytest.approx(whole[0])
    assert center == pytest.approx(whole[1])
    for m, q in ((moments, rotation), (whole[2], whole[3])):
        a = rotation_matrix(q)
        assert a @ np.diag(m) @ a.T == pytest.approx(axes @ np.diag(whole[2]) @ axes.T)
    assert solid_mass(3, [])[0] == 0.0


def compiled(shape: Shape, worlds: int) -> tuple[Any, Any, Any]:
    """As much of a model as mass.py looks at."""
    one = shape_record(shape, shape_parameter_dtype(3))
    bodies, shapes = np.zeros(1, body_model_dtype()), np.zeros(1, shape_model_dtype())
    shapes["kind"], shapes["vertex_count"] = int(shape.kind), len(one.vertices)
    parameters = np.zeros((worlds, 1), body_parameter_dtype(3))
    parameters["center"] = mass_properties(shape)[1]
    model = SimpleNamespace(dim=3, bodies=bodies, shapes=shapes, nominal_vertices=one.vertices)
    return model, np.broadcast_to(one.record, (worlds, 1)).copy(), parameters


SHAPES = [
    (Sphere(radius=0.5), {"radius": 0.7}),
    (Box(half_extents=(1, 1, 1)), {"half_extents": (0.4, 0.9, 0.2)}),
    (Capsule(half_length=0.3, radius=0.2), {"half_length": 0.8, "radius": 0.1}),
    (Cylinder(half_length=0.3, radius=0.2), {"half_length": 0.1, "radius": 0.5}),
]


@pytest.mark.parametrize(("shape", "sizes"), SHAPES, ids=lambda v: type(v).__name__)
def test_resizing_is_the_same_as_authoring(shape: Shape, sizes: dict[str, Any]) -> None:
    place: Any = {"position": (0.3, 0.2, 0.1), "orientation": ROTATION, "density": 2.0}
    old, new = type(shape)(**{**vars(shape), **place}), type(shape)(**{**vars(shape), **place, **sizes})
    model, records, bodies = compiled(old, 3)
    fresh = shape_record(new, shape_parameter_dtype(3)).record
    for name in ("size", "radius"):
        records[name][1, 0] = fresh[name]
    chosen = np.array([0, 1])
    found = solids(model, records, 0, chosen)
    for world, authored in enumerate((old, new)):
        wanted_mass, _, moments, _ = solid_mass(3, [authored])
        assert found["mass"][world] == pytest.approx(wanted_mass)
        assert found["inertia"][world] == pytest.approx(moments)
    fit_solids(chosen, as_records(bodies), as_records(records), 0, 0, as_records(found), False, False)
    assert records["extent"][1, 0] == pytest.approx(new.extent()) == bodies["extent"][1, 0]
    assert bodies["radius"][1, 0] == pytest.approx(bounding_radius(new, new.position))
    assert bodies["radius"][2, 0] == 0.0, "not chosen"


def test_density_of_a_hull() -> None:
    hull = Hull(vertices=CORNERS, orientation=ROTATION, position=(1, 2, 3))
    model, records, _ = compiled(hull, 2)
    records["density"][1] = 5.0
    found = solids(model, records, 0, np.array([0, 1]))
    wanted, _, moments, _ = solid_mass(3, [hull])
    assert found["mass"] == pytest.approx([wanted, 5.0 * wanted])
    assert found["inertia"][0] == pytest.approx(moments)
    assert found["inertia"][1] == pytest.approx(5.0 * moments)
