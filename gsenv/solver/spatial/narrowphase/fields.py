"""Heightfields as surfaces: cells, triangles, folds between them, and searches near a point.

Cell (r, c) has the corners (r, c), (r, c+1), (r+1, c), (r+1, c+1) and is divided from the first to the
last: triangle 0 lies on the side of (r, c+1), triangle 1 on that of (r+1, c).  Sample (r, c) owns three
edges: 0 along x, 1 along y, 2 the diagonal.  The border counts as if vertical walls went down from it,
which have no contacts themselves.  All points and directions are in the field's frame.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from ...jit import njit
from ..math import Vec, along, cross, dot, norm, scaled, sub, unit

FLAT = 1e-7  # sine: a fold with a smaller angle is flat
EDGE_SLACK = 1e-9  # of a cell: a point this far beyond a triangle counts as over it
TILT = 0.1  # sine: largest tilt of a face or an edge beyond the neighbours of a peak or ridge that supports it
DOWN = (0.0, 0.0, -1.0)


Cell = tuple[int, int]  # (row, column), also of a sample


class Grid(NamedTuple):
    """The positions of the samples of a heightfield."""

    first: int  # entry in the flat array of vertices
    columns: int
    rows: int
    x: float  # m, of the first sample
    y: float
    width: float  # m, of a cell along x
    depth: float  # m, along y


class Fold(NamedTuple):
    """An edge of the field and the two faces that meet there."""

    turn: float  # sine of the angle by which the second face is below the first: > 0 is a ridge
    start: Vec
    end: Vec
    inward_a: Vec  # unit, from the edge into the first face and normal to the edge
    inward_b: Vec
    normal_a: Vec  # unit, of the faces
    normal_b: Vec


class Span(NamedTuple):
    """Cells [column, column_end) x [row, row_end)."""

    column: int
    column_end: int
    row: int
    row_end: int


@njit
def grid_of(model: Any, vertices: Any) -> Grid:
    first = int64(model.vertex_first)
    columns, rows = int64(vertices[first].columns), int64(vertices[first].rows)
    a = vertices[first].position
    b = vertices[first + rows * columns - 1].position
    return Grid(first, columns, rows, a[0], a[1], (b[0] - a[0]) / (columns - 1), (b[1] - a[1]) / (rows - 1))


@njit
def sample(vertices: Any, grid: Grid, row: int, column: int) -> Vec:
    p = vertices[grid.first + row * grid.columns + column].position
    return p[0], p[1], p[2]


@njit
def cell_along(x: float, last: int) -> int:
    """Return the integer below x, limited to [0, last]; 0 for NaN."""
    if not x > 0.0:
        return int64(0)
    if x >= last:
        return int64(last)
    return int64(x)


@njit
def span_of(grid: Grid, low: Vec, high: Vec) -> Span:
    """Return the cells that a box overlaps; none if it is beside the field."""
    x0, x1 = (low[0] - grid.x) / grid.width, (high[0] - grid.x) / grid.width
    y0, y1 = (low[1] - grid.y) / grid.depth, (high[1] - grid.y) / grid.depth
    if not (x1 >= 0.0 and y1 >= 0.0 and x0 <= grid.columns - 1 and y0 <= grid.rows - 1):
        return Span(int64(0), int64(0), int64(0), int64(0))
    return Span(
        cell_along(x0, grid.columns - 2),
        cell_along(x1, grid.columns - 2) + 1,
        cell_along(y0, grid.rows - 2),
        cell_along(y1, grid.rows - 2) + 1,
    )


@njit
def triangle(vertices: Any, grid: Grid, row: int, column: int, which: int) -> tuple[Vec, Vec, Vec]:
    """Return the corners of a triangle, counter-clockwise seen from above."""
    a = sample(vertices, grid, row, column)
    d = sample(vertices, grid, row + 1, column + 1)
    if which == 0:
        return a, sample(vertices, grid, row, column + 1), d
    return a, d, sample(vertices, grid, row + 1, column)


@njit
def normal_of(a: Vec, b: Vec, c: Vec) -> Vec:
    return unit(cross(sub(b, a), sub(c, a)))


@njit
def cell_top(vertices: Any, grid: Grid, row: int, column: int) -> float:
    """Return the largest height of a cell's corners."""
    first = grid.first + row * grid.columns + column
    upper = first + grid.columns
    low = max(vertices[first].position[2], vertices[first + 1].position[2])
    return max(low, max(vertices[upper].position[2], vertices[upper + 1].position[2]))


@njit
def height_above(vertices: Any, grid: Grid, p: Vec) -> float:
    """Return the height of a point above the surface, along z; infinite beside the field."""
    u, v = (p[0] - grid.x) / grid.width, (p[1] - grid.y) / grid.depth
    if not (u >= 0.0 and v >= 0.0 and u <= grid.columns - 1 and v <= grid.rows - 1):
        return np.inf
    column, row = cell_along(u, grid.columns - 2), cell_along(v, grid.rows - 2)
    a, b, c = triangle(vertices, grid, row, column, 0 if u - column >= v - row else 1)
    n = normal_of(a, b, c)
    return dot(n, sub(p, a)) / n[2]


@njit
def is_over(p: Vec, a: Vec, b: Vec, c: Vec, n: Vec) -> bool:
    """Whether a point's foot on the triangle's plane is in the triangle, border included."""
    for k in range(3):
        start, end = (a, b) if k == 0 else ((b, c) if k == 1 else (c, a))
        side = sub(end, start)
        if dot(cross(n, side), sub(p, start)) < -EDGE_SLACK * dot(side, side):
            return False
    return True


