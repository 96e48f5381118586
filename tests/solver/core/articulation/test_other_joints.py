"""Joints in no tree as rows in joint space: ropes, gears, targets, soft welds, user constraints, kinematic holders."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Capsule, Circle, Distance, Gear, HalfPlane, Revolute, Target, Weld
from tests.solver.core.articulation.linkages import G, add_bar
from tests.solver.core.articulation.opened import articulated

Array = np.ndarray[Any, Any]


def arm(count: int = 3, **joint: Any) -> Scene:
    """Level bars of 0.3 m and 1 kg on a hook."""
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("hook", "static")
    for k in range(count):
        add_bar(scene, f"bar_{k}", (0.3 * k, 0.0), (0.3 * k + 0.3, 0.0))
        pair = ("hook" if k == 0 else f"bar_{k - 1}", f"bar_{k}")
        scene.add_joint(f"joint_{k}", Revolute(*pair, anchor=(0.3 * k, 0.0), **joint))
    return scene


def with_rope() -> Scene:
    """A crate of 2 kg on a taut rope of 0.4 m below the end of the arm."""
    scene = arm()
    crate = Box(half_extents=(0.1, 0.1), mask=0)
    scene.add_body("crate", shapes=[crate], position=(0.9, -0.5), mass=2.0, inertia=0.02)
    scene.add_joint("rope", Distance("bar_2", "crate", anchor_a=(0.15, 0.0), anchor_b=(0.0, 0.1), limits=(0.0, 0.4)))
    return scene


def with_rod() -> Scene:
    scene = arm()
    scene.add_body("bob", shapes=[Circle(radius=0.1, mask=0)], position=(0.9, -0.4), mass=2.0, inertia=0.02)
    scene.add_joint("rod", Distance("bar_2", "bob", anchor_a=(0.15, 0.0)))
    return scene


def with_spring() -> Scene:
    scene = arm()
    scene.add_joint("spring", Distance("hook", "bar_2", anchor_b=(0.15, 0.0), stiffness=30.0, damping=0.5))
    return scene


def with_soft_weld() -> Scene:
    scene = arm()
    scene.add_body("head", shapes=[Circle(radius=0.1, mask=0)], position=(1.0, 0.0), mass=0.5, inertia=0.01)
    scene.add_joint("glue", Weld("bar_2", "head", frequency=3.0, damping_ratio=0.1))
    return scene


def with_gear() -> Scene:
    """Two geared wheels with heavy rims on a swinging bar."""
    scene = arm(1)
    for k in range(2):
        wheel = Circle(radius=0.1, mask=0)
        scene.add_body(f"wheel_{k}", shapes=[wheel], position=(0.15 + 0.15 * k, 0.0), mass=1.0, inertia=0.02)
        scene.add_body(f"rim_{k}", shapes=[wheel], position=(0.15 + 0.15 * k, 0.1 + 0.05 * k), mass=0.5, inertia=0.01)
        scene.add_joint(f"glue_{k}", Weld(f"wheel_{k}", f"rim_{k}"))
        scene.add_joint(f"pin_{k}", Revolute("bar_0", f"wheel_{k}", anchor=(0.15 + 0.15 * k, 0.0)))
    scene.add_joint("gear", Gear("pin_0", "pin_1", ratio=0.5))
    return scene


def with_target() -> Scene:
    scene = arm()
    scene.add_joint("mouse", Target("bar_2", frequency=2.0, damping_ratio=0.5, max_force=60.0, max_torque=0.0))
    return scene


def with_constraint() -> Scene:
    """The last bar keeps its angle."""
    scene = arm()
    scene.add_constraint("level", ["bar_2"], [[0.0, 0.0, 1.0]])
    return scene


SECONDS = {with_rope: 0.2}  # before the rope is slack, taut again, and chaos begins
SCENES = [with_rope, with_rod, with_spring, with_soft_weld, with_gear, with_target, with_constraint]


def after(scene: Scene, rate: int, seconds: float, on: bool, **options: Any) -> Array:
    options = {"timestep": 1.0 / rate, "substeps": 1, "sleep": False, "tolerance": 1e-7, **options}
    world = World(scene, options=Options(articulated=on, **options))
    world.step(round(rate * seconds))
    assert world.diagnostics().unconverged[0] == 0
    return world.position[0, 1:]


@pytest.mark.parametrize("build", SCENES)
def test_motion_is_that_of_rows_at_small_timesteps(build: Callable[[], Scene]) -> None:
    seconds = SECONDS.get(build, 0.5)
    exact = after(build(), 7680, seconds, False)
    errors = [np.abs(after(build(), rate, seconds, True) - exact).max() for rate in (120, 480)]
    print(build.__name__, errors)
    assert errors[1] < 2e-3
    assert errors[1] < 0.5 * errors[0] or errors[1] < 1e-4


@pytest.mark.parametrize(
    "build", [build for build in SCENES if build is not with_soft_weld and build is not with_constraint]
)
def test_joints_hold_for_ten_seconds(build: Callable[[], Scene]) -> None:
    world = articulated(build(), sleep=False)
    start = world.diagnostics().energy[0]
    kinetic = 0.0
    for _ in range(600):
        world.step()
        now = world.diagnostics()
        assert now.relative_joint_error[0] < 1e-3
        assert now.rows[0] <= 3
        kinetic = max(kinetic, now.kinetic_energy[0])
        assert build is with_target or now.energy[0] < start + 5e-3 * kinetic + 1e-9


def test_a_crate_hangs_with_its_weight() -> None:
    world = articulated(with_rope())
    for body in ("bar_0", "bar_1", "bar_2", "crate"):
        world.parameters.set(body, linear_damping=2.0, angular_damping=2.0)
    world.step(1200)
    assert world.joint_reaction("rope")[0, 1] == pytest.approx(2.0 * G, rel=1e-3)
    assert world.joint_reaction("joint_0")[0, 1] == pytest.approx(5.0 * G, rel=1e-3)
    assert_allclose(world.position[0, -1], (0.0, -1.4), atol=2e-3)


def test_a_crate_on_a_rope_lands_on_the_ground() -> None:
    """The ground carries the crate, and the rope is slack."""
    scene = arm(1)
    scene.add_body("floor", "static", shapes=[HalfPlane((0.0, 1.0))], position=(0.0, -1.0))
    scene.add_body("crate", shapes=[Box(half_extents=(0.1, 0.1))], position=(0.3, -0.5), mass=2.0)
    rope = Distance("bar_0", "crate", anchor_a=(0.15, 0.0), anchor_b=(0.0, 0.1), limits=(0.0, 0.8))
    scene.add_joint("rope", rope)
    world = articulated(scene)
    world.parameters.set("bar_0", linear_damping=3.0, angular_damping=3.0)
    world.step(300)
    assert world.position[0, -1, 1] == pytest.approx(-0.9, abs=1e-3)
    assert_allclose(world.joint_reaction("rope"), 0.0, atol=1e-6)
    assert world.joint_reaction("joint_0")[0, 1] == pytest.approx(G, rel=1e-3)
    assert world.contacts().impulse[:, 0].sum() / world.timestep == pytest.approx(2.0 * G, rel=1e-3)


def test_gears_share_a_torque() -> None:
    """Wheels of inertias I and J on fixed pins turn as one: q_a = -k q_b."""
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("frame", "static")
    inertias = (0.3, 0.7)
    for k, inertia in enumerate(inertias):
        wheel = Circle(radius=0.2, mask=0)
        scene.add_body(f"wheel_{k}", shapes=[wheel], position=(0.5 * k, 0.0), mass=1.0, inertia=inertia)
        scene.add_joint(f"pin_{k}", Revolute("frame", f"wheel_{k}", anchor=(0.5 * k, 0.0)))
    scene.add_joint("gear", Gear("pin_0", "pin_1", ratio=2.0))
    world = articulated(scene, sleep=False)
    for _ in range(60):
        world.apply_force("wheel_0", torque=1.5)
        world.step()
    rate = 1.5 / (inertias[0] + inertias[1] / 4.0)
    assert world.joint_rate("pin_0")[0] == pytest.approx(rate, rel=1e-6)
    assert world.joint_coordinate("pin_0")[0] == pytest.approx(0.5 * rate, rel=1e-6)
    assert world.joint_coordinate("gear")[0] == pytest.approx(0.0, abs=1e-9)
    assert world.diagnostics().rows[0] == 1


def test_a_target_moves_the_end_of_an_arm() -> None:
    world = articulated(with_target())
    for body in ("bar_0", "bar_1", "bar_2"):
        world.parameters.set(body, linear_damping=3.0, angular_damping=3.0)
    world.set_target("mouse", position=(0.3, -0.3))
    world.step(900)
    stiffness = 1.0 * (2.0 * np.pi * 2.0) ** 2
    drop = -0.3 - world.position[0, 3, 1]
    force = world.joint_reaction("mouse")[0, :2]
    assert_allclose(force[1], stiffness * drop, rtol=1e-3)
    assert_allclose(force + world.joint_reaction("joint_0")[0, :2], (0.0, 3.0 * G), atol=0.03)


def test_a_rope_that_is_cut_lets_go() -> None:
    world = articulated(with_rope(), sleep=False)
    world.step(20)
    world.parameters.set("rope", enabled=False)
    height, speed = world.position[0, 4, 1], world.linear_velocity[0, 4, 1]
    world.step(30)
    assert world.position[0, 4, 1] == pytest.approx(height + 0.5 * speed - 0.125 * G, abs=1e-9)
    assert world.diagnostics().rows[0] == 0


def suspension_bridge(planks: int = 12) -> Scene:
    """Planks on revolute joints between two banks, hung by ropes from a beam above."""
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("bank", "static")
    for k in range(planks):
        shape = Capsule(half_length=0.1, radius=0.02, mask=0)
        scene.add_body(f"plank_{k}", shapes=[shape], position=(0.2 * k + 0.1, 0.0), mass=1.0, inertia=0.2**2 / 12.0)
        pair = ("bank" if k == 0 else f"plank_{k - 1}", f"plank_{k}")
        scene.add_joint(f"joint_{k}", Revolute(*pair, anchor=(0.2 * k, 0.0)))
        rope = Distance("bank", f"plank_{k}", anchor_a=(0.2 * k + 0.1, 1.0), limits=(0.0, 1.0))
        scene.add_joint(f"rope_{k}", rope)
    scene.add_joint("end", Revolute(f"plank_{planks - 1}", "bank", anchor=(0.2 * planks, 0.0)))
    return scene


def test_a_suspension_bridge_carries_a_load() -> None:
    world = articulated(suspension_bridge(), sleep=False)
    for _ in range(300):
        world.apply_force("plank_5", force=(0.0, -100.0))
        world.step()
        assert world.diagnostics().relative_joint_error[0] < 5e-3
    ropes = sum(world.joint_reaction(f"rope_{k}")[0, 1] for k in range(12))
    ends = world.joint_reaction("joint_0")[0, 1] - world.joint_reaction("end")[0, 1]
    assert ropes + ends == pytest.approx(12.0 * G + 100.0, rel=2e-3)
