"""Convex hulls against Qhull, their topology, and clouds that are hard to tell apart."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from gsenv.solver.spatial.hulls import convex_hull, hull_extent, hull_mass, linked_hull

CUBE = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
Array = NDArray[np.float64]


def rotation(rng: np.random.Generator) -> Array:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def ball(rng: np.random.Generator, n: int) -> Array:
    p = rng.normal(size=(n, 3))
    return p / np.linalg.norm(p, axis=1)[:, None]


def drum(sides: int) -> Array:
    t = np.arange(sides) * (2 * np.pi / sides)
    return np.array([(np.cos(a), np.sin(a), z) for a in t for z in (-1.0, 1.0)])


def clouds() -> dict[str, tuple[Array, int, int]]:
    """Cloud, corners and faces that its hull has."""
    rng = np.random.default_rng(5)
    lattice = np.array([(x, y, z) for x in range(5) for y in range(5) for z in range(5)], float)
    r = rotation(rng)
    return {
        "cube": (CUBE, 8, 6),
        "turned cube": (CUBE @ r.T, 8, 6),
        "single precision cube": ((CUBE @ r.T).astype(np.float32).astype(float), 8, 6),
        "far cube": (CUBE @ r.T + 1e4, 8, 6),
        "lattice": (lattice, 8, 6),
        "turned lattice": (lattice @ r.T, 8, 6),
        "cube with points inside": (np.concatenate([CUBE, rng.uniform(-1, 1, (300, 3))]), 8, 6),
        "cube twice": (np.concatenate([CUBE, CUBE]), 8, 6),
        "cube almost twice": (np.concatenate([CUBE, CUBE + 1e-10]), 8, 6),
        "tetrahedron": (ball(rng, 4), 4, 4),
        "octahedron": (np.concatenate([np.eye(3), -np.eye(3)]), 6, 8),
        "drum": (drum(32) @ r.T, 64, 34),
        "ball": (ball(rng, 64), 64, 124),
        "thin plate": (CUBE * (1.0, 1.0, 1e-4) @ r.T, 8, 6),
        "needle": (CUBE * (1.0, 1e-3, 1e-3) @ r.T, 8, 6),
    }


@pytest.mark.parametrize(("points", "corners", "faces"), clouds().values(), ids=clouds())
def test_known_hulls(points: Array, corners: int, faces: int) -> None:
    found, polygons = convex_hull(points)
    assert (len(found), len(polygons)) == (corners, faces)
    assert {tuple(p) for p in found} <= {tuple(p) for p in points}, "corners are points of the cloud"
    assert hull_mass(found, polygons)[0] == pytest.approx(ConvexHull(points).volume, rel=3e-7)


def test_random_clouds_against_qhull() -> None:
    rng = np.random.default_rng(7)
    for _ in range(60):
        points = rng.normal(size=(rng.integers(4, 120), 3)) * 10.0 ** rng.uniform(-2, 2, 3)
        oracle = ConvexHull(points)
        if len(oracle.vertices) > 64 or np.ptp(points, axis=0).min() < 1e-3 * np.ptp(points, axis=0).max():
            continue
        corners, faces = convex_hull(points)
        assert {tuple(p) for p in corners} == {tuple(p) for p in points[oracle.vertices]}
        volume, _, _ = hull_mass(corners, faces)
        assert volume == pytest.approx(oracle.volume, rel=1e-5)  # faces are flat to 1e-6 of the size


@pytest.mark.parametrize("points", [c[0] for c in clouds().values()], ids=clouds())
def test_half_edges(points: Array) -> None:
    corners, faces = convex_hull(points)
    e = linked_hull(corners, faces)
    n, f, m = (int(e[k][0]) for k in ("vertex_count", "face_count", "edge_count"))
    assert (n, f, m) == (len(corners), len(faces), len(e))
    assert n - m // 2 + f == 2
    k = np.arange(m)
    assert (e["twin"][e["twin"]] == k).all()
    assert (e["origin"][e["twin"]] == e["origin"][e["next"]]).all()
    assert (e["face"][e["next"]] == e["face"]).all()
    assert (e["face"][e["twin"]] != e["face"]).all()
    assert (e["origin"][e["vertex_edge"][:n]] == np.arange(n)).all()
    assert (e["face"][e["face_edge"][:f]] == np.arange(f)).all()
    normals, offsets, p = e["normal"][:f], e["offset"][:f], e["position"][:n]
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(f), abs=1e-12)
    size = np.ptp(p, axis=0).max()
    heights = p @ normals.T - offsets
    assert heights.max() <= 4e-6 * size, "all corners are behind all faces"
    assert (heights[e["origin"], e["face"]] >= -4e-6 * size).all(), "a face's corners lie on it"
    # counter-clockwise: each side, crossed into the face's normal, points out of the face
    along = p[e["origin"][e["next"]]] - p[e["origin"]]
    out = np.cross(along, normals[e["face"]])
    middles = np.array([p[face].mean(axis=0) for face in faces])
    assert (((middles[e["face"]] - p[e["origin"]]) * out).sum(axis=1) < 0.0).all()


def test_order_and_copies_of_the_points_do_not_matter() -> None:
    rng = np.random.default_rng(9)
    points = ball(rng, 30)
    wanted = hull_mass(*convex_hull(points))
    for _ in range(5):
        mixed = np.concatenate([points, points[rng.integers(0, 30, 10)]])[rng.permutation(40)]
        found = hull_mass(*convex_hull(mixed))
        assert found[0] == pytest.approx(wanted[0], rel=1e-12)
        assert found[2] == pytest.approx(wanted[2], rel=1e-11, abs=1e-12)


def test_a_far_hull_keeps_its_inertia() -> None:
    points = ball(np.random.default_rng(3), 12)
    near, far = hull_mass(*convex_hull(points)), hull_mass(*convex_hull(points + 1e5))
    assert far[0] == pytest.approx(near[0], rel=1e-9)
    assert far[1] - 1e5 == pytest.approx(near[1], abs=1e-9)
    assert far[2] == pytest.approx(near[2], rel=1e-8, abs=1e-9)


def test_extent() -> None:
    r = rotation(np.random.default_rng(4))
    assert hull_extent(*convex_hull(CUBE * (3.0, 0.5, 1.0) @ r.T)) == pytest.approx(0.5)
    # a regular tetrahedron is narrowest between two edges across: 1/sqrt 2 of its side
    regular = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / np.sqrt(8.0)
    assert hull_extent(*convex_hull(regular @ r.T)) == pytest.approx(0.5 / np.sqrt(2.0))


def test_what_is_returned_may_be_changed() -> None:
    corners, faces = convex_hull(CUBE)
    corners += 1.0
    faces.pop()
    assert len(convex_hull(CUBE)[1]) == 6
    assert convex_hull(CUBE)[0].max() == 1.0
