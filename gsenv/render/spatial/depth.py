"""Row kernels of visibility: nearest depth and its item's id in each column, by analytic ray intersection."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, HEIGHTFIELD, HULL, PLANE
from gsenv.render.spatial.records import (
    FAR,
    HALF,
    ID,
    LANES,
    NEAR,
    ONE,
    PIXEL_X,
    SCRATCH,
    SKY,
    TINY,
    TWO,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.solver.jit import inline_njit, njit
from gsenv.solver.spatial.math import cross, dot, sub

# Start and step of a row's rays in an item's frame: d = start + x step, with x the column of the pixel's centre.
Ray = tuple[Any, Any, Any, Any, Any, Any]

ENTER, LEAVE = SCRATCH, SCRATCH + 1
NOWHERE = (FAR, -FAR, FAR, -FAR)  # bounds of no points: left, right, top, bottom in px
NEARER = f4(1.00001)  # depth ratio by which a later item must be nearer: the first of two coincident faces shows


@inline_njit
def find_ray(item: Any, look: Any, x: Any, y: Any) -> Ray:
    """Return the rays of the row at picture height y, with columns shifted by x (both at depth 1)."""
    x = look.left + x
    step = look.step
    return (
        item.forward_x + x * item.right_x + y * item.up_x,
        item.forward_y + x * item.right_y + y * item.up_y,
        item.forward_z + x * item.right_z + y * item.up_z,
        step * item.right_x,
        step * item.right_y,
        step * item.right_z,
    )


@inline_njit
def nonzero(x: Any) -> Any:
    """Return x, or a tiny number for zero, so that it can be divided by."""
    return x if abs(x) > TINY else TINY


@njit
def trace_box(lines: FloatArray, depth: int, ids: int, first: Any, last: Any, k: Any, item: Any, ray: Ray) -> None:
    """Intersect rays with a box: the overlap of three slabs."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    sx, sy, sz = item.size_x, item.size_y, item.size_z
    for j in range(first, last):
        c = lines[PIXEL_X, j]
        ix, iy, iz = ONE / nonzero(ax + c * bx), ONE / nonzero(ay + c * by), ONE / nonzero(az + c * bz)
        wx, wy, wz = abs(ix) * sx, abs(iy) * sy, abs(iz) * sz
        enter = max(max(-ix * ox - wx, -iy * oy - wy), -iz * oz - wz)
        leave = min(min(-ix * ox + wx, -iy * oy + wy), -iz * oz + wz)
        old = lines[depth, j]
        hit = (enter <= leave) & (enter > NEAR) & (enter * NEARER < old)
        lines[depth, j] = enter if hit else old
        lines[ids, j] = k if hit else lines[ids, j]


@njit
def trace_capsule(lines: FloatArray, depth: int, ids: int, first: Any, last: Any, k: Any, item: Any, ray: Ray) -> None:
    """Intersect rays with a capsule; a sphere is one of half length 0.

    The discriminants are computed from |o x d|, which avoids cancellation far from the eye.
    """
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    half, square = item.size_z, item.radius * item.radius
    for j in range(first, last):
        c = lines[PIXEL_X, j]
        dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
        flat = max(dx * dx + dy * dy, TINY)
        along = ox * dx + oy * dy
        moment = ox * dy - oy * dx
        room = flat * square - moment * moment
        side = (-along - np.sqrt(max(room, ZERO))) / flat
        z = oz + side * dz
        on_side = (room > ZERO) & (abs(z) < half)
        pz = oz - (half if z > ZERO else -half)
        mx, my = oy * dz - pz * dy, pz * dx - ox * dz
        full = flat + dz * dz
        cap_room = full * square - (mx * mx + my * my + moment * moment)
        cap = (-along - pz * dz - np.sqrt(max(cap_room, ZERO))) / full
        t = side if on_side else cap
        old = lines[depth, j]
        hit = (on_side | (cap_room > ZERO)) & (t > NEAR) & (t * NEARER < old)
        lines[depth, j] = t if hit else old
        lines[ids, j] = k if hit else lines[ids, j]


