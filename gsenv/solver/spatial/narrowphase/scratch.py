"""Scratch of the computation of one pair of shapes, reused for each pair."""

from __future__ import annotations

from typing import Any

import numpy as np

FACE_MAX = 32  # largest number of corners of a face; of larger faces every second, third, ... is used
CLIP_MAX = 2 * FACE_MAX
EPA_VERTICES = 96
EPA_FACES = 2 * EPA_VERTICES
EPA_EDGES = 3 * EPA_VERTICES


def scratch_dtype() -> np.dtype[Any]:
    """Return the dtype of the scratch, one record for each thread.  First index of ``face_*``: shape a or b."""
    return np.dtype(
        [
            # supporting features: corners (u, v) in the plane normal to the contact normal, heights along it
            ("face", "f8", (2, FACE_MAX, 2)),
            ("face_count", "i8", (2,)),
            ("face_id", "i8", (2,)),  # feature id
            ("face_label", "i8", (2, FACE_MAX)),  # label of the corner
            ("face_plane", "f8", (2, 3)),  # height of the surface = [0] + [1] u + [2] v
            ("face_bend", "f8", (2,)),  # m, radius of curvature across a line, 0 where it is an edge
            ("clip", "f8", (2, CLIP_MAX, 2)),
            ("spot", "f8", (CLIP_MAX, 4)),  # candidates of contacts: u, v, height, gap
            ("spot_label", "i8", (CLIP_MAX,)),
            ("chosen", "i8", (4,)),
            # GJK: up to four points of a - b, each followed by its points of a and of b
            ("simplex", "f8", (4, 9)),
            ("weight", "f8", (4,)),
            # EPA: points of a - b likewise, faces of their hull, edges of the hole
            ("corner", "f8", (EPA_VERTICES, 9)),
            ("triangle", "i8", (EPA_FACES, 3)),
            ("triangle_plane", "f8", (EPA_FACES, 4)),  # normal, distance of the origin
            ("rim", "i8", (EPA_EDGES, 2)),
        ],
        align=True,
    )
