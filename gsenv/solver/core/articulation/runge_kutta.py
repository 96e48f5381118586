"""Runge-Kutta steps of fourth order for trees that swing from a fixed body and touch nothing.

The classical method with the acceleration at its end as a fifth stage: with the last weight moved from the fourth
stage to the fifth it is of third order, and the difference estimates the error, by which the length of the steps is
chosen.  The fifth stage is the first of the next step.  Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, 1993, sections II.4 and II.5.  The path of a degree of freedom is counted from the start of the step; the
path of a pivot is the vector of the link's rotation, whose rate is not the spin (see ``spatial/pivot_paths.py``).
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..dispatch import by_dimension
from .dynamics import factorise_links, kinetic_energy, respond, set_inertias
from .links import move_links, set_base
from .reactions import add_impulses, keep_momenta, store_reactions
from .servos import keep_coordinates, list_servos
from .tension import damp_joints


@njit
def _same(links: Any, k: Any, path: Any, out: Any) -> None:
    """Do nothing: where the rate of a path is the rate of the degree of freedom."""


place_link = by_dimension("articulation", "place_link")
leave_link = by_dimension("articulation", "leave_link")
set_applied = by_dimension("articulation", "set_applied")
set_force = by_dimension("articulation", "set_force")
set_pivot_slope = by_dimension("pivot_paths", "set_pivot_slope", otherwise=_same)
set_pivot_step = by_dimension("pivot_paths", "set_pivot_step", otherwise=_same)

ERROR = 2.0  # of the tolerance: largest error of the speeds in a step, relative to the speeds
FIRST_TURN = 0.5  # rad: largest rotation in the first step that is tried
FIRST_SWING = 2.0  # rad: largest swing of a taut link in the same
MOST_DAMPING = 0.5  # of the timestep: decay that is resolved
HALVINGS = 1024.0  # shortest step: a substep over this
WRONG = 0.1  # relative error of the speeds from which on even the shortest step is refused,
STIFF = 1e9  # and the joints are damped by this times the inertia of their links
LEAST_FACTOR, MOST_FACTOR = 0.2, 2.0  # of the length of one step to the next
SAFETY = 0.9


@njit
def swings(world: Any, island: Any, joints: Any, articulation: Any) -> Any:
    """Whether the island is a tree on a fixed body on which no row and no spring may act."""
    links = articulation.links
    body_parameters = world.parameters.bodies
    dt = world.options.timestep
    if island.contact_count > 0 or island.other_rows > 0 or links[0].joint < 0:
        return False
    if list_servos(world, island, articulation, joints) > 0 or island.servos != 0:
        return False
    for k in range(island.body_count):
        parameters = body_parameters[links[k].body]
        if links[k].tree != 0:
            return False
        if dt * max(parameters.linear_damping, parameters.angular_damping) > MOST_DAMPING:
            return False
    return True


@njit
def swing(world: Any, island: Any, joints: Any, articulation: Any) -> Any:
    """Advance the island by one timestep in steps whose error is small; returns the rest of it in s.

    There is a rest where even the shortest step gives speeds that mean nothing; the links are at its start then, and
    move as one rigid body.
    """
    whole = world.options.timestep / world.options.substeps
    left = world.options.timestep
    size = min(FIRST_TURN / max(island.spin, 1e-12), FIRST_SWING / max(island.swing, 1e-12) ** 0.5)
    add_impulses(world, island, articulation, 0)
    _enter_step(world, island, joints, articulation)
    _accelerate(world, island, articulation, articulation.start, articulation.start_acceleration)
    island.kinetic = kinetic_energy(articulation.links, island.body_count, articulation.freedoms, articulation.start)
    shortest = whole / HALVINGS
    while left > 0.0:
        size = min(size, whole) if size > shortest else shortest  # also of NaN: the loop must end
        if size > 0.999 * left:
            size = left
        elif size > 0.5 * left:
            size = 0.5 * left
        _try(world, island, articulation, size)
        wrong, energy = _error(world, island, articulation, size)
        error = wrong / (ERROR * world.options.tolerance)
        if error <= 1.0 or not size > 1.01 * shortest:  # the rest may stretch a step by 0.1 %
            if not error <= 1.0:
                world.state.world.unconverged += 1
                if not wrong <= WRONG:
                    _calm(world, island, joints, articulation)
                    return left
            _limit_gain(world, island, articulation, energy)
            _accept(world, island, joints, articulation, size)
            left = left - size if size < left else 0.0
            if left > 0.0:
                _enter_step(world, island, joints, articulation)
        size *= _factor(error)
    return left


@njit
def _calm(world: Any, island: Any, joints: Any, articulation: Any) -> None:
    """Return the links to where the last step ended, and stop all motion of the joints but that of the tree as a whole.

    One implicit step of a strong damping of all joints, whose impulses are inner ones: what is heavy keeps its motion.
    """
    links = articulation.links
    freedoms = articulation.freedoms
    start = articulation.start
    change = articulation.change
    for f in range(island.freedoms):
        articulation.path[f] = 0.0
    _place(world, island, articulation)
    move_links(island, articulation, start)
    island.h = 0.0
    set_inertias(world, island, articulation)
    damp_joints(world, island, articulation, STIFF)
    factorise_links(links, island.body_count, freedoms)
    for f in range(island.freedoms):
        change[f] = -freedoms[f].stiffness * start[f]
        freedoms[f].stiffness = 0.0
    for k in range(island.body_count):
        for d in range(len(links[k].force)):
            links[k].force[d] = 0.0
    respond(links, island.body_count, freedoms, change)
    for f in range(island.freedoms):
        start[f] += change[f]
    move_links(island, articulation, start)
    island.stored_scale = 0.0
    store_reactions(world, island, articulation, joints)


@njit
def _factor(error: Any) -> Any:
    """Return the factor from the length of a step to that of the next, by its error over the largest one."""
    if not error < 1e6:
        return LEAST_FACTOR
    return min(max(SAFETY / max(error, 1e-6) ** 0.25, LEAST_FACTOR), MOST_FACTOR)


@njit
def _enter_step(world: Any, island: Any, joints: Any, articulation: Any) -> None:
    """Keep poses and momenta at the start of a step, and set the slopes there; the rates are ``start``."""
    links = articulation.links
    energy = island.kinetic
    island.h = 0.0
    move_links(island, articulation, articulation.start)
    keep_momenta(world, island, articulation)
    island.kinetic = energy
    keep_coordinates(world, island, articulation, joints)
    for k in range(island.body_count):
        for d in range(len(links[k].pin)):
            links[k].start_pin[d] = links[k].pin[d]
    for f in range(island.freedoms):
        articulation.path[f] = 0.0
    _set_slope(island, articulation, articulation.start, articulation.start_slope)


@njit
def _try(world: Any, island: Any, articulation: Any, size: Any) -> None:
    """Take a step of ``size`` s from the base; leaves the fourth stage's acceleration in ``free``, the fifth's in
    ``change``.
    """
    path, slope = articulation.path, articulation.slope
    rate, change = articulation.rate, articulation.change
    start = articulation.start
    count = island.freedoms
    for f in range(count):
        slope[f] = articulation.start_slope[f]
        change[f] = articulation.start_acceleration[f]
        articulation.path_sum[f] = slope[f]
        articulation.rate_sum[f] = change[f]
    for stage in range(3):
        ahead = size if stage == 2 else 0.5 * size
        weight = 1.0 if stage == 2 else 2.0
        for f in range(count):
            path[f] = ahead * slope[f]
            rate[f] = start[f] + ahead * change[f]
        _place(world, island, articulation)
        move_links(island, articulation, rate)
        _set_slope(island, articulation, rate, slope)
        _accelerate(world, island, articulation, rate, change)
        for f in range(count):
            articulation.path_sum[f] += weight * slope[f]
            articulation.rate_sum[f] += weight * change[f]
    for f in range(count):
        path[f] = size / 6.0 * articulation.path_sum[f]
        rate[f] = start[f] + size / 6.0 * articulation.rate_sum[f]
        articulation.free[f] = change[f]
    _place(world, island, articulation)
    move_links(island, articulation, rate)
    _accelerate(world, island, articulation, rate, change)


@njit
def _place(world: Any, island: Any, articulation: Any) -> None:
    """Place all links by their paths."""
    links = articulation.links
    path = articulation.path
    step = articulation.step
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    joint_parameters = world.parameters.joints
    for f in range(island.freedoms):
        step[f] = path[f]
    for k in range(island.body_count):
        set_pivot_step(links, k, path, step)
        place_link(links, k, step, bodies, body_parameters, joint_parameters[links[k].joint])


@njit
def _set_slope(island: Any, articulation: Any, rate: Any, slope: Any) -> None:
    """Set the rates at which the paths grow."""
    links = articulation.links
    for f in range(island.freedoms):
        slope[f] = rate[f]
    for k in range(island.body_count):
        set_pivot_slope(links, k, articulation.path, slope)


@njit
def _accelerate(world: Any, island: Any, articulation: Any, rate: Any, change: Any) -> None:
    """Set the accelerations of the rates at the present pose and velocities."""
    links = articulation.links
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    island.h = 0.0  # no implicit damping
    set_inertias(world, island, articulation)
    factorise_links(links, island.body_count, articulation.freedoms)
    for f in range(island.freedoms):
        change[f] = 0.0
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        set_applied(link, bodies[link.body], parameters, gravity)
        set_force(links, k, rate, parameters.mass, 1.0)
    respond(links, island.body_count, articulation.freedoms, change)


@njit
def _error(world: Any, island: Any, articulation: Any, size: Any) -> Any:
    """Return the error of the speeds over the speeds, or what gravity adds to them in a substep, in the norm of the
    kinetic energy, and twice that energy at the end of the step.
    """
    links = articulation.links
    freedoms = articulation.freedoms
    difference = articulation.free
    count = island.body_count
    whole = world.options.timestep / world.options.substeps
    for f in range(island.freedoms):
        difference[f] = size / 6.0 * (difference[f] - articulation.change[f])
    wrong = kinetic_energy(links, count, freedoms, difference)
    energy = kinetic_energy(links, count, freedoms, articulation.rate)
    least = 0.0
    gravity = world.parameters.world.gravity
    for d in range(len(gravity)):
        least += (whole * gravity[d]) ** 2
    mass = 0.0
    for k in range(count):
        mass += world.parameters.bodies[links[k].body].mass
    return ((wrong / max(energy, mass * least)) ** 0.5 if wrong > 0.0 else wrong), energy


@njit
def _accept(world: Any, island: Any, joints: Any, articulation: Any, size: Any) -> None:
    """Make the end of the step the base of the next, and store poses and reactions."""
    links = articulation.links
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        for d in range(len(links[k].half)):
            links[k].half[d] = 0.0
    for k in range(island.body_count):
        set_base(links[k])
        leave_link(links[k], bodies[links[k].body], substep_bodies[links[k].body])
    _set_middle_arms(world, island, articulation, size)
    island.h = size
    island.stored_scale = world.options.timestep / (world.options.substeps * size)
    store_reactions(world, island, articulation, joints)
    for f in range(island.freedoms):
        articulation.start[f] = articulation.rate[f]
        articulation.start_acceleration[f] = articulation.change[f]


@njit
def _set_middle_arms(world: Any, island: Any, articulation: Any, size: Any) -> None:
    """Set centres and anchors to their mean over the step, and add what forces have added to the momenta."""
    links = articulation.links
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    for k in range(island.body_count):
        link = links[k]
        root = links[link.tree]
        weight = body_parameters[link.body].mass * body_parameters[link.body].gravity_scale
        for d in range(len(gravity)):
            origin = root.start[d] + root.position[d]
            link.center[d] = 0.5 * (link.start[d] + link.position[d] - origin)
            link.anchor[d] = 0.5 * (link.start_pin[d] + link.pin[d] - origin)
            link.push[d] += size * weight * gravity[d]
        for d in range(len(link.push)):
            link.push[d] += size * bodies[link.body].force[d]


@njit
def _limit_gain(world: Any, island: Any, articulation: Any, energy: Any) -> None:
    """Slow the links down to where forces have done the work: an error of the step must not add energy.

    ``energy``: twice their kinetic energy.
    """
    links = articulation.links
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    rate = articulation.rate
    allowed = island.kinetic
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        force = bodies[link.body].force
        weight = parameters.mass * parameters.gravity_scale
        for d in range(len(gravity)):
            allowed += 2.0 * (weight * gravity[d] + force[d]) * (link.position[d] - link.start[d])
        for d in range(len(link.turn)):
            allowed += 2.0 * force[len(gravity) + d] * link.turn[d]
    island.kinetic = energy
    if island.kinetic > allowed:
        scale = (max(allowed, 0.0) / island.kinetic) ** 0.5
        island.kinetic = max(allowed, 0.0)
        for f in range(island.freedoms):
            rate[f] *= scale
        move_links(island, articulation, rate)
