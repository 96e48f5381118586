"""Round trips, fitting, and the follow camera's motion."""

import numpy as np
import pytest

from gsenv.render.camera import Bounds, Camera, FollowCamera

WIDTH, HEIGHT = 640, 480


def test_pixels_and_metres_round_trip() -> None:
    camera = Camera((3.0, -2.0), 7.5)
    points = np.random.default_rng(0).normal(size=(50, 2)) * 20.0
    pixels = camera.to_pixel(points, WIDTH, HEIGHT)
    np.testing.assert_allclose(camera.to_world(pixels, WIDTH, HEIGHT), points, atol=1e-12)


def test_pixel_axes() -> None:
    camera = Camera((3.0, -2.0), 8.0)
    np.testing.assert_allclose(camera.to_pixel((3.0, -2.0), WIDTH, HEIGHT), (320.0, 240.0))
    np.testing.assert_allclose(camera.to_pixel((4.0, -1.0), WIDTH, HEIGHT), (380.0, 180.0))
    np.testing.assert_allclose(camera.to_world((0.0, 0.0), WIDTH, HEIGHT)[1], 2.0)


@pytest.mark.parametrize("bounds", [Bounds(-1, -2, 9, 1), Bounds(0, 0, 1, 20), Bounds(2, 2, 2, 2)])
def test_fit_shows_everything_with_the_margin_and_no_more(bounds: Bounds) -> None:
    camera = Camera.fit(bounds, WIDTH, HEIGHT, margin=0.1)
    corners = np.array([(bounds.left, bounds.top), (bounds.right, bounds.bottom)])
    (left, top), (right, bottom) = camera.to_pixel(corners, WIDTH, HEIGHT)
    gaps = np.array([left, WIDTH - right, top, HEIGHT - bottom]) / (WIDTH, WIDTH, HEIGHT, HEIGHT)
    assert gaps.min() >= 0.1 - 1e-9
    if bounds.right > bounds.left:
        assert gaps.min() == pytest.approx(0.1)


def follow(times: np.ndarray, **options: float) -> np.ndarray:
    """Camera centres for a body that jumps around on a polyline with corners at whole seconds."""
    camera = FollowCamera([0], smooth_time=options.get("smooth_time", 0.4))
    corners = np.array([(0.0, 0.0), (4.0, 1.0), (3.0, 5.0), (9.0, 5.0), (9.0, 0.0)])
    path = np.stack([np.interp(times, np.arange(5), corners[:, k]) for k in (0, 1)], axis=1)
    return np.array([camera.update(p[None], t, WIDTH, HEIGHT).center for p, t in zip(path, times, strict=True)])


def test_the_frame_rate_does_not_change_the_path() -> None:
    slow, fast = follow(np.linspace(0.0, 4.0, 41)), follow(np.linspace(0.0, 4.0, 241))
    np.testing.assert_allclose(slow, fast[::6], atol=1e-9)


def test_a_step_is_followed_without_overshoot() -> None:
    camera = FollowCamera([0], smooth_time=0.5)
    camera.update(np.zeros((1, 2)), 0.0, WIDTH, HEIGHT)
    centers = []
    for t in np.linspace(1e-6, 5.0, 500):
        centers.append(camera.update(np.array([[2.0, 0.0]]), t, WIDTH, HEIGHT).center[0])
    path = np.array(centers)
    assert (np.diff(path) > -1e-12).all()
    assert path[0] < 0.01
    assert path.max() <= 2.0 + 1e-9
    assert path[-1] == pytest.approx(2.0, abs=1e-4)


def test_the_lag_behind_a_steady_target_is_the_smooth_time() -> None:
    camera = FollowCamera([0], smooth_time=0.4)
    for t in np.linspace(0.0, 10.0, 600):
        center = camera.update(np.array([[3.0 * t, 0.0]]), t, WIDTH, HEIGHT).center
    assert 30.0 - center[0] == pytest.approx(3.0 * 0.4, rel=1e-3)


def test_resets_jump_and_repeats_stay() -> None:
    camera = FollowCamera([1])
    here, there = np.array([[9.0, 9.0], [0.0, 0.0]]), np.array([[9.0, 9.0], [5.0, 0.0]])
    camera.update(here, 0.0, WIDTH, HEIGHT)
    moving = camera.update(there, 0.1, WIDTH, HEIGHT)
    assert 0.0 < moving.center[0] < 5.0
    assert camera.update(there, 0.1, WIDTH, HEIGHT) == moving
    assert camera.update(here, 0.1, WIDTH, HEIGHT).center == (0.0, 0.0)
    camera.update(there, 0.2, WIDTH, HEIGHT)
    assert camera.update(here, 0.0, WIDTH, HEIGHT).center == (0.0, 0.0)


def test_zero_smooth_time_locks() -> None:
    times = np.linspace(0.0, 4.0, 9)
    np.testing.assert_allclose(follow(times, smooth_time=0.0)[4], (3.0, 5.0))


def test_all_followed_bodies_stay_in_view() -> None:
    camera = FollowCamera([0, 2], height=2.0, margin=1.0)
    positions = np.array([(-10.0, 0.0), (99.0, 99.0), (10.0, 3.0)])
    view = camera.update(positions, 0.0, WIDTH, HEIGHT)
    pixels = view.to_pixel(positions[[0, 2]], WIDTH, HEIGHT)
    assert (pixels > 0.0).all()
    assert (pixels < (WIDTH, HEIGHT)).all()
    np.testing.assert_allclose(view.center, (0.0, 1.5))
