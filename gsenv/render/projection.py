"""Project draw items in metres to screen items in pixels; items outside the picture are dropped here."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.draw_list import DrawFlag, DrawKind
from gsenv.render.scanline import FAR, HALF, ONE, TINY, TWO, ZERO
from gsenv.solver.jit import njit

FloatArray = NDArray[np.float32]

BOX = int(DrawKind.BOX)
CAPSULE = int(DrawKind.CAPSULE)
POLYGON = int(DrawKind.POLYGON)
POLYLINE = int(DrawKind.POLYLINE)
HALF_PLANE = int(DrawKind.HALF_PLANE)
TERRAIN = int(DrawKind.TERRAIN)
OUTLINE = int(DrawFlag.OUTLINE)
SHADE = int(DrawFlag.SHADE)
SHADOW = int(DrawFlag.SHADOW)

EDGE_COUNTS = (4, 0, 0, 0, 1, 0)  # edges by kind; those of polygons and polylines follow from their vertices
SHADE_TOP = np.float32(1.07)
SHADE_STEP = np.float32(-0.17)  # change of the brightness factor from the top of a silhouette to its bottom
OUTLINE_SHARE = np.float32(0.30)  # largest outline, as a fraction of the inradius, so that small shapes keep a fill

SCREEN_ITEM = np.dtype(
    [
        ("kind", np.int32),
        ("casts_shadow", np.int32),
        ("edge_first", np.int32),
        ("edge_count", np.int32),
        ("terrain", np.int32),  # TERRAIN: index among the terrains
        ("left", np.float32),  # silhouette bounds, px
        ("right", np.float32),
        ("top", np.float32),
        ("bottom", np.float32),
        ("ax", np.float32),  # CAPSULE
        ("ay", np.float32),
        ("bx", np.float32),
        ("by", np.float32),
        ("radius", np.float32),  # CAPSULE, POLYLINE
        ("outline", np.float32),  # px
        ("depth", np.float32),  # px, depth over which a ground darkens
        ("shade_top", np.float32),  # brightness factor of the fill at the top of the silhouette
        ("shade_slope", np.float32),  # 1/px, change of that factor downwards
        ("alpha", np.float32),
        ("fill", np.float32, 3),
        ("line", np.float32, 3),
        ("deep", np.float32, 3),
    ],
    align=True,
)

# Lengths in px, which scale with the picture's height.
LOOK = np.dtype(
    [
        ("outline", np.float32),
        ("ground_edge", np.float32),
        ("ground_depth", np.float32),
        ("shadow_x", np.float32),
        ("shadow_y", np.float32),
        ("softness", np.float32),
        ("shadow_alpha", np.float32),
    ],
    align=True,
)


@njit
def set_bounds(out: Any, left: Any, right: Any, top: Any, bottom: Any) -> None:
    out.left = left
    out.right = right
    out.top = top
    out.bottom = bottom


@njit
def project_capsule(item: Any, x: float, y: float, scale: float, out: Any) -> Any:
    """Set endpoints and radius; return the inradius in px. A capsule below a pixel's width fades out."""
    half_x = item.rotation[0] * item.size[0] * scale
    half_y = -item.rotation[1] * item.size[0] * scale
    out.ax = np.float32(x - half_x)
    out.ay = np.float32(y - half_y)
    out.bx = np.float32(x + half_x)
    out.by = np.float32(y + half_y)
    inradius = np.float32(item.radius * scale)
    radius = max(inradius, HALF)
    out.radius = radius
    if half_x != 0.0 or half_y != 0.0:
        out.alpha *= inradius / radius
    else:
        out.alpha *= (inradius / radius) ** 2
    set_bounds(
        out,
        min(out.ax, out.bx) - radius,
        max(out.ax, out.bx) + radius,
        min(out.ay, out.by) - radius,
        max(out.ay, out.by) + radius,
    )
    return inradius


