"""The links of an island: which body hangs on which, their poses and rates."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...jit import njit
from ...records.articulation import LinkKind
from ...records.model import JointKind
from ..dispatch import by_dimension
from ..joints import SWING_PER_SUBSTEP
from ..slices import part
from ..springs import has_spring

enter_link = by_dimension("articulation", "enter_link")
enter_joint = by_dimension("articulation", "enter_joint")
place_link = by_dimension("articulation", "place_link")
start_rates = by_dimension("articulation", "start_rates")
set_motion = by_dimension("articulation", "set_motion")
turning_rate = by_dimension("articulation", "turning_rate")
swing_of_side = by_dimension("joints", "swing_of_side")
tension_of = by_dimension("joints", "tension_of")
most_inverse = by_dimension("articulation", "most_inverse")
mismatch = by_dimension("articulation", "mismatch")

_FREE = int(LinkKind.FREE)
_FIXED = int(LinkKind.FIXED)
_PIVOT = int(LinkKind.PIVOT)
_WELD = int(JointKind.WELD)
TURN_PER_SUBSTEP = 0.4  # rad: largest rotation of a link in a substep
MOST_TURN = 1.0  # rad: where even the most substeps leave more, the rows of the joints are more robust
LEAST_SWING = 1.0  # rad in a substep: slower swings of taut links need no care
NEAR = 0.01  # of the size of a link: joints that are farther apart are first brought together by their rows
JUMP = 0.05  # of a link's speed: anchors that separate faster are first brought together


@njit
def list_links(world: Any, island: Any, articulation: Any) -> Any:
    """Fill ``links`` with the bodies of the island, parents first; False where it needs the rows of its joints."""
    if not _all_in_trees(world, island):
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
    if not _fits(island, articulation, len(world.scratch.rows[0].jacobian_a)):
        return False
    return _enter(world, island, articulation)


@njit
def _all_in_trees(world: Any, island: Any) -> Any:
    """Whether the island has joints, all of them rigid and in trees, and no body that is swept.

    Rotors, soft limits and limits with restitution need the rows of their joints.
    """
    trees = world.model.trees
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    body_parameters = world.parameters.bodies
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    if len(island_joints) == 0:
        return False
    for k in range(len(island_joints)):
        j = island_joints[k]
        model = joint_models[j]
        child = model.body_a if trees[model.body_a].joint == j else model.body_b
        if trees[child].joint != j or not body_parameters[child].inv_mass > 0.0:
            return False
        if model.kind == _WELD and has_spring(joint_parameters[j]):
            return False
        if joint_parameters[j].limit_restitution > 0.0 or joint_parameters[j].limit_frequency > 0.0:
            return False
        if joint_parameters[j].armature > 0.0:
            return False
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
    link.coordinate = 0.0
    last = -1
    if tree.joint >= 0 and joint_parameters[tree.joint].enabled != 0:
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
    link.count = 1
    if link.kind == _FREE:
        link.count = len(link.velocity)
    elif link.kind == _FIXED:
        link.count = 0
    elif link.kind == _PIVOT:
        link.count = 3
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
    rows = ndof * island.contact_count + 4 * island.joint_count
    return 2 * deepest * rows <= len(articulation.values)


@njit
def _enter(world: Any, island: Any, articulation: Any) -> Any:
    """Set poses and rates from the bodies; False where a joint does not hold, so that its rows must act first."""
    links = articulation.links
    start = articulation.start
    step = articulation.step
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    joint_parameters = world.parameters.joints
    for f in range(island.freedoms):
        step[f] = 0.0
    for k in range(island.body_count):
        link = links[k]
        body = bodies[link.body]
        enter_link(link, body)
        for d in range(len(link.turn)):
            link.turn[d] = 0.0
        if link.joint >= 0:
            enter_joint(links, k, bodies, body_parameters, joint_parameters[link.joint])
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
            if gap > NEAR * size or slip > JUMP * speed + world.options.sleep_speed:
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
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    dt = world.options.timestep
    slow = (LEAST_SWING * world.options.substeps / dt) ** 2
    island.swing = 0.0
    island.spin = 0.0
    for k in range(island.body_count):
        link = links[k]
        island.spin = max(island.spin, turning_rate(link, body_parameters[link.body]))
        if link.joint >= 0 and link.kind != _FIXED:
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
            a, _, _ = swing_of_side(bodies[model.body_a], body_parameters[model.body_a], parameters.anchor_a)
            b, _, _ = swing_of_side(bodies[model.body_b], body_parameters[model.body_b], parameters.anchor_b)
            island.swing = max(island.swing, tension * (a + b))


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
    link.base_coordinate = link.coordinate


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
