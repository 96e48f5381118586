"""Links of one robot that touch each other: friction and joints may let a contact bear any force."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar
from gsenv.solver.spatial import Box, Capsule, Hinge


def arm_of_boxes() -> Scene:
    """Three links on hinges, of which the first and the third touch."""
    scene = Scene(dim=3)
    scene.add_body("base", "static")
    for name, position, mass in (("a", (0.1, 0.1, 1), None), ("b", (0.2, 0.2, 1.2), None), ("c", (0.2, 0.2, 1.2), 1.0)):
        shape = Box((0.1, 0.1, 0.1), friction=1.0, density=500)
        scene.add_body(name, shapes=[shape], position=position, mass=mass)
    scene.add_joint("j1", Hinge("base", "a", anchor=(0, 0, 1), axis=(0, 1, 0)))
    scene.add_joint("j2", Hinge("a", "b", anchor=(0.2, 0, 1), axis=(1, 0, 0)))
    scene.add_joint("j3", Hinge("b", "c", anchor=(0.2, 0.2, 1.2), axis=(0, 1, 0)))
    return scene


@pytest.mark.parametrize("timestep", [1 / 240, 1 / 1000, 1 / 4000])
def test_links_that_touch_do_not_lock_the_joints(timestep: float) -> None:
    world = World(arm_of_boxes(), options=Options(timestep=timestep, sleep=False))
    world.step(round(0.3 / timestep))
    # 1.369 rad by rows at 1/4000 s
    assert world.joint_coordinate("j1")[0] == pytest.approx(1.369, abs=0.015)
    assert world.diagnostics().unconverged[0] == 0


def random_arm(dim: int, seed: int) -> Scene:
    """Four capsules on hinges, with friction 1 between them."""
    rng = np.random.default_rng(seed)
    scene = Scene(dim=dim)
    scene.add_body("base", "static")
    point = np.zeros(dim)
    for k in range(4):
        length, radius = rng.uniform(0.1, 0.4), rng.uniform(0.03, 0.08)
        along = rng.normal(size=dim)
        along /= np.linalg.norm(along)
        before, name = f"link {k - 1}" if k else "base", f"link {k}"
        position = tuple(point + 0.5 * length * along)
        if dim == 2:
            flat = planar.Capsule(half_length=0.5 * length, radius=radius, friction=1.0, density=500)
            scene.add_body(name, shapes=[flat], position=position, angle=float(np.arctan2(along[1], along[0])))
            scene.add_joint(f"joint {k}", planar.Revolute(before, name, anchor=tuple(point)))
        else:
            shape = Capsule(half_length=0.5 * length, radius=radius, friction=1.0, density=500)
            turn = (1.0 + along[2], -along[1], along[0], 0.0)  # from z to ``along``
            scene.add_body(name, shapes=[shape], position=position, orientation=turn)
            axis = rng.normal(size=3)
            scene.add_joint(f"joint {k}", Hinge(before, name, anchor=tuple(point), axis=tuple(axis)))
        point = point + length * along
    return scene


@pytest.mark.parametrize("dim", [2, 3])
def test_contact_forces_of_folded_arms_are_bounded(dim: int) -> None:
    # before contacts had a compliance and a start from zero, every tenth arm had more than 1e5 times its weight
    worst = 0.0
    for seed in range(40):
        world = World(random_arm(dim, seed), options=Options(timestep=1 / 240, sleep=False))
        weight = 9.81 * world.parameters.mass[0, 1:].sum()
        for _ in range(6):
            world.step(40)
            worst = max(worst, world.contacts().impulse[:, 0].max(initial=0.0) * 240 / weight)
    assert worst < 3000.0
