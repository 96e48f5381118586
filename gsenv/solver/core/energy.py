"""Measures of the solve of an island: the scale of its residual, the natural-map residual, the energy guard."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..methods.joint_factor import SELF_STRESS
from .coupled import has_half
from .dispatch import by_dimension
from .rows import (
    DISC,
    DISC_END,
    EQUATION,
    FRICTION,
    UNILATERAL,
    apply_impulse,
    apply_impulses,
    free_rate,
    on_disc,
    row_product,
    row_velocities,
)
from .slices import part

cone_span = by_dimension("friction_cone", "cone_span")
cone_residual = by_dimension("friction_cone", "cone_residual")

ROTATION_GAIN = (
    0.02  # of the kinetic energy, gained in one substep: more than what rotating joints add, which is of third order
)
STRICT = 0.75  # least s* of an unfinished solve; nearer to 1, heaps sink: one s scales all impulses of an island


@njit
def apply_warm_start(world: Any, island: Any) -> Any:
    """Apply the impulses that the rows start from, and set ``free``; returns the scale of the squared residual.

    The scale is sum ((g h)^2 + u^2) / A_rr, u = J v + bias before any impulse.  For unilateral rows only the
    approach speed counts, and slip counts up to what friction can stop: otherwise a far limit or a fast slide
    would dominate the sum.  The two tangents of a disc count as one slip.

    The scale is one of velocities, not of impulses: under a mass of 1000 kg the load is 1000 times the gravity
    on the 1 kg box that carries it, and its sinking speed would appear a thousand times too small.
    """
    rows = world.scratch.rows
    solver_bodies = world.scratch.solver_bodies
    gravity_norm = island.gravity_norm
    h = island.h
    s = 1e-300
    approach = 0.0
    slip = 0.0
    for r in range(island.rows):
        row = rows[r]
        a = solver_bodies[row.body_a]
        b = solver_bodies[row.body_b]
        u = row_product(row, a.start, b.start)
        row.free = u
        u += row.bias
        square = u * u
        if row.correction == UNILATERAL:
            if u > 0.0:
                u = square = 0.0
            approach = gravity_norm * h - u
        elif row.kind == FRICTION or row.kind == DISC:
            slip = square
            square = min(square, (row.friction * approach) ** 2)
        elif row.kind == DISC_END:
            square = min(square, max((row.friction * approach) ** 2 - slip, 0.0))
        s += (gravity_norm * gravity_norm * h * h + square) * row.effective_mass
        if row.kind == DISC_END:
            apply_impulses(rows[r - 1], rows[r - 1].impulse, row, row.impulse, a, b)
        elif row.impulse != 0.0 and row.kind != DISC:
            apply_impulse(row, a, b, row.impulse)
    return s


@njit
def guard_energy(world: Any, island: Any, strict: Any) -> Any:
    """Scale impulses back where an unfinished solve of passive contacts increased the kinetic energy.

    The kinetic energy along the impulses, T(s) = |v_free + s dv|^2_M / 2, is least at s*.  s* < 1/2 means
    T(1) > T(0).  An exact solve of contacts alone has s* >= 1, since no impulse does positive work at the new
    velocities; with less, a load at rest would be thrown up, by up to the velocity that gravity gives it in the
    substep.  ``strict``: only s* >= STRICT is accepted.  Not for joints of rotating bodies, which do such work, nor for
    solves that are exact up to the tolerance.  Friction cones contain all scaled impulses.
    Returns whether it scaled any.
    """
    least = STRICT if strict else 0.5
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    slope = 0.0
    curve = 0.0
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            m = substep_bodies[i].mass_matrix[d, d]
            free = substep_bodies[i].free_velocity[d]
            dv = bodies[i].velocity[d] - free
            slope += m * dv * free
            curve += m * dv * dv
    if curve <= 0.0 or slope <= -least * curve:
        return False
    s = max(-slope / curve, 0.0)
    for r in range(island.rows):
        rows[r].impulse *= s
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            free = substep_bodies[i].free_velocity[d]
            bodies[i].velocity[d] = free + s * (bodies[i].velocity[d] - free)
    return True


@njit
def limit_squeeze(world: Any, island: Any) -> None:
    """Limit the velocities where moving kinematic bodies leave the rows of others no solution.

    An unfinished solve of such rows may throw a body at any speed.  Here none becomes faster than the fastest of the
    island before the impulses and the fastest kinematic body together: without restitution, what is hit becomes at most
    as fast as what hits it, but where a wedge squeezes it out, which a finished solve tells.  Nor does it become faster
    than twice the kinematic body, unless it was: in a jam that lasts, speeds would grow in each step.
    """
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    drive = _fastest_kinematic(world, island)
    own = 0.0
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        own = max(own, _speed(substep_bodies[i].free_velocity, body_parameters[i]))
    most = min(own + drive, max(own, 2.0 * drive))
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        velocity = bodies[i].velocity
        speed = _speed(velocity, body_parameters[i])
        if speed > most:
            for d in range(len(velocity)):
                velocity[d] *= most / speed


@njit
def _fastest_kinematic(world: Any, island: Any) -> Any:
    """Return the largest speed of a kinematic body in contact with the island, m/s."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    contacts = world.state.contacts
    island_contacts = part(world.scratch.island_contacts, island.contact_first, island.contact_count)
    fastest = 0.0
    for k in range(len(island_contacts)):
        for side in range(2):
            i = contacts[island_contacts[k]].body_a if side == 0 else contacts[island_contacts[k]].body_b
            if body_parameters[i].inv_mass == 0.0:
                fastest = max(fastest, _speed(bodies[i].velocity, body_parameters[i]))
    return fastest


