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
