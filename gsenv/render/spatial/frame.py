"""The frame kernel: rows from depth to light, then the edges."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import Ray, find_ray, trace, trace_row
from gsenv.render.spatial.light import light_row
from gsenv.render.spatial.primitives import PLANE
from gsenv.render.spatial.records import (
    BLUE,
    DEPTH,
    FAR,
    GREEN,
    HALF,
    ID,
    NORMAL_X,
    OPEN,
    RED,
    SAMPLES,
    SHADOW,
    SKY,
    SUB_DEPTH,
    SUB_ID,
    ONE,
    ZERO,
    FloatArray,
    f4,
)
from gsenv.render.spatial.shadow import dim, shade
from gsenv.render.spatial.surface import paint
from gsenv.solver.jit import njit

# Places of the samples in a pixel: a rotated grid.
SAMPLE_X = (f4(-0.125), f4(0.375), f4(-0.375), f4(0.125))
SAMPLE_Y = (f4(-0.375), f4(-0.125), f4(0.125), f4(0.375))


@njit
def clear_row(lines: FloatArray) -> None:
    for j in range(np.uint64(0), np.uint64(lines.shape[1])):
        lines[DEPTH, j] = FAR
        lines[ID, j] = SKY
        lines[SHADOW, j] = ZERO
        lines[OPEN, j] = ONE
    for line in range(NORMAL_X, SHADOW):
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            lines[line, j] = ZERO


@njit
def find_world_ray(look: Any, y: Any) -> Ray:
    x = look.left
    return (
        look.forward_x + x * look.right_x + y * look.up_x,
        look.forward_y + x * look.right_y + y * look.up_y,
        look.forward_z + x * look.right_z + y * look.up_z,
        look.step * look.right_x,
        look.step * look.right_y,
        look.step * look.right_z,
    )


@njit
def draw_row(
    lines: FloatArray,
    row: int,
    items: NDArray[np.void],
    count: int,
    look: Any,
    faces: FloatArray,
    shadows: NDArray[np.void],
    contacts: NDArray[np.void],
    spans: NDArray[np.int64],
) -> None:
    """Colours of one row in the lines RED, GREEN and BLUE, ids in ID."""
    y = look.top - (f4(row) + HALF) * look.step
    clear_row(lines)
    trace_row(lines, row, items, count, look, faces, spans)
    for k in range(count):
        if spans[k, 0] < spans[k, 1]:
            item = items[k]
            ray = find_ray(item, look, ZERO, y)
            paint(lines, np.uint64(spans[k, 0]), np.uint64(spans[k, 1]), k, item, ray, look, faces)
    for k in range(len(shadows)):
        pair = shadows[k]
        if pair.top <= row < pair.bottom:
            first, last = max(pair.left, spans[pair.receiver, 0]), min(pair.right, spans[pair.receiver, 1])
            if first < last:
                item = items[pair.occluder]
                ray = find_ray(item, look, ZERO, y)
                shade(lines, np.uint64(first), np.uint64(last), pair.receiver, item, ray, look, faces)
    for k in range(len(contacts)):
        pair = contacts[k]
        if pair.top <= row < pair.bottom:
            first, last = max(pair.left, spans[pair.receiver, 0]), min(pair.right, spans[pair.receiver, 1])
            if first < last:
                item = items[pair.occluder]
                ray = find_ray(item, look, ZERO, y)
                dim(lines, np.uint64(first), np.uint64(last), pair.receiver, item, ray, faces)
    light_row(lines, look, find_world_ray(look, y))


@njit
def to_byte(value: Any) -> Any:
    return np.uint8(np.int32(value * f4(255.0) + HALF))


@njit
def draw_fast(
    image: NDArray[np.uint8],
    ids: NDArray[np.int32],
    lines: FloatArray,
    items: NDArray[np.void],
    count: int,
    looks: NDArray[np.void],
    faces: FloatArray,
    shadows: NDArray[np.void],
    contacts: NDArray[np.void],
    spans: NDArray[np.int64],
) -> None:
    """One sample for each pixel."""
    look = looks[0]
    for row in range(image.shape[0]):
        draw_row(lines, row, items, count, look, faces, shadows, contacts, spans)
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            image[row, j, 0] = to_byte(lines[RED, j])
            image[row, j, 1] = to_byte(lines[GREEN, j])
            image[row, j, 2] = to_byte(lines[BLUE, j])
            ids[row, j] = np.int32(lines[ID, j])


@njit
def draw_high(
    image: NDArray[np.uint8],
    ids: NDArray[np.int32],
    lines: FloatArray,
    items: NDArray[np.void],
    count: int,
    looks: NDArray[np.void],
    faces: FloatArray,
    shadows: NDArray[np.void],
    contacts: NDArray[np.void],
    spans: NDArray[np.int64],
    colors: FloatArray,
) -> None:
    """One colour for each pixel, and edges blended by what four samples see."""
    look = looks[0]
    for row in range(image.shape[0]):
        draw_row(lines, row, items, count, look, faces, shadows, contacts, spans)
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            colors[0, row, j] = lines[RED, j]
            colors[1, row, j] = lines[GREEN, j]
            colors[2, row, j] = lines[BLUE, j]
            ids[row, j] = np.int32(lines[ID, j])
    for row in range(image.shape[0]):
        for j in range(np.uint64(0), np.uint64(lines.shape[1])):
            image[row, j, 0] = to_byte(colors[0, row, j])
            image[row, j, 1] = to_byte(colors[1, row, j])
            image[row, j, 2] = to_byte(colors[2, row, j])
        first, last = sample_row(lines, row, items, count, look, faces)
        blend_row(image, ids, colors, lines, row, first, last)


@njit
def sample_row(
    lines: FloatArray, row: int, items: NDArray[np.void], count: int, look: Any, faces: FloatArray
) -> tuple[int, int]:
    """Ids that the samples see, in the lines SUB_ID.., between the columns that are returned."""
    low, high = lines.shape[1], 0
    for k in range(count):
        item = items[k]
        if item.top <= row < item.bottom and item.kind != PLANE:
            low, high = min(low, item.left), max(high, item.right)
    if low >= high:
        return 0, 0
    begin, end = np.uint64(low), np.uint64(high)
    for s in range(SAMPLES):
        y = look.top - (f4(row) + HALF + SAMPLE_Y[s]) * look.step
        for j in range(begin, end):
            lines[SUB_DEPTH, j] = FAR
            lines[SUB_ID + s, j] = SKY
        for k in range(count):
            item = items[k]
            if item.top <= row < item.bottom:
                first, last = np.uint64(max(item.left, low)), np.uint64(min(item.right, high))
                ray = find_ray(item, look, SAMPLE_X[s] * look.step, y)
                trace(lines, SUB_DEPTH, SUB_ID + s, first, last, k, item, ray, faces)
    return low, high


@njit
def blend_row(
    image: NDArray[np.uint8],
    ids: NDArray[np.int32],
    colors: FloatArray,
    lines: FloatArray,
    row: int,
    first: int,
    last: int,
) -> None:
    """Pixels whose samples see several things get the mean of the colours of neighbours that show them."""
    height, width = ids.shape
    for j in range(first, last):
        mine = f4(ids[row, j])
        same = True
        for s in range(SAMPLES):
            same &= lines[SUB_ID + s, j] == mine
        if same:
            continue
        red = green = blue = ZERO
        for s in range(SAMPLES):
            seen = np.int32(lines[SUB_ID + s, j])
            at_row, at = find_color(ids, row, j, seen, height, width)
            red += colors[0, at_row, at]
            green += colors[1, at_row, at]
            blue += colors[2, at_row, at]
        share = f4(1.0 / SAMPLES)
        image[row, j, 0] = to_byte(red * share)
        image[row, j, 1] = to_byte(green * share)
        image[row, j, 2] = to_byte(blue * share)


@njit
def find_color(ids: NDArray[np.int32], row: int, j: int, seen: Any, height: int, width: int) -> tuple[int, int]:
    """The nearest of the pixel and its eight neighbours that shows `seen`; the pixel itself if none does."""
    if ids[row, j] == seen:
        return row, j
    for ring in range(1, 3):  # sides, then corners
        for di in range(-1, 2):
            for dj in range(-1, 2):
                if abs(di) + abs(dj) == ring and 0 <= row + di < height and 0 <= j + dj < width:
                    if ids[row + di, j + dj] == seen:
                        return row + di, j + dj
    return row, j
