"""Methods that solve all rows of an island together; no other code depends on the method."""

from __future__ import annotations

from typing import Any

from numba import int64

from ..core.activity import KINEMATIC_CONTACT
from ..core.slices import part
from ..jit import njit
from ..records.options import SolverKind
from .newton import solve_newton
from .nncg import solve_nncg
from .pgs import solve_pgs
from .subspace import solve_subspace

_PGS = int(SolverKind.PGS)
_NNCG = int(SolverKind.NNCG)


@njit
def solve_rows(world: Any, island: Any, joint_factor: Any, soft: Any, newton: Any) -> Any:
    """Solve the island's rows: update their impulses and the velocities of the solver bodies.

    Returns (sweeps, residual).  ``soft`` and ``newton`` are None unless that is the method, so that numba does
    not compile it otherwise.
    """
    scratch = world.scratch
    rows = scratch.rows
    count = island.rows
    bodies = scratch.solver_bodies
    island_bodies = part(scratch.island_bodies, island.body_first, island.body_count)
    limits = (int64(world.options.sweeps), world.options.tolerance, island.residual_scale)
    contact = island.activity == KINEMATIC_CONTACT
    if soft is not None:
        return solve_pgs(rows, count, bodies, joint_factor, limits)
    if newton is not None:
        return solve_newton(rows, count, bodies, island_bodies, scratch, contact, joint_factor, limits)
    kind = world.options.solver
    if kind == _PGS:
        return solve_pgs(rows, count, bodies, joint_factor, limits)
    if kind == _NNCG:
        return solve_nncg(rows, count, bodies, island_bodies, joint_factor, limits)
    return solve_subspace(rows, count, bodies, island_bodies, scratch, contact, joint_factor, limits)
