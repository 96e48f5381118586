"""Row kernels of the sun's shadows.

A shadow ray runs from the visible point to the sun. Let s be its least distance to the occluder, negative where it
hits, and t the distance along the ray at which that occurs. An occluder then covers about 1/2 - s / (2 w t) of the
sun's disc, whose angular radius is w. For convex shapes s has a closed form or a fast iteration, so no ray marching
is needed, and no shape shadows itself. The parts that several occluders cover are added, so that no light falls
through the seams of a wall.
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
PLACE, GAP = SCRATCH + 4, SCRATCH + 5
EDGE = f4(0.75)  # px, half width of the sharpest shadow edge


@inline_njit
def sign(x: Any) -> Any:
    return ONE if x >= ZERO else -ONE


@inline_njit
def cover(lines: FloatArray, j: Any, m: Any, gap: Any, distance: Any, softness: Any, edge: Any) -> None:
    """Add a shadow to pixel j of item m, whose ray passes an occluder at distance `gap`, `distance` along the ray."""
    width = max(softness * distance, edge)
    part = smooth(HALF - HALF * gap / width)
    part = part if (lines[ID, j] == m) & (distance > ZERO) else ZERO
    lines[SHADOW, j] += part


@inline_njit
def find_strip(a: Any, b: Any) -> tuple[Any, Any, Any]:
    """Return 1 / h, 1 / h^2, h^2 = a^2 + b^2, for a ray that crosses two slabs at speeds a and b; FAR if both are 0."""
    h = np.sqrt(a * a + b * b)
    still = FAR if h < f4(1e-3) else ZERO
    h = max(h, f4(1e-3))
    return ONE / h, ONE / (h * h), still


@inline_njit
def cover_strip(
    enter_a: Any, leave_a: Any, enter_b: Any, leave_b: Any, a: Any, b: Any, strip: Any, softness: Any, edge: Any
) -> Any:
    """Return the fraction of the sun behind the strip between two parallel edges of a box, in slabs a and b.

    The ray passes the edge where it enters a and leaves b at the distance (enter_a b - leave_b a) / h.
    """
    inverse, square, still = strip
    gap = (enter_a * b - leave_b * a) * inverse - still
    width = max(softness * (a * enter_a + b * leave_b) * square, edge)
    first = smooth(HALF - HALF * gap / width)
    gap = (enter_b * a - leave_a * b) * inverse - still
    width = max(softness * (b * enter_b + a * leave_a) * square, edge)
    return max(first + smooth(HALF - HALF * gap / width) - ONE, ZERO)


@njit
def shade_box(lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, softness: Any, step: Any) -> None:
    """Add a box's shadow: the product over its three pairs of slabs, so 1/2 at an edge, 1/4 at a right-angled corner.

    `enter` and `leave` are distances times the slab's speed, which avoids divisions by a speed.
    """
    ax, ay, az, bx, by, bz = ray
    ox, oy, oz = item.eye_x, item.eye_y, item.eye_z
    sx, sy, sz = item.size_x, item.size_y, item.size_z
    tx, ty, tz = sign(item.sun_x), sign(item.sun_y), sign(item.sun_z)
    u, v, w = abs(item.sun_x), abs(item.sun_y), abs(item.sun_z)
    xy, yz, zx = find_strip(u, v), find_strip(v, w), find_strip(w, u)
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = -tx * (ox + t * (ax + c * bx)), -ty * (oy + t * (ay + c * by)), -tz * (oz + t * (az + c * bz))
        edge = EDGE * step * t
        part = cover_strip(x - sx, x + sx, y - sy, y + sy, u, v, xy, softness, edge)
        part *= cover_strip(y - sy, y + sy, z - sz, z + sz, v, w, yz, softness, edge)
        part *= cover_strip(z - sz, z + sz, x - sx, x + sx, w, u, zx, softness, edge)
        ahead = min(min(x + sx, y + sy), z + sz) > edge  # a face does not shadow points that lie in it
        lines[SHADOW, j] += part if (lines[ID, j] == m) & ahead else ZERO


@njit
def shade_capsule(
    lines: FloatArray, first: Any, last: Any, m: Any, item: Any, ray: Ray, softness: Any, step: Any
) -> None:
    """Add a capsule's shadow, from the exact distance between the ray and its segment."""
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
    """Add a cylinder's shadow: three Newton steps on its convex distance, from the middle of the ray's chord."""
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
    """Add a hull's shadow, by half-spaces instead of a box's slabs, with distances mitred at edges."""
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
        u, v = lines[ENTER_SPEED, j], lines[LEAVE_SPEED, j]
        s = (u * lines[ENTER, j] + v * lines[LEAVE, j]) / (u + v)
        lines[PLACE, j] = s if lines[LEAVE, j] > ZERO else ZERO
        lines[GAP, j] = -FAR
    for face in range(item.first, item.first + item.count):
        nx, ny, nz = faces[face, 0], faces[face, 1], faces[face, 2]
        height = nx * item.eye_x + ny * item.eye_y + nz * item.eye_z - faces[face, 3]
        start, slope = nx * ax + ny * ay + nz * az, nx * bx + ny * by + nz * bz
        speed = nx * item.sun_x + ny * item.sun_y + nz * item.sun_z
        for j in range(first, last):
            away = height + lines[DEPTH, j] * (start + lines[PIXEL_X, j] * slope) + lines[PLACE, j] * speed
            lines[GAP, j] = max(lines[GAP, j], away)
    for j in range(first, last):
        cover(lines, j, m, lines[GAP, j], lines[PLACE, j], softness, EDGE * step * lines[DEPTH, j])


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
    """Compute the shadows in the rows start..end-1 from all pairs."""
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
