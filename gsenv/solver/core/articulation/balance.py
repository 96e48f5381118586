"""The balance of momentum of a substep: rates at its end that conserve momentum and energy where nothing acts."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import LinkKind
from ..dispatch import by_dimension
from .dynamics import respond
from .energy import UNEVEN_TURN, keep_energy
from .links import move_links, place_links
from .reactions import add_corrections

keep_momentum = by_dimension("articulation", "keep_momentum")
carry = by_dimension("articulation", "carry")
resist = by_dimension("tension", "resist")

_FREE = int(LinkKind.FREE)
MOST_ITERATIONS = 25  # of the balance of momentum
ENOUGH = 1e-8  # the same after the most iterations
RELAXED = 0.6  # factor of the corrections where taut links would make them oscillate
LEAST_RELAXED = 0.2
SETTLED = 1e-16  # of the kinetic energy: largest energy of the last correction of the rates
LOOSE = 1e-12  # the same at most where forces do work,
TRUNCATED = 0.1  # and of the cube of the turn in the substep, the method's own error of the rates
SLOWEST = 0.25  # ratio of the energies of two corrections above which they are relaxed


@njit
def settle_rates(world: Any, island: Any, articulation: Any) -> Any:
    """Balance the momenta of a substep without rows; returns whether the corrections converged."""
    settled = _settle(world, island, articulation)
    if settled:
        _restore_paths(world, island, articulation, 0.5, False)
    return settled


@njit
def _settle(world: Any, island: Any, articulation: Any) -> Any:
    """Correct the rates of a substep without rows until the momentum at its end is the one that it must be.

    The momenta of all bodies and rotors at the end pose, less those at the start and what forces add, do no work on
    the motions of the joints half a substep ahead.  This is symmetric in time and keeps the momentum of free trees
    and, without drift, the energy; forces at the mean of old and new rates alone change the energy of fast chains.
    Fast links that nothing drives or damps keep the energy exactly (energy.py).
    Places the links at the end of the substep; returns whether the corrections converged: whether the last is small
    enough, or the next would be at the rate at which they shrink.
    """
    freedoms = articulation.freedoms
    rate = articulation.rate
    change = articulation.change
    count = island.body_count
    best = articulation.before
    least = 0.0
    last = 0.0
    relaxed = 1.0
    settled = SETTLED
    if island.driven or island.has_springs:
        settled = min(max(settled, (TRUNCATED * island.turning**3) ** 2), LOOSE)
    for f in range(island.freedoms):
        rate[f] = articulation.free[f]
    for k in range(MOST_ITERATIONS):
        _end_at_rates(world, island, articulation)
        energy = set_imbalance(world, island, articulation, False)
        energy += set_joint_imbalance(island, articulation)
        error = respond(articulation.links, count, freedoms, change)
        if error <= (settled if k < MOST_ITERATIONS - 1 else ENOUGH) * energy:
            for f in range(island.freedoms):
                rate[f] += change[f]
            move_links(island, articulation, rate)
            return keep_energy(world, island, articulation, UNEVEN_TURN) >= 0
        if k > 0 and error < last and error * (error / last) <= settled * energy:
            for f in range(island.freedoms):
                rate[f] += change[f]
            _end_at_rates(world, island, articulation)
            return keep_energy(world, island, articulation, UNEVEN_TURN) >= 0
        if k == 0 or error < least:
            least = error
            for f in range(island.freedoms):
                best[f] = rate[f]
        if k > 0 and not error <= SLOWEST * last:
            relaxed = max(RELAXED * relaxed, LEAST_RELAXED)
        last = error
        for f in range(island.freedoms):
            rate[f] += relaxed * change[f]
    for f in range(island.freedoms):
        rate[f] = best[f]
    _end_at_rates(world, island, articulation)
    return False


@njit
def _end_at_rates(world: Any, island: Any, articulation: Any) -> None:
    """Move the links from the middle of the substep to its end, with the present rates."""
    rate = articulation.rate
    step = articulation.step
    for f in range(island.freedoms):
        step[f] = 0.5 * island.h * rate[f]
    place_links(world, island, articulation)
    move_links(island, articulation, rate)


@njit
def set_imbalance(world: Any, island: Any, articulation: Any, touched: Any) -> Any:
    """Set ``force`` of all links to the impulse that their momenta lack; returns twice the kinetic energy.

    ``touched``: whether rows act; ``link.contact`` then has their impulses.
    """
    links = articulation.links
    body_parameters = world.parameters.bodies
    energy = 0.0
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        keep_momentum(link, parameters)
        for d in range(len(link.momentum)):
            damping = parameters.linear_damping if d < len(link.position) else parameters.angular_damping
            energy += link.momentum[d] * link.velocity[d]
            link.response[d] = link.push[d] - (1.0 + island.h * damping) * link.momentum[d]
            if touched:
                link.response[d] += link.contact[d]
        if island.taut:
            resist(link, -1.0)
        carry(link)
    return energy


@njit
def restore_paths_of_rows(world: Any, island: Any, articulation: Any) -> None:
    """Restore the paths of trees where rows correct positions: finite rotations move centres by the squared angles."""
    add_corrections(world, island, articulation)
    _restore_paths(world, island, articulation, 0.5 * island.smooth, True)


@njit
def _restore_paths(world: Any, island: Any, articulation: Any, old: Any, corrected: Any) -> None:
    """Move each tree that nothing holds as a whole, so that its centre of mass moves by its mean momentum.

    ``old``: the part of the old momentum in the mean; ``corrected``: whether ``link.contact`` moves links besides.
    """
    links = articulation.links
    body_parameters = world.parameters.bodies
    bodies = world.state.bodies
    gravity = world.parameters.world.gravity
    dim = len(gravity)
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        for d in range(dim):
            force = bodies[link.body].force[d] + parameters.mass * parameters.gravity_scale * gravity[d]
            momentum = old * (link.push[d] - island.h * force) + (1.0 - old) * parameters.mass * link.velocity[d]
            if corrected:
                momentum += link.contact[d]
            link.force[d] = island.h * momentum - parameters.mass * (link.position[d] - link.start[d])
        link.force[dim] = parameters.mass
    average_over_trees(island, links, dim)
    for k in range(island.body_count):
        for d in range(dim):
            links[k].position[d] += links[k].response[d]


@njit
def restore_momenta(world: Any, island: Any, articulation: Any, h: Any) -> None:
    """Move each tree that nothing holds as a whole, by rounding, so that its momentum is ``push`` and ``contact``.

    The corrections of the rates end before their momenta are exact; sums over many steps would show that.  ``h``: s,
    in which damping acts.
    """
    links = articulation.links
    body_parameters = world.parameters.bodies
    dim = len(world.parameters.world.gravity)
    for k in range(island.body_count):
        link = links[k]
        mass = body_parameters[link.body].mass * (1.0 + h * body_parameters[link.body].linear_damping)
        for d in range(dim):
            link.force[d] = link.push[d] + link.contact[d] - mass * link.velocity[d]
        link.force[dim] = mass
    average_over_trees(island, links, dim)
    for k in range(island.body_count):
        link = links[k]
        for d in range(dim):
            link.velocity[d] += link.response[d]
            if link.tree == k and link.kind == _FREE:
                articulation.rate[link.first + d] += link.response[d]


@njit
def average_over_trees(island: Any, links: Any, dim: Any) -> None:
    """Set ``response`` of links to the sum of ``force`` over its tree by that of the masses, which come after it.

    0 for trees that are held.
    """
    for k in range(island.body_count):
        for d in range(dim + 1):
            links[k].response[d] = 0.0
    for k in range(island.body_count):
        root = links[links[k].tree]
        if root.kind == _FREE:
            for d in range(dim + 1):
                root.response[d] += links[k].force[d]
    for k in range(island.body_count):
        root = links[links[k].tree]
        for d in range(dim):
            if links[k].tree == k:
                root.response[d] = root.response[d] / root.response[dim] if root.kind == _FREE else 0.0
            else:
                links[k].response[d] = root.response[d]


@njit
def set_joint_imbalance(island: Any, articulation: Any) -> Any:
    """Set ``change`` to the impulses of springs, efforts and rotors at the present rates.

    Returns twice the kinetic energy of the rotors.
    """
    freedoms = articulation.freedoms
    start = articulation.start
    rate = articulation.rate
    change = articulation.change
    energy = 0.0
    for f in range(island.freedoms):
        rotor = freedoms[f].armature * rate[f]
        energy += rotor * rate[f]
        change[f] = freedoms[f].pull - freedoms[f].stiffness * rate[f] + freedoms[f].armature * start[f] - rotor
    return energy
