"""Bodies on ball joints: pendulums, chains, Newton's cradle, a gyroscope."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from gsenv.solver import Scene
from gsenv.solver.spatial import Ball, Capsule, Cylinder, Distance, Sphere

from ..links import LINK, NOT_LINKS
from ..palette import AMBER, GRAPHITE, IRON, STEEL, WARM, Rgb
from .turning import about, after, along, hanging

ORIGIN = (0.0, 0.0, 0.0)


def _rods(
    scene: Scene,
    degrees: float,
    heading: float,
    length: float,
    masses: Sequence[float],
    radii: Sequence[float],
    colors: Sequence[Rgb] = IRON,
) -> None:
    """Add uniform rods in a straight line from the static body "hook" at the origin, joined by ball joints.

    The z axis of each rod points back to the hook.
    """
    direction = hanging(degrees, heading)
    rotation = after(about(2, heading), about(1, -degrees))
    names = [f"link_{k}" for k in range(len(masses))]
    for k, (mass, radius) in enumerate(zip(masses, radii, strict=True)):
        rod = Capsule(half_length=0.5 * length, radius=radius, category=LINK, mask=NOT_LINKS)
        across = mass * length**2 / 12.0
        scene.add_body(
            names[k],
            shapes=[rod],
            position=along(ORIGIN, (k + 0.5) * length, direction),
            orientation=rotation,
            mass=mass,
            inertia=(across, across, 0.5 * mass * radius**2),
            color=colors[k % len(colors)],
        )
    for k, (upper, lower) in enumerate(pairwise(["hook", *names])):
        scene.add_joint(f"joint_{k}", Ball(upper, lower, anchor=along(ORIGIN, k * length, direction)))


def rod_pendulum(degrees: float = 120.0, length: float = 1.0, heading: float = 0.0, point: bool = False) -> Scene:
    """Build a pendulum of 1 kg on a ball joint at the origin, at rest ``degrees`` from the vertical.

    It is a uniform rod of ``length`` m or, with ``point``, a point mass on a massless rod of that length.
    """
    scene = Scene(dim=3)
    scene.add_body("hook", kind="static")
    if point:
        ball = Sphere(radius=0.1 * length)
        scene.add_body("bob", shapes=[ball], position=along(ORIGIN, length, hanging(degrees, heading)), mass=1.0)
        scene.add_joint("rod", Distance("hook", "bob", anchor_a=ORIGIN, anchor_b=ORIGIN))
    else:
        _rods(scene, degrees, heading, length, [1.0], [0.04 * length], [WARM])
    return scene


def two_rods(degrees: float = 90.0, length: float = 1.0, heading: float = 0.0) -> Scene:
    """Build two uniform rods of ``length`` m and 1 kg on ball joints, straight and at rest.

    They start ``degrees`` from the vertical.
    """
    scene = Scene(dim=3)
    scene.add_body("hook", kind="static")
    _rods(scene, degrees, heading, length, [1.0, 1.0], [0.05 * length] * 2, [WARM, AMBER])
    return scene


def ball_chain(
    count: int = 20, link: float = 0.25, degrees: float = 30.0, last_mass: float = 100.0, heading: float = 0.0
) -> Scene:
    """Build a chain on ball joints that hangs from the origin and is released straight, ``degrees`` from the vertical.

    It has ``count`` uniform rods of length ``link`` m and mass 1 kg; the last one has ``last_mass`` kg.
    """
    scene = Scene(dim=3)
    scene.add_body("hook", kind="static")
    masses = [1.0] * (count - 1) + [last_mass]
    radii = [min(0.1 * link * mass**0.25, 0.5 * link) for mass in masses]  # heavier links are drawn thicker
    _rods(scene, degrees, heading, link, masses, radii)
    return scene


def sphere_cradle(
    raised: int = 1,
    restitution: float = 1.0,
    count: int = 5,
    degrees: float = 30.0,
    radius: float = 0.1,
    length: float = 1.0,
    arms: bool = False,
) -> Scene:
    """Build Newton's cradle: ``count`` touching frictionless balls in a row along x, on ball joints.

    Each ball is rigidly attached to an arm whose ball joint is ``length`` m above its centre. The ``raised`` leftmost
    balls start at rest, ``degrees`` to the left. ``arms`` draws the arms, which have no mass and collide with nothing.
    """
    scene = Scene(dim=3)
    beam = Capsule(half_length=radius * (count + 1), radius=0.4 * radius, mask=0, orientation=about(1, 90.0))
    scene.add_body("frame", kind="static", shapes=[beam], position=(0.0, 0.0, length), color=GRAPHITE)
    ball = Sphere(radius=radius, friction=0.0, restitution=restitution)
    half = 0.5 * (length - radius)
    arm = Capsule(half_length=half, radius=0.1 * radius, position=(0.0, 0.0, radius + half), density=0.0, mask=0)
    for k in range(count):
        hinge = (2.0 * radius * (k - 0.5 * (count - 1)), 0.0, length)
        angle = -degrees if k < raised else 0.0
        scene.add_body(
            f"ball_{k}",
            shapes=[arm, ball] if arms else [ball],
            position=along(hinge, length, hanging(angle)),
            orientation=about(1, -angle),
            color=STEEL,
        )
        scene.add_joint(f"joint_{k}", Ball("frame", f"ball_{k}", anchor=hinge))
    return scene


def gyroscope(spin: float = 200.0, radius: float = 0.1, arm: float = 0.1, gravity: float = 9.81) -> Scene:
    """Build a gyroscope: a thin disk of 1 kg on a massless horizontal arm of ``arm`` m, on a ball joint at the origin.

    The disk spins at ``spin`` rad/s about the arm and starts in steady precession, at m g d / (I spin) rad/s about z.
    """
    scene = Scene(dim=3, gravity=(0.0, 0.0, -gravity))
    scene.add_body("hook", kind="static")
    across, axial = 0.25 * radius**2, 0.5 * radius**2
    turn = gravity * arm / (axial * spin)
    disk = Cylinder(radius=radius, half_length=0.1 * radius)
    rod = Capsule(half_length=0.5 * arm, radius=0.05 * radius, position=(0.0, 0.0, -0.5 * arm), density=0.0, mask=0)
    scene.add_body(
        "disk",
        shapes=[disk, rod],
        position=(arm, 0.0, 0.0),
        orientation=about(1, 90.0),  # the disk's axis is along x
        mass=1.0,
        inertia=(across, across, axial),
        linear_velocity=(0.0, turn * arm, 0.0),
        angular_velocity=(spin, 0.0, turn),
    )
    scene.add_joint("joint", Ball("hook", "disk", anchor=ORIGIN))
    return scene


def precession(spin: float = 200.0, radius: float = 0.1, arm: float = 0.1, gravity: float = 9.81) -> float:
    """Return the gyroscope's rate of steady precession in rad/s, which is exact for a horizontal arm."""
    return 2.0 * gravity * arm / (radius**2 * spin)


def small_period(length: float = 1.0) -> float:
    """Return the period in s of small oscillations of a uniform rod of ``length`` m."""
    return 2.0 * math.pi * math.sqrt(length / (1.5 * 9.81))
