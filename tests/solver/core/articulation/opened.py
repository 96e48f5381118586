"""One island of a scene in joint coordinates, opened for its kernels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gsenv.solver import Options, Scene, World
from gsenv.solver.core.articulation.dynamics import factorise_links, respond, set_applied, set_force, set_middle
from gsenv.solver.core.articulation.links import list_links, move_links
from gsenv.solver.core.islands import build_islands
from gsenv.solver.core.step import enter_island
from gsenv.solver.jit import njit
from gsenv.solver.records.kernel_variants import kernel_variant_of
from gsenv.solver.records.kernel_world import kernel_world
from gsenv.solver.records.scratch import Scratch


class Opened(NamedTuple):
    """The bundle of a world with one island, which is opened, and the scratch of its links."""

    world: Any
    links: Any  # LINK_DTYPE (link,)
    start: Any  # rates (freedom,)


@njit
def _open(world: Any, h: Any) -> Any:
    articulation = world.scratch.articulation
    island = world.scratch.island
    count = build_islands(world, 0, world.state.joints)
    enter_island(island, world.scratch.islands[0])
    island.h = h
    if count != 1 or not list_links(world, island, articulation):
        return False
    set_middle(world, island, articulation)
    move_links(island, articulation, articulation.start)
    factorise_links(articulation.links, island.body_count, articulation.freedoms)
    return True


@njit
def accelerate(world: Any, out: Any) -> None:
    """Set ``out`` (freedom,) to the accelerations of the rates by gravity and rotation."""
    articulation = world.scratch.articulation
    links = articulation.links
    body_parameters = world.parameters.bodies
    bodies = world.state.bodies
    count = world.scratch.island.body_count
    for k in range(count):
        i = links[k].body
        set_applied(links[k], bodies[i], body_parameters[i], world.parameters.world.gravity)
        set_force(links, k, articulation.start, body_parameters[i].mass, 1.0)
    out[:] = 0.0
    respond(links, count, articulation.freedoms, out)


@njit
def push(world: Any, impulses: Any) -> None:
    """Replace impulses (impulse, freedom) on the degrees of freedom by the changes of the rates that they cause."""
    articulation = world.scratch.articulation
    links = articulation.links
    count = world.scratch.island.body_count
    for i in range(len(impulses)):
        for k in range(count):
            for d in range(len(links[k].force)):
                links[k].force[d] = 0.0
        for f in range(impulses.shape[1]):
            articulation.change[f] = impulses[i, f]
        respond(links, count, articulation.freedoms, articulation.change)
        for f in range(impulses.shape[1]):
            impulses[i, f] = articulation.change[f]


def opened(world: World, h: float = 1.0) -> Opened:
    """Open the only island of a world at its present poses and velocities."""
    variant = kernel_variant_of(world.model)
    scratch = Scratch(world.model, variant, 16)
    until = np.zeros(1, np.int64)
    options = world.options.record()
    bundle = kernel_world(
        world.model, world.parameters, world.state, scratch, options, variant, False, "subspace", until, True
    )
    assert _open(bundle, h)
    arrays: Any = scratch._articulation
    return Opened(
        bundle, arrays["links"][: scratch.island["body_count"]], arrays["start"][: scratch.island["freedoms"]]
    )


def articulated(scene: Scene, **options: Any) -> World:
    """A world with the option."""
    return World(scene, options=Options(articulated=True, **options))
