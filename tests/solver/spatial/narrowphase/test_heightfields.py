"""Heightfields against convex shapes: analytic cases, inner edges, and random ones against sampling."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver.spatial import Box, Capsule, Cylinder, Hull, Shape, Sphere
from gsenv.solver.spatial.math import rotate, to_world
from gsenv.solver.spatial.narrowphase.heightfields import STEEPEST
from gsenv.solver.spatial.shapes import rotation_matrix
from tests.solver.spatial.narrowphase import field_oracle as oracle
from tests.solver.spatial.narrowphase.field_scene import OverField, field_over, pose_at

UP = (0.0, 0.0, 1.0)
FLAT = field_over(lambda x, y: 0.0)
RIDGE = field_over(lambda x, y: -0.5 * abs(x))
LYING = (1.0, 1.0, 0.0, 0.0)  # z along -y
SHAPES: dict[str, Shape] = {
    "sphere": Sphere(radius=0.3),
    "box": Box(half_extents=(0.3, 0.2, 0.15)),
    "capsule": Capsule(half_length=0.3, radius=0.15),
    "cylinder": Cylinder(half_length=0.3, radius=0.15),
    "disc": Cylinder(half_length=0.1, radius=0.4),
    "hull": oracle.small_hull(),
}


def random_rotation(rng: np.random.Generator) -> Any:
    q = rng.normal(size=4)
    return tuple((q / np.linalg.norm(q)).tolist())


# ---------------------------------------------------------------- analytic


def test_sphere_on_a_tilted_plane_at_any_place() -> None:
    n = np.array([-0.3, 0.2, 1.0]) / np.linalg.norm([-0.3, 0.2, 1.0])
    over = OverField(field_over(lambda x, y: 0.3 * x - 0.2 * y), SHAPES["sphere"])
    rng = np.random.default_rng(1)
    for _ in range(300):
        foot = rng.uniform(-1.6, 1.6, 2)
        foot = np.array([*foot, 0.3 * foot[0] - 0.2 * foot[1]])
        gap = rng.uniform(-0.25, 0.009)
        found = over.contacts(foot + n * (0.3 + gap))
        assert found.number == 1
        assert found.normal[0] == pytest.approx(n, abs=1e-12)
        assert found.separation[0] == pytest.approx(gap, abs=1e-12)
        assert found.point[0] == pytest.approx(foot + 0.5 * gap * n, abs=1e-12)


@pytest.mark.nojit
def test_a_ball_in_a_valley_touches_both_sides() -> None:
    over = OverField(field_over(lambda x, y: 0.5 * abs(x)), Sphere(radius=0.3))
    slope = np.sqrt(1.25)
    found = over.contacts((0.0, 0.05, 0.3 * slope - 0.001))
    assert found.number == 2
    assert np.sort(found.normal[:, 0]) == pytest.approx([-0.5 / slope, 0.5 / slope])
    assert found.separation == pytest.approx([-0.001 / slope] * 2)


@pytest.mark.nojit
def test_resting_flat_gives_few_spread_points() -> None:
    """Each with the exact gap, as far apart as the shape allows."""
    cases: list[tuple[Shape, Any, float, int, float]] = [
        (Box(half_extents=(0.31, 0.22, 0.1)), (1, 0, 0, 0), 0.1, 4, 0.31 * 0.22 * 4),
        (Cylinder(half_length=0.1, radius=0.33), (1, 0, 0, 0), 0.1, 4, 2 * 0.33**2),
        (Cylinder(half_length=0.4, radius=0.1), LYING, 0.1, 2, 0.0),
        (Capsule(half_length=0.4, radius=0.1), LYING, 0.1, 2, 0.0),
        (Hull(vertices=oracle.SIGNS * (0.31, 0.22, 0.1)), (1, 0, 0, 0), 0.1, 4, 0.31 * 0.22 * 4),
    ]
    for shape, rotation, height, count, area in cases:
        for gap in (-0.002, 0.0, 0.003):
            found = OverField(FLAT, shape).contacts((0.13, 0.07, height + gap), rotation)
            assert found.number == count, shape
            assert found.separation == pytest.approx([gap] * count, abs=1e-12)
            assert np.abs(found.normal - UP).max() < 1e-12
            if area:
                x, y = (found.point[:, k] - found.point[:, k].mean() for k in (0, 1))
                order = np.argsort(np.arctan2(y, x))
                x, y = x[order], y[order]
                assert 0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) == pytest.approx(area)
            else:
                assert np.ptp(found.point[:, 1]) == pytest.approx(0.8)


@pytest.mark.nojit
def test_on_a_ridge() -> None:
    for shape, rotation, height, low, high in (
        (Box(half_extents=(0.3, 0.2, 0.1)), (1, 0, 0, 0), 0.1, -0.15, 0.25),
        (Cylinder(half_length=0.1, radius=0.2), (1, 0, 0, 0.2), 0.1, 0.05 - 0.2, 0.05 + 0.2),
        (Cylinder(half_length=0.2, radius=0.1), LYING, 0.1, -0.15, 0.25),
        (Capsule(half_length=0.2, radius=0.1), LYING, 0.1, -0.15, 0.25),
    ):
        for gap in (-0.001, 0.002):
            found = OverField(RIDGE, shape).contacts((0.0, 0.05, height + gap), rotation)
            assert np.abs(found.normal - UP).max() < 1e-9
            assert found.separation == pytest.approx([gap] * found.number, abs=1e-12)
            assert found.point[:, 0] == pytest.approx([0.0] * found.number, abs=1e-9)
            assert (found.point[:, 1].min(), found.point[:, 1].max()) == pytest.approx((low, high), abs=1e-9)
    across = OverField(RIDGE, Capsule(half_length=0.2, radius=0.1)).contacts((0.03, 0.05, 0.099), (1, 0, 1, 0))
    assert across.number == 1
    assert across.point[0] == pytest.approx((0.0, 0.05, -0.0005))


@pytest.mark.nojit
def test_a_bump_among_the_points_of_a_face_is_a_contact() -> None:
    """Four points around it are farther apart, but a face that rocks on two of them falls onto it."""
    field = field_over(lambda x, y: 0.002 * (abs(x) + abs(y) < 1e-6) - 0.0, samples=21)
    over = OverField(field, Box(half_extents=(0.6, 0.6, 0.2)))
    tilt = np.arcsin(0.006 / 1.2)  # it stands on the corners at -x
    found = over.contacts((0.0, 0.0, 0.2 + 0.003), (np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0), margin=0.01)
    bump = found.point[np.hypot(found.point[:, 0], found.point[:, 1]) < 0.01]
    assert len(bump) == 1
    assert found.number >= 5


@pytest.mark.nojit
def test_a_ridge_beside_the_one_that_carries_an_edge_is_a_contact_if_the_shape_may_turn() -> None:
    """A capsule along x leans on one edge of a flat top; it may turn onto the other."""
    top = field_over(lambda x, y: -0.5 * np.maximum(abs(x) - 0.2, 0.0), samples=21)
    over = OverField(top, Capsule(half_length=0.5, radius=0.1))
    lean = 0.01
    rotation = (np.cos(np.pi / 4 + lean / 2), 0.0, np.sin(np.pi / 4 + lean / 2), 0.0)
    at = (0.0, 0.03, 0.1 * 1.0 + 0.2 * lean)
    near = over.contacts(at, rotation, margin=0.01)
    turned = over.contacts(at, rotation, margin=0.01, turn=0.02)
    assert near.point[:, 0] == pytest.approx([0.2], abs=2e-3)
    assert np.sort(turned.point[:, 0]) == pytest.approx([-0.2, 0.2], abs=2e-3)
    other = int(np.argmin(turned.point[:, 0]))
    assert turned.separation[other] == pytest.approx(0.4 * lean, rel=0.02)


def test_a_box_standing_on_its_corner_and_on_its_edge() -> None:
    over = OverField(FLAT, Box(half_extents=(0.2, 0.2, 0.2)))
    on_edge = over.contacts((0.03, 0.04, 0.2 * np.sqrt(2.0) - 0.001), (np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0))
    assert on_edge.number == 2
    assert on_edge.separation == pytest.approx([-0.001] * 2)
    tilt = 0.5 * np.arccos(1.0 / np.sqrt(3.0))
    axis = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0) * np.sin(tilt)
    on_corner = over.contacts((0.03, 0.04, 0.2 * np.sqrt(3.0) - 0.001), (np.cos(tilt), *axis))
    assert on_corner.number == 1
    assert on_corner.separation[0] == pytest.approx(-0.001)


def test_beside_a_cliff() -> None:
    """A step of 1 m in a cell: a box on the edge is held up, one beside it is pushed away, neither is thrown."""
    step = field_over(lambda x, y: np.where(x < -1e-9, 1.0, 0.0), samples=401, size=4.0)  # wall from x = -0.01 to 0
    over = OverField(step, Box(half_extents=(0.2, 0.2, 0.2)))
    held = over.contacts((-0.06, 0.003, 1.2 - 0.001))
    assert held.normal[:, 2] == pytest.approx(np.ones(held.number), abs=1e-9)
    assert held.separation == pytest.approx([-0.001] * held.number, abs=1e-9)
    assert np.ptp(held.point[:, 0]) == pytest.approx(0.26 - 0.01, abs=1e-9)
    beside = over.contacts((0.2 - 0.001, 0.003, 0.5))
    assert beside.number > 0
    assert beside.normal[:, 0].min() > 0.99
    assert (beside.separation > -0.011).all()


# ---------------------------------------------------------------- nothing where nothing should be


@pytest.mark.parametrize("name", SHAPES)
def test_no_inner_edges_on_flat_ground(name: str) -> None:
    rng = np.random.default_rng(3)
    over = OverField(FLAT, SHAPES[name])
    turned = random_rotation(rng)
    for k in range(1000):
        rotation = (1.0, 0.0, 0.0, 0.0) if k % 2 else turned
        low = over.contacts((0, 0, 0.0), rotation, margin=5.0).separation.min()
        at = (*rng.uniform(-1.4, 1.4, 2), -low - 0.004)
        found = over.contacts(at, rotation)
        assert found.number > 0
        assert np.abs(found.normal - UP).max() < 1e-12
        assert found.deepest == pytest.approx(-0.004, abs=1e-9)


@pytest.mark.parametrize("name", ["sphere", "capsule", "cylinder"])
def test_normals_stay_between_those_of_the_faces_near(name: str) -> None:
    """On gently curved ground; the field is so fine that neighbours differ by a degree."""
    field = field_over(lambda x, y: -0.05 * (x * x + y * y), samples=41)
    over = OverField(field, SHAPES[name])
    rng = np.random.default_rng(4)
    for _ in range(60):
        rotation = random_rotation(rng) if name != "cylinder" else LYING
        xy = rng.uniform(-1.0, 1.0, 2)
        found = over.contacts(over.lowered(xy, rotation, 0.002), rotation, margin=0.005)
        assert found.number > 0
        slope = -found.normal[:, :2] / found.normal[:, 2:]
        assert np.abs(slope + 0.1 * found.point[:, :2]).max() <= 0.1 * 0.1 + 1e-9, "a cell is 0.1 m"


def test_outside_of_the_rectangle_is_nothing() -> None:
    for shape in SHAPES.values():
        over = OverField(FLAT, shape)
        for at in ((2.5, 0.0, 0.0), (0.0, -2.6, 0.01), (0.0, 0.0, 0.7), (9.0, 9.0, -1.0)):
            assert over.contacts(at).number == 0
            assert over.gap(at, margin=0.01) == np.inf


def test_open_from_behind() -> None:
    """What is wholly below is not pulled up, and what went in a little comes out upwards."""
    for shape in SHAPES.values():
        over = OverField(FLAT, shape)
        assert over.contacts((0.1, 0.2, -0.6)).number == 0
        slightly = over.contacts((0.1, 0.2, 0.05))
        assert slightly.number > 0
        assert (slightly.normal[:, 2] > 0.9).all()


def test_over_the_border() -> None:
    """Half of a box beyond the rectangle is carried by the border; nothing pushes it sideways."""
    over = OverField(FLAT, Box(half_extents=(0.3, 0.2, 0.1)))
    found = over.contacts((1.95, 0.05, 0.099))
    assert found.normal == pytest.approx(np.tile(UP, (found.number, 1)))
    assert (found.point[:, 0].min(), found.point[:, 0].max()) == pytest.approx((1.65, 2.0))


def test_not_a_number_touches_nothing() -> None:
    for shape in SHAPES.values():
        found = OverField(FLAT, shape).contacts((np.nan, 0.0, 0.1))
        assert found.number == 0


# ---------------------------------------------------------------- moved, sorted, short of room


def test_field_and_shape_moved_together() -> None:
    rng = np.random.default_rng(5)
    field = field_over(lambda x, y: 0.1 * np.sin(4 * x) * np.cos(5 * y))
    for name, shape in SHAPES.items():
        over = OverField(field, shape)
        rotation = random_rotation(rng)
        place = over.lowered((0.1, 0.2), rotation, 0.003)
        here = over.contacts(place, rotation)
        assert here.number > 0
        frame = pose_at((3.0, -4.0, 5.0), q := random_rotation(rng))
        at = to_world(frame, tuple(place.tolist()))
        there = over.contacts(at, product(q, rotation), field=frame)
        assert there.feature.tolist() == here.feature.tolist(), name
        assert there.separation == pytest.approx(here.separation, abs=1e-12)
        for k in range(here.number):
            exact = 1e-7 if name in ("cylinder", "disc") else 1e-12  # a rim's direction is searched for
            assert there.normal[k] == pytest.approx(rotate(frame, tuple(here.normal[k])), abs=exact)
            assert there.point[k] == pytest.approx(to_world(frame, tuple(here.point[k])), abs=10 * exact)


def product(p: Any, q: Any) -> Any:
    """Of quaternions, by another formula than the kernels'."""
    w, v = p[0], np.array(p[1:])
    s, u = q[0], np.array(q[1:])
    return (w * s - v @ u, *(w * u + s * v + np.cross(v, u)))


