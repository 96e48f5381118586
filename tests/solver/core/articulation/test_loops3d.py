"""Loops, ropes and soft welds in 3D joint coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Ball, Box, Capsule, Distance, Hinge, Sphere, Weld
from tests.solver.bits import everything
from tests.solver.core.articulation.linkages import PINS, G, four_bar_poses, turn_after
from tests.solver.core.articulation.opened import articulated

Array = np.ndarray[Any, Any]
BARS = np.linalg.norm(np.diff(PINS, axis=0), axis=1) ** 2 / 12.0  # kg m^2


def four_bar() -> Scene:
    """The linkage of linkages.four_bar in the plane y = 0, of hinges: three of the five rows at c are redundant."""
    scene = Scene(gravity=(0.0, 0.0, -G), dim=3)
    scene.add_body("frame", "static")
    pins = np.stack([PINS[:, 0], np.zeros(4), PINS[:, 1]], -1)
    for k, name in enumerate(("crank", "coupler", "rocker")):
        way = pins[k + 1] - pins[k]
        turn = -np.arctan2(way[2], way[0])  # about y
        length = float(np.linalg.norm(way))
        shape = Box(half_extents=(0.5 * length, 0.02, 0.02), mask=0)
        inertia = np.diag([1e-3, length**2 / 12.0, length**2 / 12.0])
        turned = (np.cos(turn / 2), 0.0, np.sin(turn / 2), 0.0)
        at: Any = {"position": 0.5 * (pins[k] + pins[k + 1]), "orientation": turned}
        scene.add_body(name, shapes=[shape], mass=1.0, inertia=inertia, **at)
    for name, a, b, k in (
        ("a", "frame", "crank", 0),
        ("b", "crank", "coupler", 1),
        ("c", "coupler", "rocker", 2),
        ("d", "rocker", "frame", 3),
    ):
        scene.add_joint(name, Hinge(a, b, anchor=pins[k], axis=(0.0, -1.0, 0.0)))
    return scene


def test_a_linkage_of_hinges_moves_as_in_the_plane() -> None:
    exact = turn_after(four_bar_poses, BARS, 1.0, 2000)
    errors = []
    for rate in (120, 480):
        world = articulated(four_bar(), timestep=1.0 / rate, substeps=1, sleep=False)
        world.step(rate)
        errors.append(abs(world.joint_coordinate("a")[0] - exact))
        diagnostics = world.diagnostics()
        assert diagnostics.rows[0] == 5
        assert diagnostics.relative_joint_error[0] < 1e-4
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] > 8.0  # 16 at second order


def test_a_linkage_of_hinges_stays_closed_and_gains_no_energy() -> None:
    world = articulated(four_bar(), sleep=False)
    start = world.diagnostics().energy[0]
    kinetic = 0.0
    for _ in range(600):
        world.step()
        now = world.diagnostics()
        kinetic = max(kinetic, now.kinetic_energy[0])
        assert now.relative_joint_error[0] < 1e-3
        assert now.energy[0] < start + 5e-3 * kinetic + 1e-9
    assert now.energy[0] > start - 0.05 * kinetic


def hand_with_crate(soft: bool = False) -> Scene:
    """Two limbs of unequal moments on balls, the upper one on a hook, and a crate on a rope or a soft weld."""
    scene = Scene(gravity=(0.0, 0.0, -G), dim=3)
    scene.add_body("hook", "static")
    for k in range(2):
        limb = Capsule(half_length=0.15, radius=0.05, mask=0)
        turned = (np.cos(np.pi / 4), 0.0, np.sin(np.pi / 4), 0.0)
        scene.add_body(f"limb_{k}", shapes=[limb], position=(0.15 + 0.3 * k, 0.0, 0.0), orientation=turned, mass=1.0)
        pair = ("hook" if k == 0 else "limb_0", f"limb_{k}")
        scene.add_joint(f"ball_{k}", Ball(*pair, anchor=(0.3 * k, 0.0, 0.0)))
    crate = Box(half_extents=(0.1, 0.05, 0.15), mask=0)
    if soft:
        scene.add_body("crate", shapes=[crate], position=(0.7, 0.0, 0.0), mass=2.0)
        scene.add_joint("glue", Weld("limb_1", "crate", frequency=6.0, damping_ratio=0.3))
    else:
        scene.add_body("crate", shapes=[crate], position=(0.6, 0.1, -0.5), mass=2.0)
        ends: Any = {"anchor_a": (0.0, 0.0, 0.15), "anchor_b": (0.05, 0.0, 0.15)}
        scene.add_joint("rope", Distance("limb_1", "crate", **ends, limits=(0.0, 0.4)))
    return scene


@pytest.mark.parametrize("soft", [False, True])
def test_motion_is_that_of_rows_at_small_timesteps(soft: bool) -> None:
    def after(rate: int, on: bool) -> Array:
        options = Options(articulated=on, timestep=1.0 / rate, substeps=1, sleep=False, tolerance=1e-7)
        world = World(hand_with_crate(soft), options=options)
        world.step(rate // 4)
        return world.position[0, 1:]

    exact = after(7680, False)
    errors = [np.abs(after(rate, True) - exact).max() for rate in (120, 480)]
    assert errors[1] < 2e-3
    assert errors[1] < 0.5 * errors[0]


def test_a_crate_hangs_from_a_hand() -> None:
    world = articulated(hand_with_crate(), sleep=False)
    for body in ("limb_0", "limb_1", "crate"):
        world.parameters.set(body, linear_damping=3.0, angular_damping=3.0)
    for _ in range(900):
        world.step()
        assert world.diagnostics().relative_joint_error[0] < 1e-3
    assert_allclose(world.joint_reaction("rope")[0, :3], (0.0, 0.0, 2.0 * G), atol=0.05)
    assert_allclose(world.joint_reaction("ball_0")[0, :3], (0.0, 0.0, 4.0 * G), atol=0.05)
    assert world.diagnostics().rows[0] == 1


def test_a_snapshot_continues_bit_for_bit() -> None:
    worlds = [articulated(four_bar()) for _ in range(2)]
    worlds[0].step(20)
    worlds[1].restore(worlds[0].save())
    for world in worlds:
        world.step(20)
    assert everything(worlds[0]) == everything(worlds[1])


def test_a_ball_that_rolls_stops_by_rolling_friction() -> None:
    """Rolling friction in joint coordinates: a ball on a light axle decelerates by d g / (r (1 + k)), k = 2/5."""
    scene = Scene(gravity=(0.0, 0.0, -G), dim=3)
    floor = Box(half_extents=(5.0, 5.0, 0.5), friction=1.0, rolling_friction=0.01)
    scene.add_body("floor", "static", shapes=[floor], position=(0.0, 0.0, -0.5))
    ball = Sphere(radius=0.2, friction=1.0, rolling_friction=0.01)
    motion: Any = {"linear_velocity": (1.0, 0.0, 0.0), "angular_velocity": (0.0, 5.0, 0.0)}
    scene.add_body("ball", shapes=[ball], position=(0.0, 0.0, 0.2), mass=1.0, **motion)
    scene.add_body("vane", shapes=[Sphere(radius=0.01, mask=0)], position=(0.0, 0.0, 0.2), mass=1e-6, **motion)
    scene.add_joint("axle", Weld("ball", "vane"))
    world = articulated(scene, sleep=False)
    world.step(60)
    stiffness = 0.01 * G / (0.2 * 1.4)
    assert world.linear_velocity[0, 1, 0] == pytest.approx(1.0 - stiffness, rel=1e-2)


def test_a_ball_that_spins_stops_by_torsional_friction() -> None:
    """Torsional friction d gives the torque d m g against the spin: I w' = -d m g."""
    scene = Scene(gravity=(0.0, 0.0, -G), dim=3)
    floor = Box(half_extents=(5.0, 5.0, 0.5), friction=1.0, torsional_friction=0.01)
    scene.add_body("floor", "static", shapes=[floor], position=(0.0, 0.0, -0.5))
    ball = Sphere(radius=0.2, friction=1.0, torsional_friction=0.01)
    spin: Any = {"angular_velocity": (0.0, 0.0, 8.0)}
    scene.add_body("ball", shapes=[ball], position=(0.0, 0.0, 0.2), mass=1.0, **spin)
    scene.add_body("vane", shapes=[Sphere(radius=0.01, mask=0)], position=(0.0, 0.0, 0.2), mass=1e-6, **spin)
    scene.add_joint("axle", Weld("ball", "vane"))
    world = articulated(scene, sleep=False)
    world.step(60)
    assert world.angular_velocity[0, 1, 2] == pytest.approx(8.0 - 0.01 * G / (0.4 * 0.04), rel=1e-2)
