"""Detection of all contacts of a step, those of secondary impacts included."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..jit import inline_njit, njit
from .dispatch import by_dimension
from .geometry import BASE_MARGIN, MovingShape, PlacedShape, linear_norm, update_geometry
from .kept_pairs import find_all_pairs, find_near_pairs
from .recycling import pair_form, recycle_pair
from .secondary import MAX_LOOKS, any_wider, clear_widening, keep_secondary, widen_boxes
from .status import MORE_CONTACTS, MORE_PAIRS, OK

TOUCHING = 0.005  # of the extent: a predicted pair with a gap up to this is in contact


@njit
def undecided(world: Any, a: int, b: int, margin: float) -> bool:
    """Return False: only the narrowphase can tell."""
    return False


@inline_njit
def without_rolling(contact: Any, one: Any, other: Any) -> None:
    """Do nothing: 2D contacts have no torsional and rolling friction."""


pose_in = by_dimension("geometry", "pose_in")
motion_of = by_dimension("narrowphase.motion", "motion_of")
far_apart = by_dimension("narrowphase.find", "far_apart", otherwise=undecided)
is_shallow = by_dimension("narrowphase.find", "is_shallow")
pair_contacts = by_dimension("narrowphase.find", "pair_contacts")
label_rolling = by_dimension("narrowphase.find", "label_rolling", otherwise=without_rolling)


@njit
def find_contacts(world: Any) -> tuple[int, int, int, int, bool]:
    """Fill `world.scratch.pairs` and `found`; returns (status, needed, pair count, contact count, any_far_moving).

    A body may be pushed by an impact towards shapes far from its path: then the search is repeated, and again
    for bodies that these may be pushed towards.
    """
    scratch = world.scratch
    models = world.shapes.models
    bodies = world.state.bodies
    parameters = world.parameters.bodies
    substep_bodies = scratch.substep_bodies
    timestep = world.options.timestep
    pair_count = int64(0)
    count = int64(0)
    far_moving = False
    for look in range(MAX_LOOKS):
        if look == 0:
            pair_count = find_near_pairs(world, scratch.kept_boxes)
        else:
            pair_count = find_all_pairs(world)
        if pair_count > len(scratch.pairs):
            return MORE_PAIRS, pair_count, pair_count, count, False
        count = collide_pairs(world, pair_count, 0.0)
        if count > len(scratch.found):
            return MORE_CONTACTS, count, pair_count, count, False
        count, hit, far_moving = keep_secondary(world, count)
        if look == MAX_LOOKS - 1 or not hit:
            break
        if look == 0:
            clear_widening(substep_bodies)
        if not any_wider(models, parameters, substep_bodies, timestep, scratch.geometry):
            break
        if look > 0:
            update_geometry(world)
        widen_boxes(models, bodies, parameters, substep_bodies, timestep, scratch.geometry)
    return OK, int64(0), pair_count, count, far_moving


@njit
def collide_pairs(world: Any, pair_count: int, depth: float) -> int:
    """Write the contacts of the first `pair_count` pairs to `world.scratch.found`, in the order of the pairs.

    Returns their number; where it exceeds the length of that array, only the first ones were written.
    ``depth``: of the extent; where positive, pairs that overlap by less may be left out.
    """
    bodies = world.state.bodies
    models = world.shapes.models
    parameters = world.shapes.parameters
    geometry = world.scratch.geometry
    pairs = world.scratch.pairs
    found = world.scratch.found
    timestep = world.options.timestep
    known = int64(0)
    count = int64(0)  # not a literal: callees would be compiled for that as well
    for p in range(pair_count):
        a = int64(pairs[p].shape_a)
        b = int64(pairs[p].shape_b)
        extent, margin = pair_scale(
            geometry[a], geometry[b], bodies[models[a].body], bodies[models[b].body],
            models[a].sensor | models[b].sensor, timestep,
        )  # fmt: skip
        start = count
        if geometry[a].calm + geometry[b].calm == 2:
            known, count = recycle_pair(world, a, b, known, count)
        if count == start:
            if depth > 0.0 and is_shallow(world, a, b, depth * extent):
                continue
            count = collide_pair(world, a, b, extent, margin, count)
            for k in range(start, min(count, len(found))):
                found[k].shape_a = a
                found[k].shape_b = b
                found[k].travel = bodies[models[a].body].travel + bodies[models[b].body].travel
                found[k].form = pair_form(geometry, a, b)
        for k in range(start, min(count, len(found))):
            label_contact(found[k], models[a], models[b], parameters[a], parameters[b], extent)
    return count


@inline_njit
def pair_scale(one: Any, other: Any, body_a: Any, body_b: Any, sensor: int, timestep: float) -> tuple[float, float]:
    """Return (extent, margin) of a pair in m, from its records of geometry and the states of its bodies.

    They are the smaller extent of its dynamic bodies, and the distance within which the two may touch in
    this step, with the sum of both motions: impacts may change their directions.  Sensors detect present overlaps only.
    """
    extent = min(one.extent, other.extent)
    if sensor != 0:
        return extent, 0.0
    dim = len(body_a.position)
    square = 0.0
    for d in range(dim):
        square += (body_b.velocity[d] - body_a.velocity[d]) ** 2
    together = min(timestep * (linear_norm(body_a.velocity, dim) + linear_norm(body_b.velocity, dim)), extent)
    approach = max(timestep * np.sqrt(square), together)
    return extent, BASE_MARGIN * extent + approach + one.reach + other.reach


@njit
def collide_pair(world: Any, a: int, b: int, extent: float, margin: float, count: int) -> int:
    """Write the contacts of shapes a and b from entry `count` of `world.scratch.found` on; returns the new count.

    `extent` and `margin` are those of pair_scale, in m.
    """
    if far_apart(world, a, b, margin):
        return count
    geometry = world.scratch.geometry
    one = PlacedShape(a, pose_in(geometry[a]))
    other = PlacedShape(b, pose_in(geometry[b]))
    return pair_contacts(world, one, other, extent, margin, count)


@inline_njit
def label_contact(contact: Any, model_a: Any, model_b: Any, one: Any, other: Any, extent: float) -> None:
    """Set what all contacts of a pair share: bodies, material, length scale; and clear the impulses.

    `one`, `other` are the parameters of shapes a and b.
    """
    contact.body_a = model_a.body
    contact.body_b = model_b.body
    contact.sensor = model_a.sensor | model_b.sensor
    contact.friction = np.sqrt(one.friction * other.friction)
    contact.restitution = max(one.restitution, other.restitution)
    contact.extent = extent
    for k in range(len(contact.impulse)):
        contact.impulse[k] = 0.0
        contact.total_impulse[k] = 0.0
    clear_moments(contact)
    label_rolling(contact, one, other)


@inline_njit
def clear_moments(contact: Any) -> None:
    """Set the moments of a contact to 0."""
    for side in range(2):
        for d in range(contact.moments.shape[1]):
            contact.moments[side, d] = 0.0


@njit
def any_jointed(world: Any, a: PlacedShape, b: PlacedShape) -> bool:
    """Whether a joint affects the path of one of the two shapes."""
    models = world.shapes.models
    bodies = world.model.bodies
    return bodies[models[a.number].body].jointed | bodies[models[b.number].body].jointed != 0


@njit
def with_motion(world: Any, shape: PlacedShape) -> MovingShape:
    """Return a shape with the motion that its body will have at the end of the step if it hits nothing."""
    b = world.shapes.models[shape.number].body
    parameter = world.parameters.bodies[b]
    kind = world.model.bodies[b].kind
    gravity = world.parameters.world.gravity
    motion = motion_of(world.state.bodies[b], parameter, kind, gravity, world.options.timestep)
    return MovingShape(shape.number, shape.pose, motion, parameter.inv_mass)
