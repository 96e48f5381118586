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
    """Warn of 2D terrains from right to left where all dynamic bodies within their range start in their solid.

    Such a chain is a ceiling: what starts above it falls through.
    """
    listed = list(bodies)
    movers = np.array([body.position for body in listed if body.kind == BodyKind.DYNAMIC]).reshape(-1, 2)
    kind = dimension(2).kinds.ShapeKind["TERRAIN"]
    for body in listed:
        for shape in body.shapes:
            if shape.kind == kind and not shape.closed and _is_inverted(_chain(body, shape), movers):
                warnings.warn(
                    f"body {body.name!r}: the Terrain goes from right to left, so its solid lies above it, and the "
                    "bodies there fall through; reverse its vertices to make it ground.",
                    stacklevel=stacklevel + 1,
                )


def _chain(body: BodySpec, shape: Any) -> Array:
    """Return the vertices (n, 2) of a terrain in the world, m."""
    points = np.array(shape.vertices, float)
    for angle, position in ((shape.angle, shape.position), (body.angle, body.position)):
        c, s = np.cos(float(angle)), np.sin(float(angle))
        points = points @ np.array([[c, s], [-s, c]]) + np.array(position, float)
    return points


def _is_inverted(chain: Array, movers: Array) -> bool:
    if not (np.diff(chain[:, 0]) < 0.0).all():
        return False  # not a function of x: there is no above
    within = (movers[:, 0] >= chain[-1, 0]) & (movers[:, 0] <= chain[0, 0])
    heights = np.interp(movers[within, 0], chain[::-1, 0], chain[::-1, 1])
    return bool(within.any() and (movers[within, 1] > heights).all())
