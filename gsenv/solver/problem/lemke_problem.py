"""A `Problem` for Lemke's method: bounded rows as they are, 2D contacts as four complementary pairs each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .kernels import Floats
from .lemke import RAY, SINGULAR, SMALLEST_PIVOTS, SOLVED, follow, free_impulses, impulses_of, make_tableau

if TYPE_CHECKING:
    from .problem import Problem

MOST_LEMKE_ROWS = 2000  # of a dense tableau: 32 MB

ACCURATE = 1e-10  # error, in units of the tableau, above which a second try is worth it

REASONS = {
    SOLVED: "",
    RAY: "Lemke's path has ended in a ray: a problem with a positive semidefinite matrix then has no solution "
    "if no row has two bounds.",
    SINGULAR: "The rows without bounds are linearly dependent, which Lemke's method excludes.",
}


def lemke_rows(problem: Problem) -> int:
    """Return the number of rows of the tableau."""
    return problem.row_count + 2 * int(np.sum(problem.contact_dim == 2))


def solve_lemke(problem: Problem, most_pivots: int) -> tuple[Floats, int, str]:
    """Return the impulses where Lemke's path ends, the number of pivots, and why they are no solution ("": they are).

    A 2D contact has the impulses lambda_N, t+, t- >= 0 with lambda_T = t+ - t-, and its sliding speed gamma >= 0
    (Stewart and Trinkle, "An implicit time-stepping scheme for rigid body dynamics with inelastic collisions and
    Coulomb friction", Int. J. Numer. Methods Eng. 39, 1996), whose matrix is copositive:
        t+, t- complementary to u_T + gamma, -u_T + gamma >= 0;  gamma to mu lambda_N - t+ - t- >= 0.
    ValueError where a contact has two tangents.
    """
    spatial = np.flatnonzero(problem.contact_dim == 3)
    if len(spatial):
        raise ValueError(
            f"Contact {spatial[0]} has two tangents under a circular cone, expected at most one for method 'lemke'."
        )
    matrix, rhs, lower, upper, scale, of_row = dense_system(problem)
    # in units in which the diagonal is 1
    matrix, rhs, lower, upper = matrix / np.outer(scale, scale), rhs / scale, lower * scale, upper * scale
    best, least, used, reason = np.clip(0.0 * rhs, lower, upper), np.inf, 0, ""
    for smallest_pivot in SMALLEST_PIVOTS:
        tableau = make_tableau(matrix, rhs, lower, upper)
        pivots, status = follow(tableau, most_pivots - used, smallest_pivot)
        used += int(pivots)
        impulse = polished(matrix, rhs, lower, upper, impulses_of(tableau), free_impulses(tableau))
        error = clip_error(matrix, rhs, lower, upper, impulse)
        if error < least:
            best, least = impulse, error
            reason = REASONS.get(status, f"Lemke's method has taken max_sweeps = {most_pivots} pivots and not ended.")
        if used >= most_pivots or status == SINGULAR or least <= ACCURATE * max(1.0, np.abs(best).max(initial=0.0)):
            break
    return of_row.T @ (best / scale), used, reason


def clip_error(matrix: Floats, rhs: Floats, lower: Floats, upper: Floats, impulse: Floats) -> float:
    """Return the largest entry of the natural map."""
    error = impulse - np.clip(impulse - matrix @ impulse - rhs, lower, upper)
    return float(np.abs(error).max(initial=0.0))


def dense_system(problem: Problem) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
    """Return matrix, right-hand side, bounds, scale, and the map E from tableau rows to problem rows."""
    planar = np.flatnonzero(problem.contact_dim == 2)
    count, contacts = problem.row_count, len(planar)
    normal = problem.contact_row[planar]
    tangent = normal + 1
    size = count + 2 * contacts
    extra, gamma = count + np.arange(contacts), count + contacts + np.arange(contacts)
    of_row = np.zeros((size, count))
    of_row[np.arange(count), np.arange(count)] = 1.0
    of_row[extra, tangent] = -1.0
    matrix = of_row @ problem._system.toarray() @ of_row.T
    # gamma is a speed: its unit keeps the matrix balanced
    unit = problem._row_scale[tangent] ** 2
    matrix[tangent, gamma] = unit
    matrix[extra, gamma] = unit
    matrix[gamma, normal] = problem.friction[planar] * unit
    matrix[gamma, tangent] = -unit
    matrix[gamma, extra] = -unit
    lower, upper = np.zeros(size), np.full(size, np.inf)
    lower[:count], upper[:count] = problem.lower, problem.upper
    lower[normal], upper[normal] = 0.0, np.inf
    lower[tangent], upper[tangent] = 0.0, np.inf
    scale = np.concatenate([problem._row_scale, problem._row_scale[tangent], problem._row_scale[tangent]])
    return matrix, of_row @ problem.rhs, lower, upper, scale, of_row


def polished(
    matrix: Floats, rhs: Floats, lower: Floats, upper: Floats, impulse: Floats, free: NDArray[np.bool_]
) -> Floats:
    """Return the impulses with the free rows solved anew where that removes rounding errors of the pivots."""
    better = impulse.copy()
    try:
        for _ in range(2):
            better[free] -= np.linalg.solve(matrix[np.ix_(free, free)], (matrix @ better + rhs)[free])
    except np.linalg.LinAlgError:  # redundant rows
        return impulse
    errors = [clip_error(matrix, rhs, lower, upper, x) for x in (better, impulse)]
    return better if errors[0] < errors[1] else impulse