@njit
def trace_cylinder(lines: FloatArray, depth: int, ids: int, first: Any, last: Any, k: Any, item: Any, ray: Ray) -> None:
    """Intersect rays with a cylinder: the overlap of an infinite one and a slab."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    half, square = item.size_z, item.radius * item.radius
    for j in range(first, last):
        c = lines[PIXEL_X, j]
        dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
        flat = max(dx * dx + dy * dy, TINY)
        along = ox * dx + oy * dy
        moment = ox * dy - oy * dx
        room = flat * square - moment * moment
        root = np.sqrt(max(room, ZERO))
        scale = ONE / flat
        iz = ONE / nonzero(dz)
        wz = abs(iz) * half
        enter = max((-along - root) * scale, -iz * oz - wz)
        leave = min((-along + root) * scale, -iz * oz + wz)
        old = lines[depth, j]
        hit = (room > ZERO) & (enter <= leave) & (enter > NEAR) & (enter * NEARER < old)
        lines[depth, j] = enter if hit else old
        lines[ids, j] = k if hit else lines[ids, j]


@njit
def trace_plane(lines: FloatArray, depth: int, ids: int, first: Any, last: Any, k: Any, item: Any, ray: Ray) -> None:
    az, bz = ray[2], ray[5]
    oz = item.eye_z
    if oz <= ZERO:
        return
    for j in range(first, last):
        dz = az + lines[PIXEL_X, j] * bz
        t = oz / max(-dz, TINY)
        old = lines[depth, j]
        hit = (dz < ZERO) & (t > NEAR) & (t * NEARER < old)
        lines[depth, j] = t if hit else old
        lines[ids, j] = k if hit else lines[ids, j]


@njit
def trace_hull(
    lines: FloatArray, depth: int, ids: int, first: Any, last: Any, k: Any, item: Any, ray: Ray, faces: FloatArray
) -> None:
    """Intersect rays with a hull: clip them by one half-space after the other.

    Where the eye is outside a face, the ray can only enter the half-space; otherwise it can only leave it.
    """
    ax, ay, az, bx, by, bz = ray
    for j in range(first, last):
        lines[ENTER, j] = ZERO
        lines[LEAVE, j] = FAR
    for face in range(item.first, item.first + item.count):
        nx, ny, nz = faces[face, 0], faces[face, 1], faces[face, 2]
        height = nx * item.eye_x + ny * item.eye_y + nz * item.eye_z - faces[face, 3]
        start, step = nx * ax + ny * ay + nz * az, nx * bx + ny * by + nz * bz
        if height > ZERO:
            for j in range(first, last):
                fall = -(start + lines[PIXEL_X, j] * step)
                t = height / max(fall, TINY)
                lines[ENTER, j] = max(lines[ENTER, j], t)
        else:
            for j in range(first, last):
                rise = start + lines[PIXEL_X, j] * step
                t = -height / max(rise, TINY)
                lines[LEAVE, j] = min(lines[LEAVE, j], t)
    for j in range(first, last):
        t = lines[ENTER, j]
        old = lines[depth, j]
        hit = (t <= lines[LEAVE, j]) & (t > NEAR) & (t * NEARER < old)
        lines[depth, j] = t if hit else old
        lines[ids, j] = k if hit else lines[ids, j]


@inline_njit
def find_row_form(view_ray: Ray, x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """Return start and step, along a row, of the dot product of its rays with (x, y, z)."""
    ax, ay, az, bx, by, bz = view_ray
    return ax * x + ay * y + az * z, bx * x + by * y + bz * z


@inline_njit
def find_depth(v: Any, item: Any) -> Any:
    """Return the depth of a point (m from the eye, in the item's frame)."""
    return v[0] * item.forward_x + v[1] * item.forward_y + v[2] * item.forward_z


@inline_njit
def extend(bounds: Any, v: Any, depth: Any, item: Any, look: Any) -> Any:
    """Return `bounds` extended by a point (m from the eye, in the item's frame) in front of the eye."""
    left, right, top, bottom = bounds
    scale = ONE / (look.step * depth)
    x = (v[0] * item.right_x + v[1] * item.right_y + v[2] * item.right_z) * scale - look.left / look.step
    y = look.top / look.step - (v[0] * item.up_x + v[1] * item.up_y + v[2] * item.up_z) * scale
    return min(left, x), max(right, x), min(top, y), max(bottom, y)


@njit
def find_bounds(corners: Any, item: Any, look: Any) -> Any:
    """Return the bounds of the part of a triangle beyond the depth NEAR; those of nothing if there is none."""
    bounds = NOWHERE
    for i in range(3):
        u, v = corners[i], corners[(i + 1) % 3]
        start, end = find_depth(u, item), find_depth(v, item)
        if start > NEAR:
            bounds = extend(bounds, u, start, item, look)
        if (start > NEAR) != (end > NEAR):
            share = (NEAR - start) / (end - start)
            crossing = (u[0] + share * (v[0] - u[0]), u[1] + share * (v[1] - u[1]), u[2] + share * (v[2] - u[2]))
            bounds = extend(bounds, crossing, NEAR, item, look)
    return bounds


@njit
def trace_triangle(
    band: FloatArray, start: int, end: int, k: Any, item: Any, look: Any, shift: Any, u: Any, v: Any, w: Any, out: Any
) -> None:
    """Intersect the rays of rows start..end-1 with a triangle u, v, w (m from the eye, in the item's frame).

    Corners are counter-clockwise seen from outside. A ray is inside if its dot products with the normals of the
    planes through the eye and each edge are all at most 0, which also holds for corners behind the eye: Olano and
    Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997.
    """
    n = cross(sub(v, u), sub(w, u))
    height = dot(n, u)
    if height >= ZERO:  # back face
        return
    left, right, top, bottom = find_bounds((u, v, w), item, look)
    width = f4(band.shape[2])
    if right < -ONE or left > width + ONE or bottom < f4(start) - ONE or top > f4(end) + ONE:
        return
    first, last = np.uint64(max(left - ONE, ZERO)), np.uint64(min(right + TWO, width))
    edge_u, edge_v, edge_w = cross(v, w), cross(w, u), cross(u, v)
    shift_x, shift_y, depth, ids = shift[0], shift[1], out[0], out[1]
    top_row: Any = max(start, np.int64(max(top - ONE, ZERO)))
    end_row: Any = min(end, np.int64(bottom) + 2)
    for row in range(top_row, end_row):
        ray = find_ray(item, look, shift_x * look.step, look.top - (f4(row) + HALF + shift_y) * look.step)
        a0, b0 = find_row_form(ray, edge_u[0], edge_u[1], edge_u[2])
        a1, b1 = find_row_form(ray, edge_v[0], edge_v[1], edge_v[2])
        a2, b2 = find_row_form(ray, edge_w[0], edge_w[1], edge_w[2])
        a3, b3 = find_row_form(ray, n[0], n[1], n[2])
        i = row - start
        for j in range(first, last):
            c = band[i, PIXEL_X, j]
            t = height / min(a3 + c * b3, -TINY)
            inside = (a0 + c * b0 <= ZERO) & (a1 + c * b1 <= ZERO) & (a2 + c * b2 <= ZERO)
            old = band[i, depth, j]
            hit = inside & (t > NEAR) & (t * NEARER < old)
            band[i, depth, j] = t if hit else old
            band[i, ids, j] = k if hit else band[i, ids, j]


@inline_njit
def find_corners(points: FloatArray, at: Any, columns: Any, eye: Any) -> Any:
    """Return the corners of the cell of a heightfield that begins at entry `at`, in order around it, m from the eye."""
    first = sub((points[at, 0], points[at, 1], points[at, 2]), eye)
    at += 1
    second = sub((points[at, 0], points[at, 1], points[at, 2]), eye)
    at += columns
    third = sub((points[at, 0], points[at, 1], points[at, 2]), eye)
    at -= 1
    return first, second, third, sub((points[at, 0], points[at, 1], points[at, 2]), eye)


@njit
def measure_cells(items: NDArray[np.void], count: int, looks: NDArray[np.void], points: FloatArray) -> None:
    """Set columns 3 and 4 of ``points`` to the top and bottom, in px, of the cell of a heightfield that begins there.

    Cells behind the eye and beside the picture are nowhere; of those that reach behind it, the part in front counts.
    """
    look = looks[0]
    width = f4(-TWO * look.left / look.step)
    for k in range(count):
        item = items[k]
        if item.kind != HEIGHTFIELD:
            continue
        eye = (item.eye_x, item.eye_y, item.eye_z)
        for r in range(item.rows - 1):
            for c in range(item.columns - 1):
                at = item.first + r * item.columns + c
                p, q, s, u = find_corners(points, at, item.columns, eye)
                one, other = find_bounds((p, q, s), item, look), find_bounds((p, s, u), item, look)
                beside = max(one[1], other[1]) < -ONE or min(one[0], other[0]) > width + ONE
                points[at, 3] = FAR if beside else min(one[2], other[2])
                points[at, 4] = -FAR if beside else max(one[3], other[3])


@njit
def trace_field(
    band: FloatArray, start: int, end: int, k: Any, item: Any, look: Any, shift: Any, points: FloatArray, out: Any
) -> None:
    """Intersect rays with the triangles of a heightfield; a cell's diagonal joins its lowest and highest indices.

    ``points`` (vertex, 5): m, and where ``measure_cells`` found the cells.
    """
    eye = (item.eye_x, item.eye_y, item.eye_z)
    columns = item.columns
    for r in range(item.rows - 1):
        for c in range(columns - 1):
            at = item.first + r * columns + c
            if points[at, 4] < f4(start) - ONE or points[at, 3] > f4(end) + ONE:
                continue
            p, q, s, u = find_corners(points, at, columns, eye)
            trace_triangle(band, start, end, k, item, look, shift, p, q, s, out)
            trace_triangle(band, start, end, k, item, look, shift, p, s, u, out)


@njit
def find_visible(lines: FloatArray, k: Any, left: int, right: int) -> tuple[Any, Any]:
    """Return (first, last), whole groups of LANES columns that hold all pixels of item k; first >= last if none."""
    first, last = np.uint64(left), np.uint64(right)
    while first < last and lines[ID, first] != k:
        first += np.uint64(1)
    while first < last and lines[ID, last - np.uint64(1)] != k:
        last -= np.uint64(1)
    return np.int64(first) // LANES * LANES, (np.int64(last) + LANES - 1) // LANES * LANES if first < last else 0


@njit
def find_columns(items: NDArray[np.void], count: int, row: int) -> tuple[int, int]:
    """Return (first, last): columns first..last-1 of the row hold all items but planes; first >= last if none."""
    first, last = 1 << 30, 0
    for k in range(count):
        item = items[k]
        if item.top <= row < item.bottom and item.kind != PLANE:
            first, last = min(first, item.left), max(last, item.right)
    return first, last


@njit
def trace_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    count: int,
    looks: NDArray[np.void],
    faces: FloatArray | None,
    points: FloatArray | None,
    shift_x: Any,
    shift_y: Any,
    depth: int,
    ids: int,
) -> None:
    """Find the nearest depth and id in the rows start..end-1, at an offset (px) from the pixel centres.

    For the samples of antialiasing (`ids` other than ID) only the columns of `find_columns` are filled.
    """
    look = looks[0]
    for row in range(start, end):
        lines = band[row - start]
        y = look.top - (f4(row) + HALF + shift_y) * look.step
        left, right = 0, lines.shape[1]
        if ids != ID:
            left, right = find_columns(items, count, row)
        for j in range(np.uint64(left), np.uint64(max(left, right))):
            lines[depth, j] = FAR
            lines[ids, j] = SKY
        for k in range(count):
            item = items[k]
            if not (item.top <= row < item.bottom and left < right):
                continue
            first, last, me = np.uint64(max(item.left, left)), np.uint64(min(item.right, right)), f4(k)
            ray = find_ray(item, look, shift_x * look.step, y)
            if item.kind == BOX:
                trace_box(lines, depth, ids, first, last, me, item, ray)
            elif item.kind == CAPSULE:
                trace_capsule(lines, depth, ids, first, last, me, item, ray)
            elif item.kind == CYLINDER:
                trace_cylinder(lines, depth, ids, first, last, me, item, ray)
            elif item.kind == PLANE:
                trace_plane(lines, depth, ids, first, last, me, item, ray)
            elif faces is not None and item.kind == HULL:
                trace_hull(lines, depth, ids, first, last, me, item, ray, faces)
    if points is not None:
        for k in range(count):
            item = items[k]
            if item.kind == HEIGHTFIELD and item.top < end and item.bottom > start:
                trace_field(band, start, end, f4(k), item, look, (shift_x, shift_y), points, (depth, ids))
