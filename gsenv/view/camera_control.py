"""Views that the mouse moves: changes on top of a camera, which may itself follow a body.

Both classes have the same methods. `aim(base, size)` returns the camera for a picture; the other methods move it, or
refer to its picture's pixels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Camera
from gsenv.render.spatial.camera import SpatialCamera

FloatArray = NDArray[np.float64]
Pixel = tuple[float, float]
Size = tuple[int, int]

ZOOM_LIMITS = (1e-3, 1e3)
STEEPEST = math.radians(89.0)
TURN = math.radians(0.4)  # per px of the mouse
NOTCH = 0.85  # factor of the view's size for one notch of the wheel


class PlanarControl:
    """Pan and zoom over a 2D camera."""

    def __init__(self) -> None:
        self._base = Camera()
        self._size: Size = (1, 1)
        self.reset()

    def reset(self) -> None:
        """Show what the base camera shows."""
        self._offset = np.zeros(2)
        self._zoom = 1.0
        self.aim(self._base, self._size)

    def aim(self, base: Camera, size: Size) -> Camera:
        """Return the camera for a picture of this size in px."""
        self._base = base
        x, y = np.asarray(base.center) + self._offset
        self._camera = Camera((float(x), float(y)), base.height * self._zoom)
        self._size = size
        return self._camera

    def rebase(self, old: Camera, new: Camera) -> None:
        """Keep the present view when the base camera is replaced."""
        self._offset = np.asarray(self._camera.center) - new.center
        self._zoom *= old.height / new.height

    def turn(self, dx: float, dy: float) -> None:
        """Pan: 2D has no orbit."""
        self.pan(dx, dy)

    def pan(self, dx: float, dy: float) -> None:
        """Move the picture by px."""
        scale = self._camera.scale(self._size[1])
        self._offset += np.array([-dx, dy]) / scale
        self.aim(self._base, self._size)

    def zoom(self, notches: float, pixel: Pixel) -> None:
        """Magnify by notches of the wheel; what is at the pixel stays there."""
        zoom = float(np.clip(self._zoom * NOTCH**notches, *ZOOM_LIMITS))
        point = self._camera.to_world(pixel, *self._size)
        self._offset += (1.0 - zoom / self._zoom) * (point - self._camera.center)
        self._zoom = zoom
        self.aim(self._base, self._size)

    def project(self, points: FloatArray) -> FloatArray:
        """Return pixels (..., 2) of points (..., 2) in m."""
        return self._camera.to_pixel(points, *self._size)

    def ray(self, pixel: Pixel) -> tuple[FloatArray, FloatArray]:
        """Return the point in m under a pixel, and the direction into the picture, which 2D does not have."""
        return self._camera.to_world(pixel, *self._size), np.zeros(2)

    def on_plane(self, pixel: Pixel, through: FloatArray) -> FloatArray:
        """Return the point in m under a pixel, in the plane parallel to the picture `through` a point."""
        return self._camera.to_world(pixel, *self._size)

    @property
    def view_height(self) -> float:
        """m, height of what the picture shows"""
        return self._camera.height


class OrbitControl:
    """Orbit, pan and zoom over a 3D camera."""

    def __init__(self) -> None:
        self._base = SpatialCamera((0.0, -1.0, 0.0), (0.0, 0.0, 0.0))
        self._size: Size = (1, 1)
        self.reset()

    def reset(self) -> None:
        """Show what the base camera shows."""
        self._offset = np.zeros(3)
        self._azimuth = self._elevation = 0.0
        self._zoom = 1.0
        self.aim(self._base, self._size)

    def aim(self, base: SpatialCamera, size: Size) -> SpatialCamera:
        """Return the camera for a picture of this size in px."""
        self._base, self._size = base, size
        target = np.asarray(base.target, float)
        away = np.asarray(base.eye, float) - target
        distance, azimuth, elevation = _spherical(away)
        highest = max(abs(elevation), STEEPEST)  # a base camera may look straight down
        whole = min(max(elevation + self._elevation, -highest), highest)
        self._elevation = whole - elevation
        if self._azimuth or self._elevation or self._zoom != 1.0:
            away = _direction(azimuth + self._azimuth, whole) * (distance * self._zoom)
        target = target + self._offset
        self._camera = base._replace(eye=target + away, target=target, width=size[0], height=size[1])
        return self._camera

    def rebase(self, old: SpatialCamera, new: SpatialCamera) -> None:
        """Keep the present view when the base camera is replaced."""
        (distance, azimuth, elevation), (r, a, e) = (_spherical(_away(camera)) for camera in (old, new))
        self._azimuth += azimuth - a
        self._elevation += elevation - e
        self._zoom *= distance / r
        self._offset = np.asarray(self._camera.target) - np.asarray(new.target, float)

    def turn(self, dx: float, dy: float) -> None:
        """Orbit about the target by px of the mouse: what is in front follows it."""
        self._azimuth -= TURN * dx
        self._elevation += TURN * dy
        self.aim(self._base, self._size)

    def pan(self, dx: float, dy: float) -> None:
        """Move the picture by px, at the depth of the target."""
        right, up, _ = self._camera.axes()
        scale = self.view_height / self._camera.height
        self._offset += scale * (dy * up - dx * right)
        self.aim(self._base, self._size)

    def zoom(self, notches: float, pixel: Pixel) -> None:
        """Magnify by notches of the wheel; what is at the pixel, at the depth of the target, stays there."""
        zoom = float(np.clip(self._zoom * NOTCH**notches, *ZOOM_LIMITS))
        target = np.asarray(self._camera.target, float)
        point = self.on_plane(pixel, target)
        self._offset += (1.0 - zoom / self._zoom) * (point - target)
        self._zoom = zoom
        self.aim(self._base, self._size)

    def project(self, points: FloatArray) -> FloatArray:
        """Return pixels (..., 2) of points (..., 3) in m; NaN behind the eye."""
        return self._camera.to_pixel(points)

    def ray(self, pixel: Pixel) -> tuple[FloatArray, FloatArray]:
        """Return the eye in m and the direction (unit) of the ray through a pixel."""
        right, up, forward = self._camera.axes()
        step = 2.0 * math.tan(0.5 * self._camera.fov) / self._camera.height
        across = (pixel[0] - 0.5 * self._camera.width) * step
        above = (0.5 * self._camera.height - pixel[1]) * step
        way = forward + across * right + above * up
        return np.asarray(self._camera.eye, float), way / np.sqrt(way @ way)

    def on_plane(self, pixel: Pixel, through: FloatArray) -> FloatArray:
        """Return the point in m under a pixel, in the plane parallel to the picture `through` a point."""
        eye, way = self.ray(pixel)
        forward = self._camera.axes()[2]
        return np.asarray(eye + way * (((through - eye) @ forward) / (way @ forward)))

    @property
    def view_height(self) -> float:
        """m, height of what the picture shows at the depth of the target"""
        away = _away(self._camera)
        return float(2.0 * np.sqrt(away @ away) * math.tan(0.5 * self._camera.fov))


Control = PlanarControl | OrbitControl


def make_control(dim: int) -> Control:
    return PlanarControl() if dim == 2 else OrbitControl()


def _away(camera: SpatialCamera) -> FloatArray:
    return np.asarray(camera.eye, float) - np.asarray(camera.target, float)


def _spherical(away: FloatArray) -> tuple[float, float, float]:
    """Return the length in m, the azimuth and the elevation in rad of a vector."""
    x, y, z = (float(part) for part in away)
    return math.sqrt(x * x + y * y + z * z), math.atan2(y, x), math.atan2(z, math.hypot(x, y))


def _direction(azimuth: float, elevation: float) -> FloatArray:
    flat = math.cos(elevation)
    return np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
