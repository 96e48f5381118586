"""Every pair of convex shapes against support functions; symmetry; the pair table."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.core.detection import find_contacts
from gsenv.solver.core.status import MORE_CONTACTS
from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon, Shape, Terrain
from gsenv.solver.planar.kinds import ShapeKind
from gsenv.solver.planar.narrowphase.boxes import REFERENCE_BIAS
from gsenv.solver.planar.narrowphase.table import BOXES, CHAINS, NONE, PAIR_TABLE, PLANES, POLYGONS, ROUND
from gsenv.solver.planar.shapes import mass_properties
from gsenv.solver.records.model import Array, contact_dtype
from gsenv.solver.records.scratch_dtypes import PAIR_DTYPE
from tests.solver.planar.narrowphase.collision import (
    STATIC,
    Arrays,
    body,
    core,
    distance_to_point,
    signed_distance,
    world,
)

REST = np.zeros(2)
CONVEX = (ShapeKind.CIRCLE, ShapeKind.BOX, ShapeKind.CAPSULE, ShapeKind.POLYGON)
KIND_PAIRS = [(a, b) for a in CONVEX for b in CONVEX if a <= b]
ONE_PAIR = np.array([(0, 1, 0, 0)], PAIR_DTYPE)


def test_every_pair_is_handled_or_excluded_by_name() -> None:
    still = {ShapeKind.HALF_PLANE, ShapeKind.TERRAIN}
    assert PAIR_TABLE.shape == (len(ShapeKind), len(ShapeKind))
    assert (PAIR_TABLE == PAIR_TABLE.T).all()
    for a in ShapeKind:
        for b in ShapeKind:
            excluded = a in still and b in still
            assert (PAIR_TABLE[a, b] == NONE) == excluded
            assert PAIR_TABLE[a, b] in (NONE, ROUND, BOXES, POLYGONS, PLANES, CHAINS)


def random_shape(kind: ShapeKind, rng: np.random.Generator) -> Shape:
    if kind == ShapeKind.CIRCLE:
        return Circle(radius=rng.uniform(0.1, 1.0))
    if kind == ShapeKind.BOX:
        return Box(half_extents=rng.uniform(0.1, 1.0, 2))
    if kind == ShapeKind.CAPSULE:
        return Capsule(half_length=rng.uniform(0.1, 1.0), radius=rng.uniform(0.1, 0.5))
    angles = np.sort((np.arange(n := rng.integers(3, 9)) + rng.uniform(-0.3, 0.3, n)) * 2 * np.pi / n)
    return Polygon(vertices=np.stack([np.cos(angles), np.sin(angles)], axis=1) * rng.uniform(0.3, 1.0))


def two(a: Shape, pose_a: Array, b: Shape, pose_b: Array) -> Arrays:
    return world(body(a, at=tuple(pose_a[:2]), angle=pose_a[2]), body(b, at=tuple(pose_b[:2]), angle=pose_b[2]))


def check_manifold(contacts: Array, a: Shape, pose_a: Array, b: Shape, pose_b: Array, margin: float) -> None:
    """Against the oracle: separation, normal, and both surfaces at each point."""
    core_a, core_b = core(a, pose_a[:2], pose_a[2]), core(b, pose_b[:2], pose_b[2])
    true = signed_distance(core_a, core_b)
    scale = min(a.extent(), b.extent())
    bias = REFERENCE_BIAS * scale
    sharp = core_a[1] + core_b[1] == 0.0
    if len(contacts) == 0:
        assert true > margin - bias or (sharp and true > 0.0)
        return
    separation = contacts["separation"].min()
    assert separation <= true + 0.1 * bias + 1e-9
    if not sharp or true <= 0.0:  # sharp corners beside each other: only a lower bound
        assert separation >= true - bias - 1e-9
    np.testing.assert_allclose(np.hypot(*contacts["normal"].T), 1.0, atol=1e-12)
    assert len(contacts) <= 2
    assert len(set(contacts["feature"])) == len(contacts)
    for contact in contacts:
        half = 0.5 * contact["separation"] * contact["normal"]
        on_a = distance_to_point(core_a, contact["point"] - half)
        on_b = distance_to_point(core_b, contact["point"] + half)
        assert max(on_a, on_b) < bias + 1e-9
        if contact["separation"] == separation or core_a[1] + core_b[1] == 0.0:
            assert min(on_a, on_b) > -bias - 1e-9  # a cut round side lies a little deeper


@pytest.mark.parametrize("kinds", KIND_PAIRS, ids=lambda k: f"{k[0].name}-{k[1].name}")
def test_manifold_against_support_functions(kinds: tuple[ShapeKind, ShapeKind]) -> None:
    rng = np.random.default_rng(7)
    touching = 0
    for _ in range(60):
        a, b = random_shape(kinds[0], rng), random_shape(kinds[1], rng)
        pose_a = np.append(rng.uniform(-3, 3, 2), rng.uniform(-4, 4))
        pose_b = np.append(pose_a[:2] + rng.normal(size=2) * 0.8, rng.uniform(-4, 4))
        arrays = two(a, pose_a, b, pose_b)
        contacts = arrays.contacts(REST, pairs=ONE_PAIR)
        touching += len(contacts) > 0
        check_manifold(contacts, a, pose_a, b, pose_b, REFERENCE_BIAS * min(a.extent(), b.extent()))
        swapped = two(b, pose_b, a, pose_a).contacts(REST, pairs=ONE_PAIR)
        if len(contacts) and len(swapped):
            s, t = contacts["separation"].min(), swapped["separation"].min()
            assert abs(s - t) <= REFERENCE_BIAS * min(a.extent(), b.extent()) + 1e-9
            if abs(s - t) < 1e-13:
                np.testing.assert_allclose(contacts[0]["normal"], -swapped[0]["normal"], atol=1e-9)
    assert touching > 20


@pytest.mark.parametrize("kinds", KIND_PAIRS, ids=lambda k: f"{k[0].name}-{k[1].name}")
def test_manifold_moves_with_the_world(kinds: tuple[ShapeKind, ShapeKind]) -> None:
    rng = np.random.default_rng(8)
    for _ in range(20):
        a, b = random_shape(kinds[0], rng), random_shape(kinds[1], rng)
        pose_a, pose_b = rng.normal(size=3) * 0.5, rng.normal(size=3) * 0.5
        here = two(a, pose_a, b, pose_b).contacts(REST, pairs=ONE_PAIR)
        turn = rng.uniform(-3, 3)
        shift = rng.uniform(-20, 20, 2)
        R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        moved = [np.append(R @ pose[:2] + shift, pose[2] + turn) for pose in (pose_a, pose_b)]
        there = two(a, moved[0], b, moved[1]).contacts(REST, pairs=ONE_PAIR)
        assert list(here["feature"]) == list(there["feature"])
        np.testing.assert_allclose(here["separation"], there["separation"], atol=1e-12)
        np.testing.assert_allclose(here["normal"] @ R.T, there["normal"], atol=1e-12)
        np.testing.assert_allclose(here["point"] @ R.T + shift, there["point"], atol=1e-12)


@pytest.mark.parametrize("kind", CONVEX, ids=lambda k: k.name)
def test_half_plane_touches_the_lowest_corners(kind: ShapeKind) -> None:
    rng = np.random.default_rng(9)
    for _ in range(60):
        shape = random_shape(kind, rng)
        turn = rng.uniform(-3, 3)
        normal = np.array([np.cos(turn), np.sin(turn)])
        plane = HalfPlane(normal=2.0 * normal, offset=1.4)  # normal need not have length 1
        pose = np.append(normal * rng.uniform(0.3, 1.2) + rng.normal() * np.array([-normal[1], normal[0]]), turn * 3)
        order = rng.integers(2)
        parts = [body(plane, kind=STATIC), body(shape, at=tuple(pose[:2]), angle=pose[2])]
        arrays = world(*(parts[::-1] if order else parts))
        contacts = arrays.contacts(REST, pairs=ONE_PAIR)
        corners, radius = core(shape, pose[:2], pose[2])
        heights = np.sort(corners @ normal - 0.7 - radius)
        if heights[0] > 0.02 * shape.extent():
            assert len(contacts) == 0
            continue
        np.testing.assert_allclose(contacts["separation"].min(), heights[0], atol=1e-12)
        side = -1.0 if order else 1.0
        np.testing.assert_allclose(contacts["normal"], np.tile(side * normal, (len(contacts), 1)), atol=1e-12)
        middle = contacts["point"] @ normal - 0.7
        np.testing.assert_allclose(middle, 0.5 * contacts["separation"], atol=1e-12)
        assert len(contacts) <= 2


def test_resting_faces_have_two_points() -> None:
    floor = body(Box(half_extents=(5.0, 0.5)), at=(0.0, -0.5), kind=STATIC)
    octagon = [(np.cos(t), np.sin(t)) for t in np.pi / 8 + np.arange(8) * np.pi / 4]
    shapes = [
        (Box(half_extents=(0.5, 0.3)), 0.3, 0.5),
        (Capsule(half_length=0.6, radius=0.2), 0.2, 0.6),
        (Polygon(vertices=octagon), np.cos(np.pi / 8), np.sin(np.pi / 8)),
    ]
    planes = [floor, body(HalfPlane(), kind=STATIC), body(Terrain(vertices=[(-9, 0), (9, 0)]), kind=STATIC)]
    for ground in planes:
        for shape, height, half in shapes:
            contacts = world(ground, body(shape, at=(0.1, height))).contacts(REST)
            assert len(contacts) == 2
            np.testing.assert_allclose(np.sort(contacts["point"][:, 0]), [0.1 - half, 0.1 + half], atol=1e-12)
            np.testing.assert_allclose(contacts["normal"], [(0.0, 1.0)] * 2, atol=1e-12)
            np.testing.assert_allclose(contacts["separation"], 0.0, atol=1e-12)


def test_overhang_is_clipped_to_the_face() -> None:
    lower = body(Box(half_extents=(0.5, 0.5)))
    upper = body(Box(half_extents=(0.5, 0.5)), at=(0.6, 1.0))
    contacts = world(lower, upper, with_vertices=False).contacts(REST)
    np.testing.assert_allclose(np.sort(contacts["point"][:, 0]), [0.1, 0.5], atol=1e-12)


def test_material_of_a_pair() -> None:
    a = body(Box(half_extents=(0.5, 0.5), friction=0.9, restitution=0.1))
    b = body(Circle(radius=0.2, friction=0.4, restitution=0.3), at=(0.0, 0.7))
    contact = world(a, b, with_vertices=False).contacts(REST)[0]
    assert contact["friction"] == pytest.approx(0.6)
    assert contact["restitution"] == 0.3
    assert contact["extent"] == 0.2
    assert (contact["shape_a"], contact["shape_b"], contact["body_a"], contact["body_b"]) == (0, 1, 0, 1)


def test_features_survive_small_motion() -> None:
    rng = np.random.default_rng(3)
    floor = body(Box(half_extents=(5.0, 0.5)), at=(0.0, -0.5), kind=STATIC)
    features = set()
    for _ in range(200):
        jitter = rng.normal(size=3) * 1e-4
        arrays = world(
            floor, body(Box(half_extents=(0.5, 0.5)), at=(jitter[0], 0.5 + jitter[1]), angle=jitter[2]),
            with_vertices=False,
        )  # fmt: skip
        features.add(tuple(sorted(arrays.contacts(REST)["feature"])))
    assert len(features) == 1


@pytest.mark.parametrize("kinds", KIND_PAIRS, ids=lambda k: f"{k[0].name}-{k[1].name}")
def test_degenerate_overlaps_are_finite(kinds: tuple[ShapeKind, ShapeKind]) -> None:
    """Same centre, identical shapes, one deep in the other, thin ones."""
    rng = np.random.default_rng(4)
    for trial in range(30):
        a = random_shape(kinds[0], rng)
        b = a if trial % 2 == 0 and kinds[0] == kinds[1] else random_shape(kinds[1], rng)
        angle = [0.0, np.pi / 2, np.pi / 4, rng.uniform(0, 3)][trial % 4]
        middle = -np.array(mass_properties(a)[1]) if trial % 3 == 0 else np.zeros(2)
        shift = 1e-17 * rng.normal(size=2) if trial % 5 == 0 else np.zeros(2)
        arrays = two(a, np.append(middle, 0.0), b, np.append(shift + middle, angle))
        contacts = arrays.contacts(REST, pairs=ONE_PAIR)
        assert len(contacts) >= 1
        for name in ("point", "normal", "separation"):
            assert np.isfinite(contacts[name]).all()
        np.testing.assert_allclose(np.hypot(*contacts["normal"].T), 1.0, atol=1e-12)
        assert -4.0 < contacts["separation"].min() < 0.0


def test_thin_boxes() -> None:
    thin = Box(half_extents=(1.0, 1e-3))
    contacts = world(body(thin), body(thin, at=(0.3, 0.0), angle=0.5), with_vertices=False).contacts(REST)
    assert len(contacts) >= 1
    assert np.isfinite(contacts["point"]).all()


def test_sensors_report_overlap_alone() -> None:
    sensor = body(Box(half_extents=(0.5, 0.5), sensor=True), kind=STATIC)
    far = world(sensor, body(Circle(radius=0.2), at=(0.0, 0.702)), with_vertices=False)
    near = world(sensor, body(Circle(radius=0.2), at=(0.0, 0.69)), with_vertices=False)
    assert len(far.contacts()) == 0
    assert near.contacts()["sensor"].tolist() == [1]


def test_counts_on_when_contacts_are_full() -> None:
    boxes = [body(Box(half_extents=(0.5, 0.5)), at=(0.0, float(k))) for k in range(5)]
    arrays = world(*boxes, with_vertices=False)
    full = arrays.contacts(REST)
    assert len(full) == 8
    few = np.zeros(3, contact_dtype(2))
    status, needed, _, _, _ = find_contacts(arrays.world(REST, found=few))
    assert (status, needed) == (MORE_CONTACTS, 8)
    assert (few == full[:3]).all()
