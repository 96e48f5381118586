"""Row kernels of surface normals and colours, with marks that make rotation visible."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import Ray, find_ray, find_visible
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, HEIGHTFIELD, HULL, PLANE
from gsenv.render.spatial.records import (
    BLUE,
    DEPTH,
    GREEN,
    HALF,
    ID,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    ONE,
    PIXEL_X,
    RED,
    SCRATCH,
    TINY,
    TWO,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.solver.jit import inline_njit, njit

BEVEL = f4(0.07)  # width of shaded bevels over the smallest half extent
HULL_BEVEL = f4(0.035)  # the same for hulls
MIN_BEVEL = f4(1.1)  # px
FOOTPRINT = f4(1.2)  # px, width of the checker's box filter
FARTHEST = f4(1e5)  # m, a plane's pattern is looked up at this depth at most
STRIPE = f4(0.15)  # half width of a ball's stripe over its radius
HUB, SPOKE = f4(0.60), f4(0.085)  # hub radius and half width of a spoke, over a cylinder's radius
QUARTER = f4(0.30)  # contrast of the quarters of a capsule

Rgb = tuple[Any, Any, Any]
Material = tuple[Rgb, Rgb, Rgb, Rgb, Rgb]

SUM_X, SUM_Y, SUM_Z = SCRATCH, SCRATCH + 1, SCRATCH + 2


@inline_njit
def smooth(x: Any) -> Any:
    """Return the smoothstep of x: 0 below 0, 1 above 1, a cubic between."""
    x = min(max(x, ZERO), ONE)
    return x * x * (f4(3.0) - TWO * x)


@inline_njit
def beyond(x: Any, size: Any) -> Any:
    """Return by how much x lies outside -size..size, with the sign of x."""
    return max(x - size, ZERO) + min(x + size, ZERO)


@inline_njit
def load_material(item: Any) -> Material:
    """Return the item's axes, its colour and the difference to its marks' colour.

    They are read before the loop over columns, which would not vectorise otherwise.
    """
    red, green, blue = item.red, item.green, item.blue
    return (
        (item.xx, item.xy, item.xz),
        (item.yx, item.yy, item.yz),
        (item.zx, item.zy, item.zz),
        (red, green, blue),
        (item.mark_red - red, item.mark_green - green, item.mark_blue - blue),
    )


@inline_njit
def store(lines: FloatArray, j: Any, k: Any, material: Material, x: Any, y: Any, z: Any, mark: Any) -> None:
    """Store a local normal of any length and the blend of colour and mark, in columns that show item k.

    They are added to zeros, since a pixel shows one item only; a select would keep the loop from vectorising.
    """
    u, v, w, color, change = material
    scale = ONE / np.sqrt(max(x * x + y * y + z * z, f4(1e-30)))
    x, y, z = x * scale, y * scale, z * scale
    nx = u[0] * x + v[0] * y + w[0] * z
    ny = u[1] * x + v[1] * y + w[1] * z
    nz = u[2] * x + v[2] * y + w[2] * z
    red = color[0] + mark * change[0]
    green = color[1] + mark * change[1]
    blue = color[2] + mark * change[2]
    mine = ONE if lines[ID, j] == k else ZERO
    lines[NORMAL_X, j] += mine * nx
    lines[NORMAL_Y, j] += mine * ny
    lines[NORMAL_Z, j] += mine * nz
    lines[RED, j] += mine * red
    lines[GREEN, j] += mine * green
    lines[BLUE, j] += mine * blue


@njit
def paint_box(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any) -> None:
    """Shade a box; the normals of adjacent faces blend over a bevel of at least one pixel, so shading has no steps."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    material = load_material(item)
    sx, sy, sz = item.size_x, item.size_y, item.size_z
    least = BEVEL * min(sx, min(sy, sz))
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        bevel = max(least, MIN_BEVEL * pixel * t)
        x, y, z = beyond(x, sx - bevel), beyond(y, sy - bevel), beyond(z, sz - bevel)
        ex, ey, ez = abs(x), abs(y), abs(z)
        # midway between two faces, where both normals contribute most, an edge line is darker
        second = max(min(ex, ey), min(max(ex, ey), ez))
        store(lines, j, k, material, x * ex, y * ey, z * ez, HALF * smooth(second / bevel))


