"""Springs and dampers as rows, at any stiffness."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..methods.cholesky import add_force, clear_sides, substitute
from ..methods.joint_factor import compliance, solve_equations
from .rows import (
    BOUNDED,
    EQUATION,
    NO_CORRECTION,
    add_response,
    free_rate,
    relative_velocity,
    row_product,
    start_rate,
)
from .slices import part
from .trig import exp_minus, sin_cos

_TWO_PI = 6.283185307179586
_NEARLY_FREE = 1.0 - 1e-9  # c of a spring too weak for the substep, which would divide by 0
EXACT = 0.8  # rad in a substep: slower springs are integrated exactly, faster ones by implicit Euler


@njit
def has_spring(parameters: Any) -> Any:
    """Whether a joint has a spring or a damper."""
    return parameters.frequency > 0.0 or parameters.stiffness > 0.0 or parameters.damping > 0.0


@njit
def stored_energy(parameters: Any, stretch: Any, inverse_mass: Any) -> Any:
    """Return the energy of a spring in J, whose force is bounded by ``spring_effort``.

    ``stretch``: m or rad; ``inverse_mass``: 1/kg or 1/(kg m^2), on which a given frequency is that of the spring.
    """
    if inverse_mass <= 0.0:
        return 0.0
    stiffness = parameters.stiffness
    if not stiffness > 0.0:
        stiffness = (_TWO_PI * parameters.frequency) ** 2 / inverse_mass
    effort = min(stiffness * abs(stretch), parameters.spring_effort)
    return effort * (abs(stretch) - 0.5 * effort / stiffness) if stiffness > 0.0 else 0.0


@njit
def beyond_limit(parameters: Any, coordinate: Any) -> Any:
    """Return by how much a coordinate is beyond a rigid limit, m or rad; soft limits may be passed."""
    if parameters.limit_frequency > 0.0:
        return 0.0
    return max(parameters.lower - coordinate, coordinate - parameters.upper, 0.0)


@njit
def limit_energy(parameters: Any, coordinate: Any, inverse_mass: Any) -> Any:
    """Return the energy in J of a soft limit; ``inverse_mass`` as for ``stored_energy``."""
    beyond = max(parameters.lower - coordinate, coordinate - parameters.upper)
    if beyond <= 0.0 or inverse_mass <= 0.0 or parameters.limit_frequency <= 0.0:
        return 0.0
    return 0.5 * (_TWO_PI * parameters.limit_frequency * beyond) ** 2 / inverse_mass


@njit
def distance_reading(parameters: Any, apart: Any, give: Any) -> Any:
    """(error m, energy J) of a distance joint whose anchors are ``apart`` m; ``give`` as for ``stored_energy``."""
    beyond = max(parameters.lower - apart, apart - parameters.upper)
    stretch = apart - parameters.length
    if parameters.rigid != 0:
        return max(abs(stretch), beyond), 0.0
    energy = 0.0
    if parameters.frequency > 0.0 or parameters.stiffness > 0.0:
        energy = stored_energy(parameters, stretch, give)
    return beyond, energy


@njit
def set_spring(row: Any, parameters: Any, give: Any, speed: Any, substep_bodies: Any, h: Any) -> None:
    """Make a rigid row the spring and damper of a joint; see ``set_oscillator``.

    ``give``: 1/kg or 1/(kg m^2), the inverse mass on which a given frequency is that of the spring; 0: the row's own.
    """
    m = row.diagonal
    omega = _TWO_PI * parameters.frequency
    share = m / give if give > 0.0 else 1.0
    square = omega * omega * share
    rate = parameters.damping_ratio * omega * share
    if parameters.stiffness > 0.0 or parameters.damping > 0.0:
        square = parameters.stiffness * m
        rate = 0.5 * parameters.damping * m
    set_oscillator(row, square, rate, speed, substep_bodies, h)


@njit
def is_slow(stiffness: Any, damping: Any, inverse_mass: Any, h: Any) -> Any:
    """Whether a spring and damper can act at the mean position and speed of a substep."""
    return h * h * stiffness * inverse_mass < EXACT * EXACT and 0.5 * h * damping * inverse_mass < EXACT


@njit
def mean_reach(stiffness: Any, damping: Any, h: Any) -> Any:
    """Return the force in N or N m that one at the mean of a substep has per m/s or rad/s of the new rate."""
    return 0.25 * h * stiffness + 0.5 * damping


@njit
def set_rotor_spring(row: Any, parameters: Any, give: Any, substep_bodies: Any, h: Any) -> None:
    """Make a rigid row the spring and damper of a joint with armature, solved with the rigid joints.

    Slow ones act at the mean position and speed of the substep, fast ones at its end (``set_oscillator``).  Sweeps
    would converge slowly, since the row does not contain the rotor's inertia.
    """
    row.kind = EQUATION
    row.correction = NO_CORRECTION
    if row.diagonal <= 0.0:
        return
    m = row.diagonal / (1.0 + row.diagonal * parameters.armature)
    stiffness = parameters.stiffness
    damping = parameters.damping
    if not (stiffness > 0.0 or damping > 0.0):
        omega = _TWO_PI * parameters.frequency
        inertia = 1.0 / (give if give > 0.0 else row.diagonal) + parameters.armature
        stiffness = omega * omega * inertia
        damping = 2.0 * parameters.damping_ratio * omega * inertia
    slow = is_slow(stiffness, damping, m, h)
    reach = mean_reach(stiffness, damping, h) if slow else h * stiffness + damping
    row.softness = 1.0 / (h * reach)
    row.bias += stiffness / reach * row.error
    if slow:
        row.bias += start_rate(row, substep_bodies)


@njit
def set_oscillator(row: Any, square: Any, rate: Any, speed: Any, substep_bodies: Any, h: Any) -> None:
    """Set kind, bias and softness of a spring and damper on the error of a rigid row, not its effective mass.

    ``square`` = w^2 in 1/s^2, ``rate`` = d in 1/s; ``speed``: that of the rest point; ``row.bias`` on entry: the
    change of J v from the pose of the row to the end of the substep. x'' = -2 d x' - w^2 x + g on the effective
    mass of the row, m = 1/A_rr. For slow springs the discrete map of (x, v), x1 = x0 + h (v0 + v1)/2, v1 = a x0 + b
    v0 + c (v_free - v0), has the trace and determinant of the exact flow, so frequency and decay are exact, and c =
    -a/(w^2 h) makes the static deflection exact. As a row: softness = gamma A_rr with gamma = c/(1 - c), bias =
    (gamma - (1 + gamma) b) v0 - (1 + gamma) a x0. Fast springs are implicit Euler steps: k = m w^2, softness = 1/(h
    (damping + h k)) (Catto, "Soft constraints", GDC 2011), which damps oscillations that the step does not resolve.
    Sweeps converge on them as slowly as on rigid rows, so the joint factor solves them.
    """
    row.kind = BOUNDED
    row.correction = NO_CORRECTION
    m = row.diagonal
    if m <= 0.0:
        return
    if square <= 0.0 and rate <= 0.0:
        return
    x = row.error
    if h * h * square < EXACT * EXACT and h * rate < EXACT:
        a, b, c = _exact_step(square, rate, h)
        c = min(c, _NEARLY_FREE)
        gamma = c / (1.0 - c)
        row.bias *= (1.0 + gamma) * (1.0 + b) - 2.0 * gamma
        row.bias += (gamma - (1.0 + gamma) * b) * (start_rate(row, substep_bodies) - speed) - (1.0 + gamma) * a * x
        row.softness = gamma * m
    else:
        implicit = 2.0 * rate + h * square
        row.kind = EQUATION
        row.bias += square / implicit * x
        row.softness = m / (h * implicit)
    row.bias -= speed


@njit
def _exact_step(square: Any, rate: Any, h: Any) -> Any:
    """Return (a, b, c) of ``set_spring``."""
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
def release_springs(rows: Any, end: Any, rotor_slot: Any) -> None:
    """Exclude stiff springs from the factor of an impact, which takes no time; the inertia of rotors stays in it.

    The bias of a rotor's row is set to 0, so that it asks for no acceleration.
    """
    for r in range(end):
        if rows[r].softness > 0.0 and rows[r].kind == EQUATION:
            if rows[r].slot == rotor_slot:
                rows[r].bias = 0.0
            else:
                rows[r].kind = BOUNDED


@njit
def any_sprung(island_joints: Any, joint_parameters: Any) -> Any:
    """Whether a joint may give back stored energy, of a spring or a rotor."""
    for k in range(len(island_joints)):
        parameters = joint_parameters[island_joints[k]]
        if has_spring(parameters) or parameters.limit_frequency > 0.0 or parameters.armature > 0.0:
            return True
    return False


@njit
def guard_springs(world: Any, island: Any, joint_factor: Any) -> None:
    """Reduce the impulses of contacts where an unfinished solve increased the energy, that of stiff springs included.

    Without contacts the direct solve of the joints cannot gain energy, since implicit steps lose it.  With dv the
    change of its solution by the contacts, v - t dv is the solution for 1 - t of their impulses, and the energy is
    a parabola in t.
    """
    rows = world.scratch.rows
    bodies = world.state.bodies
    plan = joint_factor.plan
    if plan.size > 0:
        solve_equations(rows, plan.row_end, bodies, plan.size, joint_factor.entries, joint_factor.blocks, 0.0, None)
    gain = _energy_gain(world, island)
    if gain <= 0.0:
        return
    _respond_to_contacts(world, island, joint_factor)
    slope, curve = _energy_slopes(world, island)
    if slope <= 0.0 or curve <= 0.0:
        return
    inside = slope * slope - 2.0 * gain * curve
    t = min((slope - inside**0.5) / curve if inside > 0.0 else slope / curve, 1.0)
    _reduce_contacts(world, island, t)


@njit
def _reduce_contacts(world: Any, island: Any, t: Any) -> None:
    """Remove the fraction ``t`` of the impulses of contacts and limits, and the response of the joints to it."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    solver_bodies = world.scratch.solver_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for r in range(island.rows):
        row = rows[r]
        if row.kind == EQUATION:
            row.impulse += t * _rate_of(row, solver_bodies) / compliance(row) if row.diagonal > 0.0 else 0.0
        elif r >= island.joint_rows or row.correction != NO_CORRECTION:
            row.impulse *= 1.0 - t
    for k in range(len(island_bodies)):
        velocity = bodies[island_bodies[k]].velocity
        for i in range(len(velocity)):
            velocity[i] -= t * solver_bodies[island_bodies[k]].direction[i]


