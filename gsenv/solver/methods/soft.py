"""Soft substeps: springs that act in one solve only correct overlaps and joint errors.

The rows of a substep are solved twice: first with a bias that corrects errors and a softness that damps
it, then rigidly, so that the velocity of the bias does not remain.  Bias and softness are those of a damped
spring, implicit in time, on the effective mass of a row; its stiffness grows as the substep gets shorter.
Positions move with the rigid velocity, to second order as with all methods, and with the excess of the
first solve's velocity over it: this pseudo-velocity replaces the position pass.

Catto, "Soft Constraints", GDC 2011; "Solver2D", box2d.org (2024): its soft step moves the positions between
the two solves, which do not read them, so the order is free.
"""

from __future__ import annotations

from typing import Any

from ..core.rows import BILATERAL, UNILATERAL
from ..core.slices import part
from ..jit import njit
from .pgs import solve_pgs

CONTACT_FREQUENCY = 30.0  # Hz
CONTACT_DAMPING = 10.0  # ratio
JOINT_FREQUENCY = 60.0  # Hz
JOINT_DAMPING = 2.0  # ratio
MOST_PER_SUBSTEP = 0.25  # largest number of cycles of a spring in a substep
_INFINITY = float("inf")
_TWO_PI = 6.283185307179586


@njit
def _spring(frequency: Any, damping_ratio: Any, h: Any) -> Any:
    """Return (rate, ratio): bias = rate * error, softness = ratio * A_rr."""
    omega = _TWO_PI * min(frequency, MOST_PER_SUBSTEP / h)
    implicit = 2.0 * damping_ratio + h * omega
    return omega / implicit, 1.0 / (h * omega * implicit)


@njit
def _soften(row: Any, spring: Any, push: Any) -> None:
    rate, ratio = spring
    row.bias += max(rate * row.error, -push)
    row.softness = ratio * row.diagonal
    row.effective_mass = 1.0 / (row.diagonal + row.softness)


@njit
def solve_biased(world: Any, island: Any) -> Any:
    """Solve with biases that correct errors; ``correction`` of the substep bodies gets the velocities.

    Returns the number of sweeps.  Afterwards the rows are as before except for their impulses.  Open contacts
    and rows with their own softness get no bias.
    """
    rows = world.scratch.rows
    bodies = world.scratch.solver_bodies
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    options = world.options
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    contact = _spring(CONTACT_FREQUENCY, CONTACT_DAMPING, island.h)
    joint = _spring(JOINT_FREQUENCY, JOINT_DAMPING, island.h)
    for r in range(island.rows):
        row = rows[r]
        row.position_impulse = row.bias  # unused otherwise: soft has no position pass
        row.direction = row.softness
        if row.softness > 0.0 or row.diagonal <= 0.0:
            continue
        if r >= island.joint_rows and row.correction == UNILATERAL and row.error < 0.0:
            _soften(row, contact, options.push_speed * contacts[row.source].extent)
        elif row.correction == BILATERAL or (row.correction == UNILATERAL and row.error < 0.0):
            _soften(row, joint, _INFINITY)
    sweeps, _ = solve_pgs(rows, island.rows, bodies, None, (options.sweeps, options.tolerance, island.residual_scale))
    for r in range(island.rows):
        row = rows[r]
        row.bias = row.position_impulse
        row.softness = row.direction
        row.effective_mass = 1.0 / row.diagonal if row.diagonal > 0.0 else 0.0
    for k in range(len(island_bodies)):
        substep_body = substep_bodies[island_bodies[k]]
        for i in range(len(substep_body.correction)):
            substep_body.correction[i] = bodies[island_bodies[k]].velocity[i]
    return sweeps


@njit
def keep_pseudo_velocities(world: Any, island: Any) -> None:
    """Set ``correction`` to the excess of the biased velocity over the present one."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        substep_body = substep_bodies[island_bodies[k]]
        for i in range(len(substep_body.correction)):
            substep_body.correction[i] -= bodies[island_bodies[k]].velocity[i]
