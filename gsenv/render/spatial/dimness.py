"""Row kernels of the dimness near other things, where less of the sky is seen."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import Ray, find_ray
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, HULL, PLANE
from gsenv.render.spatial.records import (
    DEPTH,
    FAR,
    HALF,
    ID,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    ONE,
    OPEN,
    PIXEL_X,
    SCRATCH,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.render.spatial.surface import smooth
from gsenv.solver.jit import inline_njit, njit

NEAREST = SCRATCH
DIM = f4(0.62)  # of the sky's light that a near thing takes at most


@inline_njit
def probe(item: Any, ray: Ray, lines: FloatArray, j: Any, reach: Any) -> tuple[Any, Any, Any]:
    """The point `reach` above the visible surface, in the item's frame."""
    ax, ay, az, bx, by, bz = ray
    c, t = lines[PIXEL_X, j], lines[DEPTH, j]
    nx, ny, nz = reach * lines[NORMAL_X, j], reach * lines[NORMAL_Y, j], reach * lines[NORMAL_Z, j]
    return (
        item.eye_x + t * (ax + c * bx) + item.xx * nx + item.xy * ny + item.xz * nz,
        item.eye_y + t * (ay + c * by) + item.yx * nx + item.yy * ny + item.yz * nz,
        item.eye_z + t * (az + c * bz) + item.zx * nx + item.zy * ny + item.zz * nz,
    )


@inline_njit
def close(lines: FloatArray, j: Any, m: Any, gap: Any, reach: Any) -> None:
    """Darken pixel j of item m by a thing at that distance from its probe."""
    taken = DIM * smooth(ONE - gap / reach)
    taken = taken if lines[ID, j] == m else ZERO
    lines[OPEN, j] *= ONE - taken


@njit
def dim_solid(lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray) -> None:
    """Distances from all but hulls: that of a box, less a radius."""
    reach = item.reach
    sx, sy, sz, radius = item.size_x, item.size_y, item.size_z, item.radius
    if item.kind == CAPSULE:
        sx = sy = ZERO
    elif item.kind == BOX:
        radius = ZERO
    turned, mirror = ZERO, ONE
    if item.kind == CYLINDER:  # a box in the plane of its axis
        sx, sy, radius, turned = radius, FAR, ZERO, ONE
    elif item.kind == PLANE:  # a box without sides or bottom
        sx, sy, sz, radius, mirror = FAR, FAR, ZERO, ZERO, ZERO
    for j in range(first, last):
        x, y, z = probe(item, ray, lines, j, reach)
        x = np.sqrt(x * x + turned * y * y)
        y = (ONE - turned) * y
        x, y, z = abs(x) - sx, abs(y) - sy, max(z, -mirror * z) - sz
        ex, ey, ez = max(x, ZERO), max(y, ZERO), max(z, ZERO)
        gap = np.sqrt(ex * ex + ey * ey + ez * ez) + min(max(x, max(y, z)), ZERO) - radius
        close(lines, j, m, gap, reach)


@njit
def dim_hull(lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, faces: FloatArray) -> None:
    reach = item.reach
    for j in range(first, last):
        lines[NEAREST, j] = -FAR
    for face in range(item.first, item.first + item.count):
        nx, ny, nz, offset = faces[face, 0], faces[face, 1], faces[face, 2], faces[face, 3]
        for j in range(first, last):
            x, y, z = probe(item, ray, lines, j, reach)
            lines[NEAREST, j] = max(lines[NEAREST, j], nx * x + ny * y + nz * z - offset)
    for j in range(first, last):
        close(lines, j, m, lines[NEAREST, j], reach)


@njit
def dim_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    pairs: NDArray[np.void],
    looks: NDArray[np.void],
    faces: FloatArray | None,
    spans: NDArray[np.int64],
) -> None:
    """Take some of the sky's light near other things, in the rows start..end-1."""
    look = looks[0]
    for row in range(start, end):
        lines = band[row - start]
        y = look.top - (f4(row) + HALF) * look.step
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            lines[OPEN, j] = ONE
        for k in range(len(pairs)):
            pair = pairs[k]
            if not pair.top <= row < pair.bottom:
                continue
            left, right = spans[row - start, pair.receiver, 0], spans[row - start, pair.receiver, 1]
            first, last = np.uint64(max(pair.left, left)), np.uint64(min(pair.right, right))
            if first >= last:
                continue
            item = items[pair.occluder]
            ray, m = find_ray(item, look, ZERO, y), f4(pair.receiver)
            if item.kind != HULL:
                dim_solid(lines, first, last, m, item, ray)
            elif faces is not None:
                dim_hull(lines, first, last, m, item, ray, faces)
