"""How all rows of an island are made true at once: the one place that knows a method."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..model import SolverKind
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
    envelope: Any,
    edges: Any,
    blocks: Any,
    pressed: Any,
) -> Any:
    """Solve ``rows[:count]``; updates their impulses and the bodies' velocities.

    Returns (sweeps, residual). ``scale``: what the squared residual is compared with.
    """
    if kind == _PGS:
        return solve_pgs(rows, count, bodies, max_sweeps, tolerance, scale)
    if kind == _NNCG:
        return solve_nncg(rows, count, bodies, max_sweeps, tolerance, scale)
    return solve_subspace(
        rows, count, bodies, max_sweeps, tolerance, scale, bodies_of, motions, envelope, edges, blocks, pressed
    )
