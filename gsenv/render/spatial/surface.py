"""Row kernels of the visible surfaces: normals, and colours with the marks that show how things turn."""

from typing import Any

import numpy as np

from gsenv.render.spatial.depth import Ray
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, HULL, PLANE
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

BEVEL = f4(0.07)  # of the smallest half extent
MIN_BEVEL = f4(1.1)  # px
STRIPE = f4(0.15)  # half width over a ball's radius
HUB, SPOKE = f4(0.60), f4(0.085)  # of a cylinder's radius
QUARTER = f4(0.30)  # strength of the marks on capsules and on the sides of cylinders
SUM_X, SUM_Y, SUM_Z = SCRATCH, SCRATCH + 1, SCRATCH + 2


@inline_njit
def smooth(x: Any) -> Any:
    """0 below 0, 1 above 1, a cubic between."""
    x = min(max(x, ZERO), ONE)
    return x * x * (f4(3.0) - TWO * x)


@inline_njit
def signed(size: Any, sign: Any) -> Any:
    return size if sign > ZERO else -size


@inline_njit
def store(lines: FloatArray, j: Any, k: Any, item: Any, x: Any, y: Any, z: Any, mark: Any) -> None:
    """A local normal of any length, and the share of the mark's colour, where item k shows."""
    mine = lines[ID, j] == k
    scale = ONE / np.sqrt(max(x * x + y * y + z * z, TINY * TINY))
    x, y, z = x * scale, y * scale, z * scale
    lines[NORMAL_X, j] = item.xx * x + item.yx * y + item.zx * z if mine else lines[NORMAL_X, j]
    lines[NORMAL_Y, j] = item.xy * x + item.yy * y + item.zy * z if mine else lines[NORMAL_Y, j]
    lines[NORMAL_Z, j] = item.xz * x + item.yz * y + item.zz * z if mine else lines[NORMAL_Z, j]
    lines[RED, j] = item.red + mark * (item.mark_red - item.red) if mine else lines[RED, j]
    lines[GREEN, j] = item.green + mark * (item.mark_green - item.green) if mine else lines[GREEN, j]
    lines[BLUE, j] = item.blue + mark * (item.mark_blue - item.blue) if mine else lines[BLUE, j]


@njit
def paint_box(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any) -> None:
    """Faces that turn into one another over a bevel, of a pixel at least: no hard steps inside."""
    ax, ay, az, bx, by, bz = ray
    sx, sy, sz = item.size_x, item.size_y, item.size_z
    least = BEVEL * min(sx, min(sy, sz))
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = item.eye_x + t * (ax + c * bx), item.eye_y + t * (ay + c * by), item.eye_z + t * (az + c * bz)
        bevel = max(least, MIN_BEVEL * pixel * t)
        ex, ey, ez = abs(x) - sx + bevel, abs(y) - sy + bevel, abs(z) - sz + bevel
        ex, ey, ez = max(ex, ZERO), max(ey, ZERO), max(ez, ZERO)
        # Half way between two faces both are deep in the bevel: a darker edge line.
        second = max(min(ex, ey), min(max(ex, ey), ez))
        edge = smooth(second / bevel)
        store(lines, j, k, item, signed(ex * ex, x), signed(ey * ey, y), signed(ez * ez, z), HALF * edge)


@njit
def paint_capsule(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any) -> None:
    """Stripes round balls, two quarters of another shade on capsules."""
    ax, ay, az, bx, by, bz = ray
    half, radius = item.size_z, item.radius
    ball = ONE if item.ball == 1 and item.mark == 1 else ZERO
    quarter = QUARTER if item.ball == 0 and item.mark == 1 else ZERO
    stripe = STRIPE * radius
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = item.eye_x + t * (ax + c * bx), item.eye_y + t * (ay + c * by), item.eye_z + t * (az + c * bz)
        sharp = ONE / max(TWO * pixel * t, TINY)
        rings = max(smooth((stripe - abs(z)) * sharp + HALF), smooth((stripe - abs(x)) * sharp + HALF))
        sides = smooth(signed(min(abs(x), abs(y)), x * y) * sharp + HALF)
        store(lines, j, k, item, x, y, z - min(max(z, -half), half), ball * rings + quarter * sides)


