"""Contact points: where they lie, how many, and that they keep their features while bodies move a little."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.spatial.kinds import PLANE
from tests.solver.spatial.narrowphase.pairs import (
    Contact,
    Shape,
    best_separation,
    box,
    box_hull,
    capsule,
    contact_of,
    cylinder,
    icosahedron,
    plane,
    rotation,
    sphere,
    tetrahedron,
    turn,
)  # fmt: skip

LYING = turn((1, 0, 0), np.pi / 2)
ACROSS = turn((0, 1, 0), np.pi / 2)
DEPTH = 1e-4
TABLE = box(1, 1, 0.5)
ROOT = np.sqrt(0.5)

# name: (a, b, points)
RESTING: dict[str, tuple[Shape, Shape, int]] = {
    "box on box": (box(0.5, 0.5, 0.5), box(0.5, 0.5, 0.5).placed((0, 0, 1 - DEPTH)), 4),
    "box on box, turned": (box(0.5, 0.5, 0.5), box(0.5, 0.5, 0.5).placed((0, 0, 1 - DEPTH), turn((0, 0, 1), 0.3)), 4),
    "box on box, shifted": (box(0.5, 0.5, 0.5), box(0.5, 0.5, 0.5).placed((0.2, 0.1, 1 - DEPTH)), 4),
    "box on table": (TABLE, box(0.2, 0.3, 0.1).placed((0.1, 0.2, 0.6 - DEPTH)), 4),
    "box on plane": (plane(), box(0.2, 0.3, 0.1).placed((0.1, 0.2, 0.1 - DEPTH)), 4),
    "sphere on box": (TABLE, sphere(0.3).placed((0.1, 0.2, 0.8 - DEPTH)), 1),
    "sphere on plane": (plane(), sphere(0.3).placed((0.1, 0.2, 0.3 - DEPTH)), 1),
    "capsule on box": (TABLE, capsule(0.4, 0.1).placed((0, 0, 0.6 - DEPTH), LYING), 2),
    "capsule on plane": (plane(), capsule(0.4, 0.1).placed((0, 0, 0.1 - DEPTH), LYING), 2),
    "capsule over an edge": (TABLE, capsule(0.4, 0.1).placed((0.9, 0, 0.6 - DEPTH), ACROSS), 2),
    "capsule along an edge": (
        TABLE, capsule(0.4, 0.1).placed((1 + (0.1 - DEPTH) * ROOT, 0, 0.5 + (0.1 - DEPTH) * ROOT), LYING), 2,
    ),
    "capsule on capsule": (capsule(0.4, 0.1), capsule(0.4, 0.1).placed((0.2 - DEPTH, 0, 0.3)), 2),
    "capsules crossed": (capsule(0.4, 0.1), capsule(0.4, 0.1).placed((0.2 - DEPTH, 0, 0.3), LYING), 1),
    "cylinder on plane": (plane(), cylinder(0.5, 0.2).placed((0, 0, 0.5 - DEPTH)), 4),
    "cylinder lies on plane": (plane(), cylinder(0.5, 0.2).placed((0, 0, 0.2 - DEPTH), LYING), 2),
    "cylinder on box": (TABLE, cylinder(0.5, 0.2).placed((0, 0, 1 - DEPTH)), 4),
    "cylinder lies on box": (TABLE, cylinder(0.3, 0.2).placed((0, 0, 0.7 - DEPTH), LYING), 2),
    "can on can": (cylinder(0.5, 0.2), cylinder(0.5, 0.2).placed((0, 0, 1 - DEPTH)), 4),
    "can on can, shifted": (cylinder(0.5, 0.2), cylinder(0.5, 0.2).placed((0.05, 0.02, 1 - DEPTH)), 4),
    "log on log": (cylinder(0.5, 0.2), cylinder(0.5, 0.2).placed((0.4 - DEPTH, 0, 0.2)), 2),
    "logs crossed": (cylinder(0.5, 0.2), cylinder(0.5, 0.2).placed((0.4 - DEPTH, 0, 0.2), LYING), 1),
    "box on can": (cylinder(0.5, 0.5), box(0.2, 0.2, 0.2).placed((0.1, 0, 0.7 - DEPTH)), 4),
    "capsule on log": (cylinder(0.5, 0.2), capsule(0.3, 0.1).placed((0.3 - DEPTH, 0, 0)), 2),
    "hull on box": (TABLE, box_hull(0.2, 0.3, 0.1).placed((0, 0, 0.6 - DEPTH)), 4),
    "hull on hull": (box_hull(0.5, 0.5, 0.5), box_hull(0.5, 0.5, 0.5).placed((0, 0, 1 - DEPTH)), 4),
    "hull on plane": (plane(), box_hull(0.2, 0.3, 0.1).placed((0, 0, 0.1 - DEPTH)), 4),
    "can on hull": (box_hull(0.5, 0.5, 0.5), cylinder(0.5, 0.2).placed((0, 0, 1 - DEPTH)), 4),
    "capsule on hull": (box_hull(0.5, 0.5, 0.5), capsule(0.3, 0.1).placed((0, 0, 0.6 - DEPTH), LYING), 2),
    "sphere on hull": (box_hull(0.5, 0.5, 0.5), sphere(0.1).placed((0.1, 0.2, 0.6 - DEPTH)), 1),
}  # fmt: skip


@pytest.mark.parametrize("name", RESTING)
def test_resting_contacts(name: str) -> None:
    a, b, points = RESTING[name]
    for one, other in ((a, b), (b, a)):
        contact = contact_of(one, other, 0.01)
        assert contact.separation == pytest.approx(-DEPTH, abs=1e-9)
        assert contact.count == points
        np.testing.assert_allclose(contact.gap, -DEPTH, atol=1e-8)
        assert contact.feature == sorted(contact.feature)


@pytest.mark.parametrize("name", RESTING)
def test_features_survive_small_motions(name: str) -> None:
    a, b, _ = RESTING[name]
    rng = np.random.default_rng(1)
    before = contact_of(a, b, 0.02)
    for _ in range(30):
        shift = 1e-4 * rng.uniform(-1, 1, 3)
        after = contact_of(a, b.placed(np.asarray(b.at) + shift, turn(rng.normal(size=3), 1e-4) @ b.rotation), 0.02)
        assert after.feature == before.feature
        np.testing.assert_allclose(after.normal, before.normal, atol=5e-3)
        assert abs(after.point - before.point).max() < 0.01


def lies_near(p: np.ndarray, shape: Shape, margin: float, rng: np.random.Generator) -> bool:
    if shape.kind == PLANE:
        return bool((p - shape.at) @ shape.rotation[:, 2] <= margin)
    return best_separation(sphere(0.0).placed(p), shape, rng, 200) <= margin + 1e-9


def test_points_lie_within_both_shapes_grown_by_the_margin() -> None:
    rng = np.random.default_rng(2)
    makers = [sphere(0.4), box(0.3, 0.4, 0.5), capsule(0.4, 0.2), cylinder(0.4, 0.3), icosahedron(0.5), tetrahedron(1)]
    margin = 0.05
    found = 0
    for a in makers:
        for shape in makers:
            for _ in range(8):
                b = shape.placed(0.6 * rng.normal(size=3), rotation(rng))
                contact = contact_of(a, b, margin)
                if contact.separation < -0.1:  # half-way between surfaces may be beyond the far side of a corner
                    continue
                found += contact.count
                for p, gap in zip(contact.point, contact.gap, strict=True):
                    assert gap <= margin
                    assert gap >= contact.separation - 1e-9
                    # the shapes' features are polygons that stand for discs, hence the slack
                    assert lies_near(p, a, margin + 0.01, rng)
                    assert lies_near(p, b, margin + 0.01, rng)
    assert found > 50


@pytest.mark.nojit
def test_points_are_half_way_between_the_surfaces() -> None:
    for gap in (-0.02, 0.02):
        contact = contact_of(box(0.5, 0.5, 0.5), box(0.3, 0.3, 0.3).placed((0, 0, 0.8 + gap)), 0.1)
        np.testing.assert_allclose(contact.point[:, 2], 0.5 + 0.5 * gap, atol=1e-12)
        np.testing.assert_allclose(abs(contact.point[:, :2]), 0.3, atol=1e-5)
        contact = contact_of(plane(), capsule(0.4, 0.1).placed((0, 0, 0.1 + gap), LYING), 0.1)
        np.testing.assert_allclose(contact.point[:, 2], 0.5 * gap, atol=1e-12)
        contact = contact_of(capsule(0.4, 0.1), sphere(0.1).placed((0.2 + gap, 0, 0)), 0.1)
        np.testing.assert_allclose(contact.point, [(0.1 + 0.5 * gap, 0, 0)], atol=1e-12)
        contact = contact_of(cylinder(0.4, 0.1), capsule(0.4, 0.1).placed((0.2 + gap, 0, 0)), 0.1)
        np.testing.assert_allclose(contact.point[:, 0], 0.1 + 0.5 * gap, atol=1e-12)
        contact = contact_of(box_hull(0.4, 0.4, 0.4), cylinder(0.4, 0.1).placed((0, 0, 0.8 + gap)), 0.1)
        np.testing.assert_allclose(contact.point[:, 2], 0.4 + 0.5 * gap, atol=1e-12)


def test_reach_of_the_four_points() -> None:
    """The area that the points span is what keeps a body from tipping."""
    for a, b, area in (
        (box(1, 1, 1), box(0.5, 0.5, 0.5).placed((0, 0, 1.5 - DEPTH), turn((0, 0, 1), 0.5)), 1.0),
        (cylinder(0.5, 0.2), cylinder(0.5, 0.2).placed((0, 0, 1 - DEPTH)), 2 * 0.2**2),
        (TABLE, cylinder(0.5, 0.2).placed((0, 0, 1 - DEPTH)), 2 * 0.2**2),
        (plane(), cylinder(0.5, 0.2).placed((0, 0, 0.5 - DEPTH)), 2 * 0.2**2),
        (plane(), box_hull(0.5, 0.5, 0.5).placed((0, 0, 0.5 - DEPTH)), 1.0),
    ):
        p = contact_of(a, b, 0.01).point[:, :2]
        p = p[np.argsort(np.arctan2(*(p - p.mean(axis=0)).T))]
        q = np.roll(p, 1, axis=0)
        assert 0.5 * abs(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])) == pytest.approx(area, rel=1e-3)


@pytest.mark.nojit
def test_edges_that_cross_touch_in_one_point() -> None:
    lower = box(0.5, 0.5, 0.5).placed((0, 0, 0), turn((1, 0, 0), np.pi / 4))
    upper = box(0.5, 0.5, 0.5).placed((0.1, 0.2, np.sqrt(2) - 0.01), turn((0, 1, 0), np.pi / 4))
    contact = contact_of(lower, upper, 0.02)
    assert contact.count == 1
    np.testing.assert_allclose(contact.normal, (0, 0, 1), atol=1e-12)
    np.testing.assert_allclose(contact.point[0], (0.1, 0.0, np.sqrt(0.5) - 0.005), atol=1e-12)
    assert contact.separation == pytest.approx(-0.01, abs=1e-12)


def deepest(contact: Contact) -> np.ndarray:
    return contact.point[np.argmin(contact.gap)]


def test_a_rolling_cylinder_keeps_its_points() -> None:
    for ground in (plane(), TABLE.placed((0, 0, -0.5))):
        first = None
        for angle in np.linspace(0, 2 * np.pi, 37):
            b = cylinder(0.4, 0.2).placed((0, 0, 0.2 - DEPTH), LYING @ turn((0, 0, 1), angle))
            contact = contact_of(ground, b, 0.01)
            assert contact.count == 2
            np.testing.assert_allclose(np.sort(contact.point[:, 1]), (-0.4, 0.4), atol=1e-5)
            first = contact.feature if first is None else first
            assert contact.feature == first


def test_a_spinning_can_keeps_its_points() -> None:
    for ground in (plane(), TABLE.placed((0, 0, -0.5)), cylinder(0.5, 0.2).placed((0, 0, -0.5))):
        first = None
        for angle in np.linspace(0, 2 * np.pi, 37):
            b = cylinder(0.5, 0.2).placed((0, 0, 0.5 - DEPTH), turn((0, 0, 1), angle))
            contact = contact_of(ground, b, 0.01)
            first = contact if first is None else first
            assert contact.feature == first.feature
            np.testing.assert_allclose(contact.point, first.point, atol=1e-5)


@pytest.mark.parametrize("tilt", [1e-6, 5e-4, 2e-3, 4e-3, 6e-3, 0.05, 0.2, 0.5, 1.0, 1.5])
def test_a_leaning_cylinder_touches_with_its_lowest_point(tilt: float) -> None:
    lowest = 0.2 * np.sin(tilt) + 0.5 * np.cos(tilt)
    for direction in np.linspace(0, 6, 13):
        axes = turn((np.cos(direction), np.sin(direction), 0), tilt)
        b = cylinder(0.5, 0.2).placed((0, 0, lowest - DEPTH), axes)
        for ground, slack in ((plane(), 0.3), (TABLE.placed((0, 0, -0.5)), 0.3)):
            contact = contact_of(ground, b, 0.01)
            assert contact.separation == pytest.approx(-DEPTH, abs=1e-9)
            # nearly upright the points move from fixed places to the lowest one
            assert contact.gap.min() <= -DEPTH + (slack * 0.2 * tilt if tilt < 0.01 else 1e-9)
            if tilt > 0.01:
                side = (axes @ (0, 0, 1))[:2]
                np.testing.assert_allclose(deepest(contact)[:2] @ side / np.linalg.norm(side),
                                           0.5 * -np.sin(tilt) + 0.2 * np.cos(tilt), atol=1e-6)  # fmt: skip


def test_a_tower_of_boxes_keeps_its_features() -> None:
    """Rounding of positions must not move contacts from corner to corner."""
    rng = np.random.default_rng(4)
    features = set()
    for _ in range(200):
        a = box(0.5, 0.5, 0.5).placed(1e-9 * rng.normal(size=3), turn(rng.normal(size=3), 1e-9))
        b = box(0.5, 0.5, 0.5).placed((0, 0, 1) + 1e-9 * rng.normal(size=3), turn(rng.normal(size=3), 1e-9))
        contact = contact_of(a, b, 0.01)
        assert contact.count == 4
        np.testing.assert_allclose(np.abs(contact.point[:, :2]), 0.5, atol=1e-5)
        features.add(tuple(contact.feature))
    assert len(features) == 1


def test_boxes_that_meet_at_edges_have_contacts_where_their_faces_will_meet_when_they_turn() -> None:
    lower = box(0.5, 0.5, 0.5)
    tilted = turn((1.0, 1.0, 0.0), 0.06)
    for at in ((0.7, 0.6, 1.0), (0.4, 0.8, 1.0)):
        upper = box(0.5, 0.5, 0.5).placed(at, tilted)
        gap = best_separation(lower, upper, np.random.default_rng(0))
        contact = contact_of(lower, upper.placed((at[0], at[1], at[2] - gap)), 0.2)
        assert contact.separation == pytest.approx(0.0, abs=1e-4)
        assert contact.count >= 3
        assert min(contact.gap) == pytest.approx(contact.separation, abs=1e-9)
        assert max(contact.gap) > 0.02
