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


def rolling(dim: int) -> World:
    """A lone ball that rolls away on a plane."""
    scene = Scene(dim=dim)
    ground: Any = planar.HalfPlane() if dim == 2 else spatial.Plane()
    ball: Any = planar.Circle(radius=0.1) if dim == 2 else spatial.Sphere(radius=0.1)
    scene.add_body("ground", "static", [ground])
    place, velocity = (0.0,) * (dim - 1) + (0.1,), (5.0,) + (0.0,) * (dim - 1)
    scene.add_body("ball", shapes=[ball], position=place, linear_velocity=velocity)
    return World(scene)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_lone_body_is_followed(dim: int) -> None:
    world = rolling(dim)
    renderer = make_renderer(world, 160, 120)
    path = []
    for _ in range(90):
        renderer.render()
        path.append(pixels(renderer, world)[1])
        world.step()
    assert world.position[0, 1, 0] > 5.0
    assert (np.array(path) > 10.0).all()
    assert (np.array(path) < (150.0, 110.0)).all()
    assert np.abs(np.diff(path[10:], axis=0)).max() < 1.0  # px a frame: no jumps once it is followed


def boxes(*centers: tuple[float, float]) -> tuple[Any, Any]:
    return np.array(centers) - 0.5, np.array(centers) + 0.5


def include(box: GrowingBox, *centers: tuple[float, float]) -> None:
    lows, highs = boxes(*centers)
    box.include(lows.min(axis=0), highs.max(axis=0), (lows, highs))


def shows(box: GrowingBox, center: tuple[float, float]) -> bool:
    return bool((box.low <= np.array(center)).all() and (np.array(center) <= box.high).all())


def test_one_that_leaves_alone_is_lost_and_the_others_stay() -> None:
    box = GrowingBox((-0.5, -0.5), (3.5, 0.5))
    for k in range(400):
        include(box, (0.0, 0.0), (3.0, -0.1 * k))
        assert shows(box, (0.0, 0.0))
    assert (box.high - box.low).max() <= 16.0
    assert not shows(box, (3.0, -39.9))


def test_of_two_that_part_the_slower_is_followed() -> None:
    box = GrowingBox((-0.5, -0.5), (3.5, 0.5))
    for k in range(400):
        before = box.low
        include(box, (-0.1 * k, 0.0), (3.0 + 0.2 * k, 0.0))
        assert shows(box, (-0.1 * k, 0.0))
        assert np.abs(box.low - before).max() <= 0.2 + 1e-9


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_box_moves_at_most_twice_as_fast_as_what_it_follows(sign: float) -> None:
    box = GrowingBox((-0.5, -0.5), (0.5, 0.5))
    for k in range(200):
        before = box.low, box.high
        include(box, (0.1 * sign * k, 0.0))
        assert max(np.abs(box.low - before[0]).max(), np.abs(box.high - before[1]).max()) <= 0.2 + 1e-9
        assert shows(box, (0.1 * sign * k, 0.0))
    np.testing.assert_allclose(box.high - box.low, (4.0, 1.0))


def test_walls_are_left_behind() -> None:
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("wall", "static", [planar.Box(half_extents=(1.0, 0.1))], position=(0.0, -1.0))
    scene.add_body("ball", shapes=[planar.Circle(radius=0.2)], linear_velocity=(3.0, 0.0))
    world = World(scene)
    renderer = make_renderer(world, 64, 48)
    for _ in range(30):
        renderer.render()
        world.step(10)
    assert (pixels(renderer, world)[1] < (64.0, 48.0)).all()
