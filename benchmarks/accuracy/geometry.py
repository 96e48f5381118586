"""Overlap of boxes from their poses alone: no engine's own report enters an error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def corners(position: Array, angle: Array, half: Array) -> Array:
    """(box, 4, 2) m in the world; position (box, 2), angle (box,), half-extents (box, 2)."""
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    local = half[:, None] * signs
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    turned = np.stack([c * local[..., 0] - s * local[..., 1], s * local[..., 0] + c * local[..., 1]], -1)
    return position[:, None] + turned


def near_pairs(position: Array, reach: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs (i < j) whose circles or balls of radius ``reach`` (m) meet; position (item, 2 or 3)."""
    distance = np.linalg.norm(position[:, None] - position[None], axis=-1)
    first, second = np.nonzero(np.triu(distance < reach[:, None] + reach[None], 1))
    return first, second


def box_overlaps(position: Array, angle: Array, half: Array) -> Array:
    """(pair,) m: the least translation that parts each near pair of boxes, negative where they are apart.

    The edges of the Minkowski difference of two boxes are parallel to the boxes' own edges, so the
    smallest overlap of their shadows on the four face normals is the exact depth (Ericson, Real-Time
    Collision Detection, 4.4).
    """
    first, second = near_pairs(position, np.linalg.norm(half, axis=-1))
    points = corners(position, angle, half)
    depth = np.full(len(first), np.inf)
    for owner in (first, second):
        for quarter in (0.0, 0.5 * np.pi):
            axis = np.stack([np.cos(angle[owner] + quarter), np.sin(angle[owner] + quarter)], -1)
            a = np.einsum("pkc,pc->pk", points[first], axis)
            b = np.einsum("pkc,pc->pk", points[second], axis)
            depth = np.minimum(depth, np.minimum(a.max(1) - b.min(1), b.max(1) - a.min(1)))
    return depth


def deepest_overlap(position: Array, angle: Array, half: Array) -> float:
    """m: deepest of all overlaps between boxes and into the ground y <= 0; 0 where nothing overlaps."""
    ground = -corners(position, angle, half)[..., 1].min()
    pairs = box_overlaps(position, angle, half)
    return float(max(0.0, ground, pairs.max(initial=0.0)))
