"""Random scenes that try to break the solver, and what is measured on each.

``random_case(seed)`` is a function of the seed alone.  A case that no motor, target or kinematic
body drives is passive: its mechanical energy E (kinetic and gravitational) may not exceed

    E_start + E_overlap + 1e-3 E_scale                                        at the end of any step.

E_scale = E_kin(start) + sum m |g| L, with L the scene's extent: the larger side of the box around
the dynamic bodies at the start and the origin, where the floor is.
E_overlap, the work of raising bodies that start inside each other: a cluster (what overlaps at the
start, plus what may rest on it) costs at most sum over its overlaps of depth times |g| times the
mass above, and at most what a tower of all its bodies costs.  Both are bounds of the work that a
calm separation does; the smaller counts, and it is 0 where nothing overlaps.

Springs of soft welds start relaxed, so what they store only lowers E.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import Box, Capsule, Circle, HalfPlane, Options, Polygon, Scene, Terrain, World

Array = NDArray[np.float64]
Rng = np.random.Generator

STEPS = 200
LIMIT = 1e-3  # of the energy scale
SPEED_LIMIT = 3.0  # of the speed scale, for cases that something drives
CATEGORIES = (
    "loose", "boxes", "stacked", "overlap", "ratio", "bouncy", "spinning", "fast", "thin",
    "terrain", "welds", "friction", "targets", "kinematic", "mixed",
)  # fmt: skip
DRIVEN = ("targets", "kinematic")
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


@dataclass(frozen=True)
class Outcome:
    """What one case did in STEPS steps.

    Attributes:
        excess: largest energy above E_start + E_overlap, over E_scale; NaN for driven cases.
        excess_step: when; excess_unforgiven: the same without E_overlap.
        rise: largest gain above the least energy so far, over E_scale. No promise (a soft weld lets
            go, an overlap is raised) but the measure that finds causes: dissipation can't hide them.
        speed: fastest point of a body at any time over ``speed_scale``.
        finite: nothing became NaN or infinite; error: an exception, in words.
        escaped: dynamic bodies whose centre ended behind a half-plane.
    """

    seed: int
    category: str
    excess: float
    excess_step: int
    excess_unforgiven: float
    rise: float
    rise_step: int
    speed: float
    finite: bool
    error: str
    escaped: int
    unconverged: int


@dataclass
class _Build:
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
        self.scene.add_body(f"body_{self.count}", shapes=shapes, fast=self.fast, **body)
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


def random_case(seed: int, category: str | None = None) -> Case:
    """The case of a seed; its category follows from the seed unless it is given."""
    rng = np.random.default_rng(seed)
    category = CATEGORIES[seed % len(CATEGORIES)] if category is None else category
    options = random_options(rng)
    pull = float(rng.choice([9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 9.81, 0.0, 50.0]))
    build = _Build(
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
    seed: int, category: str, options: Options, build: _Build, overlapping: bool = False, drive: float = 0.0
) -> Case:
    driven = category in DRIVEN
    return Case(seed, category, build.scene, options, driven, overlapping, drive)


def _ground(build: _Build, width: float, walls: bool | None = None) -> None:
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


def _scatter(build: _Build, count: int, speed: float, spin: float, lift: float = 0.0) -> float:
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


def _fill_loose(seed: int, category: str, options: Options, build: _Build) -> Case:
    """Bodies in the air that fall: loose, boxes, ratio, bouncy, spinning, fast, thin, friction."""
    rng = build.rng
    count = int(rng.integers(3, 16))
    speed = {"fast": log_uniform(rng, 10.0, 300.0)}.get(category, log_uniform(rng, 0.1, 5.0))
    spin = {"spinning": log_uniform(rng, 10.0, 500.0)}.get(category, 2.0)
    width = _scatter(build, count, speed, spin, lift=float(rng.uniform(0.0, 2.0)) * build.size)
    _ground(build, width, walls=True if category == "fast" else None)
    return _case(seed, category, options, build)


def _fill_stacked(seed: int, category: str, options: Options, build: _Build) -> Case:
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
    _ground(build, 40.0 * build.size)
    return _case(seed, category, options, build)


def _fill_overlap(seed: int, category: str, options: Options, build: _Build) -> Case:
    """Bodies that start inside each other, from shallow to all in one place."""
    rng = build.rng
    count = int(rng.integers(3, 21))
    spread = build.size * float(rng.choice([0.0, 0.3, 1.0, 2.0]))
    for _ in range(count):
        shape, radius = build.shape()
        x, y = rng.uniform(-spread, spread, 2)
        build.add([shape], position=(x, abs(y) + radius * float(rng.uniform(0.5, 1.0))))
    _ground(build, 20.0 * build.size)
    return _case(seed, category, options, build, overlapping=True)


def _fill_ratio(seed: int, category: str, options: Options, build: _Build) -> Case:
    """Masses from 1e-3 to 1e3 kg, a heavy body on a light one among them."""
    rng = build.rng
    width = _scatter(build, int(rng.integers(3, 13)), log_uniform(rng, 0.1, 5.0), 2.0, lift=4.0 * build.size)
    half = build.size
    x = 3.0 * width
    for k, mass in enumerate(rng.permutation([1.0, log_uniform(rng, 10.0, 1e6)])):
        box = Box(half_extents=(half, half), **build.material())
        build.add([box], position=(x, (2 * k + 1) * half), mass=float(mass))
    _ground(build, 5.0 * width)
    return _case(seed, category, options, build)


def _fill_terrain(seed: int, category: str, options: Options, build: _Build) -> Case:
    """Bodies that fall on a rough chain of segments."""
    rng = build.rng
    width = _scatter(build, int(rng.integers(3, 13)), log_uniform(rng, 0.1, 5.0), 5.0)
    knots = int(rng.integers(4, 60))
    x = np.linspace(-2.0 * width, 2.0 * width, knots)
    x[1:-1] += rng.uniform(-0.4, 0.4, knots - 2) * 4.0 * width / knots
    rough = build.size * float(rng.uniform(0.0, 3.0))
    y = rng.uniform(-rough, 0.0, knots)
    y[[0, -1]] = 20.0 * build.size  # a bowl
    chain = Terrain(vertices=np.stack([x, y], 1), **build.material())
    build.scene.add_body("terrain", "static", [chain])
    return _case(seed, category, options, build)


def _fill_welds(seed: int, category: str, options: Options, build: _Build) -> Case:
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
                frequency = log_uniform(rng, 0.5, 30.0) if soft else None
                ratio = float(rng.uniform(0.0, 2.0))
                build.scene.add_joint(
                    f"weld_{b}", "weld", f"body_{a}", f"body_{b}", anchor=anchor,
                    frequency=frequency, damping_ratio=ratio,
                )  # fmt: skip
        y += 2.5 * size
    two = [Box(half_extents=(size, 0.2 * size)), Circle(radius=0.5 * size, position=(size, 0.3 * size))]
    build.add(two, position=(0.0, y + 2.0 * size), angular_velocity=float(rng.normal(0.0, 5.0)))
    _ground(build, 20.0 * size)
    return _case(seed, category, options, build)


def _fill_targets(seed: int, category: str, options: Options, build: _Build) -> Case:
    """Bodies pulled through a heap by targets that move."""
    rng = build.rng
    width = _scatter(build, int(rng.integers(4, 11)), 1.0, 2.0)
    drive = 0.0
    for k in range(int(rng.integers(1, 4))):
        frequency = log_uniform(rng, 0.5, 20.0)
        bound = float(np.inf) if rng.random() < 0.3 else log_uniform(rng, 1.0, 1e4)
        name = f"target_{k}"
        build.scene.add_joint(
            name, "target", body_b=f"body_{k}", frequency=frequency,
            damping_ratio=float(rng.uniform(0.1, 2.0)), max_force=bound, max_torque=bound,
        )  # fmt: skip
        build.scene.add_actuator(name + "_x", name, "x", "velocity", -5.0, 5.0)
        build.scene.add_actuator(name + "_y", name, "y", "position", 0.0, 2.0 * width)
        drive = max(drive, 5.0 + 2.0 * np.pi * frequency * 2.0 * width)
    _ground(build, 2.0 * width)
    return _case(seed, category, options, build, drive=drive)


def _fill_kinematic(seed: int, category: str, options: Options, build: _Build) -> Case:
    """A heap that kinematic bodies sweep through, spin in and press."""
    rng = build.rng
    width = _scatter(build, int(rng.integers(4, 13)), 1.0, 2.0)
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
    _ground(build, 3.0 * width)
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


# ---------------------------------------------------------------- measures


class EnergyMeter:
    """Energy of one world, its scale and the energy of its initial overlap."""

    def __init__(self, world: World, overlapping: bool = False) -> None:
        self.world = world
        parameters = world.parameters.bodies[0]
        dynamic = (world.model.bodies["kind"] == 2) & (parameters["enabled"] != 0)
        self.dynamic = dynamic
        self.mass = np.where(dynamic, parameters["mass"], 0.0)
        self.inertia = np.where(dynamic, parameters["inertia"], 0.0)
        self.radius = np.where(dynamic, parameters["radius"], 0.0)
        gravity = world.parameters.worlds["gravity"][0]
        self.weight = (self.mass * parameters["gravity_scale"])[:, None] * gravity
        self.pull = float(np.hypot(*gravity))
        place = world.state.bodies["position"][0, dynamic]
        reach = self.radius[dynamic, None]
        lower = np.minimum((place - reach).min(0), 0.0)
        upper = np.maximum((place + reach).max(0), 0.0)
        self.extent = float((upper - lower).max())
        self.kinetic_start = self.kinetic()
        self.start = self.energy()
        self.scale = max(self.kinetic_start + float(self.mass.sum()) * self.pull * self.extent, 1e-12)
        self.overlap = self._overlap_energy() if overlapping else 0.0

    def kinetic(self) -> float:
        v = self.world.state.bodies["velocity"][0]
        return 0.5 * float(self.mass @ (v[:, 0] ** 2 + v[:, 1] ** 2) + self.inertia @ v[:, 2] ** 2)

    def energy(self) -> float:
        return self.kinetic() - float((self.weight * self.world.state.bodies["position"][0]).sum())

    def top_speed(self) -> float:
        """m/s, fastest point of a dynamic body."""
        v = self.world.state.bodies["velocity"][0, self.dynamic]
        return float((np.hypot(v[:, 0], v[:, 1]) + abs(v[:, 2]) * self.radius[self.dynamic]).max())

    def _overlap_energy(self) -> float:
        """J, see the module's docstring. Depths come from a step of no duration."""
        probe = World(self.world.model, options=Options(timestep=1e-12, sleep=False))
        probe.step()
        contacts = probe.contacts(0)
        count = len(self.mass)
        depth: dict[tuple[int, int], float] = {}
        group = np.arange(count)
        for a, b, separation in zip(contacts.body_a, contacts.body_b, contacts.separation, strict=True):
            if separation < 0.0:
                pair = (int(a), int(b))
                depth[pair] = max(depth.get(pair, 0.0), float(-separation))
                if self.dynamic[a] and self.dynamic[b]:
                    group[group == group[b]] = group[a]
        total = 0.0
        height = self.world.state.bodies["position"][0, :, 1]
        for g in np.unique(group[self.dynamic]):
            members = np.flatnonzero((group == g) & self.dynamic)
            tall = np.cumsum(2.0 * self.radius[members[np.argsort(-self.mass[members])]])
            tower = float((np.sort(self.mass[members])[::-1] * tall).sum())
            raised = 0.0
            for (a, b), d in depth.items():
                if a in members or b in members:
                    low = min(height[c] for c in (a, b) if self.dynamic[c])
                    raised += d * float(self.mass[members][height[members] >= low].sum())
            total += min(tower, raised) * self.pull
        return total


