"""Lemke's method for bounded rows of any square matrix.

The rows are solved for the right-hand side q + t d at a t so large that every bounded row is at a bound; then the
path of solutions is followed to t = 0 (Lemke, "Bimatrix equilibrium points and mathematical programming", Management
Science 11, 1965; with bounds as in Sargent, "An efficient implementation of the Lemke algorithm and its extension to
deal with upper and lower bounds", Math. Prog. Study 7, 1978). One pivot changes one row's state. The path ends at a
solution where the matrix is a P-matrix. It may end in a ray otherwise; for positive semidefinite (copositive-plus)
matrices with one-sided bounds that proves that no solution exists (Cottle, Pang, Stone, "The Linear Complementarity
Problem", 1992, theorem 4.4.12). Ties are broken lexicographically, as if q had the additional terms (e, e^2, e^3
...), so no basis recurs in degenerate problems.

The tableau is dense: a pivot takes n^2 operations, a solve mostly n to 2 n pivots.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import njit
from .kernels import Floats, Indices

Bytes = NDArray[np.uint8]

SOLVED, RAY, SINGULAR, TOO_LONG = 0, 1, 2, 3
LOWER, UPPER = 0, 2
SMALLEST_PIVOTS = (1e-10, 1e-13)  # relative to the largest entry of the column: the first, and for a second try
SMALLEST_T = 1e-15  # relative to the first t: the rest is rounding
TIE = 1e-12  # relative difference of two ratios that counts as none


class Tableau(NamedTuple):
    """Basic variables as functions of the others: basic = table @ others, at present `value`.

    Variable i < n is the impulse of row i, n + i its velocity, 2 n is t.
    """

    table: Floats  # (n, n + 1)
    value: Floats  # (n,) of the basic variables
    basic: Indices  # (n,) variable of each line
    column: Indices  # (n + 1,) variable of each column
    place: Indices  # (2 n + 1,) column of a nonbasic variable; -1 - line of a basic one
    lower: Floats  # (n,) bounds of the impulses
    upper: Floats
    side: Bytes  # (n,) LOWER or UPPER: the bound that the row is or was at
    sign: Floats  # (n,) of d: 1 at the lower, -1 at the upper bound, 0 for rows without sides


@njit
def pivot(tableau: Tableau, line: int, column: int) -> None:
    """Exchange the basic variable of a line and the variable of a column."""
    table = tableau.table
    rows, columns = table.shape
    entry = table[line, column]
    for j in range(columns):
        table[line, j] = -table[line, j] / entry
    table[line, column] = 1.0 / entry
    for i in range(rows):
        factor = table[i, column]
        if i == line or factor == 0.0:
            continue
        table[i, column] = 0.0
        for j in range(columns):
            table[i, j] += factor * table[line, j]
    leaving, entering = tableau.basic[line], tableau.column[column]
    tableau.basic[line], tableau.column[column] = entering, leaving
    tableau.place[entering], tableau.place[leaving] = -1 - line, column


@njit
def move(tableau: Tableau, column: int, distance: float) -> None:
    """Change the variable of a column by `distance`."""
    for i in range(len(tableau.value)):
        tableau.value[i] += tableau.table[i, column] * distance


@njit
def free_rows(tableau: Tableau) -> bool:
    """Make impulses without bounds basic and their velocities zero; False where their matrix is singular."""
    table, basic, column = tableau.table, tableau.basic, tableau.column
    n = len(basic)
    scale = 0.0
    for i in range(n):
        if tableau.lower[i] == -np.inf and tableau.upper[i] == np.inf:
            for j in range(n):
                scale = max(scale, abs(table[i, j]))
    while True:
        largest, line, across = 0.0, -1, -1
        left = False
        for i in range(n):
            r = basic[i] - n
            if r < 0 or tableau.lower[r] > -np.inf or tableau.upper[r] < np.inf:
                continue
            left = True
            for j in range(n):
                c = column[j]
                if c < n and tableau.lower[c] == -np.inf and tableau.upper[c] == np.inf and abs(table[i, j]) > largest:
                    largest, line, across = abs(table[i, j]), i, j
        if not left:
            return True
        if largest <= 1e-12 * scale:
            return False
        velocity = tableau.value[line]
        # the impulse changes such that this velocity becomes zero
        step = -velocity / table[line, across]
        move(tableau, across, step)
        pivot(tableau, line, across)
        tableau.value[line] = step


@njit
def room(tableau: Tableau, line: int, rate: float) -> float:
    """Return how far the entering variable may move until the line's variable meets a bound, at `rate` per unit."""
    n = len(tableau.basic)
    variable, value = tableau.basic[line], tableau.value[line]
    if variable == 2 * n:
        return value / -rate if rate < 0.0 else np.inf
    if variable < n:
        bound = tableau.lower[variable] if rate < 0.0 else tableau.upper[variable]
        return (bound - value) / rate
    sign = tableau.sign[variable - n]
    if sign == 0.0:
        return np.inf
    at_upper = tableau.side[variable - n] == UPPER
    if at_upper:
        return -value / rate if rate > 0.0 else np.inf
    return value / -rate if rate < 0.0 else np.inf


