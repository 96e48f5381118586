"""Random jointed scenes: chains, ragdolls, rings, ropes, springs, sliders, motors, gears, cars, contradictions.

benchmarks/stability.py runs as many as are asked for.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from tests.stress.batches import batches
from tests.stress.jointed import random_jointed_case
from tests.stress.measure import problems, run_case

STEPS = 300


@batches(count=280, size=28, nightly_from=112)
def test_random_jointed_scenes(seeds: range) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds."""
    broken = [problems(run_case(random_jointed_case(seed), STEPS)) for seed in seeds]
    assert not any(broken), "\n".join(filter(None, broken))


@pytest.mark.parametrize("seed", [10, 14, 16, 19, 29, 52, 58, 72, 103, 136])
def test_scenes_in_joint_coordinates(seed: int) -> None:
    """Joints that contradict each other, rings whose joints are there twice, chains that turn fast."""
    case = random_jointed_case(seed)
    case = dataclasses.replace(case, options=dataclasses.replace(case.options, articulated=True))
    broken = problems(run_case(case, STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [122, 154, 277, 290, 381, 1192, 1793])
def test_rare_scenes(seed: int) -> None:
    """Of 5,000 seeds: loops that cannot close, a contact whose point joints hold, chains that whip or are taut.

    In 277 each joint is there twice, at different points: impulses that held each other grew a thousandfold in a step.
    """
    broken = problems(run_case(random_jointed_case(seed), STEPS))
    assert not broken, broken


def _joined_twice(dim: int, apart: float) -> Scene:
    """Three boxes in a row, of 1, 0.1 and 0.01 times the density, that turn with 20 rad/s; two joints between each."""
    more = [0.0] * (dim - 2)
    down = [0.0] * (dim - 1) + [-9.81]
    scene = Scene(dim=dim, gravity=down)
    for k in range(3):
        halves = [0.5, 0.1, *[0.1] * (dim - 2)]
        box = (planar.Box if dim == 2 else spatial.Box)(half_extents=halves, density=0.1**k)
        spin = 20.0 if dim == 2 else (0.0, 0.0, 20.0)
        place, speed = [0.9 * k, 0.0, *more], [0.0, 18.0 * k, *more]
        scene.add_body(f"box_{k}", "dynamic", [box], position=place, linear_velocity=speed, angular_velocity=spin)
    for k in range(2):
        for n, y in enumerate((0.05, -0.05)):
            a, b = [0.45, y, *more], [-0.45 + apart * n, y, *more]
            bodies = f"box_{k}", f"box_{k + 1}"
            joint: Any = planar.Revolute(*bodies, anchor_a=a, anchor_b=b)
            if dim == 3:
                joint = spatial.Hinge(*bodies, anchor_a=a, anchor_b=b, axis=(0.0, 0.0, 1.0))
            scene.add_joint(f"joint_{k}_{n}", joint)
    return scene


def _largest_impulse(world: World, steps: int) -> float:
    largest = 0.0
    for _ in range(steps):
        world.step()
        largest = max(largest, float(np.abs(world.state.joints["impulse"]).max()))
    return largest


@pytest.mark.parametrize("articulated", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_joints_that_nearly_contradict_do_not_load_each_other(dim: int, articulated: bool) -> None:
    """Anchors 1 mm off: impulses do not grow to thousands of times the momentum of all bodies."""
    world = World(_joined_twice(dim, apart=1e-3), options=Options(articulated=articulated))
    masses = world.parameters.bodies["mass"][0]
    momentum = float(masses @ np.hypot.reduce(world.linear_velocity[0], axis=-1))
    assert 0.0 < _largest_impulse(world, 100) < 100.0 * momentum


@pytest.mark.parametrize("articulated", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_joints_that_agree_keep_the_spin(dim: int, articulated: bool) -> None:
    """Two joints between each two bodies that turn as one: impulses below those of a weld, m w^2 r h, and no torque."""
    world = World(_joined_twice(dim, apart=0.0), options=Options(articulated=articulated))
    masses = world.parameters.bodies["mass"][0]
    weld = 20.0 * float(masses[1] * 18.0 + masses[2] * 36.0) * world.options.timestep
    assert 0.0 < _largest_impulse(world, 200) < weld
    spin = np.reshape(world.angular_velocity[0], (len(masses), -1))[:, -1]
    np.testing.assert_allclose(spin, 20.0, rtol=1e-5 if articulated else 5e-3)
