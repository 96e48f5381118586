"""Every spatial scene runs for a while, holds together and makes no energy; closed forms are in tests/validation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes import SCENES, make_world
from gsenv.scenes.spatial import cube_rain, gyroscope, soft_cube, sphere_cradle, sphere_grid, sphere_rain
from gsenv.scenes.spatial.turning import Quaternion, about, after, hanging, lying, rolling_axle, turned, uphill_normal
from gsenv.solver import Scene, World

SPATIAL = [name for name, spec in SCENES.items() if spec.dim == 3]
LINKS = {"ball_cradle": 1.0, "rod_pendulum": 1.0, "two_rods": 1.0, "ball_chain": 0.25, "gyroscope": 0.1}  # m


def axis(turn: Quaternion, k: int) -> np.ndarray:
    """Where a rotation takes the k-th axis."""
    unit = [0.0, 0.0, 0.0]
    unit[k] = 1.0
    return np.array(turned(turn, (unit[0], unit[1], unit[2])))


def test_directions() -> None:
    a, h = math.radians(20.0), math.radians(30.0)
    turn = lying(20.0, 30.0)
    assert axis(turn, 2) == pytest.approx(uphill_normal(20.0, 30.0))
    assert axis(turn, 0) == pytest.approx([math.cos(a) * math.cos(h), math.cos(a) * math.sin(h), -math.sin(a)])
    assert axis(lying(20.0, 30.0, 90.0), 0) == pytest.approx(axis(turn, 1))
    assert axis(rolling_axle(30.0), 2) == pytest.approx([-math.sin(h), math.cos(h), 0.0])
    assert axis(after(about(2, 30.0), about(1, -20.0)), 2) == pytest.approx(-np.array(hanging(20.0, 30.0)))


@pytest.mark.parametrize("name", SPATIAL)
def test_each_builder_makes_a_new_scene(name: str) -> None:
    first, second = SCENES[name].build(), SCENES[name].build()
    assert isinstance(first, Scene)
    assert first is not second
    assert first.compile().digest == second.compile().digest


@pytest.mark.parametrize("name", SPATIAL)
def test_runs_makes_no_energy_and_holds_together(name: str) -> None:
    """For two seconds, crowds of more than a hundred for half a second."""
    world = make_world(name)
    crowd = len(world.model.body_names) > 100
    dynamic = world.model.bodies["kind"] == 2
    start = world.diagnostics()
    weight = 9.81 * world.parameters.bodies["mass"][0, dynamic].sum()
    low = high = world.center_of_mass[0, dynamic, 2]
    top, gap = 0.0, 0.0
    for _ in range(round((0.5 if crowd else min(2.0, SCENES[name].duration)) / world.timestep)):
        world.step()
        reading = world.diagnostics()
        heights = world.center_of_mass[0, dynamic, 2]
        low, high = np.minimum(low, heights), np.maximum(high, heights)
        top = max(top, float(reading.energy[0] - start.energy[0]))
        gap = max(gap, float(reading.joint_error[0]))
    assert np.isfinite(world.position).all()
    assert np.isfinite(world.orientation).all()
    assert top <= 1e-3 * (start.kinetic_energy[0] + weight * (high.max() - low.min()))
    if name in LINKS:
        assert gap < 0.01 * LINKS[name]


@pytest.mark.parametrize("scene", [cube_rain(), sphere_rain(200), sphere_grid()], ids=["cubes", "rain", "grid"])
def test_nothing_overlaps_at_the_start(scene: Scene) -> None:
    world = World(scene)
    world.step(1)
    assert world.diagnostics().penetration[0] < 1e-9


def test_cradle_touches_exactly() -> None:
    x = World(sphere_cradle(0)).center_of_mass[0, 1:, 0]
    assert np.diff(x) == pytest.approx([0.2] * 4, abs=1e-15)


def test_gyroscope_starts_in_its_motion() -> None:
    world = World(gyroscope())
    v, w, x = world.linear_velocity[0, 1], world.angular_velocity[0, 1], world.center_of_mass[0, 1]
    assert np.cross(w, x) == pytest.approx(v, abs=1e-12)


def test_soft_cube_keeps_its_place_without_weight() -> None:
    """Springs are relaxed at the initial poses."""
    world = World(soft_cube(3))
    world.parameters.set(gravity=(0.0, 0.0, 0.0))
    start = world.position
    world.step(60)
    assert np.abs(world.position - start).max() < 1e-9
