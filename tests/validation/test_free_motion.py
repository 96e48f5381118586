"""Free flight and rotation, momentum and energy of whole scenes, at default and accurate settings."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from benchmarks.accuracy.errors3d import crossings
from benchmarks.accuracy.geometry3d import conjugate, rotated
from gsenv.scenes import bouncing_balls, box_on_incline, mass_ratio_stack, overhang, projectile, pyramid, stack
from gsenv.scenes.spatial import (
    block_on_incline,
    block_overhang,
    bouncing_spheres,
    cube_mass_ratio,
    cube_pyramid,
    cube_stack,
    roller_on_incline,
    sliding_roller,
    sphere_grid,
    spinning_box,
    thrown_box,
)
from gsenv.scenes.spatial.turning import Vec, about
from gsenv.solver import Scene, planar, spatial
from tests.validation.reference import (
    BOTH,
    ENERGY,
    PLANE_AND_SPACE,
    ROTATION,
    ROUND_OFF,
    G,
    awake_world,
    energy_made,
    length,
    world_of,
)


@BOTH
@PLANE_AND_SPACE
def test_projectile_follows_a_parabola(fidelity: str, dim: int) -> None:
    spin = 3.0  # rad/s, in 2D
    scene = projectile((5.0, 7.0), spin) if dim == 2 else thrown_box((5.0, 1.0, 7.0))
    world = world_of(scene, fidelity)
    velocity, up = world.linear_velocity[0, 0], np.eye(dim)[-1]
    for k in range(1, 121):
        world.step()
        t = k * world.timestep
        x = up + velocity * t - 0.5 * G * t**2 * up
        np.testing.assert_allclose(world.position[0, 0], x, rtol=ROUND_OFF, atol=ROUND_OFF)
        np.testing.assert_allclose(world.linear_velocity[0, 0], velocity - G * t * up, atol=ROUND_OFF)
        if dim == 2:
            assert world.angle[0, 0] == pytest.approx(spin * t, rel=ROUND_OFF)


@BOTH
def test_body_of_equal_moments_rotates_evenly(fidelity: str) -> None:
    """It keeps its spin, and its orientation is that of t seconds of it."""
    spin: Vec = (1.0, 2.0, 3.0)
    world = awake_world(spinning_box((2.0, 2.0, 2.0), spin), fidelity)
    rate = float(length(np.array(spin)))
    for k in range(1, 121):
        world.step()
        half = 0.5 * rate * k * world.timestep
        expected = np.array([math.cos(half), *(math.sin(half) / rate * np.array(spin))])
        np.testing.assert_allclose(world.angular_velocity[0, 0], spin, rtol=ROUND_OFF)
        assert abs(float(expected @ world.orientation[0, 0])) == pytest.approx(1.0, abs=ROUND_OFF)


@BOTH
@pytest.mark.parametrize("attitude", [0.0, 37.0])
def test_tumbling_body_flips_in_time(fidelity: str, attitude: float) -> None:
    """Flips at 10.9169135 s, then every 19.5528671 s; energy and the vector of angular momentum are kept."""
    inertia = np.array([1.0, 2.0, 3.0])
    world = awake_world(spinning_box(orientation=about(0, attitude)), fidelity)
    steps = round(60.0 / world.timestep)
    turns, spins = np.empty((steps + 1, 4)), np.empty((steps + 1, 3))
    turns[0], spins[0] = world.orientation[0, 0], world.angular_velocity[0, 0]
    for k in range(1, steps + 1):
        world.step()
        turns[k], spins[k] = world.orientation[0, 0], world.angular_velocity[0, 0]
    own = rotated(conjugate(turns), spins)
    close = ROTATION.at(fidelity)
    flips = crossings(np.linspace(0.0, 60.0, steps + 1), own[:, 1])
    np.testing.assert_allclose(flips, 10.9169135 + 19.5528671 * np.arange(3), rtol=close)
    energy = 0.5 * (inertia * own**2).sum(-1)
    np.testing.assert_allclose(energy, energy[0], rtol=close)
    momentum = rotated(turns, inertia * own)
    assert length(momentum - momentum[0]).max() < close * length(momentum[0])


def colliding_boxes(dim: int) -> Scene:
    """Six boxes without weight that fly into each other, three of them with restitution."""
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    for k in range(6):
        material: dict[str, Any] = {"restitution": 0.5 * (k % 2), "friction": 0.6}
        motion: dict[str, Any]
        box: Any
        if dim == 2:
            box = planar.Box(half_extents=(0.4, 0.3), **material)
            motion = {"angle": 0.3 * k, "angular_velocity": k - 2.0}
        else:
            box = spatial.Box(half_extents=(0.4, 0.3, 0.35), **material)
            motion = {"orientation": about(k % 3, 17.0 * k), "angular_velocity": (k - 2.0, 0.3 * k, -0.5)}
        position = (1.5 * (k % 3), 1.2 * (k // 3), 0.1 * k)[:dim]
        velocity = ((1.0 - k % 3) * 2.0, 1.0 - 2.0 * (k // 3), 0.2 - 0.1 * k)[:dim]
        scene.add_body(f"box_{k}", shapes=[box], position=position, linear_velocity=velocity, **motion)
    return scene


@BOTH
@PLANE_AND_SPACE
def test_collisions_keep_the_total_momentum(fidelity: str, dim: int) -> None:
    world = world_of(colliding_boxes(dim), fidelity)
    start = world.diagnostics().momentum[0]
    scale = (world.parameters.mass[0] * length(world.linear_velocity[0])).sum()
    impacts = 0
    for _ in range(180):
        world.step()
        impacts += int(world.diagnostics().impacts[0])
    assert impacts > 0
    assert abs(world.diagnostics().momentum[0] - start).max() < ROUND_OFF * scale


PASSIVE: dict[str, Callable[[], Scene]] = {
    "2D stack": lambda: stack(10),
    "2D pyramid": lambda: pyramid(10),
    "2D mass ratio": lambda: mass_ratio_stack(1000.0),
    "2D bounces": lambda: bouncing_balls(),
    "2D incline": lambda: box_on_incline(35.0),
    "2D overhang": lambda: overhang(5, 1.01),
    "3D stack": lambda: cube_stack(10),
    "3D pyramid": lambda: cube_pyramid(10),
    "3D mass ratio": lambda: cube_mass_ratio(1000.0),
    "3D bounces": lambda: bouncing_spheres(),
    "3D incline": lambda: block_on_incline(35.0, 30.0, 20.0),
    "3D rolling": lambda: roller_on_incline("cylinder"),
    "3D sliding": lambda: sliding_roller("sphere"),
    "3D overhang": lambda: block_overhang(5, 1.01),
    "3D falling balls": lambda: sphere_grid(3),
}


@BOTH
@pytest.mark.parametrize("name", PASSIVE)
def test_passive_scene_gains_no_energy(fidelity: str, name: str) -> None:
    assert energy_made(world_of(PASSIVE[name](), fidelity), 3.0) < ENERGY.at(fidelity)
