"""Things that swing from hinges: one, two, and five that touch."""

from __future__ import annotations

import math

from gsenv.solver import Box, Capsule, Circle, Scene

from .links import add_links, direction, straight
from .palette import AMBER, GRAPHITE, STEEL, WARM


def pendulum(degrees: float = 120.0, length: float = 1.0, point: bool = False) -> Scene:
    """1 kg on a hinge at the origin, at rest ``degrees`` from hanging: a uniform rod of ``length`` m, or a point
    mass on a massless rod of that length."""
    scene = Scene()
    scene.add_body("pivot", kind="static")
    points = straight((0.0, 0.0), degrees, length, 1)
    if point:
        scene.add_body("bob", shapes=[Circle(radius=0.1 * length)], position=points[1], mass=1.0)
        scene.add_joint("hinge", "distance", "pivot", "bob", anchor_a=(0.0, 0.0), anchor_b=(0.0, 0.0))
    else:
        add_links(scene, points, 0.04 * length, start="pivot", masses=[1.0], colors=[WARM])
    return scene


def double_pendulum(degrees: float = 90.0, length: float = 1.0) -> Scene:
    """Two uniform rods of ``length`` m and 1 kg in one line, at rest ``degrees`` from hanging."""
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
    """``count`` touching balls without friction, each on a hinge ``length`` m above its middle; the ``raised``
    leftmost ones start ``degrees`` to the left, at rest. ``arms`` draws what holds them: no mass, touches nothing."""
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
        scene.add_joint(f"hinge_{k}", "revolute", "frame", f"ball_{k}", anchor_a=anchor_a, anchor_b=anchor_b)
    return scene
