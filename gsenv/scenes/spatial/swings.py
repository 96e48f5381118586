"""Things that hang from ball joints: pendulums, chains, a cradle, a gyroscope."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from gsenv.solver import Scene
from gsenv.solver.spatial.shapes import Capsule, Cylinder, Sphere

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
    """Uniform rods in one line from the static body "hook" at the origin, joined by ball joints; a rod's z axis
    points back to the hook."""
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
            rotation=rotation,
            mass=mass,
            inertia=(across, across, 0.5 * mass * radius**2),
            color=colors[k % len(colors)],
        )
    for k, (upper, lower) in enumerate(pairwise(["hook", *names])):
        scene.add_joint(f"joint_{k}", "ball", upper, lower, anchor=along(ORIGIN, k * length, direction))


def rod_pendulum(degrees: float = 120.0, length: float = 1.0, heading: float = 0.0, point: bool = False) -> Scene:
    """1 kg hung from the origin, at rest ``degrees`` from hanging: a uniform rod of ``length`` m on a ball joint, or
    a point mass on a massless rod of that length."""
    scene = Scene(dim=3)
    scene.add_body("hook", kind="static")
    if point:
        ball = Sphere(radius=0.1 * length)
        scene.add_body("bob", shapes=[ball], position=along(ORIGIN, length, hanging(degrees, heading)), mass=1.0)
        scene.add_joint("rod", "distance", "hook", "bob", anchor_a=ORIGIN, anchor_b=ORIGIN)
    else:
        _rods(scene, degrees, heading, length, [1.0], [0.04 * length], [WARM])
    return scene


def two_rods(degrees: float = 90.0, length: float = 1.0, heading: float = 0.0) -> Scene:
    """Two uniform rods of ``length`` m and 1 kg in one line on ball joints, at rest ``degrees`` from hanging."""
    scene = Scene(dim=3)
    scene.add_body("hook", kind="static")
    _rods(scene, degrees, heading, length, [1.0, 1.0], [0.05 * length] * 2, [WARM, AMBER])
    return scene


def ball_chain(
    count: int = 20, link: float = 0.25, degrees: float = 30.0, last_mass: float = 100.0, heading: float = 0.0
) -> Scene:
    """``count`` uniform rods of ``link`` m and 1 kg, the last of ``last_mass`` kg, hung from the origin on ball joints
    and released in one straight line ``degrees`` from hanging."""
    scene = Scene(dim=3)
    scene.add_body("hook", kind="static")
    masses = [1.0] * (count - 1) + [last_mass]
    radii = [0.1 * link * mass**0.25 for mass in masses]  # a heavy link looks heavy
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
    """``count`` touching balls in a row along x, without friction, each rigid with an arm that a ball joint holds
    ``length`` m above its middle; the ``raised`` leftmost ones start ``degrees`` to the left, at rest. ``arms``
    draws the arms: no mass, touch nothing."""
    scene = Scene(dim=3)
    beam = Capsule(half_length=radius * (count + 1), radius=0.4 * radius, mask=0, rotation=about(1, 90.0))
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
            rotation=about(1, -angle),
            color=STEEL,
        )
        scene.add_joint(f"joint_{k}", "ball", "frame", f"ball_{k}", anchor=hinge)
    return scene


def gyroscope(spin: float = 200.0, radius: float = 0.1, arm: float = 0.1, gravity: float = 9.81) -> Scene:
    """A thin disk of 1 kg on a massless level arm of ``arm`` m that a ball joint at the origin holds, spinning at
    ``spin`` rad/s about the arm and already precessing as it should: m g d / (I spin) rad/s about z."""
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
        rotation=about(1, 90.0),  # its axis along x
        mass=1.0,
        inertia=(across, across, axial),
        linear_velocity=(0.0, turn * arm, 0.0),
        angular_velocity=(spin, 0.0, turn),
    )
    scene.add_joint("joint", "ball", "hook", "disk", anchor=ORIGIN)
    return scene


def precession(spin: float = 200.0, radius: float = 0.1, arm: float = 0.1, gravity: float = 9.81) -> float:
    """rad/s of the gyroscope's arm, exact for a level one."""
    return 2.0 * gravity * arm / (radius**2 * spin)


def small_period(length: float = 1.0) -> float:
    """s, of a uniform rod of ``length`` m that swings by little."""
    return 2.0 * math.pi * math.sqrt(length / (1.5 * 9.81))
