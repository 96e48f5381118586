"""Contacts of half-planes: reference faces without ends, so that nothing is clipped."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ...jit import njit
from ..math import Pose
from .boxes import Face, RoundBox, clip_faces, incident_face
from .manifold import Manifold
from .polygons import Outline, face_manifold


@njit
def half_plane_box(plane: Pose, pose: Pose, box: RoundBox, margin: float) -> Manifold:
    """Return the contact of half-plane a with a circle, capsule or box b."""
    face = whole_face(plane)
    if box.half_x == 0.0:  # a circle has no corners: the feature id does not change as it rolls
        pose = Pose(pose.x, pose.y, plane.cos, plane.sin)
    segment = incident_face(face.frame, pose, box, int64(0))
    return clip_faces(face, segment, box.radius, 0.0, margin)


@njit
def half_plane_polygon(plane: Pose, pose: Pose, polygon: Outline, vertices: Any, margin: float) -> Manifold:
    """Return the contact of half-plane a with polygon b."""
    return face_manifold(whole_face(plane), polygon, pose, vertices, 0.0, margin, int64(0))


@njit
def whole_face(plane: Pose) -> Face:
    """Return the surface of a half-plane as a face."""
    return Face(Pose(plane.x, plane.y, -plane.sin, plane.cos), np.inf, 0.0)
