"""How all rows of an island are made true at once: the one place that knows a method."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..options import SolverKind
from .newton import solve_newton
from .nncg import solve_nncg
from .pgs import solve_pgs
from .subspace import solve_subspace

_PGS = int(SolverKind.PGS)
_NNCG = int(SolverKind.NNCG)


@njit
def solve_rows(
    rows: Any,
    count: Any,
    bodies: Any,
    kind: Any,
    max_sweeps: Any,
    tolerance: Any,
    scale: Any,
    bodies_of: Any,
    motions: Any,
    factor: Any,
    edges: Any,
    blocks: Any,
    pressed: Any,
    trees: Any,
    tree: Any,
    tree_blocks: Any,
    soft: Any,
    newton: Any,
) -> Any:
    """Solve ``rows[:count]``; updates their impulses and the bodies' velocities.

    Returns (sweeps, residual). ``scale``: what the squared residual is compared with.
    ``soft``, ``newton``: None unless ``kind`` is that method, so that nothing of it is compiled.
    """
    if soft is not None:
        return solve_pgs(rows, count, bodies, max_sweeps, tolerance, scale, trees, tree, tree_blocks)
    if newton is not None:
        return solve_newton(
            rows, count, bodies, max_sweeps, tolerance, scale, bodies_of, motions, factor, edges, blocks, pressed,
            trees, tree, tree_blocks,
        )  # fmt: skip
    if kind == _PGS:
        return solve_pgs(rows, count, bodies, max_sweeps, tolerance, scale, trees, tree, tree_blocks)
    if kind == _NNCG:
        return solve_nncg(rows, count, bodies, max_sweeps, tolerance, scale, bodies_of, trees, tree, tree_blocks)
    return solve_subspace(
        rows, count, bodies, max_sweeps, tolerance, scale, bodies_of, motions, factor, edges, blocks, pressed,
        trees, tree, tree_blocks,
    )  # fmt: skip
