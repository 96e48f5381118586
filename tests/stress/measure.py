"""What is measured on a random scene, and what it promises.

A case that no motor, target or kinematic body drives is passive: its mechanical energy E (kinetic,
gravitational, of springs) may not exceed

    E_start + E_overlap + 1e-3 E_scale                                        at the end of any step.

E_scale = E_kin(start) + sum m |g| L, with L the scene's extent: the larger side of the box around
the dynamic bodies at the start and the origin, where the floor is.
E_overlap, the work of raising bodies that start inside each other: a cluster (what overlaps at the
start, plus what may rest on it or hangs on its joints) costs at most sum over its overlaps of depth
times |g| times the mass above or jointed, and at most what a tower of all its bodies costs, from
where its deepest one leaves the ground.  Both are bounds of the work that a calm separation does;
the smaller counts, and it is 0 where nothing overlaps.  A body under terrain or a height field rises by
its vertical depth, of buried.py, and may raise all that is above it, to the largest of these depths: between
two steep slopes it rises by more than its depth along their normals.

Joints whose anchors start apart may draw all bodies up by as much: that work is added to E_overlap.

A driven case may not move faster than SPEED_LIMIT times its scale of speeds. A kinematic body of speed v
that presses a body against a second contact, whose normal is off the opposite of the first one's by the
angle a, squeezes it out at v / sin(a), as a wedge does: such a speed is added to the scale when it occurs.
So is, for a body that has left the edge of the ground, the plane z = 0 or y = 0, the speed of its fall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gsenv.solver import Options, World
from gsenv.solver.dimension import dimension
from gsenv.solver.planar import kinds as planar
from gsenv.solver.readings.joint_errors import read_joints
from gsenv.solver.records.model import JointKind
from gsenv.solver.spatial import kinds as spatial

from .buried import buried
from .cases import Array, Case, Rng
from .motion import motion

STEPS = 200
PUSHED = 20  # steps of a case with pushes
UNEVEN = {2: planar.ShapeKind.TERRAIN, 3: spatial.ShapeKind.HEIGHTFIELD}  # kinds of shape
LIMIT = 1e-3  # of the energy scale
SPEED_LIMIT = 3.0  # of the speed scale, for cases that something drives


@dataclass(frozen=True)
class Outcome:
    """What one case did in STEPS steps.

    Attributes:
        excess: largest energy above E_start + E_overlap, over E_scale; NaN for driven cases.
        excess_step: when; excess_unforgiven: the same without E_overlap.
        rise: largest gain above the least energy so far, over E_scale. No promise (a soft weld lets
            go, an overlap is raised) but the measure that finds causes: dissipation can't hide them.
        speed: fastest point of a body at any time over ``speed_scale`` and what wedges add to it.
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


