"""3D cameras."""

from typing import Any

import numpy as np
import pytest

from gsenv.render.spatial.camera import SpatialCamera


def test_target_is_in_the_middle_and_scale_is_the_field_of_view() -> None:
    camera = SpatialCamera((3.0, -4.0, 2.0), (0.0, 0.0, 0.0), width=200, height=100, fov=np.radians(60.0))
    np.testing.assert_allclose(camera.to_pixel((0.0, 0.0, 0.0)), (100.0, 50.0))
    right, up, forward = camera.axes()
    at = np.array(camera.eye) + 2.0 * forward + 2.0 * np.tan(np.radians(30.0)) * up
    np.testing.assert_allclose(camera.to_pixel(at), (100.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(np.stack([right, up, forward]) @ np.stack([right, up, forward]).T, np.eye(3), atol=1e-12)
    assert up[2] > 0.0
    assert np.isnan(camera.to_pixel(np.array(camera.eye) - forward)).all()


@pytest.mark.parametrize("elevation", [-0.3, 0.4, 1.2, np.pi / 2])
@pytest.mark.parametrize("size", [(640, 480), (84, 84), (100, 400)])
def test_bounds_fill_the_picture_up_to_its_margin(size: tuple[int, int], elevation: float) -> None:
    lower, upper = np.array([-1.0, 2.0, 0.0]), np.array([3.0, 2.5, 7.0])
    camera = SpatialCamera.look_at_bounds(lower, upper, *size, azimuth=0.7, elevation=elevation, margin=0.1)
    corners = np.array([[x, y, z] for x in (-1, 3) for y in (2, 2.5) for z in (0, 7)])
    part = camera.to_pixel(corners) / size
    assert part.min() == pytest.approx(0.1, abs=1e-6) or part.max() == pytest.approx(0.9, abs=1e-6)
    assert part.min() > 0.1 - 1e-6
    assert part.max() < 0.9 + 1e-6


def test_following_keeps_direction_and_distance() -> None:
    camera = SpatialCamera((3.0, -4.0, 2.0), (0.0, 1.0, 0.0))
    moved = camera.following((10.0, 0.0, 5.0))
    np.testing.assert_allclose(np.subtract(moved.eye, moved.target), np.subtract(camera.eye, camera.target))
    np.testing.assert_allclose(moved.target, (10.0, 0.0, 5.0))


def test_looking_straight_down_works() -> None:
    axes = np.stack(SpatialCamera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)).axes())
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"eye": (0.0, 0.0, 0.0)}, "must differ"),
        ({"eye": (np.nan, 0.0, 0.0)}, "eye must be three finite numbers"),
        ({"target": (0.0, 1.0)}, "target must be three finite numbers"),
        ({"up": (0.0, 0.0, 0.0)}, "up must not be zero"),
        ({"fov": 4.0}, "fov must be between"),
        ({"width": 0}, "at least 1 px"),
    ],
)
def test_bad_cameras_get_one_sentence(change: dict[str, Any], message: str) -> None:
    camera = SpatialCamera((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))._replace(**change)
    with pytest.raises(ValueError, match=message):
        camera.axes()


def test_bad_bounds_get_one_sentence() -> None:
    with pytest.raises(ValueError, match="lower <= upper"):
        SpatialCamera.look_at_bounds((0.0, 0.0, 1.0), (1.0, 1.0, 0.0))
