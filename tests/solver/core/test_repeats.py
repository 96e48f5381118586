"""Joints that repeat another joint of the same bodies: doors on two hinges, pins that are there twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar
from gsenv.solver.spatial import Ball, Box, Hinge, Slider, Weld

AXIS = np.array([0.2, 0.9, 0.3]) / np.hypot.reduce([0.2, 0.9, 0.3])
POINT = np.array([0.55, 0.1, 0.0])
FIRST = Hinge("a", "b", axis=AXIS.tolist(), anchor=POINT.tolist())
SECONDS: dict[str, Any] = {
    "hinge": Hinge("a", "b", axis=(-AXIS).tolist(), anchor=(POINT + 0.3 * AXIS).tolist()),
    "turned round": Hinge("b", "a", axis=AXIS.tolist(), anchor=(POINT - 0.2 * AXIS).tolist()),
    "ball": Ball("a", "b", anchor=(POINT + 0.3 * AXIS).tolist()),
}


def door(*joints: Any, spin: float = 5.0) -> Scene:
    """Two bodies that turn about a common point in space, and their joints."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    w = np.array([0.3, 0.5, 1.0]) * spin
    for name, half, place in (("a", (0.5, 0.2, 0.1), (0.0, 0.0, 0.0)), ("b", (0.3, 0.2, 0.2), (1.1, 0.3, 0.2))):
        scene.add_body(
            name, shapes=[Box(half_extents=half, mask=0)], position=place,
            linear_velocity=np.cross(w, place).tolist(), angular_velocity=w.tolist(),
        )  # fmt: skip
    for k, joint in enumerate(joints):
        scene.add_joint(f"joint_{k}", joint)
    return scene


@pytest.mark.parametrize("articulated", [True, False])
@pytest.mark.parametrize("second", SECONDS)
@pytest.mark.parametrize("first", [0, 1])
def test_a_second_joint_on_the_axis_changes_nothing(second: str, first: int, articulated: bool) -> None:
    """At 5 rad/s and 1/60 s two hinges lost 37 % of the energy, and the joints opened by 4.7 m."""
    options = Options(articulated=articulated, sleep=False)
    joints = [FIRST, SECONDS[second]]
    double = World(door(joints[first], joints[1 - first]), options=options)
    single = World(door(FIRST), options=options)
    start = float(double.diagnostics().energy[0])
    for world in (double, single):
        world.step(300)
    if articulated:  # rows of a hinge depend on where on its axis the anchor is
        np.testing.assert_allclose(double.position, single.position, atol=1e-9)
    assert double.diagnostics().rows[0] == single.diagnostics().rows[0]
    assert double.diagnostics().joint_error[0] < 1e-4
    assert abs(float(double.diagnostics().energy[0]) - start) < 1e-3 * start


def test_the_other_joint_holds_when_the_first_is_disabled() -> None:
    world = World(door(FIRST, SECONDS["hinge"]), options=Options(sleep=False))
    world.step(10)
    world.parameters.set("joint_0", enabled=0)
    world.step(60)
    assert world.diagnostics().joint_error[0] < 1e-4
    world.parameters.set("joint_1", enabled=0)
    world.step(60)
    apart = world.position[0, 1] - world.position[0, 0]
    assert np.hypot.reduce(apart) > 2.0  # they fly apart


def test_a_motor_on_the_second_hinge_acts() -> None:
    driven = Hinge("a", "b", axis=AXIS.tolist(), anchor=POINT.tolist(), motor_speed=2.0, motor_effort=1e3)
    for joints in ((FIRST, driven), (driven, FIRST)):
        world = World(door(*joints, spin=0.0), options=Options(sleep=False))
        world.step(30)
        assert world.joint_rate("joint_0")[0] == pytest.approx(2.0, rel=1e-4)


Maker = Callable[[], Scene]


def planar_pair(*joints: Any) -> Scene:
    scene = Scene(gravity=(0.0, 0.0))
    for k in range(2):
        scene.add_body(
            f"body_{k}", shapes=[planar.Box((0.5, 0.1), mask=0)], position=(float(k), 0.0),
            linear_velocity=(0.0, 5.0 * k), angular_velocity=5.0,
        )  # fmt: skip
    for k, joint in enumerate(joints):
        scene.add_joint(f"joint_{k}", joint)
    return scene


def spatial_pair(*joints: Any) -> Scene:
    scene = Scene(dim=3)
    scene.add_body("a", shapes=[Box((0.1, 0.1, 0.1))])
    scene.add_body("b", shapes=[Box((0.1, 0.1, 0.1))], position=(1.0, 0.0, 0.0))
    for k, joint in enumerate(joints):
        scene.add_joint(f"joint_{k}", joint)
    return scene


def revolute(x: float, **given: Any) -> planar.Revolute:
    return planar.Revolute("body_0", "body_1", anchor=(x, 0.0), **given)


def hinge(axis: tuple[float, float, float], anchor: tuple[float, float, float]) -> Hinge:
    return Hinge("a", "b", axis=axis, anchor=anchor)


@pytest.mark.parametrize(
    ("scene", "repeats"),
    [
        (lambda: planar_pair(revolute(0.5), revolute(0.5)), [-1, 0]),
        (lambda: planar_pair(revolute(0.5), revolute(0.5, limits=(-1.0, 1.0))), [1, -1]),
        (lambda: planar_pair(revolute(0.5), revolute(0.6)), [-1, -1]),
        (lambda: planar_pair(revolute(0.5), planar.Weld("body_0", "body_1")), [-1, -1]),
        (lambda: spatial_pair(hinge((0, 0, 1), (0, 0, 0)), hinge((0, 0, 2), (0, 0, 3))), [-1, 0]),
        (lambda: spatial_pair(hinge((0, 0, 1), (0, 0, 0)), hinge((0, 0, 1), (0, 0.1, 0))), [-1, -1]),
        (lambda: spatial_pair(hinge((0, 0, 1), (0, 0, 0)), hinge((0, 1, 0), (0, 0, 0))), [-1, -1]),
        (lambda: spatial_pair(Ball("a", "b", anchor=(0, 0, 2)), hinge((0, 0, 1), (0, 0, 0))), [1, -1]),
        (lambda: spatial_pair(Ball("a", "b", anchor=(0, 0, 2)), Ball("a", "b", anchor=(0, 0, 3))), [-1, -1]),
        (lambda: spatial_pair(Slider("a", "b", axis=(1, 0, 0)), Slider("b", "a", axis=(-1, 0, 0))), [-1, 0]),
        (lambda: spatial_pair(Slider("a", "b", axis=(1, 0, 0)), hinge((1, 0, 0), (0, 0, 0))), [-1, -1]),
        (lambda: spatial_pair(Weld("a", "b"), Slider("a", "b", axis=(1, 0, 0)), Ball("a", "b")), [-1, -1, -1]),
    ],
)
def test_which_joints_repeat_others(scene: Maker, repeats: list[int]) -> None:
    assert scene().compile().joints["repeats"].tolist() == repeats


def test_pins_that_are_there_twice_in_the_plane() -> None:
    worlds = [
        World(planar_pair(*joints), options=Options(sleep=False)) for joints in ([revolute(0.5)] * 2, [revolute(0.5)])
    ]
    for world in worlds:
        world.step(300)
    np.testing.assert_array_equal(worlds[0].position, worlds[1].position)
