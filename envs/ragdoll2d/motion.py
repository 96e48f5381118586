"""Reference motions: a script looks for the frame in which a figure was most like this one, and acts as it did there.

gsenv/envs/rises.py makes them. This is a nearest-neighbour policy (Atkeson, Moore and Schaal 1997, "Locally
weighted learning for control", with one neighbour): it has no memory, and so it picks up a motion anywhere in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.mlp import read_asset
from gsenv.envs.ragdoll2d import scene

FILE = "rises.npz"  # of gsenv.assets

Array = NDArray[np.float64]


class Motion(NamedTuple):
    """Frames of motions: what was seen of the figure (frame, feature), and the actions (frame, axis)."""

    seen: Array
    actions: Array


@cache
def reference_motion(env_id: str) -> Motion:
    """Return the motions in which a figure of this environment gets up."""
    arrays = read_asset(FILE)
    return Motion(arrays[f"{env_id} seen"].astype(np.float64), arrays[f"{env_id} actions"].astype(np.float64))


def select(observations: NDArray[np.float32], names: Mapping[str, int], weights: Mapping[str, float]) -> Array:
    """Return the features (..., feature) of observations (..., entry): those with a weight, times their weight."""
    columns = [names[name] for name in weights]
    return np.asarray(observations, np.float64)[..., columns] * np.array(list(weights.values()))


def follow(motion: Motion, seen: Array) -> NDArray[np.float32]:
    """Return the actions (..., axis) of the frames whose features are nearest to those seen (..., feature)."""
    distances = (motion.seen**2).sum(1) - 2.0 * seen @ motion.seen.T
    return motion.actions[distances.argmin(-1)].astype(np.float32)


def over_limits(actions: NDArray[Any], axes: Sequence[Any]) -> Array:
    """Return the actions (..., axis) of getting up that ask for the same angles as those of the balance.

    Those of the balance add spans to the angles of the stand, those of getting up reach to the limits.
    """
    stand = np.array([axis.stand for axis in axes])
    low, high = np.array([axis.limits for axis in axes]).T
    angles = actions * 0.5 * scene.REACH * (high - low)
    return np.asarray(np.where(angles > 0.0, angles / (high - stand), angles / (stand - low)))
