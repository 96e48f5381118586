"""Row kernels: signed distances along one pixel row, and blending from them.

`lines` (7, width) float32 holds the buffers of the current row and stays in the L1 cache, so that
painting an item is bound by arithmetic, not by memory. Distances are in px, negative inside.
All constants are float32, or numba would promote whole rows to float64. Kernels take the whole of
`lines` and the columns first..last-1 as unsigned integers: passing slices makes numba count
references, which took 40 % of a picture's time, and loops over signed columns do not vectorise.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import inline_njit

FloatArray = NDArray[np.float32]

# Rows of `lines`.
RED, GREEN, BLUE, DISTANCE, SHADOW, PIXEL_X, BAND = range(7)
LINE_COUNT = 7

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
FAR = np.float32(1e9)  # px
TINY = np.float32(1e-12)
WHITE = np.float32(255.0)
THREE_BYTES = np.uint64(3)


@inline_njit
def clamp01(x: Any) -> Any:
    return min(max(x, ZERO), ONE)


@inline_njit
def clip_span(low: Any, high: Any, width: int) -> tuple[Any, Any]:
    """Return (first, last): columns first..last-1 hold all pixel centres within one px of [low, high]."""
    first: Any = min(max(np.int64(low - ONE), 0), width)
    last: Any = max(min(np.int64(high + ONE) + 1, width), first)
    return np.uint64(first), np.uint64(last)


@inline_njit
def fill_line(lines: FloatArray, line: int, first: Any, last: Any, value: Any) -> None:
    """Set the columns first..last-1 of one buffer."""
    for j in range(first, last):
        lines[line, j] = value


@inline_njit
def find_polygon_distance(
    lines: FloatArray, first: Any, last: Any, y: Any, edges: FloatArray, edge: int, count: int
) -> None:
    """Store the largest distance to the edge lines (nx, ny, offset): exact inside, mitred at outer corners."""
    fill_line(lines, DISTANCE, first, last, -FAR)
    for k in range(edge, edge + count, 2):  # two edges per pass halve the memory traffic
        other = k + 1 if k + 1 < edge + count else k
        slope_a, slope_b = edges[k, 0], edges[other, 0]
        offset_a = edges[k, 1] * y + edges[k, 2]
        offset_b = edges[other, 1] * y + edges[other, 2]
        for j in range(first, last):
            x = lines[PIXEL_X, j]
            nearer = max(slope_a * x + offset_a, slope_b * x + offset_b)
            lines[DISTANCE, j] = max(lines[DISTANCE, j], nearer)


@inline_njit
def find_capsule_distance(lines: FloatArray, first: Any, last: Any, y: Any, shift: Any, item: Any) -> None:
    """Store the distance to the segment a-b, shifted right by `shift`, minus the radius."""
    ax = item.ax + shift
    dx = item.bx - item.ax
    dy = item.by - item.ay
    py = y - item.ay
    radius = item.radius
    inverse = ONE / max(dx * dx + dy * dy, TINY)
    for j in range(first, last):
        px = lines[PIXEL_X, j] - ax
        t = clamp01((px * dx + py * dy) * inverse)
        qx = px - t * dx
        qy = py - t * dy
        lines[DISTANCE, j] = np.sqrt(qx * qx + qy * qy) - radius


@inline_njit
def find_polyline_distance(
    lines: FloatArray, y: Any, shift: Any, edges: FloatArray, item: Any, reach: Any
) -> tuple[Any, Any]:
    """Store the distance to the segments, shifted right by `shift`, minus the radius.

    It is exact where it is below `reach`. Returns (first, last): no such column lies outside first..last-1.
    """
    begin = end = np.uint64(0)
    reach += item.radius
    for k in range(item.edge_first, item.edge_first + item.edge_count):
        ax, ay, bx, by = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
        if y < min(ay, by) - reach or y > max(ay, by) + reach:
            continue
        ax += shift
        dx = bx + shift - ax
        dy = by - ay
        py = y - ay
        # the part of the segment within reach of this row
        slope = ONE / dy if dy != ZERO else FAR
        up, down = clamp01((py - reach) * slope), clamp01((py + reach) * slope)
        near, far = ax + up * dx, ax + down * dx
        first, last = clip_span(min(near, far) - reach, max(near, far) + reach, lines.shape[1])
        if begin == end:
            begin = end = first
        fill_line(lines, DISTANCE, first, begin, FAR)
        fill_line(lines, DISTANCE, end, last, FAR)
        begin, end = min(begin, first), max(end, last)
        inverse = ONE / max(dx * dx + dy * dy, TINY)
        for j in range(first, last):
            px = lines[PIXEL_X, j] - ax
            t = clamp01((px * dx + py * dy) * inverse)
            qx = px - t * dx
            qy = py - t * dy
            lines[DISTANCE, j] = min(lines[DISTANCE, j], qx * qx + qy * qy)
    radius = item.radius
    for j in range(begin, end):
        lines[DISTANCE, j] = np.sqrt(lines[DISTANCE, j]) - radius
    return begin, end


@inline_njit
def add_polygon_shadow(
    lines: FloatArray,
    first: Any,
    last: Any,
    y: Any,
    shift: Any,
    softness: Any,
    edges: FloatArray,
    edge: int,
    count: int,
) -> None:
    """Add a blurred polygon: the product of its blurred half-planes, which has round corners."""
    fill_line(lines, DISTANCE, first, last, ONE)
    inverse = ONE / softness
    for k in range(edge, edge + count, 2):  # two edges per pass halve the memory traffic
        other = k + 1 if k + 1 < edge + count else k
        slope_a = -edges[k, 0] * inverse
        slope_b = -edges[other, 0] * inverse
        offset_a = HALF - (edges[k, 1] * y + edges[k, 2] - edges[k, 0] * shift) * inverse
        offset_b = HALF - (edges[other, 1] * y + edges[other, 2] - edges[other, 0] * shift) * inverse
        if other == k:
            slope_b, offset_b = ZERO, ONE
        for j in range(first, last):
            x = lines[PIXEL_X, j]
            a = clamp01(slope_a * x + offset_a)
            b = clamp01(slope_b * x + offset_b)
            ab = a * b
            lines[DISTANCE, j] *= ab * ab * (THREE - TWO * a) * (THREE - TWO * b)
    for j in range(first, last):
        lines[SHADOW, j] += lines[DISTANCE, j]


@inline_njit
def add_distance_shadow(lines: FloatArray, first: Any, last: Any, softness: Any) -> None:
    """Add a shadow that is a smoothstep of the stored distance."""
    inverse = ONE / softness
    for j in range(first, last):
        s = clamp01(HALF - lines[DISTANCE, j] * inverse)
        lines[SHADOW, j] += s * s * (THREE - TWO * s)


@inline_njit
def apply_shadow(lines: FloatArray, first: Any, last: Any, alpha: Any) -> None:
    """Darken by the clamped sum of shadows, which is exact for touching shapes: a wall casts no light seams."""
    for j in range(first, last):
        light = ONE - alpha * min(lines[SHADOW, j], ONE)
        lines[RED, j] *= light
        lines[GREEN, j] *= light
        lines[BLUE, j] *= light


@inline_njit
def blend_shape(lines: FloatArray, first: Any, last: Any, item: Any, y: Any) -> None:
    """Blend a shape's fill, and the outline inside its silhouette, over the row."""
    shade = item.shade_top + item.shade_slope * (y - item.top)
    fill_red = min(item.fill[0] * shade, WHITE)
    fill_green = min(item.fill[1] * shade, WHITE)
    fill_blue = min(item.fill[2] * shade, WHITE)
    line_red, line_green, line_blue = item.line[0], item.line[1], item.line[2]
    outline = item.outline
    alpha = item.alpha
    for j in range(first, last):
        d = lines[DISTANCE, j]
        red, green, blue = lines[RED, j], lines[GREEN, j], lines[BLUE, j]
        coverage = clamp01(HALF - d) * alpha
        inner = clamp01(HALF - d - outline)
        lines[RED, j] = red + (line_red + (fill_red - line_red) * inner - red) * coverage
        lines[GREEN, j] = green + (line_green + (fill_green - line_green) * inner - green) * coverage
        lines[BLUE, j] = blue + (line_blue + (fill_blue - line_blue) * inner - blue) * coverage