@njit
def paint_capsule(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any) -> None:
    """Shade a capsule or sphere, with stripes around spheres and two darker quarters on capsules."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    material = load_material(item)
    half, radius = item.size_z, item.radius
    ball = ONE if item.ball == 1 and item.mark == 1 else ZERO
    quarter = QUARTER if item.ball == 0 and item.mark == 1 else ZERO
    stripe = STRIPE * radius
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        sharp = ONE / max(TWO * pixel * t, TINY)
        rings = max(smooth((stripe - abs(z)) * sharp + HALF), smooth((stripe - abs(x)) * sharp + HALF))
        nearest = min(abs(x), abs(y))
        sides = smooth((nearest if x * y > ZERO else -nearest) * sharp + HALF)
        store(lines, j, k, material, x, y, z - min(max(z, -half), half), ball * rings + quarter * sides)


@njit
def paint_cylinder(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any) -> None:
    """Shade a cylinder, with a hub and spokes on both ends and darker quarters around the side."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    material = load_material(item)
    half, radius = item.size_z, item.radius
    least = BEVEL * min(half, radius)
    marked = ONE if item.mark == 1 else ZERO
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        bevel = max(least, MIN_BEVEL * pixel * t)
        rho = np.sqrt(x * x + y * y)
        side, z = max(rho - radius + bevel, ZERO), beyond(z, half - bevel)
        end = abs(z)
        sharp = ONE / max(TWO * pixel * t, TINY)
        nearest = min(abs(x), abs(y))
        hub = smooth((HUB * radius - rho) * sharp + HALF)
        spoke = smooth((SPOKE * radius - nearest) * sharp + HALF)
        spoke *= smooth((f4(0.85) * HUB * radius - rho) * sharp + HALF)
        quarter = f4(0.10) * smooth((nearest if x * y > ZERO else -nearest) * sharp + HALF)
        mark = hub * (ONE - f4(0.8) * spoke) if end > side else quarter
        flat = side * side / max(rho, TINY)
        store(lines, j, k, material, x * flat, y * flat, z * end, marked * mark)


