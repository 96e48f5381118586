"""Random scenes of bodies and contacts that try to break the solver.

``random_case(seed)`` is a function of the seed alone; measure.py says what is promised of it.
"""

from __future__ import annotations

import math

import numpy as np

from gsenv.solver import Options, Scene
from gsenv.solver.planar import Box, Circle, Target, Terrain, Weld

from .cases import FLAT, SOLID, Build, Case, ground, log_uniform, random_options, random_target, scatter

CATEGORIES = (
    "loose", "boxes", "stacked", "overlap", "ratio", "bouncy", "spinning", "fast", "thin",
    "terrain", "welds", "friction", "targets", "kinematic", "mixed",
)  # fmt: skip
DRIVEN = ("targets", "kinematic")
DRIVEN = ("targets", "kinematic")


def random_case(seed: int, category: str | None = None) -> Case:
    """The case of a seed; its category follows from the seed unless it is given."""
    rng = np.random.default_rng(seed)
    category = CATEGORIES[seed % len(CATEGORIES)] if category is None else category
    options = random_options(rng)
    pull = float(rng.choice([9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 0.0, 50.0]))
    build = Build(
        rng,
        Scene(gravity=(0.0, -pull)),
        kinds=FLAT if category in ("boxes", "stacked") else SOLID,
        size=log_uniform(rng, 0.05, 1.0),
        friction=(0.0, 2.0) if category == "friction" else (0.2, 0.8),
        restitution=(0.0, 0.0),
    )
    if rng.random() < 0.2:
        build.friction = (0.0, 0.0)
    if category == "bouncy":
        build.restitution = (0.0, 1.0)
        if rng.random() < 0.25:
            build.restitution = (1.0, 1.0)
    if category == "mixed":
        build.restitution = (0.0, 1.0)
        build.friction = (0.0, 2.0)
        build.density = (1e-2, 1e2)
    if category == "ratio":
        build.density = (1e-3, 1e3)
    build.slender = category == "thin"
    build.fast = category == "fast" and bool(rng.random() < 0.5)
    return _BUILDERS.get(category, _fill_loose)(seed, category, options, build)


def _case(
    seed: int, category: str, options: Options, build: Build, overlapping: bool = False, drive: float = 0.0
) -> Case:
    driven = category in DRIVEN
    return Case(seed, category, build.scene, options, driven, overlapping, drive)


def _fill_loose(seed: int, category: str, options: Options, build: Build) -> Case:
    """Bodies in the air that fall: loose, boxes, ratio, bouncy, spinning, fast, thin, friction."""
    rng = build.rng
    count = int(rng.integers(3, 16))
    speed = {"fast": log_uniform(rng, 10.0, 300.0)}.get(category, log_uniform(rng, 0.1, 5.0))
    spin = {"spinning": log_uniform(rng, 10.0, 500.0)}.get(category, 2.0)
    width = scatter(build, count, speed, spin, lift=float(rng.uniform(0.0, 2.0)) * build.size)
    ground(build, width, walls=True if category == "fast" else None)
    return _case(seed, category, options, build)


def _fill_stacked(seed: int, category: str, options: Options, build: Build) -> Case:
    """Towers of boxes that touch, with offsets up to where they fall, sometimes hit by a ball."""
    rng = build.rng
    y = 0.0
    x = 0.0
    lean = float(rng.uniform(0.0, 0.6))
    ratio = float(rng.choice([1.0, 10.0, 1000.0]))
    for _ in range(int(rng.integers(3, 16))):
        hx, hy = build.size * rng.uniform(0.5, 1.5, 2)
        box = Box(half_extents=(float(hx), float(hy)), density=log_uniform(rng, 1.0, ratio), **build.material())
        build.add([box], position=(x, y + hy))
        y += 2.0 * float(hy)
        x += float(rng.normal(0.0, lean)) * float(hx)
    if rng.random() < 0.5:
        ball = Circle(radius=build.size, **build.material())
        speed = log_uniform(rng, 1.0, 50.0)
        place = (-8.0 * build.size - abs(x) - 10.0 * build.size, 0.5 * y + build.size)
        build.add([ball], position=place, linear_velocity=(speed, 0.0))
    ground(build, 40.0 * build.size)
    return _case(seed, category, options, build)


def _fill_overlap(seed: int, category: str, options: Options, build: Build) -> Case:
    """Bodies that start inside each other, from shallow to all in one place."""
    rng = build.rng
    count = int(rng.integers(3, 21))
    spread = build.size * float(rng.choice([0.0, 0.3, 1.0, 2.0]))
    for _ in range(count):
        shape, radius = build.shape()
        x, y = rng.uniform(-spread, spread, 2)
        build.add([shape], position=(x, abs(y) + radius * float(rng.uniform(0.5, 1.0))))
    ground(build, 20.0 * build.size)
    return _case(seed, category, options, build, overlapping=True)


