"""What the solve of an island did: impulse scale, natural-map residual, and the energy guard."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import DISC, DISC_END, EQUATION, FRICTION, HELD_APART, apply_impulse, on_disc

TURNING_GAIN = 0.02  # of the kinetic energy in a substep: second order, third in the angle of the turn


@njit
def start_impulses(rows: Any, count: Any, movers: Any, pull: Any, h: Any) -> Any:
    """Bring the velocities in line with the impulses that the rows start from; what changes are compared with.

    See planar/energy.py; the two tangents of a disc count as one slip.
    """
    s = 1e-300
    approach = 0.0
    slip = 0.0
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
        elif row.kind == DISC:
            slip = u
            u = min(abs(u), row.friction * approach)
        elif row.kind == DISC_END:
            left = (row.friction * approach) ** 2 - slip * slip
            u = min(abs(u), max(left, 0.0) ** 0.5)
        s += (pull * pull * h * h + u * u) * row.effective_mass
        if row.impulse != 0.0:
            apply_impulse(row, a, b, row.impulse)
    return s


@njit
def guard_energy(rows: Any, count: Any, indices: Any, bodies: Any, motions: Any) -> Any:
    """Scale impulses back if an unfinished solve made kinetic energy out of passive contacts.

    The kinetic energy along the impulses, T(s) = |v_free + s dv|^2_M / 2, is least at s*; an exact
    solve has s* >= 1, and s* < 1/2 means T(1) > T(0).  Friction cones contain every scaled impulse.
    """
    slope = 0.0
    curve = 0.0
    for k in range(len(indices)):
        i = indices[k]
        for d in range(6):
            m = motions[i].mass_matrix[d, d]
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
        for d in range(6):
            free = motions[i].free_velocity[d]
            bodies[i].velocity[d] = free + s * (bodies[i].velocity[d] - free)
    return True


@njit
def gains_energy(indices: Any, bodies: Any, motions: Any) -> Any:
    """Whether impulses of joints raised the kinetic energy by more than turning about them does."""
    before = 0.0
    gain = 0.0
    for k in range(len(indices)):
        i = indices[k]
        for d in range(6):
            m = motions[i].mass_matrix[d, d]
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
def natural_residual(rows: Any, count: Any, contact_first: Any, bodies: Any, motions: Any) -> Any:
    """nm of the island, squared: (sum |e|^2, sum |q/s|^2, sum |s r|^2).

    e = s r - P(s r - w / s) for each bounded row and each contact's cone, with s = sqrt(A_rr) (mean of
    the rows of a cone) and De Saxce's w_n + mu |w_t| in the normal direction.
    """
    error = 0.0
    load = 0.0
    size = 0.0
    r = 0
    normal = 0.0
    while r < count:
        row = rows[r]
        if r >= contact_first and row.hold == HELD_APART:
            normal = row.impulse
            if row.span > 1 and rows[r + 1].kind == DISC:
                e, q, s = _cone_residual(rows, r, bodies, motions)
                r += 3
            else:
                e, q, s = _row_residual(row, 0.0, row.upper, bodies, motions)
                r += 1
        elif row.kind == FRICTION:
            bound = row.friction * normal
            e, q, s = _row_residual(row, -bound, bound, bodies, motions)
            r += 1
        elif row.kind == DISC:
            e, q, s = _disc_residual(rows, r, row.friction * normal, bodies, motions)
            r += 2
        else:
            e, q, s = _row_residual(row, row.lower, row.upper, bodies, motions)
            r += 1
        error += e
        load += q
        size += s
    return error, load, size


@njit
def _row_residual(row: Any, lower: Any, upper: Any, bodies: Any, motions: Any) -> Any:
    if row.diagonal <= 0.0:
        return 0.0, 0.0, 0.0
    w, q = _row_velocity(row, bodies, motions)
    s = row.diagonal**0.5
    x = s * row.impulse
    e = x - min(max(x - w / s, s * lower), s * upper)
    return e * e, q * q / row.diagonal, x * x


@njit
def _disc_residual(rows: Any, r: Any, bound: Any, bodies: Any, motions: Any) -> Any:
    w, q = _row_velocity(rows[r], bodies, motions)
    u, p = _row_velocity(rows[r + 1], bodies, motions)
    d = 0.5 * (rows[r].diagonal + rows[r + 1].diagonal)
    if d <= 0.0:
        return 0.0, 0.0, 0.0
    s = d**0.5
    x = s * rows[r].impulse
    y = s * rows[r + 1].impulse
    px, py = on_disc(x - w / s, y - u / s, s * bound)
    return (x - px) ** 2 + (y - py) ** 2, (q * q + p * p) / d, x * x + y * y


@njit
def _cone_residual(rows: Any, r: Any, bodies: Any, motions: Any) -> Any:
    w, q = _row_velocity(rows[r], bodies, motions)
    u, p = _row_velocity(rows[r + 1], bodies, motions)
    v, o = _row_velocity(rows[r + 2], bodies, motions)
    d = (rows[r].diagonal + rows[r + 1].diagonal + rows[r + 2].diagonal) / 3.0
    mu = rows[r + 1].friction
    s = d**0.5
    x = s * rows[r].impulse
    y = s * rows[r + 1].impulse
    z = s * rows[r + 2].impulse
    n, t1, t2 = _cone(x - (w + mu * (u * u + v * v) ** 0.5) / s, y - u / s, z - v / s, mu)
    error = (x - n) ** 2 + (y - t1) ** 2 + (z - t2) ** 2
    return error, (q * q + p * p + o * o) / d, x * x + y * y + z * z


@njit
def _cone(x: Any, y: Any, z: Any, mu: Any) -> Any:
    """Nearest point of {|t| <= mu n} to (n, t) = (x, (y, z))."""
    t = (y * y + z * z) ** 0.5
    if t <= mu * x:
        return x, y, z
    if mu * t <= -x:
        return 0.0, 0.0, 0.0
    n = (x + mu * t) / (1.0 + mu * mu)
    return n, mu * n * y / t, mu * n * z / t


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
