"""The flat array of hulls' vertices, faces and edges and of heightfields' samples."""

from __future__ import annotations

from typing import Any

import numpy as np


def vertex_dtype() -> np.dtype[Any]:
    """Return the dtype of vertices: entry i has a hull's i-th vertex, face and half-edge, or a field's i-th sample.

    The counts are in the first entry of a shape.  Indices count from that entry.
    """
    return np.dtype(
        [
            ("position", "f8", (3,)),  # m, vertex or sample in the shape's frame
            ("normal", "f8", (3,)),  # unit, outward, of the face; in the first of a heightfield: lowest, highest
            ("offset", "f8"),  # m, normal . x of the face
            ("face_edge", "i4"),  # a half-edge of the face; half-edges are counter-clockwise seen from outside
            ("vertex_edge", "i4"),  # a half-edge that starts at the vertex
            ("origin", "i4"),  # vertex where the half-edge starts
            ("twin", "i4"),  # the half-edge of the same edge in the other direction
            ("next", "i4"),  # next half-edge of the face
            ("face", "i4"),  # face on the left of the half-edge
            ("vertex_count", "i4"),
            ("face_count", "i4"),
            ("edge_count", "i4"),  # half-edges
            ("columns", "i4"),  # of a heightfield: number of samples along x, then of rows along y
            ("rows", "i4"),
        ],
        align=True,
    )