class EnergyMeter:
    """Energy of one world, its scale and the energy of its initial overlap."""

    def __init__(
        self, world: World, overlapping: bool = False, slack: float = 0.0, buried: Array | None = None
    ) -> None:
        self.world = world
        self.buried = np.zeros(len(world.model.bodies)) if buried is None else buried
        kinds = world.model.shapes["kind"]
        self.uneven = np.zeros(len(self.buried), bool)  # bodies of terrains or height fields
        self.uneven[world.model.shapes["body"][kinds == UNEVEN[world.model.dim]]] = buried is not None
        self.dim = world.model.dim
        self.sprung = world.model.is_linked  # soft welds start relaxed: what they store only lowers the rest
        parameters = world.parameters.bodies[0]
        dynamic = (world.model.bodies["kind"] == 2) & (parameters["enabled"] != 0)
        self.dynamic = dynamic
        self.mass = np.where(dynamic, parameters["mass"], 0.0)
        self.inertia = np.where(dynamic[:, None], parameters["inertia"].reshape(len(dynamic), -1), 0.0)
        self.axes = np.zeros((len(dynamic), 4)) if self.dim == 2 else parameters["axes"].copy()
        self.radius = np.where(dynamic, parameters["radius"], 0.0)
        gravity = world.parameters.worlds["gravity"][0]
        self.weight = (self.mass * parameters["gravity_scale"])[:, None] * gravity
        self.pull = float(np.hypot.reduce(gravity))
        place = world.state.bodies["position"][0, dynamic]
        reach = self.radius[dynamic, None]
        lower = np.minimum((place - reach).min(0), 0.0)
        upper = np.maximum((place + reach).max(0), 0.0)
        self.extent = float((upper - lower).max())
        self.kinetic_start = self.kinetic()
        self.start = self.energy()
        self.scale = max(self.kinetic_start + float(self.mass.sum()) * self.pull * self.extent, 1e-12)
        self.overlap = self._overlap_energy() if overlapping else 0.0
        self.overlap += slack * self.pull * float(self.mass.sum())

    def kinetic(self) -> float:
        return self._motion()[0]

    def top_speed(self) -> float:
        """m/s, fastest point of a dynamic body."""
        return float(self._motion()[1].max())

    def speed_over(self, scale: float) -> float:
        """Largest speed of a body over ``scale`` plus that of its fall from the ground to below it."""
        below = np.maximum(-self.world.state.bodies["position"][0, :, self.dim - 1], 0.0)
        return float((self._motion()[1] / (scale + np.sqrt(2.0 * self.pull * below))).max())

    def _motion(self) -> tuple[float, Array]:
        bodies = self.world.state.bodies[0]
        return motion(bodies["velocity"], bodies["rotation"], self.axes, self.mass, self.inertia, self.radius)

    def energy(self) -> float:
        height = -float((self.weight * self.world.state.bodies["position"][0]).sum())
        if self.sprung:
            world = self.world
            height += float(read_joints(world.model, world.parameters, world.state).spring_energy[0])
        return self.kinetic() + height

    def squeezed(self, speed: float, drive: float) -> float:
        """m/s, the speed of the sharpest wedge of a kinematic body around a body faster than ``speed``."""
        v = self.world.state.bodies["velocity"][0]
        fast = self.dynamic & (np.hypot.reduce(v[:, : self.dim], axis=1) > speed)
        kinematic = self.world.model.bodies["kind"] == 1
        contacts = self.world.contacts(0)
        normals: dict[int, list[tuple[bool, Array]]] = {}  # into a fast body, and whether a kinematic one pushes
        for a, b, normal in zip(contacts.body_a, contacts.body_b, contacts.normal, strict=True):
            for body, other, sign in ((a, b, -1.0), (b, a, 1.0)):
                if fast[body]:
                    normals.setdefault(int(body), []).append((bool(kinematic[other]), sign * normal))
        sines = [
            math.sqrt(max(1.0 - float(one @ two) ** 2, 1e-12))
            for around in normals.values()
            for pushes, one in around
            for _, two in around
            if pushes and one @ two < 0.0
        ]
        return drive / min(sines) if sines else 0.0

    def _overlap_energy(self) -> float:
        """J, see the module's docstring. Depths come from a step of no duration."""
        probe = World(self.world.model, options=Options(timestep=1e-12, sleep=False))
        probe.step()
        contacts = probe.contacts(0)
        count = len(self.mass)
        depth: dict[tuple[int, int], float] = {}
        group = np.arange(count)
        for a, b, separation in zip(contacts.body_a, contacts.body_b, contacts.separation, strict=True):
            uneven = self.uneven[a] or self.uneven[b]
            if separation < 0.0 and not uneven:
                pair = (int(a), int(b))
                depth[pair] = max(depth.get(pair, 0.0), float(-separation))
                if self.dynamic[a] and self.dynamic[b]:
                    group[group == group[b]] = group[a]
        height = self.world.state.bodies["position"][0, :, self.dim - 1]
        total = self._work_of_buried(height) * self.pull
        linked = np.zeros(count, bool)  # drawn along, from below too
        tall = 2.0 * self.radius
        for joint, parameters in zip(self.world.model.joints, self.world.parameters.joints[0], strict=True):
            a, b = int(joint["body_a"]), int(joint["body_b"])
            if self.dynamic[a] and self.dynamic[b]:
                linked[[a, b]] = True
                group[group == group[b]] = group[a]
                if joint["kind"] == JointKind.DISTANCE:  # a tower of balls on ropes stretches them
                    tall[b] += max(parameters["length"], parameters["upper"])
        for g in np.unique(group[self.dynamic]):
            members = np.flatnonzero((group == g) & self.dynamic)
            heaviest = members[np.argsort(-self.mass[members])]
            tower = float((self.mass[heaviest] * np.cumsum(tall[heaviest])).sum())
            raised = 0.0
            sunk = 0.0  # of a body that starts wholly under the ground: no tower lifts it out
            for (a, b), d in depth.items():
                if a in members or b in members:
                    if not (self.dynamic[a] and self.dynamic[b]):
                        sunk = max(sunk, d - 2.0 * float(self.radius[a] if self.dynamic[a] else self.radius[b]))
                    low = min(height[c] for c in (a, b) if self.dynamic[c])
                    raised += d * float(self.mass[members][(height[members] >= low) | linked[members]].sum())
            total += min(tower + sunk * float(self.mass[members].sum()), raised) * self.pull
        return total

    def _work_of_buried(self, height: Array) -> float:
        """kg m: each buried body may raise all that is above it, but together no higher than the deepest one."""
        under = np.flatnonzero(self.buried > 0.0)
        if not len(under):
            return 0.0
        each = sum(float(self.buried[b] * self.mass[height >= height[b]].sum()) for b in under)
        return min(each, float(self.buried.max() * self.mass[height >= height[under].min()].sum()))


