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
from .dynamics import respond_inward, respond_outward
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
    rate = articulation.rate
    change = articulation.change
    z = articulation.whitened
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
        if error <= settled * energy:
            respond_outward(articulation.links, island.body_count, freedoms, change)
            for f in range(island.freedoms):
                rate[f] += change[f]
            move_links(island, articulation, rate)
            return True
        if not error <= energy or (k > 0 and error > GROWN * last):
            _solve_again(world, island, articulation)
            return False
        if k > 0 and error > SLOWEST * last:
            relaxed *= RELAXED
        last = error
        for f in range(island.freedoms):
            if freedoms[f].root > 0.0:
                z[f] += relaxed * change[f] / freedoms[f].root
        sweeps, residual = sweep_rows(world, island, articulation, left)
        world.state.world.sweeps += sweeps
        island.residual = residual
        rates_of_rows(island, articulation)
        left -= sweeps
        if unsolved or left <= 0:
            break
    end_with_rows(world, island, articulation)
    return False


@njit
def _solve_again(world: Any, island: Any, articulation: Any) -> None:
    """Solve the rows from no impulses and without corrections, where these grow; moves the links to their ends."""
    rows = world.scratch.rows
    z = articulation.whitened
    for r in range(island.rows):
        rows[r].impulse = 0.0
    for f in range(island.freedoms):
        z[f] = 0.0
    sweeps, residual = sweep_rows(world, island, articulation, world.options.sweeps)
    world.state.world.sweeps += sweeps
    island.residual = residual
    rates_of_rows(island, articulation)
    end_with_rows(world, island, articulation)


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