def _fill_ratio(seed: int, category: str, options: Options, build: Build) -> Case:
    """Masses from 1e-3 to 1e3 kg, a heavy body on a light one among them."""
    rng = build.rng
    width = scatter(build, int(rng.integers(3, 13)), log_uniform(rng, 0.1, 5.0), 2.0, lift=4.0 * build.size)
    half = build.size
    x = 3.0 * width
    for k, mass in enumerate(rng.permutation([1.0, log_uniform(rng, 10.0, 1e6)])):
        box = Box(half_extents=(half, half), **build.material())
        build.add([box], position=(x, (2 * k + 1) * half), mass=float(mass))
    ground(build, 5.0 * width)
    return _case(seed, category, options, build)


def _fill_terrain(seed: int, category: str, options: Options, build: Build) -> Case:
    """Bodies that fall on a rough chain of segments."""
    rng = build.rng
    width = scatter(build, int(rng.integers(3, 13)), log_uniform(rng, 0.1, 5.0), 5.0)
    knots = int(rng.integers(4, 60))
    x = np.linspace(-2.0 * width, 2.0 * width, knots)
    x[1:-1] += rng.uniform(-0.4, 0.4, knots - 2) * 4.0 * width / knots
    rough = build.size * float(rng.uniform(0.0, 3.0))
    y = rng.uniform(-rough, 0.0, knots)
    y[[0, -1]] = 20.0 * build.size  # a bowl
    chain = Terrain(vertices=np.stack([x, y], 1), **build.material())
    build.scene.add_body("terrain", "static", [chain])
    return _case(seed, category, options, build, overlapping=True)  # with the walls of the bowl


def _fill_welds(seed: int, category: str, options: Options, build: Build) -> Case:
    """Chains of welded bodies, rigid and soft, and bodies of several shapes."""
    rng = build.rng
    size = build.size
    soft = rng.random() < 0.5
    y = 2.0 * size
    for _ in range(int(rng.integers(1, 4))):
        links = int(rng.integers(2, 6))
        for k in range(links):
            shape, _ = build.shape(size=0.45 * size, kind=str(rng.choice(["circle", "box", "polygon"])))
            build.add([shape], position=(k * 1.3 * size, y), linear_velocity=rng.normal(0.0, 2.0, 2).tolist())
            if k > 0:
                a, b = build.count - 2, build.count - 1
                anchor = ((k - 0.5) * 1.3 * size, y)
                frequency = log_uniform(rng, 0.5, 30.0) if soft else 0.0
                ratio = float(rng.uniform(0.0, 2.0))
                build.scene.add_joint(
                    f"weld_{b}", Weld(f"body_{a}", f"body_{b}", anchor=anchor, frequency=frequency, damping_ratio=ratio)
                )
        y += 2.5 * size
    two = [Box(half_extents=(size, 0.2 * size)), Circle(radius=0.5 * size, position=(size, 0.3 * size))]
    build.add(two, position=(0.0, y + 2.0 * size), angular_velocity=float(rng.normal(0.0, 5.0)))
    ground(build, 20.0 * size)
    return _case(seed, category, options, build)


def _fill_targets(seed: int, category: str, options: Options, build: Build) -> Case:
    """Bodies pulled through a heap by targets that move."""
    rng = build.rng
    width = scatter(build, int(rng.integers(4, 11)), 1.0, 2.0)
    drive = 0.0
    for k in range(int(rng.integers(1, 4))):
        name = f"target_{k}"
        target, frequency = random_target(rng, Target, f"body_{k}")
        build.scene.add_joint(name, target)
        build.scene.add_actuator(name + "_x", name, "x", "velocity", -5.0, 5.0)
        build.scene.add_actuator(name + "_y", name, "y", "position", 0.0, 2.0 * width)
        drive = max(drive, 5.0 + 2.0 * np.pi * frequency * 2.0 * width)
    ground(build, 2.0 * width)
    return _case(seed, category, options, build, drive=drive)


def _fill_kinematic(seed: int, category: str, options: Options, build: Build) -> Case:
    """A heap that kinematic bodies sweep through, spin in and press."""
    rng = build.rng
    width = scatter(build, int(rng.integers(4, 13)), 1.0, 2.0)
    drive = 0.0
    for k in range(int(rng.integers(1, 4))):
        shape, radius = build.shape(size=2.0 * build.size)
        velocity = rng.normal(0.0, 3.0, 2)
        spin = float(rng.normal(0.0, 3.0))
        side = float(rng.choice([-1.0, 1.0])) * (width + 2.0 * radius)
        build.scene.add_body(
            f"mover_{k}", "kinematic", [shape], position=(side, float(rng.uniform(0.0, width))),
            linear_velocity=(-math.copysign(velocity[0], side), velocity[1]), angular_velocity=spin,
        )  # fmt: skip
        drive = max(drive, float(np.hypot(*velocity)) + abs(spin) * radius)
    ground(build, 3.0 * width)
    return _case(seed, category, options, build, drive=drive)


_BUILDERS = {
    "stacked": _fill_stacked,
    "overlap": _fill_overlap,
    "ratio": _fill_ratio,
    "terrain": _fill_terrain,
    "welds": _fill_welds,
    "targets": _fill_targets,
    "kinematic": _fill_kinematic,
}