@njit
def paint_cylinder(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any) -> None:
    """A hub with spokes on both ends, quarters of another shade round the side."""
    ax, ay, az, bx, by, bz = ray
    half, radius = item.size_z, item.radius
    least = BEVEL * min(half, radius)
    marked = ONE if item.mark == 1 else ZERO
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = item.eye_x + t * (ax + c * bx), item.eye_y + t * (ay + c * by), item.eye_z + t * (az + c * bz)
        bevel = max(least, MIN_BEVEL * pixel * t)
        rho = np.sqrt(x * x + y * y)
        side, end = max(rho - radius + bevel, ZERO), max(abs(z) - half + bevel, ZERO)
        sharp = ONE / max(TWO * pixel * t, TINY)
        nearest = min(abs(x), abs(y))
        hub = smooth((HUB * radius - rho) * sharp + HALF)
        spoke = smooth((SPOKE * radius - nearest) * sharp + HALF) * smooth((f4(0.85) * HUB * radius - rho) * sharp + HALF)
        quarter = f4(0.10) * smooth(signed(nearest, x * y) * sharp + HALF)
        mark = hub * (ONE - f4(0.8) * spoke) if end > side else quarter
        flat = side * side / max(rho, TINY)
        store(lines, j, k, item, x * flat, y * flat, signed(end * end, z), marked * mark)


@njit
def paint_hull(
    lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any, faces: FloatArray
) -> None:
    """The sum of the normals of all faces within a bevel."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    least = BEVEL * min(item.size_x, min(item.size_y, item.size_z))
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
        store(lines, j, k, item, lines[SUM_X, j], lines[SUM_Y, j], lines[SUM_Z, j], ZERO)


@inline_njit
def wave(x: Any) -> Any:
    """Integral of the square wave of period 2: a triangle wave, 0 .. 1."""
    x = HALF * x
    return ONE - TWO * abs(x - np.floor(x) - HALF)


@njit
def paint_plane(lines: FloatArray, first: Any, last: Any, k: Any, item: Any, ray: Ray, pixel: Any, cell: Any) -> None:
    """A checker of two shades, box filtered over the pixel's footprint: no moire in the distance."""
    ax, ay, az, bx, by, bz = ray
    scale = ONE / cell
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
        t = t if lines[ID, j] == k else ZERO
        x, y = (item.eye_x + t * dx) * scale, (item.eye_y + t * dy) * scale
        level = ONE / np.sqrt(max(dx * dx + dy * dy, TINY))
        ux, uy = abs(dx * level), abs(dy * level)
        across = f4(1.2) * pixel * t * scale
        along = min(across / max(-dz, f4(0.01)), f4(8.0))
        fx, fy = max(ux * along + uy * across, f4(1e-3)), max(uy * along + ux * across, f4(1e-3))
        px = (wave(x + HALF * fx) - wave(x - HALF * fx)) / fx
        py = (wave(y + HALF * fy) - wave(y - HALF * fy)) / fy
        mark = HALF - HALF * px * py
        store(lines, j, k, item, ZERO, ZERO, ONE, mark)


@njit
def paint(
    lines: FloatArray, first: Any, last: Any, index: int, item: Any, ray: Ray, look: Any, faces: FloatArray
) -> None:
    """Normals and colours of item `index`."""
    k = f4(index)
    if item.kind == BOX:
        paint_box(lines, first, last, k, item, ray, look.step)
    elif item.kind == CAPSULE:
        paint_capsule(lines, first, last, k, item, ray, look.step)
    elif item.kind == CYLINDER:
        paint_cylinder(lines, first, last, k, item, ray, look.step)
    elif item.kind == PLANE:
        paint_plane(lines, first, last, k, item, ray, look.step, look.cell)
    elif item.kind == HULL:
        paint_hull(lines, first, last, k, item, ray, look.step, faces)
