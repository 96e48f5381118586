"""Terrains: smooth over inner vertices, both sides of a valley, ridges, one side only."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.planar import Box, Capsule, Circle, Polygon, Shape, Terrain
from gsenv.solver.records.model import Array
from tests.solver.planar.narrowphase.collision import KINEMATIC, STATIC, Arrays, body, world

REST = np.zeros(2)
HEXAGON = Polygon(vertices=[(np.cos(t), np.sin(t)) for t in np.arange(6) * np.pi / 3])


def on(terrain: Terrain, shape: Shape, x: float, y: float, angle: float = 0.0) -> Arrays:
    return world(body(terrain, kind=STATIC), body(shape, at=(x, y), angle=angle))


def slope(turn: float, count: int = 1001) -> Terrain:
    """Collinear segments of unequal length through the origin."""
    x = np.linspace(-20.0, 20.0, count)
    x[1:-1] += np.random.default_rng(0).uniform(-0.01, 0.01, count - 2)
    return Terrain(vertices=np.stack([np.cos(turn) * x, np.sin(turn) * x], axis=1))


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_ball_over_a_thousand_collinear_segments(turn: float) -> None:
    terrain = slope(turn)
    arrays = on(terrain, Circle(radius=0.3), 0.0, 0.0)
    along, normal = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    places = np.concatenate([np.linspace(-10, 10, 997), np.asarray(terrain.vertices)[300:700] @ along])
    for x in places:
        arrays.bodies["position"][1] = x * along + 0.299 * normal
        contacts = arrays.contacts(REST)
        assert len(contacts) == 1, x
        if turn == 0.0:
            assert contacts["normal"][0].tolist() == [0.0, 1.0]
        np.testing.assert_allclose(contacts["normal"][0], normal, atol=1e-12)
        np.testing.assert_allclose(contacts["separation"][0], -0.001, atol=1e-12)
        np.testing.assert_allclose(contacts["point"][0], x * along - 0.0005 * normal, atol=1e-12)


@pytest.mark.parametrize(
    ("shape", "height", "half"),
    [
        (Box(half_extents=(0.5, 0.3)), 0.3, 0.5),
        (Capsule(half_length=0.5, radius=0.2), 0.2, 0.5),
        (HEXAGON, 0.75**0.5, 0.5),
    ],
    ids=["box", "capsule", "polygon"],
)
def test_two_points_over_collinear_segments(shape: Shape, height: float, half: float) -> None:
    arrays = on(slope(0.0), shape, 0.0, 0.0)
    features = set()
    for x in np.linspace(-5, 5, 501):
        arrays.bodies["position"][1] = x, height - 0.001
        contacts = arrays.contacts(REST)
        assert len(contacts) == 2, x
        assert contacts["normal"].tolist() == [[0.0, 1.0]] * 2
        np.testing.assert_allclose(contacts["separation"], -0.001, atol=1e-12)
        np.testing.assert_allclose(np.sort(contacts["point"][:, 0]), [x - half, x + half], atol=1e-12)
        features.add(tuple(contacts["feature"]))
    assert len(features) == 1  # impulses follow the shape from segment to segment


def test_order_of_the_pair_turns_the_normal() -> None:
    terrain = body(slope(0.0), kind=STATIC)
    ball = body(Circle(radius=0.3), at=(0.0, 0.29))
    assert world(terrain, ball).contacts(REST)["normal"].tolist() == [[0.0, 1.0]]
    contacts = world(ball, terrain).contacts(REST)
    np.testing.assert_allclose(contacts["normal"], [(0.0, -1.0)], atol=0)
    np.testing.assert_allclose(contacts["point"], [(0.0, -0.005)], atol=1e-12)


VALLEY = Terrain(vertices=[(-5, 5), (0, 0), (5, 5)])
RIDGE = Terrain(vertices=[(-5, -5), (0, 0), (5, -5)])
DIAGONAL = 0.5**0.5


@pytest.mark.parametrize("shape", [Circle(radius=0.5), Capsule(half_length=0.3, radius=0.5)], ids=["circle", "capsule"])
def test_valley_touches_both_sides(shape: Shape) -> None:
    half = 0.3 if isinstance(shape, Capsule) else 0.0
    contacts = on(VALLEY, shape, 0.0, 0.5 / DIAGONAL + half).contacts(REST)
    assert len(contacts) == 2
    np.testing.assert_allclose(np.sort(contacts["normal"][:, 0]), [-DIAGONAL, DIAGONAL], atol=1e-12)
    np.testing.assert_allclose(contacts["separation"], 0.0, atol=1e-12)


def test_box_corner_in_a_valley() -> None:
    contacts = on(VALLEY, Box(half_extents=(0.4, 0.4)), 0.0, 0.8 * DIAGONAL, np.pi / 4).contacts(REST)
    deep = contacts[contacts["separation"] < 1e-9]
    np.testing.assert_allclose(np.unique(np.round(deep["normal"][:, 0], 9)), np.round([-DIAGONAL, DIAGONAL], 9))
    assert len(contacts) == 4  # the lowest corner on both sides, its neighbours on one each


def test_ridge_holds_a_ball_by_its_point() -> None:
    for x in (-0.2, 0.0, 0.1):
        y = np.sqrt(0.5**2 - x**2)
        contacts = on(RIDGE, Circle(radius=0.5), x, y).contacts(REST)
        assert len(contacts) == 1
        np.testing.assert_allclose(contacts["normal"][0], np.array([x, y]) / 0.5, atol=1e-12)
        np.testing.assert_allclose(contacts["point"][0], 0.0, atol=1e-12)


@pytest.mark.parametrize("tilt", [-0.3, 0.0, 0.2])
@pytest.mark.parametrize(
    "shape", [Box(half_extents=(1.0, 0.3)), Capsule(half_length=1.0, radius=0.3)], ids=["box", "capsule"]
)
def test_ridge_carries_a_beam(shape: Shape, tilt: float) -> None:
    up = np.array([-np.sin(tilt), np.cos(tilt)])
    contacts = on(RIDGE, shape, 0.3 * up[0], 0.3 * up[1], tilt).contacts(REST)
    assert len(contacts) == 1
    np.testing.assert_allclose(contacts["normal"][0], up, atol=1e-12)
    np.testing.assert_allclose(contacts["point"][0], 0.0, atol=1e-12)
    np.testing.assert_allclose(contacts["separation"][0], 0.0, atol=1e-12)


def test_box_over_a_cliff() -> None:
    cliff = Terrain(vertices=[(-5, 0), (0, 0), (0, -5), (5, -5)])
    contacts = on(cliff, Box(half_extents=(0.5, 0.5)), 0.2, 0.5).contacts(REST)
    np.testing.assert_allclose(np.sort(contacts["point"][:, 0]), [-0.3, 0.0], atol=1e-12)
    np.testing.assert_allclose(contacts["normal"], [(0.0, 1.0)] * 2, atol=1e-12)


@pytest.mark.parametrize("jitter", [-1e-4, 1e-4])
def test_rocking_box_over_a_cliff_keeps_both_points(jitter: float) -> None:
    cliff = Terrain(vertices=[(-5, 0), (0, 0), (0, -5), (5, -5)])
    contacts = on(cliff, Box(half_extents=(0.5, 0.5)), 0.2, 0.5, jitter).contacts(REST)
    assert len(contacts) == 2
    np.testing.assert_allclose(contacts["normal"], [(0.0, 1.0)] * 2, atol=1.1e-4)


def test_box_against_a_wall_of_the_chain() -> None:
    """A corner a little inside of the cliff goes out sideways, not over the top."""
    cliff = Terrain(vertices=[(-5, -5), (0, -5), (0, 0), (5, 0)])
    contacts = on(cliff, Box(half_extents=(0.5, 0.5)), -0.499, -2.0).contacts(REST)
    np.testing.assert_allclose(contacts["normal"], [(-1.0, 0.0)] * 2, atol=1e-12)
    np.testing.assert_allclose(contacts["separation"], [-0.001] * 2, atol=1e-12)


def test_a_smooth_hill_gives_no_sideways_kick() -> None:
    """Normals over a round polyline follow the circle that it approximates."""
    angles = np.linspace(2.0, 1.0, 101)
    for sign in (1.0, -1.0):  # hill and bowl
        turn = angles if sign > 0 else -angles
        points = 10.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        arrays = on(Terrain(vertices=points), Circle(radius=0.5), 0.0, 0.0)
        for t in np.linspace(1.2, 1.8, 301):
            radial = np.array([np.cos(sign * t), np.sin(sign * t)])
            arrays.bodies["position"][1] = (10.0 + sign * 0.499) * radial
            contacts = arrays.contacts(REST)
            assert 1 <= len(contacts) <= 2
            for normal in contacts["normal"]:
                assert abs(normal @ (sign * radial) - 1.0) < 1e-3


def test_wholly_behind_is_free() -> None:
    platform = Terrain(vertices=[(-5, 0), (5, 0)])
    for shape in (Circle(radius=0.5), Box(half_extents=(0.5, 0.5)), HEXAGON):
        assert len(on(platform, shape, 0.0, -1.2).contacts(REST)) == 0
        sunk = on(platform, shape, 0.0, -0.2).contacts(REST)
        assert len(sunk) >= 1
        np.testing.assert_allclose(sunk["normal"], np.tile((0.0, 1.0), (len(sunk), 1)), atol=1e-12)


def test_closed_cave_and_island() -> None:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    cave, island = Terrain(vertices=square, closed=True), Terrain(vertices=square[::-1], closed=True)
    inside = on(cave, Circle(radius=0.5), 0.5, -0.5).contacts(REST)
    np.testing.assert_allclose(sorted(map(tuple, inside["normal"])), [(-1.0, 0.0), (0.0, 1.0)], atol=1e-12)
    outside = on(island, Circle(radius=0.5), 1.499, 0.3).contacts(REST)
    np.testing.assert_allclose(outside["normal"], [(1.0, 0.0)], atol=1e-12)


def test_ends_of_a_chain_are_round_and_one_sided() -> None:
    platform = Terrain(vertices=[(-5, 0), (0, 0)])
    beside = on(platform, Circle(radius=0.5), 0.3, 0.4).contacts(REST)
    np.testing.assert_allclose(beside["normal"], [(0.6, 0.8)], atol=1e-12)
    assert len(on(platform, Circle(radius=0.5), 0.3, -0.4).contacts(REST)) == 0


def test_fast_ball_meets_the_slope_ahead() -> None:
    """At 10 m/s along the flat, the ramp is felt within the step in which it is reached."""
    ramp = Terrain(vertices=[(-20, 0), (0, 0), (10, 10)])
    arrays = on(ramp, Circle(radius=0.3), -0.3, 0.3)
    arrays.bodies["velocity"][1] = 10.0, 0.0, 0.0
    contacts = arrays.contacts(REST)
    assert sorted(np.round(contacts["normal"][:, 0], 6)) == [-0.707107, 0.0]
    hit = contacts[np.argmin(contacts["normal"][:, 0])]
    true = (np.array([-0.3, 0.3]) @ (-DIAGONAL, DIAGONAL)) - 0.3
    np.testing.assert_allclose(hit["separation"], true, atol=1e-12)


def test_moving_terrain_touches() -> None:
    lift = body(Terrain(vertices=[(-1, 0), (1, 0)]), kind=KINEMATIC, velocity=(0.0, 5.0, 0.0))
    contacts = world(lift, body(Circle(radius=0.2), at=(0.0, 0.25))).contacts(REST)
    np.testing.assert_allclose(contacts["separation"], [0.05], atol=1e-12)


def test_terrain_in_a_turned_body() -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        shape = [Circle(radius=0.4), Box(half_extents=(0.4, 0.3)), HEXAGON][rng.integers(3)]
        chain = Terrain(vertices=np.stack([np.linspace(-3, 3, 13), rng.normal(size=13) * 0.3], axis=1))
        x, y, angle = rng.uniform(-1, 1), rng.uniform(0.2, 0.8), rng.uniform(-2, 2)
        here = on(chain, shape, x, y, angle).contacts(REST)
        turn, shift = rng.uniform(-3, 3), rng.normal(size=2) * 5
        R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        there = world(
            body(chain, at=tuple(shift), angle=turn, kind=STATIC),
            body(shape, at=tuple(R @ (x, y) + shift), angle=angle + turn),
        ).contacts(REST)
        assert here["feature"].tolist() == there["feature"].tolist()
        np.testing.assert_allclose(here["normal"] @ R.T, there["normal"], atol=1e-9)
        np.testing.assert_allclose(here["point"] @ R.T + shift, there["point"], atol=1e-9)


def deepest(points: Array, chain: Array) -> float:
    """Least height of points over a chain that is a function of x, measured upwards."""
    return float((points[:, 1] - np.interp(points[:, 0], chain[:, 0], chain[:, 1])).min())


def test_random_ground_never_misses_an_overlap() -> None:
    """A box with a corner in the ground has a contact, one well above has none."""
    rng = np.random.default_rng(6)
    for _ in range(300):
        chain = np.stack([np.linspace(-3, 3, 13), rng.normal(size=13) * 0.2], axis=1)
        x, y, angle = rng.uniform(-1, 1), rng.uniform(0.0, 1.2), rng.uniform(-3, 3)
        c, s = np.cos(angle), np.sin(angle)
        t = np.linspace(-1, 1, 21)[:, None]
        ring = np.vstack([np.hstack([t, t * 0 + 1]), np.hstack([t, t * 0 - 1]), np.hstack([t * 0 + 1, t])])
        ring = np.vstack([ring, -ring]) * (0.5, 0.3)
        outline = ring @ np.array([[c, s], [-s, c]]) + (x, y)
        contacts = on(Terrain(vertices=chain), Box(half_extents=(0.5, 0.3)), x, y, angle).contacts(REST)
        height = deepest(outline, chain)
        if height < 0.0 and y - np.interp(x, *chain.T) > -0.25:  # else it may count as behind
            assert len(contacts) >= 1
            assert contacts["separation"].min() < 0.0
        if height > 0.02:
            assert len(contacts) == 0
        assert np.isfinite(contacts["point"]).all()
        pairs = list(zip(contacts["feature"], contacts["shape_b"], strict=True))
        assert len(set(pairs)) == len(pairs)
