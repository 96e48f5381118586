"""Speculative and predicted contacts: a stop where there is a hit, nothing where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon, Shape, Terrain
from gsenv.solver.records.model import Array
from tests.solver.planar.narrowphase.collision import DYNAMIC, GRAVITY, KINEMATIC, STATIC, TIMESTEP, Arrays, body, world

REST = np.zeros(2)
BLOCK = body(Box(half_extents=(0.5, 0.5)), kind=STATIC)


def allowed(contacts: Array, velocity: Array, body_b: int = 1) -> bool:
    """True if a body that keeps this velocity breaks no contact."""
    for contact in contacts:
        sign = 1.0 if contact["body_b"] == body_b else -1.0
        if sign * contact["normal"] @ velocity < -contact["separation"] / TIMESTEP - 1e-9:
            return False
    return True


def flying(shape: Shape, x: float, y: float, vx: float, vy: float, spin: float = 0.0, angle: float = 0.0) -> Arrays:
    return world(BLOCK, body(shape, at=(x, y), velocity=(vx, vy, spin), angle=angle))


@pytest.mark.parametrize("speed", [5.0, 20.0, 100.0])
@pytest.mark.parametrize("shape", [Circle(radius=0.1), Box(half_extents=(0.1, 0.1))], ids=["ball", "box"])
def test_passing_over_a_corner(shape: Shape, speed: float) -> None:
    """1 cm above the top of the block: free at every place on the way."""
    for x in np.linspace(-1.5, 0.6, 40):
        contacts = flying(shape, x, 0.61, speed, 0.0).contacts(REST)
        assert allowed(contacts, np.array([speed, 0.0])), x


@pytest.mark.parametrize("direction", [0.3, -0.3, -1.0])
def test_passing_a_corner_obliquely(direction: float) -> None:
    velocity = 20.0 * np.array([np.cos(direction), np.sin(direction)])
    side = np.array([-np.sin(direction), np.cos(direction)])
    corner = np.array([-0.5, 0.5]) if direction > -0.9 else np.array([0.5, 0.5])
    for t in np.linspace(-1.0, 1.0, 30):
        start = corner + side * 0.11 + t * velocity / 20.0
        if direction < 0.0 and direction > -0.9 and t > -0.1:
            continue  # would meet the top face behind the corner
        contacts = flying(Circle(radius=0.1), *start, *velocity).contacts(REST)
        assert allowed(contacts, velocity) or direction < 0.0


@pytest.mark.parametrize(
    "shape",
    [Circle(radius=0.1), Box(half_extents=(0.1, 0.1)), Capsule(half_length=0.1, radius=0.05)],
    ids=["ball", "box", "capsule"],
)
@pytest.mark.parametrize("speed", [3.0, 20.0, 200.0])
def test_a_hit_is_stopped_at_the_surface(shape: Shape, speed: float) -> None:
    """Moved by the greatest velocity that the contacts allow, the shape just touches."""
    reach = 0.15 if isinstance(shape, Capsule) else 0.1
    for gap in np.linspace(0.001, 0.9 * speed * TIMESTEP, 7):
        contacts = flying(shape, -0.5 - reach - gap, 0.2, speed, 0.0).contacts(REST)
        assert len(contacts) >= 1
        np.testing.assert_allclose(contacts["normal"], np.tile((-1.0, 0.0), (len(contacts), 1)), atol=1e-9)
        np.testing.assert_allclose(contacts["separation"], gap, atol=1e-9)


def test_what_is_out_of_reach_is_no_contact() -> None:
    contacts = flying(Circle(radius=0.1), -1.2, 0.2, 0.5 / TIMESTEP, 0.0).contacts(REST)
    assert len(contacts) == 0
    assert len(flying(Circle(radius=0.1), -1.2, 0.2, -0.7 / TIMESTEP, 0.0).contacts(REST)) == 0


def test_corner_meets_corner_in_flight() -> None:
    """Two boxes that come together diagonally: the true face of first contact, at the true time."""
    speed = 30.0
    for offset, normal in ((0.05, (-1.0, 0.0)), (-0.05, (0.0, 1.0))):
        contacts = flying(Box(half_extents=(0.2, 0.2)), -0.9, 0.9 - offset, speed, -speed).contacts(REST)
        assert len(contacts) >= 1
        np.testing.assert_allclose(contacts["normal"], np.tile(normal, (len(contacts), 1)), atol=1e-9)
        gap = 0.2 if normal[0] else 0.2 - offset
        np.testing.assert_allclose(contacts["separation"], gap, atol=2e-3)


def test_sliding_box_does_not_stumble_over_level_neighbours() -> None:
    tiles = [body(Box(half_extents=(0.5, 0.5)), at=(float(k), -0.5), kind=STATIC) for k in range(-2, 3)]
    for speed in (0.5, 5.0, 30.0):
        for sink in (0.0, 1e-5, 1e-4):
            for x in np.linspace(-1.5, 1.5, 61):
                slider = body(Box(half_extents=(0.2, 0.2)), at=(x, 0.2 - sink), velocity=(speed, 0.0, 0.0))
                contacts = world(*tiles, slider).contacts(REST)
                assert len(contacts) >= 2
                assert np.abs(contacts["normal"][:, 0]).max() < 1e-9, (speed, sink, x)


def test_points_of_predicted_contacts_keep_the_lever_arm() -> None:
    contacts = flying(Box(half_extents=(0.1, 0.1)), -2.0, 0.2, 200.0, 0.0).contacts(REST)
    np.testing.assert_allclose(contacts["point"][:, 0], -1.9, atol=1e-6)
    np.testing.assert_allclose(np.sort(contacts["point"][:, 1]), [0.1, 0.3], atol=1e-9)


def test_two_moving_bodies() -> None:
    left = body(Circle(radius=0.5), at=(-3.0, 0.0), velocity=(100.0, 0.0, 0.0))
    right = body(Circle(radius=0.5), at=(3.0, 0.0), velocity=(-250.0, 0.0, 0.0))
    contacts = world(left, right).contacts(REST)
    np.testing.assert_allclose(contacts["normal"], [(1.0, 0.0)], atol=1e-12)
    np.testing.assert_allclose(contacts["separation"], [5.0], atol=1e-9)
    side = body(Circle(radius=0.5), at=(3.0, 1.02), velocity=(-250.0, 0.0, 0.0))
    assert len(world(left, side).contacts(REST)) == 0


def test_gravity_and_force_are_foreseen() -> None:
    """A small ball at rest above the floor is caught within one long step."""
    for timestep in (1 / 60, 1 / 10):
        fall = 9.81 * timestep**2
        ball = body(Circle(radius=0.01), at=(0.0, 0.01 + 0.9 * fall))
        arrays = world(body(HalfPlane(), kind=STATIC), ball, with_vertices=False)
        assert len(arrays.contacts(GRAVITY, timestep)) == 1
        arrays = world(body(HalfPlane(), kind=STATIC), ball, with_vertices=False)
        mass = arrays.body_parameters["mass"][1]
        arrays.bodies["force"][1] = 0.0, -9.81 * mass, 0.0
        assert len(arrays.contacts(REST, timestep)) == 1


def test_a_spinning_rod_reaches_the_floor() -> None:
    rod = body(Box(half_extents=(0.5, 0.02)), at=(0.0, 0.3), velocity=(0.0, 0.0, -40.0))
    contacts = world(body(HalfPlane(), kind=STATIC), rod, with_vertices=False).contacts(REST)
    assert len(contacts) >= 1
    ball = body(Circle(radius=0.2), at=(0.0, 0.3), velocity=(0.0, 0.0, -400.0))
    assert len(world(body(HalfPlane(), kind=STATIC), ball, with_vertices=False).contacts(REST)) == 0


def test_kinematic_pusher_is_foreseen() -> None:
    pusher = body(Box(half_extents=(0.5, 0.5)), velocity=(60.0, 0.0, 0.0), kind=KINEMATIC)
    contacts = world(pusher, body(Circle(radius=0.1), at=(1.2, 0.0))).contacts(REST)
    np.testing.assert_allclose(contacts["separation"], [0.6], atol=1e-9)


def test_polygons_are_foreseen_too() -> None:
    wedge = Polygon(vertices=[(-0.2, -0.1), (0.2, -0.1), (0.0, 0.2)])
    contacts = flying(wedge, -2.0, 0.3, 120.0, 0.0).contacts(REST)
    np.testing.assert_allclose(contacts["normal"], np.tile((-1.0, 0.0), (len(contacts), 1)), atol=1e-9)
    assert contacts["separation"].min() == pytest.approx(1.3)
    assert allowed(flying(wedge, -2.0, 0.61, 120.0, 0.0).contacts(REST), np.array([120.0, 0.0]))


def test_terrain_hit_far_ahead() -> None:
    ground = body(Terrain(vertices=[(-50, 0), (0, 0), (0.001, 5), (50, 5)]), kind=STATIC)
    ball = body(Circle(radius=0.2), at=(-3.2, 1.0), velocity=(240.0, 0.0, 0.0), kind=DYNAMIC)
    contacts = world(ground, ball).contacts(REST)
    wall = contacts[contacts["normal"][:, 0] < -0.5]
    np.testing.assert_allclose(wall["separation"], [3.0], atol=1e-3)
    assert allowed(contacts[contacts["normal"][:, 0] >= -0.5], np.array([240.0, 0.0]))