@njit
def paint_hull(
    lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any, faces: FloatArray
) -> None:
    """Shade a hull; its normal is a weighted sum of the normals of all faces within a bevel's width."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    material = load_material(item)
    least = HULL_BEVEL * min(item.size_x, min(item.size_y, item.size_z))
    for j in range(first, last):
        lines[SUM_X, j] = lines[SUM_Y, j] = lines[SUM_Z, j] = ZERO
    for face in range(item.first, item.first + item.count):
        nx, ny, nz = faces[face, 0], faces[face, 1], faces[face, 2]
        height = nx * ox + ny * oy + nz * oz - faces[face, 3]
        start, step = nx * ax + ny * ay + nz * az, nx * bx + ny * by + nz * bz
        for j in range(first, last):
            t = lines[DEPTH, j]
            bevel = max(least, MIN_BEVEL * pixel * t)
            near = max(height + t * (start + lines[PIXEL_X, j] * step) + bevel, ZERO)
            lines[SUM_X, j] += near * near * nx
            lines[SUM_Y, j] += near * near * ny
            lines[SUM_Z, j] += near * near * nz
    for j in range(first, last):
        store(lines, j, k, material, lines[SUM_X, j], lines[SUM_Y, j], lines[SUM_Z, j], ZERO)


@inline_njit
def wave(x: Any) -> Any:
    """Return the integral of the square wave of period 2: a triangle wave in 0..1."""
    x = HALF * x
    whole = f4(np.int32(x))  # rounded towards zero
    part = x - whole
    part = part + ONE if part < ZERO else part
    return ONE - TWO * abs(part - HALF)


@inline_njit
def find_check(x: Any, y: Any, dx: Any, dy: Any, dz: Any, across: Any) -> Any:
    """Return the fraction of dark squares in a pixel's footprint at (x, y); lengths are in squares.

    The box filter prevents moire far away. The footprint is `across` wide, and longer along a grazing ray
    (dx, dy, dz).
    """
    level = ONE / np.sqrt(max(dx * dx + dy * dy, TINY))
    ux, uy = abs(dx * level), abs(dy * level)
    along = min(across / max(-dz, f4(0.01)), f4(8.0))
    fx, fy = max(ux * along + uy * across, f4(1e-3)), max(uy * along + ux * across, f4(1e-3))
    px = (wave(x + HALF * fx) - wave(x - HALF * fx)) / fx
    py = (wave(y + HALF * fy) - wave(y - HALF * fy)) / fy
    return HALF - HALF * px * py


@njit
def paint_plane(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any, cell: Any) -> None:
    """Shade a plane with a checkerboard pattern."""
    ax, ay, az, bx, by, bz = ray
    ox, oy = item.eye_x, item.eye_y
    material = load_material(item)
    scale = ONE / cell
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], min(lines[DEPTH, j], FARTHEST)
        dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
        mark = find_check((ox + t * dx) * scale, (oy + t * dy) * scale, dx, dy, dz, FOOTPRINT * pixel * t * scale)
        store(lines, j, k, material, ZERO, ZERO, ONE, mark)


@njit
def paint_field(
    lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any, cell: Any, points: FloatArray
) -> None:
    """Shade a heightfield: normals interpolate the slopes at the samples; the checkerboard is that of planes."""
    ax, ay, az, bx, by, bz = ray
    material = load_material(item)
    scale = ONE / cell
    columns, rows, start = item.columns, item.rows, item.first
    end = start + columns * rows - 1
    x0, y0 = points[start, 0], points[start, 1]
    width, depth = points[end, 0] - x0, points[end, 1] - y0
    per_x, per_y = f4(columns - 1) / width, f4(rows - 1) / depth
    for j in range(first, last):
        if lines[ID, j] != k:
            continue
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
        x, y = item.eye_x + t * dx, item.eye_y + t * dy
        u, v = min(max((x - x0) * per_x, ZERO), f4(columns - 1)), min(max((y - y0) * per_y, ZERO), f4(rows - 1))
        slope_x, slope_y = find_slopes(points, start, columns, rows, u, v)
        mark = find_check(x * scale, y * scale, dx, dy, dz, FOOTPRINT * pixel * t * scale)
        store(lines, j, k, material, -slope_x * per_x, -slope_y * per_y, ONE, mark)


@njit
def find_slopes(points: FloatArray, start: int, columns: int, rows: int, u: Any, v: Any) -> tuple[Any, Any]:
    """Return the slopes (m per cell) at (u, v) cells: central differences at four samples, bilinear between them."""
    i: Any = min(np.int64(u), columns - 2)
    j: Any = min(np.int64(v), rows - 2)
    u, v = u - f4(i), v - f4(j)
    slope_x, slope_y = ZERO, ZERO
    for corner in range(4):
        a, b = i + corner % 2, j + corner // 2
        weight = (u if corner % 2 == 1 else ONE - u) * (v if corner // 2 == 1 else ONE - v)
        west, east = max(a - 1, 0), min(a + 1, columns - 1)
        south, north = max(b - 1, 0), min(b + 1, rows - 1)
        rise_x = points[start + b * columns + east, 2] - points[start + b * columns + west, 2]
        rise_y = points[start + north * columns + a, 2] - points[start + south * columns + a, 2]
        slope_x += weight * rise_x / f4(east - west)
        slope_y += weight * rise_y / f4(north - south)
    return slope_x, slope_y


@njit
def paint_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    count: int,
    looks: NDArray[np.void],
    faces: FloatArray | None,
    points: FloatArray | None,
    spans: NDArray[np.int64],
) -> None:
    """Compute normals and colours in the rows start..end-1; `spans` (row, item, 2) gets each item's visible columns."""
    look = looks[0]
    step = look.step
    for row in range(start, end):
        lines = band[row - start]
        y = look.top - (f4(row) + HALF) * step
        for line in range(NORMAL_X, BLUE + 1):
            for j in range(np.uint64(0), np.uint64(lines.shape[1])):
                lines[line, j] = ZERO
        for k in range(count):
            item = items[k]
            if not item.top <= row < item.bottom:
                spans[row - start, k, 0] = spans[row - start, k, 1] = 0
                continue
            first, last = find_visible(lines, f4(k), item.left, item.right)
            spans[row - start, k, 0], spans[row - start, k, 1] = first, last
            if first >= last:
                continue
            ray, me = find_ray(item, look, ZERO, y), f4(k)
            first, last = np.uint64(first), np.uint64(last)
            if item.kind == BOX:
                paint_box(lines, first, last, me, item, ray, step)
            elif item.kind == CAPSULE:
                paint_capsule(lines, first, last, me, item, ray, step)
            elif item.kind == CYLINDER:
                paint_cylinder(lines, first, last, me, item, ray, step)
            elif item.kind == PLANE:
                paint_plane(lines, first, last, me, item, ray, step, look.cell)
            elif faces is not None and item.kind == HULL:
                paint_hull(lines, first, last, me, item, ray, step, faces)
            elif points is not None and item.kind == HEIGHTFIELD:
                paint_field(lines, first, last, me, item, ray, step, look.cell, points)
