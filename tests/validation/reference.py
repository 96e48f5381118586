"""What the tests of reference scenes share: fidelities and dimensions, worlds, measures, and their tolerances.

Tolerances are the errors that ``balanced`` and ``accurate`` fidelity may have at most, by what is measured.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.solver import Options, Scene, World
from gsenv.solver.records.model import BodyKind

Array = NDArray[np.float64]

G = 9.81  # m/s^2
BOTH = pytest.mark.parametrize("fidelity", ["balanced", "accurate"])
PLANE_AND_SPACE = pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])


class Tolerance(NamedTuple):
    balanced: float
    accurate: float

    def at(self, fidelity: str) -> float:
        return self.balanced if fidelity == "balanced" else self.accurate


MOTION = Tolerance(1e-2, 1e-4)  # of periods, distances and speeds of smooth motion, relative
ROTATION = Tolerance(1e-3, 1e-6)  # of free rotation, relative
IMPACT = Tolerance(1e-3, 1e-5)  # of heights and times of bounces, relative
CRADLE = Tolerance(1e-2, 1e-3)  # of energies after impacts of a whole row, relative to what came in
NUTATION = Tolerance(1e-2, 1e-3)  # of a steady precession, relative to the arm
LOAD = Tolerance(1e-2, 1e-6)  # of contact impulses at rest, relative: how far the sweeps converge
CREEP = Tolerance(1e-4, 1e-6)  # m in 5 s of a block that friction holds
STACKING = Tolerance(5e-3, 5e-4)  # m of penetration or height error per layer, of boxes of 1 m
HEAVY_STACKING = Tolerance(3e-2, 5e-4)  # m, of 1000 kg on 1 kg, where sweeps converge slowly
PENETRATION = Tolerance(3e-2, 1e-2)  # m, of balls of 1 m that hit one another
REST = Tolerance(1e-4, 1e-5)  # m, place of rest on the ground
TRACTION = Tolerance(2e-2, 1e-3)  # of a car's acceleration and braking distance, relative
CHAIN = Tolerance(3e-2, 1e-3)  # of energy and joint gaps of a chain with a heavy end, relative
DOUBLE_PENDULUM = Tolerance(1e-1, 1e-2)  # of the energy of 10 s of chaotic motion, relative
SPRING = Tolerance(5e-2, 1e-3)  # of displacement over 5 periods, relative to the amplitude
MOTOR = Tolerance(1e-3, 1e-6)  # of torques, speeds and limits of one joint
ENERGY = Tolerance(1e-3, 1e-6)  # of energy gained, over the scene's energy scale

ROUND_OFF = 1e-12  # relative, of hundreds of steps in double precision
MOVED = 1e-2  # m or m/s: what stands still moves less


def world_of(scene: Scene, fidelity: str, **changes: Any) -> World:
    """A world at the options of a fidelity, some of them changed."""
    return World(scene, options=Options.preset(fidelity, **changes))


def awake_world(scene: Scene, fidelity: str, **changes: Any) -> World:
    """The same where nothing may sleep: what is measured goes on moving, or must not rest by decree."""
    return world_of(scene, fidelity, sleep=False, **changes)


def run(world: World, seconds: float) -> World:
    world.step(round(seconds / world.timestep))
    return world


def length(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


def dynamic_masses(world: World) -> Array:
    """(body,) kg, 0 of what is not dynamic."""
    return np.where(world.model.bodies["kind"] == BodyKind.DYNAMIC, world.parameters.mass[0], 0.0)


def energy_made(world: World, seconds: float) -> float:
    """Largest energy above the initial one, over the scene's scale sum m g L."""
    start = world.diagnostics().energy[0]
    mass = dynamic_masses(world)
    height = np.ptp(world.center_of_mass[0, mass > 0.0, -1]) + 1.0
    worst = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        worst = max(worst, world.diagnostics().energy[0] - start)
    return float(worst / (mass.sum() * G * height))


def drift_and_gap(world: World, seconds: float, link: float) -> tuple[float, float]:
    """Largest change of energy over m g L of all links, and largest joint error over a link."""
    mass = dynamic_masses(world)
    scale = float(mass.sum()) * G * link * int((mass > 0.0).sum())
    start = world.diagnostics().energy[0]
    drift = gap = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        d = world.diagnostics()
        drift = max(drift, abs(float(d.energy[0] - start)) / scale)
        gap = max(gap, float(d.joint_error[0]) / link)
    return drift, gap
