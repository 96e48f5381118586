"""Where joints and contacts are shown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World, planar, spatial
from gsenv.view.readings import read_contacts, read_joints

UP, ALONG = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def two_boxes() -> tuple[Scene, Any, Any]:
    scene = Scene(dim=3)
    base = scene.add_body("base", shapes=[spatial.Box(half_extents=(0.5, 0.5, 0.5))], position=(0, 0, 1))
    arm = scene.add_body("arm", shapes=[spatial.Box(half_extents=(0.5, 0.1, 0.1))], position=(1, 0, 1))
    return scene, base, arm


@pytest.mark.parametrize("kind", [spatial.Hinge, spatial.Slider])
def test_axes_of_3d_joints(kind: Any) -> None:
    scene, base, arm = two_boxes()
    axis = np.array([0.0, 0.6, 0.8])
    scene.add_joint("joint", kind(base, arm, anchor=(0.5, 0, 1), axis=tuple(axis)))
    world = World(scene)
    world.set_velocity("arm", angular=(0.0, 1.0, 2.0))
    world.step(20)
    places = read_joints(world, 0)
    assert places.slides.tolist() == [kind is spatial.Slider]
    turned = world.orientation[0, 0]
    w, u = turned[0], turned[1:]
    expected = axis + 2.0 * w * np.cross(u, axis) + 2.0 * np.cross(u, np.cross(u, axis))
    np.testing.assert_allclose(np.abs(places.axes @ expected), 1.0, atol=1e-3)
    assert len(places.anchors) == 1


def test_a_universal_joint_has_two_axes_and_a_ball_none() -> None:
    scene, base, arm = two_boxes()
    scene.add_joint("joint", spatial.Universal(base, arm, anchor=(0.5, 0, 1), axis_a=(0, 1, 0), axis_b=(0, 0, 1)))
    places = read_joints(World(scene), 0)
    assert len(places.axes) == 2
    np.testing.assert_allclose(np.abs(places.axes), [[0, 1, 0], [0, 0, 1]], atol=1e-9)
    scene, base, arm = two_boxes()
    scene.add_joint("joint", spatial.Ball(base, arm, anchor=(0.5, 0, 1)))
    places = read_joints(World(scene), 0)
    assert len(places.axes) == 0
    np.testing.assert_allclose(places.anchors, [[0.5, 0, 1]])


def test_2d_joints_and_their_directions() -> None:
    scene = Scene(dim=2)
    boxes = [scene.add_body(f"box_{k}", position=(k, 0), shapes=[planar.Circle(radius=0.2)]) for k in range(3)]
    scene.add_joint("slide", planar.Prismatic(boxes[0], boxes[1], anchor=(1, 0), axis=(0, 1)))
    scene.add_joint("rod", planar.Distance(boxes[1], boxes[2], anchor_a=(0, 0), anchor_b=(0, 0)))
    world = World(scene, 2)
    places = read_joints(world, 1)
    np.testing.assert_allclose(places.axes, [[0, 1]])
    np.testing.assert_allclose(places.links, [[[1, 0], [2, 0]]])
    np.testing.assert_allclose(places.anchors, [[1, 0]])
    np.testing.assert_allclose(places.radii, [0.2])
    world.parameters.set("box_2", enabled=False, worlds=[1])
    assert len(read_joints(world, 1).links) == 0
    assert len(read_joints(world, 0).links) == 1


def test_contact_forces_carry_the_weight() -> None:
    scene = Scene(dim=3)
    scene.add_body("ground", kind="static", shapes=[spatial.Plane()])
    scene.add_body("box", shapes=[spatial.Box(half_extents=(0.5, 0.5, 0.5))], position=(0, 0, 0.5), mass=2.0)
    world = World(scene)
    world.step(60)
    points, forces = read_contacts(world, 0)
    np.testing.assert_allclose(forces.sum(axis=0), (0, 0, 2.0 * 9.81), atol=0.05)
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-3)
