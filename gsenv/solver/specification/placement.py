"""Points of bodies at their initial poses."""

from __future__ import annotations

from collections.abc import Sequence

from ..dimension import dimension
from ..records.model import Array
from .specs import BodySpec, JointSpec


def to_local(body: BodySpec, point: Array) -> Array:
    """Return a world point in the frame of a body at its initial pose."""
    turned_back: Array = dimension(body.dim).initial_state.turned_back(body, point - body.position)
    return turned_back


def to_world(body: BodySpec, point: Array) -> Array:
    """Return the world point of a point of a body's frame, at its initial pose."""
    turned: Array = dimension(body.dim).initial_state.turned(body, point)
    return body.position + turned


def anchor_of(spec: JointSpec, bodies: Sequence[BodySpec]) -> Array:
    """Return the world point in m of a joint's anchor on body b, from whichever anchor was given."""
    a, b = bodies[spec.body_a], bodies[spec.body_b]
    if spec.anchor_b is not None:
        return to_world(b, spec.anchor_b)
    return b.position if spec.anchor_a is None else to_world(a, spec.anchor_a)
