"""Primitives of a 3D picture, as arrays with one row each."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gsenv.render.theme import PALETTE
from gsenv.solver.spatial.vertices import vertex_dtype

FloatArray = NDArray[np.float64]

# Values of gsenv.solver.spatial.kinds.ShapeKind.
SPHERE, BOX, CAPSULE, CYLINDER, HULL, PLANE, HEIGHTFIELD = range(7)
KIND_COUNT = 7

# Whether a pattern on a shape makes its rotation visible.
PLAIN, MARKED = 0, 1


class Primitives(NamedTuple):
    """n primitives. The axis of capsules and cylinders is local z; a plane is solid below z = 0 of its frame."""

    kind: NDArray[np.int32]
    position: FloatArray  # (n, 3) m
    rotation: FloatArray  # (n, 4) unit quaternions (w, x, y, z)
    size: FloatArray  # (n, 3) m, half extents; (0, 0, half length) of capsules and cylinders
    radius: FloatArray  # (n,) m
    color: NDArray[np.uint8]  # (n, 3) RGB
    enabled: NDArray[np.bool_]  # (n,)
    vertex_first: NDArray[np.int32]  # (n,) first entry of hulls and heightfields in the array of vertices
    mark: NDArray[np.int32]  # (n,) PLAIN, or MARKED: stripes on spheres, spokes on cylinders


def make_primitives(
    kind: ArrayLike,
    position: ArrayLike,
    rotation: ArrayLike | None = None,
    size: ArrayLike | None = None,
    radius: ArrayLike | None = None,
    color: ArrayLike | None = None,
    enabled: ArrayLike | None = None,
    vertex_first: ArrayLike | None = None,
    mark: ArrayLike | None = None,
) -> Primitives:
    """Return checked primitives from `kind` (n,), `position` (n, 3), and optional fields as in `Primitives`.

    Without `color`, the palette's colours are assigned cyclically.

    Raises ValueError as `check_primitives` does.
    """
    kinds = np.ascontiguousarray(kind, np.int32).reshape(-1)
    n = len(kinds)
    identity = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (n, 4))
    primitives = Primitives(
        kind=kinds,
        position=_floats(position),
        rotation=_floats(identity if rotation is None else rotation),
        size=_floats(np.zeros((n, 3)) if size is None else size),
        radius=_floats(np.zeros(n) if radius is None else radius),
        color=np.ascontiguousarray(PALETTE[np.arange(n) % len(PALETTE)] if color is None else color, np.uint8),
        enabled=np.ascontiguousarray(np.ones(n) if enabled is None else enabled, np.bool_),
        vertex_first=np.ascontiguousarray(np.zeros(n) if vertex_first is None else vertex_first, np.int32),
        mark=np.ascontiguousarray(np.ones(n) if mark is None else mark, np.int32),
    )
    return check_primitives(primitives)


def check_primitives(primitives: Primitives, vertex_count: int | None = None) -> Primitives:
    """Return the primitives unchanged; raise ValueError, in one sentence, about the first field that is wrong."""
    n = len(primitives.kind)
    shapes = {"position": (n, 3), "rotation": (n, 4), "size": (n, 3), "color": (n, 3)}
    for name, value in primitives._asdict().items():
        wanted = shapes.get(name, (n,))
        if value.shape != wanted:
            raise ValueError(f"{name} of {n} primitives must have shape {wanted}, got {value.shape}.")
    kinds = primitives.kind
    if n and not (kinds.min() >= 0 and kinds.max() < KIND_COUNT):
        raise ValueError(f"kind must be 0..{KIND_COUNT - 1}, got {kinds[(kinds < 0) | (kinds >= KIND_COUNT)][0]}.")
    for name in ("size", "radius"):
        if n and not np.isfinite(getattr(primitives, name)).all():
            raise ValueError(f"{name} must be finite, got {getattr(primitives, name).ravel()[0]}.")
        if n and getattr(primitives, name).min() < 0.0:
            raise ValueError(f"{name} must not be negative, got {getattr(primitives, name).min()}.")
    if vertex_count is not None:
        meshed = (kinds == HULL) | (kinds == HEIGHTFIELD)
        first = primitives.vertex_first[meshed]
        if len(first) and not (first.min() >= 0 and first.max() < vertex_count):
            raise ValueError(f"vertex_first must lie in the {vertex_count} vertices, got {first.min()}..{first.max()}.")
    return primitives


class Meshes(NamedTuple):
    """Vertices of all hulls and heightfields as plain arrays, which kernels read faster than records."""

    point: FloatArray  # (v, 3) m
    normal: FloatArray  # (v, 3) of faces
    offset: FloatArray  # (v,) m
    counts: NDArray[np.int64]  # (v, 4) vertices, faces, columns, rows


def read_meshes(vertices: NDArray[np.void] | None) -> Meshes:
    """Return the meshes of an array of `vertex_dtype` entries, or empty ones for None."""
    if vertices is None:
        vertices = np.zeros(0, vertex_dtype())
    counts = [vertices[name] for name in ("vertex_count", "face_count", "columns", "rows")]
    return Meshes(
        _floats(vertices["position"]),
        _floats(vertices["normal"]),
        _floats(vertices["offset"]),
        np.ascontiguousarray(np.stack(counts, axis=-1), np.int64),
    )


def _floats(values: ArrayLike) -> FloatArray:
    return np.ascontiguousarray(values, np.float64)
