"""Per-picture setup: primitives become items, with rays in their frames and the pixels they may cover."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.primitives import (
    BOX,
    CAPSULE,
    CYLINDER,
    HEIGHTFIELD,
    HULL,
    PLANE,
    SPHERE,
    Meshes,
    Primitives,
)
from gsenv.render.spatial.records import LANES
from gsenv.solver.jit import inline_njit, njit

NEAR_DEPTH = 0.02  # m, items nearer than this get the whole picture as bounds
Bounds = tuple[float, float, float, float]
NO_BOUNDS: Bounds = (1e30, -1e30, 1e30, -1e30)  # left, right, bottom, top: picture coordinates at depth 1
ALL_BOUNDS: Bounds = (-1e30, 1e30, -1e30, 1e30)
CONTACT_REACH = 0.8  # reach of an item's ambient occlusion over its bounding radius, at most
GROUND_SHADE, MARK_SHADE = 0.74, 0.62  # brightness factors of a ground's darker squares and of other dark marks


@njit
def grow(bounds: Bounds, view: Any, x: float, y: float, z: float, radius: float) -> Bounds:
    """Extend `bounds` by the picture of a sphere at (x, y, z), in m from the eye.

    The tangents from the eye to a disc at (p, q), with q the depth, have the slopes
    (p q +- r sqrt(p^2 + q^2 - r^2)) / (q^2 - r^2).
    """
    depth = x * view.forward_x + y * view.forward_y + z * view.forward_z
    if depth <= radius + NEAR_DEPTH:
        return ALL_BOUNDS
    p = x * view.right_x + y * view.right_y + z * view.right_z
    q = x * view.up_x + y * view.up_y + z * view.up_z
    scale = 1.0 / (depth * depth - radius * radius)
    across = radius * np.sqrt(p * p + depth * depth - radius * radius)
    along = radius * np.sqrt(q * q + depth * depth - radius * radius)
    return (
        min(bounds[0], (p * depth - across) * scale),
        max(bounds[1], (p * depth + across) * scale),
        min(bounds[2], (q * depth - along) * scale),
        max(bounds[3], (q * depth + along) * scale),
    )


@njit
def store_bounds(target: Any, view: Any, bounds: Bounds) -> None:
    """Store in an item or a pair the rows and columns of all pixels that `bounds` meets; all zero if there are none.

    Columns come in whole groups of LANES, which may extend beyond the picture's right edge: loops without a
    remainder are faster.
    """
    width, height = view.width, view.height
    left = min(max((bounds[0] - view.left) / view.step, 0.0), float(width))
    right = min(max((bounds[1] - view.left) / view.step + 1.0, 0.0), float(width))
    top = min(max((view.top - bounds[3]) / view.step, 0.0), float(height))
    bottom = min(max((view.top - bounds[2]) / view.step + 1.0, 0.0), float(height))
    if not (bounds[0] <= bounds[1] and left < right and top < bottom):
        left = right = top = bottom = 0.0
    target.left, target.right = int(left) // LANES * LANES, (int(right) + LANES - 1) // LANES * LANES
    target.top, target.bottom = int(top), int(bottom)


@njit
def corner(item: Any, index: int) -> tuple[float, float, float]:
    """Return corner 0..7 of an item's bounding box, in m from the eye."""
    x = item.mid_x + (item.half_x if index & 1 else -item.half_x)
    y = item.mid_y + (item.half_y if index & 2 else -item.half_y)
    z = item.mid_z + (item.half_z if index & 4 else -item.half_z)
    return (
        item.at_x + item.xx * x + item.yx * y + item.zx * z,
        item.at_y + item.xy * x + item.yy * y + item.zy * z,
        item.at_z + item.xz * x + item.yz * y + item.zz * z,
    )


@njit
def set_axes(item: Any, w: float, x: float, y: float, z: float) -> None:
    """Set an item's axes from a unit quaternion."""
    item.xx, item.xy, item.xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    item.yx, item.yy, item.yz = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
    item.zx, item.zy, item.zz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


@njit
def to_frame(item: Any, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a direction of the world in the item's frame."""
    return (
        item.xx * x + item.xy * y + item.xz * z,
        item.yx * x + item.yy * y + item.yz * z,
        item.zx * x + item.zy * y + item.zz * z,
    )


@inline_njit
def set_rays(item: Any, view: Any) -> None:
    """Set the eye, the picture's axes and the sun's direction in the item's frame."""
    item.eye_x, item.eye_y, item.eye_z = to_frame(item, -item.at_x, -item.at_y, -item.at_z)
    item.forward_x, item.forward_y, item.forward_z = to_frame(item, view.forward_x, view.forward_y, view.forward_z)
    item.right_x, item.right_y, item.right_z = to_frame(item, view.right_x, view.right_y, view.right_z)
    item.up_x, item.up_y, item.up_z = to_frame(item, view.up_x, view.up_y, view.up_z)
    item.sun_x, item.sun_y, item.sun_z = to_frame(item, view.sun_x, view.sun_y, view.sun_z)


@inline_njit
def set_mesh_box(item: Any, meshes: Meshes, first: int) -> None:
    """Set the vertex range and bounding box of a hull or heightfield."""
    counts = meshes.counts[first]
    item.first, item.columns, item.rows = first, counts[2], counts[3]
    item.count = counts[1] if item.kind == HULL else counts[2] * counts[3]
    count = counts[0] if item.kind == HULL else counts[2] * counts[3]
    count = min(count, len(meshes.point) - first)
    low_x = low_y = low_z = 1e30
    high_x = high_y = high_z = -1e30
    for k in range(first, first + count):
        x, y, z = meshes.point[k, 0], meshes.point[k, 1], meshes.point[k, 2]
        low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
        high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
    item.mid_x, item.mid_y, item.mid_z = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y), 0.5 * (low_z + high_z)
    item.half_x, item.half_y, item.half_z = high_x - item.mid_x, high_y - item.mid_y, high_z - item.mid_z
    item.size_x, item.size_y, item.size_z = item.half_x, item.half_y, item.half_z