@njit
def find_corner(item: Any, vertices: NDArray[np.float64], k: Any, x: float, y: float, scale: float) -> tuple[Any, Any]:
    """Return corner k of a box, polygon or polyline in px."""
    if item.kind == BOX:
        u = item.size[0] if k == 1 or k == 2 else -item.size[0]
        v = item.size[1] if k >= 2 else -item.size[1]
    else:
        u = vertices[item.vertex_first + k, 0]
        v = vertices[item.vertex_first + k, 1]
    cos, sin = item.rotation[0], item.rotation[1]
    return (
        np.float32(x + (cos * u - sin * v) * scale),
        np.float32(y - (sin * u + cos * v) * scale),
    )


@njit
def project_polygon(
    item: Any,
    vertices: NDArray[np.float64],
    x: float,
    y: float,
    scale: float,
    out: Any,
    edges: FloatArray,
) -> Any:
    """Set the edge lines, with outward normals for either winding; return the inradius in px."""
    count = np.int64(out.edge_count)
    left, right, top, bottom = FAR, -FAR, FAR, -FAR
    middle_x, middle_y = ZERO, ZERO
    for k in range(count):
        px, py = find_corner(item, vertices, k, x, y, scale)
        left, right = min(left, px), max(right, px)
        top, bottom = min(top, py), max(bottom, py)
        middle_x += px
        middle_y += py
    set_bounds(out, left, right, top, bottom)
    middle_x /= np.float32(count)
    middle_y /= np.float32(count)
    ax, ay = find_corner(item, vertices, count - 1, x, y, scale)
    inradius = FAR
    for k in range(count):
        bx, by = find_corner(item, vertices, k, x, y, scale)
        row = np.int64(out.edge_first) + k
        depth = store_edge(edges, row, ax, ay, bx, by, middle_x, middle_y)
        inradius = min(inradius, depth)
        ax, ay = bx, by
    return inradius


@njit
def project_polyline(
    item: Any,
    vertices: NDArray[np.float64],
    x: float,
    y: float,
    scale: float,
    out: Any,
    edges: FloatArray,
) -> Any:
    """Set the segments (ax, ay, bx, by); return the inradius in px. Thin lines fade out as capsules do."""
    inradius = np.float32(item.radius * scale)
    radius = max(inradius, HALF)
    out.radius = radius
    out.alpha *= inradius / radius
    left, right, top, bottom = FAR, -FAR, FAR, -FAR
    ax, ay = ZERO, ZERO
    for k in range(np.int64(out.edge_count) + 1):
        bx, by = find_corner(item, vertices, k, x, y, scale)
        left, right = min(left, bx), max(right, bx)
        top, bottom = min(top, by), max(bottom, by)
        if k > 0:
            row = np.int64(out.edge_first) + k - 1
            edges[row, 0] = ax
            edges[row, 1] = ay
            edges[row, 2] = bx
            edges[row, 3] = by
        ax, ay = bx, by
    set_bounds(out, left - radius, right + radius, top - radius, bottom + radius)
    return inradius


@njit
def store_edge(edges: FloatArray, row: Any, ax: Any, ay: Any, bx: Any, by: Any, inner_x: Any, inner_y: Any) -> Any:
    """Store the line (nx, ny, offset) through a and b, with the inner point on its negative side.

    Returns the depth of the inner point in px. An edge of length zero bounds nothing.
    """
    nx = by - ay
    ny = ax - bx
    length = np.sqrt(nx * nx + ny * ny)
    if length < TINY:
        edges[row, 0] = ZERO
        edges[row, 1] = ZERO
        edges[row, 2] = -FAR
        return FAR
    nx /= length
    ny /= length
    depth = nx * (ax - inner_x) + ny * (ay - inner_y)
    if depth < ZERO:
        nx, ny, depth = -nx, -ny, -depth
    edges[row, 0] = nx
    edges[row, 1] = ny
    edges[row, 2] = -(nx * ax + ny * ay)
    return depth


