"""Energy of links that nothing drives, damps or touches: rates at the end of a substep that keep it exactly.

The balance of momentum keeps the energy on average alone; of links that turn far within a substep it is off by
thousandths now and then.  The rates are the motion of each free tree as one rigid body, with its momentum, and the
rest, which has no momentum.  Only the rest is scaled, so that momenta are kept.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import LinkKind
from ...records.model import JointKind
from ..dispatch import by_dimension
from ..joints import Joint
from ..slices import part
from .equations import factorise_matrix, substitute
from .links import move_links

keep_momentum = by_dimension("articulation", "keep_momentum")
carry = by_dimension("articulation", "carry")
set_inertia = by_dimension("articulation", "set_inertia")
add_inertia = by_dimension("articulation", "add_inertia")
read_joint = by_dimension("joint_readings", "read_joint")

_FREE = int(LinkKind.FREE)
_STORELESS = (int(JointKind.ROWS), int(JointKind.TARGET), int(JointKind.GEAR))
UNEVEN_TURN = 0.02  # rad in a substep: of slower links the error of the energy is small
MOST_SCALED = 0.1  # largest relative change of the rates
MOST_LEFT = 1e-4  # of the energy: largest error that may be left then


@njit
def keep_energy(world: Any, island: Any, articulation: Any, turn: Any) -> Any:
    """Scale the rates at the end of the substep to the energy at which forces have done the work, if only they do.

    ``turn``: rad, of links that turn less in the substep nothing is scaled.  Returns 1 if they have that energy now, 0
    if more than forces does work, -1 if the substep is too long: the error is too large to be scaled away.
    """
    if not _conserves_energy(world, island, articulation, turn):
        return 0
    left = _scale_rest(world, island, articulation, 0.0, (1.0 - MOST_SCALED) ** 2, (1.0 + MOST_SCALED) ** 2)
    return 1 if left <= MOST_LEFT else -1


@njit
def lose_energy(world: Any, island: Any, articulation: Any, stored: Any) -> None:
    """Slow links whose rates did not settle down to where forces have done the work, if no motor does any.

    ``stored``: J, which springs may give back in the substep.
    """
    if not island.driven:
        _scale_rest(world, island, articulation, 2.0 * stored, 0.0, 1.0)


@njit
def _scale_rest(world: Any, island: Any, articulation: Any, released: Any, least: Any, most: Any) -> Any:
    """Scale what is no rigid motion to the energy that forces leave it; ``least``, ``most``: of the factor's square.

    Where ``least`` is 0 and forces leave less than the energy of rigid motions, these are scaled too.

    ``released``: twice the energy in J that it has from elsewhere.  Returns the error that is left, of the energy.
    """
    links = articulation.links
    rate = articulation.rate
    _set_momenta(world, island, articulation)
    energy = 0.0
    for k in range(island.body_count):
        for d in range(len(links[k].momentum)):
            energy += links[k].momentum[d] * links[k].velocity[d]
    rigid = _set_rigid_motions(island, links)
    inner = energy - rigid
    total = energy_by_forces(world, island, links) + released
    wanted = total - rigid
    scale = whole = 1.0
    if wanted < 0.0 and least == 0.0 and rigid > 0.0:  # poses that were moved may have given trees momentum
        whole = (max(total, 0.0) / rigid) ** 0.5
    if inner > 0.0 or whole < 1.0:
        scale = min(max(max(wanted, 0.0) / max(inner, 1e-300), least), most) ** 0.5
        for k in range(island.body_count):
            link = links[k]
            for f in range(link.first, link.first + link.count):
                kept = link.response[f - link.first] if link.kind == _FREE else 0.0
                rate[f] = whole * kept + scale * (rate[f] - kept)
        move_links(island, articulation, rate)
    _restore_centers(island, links)
    return abs(wanted - scale * scale * inner) / max(total, energy, 1e-300)


@njit
def stored_energy(world: Any, island: Any, articulation: Any) -> Any:
    """Return the energy in J of the springs at the poses of the bodies, and of the rotors at the old rates."""
    bodies = world.state.bodies
    joints = world.state.joints
    joint_models = world.model.joints
    body_parameters = world.parameters.bodies
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    energy = 0.0
    for k in range(len(island_joints)):
        j = island_joints[k]
        if joint_models[j].kind in _STORELESS:
            continue
        a, b = joint_models[j].body_a, joint_models[j].body_b
        joint = Joint(joint_models[j], joint_parameters[j], joints[j])
        energy += read_joint(bodies[a], bodies[b], body_parameters[a], body_parameters[b], joint)[1]
    if island.servos:
        for f in range(island.freedoms):
            energy += 0.5 * articulation.freedoms[f].armature * articulation.start[f] ** 2
    return energy


@njit
def _conserves_energy(world: Any, island: Any, articulation: Any, turn: Any) -> Any:
    """Whether links turn so far in the substep that its error of the energy counts, and only forces do work."""
    if island.turning < turn or island.taut or island.driven or island.has_springs:
        return False
    body_parameters = world.parameters.bodies
    for k in range(island.body_count):
        parameters = body_parameters[articulation.links[k].body]
        if parameters.linear_damping != 0.0 or parameters.angular_damping != 0.0:
            return False
    return True


@njit
def _set_momenta(world: Any, island: Any, articulation: Any) -> None:
    """Set momenta, inertias and centres of all links at their present poses, about the root of each tree."""
    links = articulation.links
    body_parameters = world.parameters.bodies
    for k in range(island.body_count):
        link = links[k]
        for d in range(len(link.center)):
            link.center[d] = link.position[d] - links[link.tree].position[d]
        keep_momentum(link, body_parameters[link.body])
        set_inertia(link, body_parameters[link.body], 0.0)
        for d in range(len(link.response)):
            link.response[d] = link.momentum[d]
        carry(link)


@njit
def _set_rigid_motions(island: Any, links: Any) -> Any:
    """Set ``response`` of each free root to the velocity of its tree as one rigid body; returns twice their energy."""
    energy = 0.0
    for k in range(island.body_count - 1, -1, -1):
        root = links[links[k].tree]
        if root.kind == _FREE and links[k].tree != k:
            for d in range(len(root.force)):
                root.force[d] += links[k].force[d]
            add_inertia(root, links[k])
    for k in range(island.body_count):
        root = links[k]
        if root.kind == _FREE:
            for d in range(len(root.force)):
                root.response[d] = root.force[d]
            factorise_matrix(len(root.force), root.inertia)
            substitute(len(root.force), root.inertia, root.response)
            for d in range(len(root.force)):
                energy += root.force[d] * root.response[d]
    return energy


@njit
def energy_by_forces(world: Any, island: Any, links: Any) -> Any:
    """Return twice the kinetic energy at which gravity and applied forces have done the work of the substep."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    energy = island.kinetic
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        force = bodies[link.body].force
        for d in range(len(gravity)):
            weight = parameters.mass * parameters.gravity_scale * gravity[d]
            energy += 2.0 * (weight + force[d]) * (link.position[d] - link.start[d])
        for d in range(len(link.turn)):
            energy += 2.0 * force[len(gravity) + d] * (link.half[d] + link.turn[d])
    return energy


@njit
def _restore_centers(island: Any, links: Any) -> None:
    """Set the centres to those half a substep ahead again, where reactions act."""
    for k in range(island.body_count):
        link = links[k]
        for d in range(len(link.center)):
            link.center[d] = link.base_position[d] - links[link.tree].base_position[d]
