"""Sensors as records for kernels and readings."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class SensorKind(IntEnum):
    POSE = 0
    VELOCITY = 1
    CONTACT = 2
    FRAME = 3
    JOINT = 4
    RAYS = 5


# plain ints: numba compares them faster than enum members
POSE, VELOCITY, CONTACT, FRAME, JOINT, RAYS = (int(kind) for kind in SensorKind)

SENSOR_DTYPE = np.dtype(
    [
        ("kind", "i4"),  # SensorKind
        ("body", "i4"),  # -1: none
        ("joint", "i4"),  # -1: none
        ("column", "i4"),  # of its first number in the readings of all sensors
        ("count", "i4"),  # of numbers in its reading
        ("ray_first", "i4"),  # index of its first ray
        ("mask", "i8"),  # bits of the categories that its rays see
        ("length", "f8"),  # m, of its rays
        ("local_position", "f8", (2,)),  # m, of the site in the body's own frame
    ],
    align=True,
)
