"""Springs between anchors and soft welds given by a frequency: one stiffness at all poses, so they conserve energy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial

FREQUENCY = 1.5  # Hz
TWO_PI = 2.0 * math.pi


def pair(dim: int, kind: str) -> World:
    """Two unequal boxes that spin and part, joined at anchors away from their centres of mass; nothing else acts."""
    module: Any = planar if dim == 2 else spatial
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    sizes = ((0.3, 0.05), (0.1, 0.2)) if dim == 2 else ((0.3, 0.05, 0.1), (0.1, 0.2, 0.05))
    spins: Any = (3.0, -2.0) if dim == 2 else ((1.0, 3.0, 0.5), (-2.0, 0.3, 1.0))
    places = np.zeros((2, dim))
    places[1, 0] = 0.5
    for k, name in enumerate("ab"):
        velocity = np.zeros(dim)
        velocity[-1] = 0.3 - 0.6 * k
        scene.add_body(
            name, shapes=[module.Box(half_extents=sizes[k], mask=0)], position=places[k], linear_velocity=velocity,
            angular_velocity=spins[k],
        )  # fmt: skip
    anchor = np.array((0.28, 0.04, 0.05)[:dim])
    if kind == "weld":
        scene.add_joint("spring", module.Weld("a", "b", anchor=anchor, frequency=FREQUENCY, damping_ratio=0.0))
    else:
        other = np.array((-0.08, 0.15, 0.02)[:dim])
        spring = module.Distance(
            "a", "b", anchor_a=anchor, anchor_b=other, length=0.2, frequency=FREQUENCY, damping_ratio=0.0
        )
        scene.add_joint("spring", spring)
    return World(scene, options=Options(timestep=1e-3, sleep=False))


@pytest.mark.parametrize("kind", ["weld", "distance"])
@pytest.mark.parametrize("dim", [2, 3])
def test_energy_is_conserved_while_bodies_turn(dim: int, kind: str) -> None:
    world = pair(dim, kind)
    start = float(world.diagnostics().energy[0])
    energies, kinetic = [], []
    for _ in range(50):
        world.step(40)
        energies.append(float(world.diagnostics().energy[0]))
        kinetic.append(float(world.diagnostics().kinetic_energy[0]))
    assert min(kinetic) < 0.8 * max(kinetic)  # the spring took its part
    np.testing.assert_allclose(energies, start, rtol=2e-3)


MASS, INERTIA = 2.0, (0.05, 0.02, 0.04)  # kg, kg m^2
LENGTH = 0.2  # m


def held(dim: int, kind: str) -> World:
    """A body whose anchor is away from its centre of mass, on a fixed body."""
    module: Any = planar if dim == 2 else spatial
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    scene.add_body("base", "static")
    inertia: Any = INERTIA[0] if dim == 2 else INERTIA
    shape = module.Box(half_extents=(0.1,) * dim, mask=0)
    scene.add_body("body", shapes=[shape], mass=MASS, inertia=inertia)
    arm, origin = np.array((0.3, -0.1, 0.2)[:dim]), np.zeros(dim)
    if kind == "weld":
        scene.add_joint("spring", module.Weld("base", "body", anchor=arm, frequency=FREQUENCY, damping_ratio=0.0))
    else:
        spring = module.Distance(
            "base", "body", anchor_a=origin, anchor_b=arm, length=LENGTH, frequency=FREQUENCY, damping_ratio=0.0
        )
        scene.add_joint("spring", spring)
    return World(scene, options=Options(timestep=1e-5, sleep=False))


@pytest.mark.parametrize("kind", ["weld", "distance"])
@pytest.mark.parametrize("dim", [2, 3])
def test_the_stiffness_is_that_of_the_mean_inverse_mass_at_any_pose(dim: int, kind: str) -> None:
    """The force is k x with (2 pi f)^2 = k (1/m + the mean over directions of the inverse mass of the arm's turn)."""
    arm = np.array((0.3, -0.1, 0.2)[:dim])
    generator = np.random.default_rng(0)
    directions = generator.standard_normal((200_000, dim))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    if dim == 2:
        turning = (arm[0] * directions[:, 1] - arm[1] * directions[:, 0]) ** 2 / INERTIA[0]
    else:
        turning = (np.cross(arm, directions) ** 2 / INERTIA).sum(1)
    stiffness = (TWO_PI * FREQUENCY) ** 2 / (1.0 / MASS + turning.mean())
    world = held(dim, kind)
    fixed = arm if kind == "weld" else np.zeros(dim)
    for angle in (0.0, 0.8, 2.5):
        c, s = math.cos(angle), math.sin(angle)
        turned = arm.copy()
        turned[:2] = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
        for direction in directions[:3]:
            stretch = 0.05 * direction if kind == "weld" else (LENGTH + 0.05) * direction
            pose: Any = {"angle": angle}
            if dim == 3:
                pose = {"orientation": (math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))}
            world.set_pose("body", position=fixed + stretch - turned, **pose)
            world.set_velocity("body", linear=np.zeros(dim), angular=0.0 if dim == 2 else np.zeros(3))
            stored = float(world.diagnostics().spring_energy[0])
            world.step()
            force = MASS * world.state.bodies["velocity"][0, 1, :dim] / world.timestep
            np.testing.assert_allclose(force, -stiffness * 0.05 * direction, rtol=5e-3, atol=1e-3)
            if kind == "distance":
                assert stored == pytest.approx(0.5 * stiffness * 0.05**2, rel=5e-3)
