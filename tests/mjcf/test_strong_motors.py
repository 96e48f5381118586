"""Motors that throw light limbs about between their limits."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gsenv.mjcf import build_scene, parse_mjcf
from gsenv.solver import Options, World
from tests.mjcf.oracle import GYMNASIUM


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_an_ant_without_rotors_stays_whole(seed: int) -> None:
    """Torques of 150 N m turn its legs of 40 g from limit to limit within a step of 5 ms.

    A leg then reaches at most what the torque's work over its range gives it: 1/2 I w^2 = 150 N m * 1.05 rad with
    the least inertia 0.00034 kg m^2 of a leg, and the torso likewise on eight legs.
    """
    model = parse_mjcf(GYMNASIUM / "ant.xml")
    model.joints = [dataclasses.replace(joint, armature=0.0) for joint in model.joints]
    scene, _ = build_scene(model)
    world = World(scene, options=Options(timestep=0.005, sleep=False))
    actuators = world.model.actuators
    rng = np.random.default_rng(seed)
    fastest = error = 0.0
    for step in range(300):
        if step % 5 == 0:
            world.control[:] = rng.uniform(actuators["lower"], actuators["upper"])
        world.step()
        fastest = max(fastest, float(abs(world.angular_velocity).max()))
        error = max(error, float(world.diagnostics().joint_error.max()))
    assert fastest < np.sqrt(2.0 * 150.0 * 1.05 / 0.00034)
    assert error < 0.03


@pytest.mark.parametrize(("articulated", "substeps", "deepest"), [(True, 2, 0.02), (True, 1, 0.05), (False, 1, 0.2)])
def test_an_ant_under_random_torques_stays_whole_at_its_own_timestep(
    articulated: bool, substeps: int, deepest: float
) -> None:
    """A limb of 3 g m^2 on a rotor of 1 kg m^2: by rows, with one substep, two of 24 ants became NaN."""
    scene, _ = build_scene(parse_mjcf(GYMNASIUM / "ant.xml"))
    count = 24
    world = World(scene, count, options=Options(timestep=0.01, substeps=substeps, articulated=articulated))
    actuators = world.model.actuators
    rngs = [np.random.default_rng(seed) for seed in range(count)]
    penetration = 0.0
    for _ in range(300):
        for rng, control in zip(rngs, world.control, strict=True):
            control[:] = rng.uniform(actuators["lower"], actuators["upper"])
        world.step()
        penetration = max(penetration, float(world.diagnostics().penetration.max()))
    assert np.isfinite(world.position).all()
    assert abs(world.position).max() < 50.0
    assert penetration < deepest
