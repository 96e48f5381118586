"""Gears between hinges and sliders, on fixed and on moving bodies: ratio, torque, momenta."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Axis, Ball, Box, Gear, Hinge, Slider, Universal
from tests.solver.spatial.joints.rigs import AXES
from tests.solver.spatial.one_kernel import full_world, space

INERTIA = {"p": 0.3, "q": 0.8}
AWAKE = Options(timestep=1 / 120, sleep=False)


def pair(axis_p: Any, axis_q: Any, ratio: float, base: dict[str, Any], effort: float = 0.5) -> World:
    """Two round bodies on hinges to a "base", coupled by a gear; the first has a motor."""
    scene = space()
    scene.add_body("base", **base)
    for name, place, axis in (("p", (0.4, 0, 0), axis_p), ("q", (-0.3, 0.2, 0), axis_q)):
        moment = INERTIA[name]
        shape = Box(half_extents=(0.1, 0.1, 0.1), mask=0)
        scene.add_body(name, shapes=[shape], position=place, mass=2.0, inertia=(moment, moment, moment))
        motor: dict[str, Any] = {"motor_speed": 100.0, "motor_effort": effort} if name == "p" else {}
        scene.add_joint(f"on_{name}", Hinge("base", name, anchor=place, axis=axis, **motor))
    scene.add_joint("gear", Gear("on_p", "on_q", ratio=ratio))
    return full_world(scene, options=AWAKE)


@pytest.mark.parametrize("ratio", [1.0, -1.0, 2.5, -0.4])
@pytest.mark.parametrize("axes", [("z", "z"), ("x", "z"), ("oblique", "y")])
def test_on_a_fixed_body_the_torque_moves_both(axes: tuple[str, str], ratio: float) -> None:
    """q_p + ratio q_q = 0, and torque = (I_p + I_q / ratio^2) alpha."""
    world = pair(AXES[axes[0]], AXES[axes[1]], ratio, {"kind": "static"})
    world.step(120)
    alpha = 0.5 / (INERTIA["p"] + INERTIA["q"] / ratio**2)
    assert world.joint_rate("on_p")[0] == pytest.approx(alpha, rel=1e-4)
    assert world.joint_rate("on_q")[0] == pytest.approx(-alpha / ratio, rel=1e-4)
    assert world.joint_coordinate("gear")[0] == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("ratio", [1.0, -1.0, 2.5, -0.4])
@pytest.mark.parametrize("axes", [("z", "z"), ("x", "z"), ("oblique", "y")])
def test_on_a_free_body_momenta_stay_zero(axes: tuple[str, str], ratio: float) -> None:
    free = {"shapes": [Box(half_extents=(0.5, 0.3, 0.2), mask=0)], "mass": 3.0}
    world = pair(AXES[axes[0]], AXES[axes[1]], ratio, free, effort=0.2)
    for _ in range(120):
        world.step()
        d = world.diagnostics()
        assert_allclose(d.momentum, 0.0, atol=1e-10)
        assert abs(world.joint_coordinate("gear")[0]) < 2e-3
        assert d.joint_error[0] < 1e-3
    spin = 0.3 * abs(world.joint_rate("on_p")[0])
    assert spin > 0.01
    assert np.abs(d.angular_momentum).max() < 2e-3 * spin + 1e-4
    assert world.joint_rate("on_p")[0] == pytest.approx(-ratio * world.joint_rate("on_q")[0], rel=5e-3, abs=1e-4)


def test_rack_and_pinion() -> None:
    scene = space()
    scene.add_body("base", "static")
    scene.add_body("pinion", shapes=[Box(half_extents=(0.1, 0.1, 0.1), mask=0)], mass=1.0, inertia=(0.3, 0.3, 0.3))
    scene.add_body("rack", shapes=[Box(half_extents=(0.5, 0.1, 0.1), mask=0)], position=(0.2, 0, 1), mass=4.0)
    scene.add_joint("hinge", Hinge("base", "pinion", axis=(0, 1, 0), motor_speed=100.0, motor_effort=1.0))
    scene.add_joint("slide", Slider("base", "rack", anchor_a=(0, 0, 1), anchor_b=(0, 0, 0), axis=(1, 0, 0)))
    scene.add_joint("gear", Gear("hinge", "slide", ratio=-5.0))  # radius 0.2 m
    world = full_world(scene, options=AWAKE)
    assert world.joint_coordinate("slide")[0] == pytest.approx(0.2)
    assert world.joint_coordinate("gear")[0] == pytest.approx(0.0, abs=1e-12)
    world.step(120)
    alpha = 1.0 / (0.3 + 4.0 * 0.2**2)
    assert world.joint_rate("hinge")[0] == pytest.approx(alpha, rel=1e-4)
    assert world.joint_rate("slide")[0] == pytest.approx(0.2 * alpha, rel=1e-4)


def bench() -> Scene:
    scene = space()
    scene.add_body("base", "static")
    box = Box(half_extents=(0.1, 0.1, 0.1), mask=0)
    for k, name in enumerate(("a", "b", "c")):
        scene.add_body(name, shapes=[box], position=(k, 0, 0))
    scene.add_joint("on_base", Hinge("base", "a", axis=(0, 0, 1)))
    scene.add_joint("on_a", Hinge("a", "b", axis=(0, 0, 1)))
    scene.add_joint("same", Hinge("a", "c", anchor=(1, 0, 0.5), axis=(0, 0, 1)))
    scene.add_joint("slide", Slider("a", "c", axis=(0, 0, 1)))
    scene.add_joint("ball", Ball("base", "c", axis=(0, 0, 1), cone=1.0))
    scene.add_joint("cross", Universal("base", "c", axis_a=(0, 0, 1), axis_b=(1, 0, 0), turn_a=Axis()))
    return scene


@pytest.mark.parametrize(
    ("one", "other", "ratio", "message"),
    [
        ("on_base", "ball", 1.0, "a gear couples hinge, slider and joints' coordinates, 'ball' is a ball"),
        ("on_base", "ball/swing", 1.0, "'ball/swing' is a axis"),
        ("on_a", "slide", 0.0, "ratio must not be 0"),
        ("on_base", "on_base", 1.0, "a gear couples two different joints"),
    ],
)
def test_refusals(one: str, other: str, ratio: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        bench().add_joint("gear", Gear(one, other, ratio=ratio))
