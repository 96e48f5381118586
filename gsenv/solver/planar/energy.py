"""What the solve of an island did: impulse scale, natural-map residual, and the energy guard."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import EQUATION, FRICTION, HELD_APART, apply_impulse

TURNING_GAIN = 0.02  # of the kinetic energy in a substep: second order, third in the angle of the turn


@njit
def start_impulses(rows: Any, count: Any, movers: Any, pull: Any, h: Any) -> Any:
    """Bring the velocities in line with the impulses that the rows start from; what changes are compared with.

    That is sum ((g h)^2 + u^2) / A_rr, u = J v + bias before any impulse; of what may part only approach
    counts, and of slip no more than friction takes, or a far limit or a fast slide would drown the rest.

    A scale of velocities, not of impulses: under 1000 kg the load is 1000 times the weight of the
    box that carries it, and a sinking speed would pass as a thousandth of what it is.
    """
    s = 1e-300
    approach = 0.0
    for r in range(count):
        row = rows[r]
        a = movers[row.body_a]
        b = movers[row.body_b]
        u = 0.0
        for i in range(len(row.jacobian_a)):
            u += row.jacobian_a[i] * a.start[i] + row.jacobian_b[i] * b.start[i]
        u += row.bias
        if row.hold == HELD_APART:
            u = min(u, 0.0)
            approach = pull * h - u
        elif row.kind == FRICTION:
            u = min(abs(u), row.friction * approach)
        s += (pull * pull * h * h + u * u) * row.effective_mass
        if row.impulse != 0.0:
            apply_impulse(row, a, b, row.impulse)
    return s


@njit
def guard_energy(rows: Any, count: Any, indices: Any, bodies: Any, body_parameters: Any, motions: Any) -> Any:
    """Scale impulses back if an unfinished solve made kinetic energy out of passive contacts.

    The kinetic energy along the impulses, T(s) = |v_free + s dv|^2_M / 2, is least at s*; an exact
    solve has s* >= 1, and s* < 1/2 means T(1) > T(0).  Friction cones contain every scaled impulse.
    """
    slope = 0.0
    curve = 0.0
    for k in range(len(indices)):
        i = indices[k]
        parameters = body_parameters[i]
        for d in range(3):
            m = parameters.mass if d < 2 else parameters.inertia
            free = motions[i].free_velocity[d]
            dv = bodies[i].velocity[d] - free
            slope += m * dv * free
            curve += m * dv * dv
    if curve <= 0.0 or slope <= -0.5 * curve:
        return False
    s = max(-slope / curve, 0.0)
    for r in range(count):
        rows[r].impulse *= s
    for k in range(len(indices)):
        i = indices[k]
        for d in range(3):
            free = motions[i].free_velocity[d]
            bodies[i].velocity[d] = free + s * (bodies[i].velocity[d] - free)
    return True


@njit
def gains_energy(indices: Any, bodies: Any, body_parameters: Any, motions: Any) -> Any:
    """Whether impulses of joints raised the kinetic energy by more than turning about them does."""
    before = 0.0
    gain = 0.0
    for k in range(len(indices)):
        i = indices[k]
        parameters = body_parameters[i]
        for d in range(3):
            m = parameters.mass if d < 2 else parameters.inertia
            free = motions[i].free_velocity[d]
            v = bodies[i].velocity[d]
            before += m * free * free
            gain += m * (v - free) * (v + free)
    return gain > TURNING_GAIN * before


@njit
def drop_curves(rows: Any, end: Any) -> None:
    """Equations at rest: what they then take is a projection, which no kinetic energy survives raised."""
    for r in range(end):
        if rows[r].kind == EQUATION:
            rows[r].bias = 0.0


@njit
def _cone(x: Any, y: Any, mu: Any) -> Any:
    """Nearest point of {|t| <= mu n} to (n, t) = (x, y)."""
    if abs(y) <= mu * x:
        return x, y
    if mu * abs(y) <= -x:
        return 0.0, 0.0
    n = (x + mu * abs(y)) / (1.0 + mu * mu)
    return n, mu * n if y > 0.0 else -mu * n


@njit
def natural_residual(rows: Any, count: Any, contact_first: Any, bodies: Any, motions: Any) -> Any:
    """nm of the island, squared: (sum |e|^2, sum |q/s|^2, sum |s r|^2).

    e = s r - P(s r - w / s) for each bounded row and each contact's cone, with s = sqrt(A_rr)
    (mean of the two rows of a contact) and De Saxce's w_n + mu |w_t| in the normal direction.
    """
    error = 0.0
    load = 0.0
    size = 0.0
    r = 0
    while r < count:
        row = rows[r]
        w, q = _row_velocity(row, bodies, motions)
        if r < contact_first:
            if row.diagonal > 0.0:
                s = row.diagonal**0.5
                x = s * row.impulse
                lo = s * row.lower
                hi = s * row.upper
                e = x - min(max(x - w / s, lo), hi)
                error += e * e
                load += q * q / row.diagonal
                size += x * x
            r += 1
            continue
        if row.span == 1:
            s = row.diagonal**0.5
            e = s * row.impulse - max(s * row.impulse - w / s, 0.0)
            error += e * e
            load += q * q / row.diagonal
            size += row.impulse * row.impulse * row.diagonal
            r += 1
            continue
        tangent = rows[r + 1]
        wt, qt = _row_velocity(tangent, bodies, motions)
        d = 0.5 * (row.diagonal + tangent.diagonal)
        s = d**0.5
        x = s * row.impulse
        y = s * tangent.impulse
        n, t = _cone(x - (w + tangent.friction * abs(wt)) / s, y - wt / s, tangent.friction)
        error += (x - n) * (x - n) + (y - t) * (y - t)
        load += (q * q + qt * qt) / d
        size += x * x + y * y
        r += 2
    return error, load, size


@njit
def _row_velocity(row: Any, bodies: Any, motions: Any) -> Any:
    """(w, q): the row's velocity after and before the impulses."""
    w = row.bias + row.softness * row.impulse
    q = row.bias
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    ma = motions[row.body_a]
    mb = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        w += row.jacobian_a[i] * a.velocity[i] + row.jacobian_b[i] * b.velocity[i]
        q += row.jacobian_a[i] * ma.free_velocity[i] + row.jacobian_b[i] * mb.free_velocity[i]
    return w, q
