"""Normals and separations: every pair of kinds against support points sampled over all directions."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from gsenv.solver.spatial.kinds import ShapeKind
from gsenv.solver.spatial.narrowphase.table import FIELDS, NONE, PAIR_TABLE
from tests.solver.spatial.narrowphase.pairs import (
    Shape,
    best_separation,
    box,
    box_hull,
    capsule,
    contact_of,
    cylinder,
    hull,
    icosahedron,
    plane,
    random_hull,
    reach,
    rotation,
    sphere,
    tetrahedron,
    turn,
)  # fmt: skip

Rng = np.random.Generator
MAKERS: dict[str, Callable[[Rng], Shape]] = {
    "sphere": lambda r: sphere(r.uniform(0.2, 0.8)),
    "box": lambda r: box(*r.uniform(0.2, 0.8, 3)),
    "capsule": lambda r: capsule(*r.uniform(0.2, 0.8, 2)),
    "cylinder": lambda r: cylinder(*r.uniform(0.2, 0.8, 2)),
    "hull": lambda r: random_hull(r, 12, 0.7),
    "box_hull": lambda r: box_hull(*r.uniform(0.2, 0.8, 3)),
}
PAIRS = list(itertools.product(MAKERS, MAKERS))
FACE_BIAS = 0.03  # of the extent: how much shallower another direction may be than a face that is taken


@pytest.mark.nojit
def test_every_pair_of_kinds_is_handled_or_excluded_by_name() -> None:
    solid = [ShapeKind.SPHERE, ShapeKind.BOX, ShapeKind.CAPSULE, ShapeKind.CYLINDER, ShapeKind.HULL]
    fixed = [ShapeKind.PLANE, ShapeKind.HEIGHTFIELD]
    assert PAIR_TABLE.shape == (len(ShapeKind), len(ShapeKind))
    assert (PAIR_TABLE.T == PAIR_TABLE).all()
    for a, b in itertools.product(ShapeKind, ShapeKind):
        routine = PAIR_TABLE[a, b]
        assert (routine == NONE) == (a in fixed and b in fixed)
        assert (routine == FIELDS) == (ShapeKind.HEIGHTFIELD in (a, b) and (a in solid or b in solid))
    shapes = [sphere(1), box(1, 1, 1), capsule(1, 1), cylinder(1, 1), tetrahedron(2)]
    for a_shape, b_shape in itertools.product(shapes, [*shapes, plane()]):
        for one, other in ((a_shape, b_shape), (b_shape, a_shape)):
            contact = contact_of(one, other.placed((0.1, 0.2, 0.3)), 0.1)
            assert contact.count > 0, (one, other)
            assert contact.separation < 0.0


def placed_pair(names: tuple[str, str], rng: Rng, spread: float) -> tuple[Shape, Shape]:
    a = MAKERS[names[0]](rng).placed(0.1 * rng.normal(size=3), rotation(rng))
    b = MAKERS[names[1]](rng).placed(spread * rng.normal(size=3), rotation(rng))
    return a, b


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_separation_is_the_largest_over_all_directions(names: tuple[str, str]) -> None:
    rng = np.random.default_rng([PAIRS.index(names), 1])
    for spread in (1.5, 1.5, 1.0, 0.3, 0.3):
        a, b = placed_pair(names, rng, spread)
        contact = contact_of(a, b, 1e300)
        assert contact.separation <= reach(a, b, contact.normal) + 1e-12  # a lower bound of the distance
        oracle = best_separation(a, b, rng, 1000)
        extent = min(a.extent, b.extent)
        if oracle < 0.0:
            assert contact.separation >= oracle - FACE_BIAS * extent - 0.06 * abs(oracle) * (names == ("box", "box"))
        elif names == ("box", "box"):  # corners that pass have a bound only
            assert 0.0 < contact.separation
        else:
            assert contact.separation >= oracle - 1e-9


def axes_separation(a: Shape, b: Shape) -> float:
    """Largest separation along the 15 axes of two boxes."""
    edges = [np.cross(e, f) for e in a.rotation.T for f in b.rotation.T]
    axes = [*a.rotation.T, *b.rotation.T, *(e for e in edges if np.linalg.norm(e) > 1e-6)]
    return max(float(reach(a, b, sign * axis)) for axis in axes for sign in (-1, 1))


def test_boxes_against_all_fifteen_axes() -> None:
    rng = np.random.default_rng(3)
    for _ in range(300):
        a, b = placed_pair(("box", "box"), rng, 0.6)
        extent = min(a.extent, b.extent)
        exact = axes_separation(a, b)
        for margin in (1e300, 0.05):
            contact = contact_of(a, b, margin)
            if exact > margin:
                assert contact.separation == np.inf
                assert contact.count == 0
                continue
            assert contact.separation <= exact + 1e-12
            assert contact.separation >= exact - 0.02 * extent - 0.06 * abs(exact)
            if exact < -0.02 * extent:
                assert contact.count > 0


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("a", "b", "normal", "separation"),
    [
        (sphere(0.5), sphere(0.25).placed((0.0, 0.6, 0.8)), (0, 0.6, 0.8), 0.25),
        (sphere(0.5), capsule(1, 0.2).placed((1.0, 0, 0.7)), (1, 0, 0), 0.3),
        (sphere(0.5), capsule(1, 0.2).placed((0.0, 0, 2.0)), (0, 0, 1), 0.3),
        (sphere(0.1), box(1, 1, 1).placed((1.3, 1.4, 0)), (0.6, 0.8, 0), 0.4),
        (sphere(0.1), box(1, 2, 3).placed((0.3, 0, 0)), (1, 0, 0), -0.8),
        (sphere(0.1), cylinder(1, 2).placed((2.3, 0, 1.4)), (0.6, 0, 0.8), 0.4),
        (sphere(0.1), cylinder(1, 2).placed((0.5, 0, 0.3)), (0, 0, 1), -0.8),
        (sphere(0.1), cylinder(2, 1).placed((0, 0.5, 0.3)), (0, 1, 0), -0.6),
        (sphere(0.1), plane().placed((3, 4, -0.2)), (0, 0, -1), 0.1),
        (sphere(0.1), box_hull(1, 1, 1).placed((1.3, 1.4, 0)), (0.6, 0.8, 0), 0.4),
        (sphere(0.1), box_hull(1, 2, 3).placed((0.3, 0, 0)), (1, 0, 0), -0.8),
        (capsule(1, 0.2), capsule(1, 0.3).placed((0, 0.6, 0), turn((0, 1, 0), 1.0)), (0, 1, 0), 0.1),
        (capsule(1, 0.2), box(1, 1, 1).placed((0, 1.3, 0), turn((0, 1, 0), 0.3)), (0, 1, 0), 0.1),
        (capsule(1, 0.2), plane().placed((0, 0, -1.3)), (0, 0, -1), 0.1),
        (cylinder(1, 0.2), cylinder(1, 0.3).placed((0, 0.6, 0), turn((0, 1, 0), 1.0)), (0, 1, 0), 0.1),
        (cylinder(1, 0.2), capsule(1, 0.3).placed((0, 0.6, 0), turn((0, 1, 0), 1.0)), (0, 1, 0), 0.1),
        (cylinder(1, 0.2), box(1, 1, 1).placed((0, 0, 2.1), turn((0, 0, 1), 0.3)), (0, 0, 1), 0.1),
        (cylinder(1, 0.2), plane().placed((0, 0, -1.1)), (0, 0, -1), 0.1),
        (tetrahedron(1.0), plane().placed((0, 0, -0.6)), (0, 0, -1), 0.1),
        (box(1, 1, 1), box(1, 1, 1).placed((0, 0, 1.9)), (0, 0, 1), -0.1),
        (box(1, 1, 1), plane().placed((0, 0, -1.1)), (0, 0, -1), 0.1),
    ],
)  # fmt: skip
def test_known_answers(a: Shape, b: Shape, normal: tuple[float, float, float], separation: float) -> None:
    for one, other, sign in ((a, b, 1.0), (b, a, -1.0)):
        contact = contact_of(one, other, 0.5)
        np.testing.assert_allclose(contact.normal, sign * np.array(normal), atol=1e-9)
        assert contact.separation == pytest.approx(separation, abs=1e-9)
        assert contact.count > 0
        assert contact.gap.min() == pytest.approx(separation, abs=1e-9)


def test_boxes_and_box_hulls_agree() -> None:
    rng = np.random.default_rng(7)
    for _ in range(60):
        one, other = rng.uniform(0.2, 0.8, (2, 3))
        at, axes = 0.8 * rng.normal(size=3), rotation(rng)
        a, b = box(*one), box(*other).placed(at, axes)
        contact = contact_of(a, b, 1e300)
        exact = contact_of(box_hull(*one), box_hull(*other).placed(at, axes), 1e300)
        if exact.separation > 0:
            assert contact.separation <= exact.separation + 1e-9
        else:
            assert contact.separation == pytest.approx(exact.separation, abs=0.03 + 0.06 * abs(exact.separation))


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_far_from_the_origin_and_in_any_frame(names: tuple[str, str]) -> None:
    rng = np.random.default_rng([PAIRS.index(names), 2])
    for spread in (1.0, 0.3):
        a, b = placed_pair(names, rng, spread)
        contact = contact_of(a, b, 1e300)
        frame = rotation(rng)
        shift = 1e4 * rng.normal(size=3)
        moved = contact_of(a.moved(frame, shift), b.moved(frame, shift), 1e300)
        assert moved.separation == pytest.approx(contact.separation, abs=1e-8)
        slack = 1e-5 if "cylinder" in names else 1e-7  # round both ways: the depth has a flat minimum
        np.testing.assert_allclose(moved.normal, frame @ contact.normal, atol=slack)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_either_order(names: tuple[str, str]) -> None:
    rng = np.random.default_rng([PAIRS.index(names), 3])
    for spread in (1.5, 1.0, 0.3):
        a, b = placed_pair(names, rng, spread)
        one = contact_of(a, b, 1e300)
        other = contact_of(b, a, 1e300)
        slack = FACE_BIAS * min(a.extent, b.extent) if one.separation < 0 or names == ("box", "box") else 1e-9
        assert other.separation == pytest.approx(one.separation, abs=slack)
        if abs(other.separation - one.separation) < 1e-12:
            np.testing.assert_allclose(other.normal, -one.normal, atol=1e-6)


SIZES: dict[str, Callable[[float], Shape]] = {
    "sphere": sphere,
    "box": lambda s: box(s, s, s),
    "capsule": lambda s: capsule(s, s),
    "cylinder": lambda s: cylinder(s, s),
    "hull": icosahedron,
    "box_hull": lambda s: box_hull(s, s, s),
}


@pytest.mark.parametrize("names", list(itertools.product(SIZES, SIZES)), ids="-".join)
def test_degenerate_input(names: tuple[str, str]) -> None:
    """Concentric, touching, parallel, 1:1000: finite answers and valid bounds."""
    quarter = turn((1, 0, 0), np.pi / 2)
    for size in (1.0, 1000.0, 0.001):
        a = SIZES[names[0]](1.0)
        for axes in (np.eye(3), quarter, turn((1, 2, 3), 1e-9), turn((0, 0, 1), np.pi / 4)):
            b = SIZES[names[1]](size).placed((0, 0, 0), axes)
            top = reach(a, b, np.array((0.0, 0.0, 1.0)))
            for at in ((0, 0, 0), (0, 0, -top), (0, 0, 1e-9 - top), (1e-12, 0, 0), (0.3, 0.2, -1e-3 - top)):
                contact = contact_of(a, b.placed(at), 1e300)
                bound = reach(a, b.placed(at), contact.normal)
                assert contact.separation <= bound + 1e-9 * max(size, 1.0)
                assert contact.count > 0 or contact.separation > -1e-6


def test_a_hull_of_many_faces() -> None:
    rng = np.random.default_rng(5)
    points = rng.normal(size=(60, 3))
    a = hull(points / np.linalg.norm(points, axis=1)[:, None])
    for _ in range(10):
        b = a.placed(rng.normal(size=3), rotation(rng))
        contact = contact_of(a, b, 1e300)
        oracle = best_separation(a, b, rng, 1000)
        assert contact.separation >= oracle - (1e-9 if oracle > 0 else FACE_BIAS * a.extent)


def test_face_contacts_take_the_face_exactly() -> None:
    """A body that rests with an error of 1e-7 rad keeps the face's own normal: nothing flickers."""
    rng = np.random.default_rng(8)
    for make in (lambda: box(0.5, 0.5, 0.5), lambda: cylinder(0.5, 0.3), lambda: box_hull(0.4, 0.4, 0.5)):
        for _ in range(10):
            axes = turn(rng.normal(size=3), 1e-7)
            contact = contact_of(box(2, 2, 0.5), make().placed((0.1, 0.2, 1.0 - 1e-4), axes), 0.01)
            assert contact.count == 4
            np.testing.assert_allclose(contact.normal, (0, 0, 1), atol=2e-7)
