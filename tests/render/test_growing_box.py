"""Automatic cameras keep what moves in the picture, without jumps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.render import make_renderer
from gsenv.render.camera import Camera
from gsenv.render.growing_box import GrowingBox
from gsenv.solver import Scene, World, planar, spatial


def flying(dim: int, speed: float) -> World:
    """A ball that flies away from another, without gravity."""
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    ball: Any = planar.Circle(radius=0.5) if dim == 2 else spatial.Sphere(radius=0.5)
    scene.add_body("here", shapes=[ball], position=(-1.0,) + (0.0,) * (dim - 1))
    velocity = (speed,) + (0.0,) * (dim - 1)
    scene.add_body("away", shapes=[ball], position=(1.0,) + (0.0,) * (dim - 1), linear_velocity=velocity)
    return World(scene)


def pixels(renderer: Any, world: World) -> Any:
    places = world.position[0]
    if world.model.dim == 2:
        return renderer.camera.to_pixel(places, renderer.width, renderer.height)
    return renderer.camera.to_pixel(places)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_that_leaves_stays_in_the_picture(dim: int) -> None:
    world = flying(dim, 2.0)
    renderer = make_renderer(world, 64, 48)
    renderer.render()
    seen = [pixels(renderer, world)]
    for _ in range(150):
        world.step()
        renderer.render()
        seen.append(pixels(renderer, world))
    path = np.array(seen)
    assert ((path >= 0.0) & (path <= (64.0, 48.0))).all()
    assert world.position[0, 1, 0] > 5.9
    assert np.abs(np.diff(path, axis=0)).max() < 1.5  # px a frame: no jumps


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_that_is_gone_for_good_does_not_shrink_the_others_to_nothing(dim: int) -> None:
    world = flying(dim, 1000.0)
    renderer = make_renderer(world, 64, 48)
    renderer.render()
    before = np.ptp(pixels(renderer, world)[:, 0])
    for _ in range(20):
        world.step()
        renderer.render()
    world.set_pose("away", position=(1.0,) + (0.0,) * (dim - 1))
    assert np.ptp(pixels(renderer, world)[:, 0]) > before / 8.0


def test_small_motions_and_given_cameras_change_nothing() -> None:
    world = flying(2, 0.05)
    renderer = make_renderer(world, 64, 48)
    renderer.render()
    fitted = renderer.camera
    world.step(30)
    renderer.render()
    assert renderer.camera is fitted
    renderer.camera = Camera((0.0, 0.0), 5.0)
    world.step(6000)
    renderer.render()
    assert renderer.camera == Camera((0.0, 0.0), 5.0)


def test_the_box_grows_by_what_is_outside_and_never_shrinks() -> None:
    box = GrowingBox((0, 0), (10, 1))
    assert not box.include((-0.8, 0), (10.8, 1.8))
    assert box.include((-1.8, 0), (10, 1))
    np.testing.assert_allclose(box.low, (-1, 0))
    assert not box.include((0, 0), (10, 1))
    assert box.include((0, -1e9), (np.inf, 1))
    np.testing.assert_allclose((box.low, box.high), ((-1, -15), (25, 1)))
