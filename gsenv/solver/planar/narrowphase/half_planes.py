"""Half-planes: a reference face without ends, so that nothing is cut off."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose
from gsenv.solver.planar.narrowphase.boxes import clip_faces, incident_face
from gsenv.solver.planar.narrowphase.manifold import Manifold
from gsenv.solver.planar.narrowphase.polygons import Outline, face_manifold


@njit
def half_plane_box(
    plane: Pose, pose: Pose, half_x: float, half_y: float, radius: float, margin: float
) -> Manifold:
    """Half-plane a; b a circle, capsule or box: half-extents and a radius in m."""
    frame = Pose(plane.x, plane.y, -plane.sin, plane.cos)
    if half_x == 0.0:  # a circle has no corners: as it rolls, the feature stays
        pose = Pose(pose.x, pose.y, plane.cos, plane.sin)
    normal0, side0, normal1, side1, corner0, corner1 = incident_face(frame, pose, half_x, half_y)
    return clip_faces(
        frame, np.inf, normal0, side0, normal1, side1, 0.0, radius, 0.0, margin, corner0, corner1
    )


@njit
def half_plane_polygon(
    plane: Pose, pose: Pose, polygon: Outline, vertices: Any, margin: float
) -> Manifold:
    """Half-plane a, polygon b."""
    frame = Pose(plane.x, plane.y, -plane.sin, plane.cos)
    return face_manifold(frame, np.inf, 0.0, polygon, pose, vertices, 0.0, margin, int64(0))
