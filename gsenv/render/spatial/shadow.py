"""Row kernels of the sun's shadows.

A shadow ray runs from the visible point to the sun. What counts is how near it comes to the occluder: s, negative
where it hits, at the distance t. The sun's disc, seen as wide as w, is covered by about 1/2 - s / (2 w t). For
convex shapes one evaluation gives s, in closed form: no marching, and no shape shadows itself. What several
occluders cover is added up, so that no light falls through the seams of a wall.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import Ray, find_ray, nonzero
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, HULL
from gsenv.render.spatial.records import (
    DEPTH,
    FAR,
    HALF,
    ID,
    ONE,
    PIXEL_X,
    SCRATCH,
    SHADOW,
    TINY,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.render.spatial.surface import beyond, smooth
from gsenv.solver.jit import inline_njit, njit

ENTER, ENTER_SPEED, LEAVE, LEAVE_SPEED = SCRATCH, SCRATCH + 1, SCRATCH + 2, SCRATCH + 3
EDGE = f4(0.75)  # px, half width of the sharpest shadow edge


@inline_njit
def cover(lines: FloatArray, j: Any, m: Any, gap: Any, distance: Any, softness: Any, edge: Any) -> None:
    """Add a shadow to pixel j of item m, whose ray passes an occluder with that gap at that distance."""
    width = max(softness * distance, edge)
    part = smooth(HALF - HALF * gap / width)
    part = part if (lines[ID, j] == m) & (distance > ZERO) else ZERO
    lines[SHADOW, j] += part


@inline_njit
def approach(s: Any, x: Any, y: Any, z: Any, lx: Any, ly: Any, lz: Any, sx: Any, sy: Any, sz: Any) -> Any:
    """Newton's step towards the least distance of (x, y, z) + s (lx, ly, lz) from a box."""
    ex, ey, ez = beyond(x + s * lx, sx), beyond(y + s * ly, sy), beyond(z + s * lz, sz)
    bend_x = lx * lx if ex != ZERO else ZERO
    bend_y = ly * ly if ey != ZERO else ZERO
    bend_z = lz * lz if ez != ZERO else ZERO
    slope = lx * ex + ly * ey + lz * ez
    return max(s - slope / max(bend_x + bend_y + bend_z, f4(1e-4)), ZERO)


@njit
def shade_box(lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, softness: Any, step: Any) -> None:
    """The gap between the latest entry into a slab and the earliest leave; two steps of Newton's where it misses.

    The squared distance along the ray is convex and piecewise quadratic.
    """
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    sx, sy, sz = item.size_x, item.size_y, item.size_z
    lx, ly, lz = nonzero(item.sun_x), nonzero(item.sun_y), nonzero(item.sun_z)
    ix, iy, iz = ONE / lx, ONE / ly, ONE / lz
    vx, vy, vz = abs(lx), abs(ly), abs(lz)
    wx, wy, wz = abs(ix) * sx, abs(iy) * sy, abs(iz) * sz
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        mx, my, mz = -x * ix, -y * iy, -z * iz
        ex, ey, ez = mx - wx, my - wy, mz - wz
        enter, u = max(ex, ey), vx if ex > ey else vy
        u = u if enter > ez else vz  # the speed into the slab that it enters last
        enter = max(enter, ez)
        ex, ey, ez = mx + wx, my + wy, mz + wz
        leave, v = min(ex, ey), vx if ex < ey else vy
        v = v if leave < ez else vz
        leave = min(leave, ez)
        depth = (enter - leave) * u * v / (u + v)
        u, v = u * u, v * v
        s = max((u * enter + v * leave) / (u + v), ZERO)
        s = approach(s, x, y, z, lx, ly, lz, sx, sy, sz)
        s = approach(s, x, y, z, lx, ly, lz, sx, sy, sz)
        ex, ey, ez = beyond(x + s * lx, sx), beyond(y + s * ly, sy), beyond(z + s * lz, sz)
        away = np.sqrt(ex * ex + ey * ey + ez * ez)
        hit = (enter < leave) & (leave > ZERO)
        near = max(enter, ZERO)
        gap, place = depth if hit else away, near if hit else s
        cover(lines, j, m, gap, place, softness, EDGE * step * t)