@njit
def _energy_slopes(world: Any, island: Any) -> Any:
    """Return the first and second derivative of the energy along the change of the velocities by contacts."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    solver_bodies = world.scratch.solver_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    slope = 0.0
    curve = 0.0
    for k in range(len(island_bodies)):
        m = substep_bodies[island_bodies[k]].mass_matrix
        change = solver_bodies[island_bodies[k]].direction
        for i in range(len(change)):
            for j in range(len(change)):
                slope += m[i, j] * change[i] * bodies[island_bodies[k]].velocity[j]
                curve += m[i, j] * change[i] * change[j]
    for r in range(island.joint_rows):
        row = rows[r]
        if row.kind == EQUATION and row.softness > 0.0:
            d = _rate_of(row, solver_bodies)
            slope += d * (relative_velocity(row, bodies[row.body_a], bodies[row.body_b]) + row.bias) / row.softness
            curve += d * d / row.softness
    return slope, curve


@njit
def _energy_gain(world: Any, island: Any) -> Any:
    """Return the energy in J that the solve added; half of the dissipation of dampers is not counted."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    gain = 0.0
    for k in range(len(island_bodies)):
        substep_body = substep_bodies[island_bodies[k]]
        v = bodies[island_bodies[k]].velocity
        free = substep_body.free_velocity
        for i in range(len(v)):
            for j in range(len(v)):
                gain += 0.5 * substep_body.mass_matrix[i, j] * (v[i] * v[j] - free[i] * free[j])
    for r in range(island.joint_rows):
        row = rows[r]
        if row.softness <= 0.0:
            continue
        rate = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
        if row.kind == EQUATION:
            gain += (0.5 * rate + row.bias) * rate / row.softness
        elif row.correction == NO_CORRECTION:  # a slow spring: its work
            gain -= 0.5 * row.impulse * (rate + free_rate(row, substep_bodies))
    return gain


