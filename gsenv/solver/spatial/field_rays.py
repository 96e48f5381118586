"""Intersections of rays with a heightfield, from cell to cell; all points and directions are in the field's frame.

The cells under a ray are visited along the axis on which it advances faster, so two or three at each step.  A
cell whose heights the ray does not reach is skipped.  Triangles are tested in coordinates across the ray (as in
S. Woop, C. Benthin and I. Wald, "Watertight ray/triangle intersection", JCGT 2 (1), 2013), which are equal, bit by
bit, for triangles that share a corner: no ray passes between two triangles.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from ..core.rays import SLACK, Hit, Ray, slab
from ..jit import njit
from .math import Vec, add, along, dot, norm, sub, tangents
from .narrowphase.fields import (
    Cell,
    Grid,
    cell_along,
    cell_top,
    closest_on_triangle,
    grid_of,
    height_above,
    normal_of,
    sample,
    span_of,
    triangle,
)


class Stretch(NamedTuple):
    """A part of a ray, from a start in the field's box, and the axes across it."""

    at: Vec  # m
    way: Vec  # unit
    aside: Vec  # unit, with aside x above = -way
    above: Vec
    length: float  # m
    pad: float  # m, above all rounding errors


class Steps(NamedTuple):
    """The path over the cells: `place + t speed` counts cells along the faster axis and along the slower one."""

    by_columns: bool  # whether the faster axis is x
    place: float
    speed: float  # 1/m
    last: int  # index of the last cell
    slow_place: float
    slow_speed: float
    slow_last: int
    slack: float  # of a cell, above all rounding errors


class Crossing(NamedTuple):
    """The nearest triangle that a ray has crossed from above; row -1: none."""

    distance: float  # m
    row: int
    column: int
    which: int


@njit
def miss() -> Hit:
    return Hit(np.inf, (0.0, 0.0, 0.0))


@njit
def inside(ray: Ray) -> Hit:
    return Hit(0.0, (-ray.way[0], -ray.way[1], -ray.way[2]))


@njit
def field_hit(ray: Ray, model: Any, vertices: Any, depth: float) -> Hit:
    """Return the first crossing of the surface from above; starts at most `depth` m below it are inside."""
    grid = grid_of(model, vertices)
    if depth > 0.0 and lies_below(vertices, grid, ray.at, depth):
        return inside(ray)
    lowest, highest = vertices[grid.first].normal[0], vertices[grid.first].normal[1]
    enter, stretch = stretch_over(ray, grid, lowest, highest)
    if not stretch.length >= 0.0:
        return miss()
    found = walk(vertices, grid, stretch, steps_of(stretch, grid))
    if found.row < 0:
        return miss()
    a, b, c = triangle(vertices, grid, found.row, found.column, found.which)
    return Hit(enter + found.distance, normal_of(a, b, c))


@njit
def lies_below(vertices: Any, grid: Grid, p: Vec, depth: float) -> bool:
    """Whether a point is below the surface, and within `depth` m of it."""
    height = height_above(vertices, grid, p)
    if not height < 0.0:
        return False
    if -height <= depth:
        return True
    room = (depth, depth, depth)
    span = span_of(grid, sub(p, room), add(p, room))
    for row in range(span.row, span.row_end):
        for column in range(span.column, span.column_end):
            for which in range(2):
                a, b, c = triangle(vertices, grid, row, column, which)
                n = normal_of(a, b, c)
                if abs(dot(n, sub(a, p))) <= depth:
                    if norm(sub(closest_on_triangle(p, a, b, c, n), p)) <= depth:
                        return True
    return False


@njit
def stretch_over(ray: Ray, grid: Grid, lowest: float, highest: float) -> tuple[float, Stretch]:
    """Return the distance in m at which a ray enters the field's box, and its part in there, of length < 0 if none."""
    wide, deep = 0.5 * (grid.columns - 1) * grid.width, 0.5 * (grid.rows - 1) * grid.depth
    middle = (grid.x + wide, grid.y + deep, 0.5 * (lowest + highest))
    apart = sub(ray.at, middle)
    high = 0.5 * (highest - lowest)
    far = abs(ray.at[0]) + abs(ray.at[1]) + abs(ray.at[2]) + abs(middle[0]) + abs(middle[1]) + abs(middle[2])
    pad = SLACK * (far + wide + deep + high)
    x0, x1 = slab(apart[0], ray.way[0], wide + pad)
    y0, y1 = slab(apart[1], ray.way[1], deep + pad)
    z0, z1 = slab(apart[2], ray.way[2], high + pad)
    enter = max(max(x0, y0), max(z0, 0.0))
    leave = min(min(x1, y1), min(z1, ray.length))
    across, above = tangents(ray.way)
    start = along(ray.at, enter, ray.way) if enter < leave else ray.at
    aside = (-across[0], -across[1], -across[2])
    return enter, Stretch(start, ray.way, aside, above, leave - enter, pad)


