"""A warning for ground whose solid is on the wrong side."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..dimension import dimension
from ..records.model import Array, BodyKind
from .specs import BodySpec


def warn_of_inverted_terrains(bodies: Iterable[BodySpec], stacklevel: int) -> None:
    """Warn of 2D terrains that dynamic bodies would fall through, because their solid is on the side of the bodies.

    Below such a body, the first segment has its solid above it. A terrain on which others stand is not meant.
    """
    listed = list(bodies)
    movers = np.array([body.position for body in listed if body.kind == BodyKind.DYNAMIC]).reshape(-1, 2)
    kind = dimension(2).kinds.ShapeKind["TERRAIN"]
    for body in listed:
        for shape in body.shapes:
            if shape.kind == kind and _is_inverted(_chain(body, shape), movers):
                goes = "round its bodies the wrong way" if shape.closed else "from right to left"
                warnings.warn(
                    f"body {body.name!r}: the Terrain goes {goes}, so its solid lies above it, and the "
                    "bodies there fall through; reverse its vertices to make it ground.",
                    stacklevel=stacklevel + 1,
                )


def _chain(body: BodySpec, shape: Any) -> Array:
    """Return the vertices (n, 2) of a terrain in the world, m; a closed one ends with its first."""
    points = np.array(shape.vertices, float)
    for angle, position in ((shape.angle, shape.position), (body.angle, body.position)):
        c, s = np.cos(float(angle)), np.sin(float(angle))
        points = points @ np.array([[c, s], [-s, c]]) + np.array(position, float)
    return np.concatenate([points, points[:1]]) if shape.closed else points


def _is_inverted(chain: Array, movers: Array) -> bool:
    """Whether bodies are above segments from right to left, and none is above one from left to right."""
    start, end = chain[:-1], chain[1:]
    leftwards = end[:, 0] < start[:, 0]
    below = [_first_below(start, end, mover) for mover in movers]
    hit = [bool(leftwards[k]) for k in below if k is not None]
    return bool(hit) and all(hit)


def _first_below(start: Array, end: Array, point: Array) -> int | None:
    """Return the number of the segment that is next below a point; None where there is none."""
    across = end[:, 0] - start[:, 0]
    low, high = np.minimum(start[:, 0], end[:, 0]), np.maximum(start[:, 0], end[:, 0])
    spans = (across != 0.0) & (low <= point[0]) & (point[0] <= high)
    share = (point[0] - start[spans, 0]) / across[spans]
    heights = start[spans, 1] + share * (end[spans, 1] - start[spans, 1])
    under = heights < point[1]
    if not under.any():
        return None
    return int(np.flatnonzero(spans)[under][np.argmax(heights[under])])