@inline_njit
def blend_ground(lines: FloatArray, first: Any, last: Any, item: Any) -> None:
    """Blend a ground: it darkens with depth and in vertical stripes, and has an edge band inside its surface."""
    line_red, line_green, line_blue = item.line[0], item.line[1], item.line[2]
    top_red, top_green, top_blue = item.fill[0], item.fill[1], item.fill[2]
    step_red, step_green, step_blue = (
        item.deep[0] - top_red,
        item.deep[1] - top_green,
        item.deep[2] - top_blue,
    )
    outline = item.outline
    slope = -ONE / item.depth
    alpha = item.alpha
    for j in range(first, last):
        d = lines[DISTANCE, j]
        red, green, blue = lines[RED, j], lines[GREEN, j], lines[BLUE, j]
        coverage = clamp01(HALF - d) * alpha
        inner = clamp01(HALF - d - outline)
        depth = clamp01(d * slope)
        depth *= TWO - depth
        light = lines[BAND, j]
        fill_red = (top_red + step_red * depth) * light
        fill_green = (top_green + step_green * depth) * light
        fill_blue = (top_blue + step_blue * depth) * light
        lines[RED, j] = red + (line_red + (fill_red - line_red) * inner - red) * coverage
        lines[GREEN, j] = green + (line_green + (fill_green - line_green) * inner - green) * coverage
        lines[BLUE, j] = blue + (line_blue + (fill_blue - line_blue) * inner - blue) * coverage


