"""Fast trees of bodies that hit the ground in joint coordinates: momentum, energy and overlap."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box as Box2D
from gsenv.solver.planar import Capsule as Capsule2D
from gsenv.solver.planar import HalfPlane, Revolute
from gsenv.solver.spatial import Ball, Box, Plane

Array = np.ndarray[Any, Any]
LIMBS = 2  # collision category: links do not collide with each other
LINKS = 5
LENGTH = 0.5  # m


def flail(seed: int, friction: float) -> Scene:
    """A chain of boxes on ball joints, thrown to the ground with rates of about 10 rad/s."""
    rng = np.random.default_rng(seed)
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[Plane(friction=friction)])
    box = Box(half_extents=(0.25, 0.06, 0.04), density=500.0, friction=friction, category=LIMBS, mask=~LIMBS)
    v = np.array((1.0, 0.5, -1.0))
    spin = np.zeros(3)
    at = np.array((0.0, 0.0, 1.0))
    for k in range(LINKS):
        new = rng.uniform(-10.0, 10.0, 3)
        if k:
            v = v + np.cross(spin, (0.5 * LENGTH, 0.0, 0.0)) + np.cross(new, (0.5 * LENGTH, 0.0, 0.0))
            at = at + np.array((LENGTH, 0.0, 0.0))
        spin = new
        scene.add_body(f"b{k}", shapes=[box], position=at, linear_velocity=v, angular_velocity=spin)
        if k:
            scene.add_joint(f"j{k}", Ball(f"b{k - 1}", f"b{k}", anchor=at - (0.5 * LENGTH, 0.0, 0.0)))
    return scene


def flail2d(seed: int, friction: float) -> Scene:
    rng = np.random.default_rng(seed)
    scene = Scene(dim=2)
    scene.add_body("ground", "static", shapes=[HalfPlane(friction=friction)])
    box = Box2D(half_extents=(0.25, 0.05), density=500.0, friction=friction, category=LIMBS, mask=~LIMBS)
    v = np.array((1.0, -1.0))
    spin = 0.0
    at = np.array((0.0, 1.0))
    for k in range(LINKS):
        new = float(rng.uniform(-10.0, 10.0))
        if k:
            v = v + np.array((0.0, 0.5 * LENGTH * (spin + new)))
            at = at + np.array((LENGTH, 0.0))
        spin = new
        scene.add_body(f"b{k}", shapes=[box], position=at, linear_velocity=v, angular_velocity=spin)
        if k:
            scene.add_joint(f"j{k}", Revolute(f"b{k - 1}", f"b{k}", anchor=at - (0.5 * LENGTH, 0.0)))
    return scene


def thrown(dim: int, seed: int, friction: float, on: bool = True) -> World:
    scene = flail(seed, friction) if dim == 3 else flail2d(seed, friction)
    return World(scene, options=Options(timestep=1 / 240, sleep=False, articulated=on))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", [1, 2])
def test_ground_without_friction_changes_no_momentum_along_it(dim: int, seed: int) -> None:
    world = thrown(dim, seed, friction=0.0)
    before = world.diagnostics()
    hit = False
    for _ in range(240):
        world.step()
        hit = hit or bool(world.diagnostics().contacts[0] > 0)
    assert hit
    after = world.diagnostics()
    mass = float(world.parameters.bodies["mass"][0, 1:].sum())
    scale = float((2.0 * mass * before.kinetic_energy[0]) ** 0.5)
    assert np.abs(after.momentum[0, : dim - 1] - before.momentum[0, : dim - 1]).max() < 1e-3 * scale
    if dim == 3:
        turned = abs(after.angular_momentum[0, 2] - before.angular_momentum[0, 2])
        assert turned < 2e-3 * scale * LINKS * LENGTH  # landings take place at the start of their substep


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_fast_links_gain_no_energy_on_the_ground_and_hardly_enter_it(dim: int, seed: int) -> None:
    world = thrown(dim, seed, friction=0.6)
    energies = [float(world.diagnostics().energy[0])]
    deepest = 0.0
    for _ in range(480):
        world.step()
        diagnostics = world.diagnostics()
        energies.append(float(diagnostics.energy[0]))
        deepest = max(deepest, float(diagnostics.penetration[0]))
    gains = np.maximum(np.diff(energies), 0.0)
    kinetic = energies[0] - energies[-1]
    assert kinetic > 10.0
    assert gains.sum() < 0.01 * kinetic, gains.sum() / kinetic
    assert deepest < 0.01, deepest


def test_a_contact_that_joints_hold_still_does_not_end_the_solve() -> None:
    """A bar from a fixed pin to a wall, on which boxes lie: along the bar no impulse at the wall moves anything."""
    scene = Scene(dim=2)
    scene.add_body("ground", "static", shapes=[HalfPlane(), Box2D(half_extents=(0.1, 1.0), position=(1.15, 1.0))])
    scene.add_body("bar", shapes=[Capsule2D(half_length=0.5, radius=0.05)], position=(0.5, 0.05))
    scene.add_body("post", "static")
    scene.add_joint("pin", Revolute("post", "bar", anchor=(0.0, 0.05)))
    for k in range(3):
        scene.add_body(f"box_{k}", shapes=[Box2D(half_extents=(0.2, 0.1))], position=(0.5, 0.2 + 0.2 * k))
    world = World(scene, options=Options(articulated=True, sleep=False))
    for _ in range(60):
        world.step()
        assert np.abs(world.linear_velocity[0]).max() < 1e-3
        assert world.diagnostics().penetration[0] < 1e-4
