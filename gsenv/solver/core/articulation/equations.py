"""Equations among the rows of joints that are in no tree: solved together, by a factor of their Delassus matrix.

A loop closes with few equations once its tree joints are eliminated, so that their Delassus matrix is small and
dense.  Redundant equations, such as those of a planar linkage in 3D, and stretched chains, whose ends cannot move
apart, make it singular; the compliance of methods/joint_factor.py makes it regular.
"""

from __future__ import annotations

from typing import Any

from numba import uint64

from ...jit import njit
from ...methods.joint_factor import EPSILON
from ..coupled import has_half
from ..energy import ROTATION_GAIN
from ..position_pass import SMOOTH_TURN, displacement_rate, relative_speed, smooth_fraction
from ..rows import BILATERAL, EQUATION, HALF, NO_CORRECTION, UNILATERAL, push_row, start_rate
from .other_joints import has_position

TIED = 1e-9  # of a row's free velocity per impulse: where joints of trees leave less, these already hold the row
REACH = 0.1  # rad, and of a body's size: largest error of a joint that is corrected at once
APART = 0.01  # rad, and of a body's size: joints that are farther apart are first brought together by all rows
_ENOUGH = 1e-6  # of what the sweeps aim at: a smaller residual of the equations is not solved again


@njit
def factorise_equations(world: Any, island: Any, articulation: Any, others: Any) -> None:
    """List the equations among the first rows, which are whitened, and factorise their Delassus matrix."""
    if others is None:
        return
    rows = world.scratch.rows
    order = others.order
    give = others.give
    n = 0
    for r in range(island.other_rows):
        row = rows[r]
        if row.kind == EQUATION and row.softness == 0.0 and row.diagonal <= TIED * others.free[r]:
            row.impulse = 0.0  # else rounding and the compliance would make it arbitrary, and often huge
            row.diagonal = 0.0
        elif row.kind == EQUATION and others.free[r] > 0.0:
            order[n] = r
            give[n] = max(row.softness, EPSILON * others.free[r])
            n += 1
            row.diagonal = others.free[r] + row.softness  # the measure of residuals
        else:
            row.diagonal += EPSILON * others.free[r]
        row.effective_mass = 1.0 / row.diagonal if row.diagonal > 0.0 else 0.0
        others.mass[r] = row.effective_mass
        row.diagonal = row.diagonal if row.diagonal > 0.0 else others.free[r]
    island.equations = n
    _fill(n, articulation, others)
    factorise_matrix(n, others.matrix)


@njit
def _fill(n: Any, articulation: Any, others: Any) -> None:
    """Fill the lower triangle of the Delassus matrix."""
    spans = articulation.spans
    ways = articulation.ways
    values = articulation.values
    order = others.order
    dense = others.dense
    matrix = others.matrix
    for i in range(n):
        span = spans[order[i]]
        at = span.values
        for p in range(span.places, span.places + span.count):
            dense[ways[p]] += values[at]  # a row in two halves may list a freedom twice
            at += span.stride
        for j in range(i + 1):
            matrix[i, j] = dot_with(spans[order[j]], ways, values, dense)
        matrix[i, i] += others.give[i]
        for p in range(span.places, span.places + span.count):
            dense[ways[p]] = 0.0


@njit
def factorise_matrix(n: Any, matrix: Any) -> None:
    """Replace the lower triangle by its Cholesky factor, with zeros where rounding leaves nothing."""
    for i in range(n):
        size = matrix[i, i]
        for j in range(i):
            x = matrix[i, j]
            for k in range(j):
                x -= matrix[i, k] * matrix[j, k]
            x = x / matrix[j, j] if matrix[j, j] > 0.0 else 0.0
            matrix[i, j] = x
            size -= x * x
        matrix[i, i] = size**0.5 if size > 0.0 else 0.0


@njit
def substitute(n: Any, matrix: Any, x: Any) -> None:
    """Solve L L^T x = x."""
    for i in range(n):
        s = x[i]
        for j in range(i):
            s -= matrix[i, j] * x[j]
        x[i] = s / matrix[i, i] if matrix[i, i] > 0.0 else 0.0
    for i in range(n - 1, -1, -1):
        s = x[i]
        for j in range(i + 1, n):
            s -= matrix[j, i] * x[j]
        x[i] = s / matrix[i, i] if matrix[i, i] > 0.0 else 0.0


@njit
def dot_with(span: Any, ways: Any, values: Any, z: Any) -> Any:
    """Return y . z of a row."""
    s = 0.0
    i = uint64(span.values)  # no sign to check
    stride = uint64(span.stride)
    for p in range(uint64(span.places), uint64(span.places + span.count)):
        s += values[i] * z[ways[p]]
        i += stride
    return s