@njit
def closest_on_segment(p: Vec, a: Vec, b: Vec) -> Vec:
    way = sub(b, a)
    square = dot(way, way)
    if not square > 0.0:
        return a
    return along(a, min(max(dot(sub(p, a), way) / square, 0.0), 1.0), way)


@njit
def closest_on_triangle(p: Vec, a: Vec, b: Vec, c: Vec, n: Vec) -> Vec:
    if is_over(p, a, b, c, n):
        return along(p, -dot(n, sub(p, a)), n)
    best, least = a, np.inf
    for k in range(3):
        start, end = (a, b) if k == 0 else ((b, c) if k == 1 else (c, a))
        q = closest_on_segment(p, start, end)
        d = sub(p, q)
        if dot(d, d) < least:
            best, least = q, dot(d, d)
    return best


@njit
def has_edge(grid: Grid, row: int, column: int, k: int) -> bool:
    return (column + 1 < grid.columns or k == 1) and (row + 1 < grid.rows or k == 0)


@njit
def is_ridge(vertices: Any, grid: Grid, row: int, column: int, k: int) -> bool:
    """Whether an edge of the sample may be a ridge; a cheap test, False if it is surely flat or a valley.

    Seen from above, the ends of an inner edge and the far corners of its two triangles form a parallelogram.
    """
    last_row, last_column = grid.rows - 1, grid.columns - 1
    if k != 2 and (row == 0 or row == last_row if k == 0 else column == 0 or column == last_column):
        return True
    here = grid.first + row * grid.columns + column
    beyond = here + grid.columns + 1
    if k == 2:
        end, one, other = beyond, here + 1, beyond - 1
    elif k == 0:
        end, one, other = here + 1, beyond, here - grid.columns
    else:
        end, one, other = beyond - 1, beyond, here - 1
    ends = vertices[here].position[2] + vertices[end].position[2]
    sides = vertices[one].position[2] + vertices[other].position[2]
    return ends - sides > 1e-2 * FLAT * min(grid.width, grid.depth)


@njit
def edge_end(vertices: Any, grid: Grid, row: int, column: int, k: int) -> Vec:
    """Return the end of edge k of a sample, which is its start."""
    return sample(vertices, grid, row + (1 if k != 0 else 0), column + (1 if k != 1 else 0))


@njit
def fold_of(vertices: Any, grid: Grid, row: int, column: int, k: int) -> Fold:
    """Return the fold at edge k of a sample that has this edge."""
    start = sample(vertices, grid, row, column)
    end = edge_end(vertices, grid, row, column, k)
    if k == 2:
        return folded(start, end, sample(vertices, grid, row, column + 1), sample(vertices, grid, row + 1, column))
    wall = along(start, 1.0, DOWN)
    one = other = wall
    if row + 1 < grid.rows and column + 1 < grid.columns:
        one = sample(vertices, grid, row + 1, column + 1)
    if k == 0 and row > 0:
        other = sample(vertices, grid, row - 1, column)
    if k == 1 and column > 0:
        other = sample(vertices, grid, row, column - 1)
    if one[2] == wall[2] and one[0] == wall[0] and one[1] == wall[1]:  # the wall comes second
        return folded(start, end, other, one)
    return folded(start, end, one, other)


@njit
def folded(start: Vec, end: Vec, one: Vec, other: Vec) -> Fold:
    """Return the fold between two faces, each given by a point that is not on the edge."""
    way = unit(sub(end, start))
    a, b = sub(one, start), sub(other, start)
    a, b = unit(along(a, -dot(a, way), way)), unit(along(b, -dot(b, way), way))
    n, m = cross(way, a), cross(way, b)
    if n[2] < 0.0:  # the first face is one of the field, whose normal points up
        n = scaled(n, -1.0)
    else:
        m = scaled(m, -1.0)
    return Fold(-dot(n, b), start, end, a, b, n, m)


@njit
def beyond_fold(fold: Fold, d: Vec) -> float:
    """Return the sine by which a unit direction is outside the range between the normals of the two faces."""
    return max(dot(d, fold.inward_a), dot(d, fold.inward_b))


@njit
def neighbour(k: int) -> tuple[int, int]:
    """Return (row, column) of the k-th of six neighbours; k + 3 is opposite to k."""
    sign = 1 if k < 3 else -1
    k = k % 3
    return (0 if k == 0 else sign), (0 if k == 1 else sign)


@njit
def is_peak(vertices: Any, grid: Grid, row: int, column: int) -> bool:
    """Whether the surface is convex at a sample along at least one of its lines; always True at the border."""
    if row == 0 or column == 0 or row == grid.rows - 1 or column == grid.columns - 1:
        return True
    p = sample(vertices, grid, row, column)
    for k in range(3):
        i, j = neighbour(k)
        a = sub(sample(vertices, grid, row + i, column + j), p)
        b = sub(sample(vertices, grid, row - i, column - j), p)
        if a[2] + b[2] < -FLAT * norm(a):
            return True
    return False


@njit
def beyond_peak(vertices: Any, grid: Grid, row: int, column: int, d: Vec) -> float:
    """Return the sine by which a unit direction is outside those along which the sample is a local maximum."""
    p = sample(vertices, grid, row, column)
    worst = -np.inf
    border = False
    for k in range(6):
        i, j = neighbour(k)
        if row + i < 0 or column + j < 0 or row + i >= grid.rows or column + j >= grid.columns:
            border = True
            continue
        way = sub(sample(vertices, grid, row + i, column + j), p)
        worst = max(worst, dot(d, way) / norm(way))
    return max(worst, -d[2]) if border else worst
