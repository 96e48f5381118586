"""Rows of gears that act on the bodies of two joints: two halves with one impulse.

J v of such a row is that of its first half plus that of the row after it, the second half.  Two bodies are not enough
where the joints are on moving bodies: the fingers of a hand, which one motor moves apart, push the hand with the sum of
their forces.  In joint coordinates the first half is an equation, and whiten_rows adds the second to it; in body space
it is COUPLED, and only sweeps solve it.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..records.model import JointKind
from .dispatch import by_dimension
from .rows import BILATERAL, COUPLED, EQUATION, HALF, NO_CORRECTION, apply_impulse, relative_velocity

set_coordinate = by_dimension("joints.gear", "set_coordinate")

_AXIS = int(JointKind.AXIS)
_INFINITY = float("inf")
CORRECTION = 0.2  # of the error, removed in each substep in body space, where no position pass corrects it


@njit
def has_half(rows: Any, r: Any, end: Any) -> Any:
    """Whether row r, one of ``rows[:end]``, has a second half."""
    return r + 1 < end and rows[r + 1].kind == HALF


@njit
def is_coupled(gear: Any) -> Any:
    """Whether a gear needs a row in two halves."""
    return gear.model.row_count == 2


@njit
def add_coupled_rows(world: Any, row: Any, gear: Any, first: Any, second: Any, h: Any) -> None:
    """Write the two halves of a gear's row from ``rows[row]`` on; of joints that are disabled it does nothing."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    if not (_is_enabled(world, gear.model.joint_a) and _is_enabled(world, gear.model.joint_b)):
        for i in range(2):
            _scale(rows[row + i], 0.0)
        couple_rows(rows, row, 0.0, 0.0, substep_bodies, h)
        return
    p, curve_p = set_coordinate(rows[row], first, bodies, body_parameters, substep_bodies, h)
    q, curve_q = set_coordinate(rows[row + 1], second, bodies, body_parameters, substep_bodies, h)
    k = gear.parameters.ratio
    _scale(rows[row + 1], k)
    error = p + k * q - gear.parameters.reference_angle
    couple_rows(rows, row, error, curve_p + k * curve_q, substep_bodies, h)


@njit
def _is_enabled(world: Any, j: Any) -> Any:
    model = world.model.joints[j]
    main = model.joint_a if model.kind == _AXIS else j
    return world.parameters.joints[main].enabled != 0


@njit
def _scale(row: Any, k: Any) -> None:
    for d in range(len(row.jacobian_a)):
        row.jacobian_a[d] = k * row.jacobian_a[d] if k != 0.0 else 0.0
        row.jacobian_b[d] = k * row.jacobian_b[d] if k != 0.0 else 0.0


@njit
def couple_rows(rows: Any, r: Any, error: Any, curve: Any, substep_bodies: Any, h: Any) -> None:
    """Make rows r and r + 1, whose bodies and Jacobians are set, the halves of one rigid row, slot 0.

    ``error``: m or rad; ``curve``: m/s or rad/s, the change of J v by the end of the substep.
    """
    for i in range(2):
        row = rows[r + i]
        row.kind = HALF if i == 1 else COUPLED
        row.correction = NO_CORRECTION if i == 1 else BILATERAL
        row.slot = 0
        row.error = 0.0
        row.lower = -_INFINITY
        row.upper = _INFINITY
        row.bias = 0.0
        row.drive = 0.0
        row.softness = 0.0
        row.diagonal = 0.0
        row.effective_mass = 0.0
    row = rows[r]
    row.error = error
    row.bias = curve + CORRECTION * error / h
    row.diagonal = _coupled_size(rows[r], rows[r + 1], substep_bodies)
    row.effective_mass = 1.0 / row.diagonal if row.diagonal > 0.0 else 0.0


@njit
def _coupled_size(one: Any, two: Any, substep_bodies: Any) -> Any:
    """Return J M^-1 J^T of a row with its second half, which may share bodies."""
    size = 0.0
    for p in range(4):
        row = one if p < 2 else two
        i = row.body_b if p % 2 else row.body_a
        jacobian = row.jacobian_b if p % 2 else row.jacobian_a
        inverse = substep_bodies[i].inverse
        for q in range(4):
            other = one if q < 2 else two
            j = other.body_b if q % 2 else other.body_a
            factor = other.jacobian_b if q % 2 else other.jacobian_a
            if i == j:
                for d in range(len(jacobian)):
                    size += jacobian[d] * inverse[d] * factor[d]
    return size


@njit
def solve_coupled(rows: Any, r: Any, bodies: Any) -> Any:
    """Solve row r with its second half in a sweep; returns d^2 A_rr.  The second half takes the impulse at its turn."""
    one = rows[r]
    two = rows[r + 1]
    w = one.bias + relative_velocity(one, bodies[one.body_a], bodies[one.body_b])
    w += relative_velocity(two, bodies[two.body_a], bodies[two.body_b])
    d = -one.effective_mass * w
    one.impulse += d
    apply_impulse(one, bodies[one.body_a], bodies[one.body_b], d)
    apply_impulse(two, bodies[two.body_a], bodies[two.body_b], d)
    return d * d * one.diagonal


@njit
def any_coupled(rows: Any, end: Any) -> Any:
    """Whether one of the rows has a second half."""
    for r in range(end):
        if rows[r].kind == HALF:
            return True
    return False


@njit
def make_equations(rows: Any, first: Any, end: Any) -> None:
    """Make equations of coupled rows, for joint coordinates, in which their coefficients are constant."""
    for r in range(first, end):
        if rows[r].kind == COUPLED:
            rows[r].kind = EQUATION
            rows[r].bias = 0.0


@njit
def share_impulses(rows: Any, end: Any) -> None:
    """Give second halves the impulses of their rows."""
    for r in range(1, end):
        if rows[r].kind == HALF:
            rows[r].impulse = rows[r - 1].impulse


@njit
def share_corrections(rows: Any, end: Any) -> None:
    """Give second halves the impulses of the position pass of their rows."""
    for r in range(1, end):
        if rows[r].kind == HALF:
            rows[r].position_impulse = rows[r - 1].position_impulse
