"""Forces of the joints of trees: what each joint must have transmitted for its bodies to move as they did."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..coupled import has_half
from ..dispatch import by_dimension
from ..rows import HALF

add_reaction = by_dimension("articulation", "add_reaction")
add_row_reaction = by_dimension("joints", "add_reaction")
keep_momentum = by_dimension("articulation", "keep_momentum")
carry = by_dimension("articulation", "carry")
resist = by_dimension("tension", "resist")


@njit
def keep_momenta(world: Any, island: Any, articulation: Any) -> None:
    """Keep positions, momenta and twice the kinetic energy at the start of the substep."""
    links = articulation.links
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    island.kinetic = 0.0
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        force = bodies[link.body].force
        keep_momentum(link, parameters)
        for d in range(len(link.momentum)):
            island.kinetic += link.momentum[d] * link.velocity[d]
            link.push[d] = link.momentum[d] + island.h * force[d]
        for d in range(len(gravity)):
            link.start[d] = link.position[d]
            link.push[d] += island.h * parameters.mass * parameters.gravity_scale * gravity[d]
        for d in range(len(link.start_spin)):
            link.start_spin[d] = link.velocity[len(gravity) + d]


@njit
def store_reactions(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Add the impulses of all joints in the substep to their reactions, from the leaves inward.

    The change of a link's momentum is the impulse of gravity, applied forces, damping, contacts and joints.
    """
    links = articulation.links
    body_parameters = world.parameters.bodies
    dim = len(world.parameters.world.gravity)
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        keep_momentum(link, parameters)
        for d in range(len(link.momentum)):
            damping = parameters.linear_damping if d < dim else parameters.angular_damping
            link.response[d] = (1.0 + island.h * damping) * link.momentum[d] - link.push[d] - link.contact[d]
        if island.taut:
            resist(link, 1.0)
        carry(link)
    add_reactions(island, articulation, joints, not island.servos)
    for k in range(island.body_count):
        link = links[k]
        if link.joint >= 0:
            _store_locked(link, joints[link.joint], dim, island.stored_scale)


@njit
def add_reactions(island: Any, articulation: Any, joints: Any, idle: Any) -> None:
    """Add to the reactions what the joints transmit; ``link.force`` has the impulse that each link takes, of itself.

    ``idle``: no motor, spring, limit or friction acts in a joint.
    """
    links = articulation.links
    for k in range(island.body_count - 1, -1, -1):
        link = links[k]
        if link.joint < 0:
            continue
        if link.parent >= 0:
            for d in range(len(link.force)):
                links[link.parent].force[d] += link.force[d]
        add_reaction(link, joints[link.joint].reaction, idle)


@njit
def keep_pushes(world: Any, island: Any, articulation: Any) -> None:
    """Keep the momenta of all links, whose change ``add_pushes`` is to explain."""
    links = articulation.links
    for k in range(island.body_count):
        keep_momentum(links[k], world.parameters.bodies[links[k].body])
        for d in range(len(links[k].momentum)):
            links[k].push[d] = links[k].momentum[d]


@njit
def add_pushes(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Add the impulses by joints that changed the momenta, at the present poses, to the reactions.

    The rows of joints in no tree have theirs as ``impulse``, and the links the sums of these as ``contact``.
    """
    _add_other_reactions(world, island, joints)
    links = articulation.links
    for k in range(island.body_count):
        link = links[k]
        keep_momentum(link, world.parameters.bodies[link.body])
        for d in range(len(link.momentum)):
            link.response[d] = link.momentum[d] - link.push[d] - link.contact[d]
        for d in range(len(link.center)):
            link.center[d] = link.position[d] - links[link.tree].position[d]
            link.anchor[d] = link.pin[d] - links[link.tree].position[d]
        carry(link)
    add_reactions(island, articulation, joints, not island.servos)


@njit
def _add_other_reactions(world: Any, island: Any, joints: Any) -> None:
    """Add the impulses of the rows of joints in no tree, which are of the present poses, to the reactions."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    joint_parameters = world.parameters.joints
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    for r in range(island.other_rows):
        row = rows[r]
        if row.impulse == 0.0:
            continue
        i = row.body_b
        substep_body = substep_bodies[i]
        for d in range(len(substep_body.correction)):
            substep_body.correction[d] = 0.0
        state = joints[row.source]
        if row.kind == HALF:
            pass  # its impulse is that of the row before it
        elif row.slot < 0:
            state.total_impulse[-1 - row.slot] -= row.impulse
        else:
            state.total_impulse[row.slot] += row.impulse
        if has_half(rows, r, island.other_rows):
            continue  # reactions are those on the second joint's body b
        add_row_reaction(row, joint_parameters[row.source], bodies[i], body_parameters[i], substep_body, state, 0.0)


@njit
def _store_locked(link: Any, state: Any, dim: Any, scale: Any) -> None:
    """Store the impulses of the rows that the joint would have, from which these start where they are needed."""
    for d in range(dim):
        force = -link.force[d] if link.flipped else link.force[d]
        state.impulse[d] = 0.0 if link.slides > 0 else scale * force
    if dim == 3 or link.count == 0:
        for d in range(dim, len(link.force)):
            state.impulse[d] = 0.0


@njit
def add_impulses(world: Any, island: Any, articulation: Any, first: Any) -> None:
    """Set the impulses by rows on each link, about its centre of mass: of contacts and of joints in no tree.

    ``first``: first row that is not of a joint in no tree, 0 for all rows.
    """
    _clear_impulses(island, articulation)
    rows = world.scratch.rows
    for r in range(island.rows):
        if r < island.other_rows or r >= first:
            _add_impulse(world, articulation, rows[r], rows[r].impulse)


@njit
def add_corrections(world: Any, island: Any, articulation: Any) -> None:
    """Set ``contact`` of each link to the impulses, per time, of the correction of positions in this substep."""
    _clear_impulses(island, articulation)
    rows = world.scratch.rows
    for r in range(island.rows):
        _add_impulse(world, articulation, rows[r], island.share * rows[r].position_impulse)


@njit
def _clear_impulses(island: Any, articulation: Any) -> None:
    links = articulation.links
    for k in range(island.body_count):
        for d in range(len(links[k].contact)):
            links[k].contact[d] = 0.0


@njit
def _add_impulse(world: Any, articulation: Any, row: Any, impulse: Any) -> None:
    if impulse == 0.0:
        return
    places = articulation.places
    links = articulation.links
    body_parameters = world.parameters.bodies
    if body_parameters[row.body_a].inv_mass > 0.0:
        contact = links[places[row.body_a]].contact
        for d in range(len(row.jacobian_a)):
            contact[d] += row.jacobian_a[d] * impulse
    if body_parameters[row.body_b].inv_mass > 0.0:
        other = links[places[row.body_b]].contact
        for d in range(len(row.jacobian_b)):
            other[d] += row.jacobian_b[d] * impulse
