"""Random scenes in 3D that try to break the solver.

``random_spatial_case(seed)`` is a function of the seed alone; measure.py says what is promised of it.
All scenes share one variant of the step kernel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.spatial import Ball, Box, Capsule, Cylinder, Distance, Heightfield, Hull, Plane, Sphere, Target, Weld
from tests.solver.spatial.one_kernel import complete

from .cases import Array, Build, Case, Rng, log_uniform, random_options, random_target
from .measure import PUSHED

CATEGORIES = (
    "loose", "stacked", "overlap", "ratio", "bouncy", "spinning", "fast", "thin", "field", "chains", "springs",
    "friction", "targets", "kinematic", "pushed", "mixed",
)  # fmt: skip
DRIVEN = ("targets", "kinematic", "pushed")
TURNING = 0.2  # share of bodies with torsional and rolling friction
SOLID = ("sphere", "box", "capsule", "cylinder", "hull")


@dataclass
class SpatialBuild(Build):
    """As Build, of spatial shapes."""

    def material(self) -> dict[str, Any]:
        material = super().material()
        if self.rng.random() < TURNING:
            material["torsional_friction"] = 0.1 * self.size * float(self.rng.random())
            material["rolling_friction"] = 0.1 * self.size * float(self.rng.random())
        return material

    def shape(self, kind: str | None = None, size: float | None = None, **place: Any) -> tuple[Any, float]:
        """(shape, bounding radius in m)."""
        rng = self.rng
        kind = str(rng.choice(self.kinds)) if kind is None else kind
        size = self.size * float(rng.uniform(0.5, 1.5)) if size is None else size
        common: dict[str, Any] = {**self.material(), "density": log_uniform(rng, *self.density), **place}
        if kind == "sphere":
            return Sphere(radius=size, **common), size
        if kind in ("capsule", "cylinder"):
            half = size * float(rng.uniform(0.5, 2.0)) if kind == "capsule" else size * log_uniform(rng, 0.1, 3.0)
            radius = size * (0.05 if self.slender else float(rng.uniform(0.2, 0.8)))
            if kind == "capsule":
                return Capsule(half_length=half, radius=radius, **common), half + radius
            return Cylinder(half_length=half, radius=radius, **common), math.hypot(half, radius)
        if kind == "hull":
            points = random_hull(rng, size)
            points[:, 2] *= 0.05 if self.slender else 1.0
            return Hull(vertices=points, **common), float(np.hypot.reduce(points, axis=1).max())
        half_extents = size * rng.uniform(0.3, 1.0, 3)
        if self.slender:
            half_extents[2] = size * log_uniform(rng, 0.01, 0.1)
        return Box(half_extents=half_extents.tolist(), **common), float(np.hypot.reduce(half_extents))


def random_hull(rng: Rng, size: float) -> Array:
    """The corners of a box, one of them off its place, or 4 to 20 points near a ball's surface."""
    if rng.random() < 0.3:
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        corners *= size * rng.uniform(0.3, 0.6, 3)
        corners[0] *= rng.uniform(0.3, 1.0)
        return corners
    tetrahedron = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
    points = np.concatenate([tetrahedron, rng.normal(size=(int(rng.integers(0, 17)), 3))])
    points /= np.hypot.reduce(points, axis=1)[:, None]
    return np.asarray(size * points * rng.uniform(0.8, 1.0, (len(points), 1)))


def random_turn(rng: Rng) -> list[float]:
    """A quaternion of any rotation, or one along the axes."""
    return rng.normal(size=4).tolist() if rng.random() < 0.8 else [1.0, 0.0, 0.0, 0.0]


def ground(build: SpatialBuild, width: float, walls: bool | None = None) -> None:
    """The plane z = 0 or a static box under it, and sometimes walls."""
    rng = build.rng
    material = build.material()
    if rng.random() < 0.7 or walls:
        build.scene.add_body("ground", "static", [Plane(**material)])
    else:
        kind = Box(half_extents=(20.0 * width, 20.0 * width, 1.0), **material)
        build.scene.add_body("ground", "static", [kind], position=(0.0, 0.0, -1.0))
    if walls or (walls is None and rng.random() < 0.3):
        for k, normal in enumerate([(1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0)]):
            build.scene.add_body(f"wall_{k}", "static", [Plane(normal=normal, offset=-width, **material)])