@inline_njit
def find_terrain_distance(
    lines: FloatArray,
    y: Any,
    surfaces: FloatArray,
    terrain: int,
    row: int,
    segments: FloatArray,
    segment_first: NDArray[np.int64],
    reach: Any,
) -> None:
    """Store the distance to the chain: exact within `reach`, elsewhere the vertical one, which is never smaller.

    Surfaces and segments are those of TerrainLines.
    """
    width = lines.shape[1]
    for j in range(np.uint64(0), np.uint64(width)):
        lines[DISTANCE, j] = surfaces[terrain, row, j] - y
    for k in range(segment_first[terrain], segment_first[terrain + 1]):
        ax, ay, bx, by = segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3]
        if y < min(ay, by) - reach or y > max(ay, by) + reach:
            continue
        first: Any = max(np.int64(min(ax, bx) - reach), 0)
        last: Any = max(min(np.int64(max(ax, bx) + reach) + 1, width), 0)
        take_segment_distance(lines, np.uint64(first), np.uint64(last), y, ax, ay, bx, by, reach)


@inline_njit
def take_segment_distance(
    lines: FloatArray, first: Any, last: Any, y: Any, ax: Any, ay: Any, bx: Any, by: Any, reach: Any
) -> None:
    """Shrink |distance| to the distance from segment a-b where that is within reach; the sign stays.

    Beyond the reach it is left alone, or the bounding box of a steep segment would show as a light area.
    """
    dx = bx - ax
    dy = by - ay
    py = y - ay
    inverse = ONE / max(dx * dx + dy * dy, TINY)
    for j in range(first, last):
        px = lines[PIXEL_X, j] - ax
        t = clamp01((px * dx + py * dy) * inverse)
        qx = px - t * dx
        qy = py - t * dy
        d = lines[DISTANCE, j]
        near = np.sqrt(qx * qx + qy * qy)
        near = min(abs(d), near) if near <= reach else abs(d)
        lines[DISTANCE, j] = near if d > ZERO else -near


@inline_njit
def store_line(lines: FloatArray, row: int, dither: FloatArray, pixels: NDArray[np.uint8]) -> None:
    """Write the row as bytes, with ordered dithering in (0, 1): it prevents banding and keeps integers exact.

    pixels: the whole image, flattened: a single index vectorises, 0.4 instead of 1.0 ns per px
    """
    begin = np.uint64(3 * row * lines.shape[1])
    for j in range(np.uint64(0), np.uint64(lines.shape[1])):
        noise = dither[row & 7, j]
        at = begin + THREE_BYTES * j
        pixels[at] = np.uint8(np.int32(lines[RED, j] + noise))
        pixels[at + np.uint64(1)] = np.uint8(np.int32(lines[GREEN, j] + noise))
        pixels[at + np.uint64(2)] = np.uint8(np.int32(lines[BLUE, j] + noise))