@njit
def steps_of(stretch: Stretch, grid: Grid) -> Steps:
    u, v = (stretch.at[0] - grid.x) / grid.width, (stretch.at[1] - grid.y) / grid.depth
    du, dv = stretch.way[0] / grid.width, stretch.way[1] / grid.depth
    slack = stretch.pad / min(grid.width, grid.depth) + SLACK * (grid.columns + grid.rows)
    if abs(du) >= abs(dv):
        return Steps(True, u, du, grid.columns - 2, v, dv, grid.rows - 2, slack)
    return Steps(False, v, dv, grid.rows - 2, u, du, grid.columns - 2, slack)


@njit
def walk(vertices: Any, grid: Grid, stretch: Stretch, steps: Steps) -> Crossing:
    """Return the nearest crossing of the cells under a stretch of a ray."""
    found = Crossing(np.inf, int64(-1), int64(-1), int64(-1))
    first, last = cells_between(steps.place, steps.speed, 0.0, stretch.length, steps.slack, steps.last)
    for k in range(last - first + 1):
        i = first + k if steps.speed >= 0.0 else last - k
        start, end = time_in_cell(i, steps, stretch.length)
        if not start <= end:
            continue
        low, high = cells_between(steps.slow_place, steps.slow_speed, start, end, steps.slack, steps.slow_last)
        for j in range(low, high + 1):
            row, column = (j, i) if steps.by_columns else (i, j)
            if reaches_cell(vertices, grid, stretch, (row, column), start, end):
                found = cross_cell(vertices, grid, stretch, (row, column), found)
        if found.distance <= end:
            break
    return found


@njit
def cells_between(place: float, speed: float, start: float, end: float, slack: float, last: int) -> tuple[int, int]:
    """Return the first and last cell of [0, last] that `place + t speed` is in or near for t from start to end."""
    one, other = place + start * speed, place + end * speed
    return cell_along(min(one, other) - slack, last), cell_along(max(one, other) + slack, last)


@njit
def time_in_cell(i: int, steps: Steps, length: float) -> tuple[float, float]:
    """Return the part of a stretch, in m from its start, over cell i of the faster axis, or near it."""
    if steps.speed == 0.0:
        return 0.0, length
    one = (i - steps.slack - steps.place) / steps.speed
    other = (i + 1 + steps.slack - steps.place) / steps.speed
    return max(min(one, other), 0.0), min(max(one, other), length)


@njit
def reaches_cell(vertices: Any, grid: Grid, stretch: Stretch, cell: Cell, start: float, end: float) -> bool:
    """Whether the heights of a stretch from `start` to `end` m overlap those of a cell."""
    row, column = cell
    one = stretch.at[2] + start * stretch.way[2]
    other = stretch.at[2] + end * stretch.way[2]
    if min(one, other) - stretch.pad > cell_top(vertices, grid, row, column):
        return False
    return max(one, other) + stretch.pad >= cell_bottom(vertices, grid, row, column)


@njit
def cell_bottom(vertices: Any, grid: Grid, row: int, column: int) -> float:
    """Return the smallest height of a cell's corners."""
    first = grid.first + row * grid.columns + column
    upper = first + grid.columns
    low = min(vertices[first].position[2], vertices[first + 1].position[2])
    return min(low, min(vertices[upper].position[2], vertices[upper + 1].position[2]))


@njit
def cross_cell(vertices: Any, grid: Grid, stretch: Stretch, cell: Cell, found: Crossing) -> Crossing:
    """Return the nearer of a crossing and those of a cell's triangles."""
    row, column = cell
    a = across(stretch, sample(vertices, grid, row, column))
    b = across(stretch, sample(vertices, grid, row, column + 1))
    c = across(stretch, sample(vertices, grid, row + 1, column + 1))
    d = across(stretch, sample(vertices, grid, row + 1, column))
    distance = crossing(a, b, c)
    if distance < found.distance:
        found = Crossing(distance, row, column, int64(0))
    distance = crossing(a, c, d)
    if distance < found.distance:
        found = Crossing(distance, row, column, int64(1))
    return found


@njit
def across(stretch: Stretch, p: Vec) -> Vec:
    """Return a point's coordinates: two across the ray, and the third along it, m."""
    q = sub(p, stretch.at)
    return dot(q, stretch.aside), dot(q, stretch.above), dot(q, stretch.way)


@njit
def side_of(p: Vec, q: Vec) -> float:
    """Return on which side of the ray the edge from p to q passes; exactly the opposite from q to p."""
    return p[0] * q[1] - p[1] * q[0]


@njit
def crossing(a: Vec, b: Vec, c: Vec) -> float:
    """Return the distance at which the ray crosses a triangle from its front, border included, or infinity."""
    one, two, three = side_of(b, c), side_of(c, a), side_of(a, b)
    total = one + two + three
    if not (one >= 0.0 and two >= 0.0 and three >= 0.0 and total > 0.0):
        return np.inf
    distance = (one * a[2] + two * b[2] + three * c[2]) / total
    return distance if distance >= 0.0 else np.inf