def scatter(build: SpatialBuild, count: int, speed: float, spin: float, lift: float = 0.0) -> float:
    """Bodies in the cells of a grid, none touching another. Returns the half-width in m."""
    rng = build.rng
    drawn = [build.shape() for _ in range(count)]
    pitch = 2.05 * max(radius for _, radius in drawn)
    side = max(1, round(count ** (1.0 / 3.0) * float(rng.uniform(0.7, 1.5))))
    for k, (shape, radius) in enumerate(drawn):
        cell = np.array([k % side - 0.5 * (side - 1), k // side % side - 0.5 * (side - 1), k // side**2 + 0.5])
        place = cell * pitch + rng.uniform(-1.0, 1.0, 3) * (0.5 * pitch - radius) + (0.0, 0.0, lift)
        build.add(
            [shape],
            position=place.tolist(),
            orientation=random_turn(rng),
            linear_velocity=rng.normal(0.0, speed, 3).tolist(),
            angular_velocity=rng.normal(0.0, spin, 3).tolist(),
        )
    return (0.5 * side + 1.0) * pitch


def random_spatial_case(seed: int, category: str | None = None) -> Case:
    """The case of a seed; its category follows from the seed unless it is given."""
    rng = np.random.default_rng([seed, 5])
    category = CATEGORIES[seed % len(CATEGORIES)] if category is None else category
    options = random_options(rng)
    pull = float(rng.choice([9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 0.0, 50.0]))
    build = SpatialBuild(
        rng,
        Scene(dim=3, gravity=(0.0, 0.0, -pull)),
        kinds=SOLID,
        size=log_uniform(rng, 0.05, 2.0),
        friction=(0.0, 2.0) if category in ("friction", "mixed") else (0.2, 0.8),
        restitution=(0.0, 1.0) if category in ("bouncy", "mixed") else (0.0, 0.0),
    )
    if rng.random() < 0.2:
        build.friction = (0.0, 0.0)
    if category == "bouncy" and rng.random() < 0.25:
        build.restitution = (1.0, 1.0)
    if category in ("ratio", "mixed"):
        build.density = (0.03, 30.0)
    build.slender = category == "thin"
    build.fast = category in ("fast", "thin") and bool(rng.random() < 0.5)
    drive, slack = _BUILDERS.get(category, _fill_loose)(build, category)
    pushes = log_uniform(rng, 1.0, 300.0) if category == "pushed" else 0.0
    if pushes:
        drive = 2.0 * PUSHED * options.timestep * pushes
    overlapping = category in ("overlap", "field", "chains", "springs")  # a bowl's rim may reach into bodies
    driven = category in DRIVEN
    return Case(seed, category, complete(build.scene), options, driven, overlapping, drive, slack, pushes)


def _fill_loose(build: SpatialBuild, category: str) -> tuple[float, float]:
    """Bodies in the air that fall: loose, ratio, bouncy, spinning, fast, thin, friction, pushed."""
    rng = build.rng
    speed = {"fast": log_uniform(rng, 10.0, 300.0)}.get(category, log_uniform(rng, 0.1, 5.0))
    spin = {"spinning": log_uniform(rng, 10.0, 300.0)}.get(category, 2.0)
    width = scatter(build, int(rng.integers(3, 13)), speed, spin, lift=float(rng.uniform(0.0, 2.0)) * build.size)
    if category == "ratio":
        half = build.size
        for k, mass in enumerate(rng.permutation([1.0, log_uniform(rng, 10.0, 1e3)])):
            box = Box(half_extents=(half, half, half), **build.material())
            build.add([box], position=(3.0 * width, 0.0, (2 * k + 1) * half), mass=float(mass))
    ground(build, 5.0 * width if category == "ratio" else width, walls=True if category == "fast" else None)
    return 0.0, 0.0


def _fill_stacked(build: SpatialBuild, category: str) -> tuple[float, float]:
    """Towers of boxes, drums and prisms that touch, with offsets up to where they fall, sometimes hit by a ball."""
    rng = build.rng
    top = np.zeros(3)
    lean = float(rng.uniform(0.0, 0.6))
    ratio = float(rng.choice([1.0, 10.0, 100.0]))
    for _ in range(int(rng.integers(3, 11))):
        hx, hy, hz = (float(h) for h in build.size * rng.uniform(0.5, 1.5, 3))
        common = {"density": log_uniform(rng, 1.0, ratio), **build.material()}
        kind = rng.random()
        if kind < 0.6:
            shape: Any = Box(half_extents=(hx, hy, hz), **common)
        elif kind < 0.8:
            shape = Cylinder(half_length=hz, radius=hx, **common)
        else:
            corners = [(x, y, z) for x in (-hx, hx) for y in (-hy, hy) for z in (-hz, hz)]
            shape = Hull(vertices=corners, **common)
        build.add([shape], position=(top[0], top[1], top[2] + hz), orientation=(1.0, 0.0, 0.0, float(rng.normal())))
        top += (*(rng.normal(0.0, lean, 2) * min(hx, hy)), 2.0 * hz)
    if rng.random() < 0.5:
        ball = Sphere(radius=build.size, **build.material())
        place = (-20.0 * build.size - abs(top[0]), float(top[1]), 0.5 * float(top[2]) + build.size)
        build.add([ball], position=place, linear_velocity=(log_uniform(rng, 1.0, 50.0), 0.0, 0.0))
    ground(build, 60.0 * build.size)
    return 0.0, 0.0


def _fill_overlap(build: SpatialBuild, category: str) -> tuple[float, float]:
    """Bodies that start inside each other, from shallow to all in one place."""
    rng = build.rng
    spread = build.size * float(rng.choice([0.0, 0.3, 1.0, 2.0]))
    for _ in range(int(rng.integers(3, 13))):
        shape, radius = build.shape()
        x, y, z = rng.uniform(-spread, spread, 3)
        z = abs(z) + radius * float(rng.uniform(0.5, 1.0))
        build.add([shape], position=(x, y, z), orientation=random_turn(rng))
    ground(build, 20.0 * build.size)
    return 0.0, 0.0


def _fill_field(build: SpatialBuild, category: str) -> tuple[float, float]:
    """Bodies that fall into a rough bowl."""
    rng = build.rng
    width = scatter(build, int(rng.integers(3, 11)), log_uniform(rng, 0.1, 5.0), 5.0, lift=0.2 * build.size)
    knots = int(rng.integers(3, 20))
    x = np.linspace(-2.0 * width, 2.0 * width, knots)
    rim = np.maximum(abs(x)[:, None], abs(x)[None])
    heights = rng.uniform(-1.0, 0.0, (knots, knots)) * build.size * float(rng.uniform(0.0, 2.0))
    heights = np.where(rim > 1.99 * width, 20.0 * build.size, heights)
    field = Heightfield(heights=heights, size=(4.0 * width, 4.0 * width), **build.material())
    build.scene.add_body("field", "static", [field])
    return 0.0, 0.0


def _fill_joints(build: SpatialBuild, category: str) -> tuple[float, float]:
    """Scattered bodies joined into chains, trees and rings, some hung from the world."""
    rng = build.rng
    count = int(rng.integers(2, 11))
    start = build.count
    # springs start at rest: one far too stiff for the timestep would store what the first step stretches it
    speed, spin = (0.0, 0.0) if category == "springs" else (log_uniform(rng, 0.1, 5.0), 2.0)
    width = scatter(build, count, speed, spin, lift=float(rng.uniform(0.0, 4.0)) * build.size)
    build.scene.add_body("hook", "static", position=(0.0, 0.0, 4.0 * width))
    bodies = list(build.scene.bodies.values())
    names = [f"body_{start + k}" for k in range(count)]
    links = [(names[int(rng.integers(max(0, k - 2), k))], names[k]) for k in range(1, count)]
    if rng.random() < 0.3 and count > 2:
        links.append((names[0], names[-1]))  # a ring
    if rng.random() < 0.5:
        links.append(("hook", names[0]))
    place = {spec.name: spec.position for spec in bodies}
    for k, (a, b) in enumerate(links):
        middle = 0.5 * (place[a] + place[b])
        _random_joint(build, f"joint_{k}", a, b, middle, soft=category == "springs")
    ground(build, 5.0 * width, walls=False)
    return 0.0, 0.0


def _random_joint(build: SpatialBuild, name: str, a: str, b: str, middle: Array, soft: bool) -> None:
    rng = build.rng
    kind = str(rng.choice(["weld", "distance"] if soft else ["ball", "ball", "weld", "rod", "rope"]))
    # not by frequency: that spring is as stiff as the turning bodies' mass in it asks for, and stores no fixed energy
    stiffness = 20.0 * build.size**3 * log_uniform(rng, 0.5, 30.0) ** 2
    spring: dict[str, Any] = (
        {"stiffness": stiffness, "damping": stiffness * log_uniform(rng, 1e-3, 0.1)} if soft else {}
    )
    if kind == "rope":
        apart = build.scene.bodies[a].position - build.scene.bodies[b].position
        spring = {"limits": (0.0, float(np.hypot.reduce(apart) * rng.uniform(1.0, 1.5)))}
    joints: dict[str, Any] = {"ball": Ball, "weld": Weld}
    anchor = {"anchor": middle} if kind in joints else {}
    build.scene.add_joint(name, joints.get(kind, Distance)(a, b, **anchor, **spring))


def _fill_targets(build: SpatialBuild, category: str) -> tuple[float, float]:
    """Bodies pulled through a heap by targets that move and turn."""
    rng = build.rng
    width = scatter(build, int(rng.integers(4, 11)), 1.0, 2.0)
    drive = 0.0
    for k in range(int(rng.integers(1, 4))):
        name = f"target_{k}"
        target, frequency = random_target(rng, Target, f"body_{k}")
        build.scene.add_joint(name, target)
        build.scene.add_actuator(name + "_x", name, "x", "velocity", -5.0, 5.0)
        build.scene.add_actuator(name + "_z", name, "z", "position", 0.0, 2.0 * width)
        build.scene.add_actuator(name + "_turn", name, str(rng.choice(["turn_x", "turn_y", "turn_z"])), "velocity")
        drive = max(drive, 5.0 + 5.0 * width + 2.0 * np.pi * frequency * 2.0 * width)
    ground(build, 2.0 * width)
    return drive, 0.0


def _fill_kinematic(build: SpatialBuild, category: str) -> tuple[float, float]:
    """A heap that kinematic bodies sweep through, spin in and press."""
    rng = build.rng
    width = scatter(build, int(rng.integers(4, 11)), 1.0, 2.0)
    drive = 0.0
    for k in range(int(rng.integers(1, 4))):
        shape, radius = build.shape(size=2.0 * build.size)
        velocity, spin = rng.normal(0.0, 3.0, (2, 3))
        side = float(rng.choice([-1.0, 1.0])) * (width + 2.0 * radius)
        velocity[0] = -math.copysign(velocity[0], side)
        build.scene.add_body(
            f"mover_{k}", "kinematic", [shape], position=(side, 0.0, float(rng.uniform(0.0, width))),
            orientation=random_turn(rng), linear_velocity=velocity.tolist(), angular_velocity=spin.tolist(),
        )  # fmt: skip
        drive = max(drive, float(np.hypot.reduce(velocity) + np.hypot.reduce(spin) * radius))
    ground(build, 3.0 * width)
    return drive, 0.0


_BUILDERS = {
    "stacked": _fill_stacked,
    "overlap": _fill_overlap,
    "field": _fill_field,
    "chains": _fill_joints,
    "springs": _fill_joints,
    "targets": _fill_targets,
    "kinematic": _fill_kinematic,
}
