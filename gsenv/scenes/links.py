"""Rows of links joined by hinges, of which chains, ropes and bridges are made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Capsule, Revolute

from .palette import IRON, Rgb

Point = tuple[float, float]

LINK = 2  # collision category of links, which do not collide with each other
NOT_LINKS = ~LINK


def direction(degrees: float) -> Point:
    """Return the unit vector ``degrees`` counter-clockwise from straight down."""
    angle = math.radians(degrees)
    return math.sin(angle), -math.cos(angle)


def straight(start: Point, degrees: float, length: float, count: int) -> list[Point]:
    """Return ``count`` + 1 points ``length`` m apart, from ``start`` on in the ``direction`` of ``degrees``."""
    x, y = direction(degrees)
    return [(start[0] + k * length * x, start[1] + k * length * y) for k in range(count + 1)]


def add_links(
    scene: Scene,
    points: Sequence[Point],
    half_width: float | Sequence[float],
    start: str | None = None,
    end: str | None = None,
    masses: Sequence[float] | None = None,
    name: str = "link",
    density: float = 1.0,
    friction: float = 0.5,
    damping: float = 0.0,
    drag: float = 0.0,
    colors: Sequence[Rgb] = IRON,
) -> list[str]:
    """Add links ``name``_0, ``name``_1, ... from each point to the next, joined by hinges at the points.

    Args:
        points: m, (link + 1, 2).
        half_width: m, half width of the capsules: one number, or one for each link.
        start, end: bodies to which the first and the last point are hinged; None leaves that end free.
        masses: kg, one for each link, with the inertia of a uniform thin rod; None takes masses and inertias from
            shape and density.
        density: kg/m^2.
        damping: N m s/rad, of the hinges between links.
        drag: 1/s, linear damping of the links.
        colors: colours of the links, used cyclically.

    Returns:
        The links' names.
    """
    count = len(points) - 1
    names = [f"{name}_{k}" for k in range(count)]
    widths = np.broadcast_to(half_width, (count,)).tolist()
    for k, ((ax, ay), (bx, by)) in enumerate(pairwise(points)):
        length = math.hypot(bx - ax, by - ay)
        shape = Capsule(
            half_length=0.5 * length,
            radius=widths[k],
            density=density,
            friction=friction,
            category=LINK,
            mask=NOT_LINKS,
        )
        mass = None if masses is None else masses[k]
        scene.add_body(
            names[k],
            shapes=[shape],
            position=(0.5 * (ax + bx), 0.5 * (ay + by)),
            angle=math.atan2(by - ay, bx - ax),
            mass=mass,
            inertia=None if mass is None else mass * length**2 / 12.0,
            linear_damping=drag,
            color=colors[k % len(colors)],
        )
    joined = pairwise([start, *names, end])
    for k, ((before, after), point) in enumerate(zip(joined, points, strict=True)):
        if before is not None and after is not None:
            between = damping if 0 < k < count else 0.0
            scene.add_joint(f"{name}_hinge_{k}", Revolute(before, after, anchor=point, damping=between))
    return names