@njit
def add_to(span: Any, ways: Any, values: Any, z: Any, impulse: Any) -> None:
    """Add y times an impulse to z."""
    i = uint64(span.values)
    stride = uint64(span.stride)
    for p in range(uint64(span.places), uint64(span.places + span.count)):
        z[ways[p]] += values[i] * impulse
        i += stride


@njit
def sweep_others(world: Any, island: Any, articulation: Any, others: Any, push: Any) -> Any:
    """Take one sweep over the rows of joints in no tree, their equations last; returns sum d^2 A_rr.

    ``push`` as in methods/pgs.sweep.  The change of the equations is measured by the velocities before.
    """
    if others is None or island.other_rows == 0:
        return 0.0
    rows = world.scratch.rows
    spans = articulation.spans
    ways = articulation.ways
    values = articulation.values
    z = articulation.whitened
    change = 0.0
    for r in range(island.other_rows):
        row = rows[r]
        if row.kind == EQUATION:
            continue
        push_row(row, push)
        old = row.impulse
        w = spans[r].free + row.softness * old + dot_with(spans[r], ways, values, z)
        new = min(max(old - row.effective_mass * w, row.lower), row.upper)
        row.impulse = new
        if new != old:
            add_to(spans[r], ways, values, z, new - old)
        change += (new - old) * (new - old) * row.diagonal
    return change + _solve_equations(world, island, articulation, others, push)


@njit
def _solve_equations(world: Any, island: Any, articulation: Any, others: Any, push: Any) -> Any:
    """Solve the equations at the present impulses of all other rows; returns sum w^2 / A_rr before."""
    rows = world.scratch.rows
    spans = articulation.spans
    ways = articulation.ways
    values = articulation.values
    z = articulation.whitened
    order = others.order
    side = others.side
    n = island.equations
    change = 0.0
    for i in range(n):
        r = order[i]
        row = rows[r]
        push_row(row, push)
        w = spans[r].free + others.give[i] * row.impulse + dot_with(spans[r], ways, values, z)
        side[i] = -w
        change += w * w * row.effective_mass
    goal = world.options.tolerance * world.options.tolerance * island.residual_scale
    if change <= _ENOUGH * goal:
        return change
    substitute(n, others.matrix, side)
    for i in range(n):
        rows[order[i]].impulse += side[i]
        add_to(spans[order[i]], ways, values, z, side[i])
    return change


@njit
def contradiction(world: Any, island: Any, others: Any) -> Any:
    """Return the residual that the compliance of the equations hides: large only where these contradict each other."""
    if others is None or island.equations == 0:
        return 0.0
    rows = world.scratch.rows
    left = 0.0
    for i in range(island.equations):
        row = rows[others.order[i]]
        w = (others.give[i] - row.softness) * row.impulse
        left += w * w * row.effective_mass
    return (left / island.residual_scale) ** 0.5


@njit
def is_apart(world: Any, island: Any, others: Any) -> Any:
    """Whether a rigid joint in no tree is so far apart that Newton's method may not close it, if it can be closed."""
    if others is None:
        return False
    rows = world.scratch.rows
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    for r in range(island.other_rows):
        row = rows[r]
        off = row.correction == BILATERAL or (row.correction == UNILATERAL and row.error < 0.0)
        if off and row.softness == 0.0 and abs(row.error) > APART * size_of(world, row):
            if has_position(joint_models[row.source], joint_parameters[row.source]):
                return True
    return False


@njit
def clear_biases(world: Any, island: Any, articulation: Any, others: Any) -> Any:
    """Set the biases of the equations to 0 where their impulses add more energy than rotation does; True if so.

    Without biases their solution is a projection, which cannot; see energy.gains_energy.
    """
    if others is None or island.equations == 0 or island.driven or island.has_springs:
        return False
    rows = world.scratch.rows
    spans = articulation.spans
    z = articulation.whitened
    gain = 0.0
    for f in range(island.freedoms):
        gain += z[f] * z[f]
    for r in range(island.rows):
        gain += 2.0 * rows[r].impulse * (spans[r].free - rows[r].bias)
    if not gain > ROTATION_GAIN * island.kinetic:
        return False
    for r in range(island.other_rows):
        if rows[r].kind == EQUATION:
            spans[r].free -= rows[r].bias
            rows[r].bias = 0.0
    return True


@njit
def only_closes(world: Any, island: Any, others: Any) -> Any:
    """Whether the rows that act only close loops, so that they do no work but in a jump of velocities."""
    if others is None or island.other_rows == 0:
        return False
    rows = world.scratch.rows
    for r in range(island.rows):
        row = rows[r]
        closes = r < island.other_rows and row.correction == BILATERAL and row.softness == 0.0 and row.drive == 0.0
        if not closes and row.kind != HALF and row.impulse != 0.0:
            return False
    return True