def drive(case: Case, world: World, step: int, rng: Rng) -> None:
    """Now and then a new control for a case with targets."""
    if world.control.shape[1] and step % 20 == 0:
        world.control[:] = rng.uniform(-5.0, 5.0, world.control.shape)


def run_case(case: Case, steps: int = STEPS) -> Outcome:
    """Step a case and watch its energy, speeds and numbers after every step."""
    raw = rise = -math.inf
    when = rise_step = -1
    fastest = 0.0
    finite = True
    error = ""
    unconverged = 0
    rng = np.random.default_rng(case.seed + 1)  # of the controls
    world = World(case.scene, options=case.options)
    meter = EnergyMeter(world, case.overlapping)
    least = meter.start
    bodies = world.state.bodies
    for step in range(steps):
        drive(case, world, step, rng)
        try:
            world.step()
        except Exception as problem:  # whatever it is, it is the finding
            error = repr(problem)
            break
        finite = bool(np.isfinite(bodies["position"]).all() and np.isfinite(bodies["velocity"]).all())
        if not finite:
            break
        energy = meter.energy()
        if energy - meter.start > raw:
            raw, when = energy - meter.start, step
        if energy - least > rise:
            rise, rise_step = energy - least, step
        least = min(least, energy)
        fastest = max(fastest, meter.top_speed())
        unconverged += int(world.state.worlds["unconverged"][0])
    excess = (raw - meter.overlap) / meter.scale
    return Outcome(
        seed=case.seed,
        category=case.category,
        excess=math.nan if case.driven else excess,
        excess_step=when,
        excess_unforgiven=raw / meter.scale,
        rise=rise / meter.scale,
        rise_step=rise_step,
        speed=fastest / speed_scale(case, meter),
        finite=finite,
        error=error,
        escaped=_escaped(world, meter),
        unconverged=unconverged,
    )


