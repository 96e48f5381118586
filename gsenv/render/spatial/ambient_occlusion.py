"""Row kernels of ambient occlusion: near other items a surface sees less of the sky, and gets less of its light."""

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
    PIXEL_X,
    SCRATCH,
    VISIBILITY,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.render.spatial.surface import smooth
from gsenv.solver.jit import inline_njit, njit

NEAREST = SCRATCH
MAX_OCCLUSION = f4(0.62)  # largest fraction of the sky's light that one occluder takes


@inline_njit
def probe(item: Any, ray: Ray, lines: FloatArray, j: Any, reach: Any) -> tuple[Any, Any, Any]:
    """Return the point at distance `reach` above the visible surface of column j, in the item's frame."""
    ax, ay, az, bx, by, bz = ray
    c, t = lines[PIXEL_X, j], lines[DEPTH, j]
    nx, ny, nz = reach * lines[NORMAL_X, j], reach * lines[NORMAL_Y, j], reach * lines[NORMAL_Z, j]
    return (
        item.eye_x + t * (ax + c * bx) + item.xx * nx + item.xy * ny + item.xz * nz,
        item.eye_y + t * (ay + c * by) + item.yx * nx + item.yy * ny + item.yz * nz,
        item.eye_z + t * (az + c * bz) + item.zx * nx + item.zy * ny + item.zz * nz,
    )


@inline_njit
def occlude(lines: FloatArray, j: Any, m: Any, gap: Any, reach: Any) -> None:
    """Reduce the sky's visibility at pixel j of item m by an occluder at distance `gap` from its probe."""
    occlusion = MAX_OCCLUSION * smooth(ONE - gap / reach)
    occlusion = occlusion if lines[ID, j] == m else ZERO
    lines[VISIBILITY, j] *= ONE - occlusion


@njit
def occlude_solid(lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray) -> None:
    """Return the occlusion by a shape that is no hull; its distance is that of a box, minus a radius."""
    reach = item.reach
    sx, sy, sz, radius = item.size_x, item.size_y, item.size_z, item.radius
    if item.kind == CAPSULE:
        sx = sy = ZERO
    elif item.kind == BOX:
        radius = ZERO
    turned, mirror = ZERO, ONE
    if item.kind == CYLINDER:  # a rectangle in the half-plane through its axis
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
        occlude(lines, j, m, gap, reach)


@njit
def occlude_hull(lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, faces: FloatArray) -> None:
    """Return the occlusion by a hull; its distance is the largest to the planes of its faces."""
    reach = item.reach
    for j in range(first, last):
        lines[NEAREST, j] = -FAR
    for face in range(item.first, item.first + item.count):
        nx, ny, nz, offset = faces[face, 0], faces[face, 1], faces[face, 2], faces[face, 3]
        for j in range(first, last):
            x, y, z = probe(item, ray, lines, j, reach)
            lines[NEAREST, j] = max(lines[NEAREST, j], nx * x + ny * y + nz * z - offset)
    for j in range(first, last):
        occlude(lines, j, m, lines[NEAREST, j], reach)


@njit
def occlude_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    pairs: NDArray[np.void],
    looks: NDArray[np.void],
    faces: FloatArray | None,
    spans: NDArray[np.int64],
) -> None:
    """Set the visibility of the sky in the rows start..end-1 from all pairs."""
    look = looks[0]
    for row in range(start, end):
        lines = band[row - start]
        y = look.top - (f4(row) + HALF) * look.step
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            lines[VISIBILITY, j] = ONE
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
                occlude_solid(lines, first, last, m, item, ray)
            elif faces is not None:
                occlude_hull(lines, first, last, m, item, ray, faces)