@njit
def is_sooner(tableau: Tableau, line: int, other: int, rate: float, other_rate: float) -> bool:
    """Whether, at equal ratios, `line` meets its bound before `other` does with the lexicographic terms."""
    n = len(tableau.basic)
    for r in range(n):
        first, second = 0.0, 0.0
        place = tableau.place[n + r]
        if place >= 0:
            first, second = -tableau.table[line, place], -tableau.table[other, place]
        else:
            first = 1.0 if -1 - place == line else 0.0
            second = 1.0 if -1 - place == other else 0.0
        # value + term e^r meets its bound after (room -+ term e^r / rate)
        first *= -tableau.sign[r] / rate
        second *= -tableau.sign[r] / other_rate
        if abs(first - second) > 1e-11 * max(abs(first), abs(second)):
            return first < second
    return line < other


@njit
def leaving_line(tableau: Tableau, column: int, direction: float, smallest_pivot: float) -> tuple[int, float]:
    """Return the line whose variable meets a bound first and the distance to it; -1 where none does."""
    n = len(tableau.basic)
    table = tableau.table
    largest = 0.0
    for i in range(n):
        largest = max(largest, abs(table[i, column]))
    chosen, least = -1, np.inf
    for i in range(n):
        rate = table[i, column] * direction
        if abs(rate) <= smallest_pivot * largest:
            continue
        distance = max(room(tableau, i, rate), 0.0)
        if distance == np.inf:
            continue
        gap = TIE * max(distance, least) if chosen >= 0 else 0.0
        if chosen < 0 or distance < least - gap:
            chosen, least = i, distance
        elif distance <= least + gap:
            if tableau.basic[chosen] == 2 * n:
                continue
            if tableau.basic[i] == 2 * n or is_sooner(tableau, i, chosen, rate, table[chosen, column] * direction):
                chosen, least = i, min(distance, least)
    return chosen, least


@njit
def first_line(tableau: Tableau) -> int:
    """Return the line that limits t from below, -1 where t = 0 is a solution already."""
    n = len(tableau.basic)
    chosen, largest = -1, 0.0
    for i in range(n):
        r = tableau.basic[i] - n
        rate = tableau.table[i, n]
        if r < 0 or tableau.sign[r] == 0.0 or tableau.value[i] * tableau.sign[r] >= 0.0:
            continue
        needed = -tableau.value[i] / rate
        # at equal needs the lexicographic terms, + e^r at every row, need least t for the row of the smallest power
        if needed >= largest * (1.0 + TIE) or (chosen >= 0 and needed >= largest * (1.0 - TIE)):
            chosen, largest = i, max(needed, largest)
    return chosen