def problems(outcome: Outcome) -> str:
    """Which promises a case broke, in words; empty if none."""
    found = []
    if outcome.error:
        found.append(outcome.error)
    if not outcome.finite:
        found.append("not finite")
    if outcome.excess > LIMIT:
        found.append(f"energy excess {outcome.excess:.1e} at step {outcome.excess_step}")
    if math.isnan(outcome.excess) and outcome.speed > SPEED_LIMIT:
        found.append(f"speed {outcome.speed:.1f} of what drives it")
    return f"seed {outcome.seed} ({outcome.category}): {', '.join(found)}" if found else ""


def speed_scale(case: Case, meter: EnergyMeter) -> float:
    """m/s: what drives the scene, how fast it starts, how fast it falls over its own extent in the time."""
    mass = meter.mass[meter.dynamic]
    started = math.sqrt(2.0 * meter.kinetic_start / float(mass.min())) if meter.kinetic_start > 0.0 else 0.0
    fall = min(math.sqrt(2.0 * meter.pull * meter.extent), meter.pull * STEPS * case.options.timestep)
    return case.drive_speed + started + fall + 1e-9


def _escaped(world: World, meter: EnergyMeter) -> int:
    """Dynamic bodies whose centre is behind a half-plane."""
    behind = np.zeros(len(meter.mass), bool)
    shapes = world.model.shapes
    place = world.state.bodies["position"][0]
    for s in np.flatnonzero(shapes["kind"] == 4):
        record = world.parameters.shapes[0, s]
        c, sine = record["local_rotation"]
        behind |= (place - record["local_position"]) @ np.array([-sine, c]) < 0.0
    return int((behind & meter.dynamic).sum())