@njit
def shade_capsule(
    lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, softness: Any, step: Any
) -> None:
    """The distance between a line and a segment, exactly."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    lx, ly, lz = item.sun_x, item.sun_y, item.sun_z
    half, radius = item.size_z, item.radius
    inverse = ONE / max(lx * lx + ly * ly, f4(1e-6))
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        flat = -(x * lx + y * ly)
        place = min(max(z + flat * inverse * lz, -half), half)
        s = flat - (z - place) * lz
        on = max(s, ZERO)
        dx, dy, dz = x + on * lx, y + on * ly, z + on * lz - place
        gap = np.sqrt(dx * dx + dy * dy + dz * dz) - radius
        cover(lines, j, m, gap, s, softness, EDGE * step * t)


@njit
def shade_cylinder(
    lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, softness: Any, step: Any
) -> None:
    """From the middle of the chord (or of the gap between its ends), three steps down the convex distance."""
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    lx, ly, lz = item.sun_x, item.sun_y, nonzero(item.sun_z)
    half, radius = item.size_z, item.radius
    flat = max(lx * lx + ly * ly, f4(1e-6))
    inverse, iz, upright = ONE / flat, ONE / lz, lz * lz
    wz = abs(iz) * half
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        moment = x * ly - y * lx
        chord = np.sqrt(max(flat * radius * radius - moment * moment, ZERO)) * inverse
        middle = -(x * lx + y * ly) * inverse
        enter, leave = max(middle - chord, -z * iz - wz), min(middle + chord, -z * iz + wz)
        s = max(HALF * (enter + leave), ZERO)
        for _ in range(3):
            px, py, pz = x + s * lx, y + s * ly, z + s * lz
            rho = np.sqrt(px * px + py * py)
            side, end = max(rho - radius, ZERO), beyond(pz, half)
            slope = side * (px * lx + py * ly) / max(rho, TINY) + end * lz
            bend = (flat if side > ZERO else ZERO) + (upright if end != ZERO else ZERO)
            s = max(s - slope / max(bend, f4(1e-4)), ZERO)
        px, py, pz = x + s * lx, y + s * ly, z + s * lz
        side, end = np.sqrt(px * px + py * py) - radius, abs(pz) - half
        out_side, out_end = max(side, ZERO), max(end, ZERO)
        gap = np.sqrt(out_side * out_side + out_end * out_end) + min(max(side, end), ZERO)
        s = s if leave > ZERO else ZERO
        cover(lines, j, m, gap, s, softness, EDGE * step * t)


@njit
def shade_hull(
    lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, softness: Any, step: Any, faces: FloatArray
) -> None:
    """As for boxes, with half-spaces in place of slabs and mitred distances."""
    ax, ay, az, bx, by, bz = ray
    for j in range(first, last):
        lines[ENTER, j], lines[ENTER_SPEED, j] = -FAR, ONE
        lines[LEAVE, j], lines[LEAVE_SPEED, j] = FAR, ONE
    for face in range(item.first, item.first + item.count):
        nx, ny, nz = faces[face, 0], faces[face, 1], faces[face, 2]
        height = nx * item.eye_x + ny * item.eye_y + nz * item.eye_z - faces[face, 3]
        start, slope = nx * ax + ny * ay + nz * az, nx * bx + ny * by + nz * bz
        speed = nonzero(nx * item.sun_x + ny * item.sun_y + nz * item.sun_z)
        inverse = ONE / speed
        if speed < ZERO:
            for j in range(first, last):
                s = -(height + lines[DEPTH, j] * (start + lines[PIXEL_X, j] * slope)) * inverse
                later = s > lines[ENTER, j]
                lines[ENTER, j] = s if later else lines[ENTER, j]
                lines[ENTER_SPEED, j] = -speed if later else lines[ENTER_SPEED, j]
        else:
            for j in range(first, last):
                s = -(height + lines[DEPTH, j] * (start + lines[PIXEL_X, j] * slope)) * inverse
                sooner = s < lines[LEAVE, j]
                lines[LEAVE, j] = s if sooner else lines[LEAVE, j]
                lines[LEAVE_SPEED, j] = speed if sooner else lines[LEAVE_SPEED, j]
    for j in range(first, last):
        enter, leave = lines[ENTER, j], lines[LEAVE, j]
        u, v = lines[ENTER_SPEED, j], lines[LEAVE_SPEED, j]
        gap = (enter - leave) * u * v / (u + v)
        s = enter if leave > ZERO else ZERO
        cover(lines, j, m, gap, s, softness, EDGE * step * lines[DEPTH, j])


@njit
def shade_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    pairs: NDArray[np.void],
    looks: NDArray[np.void],
    faces: FloatArray | None,
    spans: NDArray[np.int64],
) -> None:
    """Shadows in the rows start..end-1."""
    look = looks[0]
    step, softness = look.step, look.softness
    for row in range(start, end):
        lines = band[row - start]
        y = look.top - (f4(row) + HALF) * step
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            lines[SHADOW, j] = ZERO
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
            if item.kind == BOX:
                shade_box(lines, first, last, m, item, ray, softness, step)
            elif item.kind == CAPSULE:
                shade_capsule(lines, first, last, m, item, ray, softness, step)
            elif item.kind == CYLINDER:
                shade_cylinder(lines, first, last, m, item, ray, softness, step)
            elif faces is not None and item.kind == HULL:
                shade_hull(lines, first, last, m, item, ray, softness, step, faces)