@njit
def _respond_to_contacts(world: Any, island: Any, joint_factor: Any) -> None:
    """Set ``direction`` of the solver bodies: the change by contacts and limits, with the response of the joints."""
    rows = world.scratch.rows
    solver_bodies = world.scratch.solver_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    entries = joint_factor.entries
    size = joint_factor.plan.size
    clear_sides(size, entries)
    for k in range(len(island_bodies)):
        for i in range(len(solver_bodies[island_bodies[k]].direction)):
            solver_bodies[island_bodies[k]].direction[i] = 0.0
    for r in range(island.rows):
        row = rows[r]
        counts = r >= island.joint_rows or row.correction != NO_CORRECTION
        if row.impulse != 0.0 and row.kind != EQUATION and counts:
            add_force(row, entries, row.impulse)
            a = solver_bodies[row.body_a]  # the response of bodies without joints
            b = solver_bodies[row.body_b]
            add_response(row, row.impulse, a.direction, a.inverse, b.direction, b.inverse)
    substitute(size, entries, joint_factor.blocks)
    for p in range(size):
        for i in range(len(entries[p].x)):
            solver_bodies[entries[p].order].direction[i] = entries[p].x[i]


@njit
def _rate_of(row: Any, solver_bodies: Any) -> Any:
    """Return J dv of a row."""
    return row_product(row, solver_bodies[row.body_a].direction, solver_bodies[row.body_b].direction)
