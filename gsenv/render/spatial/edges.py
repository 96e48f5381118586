"""Antialiasing of edges: pixels whose samples see several items."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.depth import find_columns
from gsenv.render.spatial.light import to_byte
from gsenv.render.spatial.records import SAMPLES, SUB_ID, ZERO, FloatArray, f4
from gsenv.solver.jit import njit

# Offsets of the samples from the pixel's centre, in px: a rotated grid.
SAMPLE_X = (f4(-0.125), f4(0.375), f4(-0.375), f4(0.125))
SAMPLE_Y = (f4(-0.375), f4(-0.125), f4(0.125), f4(0.375))


@njit
def find_color(ids: NDArray[np.int32], row: int, j: int, seen: Any, height: int, width: int) -> tuple[int, int]:
    """Return the nearest of the pixel and its eight neighbours that shows item `seen`, or the pixel if none does."""
    if ids[row, j] == seen:
        return row, j
    for ring in range(1, 3):  # first the four direct neighbours, then the diagonal ones
        for di in range(-1, 2):
            for dj in range(-1, 2):
                if abs(di) + abs(dj) == ring and 0 <= row + di < height and 0 <= j + dj < width:
                    if ids[row + di, j + dj] == seen:
                        return row + di, j + dj
    return row, j


@njit
def blend_band(
    band: FloatArray,
    start: int,
    end: int,
    items: NDArray[np.void],
    count: int,
    image: NDArray[np.uint8],
    ids: NDArray[np.int32],
    colors: FloatArray,
) -> None:
    """Average, in pixels whose samples see several items, the colours of neighbours that show these items."""
    height, width = ids.shape
    share = f4(1.0 / SAMPLES)
    for row in range(start, end):
        lines = band[row - start]
        first, last = find_columns(items, count, row)
        for j in range(first, min(last, width)):
            mine = f4(ids[row, j])
            same = True
            for s in range(SAMPLES):
                same &= lines[SUB_ID + s, j] == mine
            if same:
                continue
            red = green = blue = ZERO
            for s in range(SAMPLES):
                at_row, at = find_color(ids, row, j, np.int32(lines[SUB_ID + s, j]), height, width)
                red += colors[0, at_row, at]
                green += colors[1, at_row, at]
                blue += colors[2, at_row, at]
            image[row, j, 0] = to_byte(red * share)
            image[row, j, 1] = to_byte(green * share)
            image[row, j, 2] = to_byte(blue * share)
