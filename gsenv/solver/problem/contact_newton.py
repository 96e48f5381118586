"""Bounded rows and contacts with friction by a semismooth Newton method.

Each row or contact is in one state: at a bound or free, open, sticking or sliding. The equations of these states,
linearised, are one sparse system; its solution gives the next states (Alart and Curnier, "A mixed formulation for
frictional contact problems prone to Newton like solution methods", Comput. Methods Appl. Mech. Eng. 92, 1991, with
normal and tangents projected one after the other, and the radius mu lambda_N of the friction disc taken from the
normal's projection). In 2D the equations of a state are linear, so the step from the right states is exact.

A step that doesn't reduce the residual is kept for a few steps, as states settle in no particular order; then
Newton goes on from the best impulses with a line search. Nothing guarantees that it ends at a solution, as
the problem itself need not have one; the caller measures what it gets.
"""

from __future__ import annotations

import numpy as np

from ..jit import njit
from .kernels import Blocks, Floats, System
from .pivoting import Vectors, proximal_velocity
from .sparse_lu import Factor, Rows, factorise, substitute

PATIENCE = 10  # full steps without a smaller residual
SHORTEST_STEP = 1.0 / 64.0


@njit
def linearise_row(system: System, rows: Rows, vectors: Vectors, impulse: Floats, b: int, r: int) -> None:
    """Set a bounded row's equation."""
    rho = 1.0 / (vectors.scale[r] * vectors.scale[r])
    ahead = impulse[r] - rho * vectors.velocity[r]
    bound = min(max(ahead, system.lower[r]), system.upper[r])
    free = bound == ahead and system.lower[r] < system.upper[r]
    rows.velocity_part[b, 0, 0] = rho if free else 0.0
    rows.impulse_part[b, 0, 0] = 0.0 if free else 1.0
    vectors.rhs[r] = -rho * vectors.velocity[r] if free else bound - impulse[r]


@njit
def linearise_contact(block: Blocks, rows: Rows, vectors: Vectors, impulse: Floats, b: int) -> None:
    """Set a contact's equations: rhs = -F and G, H with dF = G dw + H dlambda."""
    r, dim, mu = block.row, block.dim, block.friction
    g, h = rows.velocity_part[b], rows.impulse_part[b]
    rho = 1.0 / (block.scale * block.scale)
    g[:] = 0.0
    h[:] = 0.0
    normal = impulse[r] - rho * vectors.velocity[r]
    if normal <= 0.0:
        for i in range(dim):
            h[i, i] = 1.0
            vectors.rhs[r + i] = -impulse[r + i]
        return
    g[0, 0] = rho
    vectors.rhs[r] = -rho * vectors.velocity[r]
    x = impulse[r + 1] - rho * vectors.velocity[r + 1]
    y = impulse[r + 2] - rho * vectors.velocity[r + 2] if dim == 3 else 0.0
    length = np.sqrt(x * x + y * y)
    radius = mu * normal
    if length <= radius:
        for i in range(1, dim):
            g[i, i] = rho
            vectors.rhs[r + i] = -rho * vectors.velocity[r + i]
        return
    x, y = x / length, y / length
    for i in range(1, dim):
        along = x if i == 1 else y
        for j in range(1, dim):
            other = x if j == 1 else y
            turn = (radius / length) * ((1.0 if i == j else 0.0) - along * other)
            g[i, j] = rho * turn
            h[i, j] = (1.0 if i == j else 0.0) - turn
        g[i, 0] = rho * mu * along
        h[i, 0] = -mu * along
        vectors.rhs[r + i] = radius * along - impulse[r + i]


@njit
def linearise(system: System, rows: Rows, vectors: Vectors, impulse: Floats) -> float:
    """Set the equations of all rows at these impulses; returns sum (s F)^2."""
    proximal_velocity(system, rows, vectors, impulse)
    for b in range(len(system.blocks)):
        block = system.blocks[b]
        if block.dim == 1:
            linearise_row(system, rows, vectors, impulse, b, block.row)
        else:
            linearise_contact(block, rows, vectors, impulse, b)
    total = 0.0
    for r in range(len(impulse)):
        total += (vectors.scale[r] * vectors.rhs[r]) ** 2
    return total


@njit
def product(system: System, rows: Rows, block: Blocks, b: int, vector: Floats, a: int) -> float:
    """Return row a of block b of `(G (W + P) + H) vector`."""
    total = 0.0
    for j in range(block.dim):
        r = block.row + j
        g = rows.velocity_part[b, a, j]
        total += rows.impulse_part[b, a, j] * vector[r]
        if g != 0.0:
            moved = rows.proximal[r] * vector[r]
            for k in range(system.indptr[r], system.indptr[r + 1]):
                moved += system.data[k] * vector[system.indices[k]]
            total += g * moved
    return total


@njit
def newton_change(system: System, rows: Rows, vectors: Vectors, factor: Factor) -> bool:
    """Set `change` to the solution of the linearised equations, refined once; False where a number overflowed."""
    if not factorise(system, rows, factor):
        return False
    substitute(factor, vectors.rhs, vectors.change)
    for b in range(len(system.blocks)):
        block = system.blocks[b]
        for a in range(block.dim):
            r = block.row + a
            vectors.rhs[r] -= product(system, rows, block, b, vectors.change, a)
    substitute(factor, vectors.rhs, vectors.trial)
    total = 0.0
    for r in range(len(vectors.change)):
        vectors.change[r] += vectors.trial[r]
        total += abs(vectors.change[r])
    return total < np.inf


@njit(makes_arrays=True)
def solve_contacts(
    system: System, rows: Rows, vectors: Vectors, factor: Factor, best: Floats, impulse: Floats, most_steps: int
) -> tuple[int, float]:
    """Take Newton steps from `impulse`. Returns (linear systems solved, sum (s F)^2 of `best`).

    `best` is set to the impulses of the smallest residual. Stops where a step no longer reduces it.
    """
    rows.live[:] = 1
    best[:] = impulse
    least = linearise(system, rows, vectors, impulse)
    square, waited = least, 0
    for step in range(1, most_steps + 1):
        if least == 0.0 or not newton_change(system, rows, vectors, factor):
            return step, least
        vectors.trial[:] = impulse
        length = 1.0
        before = square
        while True:
            for r in range(len(impulse)):
                impulse[r] = vectors.trial[r] + length * vectors.change[r]
            square = linearise(system, rows, vectors, impulse)
            if waited < PATIENCE or square < (1.0 - 0.1 * length) * before or length <= SHORTEST_STEP:
                break
            length *= 0.5
        if square < 0.81 * least:
            least = square
            best[:] = impulse
            waited = min(waited, PATIENCE)
            if waited < PATIENCE:
                waited = 0
            continue
        if square < least:
            least = square
            best[:] = impulse
        waited += 1
        if waited == PATIENCE:  # the line search starts from the best
            impulse[:] = best
            square = linearise(system, rows, vectors, impulse)
        elif waited > PATIENCE + 2 or least <= 1e-28 * total_square(vectors, best):
            return step, least
    return most_steps, least


@njit
def total_square(vectors: Vectors, impulse: Floats) -> float:
    """Return sum (s lambda)^2."""
    total = 0.0
    for r in range(len(impulse)):
        total += (vectors.scale[r] * impulse[r]) ** 2
    return total
