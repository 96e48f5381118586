"""Soft substeps: overlaps and joint errors leave through springs that act for one solve.

The rows of a substep are solved twice: first with a bias that takes errors back and a softness that keeps
it calm, then rigidly, so that the speed of the bias does not stay.  Both are those of a damped spring,
implicit in time, on the mass that a row sees; its stiffness follows the substep, so short substeps are
stiff.  Positions move with the rigid velocity, second order as ever, and with what the first solve had
on top of it: this push takes the place of the position pass.

Catto, "Soft Constraints", GDC 2011; "Solver2D", box2d.org (2024): its soft step moves the positions between
the two solves, which do not read them, so the order is free.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import HELD, HELD_APART
from .pgs import solve_pgs

CONTACT_FREQUENCY = 30.0  # Hz
CONTACT_DAMPING = 10.0  # ratio
JOINT_FREQUENCY = 60.0
JOINT_DAMPING = 2.0
MOST_PER_SUBSTEP = 0.25  # cycles of a spring in a substep
_INFINITY = float("inf")
_TWO_PI = 6.283185307179586


@njit
def _spring(frequency: Any, damping_ratio: Any, h: Any) -> Any:
    """(rate, give): bias = rate * error, softness = give * A_rr."""
    omega = _TWO_PI * min(frequency, MOST_PER_SUBSTEP / h)
    implicit = 2.0 * damping_ratio + h * omega
    return omega / implicit, 1.0 / (h * omega * implicit)


@njit
def _soften(row: Any, spring: Any, push: Any) -> None:
    rate, give = spring
    row.bias += max(rate * row.error, -push)
    row.softness = give * row.diagonal
    row.effective_mass = 1.0 / (row.diagonal + row.softness)


@njit
def solve_biased(
    rows: Any,
    contact_first: Any,
    count: Any,
    bodies: Any,
    contacts: Any,
    bodies_of: Any,
    motions: Any,
    options: Any,
    scale: Any,
    h: Any,
) -> Any:
    """The solve that takes errors back; its velocities go to ``motion.correction``. Returns sweeps.

    Afterwards rows are as before, but for their impulses.  Open contacts and rows with a softness of
    their own take no part in the push.
    """
    contact = _spring(CONTACT_FREQUENCY, CONTACT_DAMPING, h)
    joint = _spring(JOINT_FREQUENCY, JOINT_DAMPING, h)
    for r in range(count):
        row = rows[r]
        row.position_impulse = row.bias  # free: soft has no position pass
        row.direction = row.softness
        if row.softness > 0.0 or row.diagonal <= 0.0:
            continue
        if r >= contact_first and row.hold == HELD_APART and row.error < 0.0:
            _soften(row, contact, options.push_speed * contacts[row.source].extent)
        elif row.hold == HELD or (row.hold == HELD_APART and row.error < 0.0):
            _soften(row, joint, _INFINITY)
    sweeps, _ = solve_pgs(rows, count, bodies, options.sweeps, options.tolerance, scale, (0, 0), None, None)
    for r in range(count):
        row = rows[r]
        row.bias = row.position_impulse
        row.softness = row.direction
        row.effective_mass = 1.0 / row.diagonal if row.diagonal > 0.0 else 0.0
    for k in range(len(bodies_of)):
        motion = motions[bodies_of[k]]
        for i in range(len(motion.correction)):
            motion.correction[i] = bodies[bodies_of[k]].velocity[i]
    return sweeps


@njit
def keep_push(bodies_of: Any, bodies: Any, motions: Any) -> None:
    """``motion.correction``: what the biased velocity had on top of the present one."""
    for k in range(len(bodies_of)):
        motion = motions[bodies_of[k]]
        for i in range(len(motion.correction)):
            motion.correction[i] -= bodies[bodies_of[k]].velocity[i]
