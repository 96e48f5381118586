"""Springs and dampers as rows, at any stiffness."""

from __future__ import annotations

from typing import Any

from .jit import njit
from .motion import start_rate
from .rows import BOUNDED, EQUATION, UNHELD, relative_velocity
from .solvers.cholesky import add_force, clear_sides, substitute
from .solvers.tree import give_of, solve_equations
from .trig import exp_minus, sin_cos

_TWO_PI = 6.283185307179586
EXACT = 0.8  # rad in a substep: slower springs keep their phase, faster ones are implicit


@njit
def has_spring(parameters: Any) -> Any:
    return parameters.frequency > 0.0 or parameters.stiffness > 0.0 or parameters.damping > 0.0


@njit
def set_spring(row: Any, parameters: Any, speed: Any, motions: Any, h: Any) -> None:
    """Kind, bias and softness of a spring and damper on a rigid row's error; its effective mass is still to be set.

    ``speed``: that of the resting point.  x'' = -2 d x' - w^2 x + g on the mass that the row sees, m = 1/A_rr.
    For slow springs the discrete map of (x, v), x1 = x0 + h (v0 + v1)/2, v1 = a x0 + b v0 + c (v_free - v0), gets
    the trace and determinant of the exact flow, so frequency and decay are exact, and c = -a/(w^2 h) makes the
    sag exact. As a row: softness = gamma A_rr with gamma = c/(1 - c), bias = (gamma - (1 + gamma) b) v0
    - (1 + gamma) a x0.  Fast springs are implicit Euler steps: k = m w^2, softness = 1/(h (damping +
    h k)) (Catto, "Soft constraints", GDC 2011), which damps what the step can't follow.  Sweeps converge on them
    no better than on rigid rows: they belong to the exact block.
    """
    row.kind = BOUNDED
    row.hold = UNHELD
    m = row.diagonal
    if m <= 0.0:
        return
    omega = _TWO_PI * parameters.frequency
    square = omega * omega
    rate = parameters.damping_ratio * omega
    if parameters.stiffness > 0.0 or parameters.damping > 0.0:
        square = parameters.stiffness * m
        rate = 0.5 * parameters.damping * m
    if square <= 0.0 and rate <= 0.0:
        return
    x = row.error
    if h * h * square < EXACT * EXACT and h * rate < EXACT:
        a, b, c = _exact_step(square, rate, h)
        gamma = c / (1.0 - c)
        row.bias += (gamma - (1.0 + gamma) * b) * (start_rate(row, motions) - speed) - (1.0 + gamma) * a * x
        row.softness = gamma * m
    else:
        implicit = 2.0 * rate + h * square
        row.kind = EQUATION
        row.bias += square / implicit * x
        row.softness = m / (h * implicit)
    row.bias -= speed


@njit
def _exact_step(square: Any, rate: Any, h: Any) -> Any:
    """(a, b, c) of ``set_spring``."""
    if h * h * square < 1e-10:  # a damper alone: v1 = b v0 + c h g
        x = 2.0 * h * rate
        b = exp_minus(x)
        c = (1.0 - b) / x if x > 1e-4 else 1.0 - 0.5 * x + x * x / 6.0
        return -square * h * c, b, c
    decay = exp_minus(h * rate)
    inside = square - rate * rate
    if inside >= 0.0:
        cosine, _ = sin_cos(h * inside**0.5)
        trace = 2.0 * decay * cosine
    else:
        e = exp_minus(h * (-inside) ** 0.5)
        trace = decay * (e + 1.0 / e)
    det = decay * decay
    a = (trace - 1.0 - det) / h
    return a, 0.5 * (trace - 1.0 + det), -a / (square * h)


@njit
def release_springs(rows: Any, end: Any) -> None:
    """Springs take no part in an impact, which lasts no time."""
    for r in range(end):
        if rows[r].softness > 0.0 and rows[r].kind == EQUATION:
            rows[r].kind = BOUNDED


@njit
def any_sprung(indices: Any, joint_parameters: Any) -> Any:
    """Whether a joint may give back stored energy."""
    for k in range(len(indices)):
        if has_spring(joint_parameters[indices[k]]):
            return True
    return False


