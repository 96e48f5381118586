"""What the random scenes of the stress tests are made of: cases, bodies of random shapes, options."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import Options, Scene
from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon

Array = NDArray[np.float64]
Rng = np.random.Generator

FLAT = ("circle", "box")  # shapes without vertices
SOLID = ("circle", "box", "capsule", "polygon")


@dataclass(frozen=True)
class Case:
    """A scene, how to step it, and what of it is promised."""

    seed: int
    category: str
    scene: Scene
    options: Options
    driven: bool
    overlapping: bool
    drive_speed: float = 0.0  # m/s, fastest thing that drives it
    slack: float = 0.0  # m, how far joints may draw bodies that start apart
    pushes: float = 0.0  # m/s^2, of random forces at the start


@dataclass
class Build:
    """A scene in the making: what is drawn once for all its bodies."""

    rng: Rng
    scene: Scene
    kinds: tuple[str, ...]
    size: float  # m, typical half-width
    friction: tuple[float, float]
    restitution: tuple[float, float]
    density: tuple[float, float] = (1.0, 1.0)  # kg/m^2, drawn log-uniformly
    slender: bool = False
    fast: bool = False
    count: int = 0

    def material(self) -> dict[str, Any]:
        return {
            "friction": float(self.rng.uniform(*self.friction)),
            "restitution": float(self.rng.uniform(*self.restitution)),
        }

    def shape(self, kind: str | None = None, size: float | None = None, **place: Any) -> tuple[Any, float]:
        """(shape, bounding radius in m)."""
        rng = self.rng
        kind = str(rng.choice(self.kinds)) if kind is None else kind
        size = self.size * float(rng.uniform(0.5, 1.5)) if size is None else size
        common: dict[str, Any] = {**self.material(), "density": log_uniform(rng, *self.density), **place}
        if kind == "circle":
            return Circle(radius=size, **common), size
        if kind == "capsule":
            half = size * float(rng.uniform(0.5, 3.0))
            radius = size * (0.05 if self.slender else float(rng.uniform(0.2, 0.8)))
            return Capsule(half_length=half, radius=radius, **common), half + radius
        if kind == "polygon":
            points = random_polygon(rng, size)
            if self.slender:
                points[:, 1] *= 0.05
            return Polygon(vertices=points, **common), float(np.hypot(*points.T).max())
        hx, hy = size, size * float(rng.uniform(0.3, 1.0))
        if self.slender:
            hy = size * log_uniform(rng, 0.01, 0.1)
        return Box(half_extents=(hx, hy), **common), math.hypot(hx, hy)

    def add(self, shapes: list[Any], **body: Any) -> None:
        self.scene.add_body(f"body_{self.count}", shapes=shapes, continuous=self.fast, **body)
        self.count += 1


def log_uniform(rng: Rng, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def random_polygon(rng: Rng, size: float) -> Array:
    """3 to 8 corners on an ellipse, never in line."""
    corners = int(rng.integers(3, 9))
    angles = (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) * 2.0 * np.pi / corners
    return np.asarray(size * np.stack([np.cos(angles), rng.uniform(0.5, 1.0) * np.sin(angles)], 1))


def random_options(rng: Rng) -> Options:
    """Half of the cases at the default options, all with a timestep from 1e-4 to 1/20 s."""
    timestep = 1.0 / 60.0 if rng.random() < 0.3 else log_uniform(rng, 1e-4, 1.0 / 20.0)
    if rng.random() < 0.5:
        return Options(timestep=timestep)
    return Options(
        timestep=timestep,
        substeps=int(rng.integers(1, 5)),
        solver=str(rng.choice(["subspace", "subspace", "nncg", "pgs"])),
        sweeps=int(rng.integers(10, 61)),
        tolerance=log_uniform(rng, 1e-6, 1e-3),
        position_sweeps=int(rng.integers(1, 5)),
        warm_start=bool(rng.random() < 0.9),
        sleep=bool(rng.random() < 0.7),
    )


def random_target(rng: Rng, kind: Any, body: str) -> tuple[Any, float]:
    """(a target joint of a body, its frequency in Hz); ``kind`` is the Target of a dimension."""
    frequency = log_uniform(rng, 0.5, 20.0)
    bound = float(np.inf) if rng.random() < 0.3 else log_uniform(rng, 1.0, 1e4)
    ratio = float(rng.uniform(0.1, 2.0))
    return kind(body, frequency=frequency, damping_ratio=ratio, max_force=bound, max_torque=bound), frequency


def ground(build: Build, width: float, walls: bool | None = None) -> None:
    """The half-plane y <= 0 or a static box under it, and sometimes walls."""
    rng = build.rng
    material = build.material()
    if rng.random() < 0.8 or walls:
        build.scene.add_body("ground", "static", [HalfPlane(**material)])
    else:
        box = Box(half_extents=(20.0 * width, 1.0), **material)
        build.scene.add_body("ground", "static", [box], position=(0.0, -1.0))
    if walls or (walls is None and rng.random() < 0.3):
        for side in (-1.0, 1.0):
            wall = HalfPlane(normal=(-side, 0.0), offset=-width, **material)
            build.scene.add_body(f"wall_{side:.0f}", "static", [wall])


def scatter(build: Build, count: int, speed: float, spin: float, lift: float = 0.0) -> float:
    """Bodies in the cells of a grid, none touching another. Returns the half-width in m."""
    rng = build.rng
    drawn = [build.shape() for _ in range(count)]
    pitch = 2.05 * max(radius for _, radius in drawn)
    columns = max(1, round(math.sqrt(count) * float(rng.uniform(0.5, 1.5))))
    for k, (shape, radius) in enumerate(drawn):
        spare = 0.5 * pitch - radius
        x = (k % columns - 0.5 * (columns - 1)) * pitch + float(rng.uniform(-spare, spare))
        y = (k // columns + 0.5) * pitch + float(rng.uniform(-spare, spare)) + lift
        build.add(
            [shape],
            position=(x, y),
            angle=float(rng.uniform(-np.pi, np.pi)),
            linear_velocity=rng.normal(0.0, speed, 2).tolist(),
            angular_velocity=float(rng.normal(0.0, spin)),
        )
    return (0.5 * columns + 1.0) * pitch
