"""Stripes along a line on heightfields, such as a road with its edges and dashes: painted, so they have no seams."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import find_ray
from gsenv.render.spatial.primitives import HEIGHTFIELD
from gsenv.render.spatial.records import BLUE, DEPTH, GREEN, HALF, ID, ONE, PIXEL_X, RED, TINY, ZERO, FloatArray, f4
from gsenv.render.theme import Rgb
from gsenv.solver.jit import inline_njit, njit

UNKNOWN = 1e3  # m, `aside` of places that are far from the line; nothing is painted in cells with such a corner
FOOTPRINT = f4(1.2)  # px, width of the edges' filter
LONGEST = f4(12.0)  # ratio of the lengths of a pixel's footprint along and across a grazing ray
ASIDE, ALONG, WIDE = range(3)


class Stripes(NamedTuple):
    """Stripes on all heightfields of a world, painted in this order over their checkerboard.

    places: float32 (row, column, 3), at points of a grid: distance to the left of the line (m), length along it (m),
        and the factor of `widening`, bilinear between them
    grid: float32 (5,), x and y (m) of the first point in the heightfield's frame, points per m, and the lengths along
        the line where all stripes begin and end (m)
    bands: float32 (band, 7): half width (m), widening (m), period along the line (m; 0: no gaps), length of a mark in
        it (m), and linear red, green and blue
    """

    places: FloatArray
    grid: FloatArray
    bands: FloatArray


def band(half_width: float, color: Rgb, widening: float = 0.0, period: float = 0.0, mark: float = 0.0) -> list[float]:
    """Return an entry of `Stripes.bands`."""
    return [half_width, widening, period, mark, *((channel / 255.0) ** 2 for channel in color)]


@inline_njit
def share_within(half: Any, distance: Any, width: Any) -> Any:
    """Return the share of a pixel of this width that lies within `half` m of a middle at a distance from it, in m."""
    return min(max(half + HALF * width - distance, ZERO), min(width, half + half)) / width


@njit
def find_place(stripes: Stripes, x: Any, y: Any) -> tuple[Any, Any, Any, Any, Any, bool]:
    """Return (aside, along, wide), the gradient (x, y) of aside, and whether the place (x, y) in m is known."""
    grid, places = stripes.grid, stripes.places
    u, v = (x - grid[0]) * grid[2], (y - grid[1]) * grid[2]
    rows, columns = places.shape[0], places.shape[1]
    if not (u >= ZERO and v >= ZERO and u < f4(columns - 1) and v < f4(rows - 1)):  # NaN is nowhere
        return ZERO, ZERO, ZERO, ZERO, ZERO, False
    i, j = np.int64(u), np.int64(v)
    u, v = u - f4(i), v - f4(j)
    a, b, c, d = places[j, i], places[j, i + 1], places[j + 1, i], places[j + 1, i + 1]
    most = max(max(abs(a[ASIDE]), abs(b[ASIDE])), max(abs(c[ASIDE]), abs(d[ASIDE])))
    if most >= f4(UNKNOWN):
        return ZERO, ZERO, ZERO, ZERO, ZERO, False
    p, q, r, s = (ONE - u) * (ONE - v), u * (ONE - v), (ONE - u) * v, u * v
    slope_x = ((ONE - v) * (b[ASIDE] - a[ASIDE]) + v * (d[ASIDE] - c[ASIDE])) * grid[2]
    slope_y = ((ONE - u) * (c[ASIDE] - a[ASIDE]) + u * (d[ASIDE] - b[ASIDE])) * grid[2]
    return (
        p * a[ASIDE] + q * b[ASIDE] + r * c[ASIDE] + s * d[ASIDE],
        p * a[ALONG] + q * b[ALONG] + r * c[ALONG] + s * d[ALONG],
        p * a[WIDE] + q * b[WIDE] + r * c[WIDE] + s * d[WIDE],
        slope_x,
        slope_y,
        True,
    )


@njit
def paint_pixel(lines: FloatArray, j: Any, stripes: Stripes, place: Any, across: Any, onward: Any) -> None:
    """Blend all stripes over column j; its footprint is `across` wide and `onward` long, in m."""
    aside, along, wide = place[0], place[1], place[2]
    bands = stripes.bands
    for k in range(len(bands)):
        part = share_within(bands[k, 0] + bands[k, 1] * wide, abs(aside), across)
        period = bands[k, 2]
        if period > ZERO:
            phase = along - period * np.floor(along / period)
            part *= share_within(HALF * bands[k, 3], abs(phase - HALF * period), onward)
        lines[RED, j] += part * (bands[k, 4] - lines[RED, j])
        lines[GREEN, j] += part * (bands[k, 5] - lines[GREEN, j])
        lines[BLUE, j] += part * (bands[k, 6] - lines[BLUE, j])


@njit
def stripe_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    count: int,
    looks: NDArray[np.void],
    stripes: Stripes,
    spans: NDArray[np.int64],
) -> None:
    """Paint the stripes on the heightfields in the rows start..end-1, whose colours `paint_band` has computed."""
    look = looks[0]
    first_s, last_s = stripes.grid[3], stripes.grid[4]
    for row in range(start, end):
        lines = band[row - start]
        y = look.top - (f4(row) + HALF) * look.step
        for k in range(count):
            item = items[k]
            if item.kind != HEIGHTFIELD or not item.top <= row < item.bottom:
                continue
            ax, ay, az, bx, by, bz = find_ray(item, look, ZERO, y)
            me = f4(k)
            for j in range(spans[row - start, k, 0], spans[row - start, k, 1]):
                if lines[ID, j] != me:
                    continue
                c, t = lines[PIXEL_X, j], lines[DEPTH, j]
                dx, dy, dz = ax + c * bx, ay + c * by, az + c * bz
                place = find_place(stripes, item.eye_x + t * dx, item.eye_y + t * dy)
                if not place[5] or place[1] < first_s or place[1] > last_s:
                    continue
                level = ONE / np.sqrt(max(dx * dx + dy * dy, TINY))
                side = abs(dx * place[3] + dy * place[4]) * level  # 1 where the ray crosses the line
                pixel = FOOTPRINT * look.step * t
                stretched = pixel * min(ONE / max(abs(dz) * level, f4(1e-3)), LONGEST)
                turned = np.sqrt(max(ONE - side * side, ZERO))
                paint_pixel(
                    lines, j, stripes, place, side * stretched + turned * pixel, turned * stretched + side * pixel
                )