@njit
def follow(tableau: Tableau, most_pivots: int, smallest_pivot: float) -> tuple[int, int]:
    """Follow the path from large t to t = 0. Returns (pivots, SOLVED, RAY, SINGULAR or TOO_LONG)."""
    n = len(tableau.basic)
    if not free_rows(tableau):
        return 0, SINGULAR
    line = first_line(tableau)
    if line < 0:
        return 0, SOLVED
    t = -tableau.value[line] / tableau.table[line, n]
    row = tableau.basic[line] - n
    move(tableau, n, t)
    pivot(tableau, line, n)
    tableau.value[line] = t
    entering, direction, start = row, tableau.sign[row], 0.0
    for count in range(1, most_pivots + 1):
        column = tableau.place[entering]
        start = 0.0
        flip = np.inf
        if entering < n:
            start = tableau.lower[entering] if direction > 0.0 else tableau.upper[entering]
            flip = tableau.upper[entering] - tableau.lower[entering]
        line, distance = leaving_line(tableau, column, direction, smallest_pivot)
        if flip < distance or (line < 0 and flip < np.inf):  # from one bound to the other
            move(tableau, column, direction * flip)
            tableau.side[entering] = UPPER if direction > 0.0 else LOWER
            entering += n
            direction = -1.0 if tableau.side[entering - n] == UPPER else 1.0
            continue
        if line < 0:
            return count, RAY
        leaving = tableau.basic[line]
        rate = tableau.table[line, column] * direction
        move(tableau, column, direction * distance)
        pivot(tableau, line, column)
        tableau.value[line] = start + direction * distance
        place = tableau.place[2 * n]
        if leaving == 2 * n or tableau.value[-1 - place] <= SMALLEST_T * t:
            return count, SOLVED
        if leaving >= n:  # a velocity is zero: its impulse leaves the bound
            entering = leaving - n
            direction = 1.0 if tableau.side[entering] == LOWER else -1.0
        else:
            tableau.side[leaving] = LOWER if rate < 0.0 else UPPER
            entering = leaving + n
            direction = 1.0 if rate < 0.0 else -1.0
    return most_pivots, TOO_LONG


def make_tableau(matrix: Floats, rhs: Floats, lower: Floats, upper: Floats) -> Tableau:
    """Return the tableau of `lower <= lambda <= upper` for velocities `matrix @ lambda + rhs`."""
    n = len(rhs)
    bounded_below, bounded_above = np.isfinite(lower), np.isfinite(upper)
    start = np.where(bounded_below, lower, np.where(bounded_above, upper, 0.0))
    sign = np.where(bounded_below, 1.0, np.where(bounded_above, -1.0, 0.0))
    sign[lower == upper] = 0.0
    table = np.empty((n, n + 1))
    table[:, :n] = matrix
    table[:, n] = sign
    place = np.concatenate([np.arange(n), -1 - np.arange(n), [n]]).astype(np.int64)
    column = np.append(np.arange(n), 2 * n).astype(np.int64)
    basic = np.arange(n, 2 * n, dtype=np.int64)
    side = np.where(bounded_below, LOWER, UPPER).astype(np.uint8)
    value = matrix @ start + rhs
    return Tableau(table, value, basic, column, place, lower.copy(), upper.copy(), side, sign)


def impulses_of(tableau: Tableau) -> Floats:
    """Return the impulses of the present basis, within their bounds."""
    n = len(tableau.basic)
    lower, upper = tableau.lower, tableau.upper
    impulse = np.where(tableau.side == UPPER, upper, lower)
    free = np.flatnonzero(tableau.basic < n)
    impulse[tableau.basic[free]] = tableau.value[free]
    impulse[~np.isfinite(impulse)] = 0.0
    return np.clip(impulse, lower, upper)


def free_impulses(tableau: Tableau) -> NDArray[np.bool_]:
    """Return which rows' impulses are between their bounds."""
    n = len(tableau.basic)
    free = np.zeros(n, bool)
    free[tableau.basic[tableau.basic < n]] = True
    return free