@njit
def guard_springs(
    rows: Any, first: Any, end: Any, indices: Any, bodies: Any, motions: Any, movers: Any, size: Any, tree: Any,
    blocks: Any,
) -> None:  # fmt: skip
    """Take contacts back as far as an unfinished solve made energy with them, that of stiff springs included.

    Without contacts the joints' exact block can't gain: implicit steps lose energy.  With dv what the contacts
    change of its solution, v - t dv is the solution for 1 - t of their impulses, and its energy a parabola in t.
    """
    solve_equations(rows, first, bodies, size, tree, blocks, 0.0, None)
    gain = _energy_gain(rows, first, indices, bodies, motions)
    if gain <= 0.0:
        return
    _respond_to_contacts(rows, first, end, indices, movers, size, tree, blocks)
    slope = 0.0
    curve = 0.0
    for k in range(len(indices)):
        m = motions[indices[k]].mass_matrix
        change = movers[indices[k]].direction
        for i in range(len(change)):
            for j in range(len(change)):
                slope += m[i, j] * change[i] * bodies[indices[k]].velocity[j]
                curve += m[i, j] * change[i] * change[j]
    for r in range(first):
        row = rows[r]
        if row.kind == EQUATION and row.softness > 0.0:
            d = _rate_of(row, movers)
            slope += d * (relative_velocity(row, bodies[row.body_a], bodies[row.body_b]) + row.bias) / row.softness
            curve += d * d / row.softness
    if slope <= 0.0 or curve <= 0.0:
        return
    inside = slope * slope - 2.0 * gain * curve
    t = min((slope - inside**0.5) / curve if inside > 0.0 else slope / curve, 1.0)
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION:
            row.impulse += t * _rate_of(row, movers) / give_of(row) if row.diagonal > 0.0 else 0.0
        elif r >= first or row.hold != UNHELD:
            row.impulse *= 1.0 - t
    for k in range(len(indices)):
        velocity = bodies[indices[k]].velocity
        for i in range(len(velocity)):
            velocity[i] -= t * movers[indices[k]].direction[i]


@njit
def _energy_gain(rows: Any, first: Any, indices: Any, bodies: Any, motions: Any) -> Any:
    """J that the solve added; half of what dampers take is not counted."""
    gain = 0.0
    for k in range(len(indices)):
        motion = motions[indices[k]]
        v = bodies[indices[k]].velocity
        free = motion.free_velocity
        for i in range(len(v)):
            for j in range(len(v)):
                gain += 0.5 * motion.mass_matrix[i, j] * (v[i] * v[j] - free[i] * free[j])
    for r in range(first):
        row = rows[r]
        if row.softness <= 0.0:
            continue
        rate = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
        if row.kind == EQUATION:
            gain += (0.5 * rate + row.bias) * rate / row.softness
        elif row.hold == UNHELD:  # a slow spring: its work
            free_rate = 0.0
            for i in range(len(row.jacobian_a)):
                free_rate += row.jacobian_a[i] * motions[row.body_a].free_velocity[i]
                free_rate += row.jacobian_b[i] * motions[row.body_b].free_velocity[i]
            gain -= 0.5 * row.impulse * (rate + free_rate)
    return gain


@njit
def _respond_to_contacts(
    rows: Any, first: Any, end: Any, indices: Any, movers: Any, size: Any, tree: Any, blocks: Any
) -> None:
    """``direction`` of the movers: what contacts and limits change of the velocities, joints answering."""
    clear_sides(size, tree)
    for k in range(len(indices)):
        for i in range(len(movers[indices[k]].direction)):
            movers[indices[k]].direction[i] = 0.0
    for r in range(end):
        row = rows[r]
        if row.impulse != 0.0 and row.kind != EQUATION and (r >= first or row.hold != UNHELD):
            add_force(row, tree, row.impulse)
            for i in range(len(row.jacobian_a)):  # of bodies without joints
                a = movers[row.body_a]
                b = movers[row.body_b]
                a.direction[i] += a.inverse[i] * row.jacobian_a[i] * row.impulse
                b.direction[i] += b.inverse[i] * row.jacobian_b[i] * row.impulse
    substitute(size, tree, blocks)
    for p in range(size):
        for i in range(len(tree[p].x)):
            movers[tree[p].order].direction[i] = tree[p].x[i]


@njit
def _rate_of(row: Any, movers: Any) -> Any:
    """J dv."""
    s = 0.0
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * movers[row.body_a].direction[i] + row.jacobian_b[i] * movers[row.body_b].direction[i]
    return s