@njit
def smooth_with_others(world: Any, island: Any, others: Any) -> Any:
    """Return position_pass.smooth_fraction; a taut rope of which the links turn is smooth.

    Velocities of links at the middle contain half of the bend: where a row was taut, its rate at the start is its bias.
    """
    if others is None or island.other_rows == 0:
        return smooth_fraction(world, island)
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    for r in range(island.other_rows):
        row = rows[r]
        slow = SMOOTH_TURN * relative_speed(row, world.state.bodies, world.parameters.bodies)
        taut = row.correction == UNILATERAL and abs(start_rate(row, substep_bodies) - row.bias) <= slow
        row.position_impulse = 1.0 if taut else 0.0
        if taut:
            row.correction = NO_CORRECTION
    smooth = smooth_fraction(world, island)
    for r in range(island.other_rows):
        if rows[r].position_impulse > 0.0:
            rows[r].correction = UNILATERAL
    return smooth


@njit
def start_corrections(world: Any, island: Any, others: Any) -> Any:
    """Set ``previous`` of the rows of joints in no tree to the rate at which their errors at the end of the substep
    are removed, and ``position_impulse`` to 0; returns whether there are any.

    The displacement is that of velocities that are known; see position_pass.correct_positions.
    """
    if others is None or island.other_rows == 0:
        return False
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    rate = world.options.correction_rate / island.h
    busy = False
    for r in range(island.other_rows):
        row = rows[r]
        row.position_impulse = 0.0
        row.previous = 0.0
        if row.correction == BILATERAL:
            moved = displacement_rate(row, bodies, substep_bodies, island.smooth, island.h)
            if has_half(rows, r, island.other_rows):
                moved += displacement_rate(rows[r + 1], bodies, substep_bodies, island.smooth, island.h)
            row.previous = row.error / island.h + moved + row.drive
        elif row.correction == UNILATERAL:
            row.previous = rate * min(row.error, 0.0)
        if row.previous != 0.0:
            bound_correction(row, size_of(world, row), island.h)
        busy = busy or row.previous != 0.0
    return busy


@njit
def size_of(world: Any, row: Any) -> Any:
    """Return the length that the error of a row is compared with: twice the larger radius of gyration; 1 of angles."""
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    linear = (len(row.jacobian_a) + 1) // 2
    turns = True
    for d in range(linear):
        turns = turns and row.jacobian_a[d] == 0.0 and row.jacobian_b[d] == 0.0
    if turns:
        return 1.0
    square = 0.0
    for side in range(2):
        i = row.body_a if side == 0 else row.body_b
        if body_parameters[i].inv_mass > 0.0:
            least = substep_bodies[i].inverse[linear]
            for d in range(linear + 1, len(row.jacobian_a)):
                least = min(least, substep_bodies[i].inverse[d])
            square = max(square, body_parameters[i].inv_mass / max(least, 1e-300))
    return 2.0 * max(square, 1e-300) ** 0.5


@njit
def bound_correction(row: Any, size: Any, h: Any) -> None:
    """Limit the error that is corrected at once to where directions are nearly constant."""
    most = REACH * size / h
    row.previous = min(max(row.previous, -most), most)


@njit
def correct_others(world: Any, island: Any, articulation: Any, others: Any) -> None:
    """Take one sweep of the position pass over the rows of joints in no tree, their equations last."""
    if others is None or island.other_rows == 0:
        return
    rows = world.scratch.rows
    spans = articulation.spans
    ways = articulation.ways
    values = articulation.values
    z = articulation.whitened
    order = others.order
    side = others.side
    n = island.equations
    for r in range(island.other_rows):
        row = rows[r]
        if row.correction != UNILATERAL or row.error > 0.0:
            continue
        w = row.previous + dot_with(spans[r], ways, values, z)
        new = max(row.position_impulse - others.mass[r] * w, 0.0)
        add_to(spans[r], ways, values, z, new - row.position_impulse)
        row.position_impulse = new
    for i in range(n):
        r = order[i]
        side[i] = 0.0
        # slow springs are no equations; stiff ones resist corrections
        if rows[r].correction != NO_CORRECTION or others.give[i] > 0.0:
            w = rows[r].previous + others.give[i] * rows[r].position_impulse
            side[i] = -w - dot_with(spans[r], ways, values, z)
    substitute(n, others.matrix, side)
    for i in range(n):
        rows[order[i]].position_impulse += side[i]
        add_to(spans[order[i]], ways, values, z, side[i])
