"""2D wheels and limits in joint coordinates: closed forms and the rows of joints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.scenes import car
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, HalfPlane, Wheel
from tests.solver.core.articulation.opened import articulated
from tests.solver.core.articulation.test_step import G, servo
from tests.validation.test_car import Car


def cart(flipped: bool = False, gravity: float = G, **wheel: Any) -> Scene:
    """A box on two wheels with springs."""
    scene = Scene(gravity=(0.0, -gravity))
    scene.add_body("ground", "static", shapes=[HalfPlane(friction=0.8)])
    scene.add_body("box", shapes=[Box(half_extents=(0.8, 0.2))], position=(0.0, 0.8), mass=10.0)
    for k, x in enumerate((-0.5, 0.6)):
        scene.add_body(f"wheel_{k}", shapes=[Circle(radius=0.3, friction=0.8)], position=(x, 0.3), mass=1.0)
        pair = (f"wheel_{k}", "box") if flipped else ("box", f"wheel_{k}")
        scene.add_joint(f"axle_{k}", Wheel(*pair, axis=(0.1, 1.0), anchor=(x, 0.3), **wheel))
    return scene


def ends(scene: Scene, steps: int, rate: int) -> list[World]:
    """Worlds after the steps, in joint coordinates and by rows."""
    worlds = []
    for on in (True, False):
        options = Options(timestep=1.0 / rate, substeps=1, max_substeps=1, sleep=False, articulated=on)
        world = World(scene, options=options)
        world.step(steps)
        worlds.append(world)
    return worlds


DRIVES: list[dict[str, Any]] = [
    {"motor_speed": -8.0, "motor_effort": 3.0},
    {"motor_speed": -8.0, "motor_effort": 3.0, "armature": 0.1, "friction_effort": 0.2},
    {"limits": (-0.05, 0.02)},
    {"limits": (-0.01, 0.02), "limit_frequency": 6.0, "limit_damping_ratio": 0.3},
]


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("drive", DRIVES)
def test_a_cart_moves_as_by_rows(drive: dict[str, Any], flipped: bool) -> None:
    ours, rows = ends(cart(flipped, stiffness=800.0, damping=20.0, **drive), 1000, 2000)
    assert ours.diagnostics().rows[0] < rows.diagnostics().rows[0]
    assert_allclose(ours.position, rows.position, atol=1e-3)
    assert_allclose(ours.linear_velocity, rows.linear_velocity, atol=1e-2)
    assert_allclose(ours.angular_velocity, rows.angular_velocity, atol=5e-2)
    for k in range(2):
        axle = f"axle_{k}"
        assert_allclose(ours.joint_coordinate(axle), rows.joint_coordinate(axle), atol=1e-4)
        assert_allclose(ours.joint_reaction(axle), rows.joint_reaction(axle), atol=1.0)
    impulses = [2000.0 * world.state.joints["impulse"] for world in (ours, rows)]
    assert_allclose(impulses[0][..., 1:], impulses[1][..., 1:], atol=1.0)


@pytest.mark.parametrize("part", [0.5, 0.99, 1.03, 2.0])
def test_a_car_grips_up_to_its_limit(part: float) -> None:
    friction = 0.5
    torque = part * Car(articulated(car(friction=friction)), friction).grip_limit()
    world = articulated(car(torque=torque, friction=friction), sleep=False)
    built = Car(world, friction)
    world.step(30)
    before = world.linear_velocity[0, built.chassis, 0]
    world.step(30)
    expected = built.gripping(torque) if part < 1.0 else built.slipping(torque)
    assert_allclose(2.0 * (world.linear_velocity[0, built.chassis, 0] - before), expected, rtol=1e-2)
    assert world.diagnostics().joint_error[0] < 1e-13


@pytest.mark.parametrize("flipped", [False, True])
def test_a_free_cart_keeps_momentum_and_energy(flipped: bool) -> None:
    drifts = []
    for rate in (120, 240):
        world = articulated(cart(flipped, 0.0, stiffness=800.0), timestep=1.0 / rate, substeps=1, sleep=False)
        world.set_pose("ground", position=(0.0, -50.0))
        world.set_velocity("box", linear=(1.0, 0.5), angular=1.0)
        world.step(2)  # the first brings the wheels along
        start = world.diagnostics()
        world.step(rate)
        end = world.diagnostics()
        assert end.rows[0] == 0
        momentum = np.append(end.momentum - start.momentum, end.angular_momentum - start.angular_momentum)
        drifts.append([abs(momentum).max(), abs(end.energy - start.energy)[0] / start.energy[0]])
    print(drifts)
    assert drifts[0][0] < 1e-4
    assert drifts[0][1] < 2e-3
    assert drifts[1][1] < 0.35 * drifts[0][1]


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a_limit_bounces_by_newtons_law(restitution: float) -> None:
    world = servo(limits=(-1.0, 0.1), limit_restitution=restitution)
    for rod, side in (("rod_0", 1.0), ("rod_1", -1.0)):
        world.set_velocity(rod, linear=(0.0, side), angular=2.0 * side)
    world.step(12)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_rate(joint), -2.0 * restitution, atol=1e-9)


def test_a_soft_limit_swings_back_at_its_frequency() -> None:
    """2 Hz on the row's effective mass, 1/12 kg m^2, is 1 Hz on 1/3 kg m^2: half a period of 0.5 s in the limit."""
    world = servo(limits=(-5.0, 0.0), limit_frequency=2.0, limit_damping_ratio=0.0)
    for rod, side in (("rod_0", 1.0), ("rod_1", -1.0)):
        world.set_velocity(rod, linear=(0.0, 0.5 * side), angular=side)
    world.step(15)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_coordinate(joint), 0.5 / np.pi, rtol=2e-2)
    world.step(18)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_rate(joint), -1.0, rtol=2e-2)
