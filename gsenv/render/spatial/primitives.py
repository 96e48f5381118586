"""What a 3D picture is made of: one row per primitive."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gsenv.render.theme import PALETTE
from gsenv.solver.spatial.vertices import vertex_dtype

FloatArray = NDArray[np.float64]

# Numbers of gsenv.solver.spatial.shapes.ShapeKind.
SPHERE, BOX, CAPSULE, CYLINDER, HULL, PLANE, HEIGHTFIELD = range(7)
KIND_COUNT = 7

# What of a shape turns with it, so that one sees it turn.
PLAIN, MARKED = 0, 1


class Primitives(NamedTuple):
    """(n,) primitives. A shape's axis is its z axis; a plane is solid below z = 0 of its frame."""

    kind: NDArray[np.int32]
    position: FloatArray  # (n, 3) m
    rotation: FloatArray  # (n, 4) unit quaternions (w, x, y, z)
    size: FloatArray  # (n, 3) m, half extents; (0, 0, half length) of capsules and cylinders
    radius: FloatArray  # (n,) m
    color: NDArray[np.uint8]  # (n, 3) RGB
    enabled: NDArray[np.bool_]  # (n,)
    vertex_first: NDArray[np.int32]  # (n,) of hulls and heightfields, in the array of vertices
    mark: NDArray[np.int32]  # (n,) MARKED: stripes on spheres, spokes on cylinders


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
    """Checked primitives: `kind` (n,), `position` (n, 3), the rest as in `Primitives` or left out.

    Colours follow the palette in turn where none are given.
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
    """The same, or ValueError with one clear sentence about the first thing wrong."""
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
    """Vertices of all hulls and heightfields, as arrays that kernels read fast."""

    point: FloatArray  # (v, 3) m
    normal: FloatArray  # (v, 3) of faces
    offset: FloatArray  # (v,) m
    counts: NDArray[np.int64]  # (v, 4) vertices, faces, columns, rows


def read_meshes(vertices: NDArray[np.void] | None) -> Meshes:
    """Meshes of an array of `vertex_dtype` entries, or of none."""
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