@njit
def project_half_plane(item: Any, x: float, y: float, width: int, height: int, out: Any, edges: FloatArray) -> None:
    """Set the edge line; the bounds are the part of the picture that the half-plane may cover."""
    nx = -item.rotation[1]
    ny = -item.rotation[0]
    offset = -(nx * x + ny * y)
    edges[out.edge_first, 0] = np.float32(nx)
    edges[out.edge_first, 1] = np.float32(ny)
    edges[out.edge_first, 2] = np.float32(offset)
    lowest = offset + min(nx * width, 0.0) + min(ny * height, 0.0)
    bottom = np.float32(height) if lowest < 1.0 else -FAR
    set_bounds(out, ZERO, np.float32(width), ZERO, bottom)


@njit
def start_item(item: Any, out: Any, row: Any) -> None:
    """Set all fields that do not depend on the geometry."""
    out.kind = item.kind
    out.casts_shadow = item.flags & SHADOW
    out.alpha = item.alpha
    out.edge_first = row
    out.edge_count = EDGE_COUNTS[item.kind]
    if item.kind == POLYGON:
        out.edge_count = item.vertex_count
    elif item.kind == POLYLINE:
        out.edge_count = item.vertex_count - 1
    for channel in range(3):
        out.fill[channel] = item.fill[channel]
        out.line[channel] = item.line[channel]
        out.deep[channel] = item.deep[channel]


@njit
def finish_shape(item: Any, inradius: Any, look: Any, out: Any) -> None:
    """Set the outline's width and the vertical gradient from the size on screen."""
    out.outline = -TWO  # no outline: the fill covers the antialiased edge as well
    if item.flags & OUTLINE:
        out.outline = min(look.outline, OUTLINE_SHARE * inradius)
    out.shade_top = ONE
    out.shade_slope = ZERO
    if item.flags & SHADE:
        out.shade_top = SHADE_TOP
        out.shade_slope = SHADE_STEP / max(out.bottom - out.top, ONE)


@njit
def is_in_sight(out: Any, look: Any, width: int, height: int) -> bool:
    """Whether the silhouette or its shadow meets the picture; False for NaN."""
    left, right, top, bottom = out.left, out.right, out.top, out.bottom
    if out.casts_shadow:
        left -= look.softness
        top -= look.softness
        right += look.shadow_x + look.softness
        bottom += look.shadow_y + look.softness
    visible = right > -ONE and left < np.float32(width) + ONE and right - left < FAR
    return visible and bottom > -ONE and top < np.float32(height) + ONE and out.alpha > ZERO


@njit
def project(
    items: NDArray[np.void],
    vertices: NDArray[np.float64],
    center_x: float,
    center_y: float,
    scale: float,
    width: int,
    height: int,
    look: NDArray[np.void],
    terrain_tops: FloatArray,
    screen: NDArray[np.void],
    edges: FloatArray,
) -> int:
    """Fill `screen` with the visible items, in list order; return their number."""
    style = look[0]
    count, row, terrain = 0, np.int64(0), 0  # int64, not a literal, or numba compiles start_item twice
    for index in range(items.shape[0]):
        item = items[index]
        out = screen[count]
        start_item(item, out, row)
        x = (item.position[0] - center_x) * scale + 0.5 * width
        y = (center_y - item.position[1]) * scale + 0.5 * height
        if item.kind >= HALF_PLANE:
            out.outline = style.ground_edge
            out.depth = style.ground_depth
            out.casts_shadow = 0
            if item.kind == HALF_PLANE:
                project_half_plane(item, x, y, width, height, out, edges)
            else:
                out.terrain = terrain
                top = terrain_tops[terrain]
                set_bounds(out, ZERO, np.float32(width), top, np.float32(height))
                terrain += 1
        else:
            if item.kind == CAPSULE:
                inradius = project_capsule(item, x, y, scale, out)
            elif item.kind == POLYLINE:
                inradius = project_polyline(item, vertices, x, y, scale, out, edges)
            else:
                inradius = project_polygon(item, vertices, x, y, scale, out, edges)
            finish_shape(item, inradius, style, out)
        if is_in_sight(out, style, width, height):
            count += 1
            row += np.int64(out.edge_count)
    return count
