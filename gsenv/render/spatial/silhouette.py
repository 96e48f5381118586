"""Outlines of convex things in pictures: their distance to each pixel, and how much of it they cover."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def find_hull(points: FloatArray) -> FloatArray:
    """Return the corners (k, 2) of the convex hull of points (n, 2), of which no three are in line.

    They go around from the x to the y axis. Andrew's monotone chain: "Another efficient algorithm for convex hulls in
    two dimensions", 1979.
    """
    ordered = sorted({(float(x), float(y)) for x, y in points})
    chains = []
    for way in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in way:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], (x, y)) <= 0.0:
                chain.pop()
            chain.append((x, y))
        chains.append(chain[:-1])
    return np.array(chains[0] + chains[1]).reshape(-1, 2)


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def measure(points: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """Return how far (px) places x, y are outside of the hull of points (n, 2), and the hull's least width in px.

    Inside, distances are negative. They are those to the lines along the hull's edges, so corners are sharp.
    """
    outside = np.full(np.broadcast_shapes(x.shape, y.shape), -np.inf)
    corners = find_hull(points)
    if len(corners) < 3:
        return np.full_like(outside, np.inf), 0.0
    width = np.inf
    for corner, edge in zip(corners, np.roll(corners, -1, axis=0) - corners, strict=True):
        normal = np.array([edge[1], -edge[0]]) / np.hypot(*edge)
        level = float(corner @ normal)
        np.maximum(outside, normal[0] * x + normal[1] * y - level, out=outside)
        width = min(width, level - float((corners @ normal).min()))
    return outside, width


def coverage(outside: FloatArray, width: float) -> FloatArray:
    """Return the share of pixels that a shape covers whose edge is `outside` px away, and which is so many px wide."""
    return np.clip(0.5 - outside, 0.0, min(width, 1.0))
