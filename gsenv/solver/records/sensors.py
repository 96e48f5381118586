"""Sensors, rays and the motion of bodies in a step, as records for kernels and readings."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from .model import NDOF, ROTATION_SIZE


class SensorKind(IntEnum):
    POSE = 0
    VELOCITY = 1
    CONTACT = 2
    FRAME = 3
    JOINT = 4
    RAYS = 5
    ACCELERATION = 6
    CONTACT_FORCE = 7


# plain ints: numba compares them faster than enum members
POSE, VELOCITY, CONTACT, FRAME, JOINT, RAYS, ACCELERATION, CONTACT_FORCE = (int(kind) for kind in SensorKind)


def sensor_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a sensor."""
    return np.dtype(
        [
            ("kind", "i4"),  # SensorKind
            ("body", "i4"),  # -1: none
            ("joint", "i4"),  # -1: none
            ("column", "i4"),  # of its first number in the readings of all sensors
            ("count", "i4"),  # of numbers in its reading
            ("ray_first", "i4"),  # index of its first ray
            ("subtract_gravity", "i4"),  # 1: it reads the acceleration without that by gravity
            ("mask", "i8"),  # bits of the categories that its rays see
            ("length", "f8"),  # m, of its rays
            ("local_position", "f8", (dim,)),  # m, of the site in the body's own frame
        ],
        align=True,
    )


def ray_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a ray in the world and its nearest hit."""
    return np.dtype(
        [
            ("origin", "f8", (dim,)),  # m
            ("direction", "f8", (dim,)),  # unit
            ("distance", "f8"),  # m: length of the ray, then distance of the hit
            ("normal", "f8", (dim,)),  # of the surface, outward; zero without a hit
            ("shape", "i8"),  # -1: none
        ],
        align=True,
    )


def motion_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the motion of a body over the last step, from its start to its end."""
    return np.dtype(
        [
            ("position", "f8", (dim,)),  # m, centre of mass at the start
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("velocity", "f8", (NDOF[dim],)),  # m/s and rad/s
            ("end_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("end_velocity", "f8", (NDOF[dim],)),
        ],
        align=True,
    )
