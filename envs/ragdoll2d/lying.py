"""Poses of figures that have fallen and come to rest; gsenv/envs/falls.py makes them."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.mlp import read_asset

FILE = "lying.npz"  # of gsenv.assets
NO_POSES = np.zeros((0, 1))  # for tasks in which nobody lies


@cache
def lying_poses(env_id: str) -> NDArray[np.float64]:
    """Return a row for each pose: the rotation of the pelvis, then the angles of all joints from the stand in rad.

    The rotation is an angle in rad in 2D, a unit quaternion in 3D.
    """
    arrays = read_asset(FILE)
    return np.ascontiguousarray(arrays[env_id], dtype=np.float64)
