"""The links of an island: which body hangs on which, their poses and rates."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...jit import njit
from ...records.articulation import SLIDES, LinkKind
from ...records.model import JointKind
from ..dispatch import by_dimension
from ..joints import SWING_PER_SUBSTEP, rod_length
from ..slices import part
from .other_joints import count_other_rows, has_position, is_soft

enter_link = by_dimension("articulation", "enter_link")
enter_joint = by_dimension("articulation", "enter_joint")
place_link = by_dimension("articulation", "place_link")
keep_axes = by_dimension("articulation", "keep_axes")
start_joint_rates = by_dimension("articulation", "start_joint_rates")
set_joint_motion = by_dimension("articulation", "set_joint_motion")
squared_turning = by_dimension("articulation", "squared_turning")
arm_over_inertia = by_dimension("joints", "arm_over_inertia")
tension_of = by_dimension("joints", "tension_of")
most_inverse = by_dimension("articulation", "most_inverse")
mismatch = by_dimension("articulation", "mismatch")
anchor_distance = by_dimension("joints.distance", "anchor_distance")
line_speed = by_dimension("joints.distance", "line_speed")

_DISTANCE = int(JointKind.DISTANCE)
_FREE = int(LinkKind.FREE)
_AXES = int(LinkKind.AXES)
_NO_NEIGHBOUR = -2
TURN_PER_SUBSTEP = 0.4  # rad: largest rotation of a link in a substep
MOST_TURN = 1.0  # rad: where even the most substeps leave more, the rows of the joints are more robust
LEAST_SWING = 1.0  # rad in a substep: slower swings of taut links need no care
LARGEST_TURN = 0.3  # rad: largest rotation of a link by one correction of positions
NEAR = 0.01  # of the size of a link: joints that are farther apart are first brought together by their rows
ROUNDING = 1e-9  # m: smaller gaps are those of rounding, also of a wheel at the centre of mass that it hangs on
_POINT = 1e-9  # m: shorter lines have no direction
JUMP = 0.05  # of a link's speed: anchors that separate faster are first brought together


@njit
def list_links(world: Any, island: Any, articulation: Any) -> Any:
    """Fill ``links`` with the bodies of the island, parents first; False where it needs the rows of its joints."""
    if not _can_be_linked(world, island) or not count_other_rows(world, island, articulation.others):
        return False
    trees = world.model.trees
    links = articulation.links
    places = articulation.places
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        p = k
        while p > 0 and trees[links[p - 1].body].rank > trees[i].rank:
            links[p].body = links[p - 1].body
            p -= 1
        links[p].body = i
    for k in range(len(island_bodies)):
        places[links[k].body] = k
    count = 0
    for k in range(len(island_bodies)):
        if not _attach(world, articulation, k, count):
            return False
        count += links[k].count
    island.freedoms = count
    if count == 0:  # welds on fixed bodies: their rows know the reactions
        return False
    if not _fits(island, articulation, len(world.scratch.rows[0].jacobian_a)):
        return False
    return _enter(world, island, articulation)


@njit
def has_chain(world: Any, island: Any, articulation: Any) -> Any:
    """Whether rods or ropes tie trees that nothing holds into a chain: one of two tied trees has another neighbour.

    There the stiffness is between the trees.  The factor of all joints in body space then solves it better than sweeps
    over the ropes, and closes it in straight lines, too; joint coordinates keep the energy of fast links better.
    """
    if island.other_rows == 0:
        return False
    links = articulation.links
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    for k in range(island.body_count):
        links[k].neighbour = _NO_NEIGHBOUR
    chained = False
    tied = False
    for k in range(len(island_joints)):
        model = world.model.joints[island_joints[k]]
        parameters = world.parameters.joints[island_joints[k]]
        if model.kind == _DISTANCE and has_position(model, parameters):
            a = _free_tree(world, articulation, model.body_a)
            b = _free_tree(world, articulation, model.body_b)
            tied = tied or (a != b and a >= 0 and b >= 0)
            chained = _is_second(links, a, b) or chained
            chained = _is_second(links, b, a) or chained
    return tied and chained


@njit
def _is_second(links: Any, tree: Any, neighbour: Any) -> Any:
    """Whether a free tree is tied to a second neighbour; -1 is whatever is held."""
    if tree < 0 or neighbour == tree:
        return False
    if links[tree].neighbour == _NO_NEIGHBOUR:
        links[tree].neighbour = neighbour
    return links[tree].neighbour != neighbour


@njit
def _free_tree(world: Any, articulation: Any, body: Any) -> Any:
    """Return the root of the tree of a body, -1 where something holds it."""
    if world.parameters.bodies[body].inv_mass == 0.0:
        return -1
    links = articulation.links
    root = links[articulation.places[body]].tree
    return root if links[root].kind == _FREE else -1


@njit
def _can_be_linked(world: Any, island: Any) -> Any:
    """Whether no body of the island is swept."""
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    body_models = world.model.bodies
    for k in range(len(island_bodies)):
        if body_models[island_bodies[k]].continuous != 0:
            return False
    return True


@njit
def _attach(world: Any, articulation: Any, k: Any, first: Any) -> Any:
    """Set parent, joint and degrees of freedom of link k, of which ``first`` is the first; False if it cannot be."""
    links = articulation.links
    freedoms = articulation.freedoms
    link = links[k]
    tree = world.model.trees[link.body]
    joint_parameters = world.parameters.joints
    link.parent = -1
    link.holder = -1
    link.joint = -1
    link.kind = _FREE
    link.flipped = tree.flipped
    link.tree = k
    last = -1
    if tree.joint >= 0 and joint_parameters[tree.joint].enabled != 0 and not is_soft(world, tree.joint):
        link.joint = tree.joint
        link.kind = tree.kind
        link.holder = tree.parent
        if world.parameters.bodies[tree.parent].inv_mass > 0.0:
            link.parent = articulation.places[tree.parent]
            link.tree = links[link.parent].tree
            last = links[link.parent].last
        else:
            velocity = world.state.bodies[tree.parent].velocity
            for d in range(len(velocity)):
                if velocity[d] != 0.0:
                    return False
    link.first = first
    link.count = tree.count
    link.slides = 0
    if link.kind == _FREE:
        link.count = len(link.velocity)
    for i in range(min(link.count, len(link.numbers))):
        link.numbers[i] = tree.numbers[i]
        if link.kind != _FREE and 0 <= tree.numbers[i] < SLIDES:
            link.slides += 1
    for f in range(first, first + link.count):
        freedoms[f].parent = last
        freedoms[f].link = k
        freedoms[f].stiffness = 0.0
        freedoms[f].pull = 0.0
        last = f
    link.last = last
    return True


@njit
def _fits(island: Any, articulation: Any, ndof: Any) -> Any:
    """Whether the rows of the island fit into the buffers in joint space."""
    links = articulation.links
    freedoms = articulation.freedoms
    deepest = 0
    for k in range(island.body_count):
        depth = 0
        f = links[k].last
        if f >= 0 and freedoms[f].link == k:
            while f >= 0:
                depth += 1
                f = freedoms[f].parent
        deepest = max(deepest, depth)
    rows = ndof * island.contact_count + 5 * island.joint_count + island.other_rows
    return 2 * deepest * rows <= len(articulation.values)


@njit
def _enter(world: Any, island: Any, articulation: Any) -> Any:
    """Set poses and rates from the bodies; False where rows must act: a joint does not hold, or is nearly singular."""
    links = articulation.links
    start = articulation.start
    step = articulation.step
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    joint_parameters = world.parameters.joints
    for f in range(island.freedoms):
        step[f] = 0.0
    island.mass = 0.0
    for k in range(island.body_count):
        link = links[k]
        body = bodies[link.body]
        island.mass += body_parameters[link.body].mass
        enter_link(link, body)
        for d in range(len(link.turn)):
            link.turn[d] = 0.0
        if link.joint >= 0 and not enter_joint(links, k, bodies, body_parameters, joint_parameters[link.joint]):
            return False
        set_base(link)
        if link.joint >= 0:
            place_link(links, k, step, bodies, body_parameters, joint_parameters[link.joint])
        start_rates(links, k, bodies, start)
        set_motion(links, k, start)
        if link.joint >= 0:
            size = 0.0
            for d in range(len(link.arm)):
                size += abs(link.arm[d]) + abs(link.reach[d])
            set_base(link)
            gap, slip, speed = mismatch(link, body, body_parameters[link.body].radius)
            if gap > NEAR * size + ROUNDING or slip > JUMP * speed + world.options.sleep_speed:
                return False
    return True


@njit
def measure_motion(world: Any, island: Any, joints: Any, articulation: Any) -> None:
    """Set ``spin``, the fastest rotation of a link in rad/s, and ``swing``, the squared frequency of taut links.

    See ``joints.substeps_for`` for taut links. Frequencies that every substep resolves count as 0.
    """
    links = articulation.links
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    body_parameters = world.parameters.bodies
    dt = world.options.timestep
    slow = (LEAST_SWING * world.options.substeps / dt) ** 2
    island.swing = 0.0
    spin = 0.0
    for k in range(island.body_count):
        link = links[k]
        spin = max(spin, squared_turning(links, k, body_parameters))
        if link.joint >= 0 and link.count > 0:
            model = joint_models[link.joint]
            parameters = joint_parameters[link.joint]
            tension = tension_of(joints[link.joint]) / dt
            own, other = 0.0, 0.0
            for d in range(len(link.arm)):
                own += abs(link.arm[d])
                other += abs(link.reach[d])
            own *= most_inverse(body_parameters[link.body])
            other *= most_inverse(body_parameters[link.holder])
            if tension * (own + other) < slow:
                continue
            a = arm_over_inertia(body_parameters[model.body_a], parameters.anchor_a)
            b = arm_over_inertia(body_parameters[model.body_b], parameters.anchor_b)
            island.swing = max(island.swing, tension * (a + b))
    island.spin = spin**0.5


@njit
def substeps_of_links(world: Any, island: Any) -> Any:
    """Return the number of substeps that keeps taut links stable and rotating ones accurate; 0 if there is none."""
    dt = world.options.timestep
    least = world.options.substeps
    most = max(least, world.options.max_substeps)
    needed = max(dt * island.swing**0.5 / SWING_PER_SUBSTEP, dt * island.spin / TURN_PER_SUBSTEP)
    count = min(max(least, int(np.ceil(min(needed, 1e6)))), most)
    island.turning = dt * island.spin / count
    return count if island.turning <= MOST_TURN else 0


@njit
def set_base(link: Any) -> None:
    """Count displacements from the present pose of a link."""
    for d in range(len(link.position)):
        link.base_position[d] = link.position[d]
    for d in range(len(link.rotation)):
        link.base_rotation[d] = link.rotation[d]
    link.base_angle = link.angle
    if link.kind == _AXES:
        keep_axes(link)


@njit
def start_rates(links: Any, k: Any, bodies: Any, rates: Any) -> None:
    """Set the rates of link k from the velocities of the bodies."""
    link = links[k]
    if link.kind != _FREE:
        start_joint_rates(links, k, bodies, rates)
        return
    for d in range(len(link.velocity)):
        rates[link.first + d] = bodies[link.body].velocity[d]


@njit
def set_motion(links: Any, k: Any, rates: Any) -> None:
    """Set the velocity of link k by the rates; that of its parent is set."""
    link = links[k]
    if link.kind != _FREE:
        set_joint_motion(links, k, rates)
        return
    for d in range(len(link.velocity)):
        link.velocity[d] = rates[link.first + d]


@njit
def place_links(world: Any, island: Any, articulation: Any) -> None:
    """Move all links from their bases by the displacement ``step`` of their degrees of freedom."""
    links = articulation.links
    step = articulation.step
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    joint_parameters = world.parameters.joints
    for k in range(island.body_count):
        place_link(links, k, step, bodies, body_parameters, joint_parameters[max(links[k].joint, 0)])


@njit
def move_links(island: Any, articulation: Any, rates: Any) -> None:
    """Set the velocities of all links by their rates."""
    links = articulation.links
    for k in range(island.body_count):
        set_motion(links, k, rates)


@njit
def largest_turn(world: Any, island: Any, articulation: Any) -> Any:
    """Return the largest rotation of a link in the substep at its present velocity, rad."""
    links = articulation.links
    body_parameters = world.parameters.bodies
    spin = 0.0
    for k in range(island.body_count):
        spin = max(spin, squared_turning(links, k, body_parameters))
    return island.h * spin**0.5


@njit
def largest_share(world: Any, island: Any, articulation: Any) -> Any:
    """Return the share of ``change`` by which no link, rod or rope turns so far that directions change much."""
    links = articulation.links
    move_links(island, articulation, articulation.change)
    farthest = LARGEST_TURN
    for k in range(island.body_count):
        turn = 0.0
        for d in range(len(links[k].position), len(links[k].velocity)):
            turn += abs(links[k].velocity[d])
        farthest = max(farthest, island.h * turn)
    if island.other_rows > 0:
        farthest = max(farthest, island.h * _fastest_line(world, island, articulation))
    return LARGEST_TURN / farthest


@njit
def _fastest_line(world: Any, island: Any, articulation: Any) -> Any:
    """Return the largest angular velocity, at most, of the line between the anchors of a rod or rope, rad/s.

    A stretched one turns by the way across the line over its present length; the way along it counts, too.
    """
    links, places = articulation.links, articulation.places
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    fastest = 0.0
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    for k in range(len(island_joints)):
        model = world.model.joints[island_joints[k]]
        parameters = world.parameters.joints[island_joints[k]]
        if model.kind != _DISTANCE or not has_position(model, parameters):
            continue
        i, j = model.body_a, model.body_b
        a, b = body_parameters[i], body_parameters[j]
        velocity_a, velocity_b = links[places[i]].velocity, links[places[j]].velocity
        speed = line_speed(bodies[i], bodies[j], a, b, parameters, velocity_a, velocity_b)
        length = max(anchor_distance(bodies[i], bodies[j], a, b, parameters), rod_length(parameters), _POINT)
        fastest = max(fastest, speed / length)
    return fastest
