"""Bit-for-bit comparison of worlds."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from gsenv.solver import World


def bits(array: Any) -> bytes:
    """All values of a structured array, without the padding between them."""
    return b"".join(array[name].tobytes() for name in array.dtype.names)


def everything(world: World, chosen: Any = slice(None)) -> bytes:
    """All bits of State and Parameters of the chosen worlds."""
    state = world.state
    count = state.worlds["contact_count"][chosen].max(initial=0)
    arrays = [state.worlds[chosen], state.bodies[chosen], state.joints[chosen], state.contacts[chosen][..., :count]]
    arrays += [array[chosen] for array in world.parameters.arrays().values()]
    return world.control[chosen].tobytes() + b"|".join(bits(array) for array in arrays)


def motion_hash(world: World) -> str:
    """sha256 of where all bodies are and how they move."""
    bodies = world.state.bodies
    names = ("position", "angle" if world.model.dim == 2 else "rotation", "velocity")
    parts = [np.ascontiguousarray(bodies[name], "<f8").tobytes() for name in names]
    return hashlib.sha256(b"".join(parts)).hexdigest()