def test_room_for_fewer_contacts() -> None:
    over = OverField(FLAT, SHAPES["box"])
    whole = over.contacts((0.1, 0.2, 0.149))
    short = over.contacts((0.1, 0.2, 0.149), room=2)
    assert over.total == whole.number == 4
    assert short.point.tolist() == whole.point[:2].tolist()


@pytest.mark.parametrize("name", SHAPES)
def test_features_are_sorted_and_differ(name: str) -> None:
    rng = np.random.default_rng(6)
    over = OverField(field_over(lambda x, y: rng.normal(size=x.shape) * 0.05), SHAPES[name])
    for _ in range(100):
        found = over.contacts((*rng.uniform(-1, 1, 2), 0.15), random_rotation(rng), margin=0.05)
        assert found.number <= 16
        assert (np.diff(found.feature) > 0).all()
        assert np.linalg.norm(found.normal, axis=1) == pytest.approx(np.ones(found.number))


# ---------------------------------------------------------------- against sampling

GROUNDS = {
    "rough": lambda x, y: np.random.default_rng(7).normal(size=x.shape) * 0.05,
    "dome": lambda x, y: -0.2 * (x * x + y * y),
    "bowl": lambda x, y: 0.3 * (x * x + y * y),
    "waves": lambda x, y: 0.1 * np.sin(4 * x) * np.cos(5 * y),
    "cliffs": lambda x, y: 0.4 * (np.floor(3 * x + 0.1) % 2) + 0.0 * y,
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("ground", GROUNDS)
def test_against_sampled_surfaces(ground: str, name: str) -> None:
    """No overlap goes unseen, nothing beyond the margin is seen, and all points lie on both surfaces."""
    rng = np.random.default_rng(8)
    field, shape = field_over(GROUNDS[ground]), SHAPES[name]
    over, faces, points = OverField(field, shape), oracle.triangles(field), oracle.surface(shape, rng)
    for k in range(40):
        rotation, xy = random_rotation(rng), rng.uniform(-1.2, 1.2, 2)
        turned = points @ rotation_matrix(rotation).T
        clearance = (turned[:, 2] - oracle.ground(field, turned[:, 0] + xy[0], turned[:, 1] + xy[1])).min()
        deeper = (-0.005, -0.02, 0.1)[k % 3]
        at = np.array([*xy, deeper - clearance])
        found = over.contacts(at, rotation, margin=0.01)
        if deeper < 0.0:
            assert found.deepest < 0.0, "an overlap of 5 or 20 mm"
        elif ground != "cliffs":  # sampling may overlook a few mm, and slopes are below 60 degrees
            assert found.deepest > 0.0
        bound = over.gap(at, rotation)
        assert bound <= max(deeper, 0.0) + 1e-9, "never more than the fall to the first sample that touches"
        for i in range(found.number):
            half = 0.5 * found.separation[i] * found.normal[i]
            local = rotation_matrix(rotation).T @ (found.point[i] + half - at)
            out = oracle.outside_by(shape, local)
            # an end of a capsule may touch within it, a peak in a hull be pushed past the border of a face
            assert out < 1e-3 - (1.0 - 1.0 / STEEPEST) * min(found.separation[i], 0.0)
            assert out > -1e-3 or isinstance(shape, Capsule)
            if found.separation[i] > -0.03:
                assert oracle.distance_to(faces, found.point[i] - half) < 1e-6


def test_gap_leads_to_contact() -> None:
    """Conservative advancement straight down by the bound never passes the contact and arrives."""
    rng = np.random.default_rng(9)
    for ground in ("rough", "waves"):
        field = field_over(GROUNDS[ground])
        for shape in SHAPES.values():
            over, rotation = OverField(field, shape), random_rotation(rng)
            at = np.array([*rng.uniform(-1, 1, 2), 1.2])
            for _ in range(300):
                gap = over.gap(at, rotation, margin=3.0)
                if gap < 1e-3:
                    break
                at[2] -= gap
            assert gap < 1e-3
            assert over.contacts(at, rotation).deepest > -1e-9
