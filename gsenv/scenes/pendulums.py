"""Pendulums, a double pendulum and Newton's cradle."""

from __future__ import annotations

import math

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Circle, Distance, Revolute

from .links import add_links, direction, straight
from .palette import AMBER, GRAPHITE, STEEL, WARM


def pendulum(degrees: float = 120.0, length: float = 1.0, point: bool = False) -> Scene:
    """Build a pendulum of 1 kg on a hinge at the origin, at rest ``degrees`` from the vertical.

    It is a uniform rod of ``length`` m or, with ``point``, a point mass on a massless rod of that length.
    """
    scene = Scene()
    scene.add_body("pivot", kind="static")
    points = straight((0.0, 0.0), degrees, length, 1)
    if point:
        scene.add_body("bob", shapes=[Circle(radius=0.1 * length)], position=points[1], mass=1.0)
        scene.add_joint("hinge", Distance("pivot", "bob", anchor_a=(0.0, 0.0), anchor_b=(0.0, 0.0)))
    else:
        add_links(scene, points, 0.04 * length, start="pivot", masses=[1.0], colors=[WARM])
    return scene


def double_pendulum(degrees: float = 90.0, length: float = 1.0) -> Scene:
    """Build a double pendulum of two uniform rods of ``length`` m and 1 kg, straight and at rest.

    It starts ``degrees`` from the vertical.
    """
    scene = Scene()
    scene.add_body("pivot", kind="static")
    points = straight((0.0, 0.0), degrees, length, 2)
    add_links(scene, points, 0.05 * length, start="pivot", masses=[1.0, 1.0], colors=[WARM, AMBER])
    return scene


def cradle(
    raised: int = 1,
    restitution: float = 1.0,
    count: int = 5,
    degrees: float = 30.0,
    radius: float = 0.1,
    length: float = 1.0,
    arms: bool = False,
) -> Scene:
    """Build Newton's cradle: ``count`` touching frictionless balls, each on a hinge ``length`` m above its centre.

    The ``raised`` leftmost balls start at rest, ``degrees`` to the left. ``arms`` draws the arms that hold the balls,
    which have no mass and collide with nothing.
    """
    scene = Scene()
    beam = Capsule(half_length=radius * (count + 1), radius=0.4 * radius, mask=0)
    scene.add_body("frame", kind="static", shapes=[beam], position=(0.0, length), color=GRAPHITE)
    ball = Circle(radius=radius, friction=0.0, restitution=restitution)
    half = 0.5 * (length - radius)
    arm = Box(half_extents=(0.15 * radius, half), position=(0.0, radius + half), density=0.0, mask=0)
    x, y = direction(-degrees)
    for k in range(count):
        hinge = 2.0 * radius * (k - 0.5 * (count - 1))
        up = k < raised
        scene.add_body(
            f"ball_{k}",
            shapes=[arm, ball] if arms else [ball],
            position=(hinge + length * x, length * (1.0 + y)) if up else (hinge, 0.0),
            angle=-math.radians(degrees) if up else 0.0,
            color=STEEL,
        )
        anchor_a, anchor_b = (hinge, 0.0), (0.0, length)
        scene.add_joint(f"hinge_{k}", Revolute("frame", f"ball_{k}", anchor_a=anchor_a, anchor_b=anchor_b))
    return scene
