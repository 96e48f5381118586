"""2D cameras: which part of the world the picture shows."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


class Bounds(NamedTuple):
    """Axis-aligned box in m."""

    left: float
    bottom: float
    right: float
    top: float


class Camera(NamedTuple):
    """Orthographic view of `height` m, centred on `center` (x, y) in m.

    Pixel coordinates are continuous: (0, 0) is the top left corner, y points down, and the centre of
    the first pixel is (0.5, 0.5).
    """

    center: tuple[float, float] = (0.0, 0.0)
    height: float = 10.0

    @classmethod
    def fit(cls, bounds: Bounds, width: int, height: int, margin: float = 0.10) -> "Camera":
        """Return a camera that shows all of `bounds`; `margin` is the least free share of the picture on each side."""
        room = 1.0 - 2.0 * margin
        span_x = max(bounds.right - bounds.left, 1e-3)
        span_y = max(bounds.top - bounds.bottom, 1e-3)
        view_height = max(span_y, span_x * height / width) / room
        center = (0.5 * (bounds.left + bounds.right), 0.5 * (bounds.bottom + bounds.top))
        return cls(center, view_height)

    def scale(self, height: int) -> float:
        """Return the pixels per metre in a picture that is `height` px high."""
        return height / self.height

    def to_pixel(self, points: ArrayLike, width: int, height: int) -> FloatArray:
        """Convert world points (..., 2) in m to pixels (..., 2)."""
        scale = self.scale(height)
        offset = (np.asarray(points, np.float64) - self.center) * (scale, -scale)
        middle: FloatArray = np.array([0.5 * width, 0.5 * height])
        return offset + middle

    def to_world(self, pixels: ArrayLike, width: int, height: int) -> FloatArray:
        """Convert pixels (..., 2) to world points (..., 2) in m."""
        scale = self.scale(height)
        offset = np.asarray(pixels, np.float64) - (0.5 * width, 0.5 * height)
        return offset / (scale, -scale) + self.center


@dataclass
class FollowCamera:
    """Camera that follows bodies like a critically damped spring, in simulation time.

    The target is the centre of the bounding box of the positions of `bodies`. It is assumed to move
    in a straight line between two updates; the spring's motion is solved exactly for that, so the
    path does not depend on the frame rate. If the time decreases, or the bodies move while it stays
    the same (a reset), the camera jumps to the target.

    bodies: indices of the bodies to keep in view
    height: m, least height of the view; it grows with the bounding box
    smooth_time: s, approximate lag behind a moving target; 0 locks the camera to the target
    offset: m, from the target to the centre of the view
    margin: m, free space around the bounding box
    """

    bodies: Sequence[int]
    height: float = 10.0
    smooth_time: float = 0.3
    offset: tuple[float, float] = (0.0, 0.0)
    margin: float = 1.0
    _time: float | None = field(default=None, repr=False)
    _value: FloatArray = field(default_factory=lambda: np.zeros(3), repr=False)
    _velocity: FloatArray = field(default_factory=lambda: np.zeros(3), repr=False)
    _target: FloatArray = field(default_factory=lambda: np.zeros(3), repr=False)

    def update(self, positions: FloatArray, time: float | None, width: int, height: int) -> Camera:
        """Return the camera at `time` (s; None disables smoothing) for body positions (body, 2) in m."""
        target = self._find_target(positions, width / height)
        if time is not None and self._time is not None and time > self._time:
            self._advance(target, time - self._time)
        elif time is None or time != self._time or not np.array_equal(target, self._target):
            self._value, self._velocity = target, np.zeros(3)
        self._time, self._target = time, target
        center_x, center_y, view_height = self._value
        return Camera((float(center_x), float(center_y)), float(view_height))

    def _find_target(self, positions: FloatArray, aspect: float) -> FloatArray:
        """Return the (center x, center y, height) in m that frames the followed bodies."""
        followed = positions[list(self.bodies)]
        low, high = followed.min(axis=0), followed.max(axis=0)
        span = high - low + 2.0 * self.margin
        center = 0.5 * (low + high) + self.offset
        return np.array([*center, max(self.height, span[1], span[0] / aspect)])

    def _advance(self, target: FloatArray, dt: float) -> None:
        """Advance the exact solution of x'' = w^2 (g - x) - 2 w x' by `dt`, for a target g of constant velocity.

        With u = g', the lag e = x - g + 2 u / w obeys e'' = -w^2 e - 2 w e', whose solution is
        e(t) = (e0 + (e0' + w e0) t) exp(-w t).
        """
        if self.smooth_time <= 0.0:
            self._value = target
            return
        omega = 2.0 / self.smooth_time
        target_velocity = (target - self._target) / dt
        lag = self._value - self._target + 2.0 * target_velocity / omega
        slope = self._velocity - target_velocity + omega * lag
        decay = np.exp(-omega * dt)
        new_lag = (lag + slope * dt) * decay
        self._value = target + new_lag - 2.0 * target_velocity / omega
        self._velocity = target_velocity + (slope - omega * (lag + slope * dt)) * decay