@inline_njit
def set_solid_box(item: Any, x: float, y: float, z: float, radius: float) -> None:
    """Set the size and bounding box of a box, sphere, capsule or cylinder."""
    if item.kind != BOX:
        x = y = radius
        z = z if item.kind == CYLINDER else z + radius
    item.mid_x = item.mid_y = item.mid_z = 0.0
    item.half_x, item.half_y, item.half_z = x, y, z
    item.size_x, item.size_y, item.radius = x, y, radius
    item.size_z = z if item.kind != CAPSULE else z - radius


@inline_njit
def set_pixels(item: Any, view: Any) -> None:
    """Set the bounding sphere, the reach of ambient occlusion and the pixels that the item may cover."""
    x, y, z = item.mid_x, item.mid_y, item.mid_z
    item.center_x = item.at_x + item.xx * x + item.yx * y + item.zx * z
    item.center_y = item.at_y + item.xy * x + item.yy * y + item.zy * z
    item.center_z = item.at_z + item.xz * x + item.yz * y + item.zz * z
    if item.kind == PLANE:
        store_bounds(item, view, ALL_BOUNDS)
        item.bound = 1e30
        item.reach = view.reach
        return
    item.bound = np.sqrt(item.half_x**2 + item.half_y**2 + item.half_z**2)
    bounds = NO_BOUNDS
    if item.kind == CAPSULE:
        item.bound = item.size_z + item.radius
        for side in range(2):
            s = item.size_z if side == 0 else -item.size_z
            x, y, z = item.at_x + s * item.zx, item.at_y + s * item.zy, item.at_z + s * item.zz
            bounds = grow(bounds, view, x, y, z, item.radius)
    else:
        for k in range(8):
            x, y, z = corner(item, k)
            bounds = grow(bounds, view, x, y, z, 0.0)
    depth = item.center_x * view.forward_x + item.center_y * view.forward_y + item.center_z * view.forward_z
    if depth < -item.bound:
        bounds = NO_BOUNDS
    store_bounds(item, view, bounds)
    item.reach = min(view.reach, CONTACT_REACH * item.bound)


@inline_njit
def set_plane_origin(item: Any, view: Any) -> None:
    """Move a plane's origin near the eye by whole periods of its pattern, which keeps float32 exact far out."""
    item.mid_x = item.mid_y = item.mid_z = item.half_x = item.half_y = item.half_z = 0.0
    item.size_x = item.size_y = item.size_z = item.radius = 0.0
    period = 2.0 * view.cell
    x, y, _ = to_frame(item, item.at_x, item.at_y, item.at_z)
    x, y = period * np.floor(x / period), period * np.floor(y / period)
    item.at_x -= item.xx * x + item.yx * y
    item.at_y -= item.xy * x + item.yy * y
    item.at_z -= item.xz * x + item.yz * y


@njit
def prepare(items: NDArray[np.void], primitives: Primitives, meshes: Meshes | None, views: NDArray[np.void]) -> int:
    """Fill `items` and return their number. Disabled and non-finite primitives are left out and get no id."""
    view = views[0]
    count = 0
    for k in range(len(primitives.kind)):
        p, q = primitives.position[k], primitives.rotation[k]
        norm = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        total = p[0] + p[1] + p[2] + norm
        if not (primitives.enabled[k] and norm > 0.0 and abs(total) < 1e30):
            continue
        item = items[count]
        kind = primitives.kind[k]
        item.kind = CAPSULE if kind == SPHERE else kind
        item.ball = 1 if kind == SPHERE else 0
        item.mark = primitives.mark[k]
        item.at_x, item.at_y, item.at_z = p[0] - view.eye_x, p[1] - view.eye_y, p[2] - view.eye_z
        set_axes(item, q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm)
        if kind == HULL or kind == HEIGHTFIELD:
            if meshes is not None:
                set_mesh_box(item, meshes, primitives.vertex_first[k])
        elif kind == PLANE:
            set_plane_origin(item, view)
        else:
            size = primitives.size[k]
            set_solid_box(item, size[0], size[1], 0.0 if kind == SPHERE else size[2], primitives.radius[k])
        set_rays(item, view)
        set_pixels(item, view)
        color = primitives.color[k]
        set_colors(item, color[0] / 255.0, color[1] / 255.0, color[2] / 255.0)
        count += 1
    return count


@inline_njit
def set_colors(item: Any, red: float, green: float, blue: float) -> None:
    """Set the linear colours of an item and of its marks: light marks on dark items, dark marks on light ones."""
    item.red, item.green, item.blue = red * red, green * green, blue * blue
    light = 0.3 * item.red + 0.6 * item.green + 0.1 * item.blue
    if item.kind != CYLINDER and item.ball == 0:
        shade = GROUND_SHADE if item.kind == PLANE or item.kind == HEIGHTFIELD else MARK_SHADE
        item.mark_red, item.mark_green, item.mark_blue = shade * item.red, shade * item.green, shade * item.blue
    elif light < 0.55:
        item.mark_red, item.mark_green, item.mark_blue = 0.86, 0.86, 0.84
    else:
        item.mark_red, item.mark_green, item.mark_blue = 0.03, 0.045, 0.14
