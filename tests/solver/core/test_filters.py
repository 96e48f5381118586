"""Which shapes meet: category and mask bits, exclusions, joints, sensors, enabled flags."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, ContactSensor, HalfPlane, Weld

G = 9.81
AWAKE = Options(sleep=False)


def drop(ball: dict[str, Any], floor: dict[str, Any]) -> World:
    """A ball just above a floor."""
    scene = Scene()
    scene.add_body("floor", kind="static", shapes=[HalfPlane(**floor)])
    scene.add_body("ball", shapes=[Circle(radius=0.5, **ball)], position=(0, 0.5))
    return World(scene, options=AWAKE)


def falls(world: World, body: int = 1) -> bool:
    """Whether the body is in free fall after half a second, down to the last bits."""
    world.step(30)
    speed = world.linear_velocity[0, body, 1]
    assert abs(speed) < 1e-3 or speed == pytest.approx(-G / 2, rel=1e-12)
    return bool(speed < -1.0)


@pytest.mark.parametrize(
    ("ball", "floor", "meet"),
    [
        ({}, {}, True),
        ({"category": 2}, {"mask": 2}, True),
        ({"category": 2}, {"mask": 1}, False),
        ({"category": 2}, {"mask": 4}, False),
        ({"mask": 4}, {"category": 2}, False),  # both sides must agree
        ({"mask": 2}, {"category": 2, "mask": 1}, True),
        ({"category": 6, "mask": 8}, {"category": 8, "mask": 2}, True),  # one common bit is enough
        ({"category": 0}, {}, False),
        ({"mask": 0}, {}, False),
        ({"category": 1 << 63}, {"mask": 1 << 63}, True),  # the sign bit is a bit like any other
        ({"category": 1 << 63}, {"mask": (1 << 63) - 1}, False),
        ({"category": 1 << 40}, {"mask": -1}, True),
    ],
)
def test_category_and_mask(ball: dict[str, Any], floor: dict[str, Any], meet: bool) -> None:
    world = drop(ball, floor)
    assert falls(world) is not meet
    assert bool(world.diagnostics().pairs[0] > 0) is meet
    assert (len(world.contacts()) > 0) is meet


def test_filters_are_per_shape() -> None:
    # a cross: the long bar passes through the shelf, the short one rests on it
    scene = Scene()
    scene.add_body("shelf", kind="static", shapes=[Box(half_extents=(3, 0.1), category=2)], position=(0, -0.1))
    shapes = [Box(half_extents=(0.1, 1.0), mask=1), Box(half_extents=(0.5, 0.1))]
    scene.add_body("cross", shapes=shapes, position=(0, 0.1))
    world = World(scene, options=AWAKE)
    assert not falls(world)
    np.testing.assert_array_equal(np.unique(world.contacts().shape_b), 2)


def test_exclude() -> None:
    for pair in (("floor", "ball"), ("ball", "floor"), (0, 1)):
        scene = Scene()
        scene.add_body("floor", kind="static", shapes=[HalfPlane()])
        scene.add_body("ball", shapes=[Circle(radius=0.5)], position=(0, 0.5))
        scene.add_body("other", shapes=[Circle(radius=0.5)], position=(5, 0.5))
        scene.exclude(*pair)
        world = World(scene, options=AWAKE)
        assert falls(world)
        assert abs(world.linear_velocity[0, 2, 1]) < 1e-3
        assert world.diagnostics().pairs[0] == 1


def overlapping(**given: Any) -> World:
    scene = Scene(gravity=(0, 0))
    for k in range(2):
        scene.add_body(f"disk_{k}", shapes=[Circle(radius=0.5)], position=(0.6 * k, 0))
    if given.pop("joined", True):
        scene.add_joint("weld", Weld("disk_0", "disk_1", **given))
    return World(scene, options=AWAKE)


def test_jointed_bodies_do_not_collide() -> None:
    world = overlapping()
    world.step(30)
    assert len(world.contacts()) == 0
    np.testing.assert_allclose(world.position[0, :, 0], (0, 0.6), atol=1e-9)


def test_jointed_bodies_collide_on_request() -> None:
    world = overlapping(collide=True)
    world.step()
    assert len(world.contacts()) == 1
    free = overlapping(joined=False)
    free.step(60)
    assert free.position[0, 1, 0] - free.position[0, 0, 0] > 0.95


def test_a_disabled_joint_still_keeps_its_bodies_apart_from_contacts() -> None:
    world = overlapping(enabled=False)
    world.step(30)
    np.testing.assert_allclose(world.position[0, :, 0], (0, 0.6), atol=1e-12)


@pytest.mark.parametrize("on", ["ball", "floor"])
def test_sensor_shapes_report_and_push_nothing(on: str) -> None:
    scene = Scene()
    plane = Box(half_extents=(3, 0.5), sensor=on == "floor")
    scene.add_body("floor", kind="static", shapes=[plane], position=(0, -0.5))
    ball = Circle(radius=0.5, sensor=on == "ball")
    scene.add_body("ball", shapes=[ball], position=(0, 1.0), mass=1.0, inertia=1.0)
    scene.add_sensor("touch", ContactSensor("ball"))
    world = World(scene, options=AWAKE)
    seen = []
    for _ in range(40):
        # contacts are those at the start of the step
        overlap = -1.5 < world.position[0, 1, 1] < 0.5
        world.step()
        contacts = world.contacts()
        assert (len(contacts) > 0) == overlap
        assert contacts.sensor.all()
        assert not contacts.impulse.any()
        assert world.sensor("touch")[0, 0] == overlap
        assert not world.sensor("touch")[0, 1:].any()
        seen.append(overlap)
        assert world.diagnostics().rows[0] == 0
        assert world.diagnostics().penetration[0] == 0.0
    assert any(seen)
    assert not all(seen)
    t = world.time[0]
    assert world.position[0, 1, 1] == pytest.approx(1 - 0.5 * G * t**2, rel=1e-12)


def test_sensors_do_not_join_islands() -> None:
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    for k in range(2):
        zone = Circle(radius=3.0, sensor=True)
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5)), zone], position=(2.0 * k, 0.5))
    world = World(scene, options=AWAKE)
    world.step()
    assert world.diagnostics().islands[0] == 2
    assert world.contacts().sensor.sum() > 0


def test_disabled_bodies_meet_nothing() -> None:
    scene = Scene()
    scene.add_body("floor", kind="static", shapes=[Box(half_extents=(3, 0.5))], position=(0, -0.5), enabled=False)
    scene.add_body("ball", shapes=[Circle(radius=0.5)], position=(0, 0.5))
    world = World(scene, world_count=2, options=AWAKE)
    world.parameters.set("floor", enabled=True, worlds=1)
    world.step(30)
    np.testing.assert_allclose(world.linear_velocity[:, 1, 1], (-G / 2, 0), atol=1e-3)
    np.testing.assert_array_equal(world.diagnostics().contacts, (0, 1))
