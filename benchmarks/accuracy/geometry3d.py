"""Overlaps of boxes and balls from their poses alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.quaternions import conjugate, matrices, multiply, rotated

from .geometry import near_pairs

Array = NDArray[np.float64]

__all__ = [
    "box_overlaps", "conjugate", "corners", "deepest_ball_overlap", "deepest_box_overlap", "matrices", "multiply",
    "rotated",
]  # fmt: skip


def corners(position: Array, rotation: Array, half: Array) -> Array:
    """(box, 8, 3) m in the world; position (box, 3), rotation (box, 4), half-extents (box, 3)."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, 8).T
    return position[:, None] + rotated(rotation[:, None], half[:, None] * signs)


def box_overlaps(position: Array, rotation: Array, half: Array) -> Array:
    """(pair,) m: the least translation that parts each near pair of boxes, negative where they are apart.

    The faces of the Minkowski difference of two boxes are parallel to a face of either or to an edge of each, so
    the smallest overlap of their shadows on the 6 normals and 9 cross products is the exact depth (Gottschalk,
    Lin, Manocha, OBBTree, 1996).
    """
    first, second = near_pairs(position, np.linalg.norm(half, axis=-1))
    axes = matrices(rotation)
    a, b = axes[first], axes[second]
    edges = np.cross(a[:, :, :, None], b[:, :, None, :], axis=1).reshape(len(first), 3, 9)
    tried = np.concatenate([a, b, edges], -1)  # (pair, 3, 15)
    length = np.linalg.norm(tried, axis=1, keepdims=True)
    parallel = length[:, 0] < 1e-6  # such edges add nothing to the faces
    tried = tried / np.where(length < 1e-6, 1.0, length)
    reach = sum(
        np.einsum("pi,pik->pk", half[side], np.abs(np.einsum("pij,pik->pjk", frame, tried)))
        for side, frame in ((first, a), (second, b))
    )
    apart = np.abs(np.einsum("pi,pik->pk", position[second] - position[first], tried))
    return np.where(parallel, np.inf, reach - apart).min(1, initial=np.inf)


def deepest_box_overlap(position: Array, rotation: Array, half: Array) -> float:
    """m: deepest of all overlaps between boxes and into the ground z <= 0; 0 where nothing overlaps."""
    ground = -corners(position, rotation, half)[..., 2].min()
    return float(max(0.0, ground, box_overlaps(position, rotation, half).max(initial=0.0)))


def deepest_ball_overlap(position: Array, radius: Array) -> float:
    """m: the same of balls."""
    ground = (radius - position[:, 2]).max()
    first, second = near_pairs(position, radius)
    depth = radius[first] + radius[second] - np.linalg.norm(position[second] - position[first], axis=-1)
    return float(max(0.0, ground, depth.max(initial=0.0)))
