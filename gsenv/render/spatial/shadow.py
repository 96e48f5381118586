"""Row kernels of the sun's shadows and of the dimness near other things.

A shadow ray runs from the visible point to the sun. What counts is how near it comes to the occluder: s, negative
where it hits, at the distance t. The sun's disc, seen as wide as w, is covered by about 1/2 - s / (2 w t). For
convex shapes one evaluation gives s, in closed form: no marching, and no shape shadows itself. What several
occluders cover is added up, so that no light falls through the seams of a wall.
"""

from typing import Any

import numpy as np

from gsenv.render.spatial.depth import Ray, nonzero
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
    SHADOW,
    TINY,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.render.spatial.surface import smooth
from gsenv.solver.jit import inline_njit, njit

ENTER, ENTER_SPEED, LEAVE, LEAVE_SPEED = SCRATCH, SCRATCH + 1, SCRATCH + 2, SCRATCH + 3
NEAREST = SCRATCH
EDGE = f4(0.75)  # px, half width of the sharpest shadow edge
DIM = f4(0.62)  # of the sky's light that a near thing takes at most


@inline_njit
def cover(lines: FloatArray, j: Any, m: Any, gap: Any, distance: Any, softness: Any, edge: Any) -> None:
    """Add a shadow to pixel j of item m, whose ray passes an occluder with that gap at that distance."""
    width = max(softness * distance, edge)
    part = smooth(HALF - HALF * gap / width)
    part = part if (lines[ID, j] == m) & (distance > ZERO) else ZERO
    lines[SHADOW, j] += part


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
    qx, qy, qz = lx * lx, ly * ly, lz * lz
    vx, vy, vz = abs(lx), abs(ly), abs(lz)
    wx, wy, wz = abs(ix) * sx, abs(iy) * sy, abs(iz) * sz
    for j in range(first, last):
        c, t = lines[PIXEL_X, j], lines[DEPTH, j]
        x, y, z = ox + t * (ax + c * bx), oy + t * (ay + c * by), oz + t * (az + c * bz)
        mx, my, mz = -x * ix, -y * iy, -z * iz
        enter = max(max(mx - wx, my - wy), mz - wz)
        leave = min(min(mx + wx, my + wy), mz + wz)
        enter_speed = vx if enter == mx - wx else (vy if enter == my - wy else vz)
        leave_speed = vx if leave == mx + wx else (vy if leave == my + wy else vz)
        depth = (enter - leave) * enter_speed * leave_speed / (enter_speed + leave_speed)
        u, v = leave_speed * leave_speed, enter_speed * enter_speed
        s = max((u * leave + v * enter) / (u + v), ZERO)
        for _ in range(2):
            px, py, pz = x + s * lx, y + s * ly, z + s * lz
            ex, ey, ez = max(abs(px) - sx, ZERO), max(abs(py) - sy, ZERO), max(abs(pz) - sz, ZERO)
            slope = (lx * ex if px > ZERO else -lx * ex) + (ly * ey if py > ZERO else -ly * ey)
            slope += lz * ez if pz > ZERO else -lz * ez
            bend = (qx if ex > ZERO else ZERO) + (qy if ey > ZERO else ZERO) + (qz if ez > ZERO else ZERO)
            s = max(s - slope / max(bend, f4(1e-4)), ZERO)
        ex, ey, ez = abs(x + s * lx) - sx, abs(y + s * ly) - sy, abs(z + s * lz) - sz
        ex, ey, ez = max(ex, ZERO), max(ey, ZERO), max(ez, ZERO)
        away = np.sqrt(ex * ex + ey * ey + ez * ez)
        hit = (enter < leave) & (leave > ZERO)
        cover(lines, j, m, depth if hit else away, max(enter, ZERO) if hit else s, softness, EDGE * step * t)


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
            side, end = max(rho - radius, ZERO), max(abs(pz) - half, ZERO)
            slope = side * (px * lx + py * ly) / max(rho, TINY) + (end * lz if pz > ZERO else -end * lz)
            bend = (flat if side > ZERO else ZERO) + (upright if end > ZERO else ZERO)
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
def shade(
    lines: FloatArray, first: Any, last: Any, receiver: int, item: Any, ray: Ray, look: Any, faces: FloatArray
) -> None:
    """Shadow of `item` on the pixels of item `receiver`."""
    m = f4(receiver)
    if item.kind == BOX:
        shade_box(lines, first, last, m, item, ray, look.softness, look.step)
    elif item.kind == CAPSULE:
        shade_capsule(lines, first, last, m, item, ray, look.softness, look.step)
    elif item.kind == CYLINDER:
        shade_cylinder(lines, first, last, m, item, ray, look.softness, look.step)
    elif item.kind == HULL:
        shade_hull(lines, first, last, m, item, ray, look.softness, look.step, faces)


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


@njit
def dim(lines: FloatArray, first: Any, last: Any, receiver: int, item: Any, ray: Ray, faces: FloatArray) -> None:
    """Take some of the sky's light from points near `item`: one look at its distance from just above them."""
    m = f4(receiver)
    reach = item.reach
    inverse = ONE / max(reach, TINY)
    sx, sy, sz, radius = item.size_x, item.size_y, item.size_z, item.radius
    if item.kind == PLANE:
        for j in range(first, last):
            lines[NEAREST, j] = probe(item, ray, lines, j, reach)[2]
    elif item.kind == CYLINDER:
        for j in range(first, last):
            x, y, z = probe(item, ray, lines, j, reach)
            side, end = np.sqrt(x * x + y * y) - radius, abs(z) - sz
            out_side, out_end = max(side, ZERO), max(end, ZERO)
            lines[NEAREST, j] = np.sqrt(out_side * out_side + out_end * out_end) + min(max(side, end), ZERO)
    elif item.kind == HULL:
        for j in range(first, last):
            lines[NEAREST, j] = -FAR
        for face in range(item.first, item.first + item.count):
            nx, ny, nz = faces[face, 0], faces[face, 1], faces[face, 2]
            for j in range(first, last):
                x, y, z = probe(item, ray, lines, j, reach)
                lines[NEAREST, j] = max(lines[NEAREST, j], nx * x + ny * y + nz * z - faces[face, 3])
    else:
        if item.kind == CAPSULE:
            sx = sy = ZERO
        else:
            radius = ZERO
        for j in range(first, last):
            x, y, z = probe(item, ray, lines, j, reach)
            x, y, z = abs(x) - sx, abs(y) - sy, abs(z) - sz
            ex, ey, ez = max(x, ZERO), max(y, ZERO), max(z, ZERO)
            inside = min(max(x, max(y, z)), ZERO)
            lines[NEAREST, j] = np.sqrt(ex * ex + ey * ey + ez * ez) + inside - radius
    for j in range(first, last):
        taken = DIM * smooth(ONE - lines[NEAREST, j] * inverse)
        lines[OPEN, j] *= ONE - (taken if lines[ID, j] == m else ZERO)