@njit
def _speed(velocity: Any, parameters: Any) -> Any:
    """Return the speed of a body's centre plus that of its farthest point about it, m/s."""
    linear = 0.0
    angular = 0.0
    for d in range(len(velocity)):
        if d < (len(velocity) + 1) // 2:
            linear += velocity[d] * velocity[d]
        else:
            angular += velocity[d] * velocity[d]
    return linear**0.5 + parameters.radius * angular**0.5


@njit
def gains_energy(world: Any, island: Any) -> Any:
    """Whether impulses of joints increased the kinetic energy by more than rotation about them does."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    before = 0.0
    gain = 0.0
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            m = substep_bodies[i].mass_matrix[d, d]
            free = substep_bodies[i].free_velocity[d]
            v = bodies[i].velocity[d]
            before += m * free * free
            gain += m * (v - free) * (v + free)
    return gain > ROTATION_GAIN * before


@njit
def is_self_stressed(world: Any, island: Any) -> Any:
    """Whether the impulses of rigid joints are so large, for how little all impulses move, that they hold each other.

    Two joints that almost contradict each other have such impulses.  As a warm start they would grow in each step: at
    the next pose they no longer cancel.
    """
    rows = world.scratch.rows
    effort = 0.0
    for r in range(island.joint_rows):
        if rows[r].kind == EQUATION and rows[r].softness == 0.0:
            effort += rows[r].diagonal * rows[r].impulse * rows[r].impulse
    if effort == 0.0:
        return False
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    moved = 0.0
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            dv = bodies[i].velocity[d] - substep_bodies[i].free_velocity[d]
            moved += substep_bodies[i].mass_matrix[d, d] * dv * dv
    return moved < SELF_STRESS * effort


@njit
def clear_equation_biases(rows: Any, end: Any) -> None:
    """Set the biases of equations to 0; their solution is then a projection, which cannot increase the energy."""
    for r in range(end):
        if rows[r].kind == EQUATION:
            rows[r].bias = 0.0


@njit
def set_free_rates_of_rows(world: Any, island: Any) -> None:
    """Set ``free`` of all rows, for ``natural_residual``, where no warm start does."""
    rows = world.scratch.rows
    for r in range(island.rows):
        rows[r].free = free_rate(rows[r], world.scratch.substep_bodies)


@njit
def natural_residual(world: Any, island: Any) -> Any:
    """Return the squared natural-map residual of the island: (sum |e|^2, sum |q/s|^2, sum |s r|^2).

    e = s r - P(s r - w / s) for each bounded row and each contact's cone, with s = sqrt(A_rr) (for a cone
    the mean of its rows), q = w before the impulses, and De Saxce's w_n + mu |w_t| in the normal direction.
    Bounds and cones scale, so e = s (r - P(r - w / s^2)), which needs no root.
    """
    rows = world.scratch.rows
    bodies = world.state.bodies
    error = 0.0
    load = 0.0
    size = 0.0
    normal = 0.0
    r = 0
    while r < island.rows:
        row = rows[r]
        count = 1
        if r >= island.joint_rows and row.correction == UNILATERAL:
            normal = row.impulse
            count = cone_span(rows, r)
            if count > 1:
                e, q, s = cone_residual(rows, r, bodies)
            else:
                e, q, s = _row_residual(row, 0.0, row.upper, bodies)
        elif row.kind == FRICTION:
            bound = row.friction * normal
            e, q, s = _row_residual(row, -bound, bound, bodies)
        elif row.kind == DISC:
            e, q, s = _disc_residual(rows, r, row.friction * normal, bodies)
            count = 2
        elif has_half(rows, r, island.joint_rows):
            e, q, s = _coupled_residual(rows, r, bodies)
            count = 2
        else:
            e, q, s = _row_residual(row, row.lower, row.upper, bodies)
        error += e
        load += q
        size += s
        r += count
    return error, load, size


@njit
def _row_residual(row: Any, lower: Any, upper: Any, bodies: Any) -> Any:
    if row.diagonal <= 0.0:
        return 0.0, 0.0, 0.0
    w, q = row_velocities(row, bodies)
    a = row.diagonal
    mass = 1.0 / a
    e = row.impulse - min(max(row.impulse - mass * w, lower), upper)
    return a * e * e, mass * q * q, a * row.impulse * row.impulse


@njit
def _coupled_residual(rows: Any, r: Any, bodies: Any) -> Any:
    """As ``_row_residual`` of an equation in two halves."""
    if rows[r].diagonal <= 0.0:
        return 0.0, 0.0, 0.0
    w, q = row_velocities(rows[r], bodies)
    u, p = row_velocities(rows[r + 1], bodies)
    size = rows[r].diagonal
    return (w + u) ** 2 / size, (q + p) ** 2 / size, size * rows[r].impulse ** 2


@njit
def _disc_residual(rows: Any, r: Any, bound: Any, bodies: Any) -> Any:
    w, q = row_velocities(rows[r], bodies)
    u, p = row_velocities(rows[r + 1], bodies)
    d = 0.5 * (rows[r].diagonal + rows[r + 1].diagonal)
    if d <= 0.0:
        return 0.0, 0.0, 0.0
    mass = 1.0 / d
    x = rows[r].impulse
    y = rows[r + 1].impulse
    px, py = on_disc(x - mass * w, y - mass * u, bound)
    return d * ((x - px) ** 2 + (y - py) ** 2), mass * (q * q + p * p), d * (x * x + y * y)
