"""The balance of momentum of a substep in which rows act.

The rows are solved half a substep ahead.  At the end of the substep the links have turned, and the same rates mean
other momenta.  With the impulses of the rows given, the balance (balance.py) asks for a correction of the rates; the
rows are solved again with it, from their impulses, until the correction vanishes.
"""

from __future__ import annotations

from typing import Any

from numba import int64

from ...jit import njit
from .balance import RELAXED, set_imbalance, set_joint_imbalance
from .dynamics import respond_inward, respond_outward, set_forces
from .links import move_links, place_links
from .reactions import add_impulses
from .solve import sweep_rows

MOST_PASSES = 10  # of the rows and the balance
SETTLED = 0.1  # of the tolerance: largest correction of the rates that ends the passes, relative to the rates
GROWN = 4.0  # the same above which they are given up
HURRIED = 3  # share of the sweeps in a pass over rows that were not solved to the tolerance
SLOWEST = 0.25  # ratio of the energies of two corrections above which they are relaxed


@njit
def settle_rows(world: Any, island: Any, articulation: Any) -> Any:
    """Correct rates and impulses until the momenta at the end of the substep are what they must be.

    Starts from solved rows.  Leaves the links at the end of the substep; returns whether the corrections converged.
    All passes together take at most as many sweeps as a solve.  Rows that are not solved to the tolerance are far
    from where more passes could help: they get one, of fewer sweeps.
    """
    options = world.options
    freedoms = articulation.freedoms
    change = articulation.change
    settled = (SETTLED * options.tolerance) ** 2  # of the kinetic energy: largest energy of the last correction
    unsolved = island.residual > options.tolerance
    left = int64(max(options.sweeps // HURRIED, 1) if unsolved else options.sweeps)
    relaxed = 1.0
    last = 0.0
    for k in range(MOST_PASSES):
        end_with_rows(world, island, articulation)
        add_impulses(world, island, articulation, 0)
        energy = set_imbalance(world, island, articulation, True)
        energy = max(energy + set_joint_imbalance(island, articulation), island.kinetic)
        error = respond_inward(articulation.links, island.body_count, freedoms, change)
        if error <= settled * energy or (k > 0 and error < last and error * (error / last) <= settled * energy):
            _solve_with(world, island, articulation, 1.0, left)
            end_with_rows(world, island, articulation)
            return True
        if not error <= energy or (k > 0 and error > GROWN * last):
            _solve_again(world, island, articulation)
            return False
        if k > 0 and error > SLOWEST * last:
            relaxed *= RELAXED
        last = error
        left -= _solve_with(world, island, articulation, relaxed, left)
        if unsolved or left <= 0:
            break
    end_with_rows(world, island, articulation)
    return False


@njit
def correct_forces(world: Any, island: Any, articulation: Any) -> None:
    """Solve the rows again with the forces that depend on the rates at the mean of the old and the present ones.

    Those of the free rates do not know the impulses of the rows; with them motors would be of first order.
    """
    links = articulation.links
    start = articulation.start
    mean = articulation.mean
    rate = articulation.rate
    change = articulation.change
    for f in range(island.freedoms):
        mean[f] = start[f] + 0.5 * (rate[f] - start[f])
        change[f] = 0.0
    move_links(island, articulation, mean)
    set_forces(world, island, articulation, mean)
    for k in range(island.body_count):
        for d in range(len(links[k].force)):
            links[k].force[d] -= links[k].contact[d]
    respond_inward(links, island.body_count, articulation.freedoms, change)
    _solve_with(world, island, articulation, 1.0, int64(world.options.sweeps))


@njit
def _solve_again(world: Any, island: Any, articulation: Any) -> None:
    """Solve the rows from no impulses and without corrections, where these grow; moves the links to their ends."""
    rows = world.scratch.rows
    z = articulation.whitened
    for r in range(island.rows):
        rows[r].impulse = 0.0
    for f in range(island.freedoms):
        z[f] = 0.0
    _sweep_again(world, island, articulation, int64(world.options.sweeps))
    end_with_rows(world, island, articulation)


@njit
def _solve_with(world: Any, island: Any, articulation: Any, share: Any, most: Any) -> Any:
    """Solve the rows again with a share of the correction of the rates, of which ``change`` has the inward half.

    Takes at most ``most`` sweeps; returns their number.
    """
    freedoms = articulation.freedoms
    change = articulation.change
    z = articulation.whitened
    for f in range(island.freedoms):
        if freedoms[f].root > 0.0:
            z[f] += share * change[f] / freedoms[f].root
    return _sweep_again(world, island, articulation, most)


@njit
def _sweep_again(world: Any, island: Any, articulation: Any, most: Any) -> Any:
    """Solve the rows from the present impulses, and set the rates; returns the number of sweeps."""
    sweeps, residual = sweep_rows(world, island, articulation, most)
    world.state.world.sweeps += sweeps
    island.residual = residual
    rates_of_rows(island, articulation)
    return sweeps


@njit
def rates_of_rows(island: Any, articulation: Any) -> None:
    """Set ``rate`` to the free rates and the change that the whitened rates mean, ``change``."""
    rate = articulation.rate
    free = articulation.free
    change = articulation.change
    change_of_rows(island, articulation)
    for f in range(island.freedoms):
        rate[f] = free[f] + change[f]


@njit
def change_of_rows(island: Any, articulation: Any) -> None:
    """Set ``change`` to the change of the rates that the whitened rates mean."""
    freedoms = articulation.freedoms
    change = articulation.change
    z = articulation.whitened
    for f in range(island.freedoms):
        change[f] = z[f] * freedoms[f].root
    respond_outward(articulation.links, island.body_count, freedoms, change)


@njit
def end_with_rows(world: Any, island: Any, articulation: Any) -> None:
    """Move the links from the middle of the substep to its end, with the present rates and the shift of overlaps.

    Where the rows make velocities jump, the new rates hold over the whole substep.
    """
    rate = articulation.rate
    step = articulation.step
    start = articulation.start
    shift = articulation.shift
    for f in range(island.freedoms):
        mean = rate[f] + 0.5 * island.smooth * (start[f] - rate[f])
        step[f] = island.h * (mean - 0.5 * start[f]) + shift[f]
    place_links(world, island, articulation)
    move_links(island, articulation, rate)