def drive(case: Case, world: World, step: int, rng: Rng) -> None:
    """Now and then a new control for a case with targets; forces on all bodies at the start of one with pushes."""
    if case.pushes > 0.0 and step < PUSHED:
        for body in np.flatnonzero(world.model.bodies["kind"] == 2):
            parameters = world.parameters.bodies[0, body]
            way, turn = rng.normal(0.0, 0.5, (2, world.model.dim))
            torque = case.pushes * parameters["inertia"].min() / max(parameters["radius"], 1e-12) * turn
            world.apply_force(int(body), force=case.pushes * parameters["mass"] * way, torque=torque)
    if world.control.shape[1] and step % 20 == 0:
        world.control[:] = rng.uniform(-5.0, 5.0, world.control.shape)


def run_case(case: Case, steps: int = STEPS) -> Outcome:
    """Step a case and watch its energy, speeds and numbers after every step."""
    raw = rise = -math.inf
    when = rise_step = -1
    fastest = 0.0  # over the scale
    finite = True
    error = ""
    unconverged = 0
    rng = np.random.default_rng(case.seed + 1)  # of the controls
    world = World(case.scene, options=case.options)
    meter = EnergyMeter(world, case.overlapping, case.slack, buried(case.scene) if case.overlapping else None)
    scale = speed_scale(case, meter)
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
        speed = meter.speed_over(scale)
        if case.driven and speed > SPEED_LIMIT:
            scale += meter.squeezed(SPEED_LIMIT * scale, case.drive_speed)
            speed = meter.speed_over(scale)
        fastest = max(fastest, speed)
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
        speed=fastest,
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
    for s in np.flatnonzero(shapes["kind"] == (4 if meter.dim == 2 else 5)):
        record = world.parameters.shapes[0, s]
        if meter.dim == 2:
            c, sine = record["local_rotation"]
            normal = np.array([-sine, c])
        else:
            normal = dimension(3).initial_state.turned_by(record["local_rotation"], (0.0, 0.0, 1.0))
        behind |= (place - record["local_position"]) @ normal < 0.0
    return int((behind & meter.dynamic).sum())
