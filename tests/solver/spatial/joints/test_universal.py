"""Universal: the closed form of a Cardan shaft, its momenta, and motors on its axes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, World
from gsenv.solver.spatial import Axis, Box, Cylinder, Hinge, Universal
from tests.solver.spatial.joints.rigs import held, scene_of
from tests.solver.spatial.one_kernel import full_world, space


def shafts(bend: float, speed: float, options: Options) -> World:
    """Two shafts in bearings at an angle ``bend``, joined by a universal joint at the origin; the first is driven."""
    scene = space()
    scene.add_body("base", "static")
    way = np.array((math.cos(bend), math.sin(bend), 0))
    for name, place, axis in (("in", (-0.5, 0, 0), (1.0, 0, 0)), ("out", 0.5 * way, way)):
        shape = Cylinder(half_length=0.3, radius=0.1, mask=0)
        turn = np.array((1.0, *np.cross((0, 0, 1), axis)))  # half way from z to the axis
        scene.add_body(name, shapes=[shape], position=place, orientation=turn, mass=1.0)
        drive: dict[str, Any] = {"motor_speed": speed, "motor_effort": 1e4} if name == "in" else {}
        scene.add_joint(name, Hinge("base", name, anchor=place, axis=axis, **drive))
    cross = Universal("in", "out", anchor=(0, 0, 0), axis_a=(0, 0, 1), axis_b=(-math.sin(bend), math.cos(bend), 0))
    scene.add_joint("cross", cross)
    return full_world(scene, options=options)


@pytest.mark.parametrize("bend", [0.0, 0.4, 0.9])
def test_cardan_shaft_has_the_speed_ratio_of_its_closed_form(bend: float) -> None:
    """tan q_out = cos(bend) tan q_in, so that the ratio of speeds is cos(b) / (1 - sin(b)^2 sin(q_in)^2)."""
    world = shafts(bend, 4.0, Options(timestep=1 / 120, sleep=False))
    world.step(2)
    for _ in range(400):  # two turns
        world.step()
        q = world.joint_coordinate("in")[0]
        rate = math.cos(bend) / (1.0 - (math.sin(bend) * math.sin(q)) ** 2)
        assert world.joint_rate("in")[0] == pytest.approx(4.0, rel=2e-3)
        assert world.joint_rate("out")[0] / world.joint_rate("in")[0] == pytest.approx(rate, rel=1e-2)
        expected = q + math.atan2((math.cos(bend) - 1.0) * math.tan(q), 1.0 + math.cos(bend) * math.tan(q) ** 2)
        assert world.joint_coordinate("out")[0] == pytest.approx(expected, abs=5e-3)
        assert world.diagnostics().joint_error[0] < 2e-3
    assert world.joint_coordinate("out")[0] > 4.0 * math.pi


def test_free_pair_keeps_momenta_and_energy() -> None:
    scene = space()
    for k in range(2):
        scene.add_body(
            f"b{k}", shapes=[Box(half_extents=(0.3, 0.1, 0.2), mask=0)], position=(0.8 * k, 0, 0),
            angular_velocity=(0.5, 1.0 - 2.0 * k, 0.3), linear_velocity=(0, 0.12, 0),
        )  # fmt: skip
    scene.add_joint("joint", Universal("b0", "b1", anchor=(0.4, 0, 0), axis_a=(0, 0, 1), axis_b=(0, 1, 0)))
    world = full_world(scene, options=Options(timestep=1 / 240, sleep=False))
    world.step(2)  # the joint first stops the twist
    start = world.diagnostics()
    for _ in range(480):
        world.step()
        d = world.diagnostics()
        assert d.joint_error[0] < 1e-3
        assert_allclose(d.momentum, start.momentum, atol=1e-9)
    assert_allclose(d.angular_momentum, start.angular_momentum, atol=3e-3 * abs(start.angular_momentum).max())
    assert d.energy[0] == pytest.approx(start.energy[0], rel=3e-3)
    twist = world.angular_velocity[0, 1] - world.angular_velocity[0, 0]
    assert np.isfinite(twist).all()


def test_each_axis_has_its_motor_and_limits() -> None:
    joint = Universal(
        "base", "it", anchor=(0, 0, 0), axis_a=(0, 0, 1), axis_b=(0, 1, 0),
        turn_a=Axis(motor_speed=1.0, motor_effort=50.0), turn_b=Axis(frequency=2.0, rest=0.4, limits=(-0.5, 0.3)),
    )  # fmt: skip
    world = held(joint)
    world.step(180)
    assert world.joint_rate("joint/turn_a")[0] == pytest.approx(1.0, rel=1e-3)
    assert world.joint_coordinate("joint/turn_a")[0] == pytest.approx(3.0, abs=0.02)
    assert world.joint_coordinate("joint/turn_b")[0] == pytest.approx(0.3, abs=2e-3)
    world.set_motor("joint/turn_a", speed=-1.0)
    world.parameters.set("joint/turn_b", upper=0.1)
    world.step(60)
    assert world.joint_rate("joint/turn_a")[0] == pytest.approx(-1.0, rel=1e-3)
    assert world.joint_coordinate("joint/turn_b")[0] == pytest.approx(0.1, abs=2e-3)


def test_axes_must_be_perpendicular() -> None:
    with pytest.raises(ValueError, match=r"axis_a and axis_b must be perpendicular, the cosine of their angle is 0.6"):
        scene_of(Universal("base", "it", axis_a=(0, 0, 1), axis_b=(0, 0.8, 0.6)))
    with pytest.raises(ValueError, match="joint 'joint/turn_a' must be an Axis"):
        scene_of(Universal("base", "it", axis_a=(0, 0, 1), axis_b=(0, 1, 0), turn_a=(-1, 1)))  # type: ignore[arg-type]
