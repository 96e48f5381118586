"""What 2D renderers refuse of cameras; not in camera.py, because kernels are compiled anew when that file changes."""

from math import inf, isfinite
from numbers import Real

import numpy as np

from gsenv.render.camera import Camera, FollowCamera
from gsenv.render.checks import checked_bodies


def checked_camera(camera: Camera) -> Camera:
    """Return a camera of floats: kernels would be compiled anew for whole numbers.

    Raises:
        ValueError: it shows nothing.
    """
    try:
        (x, y), height = camera
        x, y, height = float(x), float(y), float(height)
    except (TypeError, ValueError):
        height = 0.0
    if not (0.0 < height < inf and isfinite(1.0 / height) and isfinite(x) and isfinite(y)):
        raise ValueError(f"a Camera needs a finite center (x, y) and a positive height in m, got {camera!r}.")
    return Camera((x, y), height)


def check_follow(camera: FollowCamera, body_count: int) -> None:
    """Raise ValueError for no bodies or ones that do not exist, and for numbers that are not finite or are negative."""
    if not checked_bodies(camera.bodies, "FollowCamera: bodies", body_count):
        raise ValueError("FollowCamera: bodies must be at least one, got none.")
    for name in ("height", "smooth_time", "margin"):
        value = getattr(camera, name)
        if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 <= float(value) < inf:
            raise ValueError(f"FollowCamera: {name} must be a finite number of at least 0, got {value!r}.")
    offset = camera.offset
    if np.shape(offset) != (2,) or not all(isinstance(x, Real) and isfinite(x) for x in offset):
        raise ValueError(f"FollowCamera: offset must be two finite numbers, got {offset!r}.")
