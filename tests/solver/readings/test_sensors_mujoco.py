"""Sensors of a body that swings on a ball joint against those of MuJoCo, which shares no code with gsenv."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.records.model import Array
from gsenv.solver.spatial import AccelerationSensor, Ball, Box, FrameSensor

mujoco = pytest.importorskip("mujoco")

SIZE, PLACE, SITE = (0.1, 0.2, 0.3), (0.3, -0.1, -0.5), (0.4, 0.2, -0.7)
TURN, SPIN = (0.9, 0.3, -0.2, 0.1), np.array((1.0, -2.0, 3.0))
TIMESTEP = 1e-3

MODEL = """
<mujoco><option gravity="0 0 -9.81"><flag contact="disable"/></option>
<worldbody><body><joint type="ball"/><geom type="box" size="0.1 0.2 0.3" pos="0.3 -0.1 -0.5" density="800"/>
<site name="s" pos="0.4 0.2 -0.7"/></body></worldbody>
<sensor><framepos objtype="site" objname="s"/><velocimeter site="s"/><gyro site="s"/><accelerometer site="s"/>
<frameangacc objtype="site" objname="s"/></sensor></mujoco>
"""


def swinging() -> World:
    scene = Scene(dim=3)
    scene.add_body("base", "static")
    scene.add_body("arm", shapes=[Box(half_extents=SIZE, position=PLACE, density=800.0)], orientation=TURN)
    scene.add_joint("pin", Ball("base", "arm", anchor=(0, 0, 0)))
    scene.add_sensor("frame", FrameSensor("arm", position=SITE))
    scene.add_sensor("imu", AccelerationSensor("arm", position=SITE, subtract_gravity=True))
    world = World(scene, options=Options(timestep=TIMESTEP))
    world.set_velocity("arm", linear=np.cross(SPIN, world.center_of_mass[0, 1]), angular=SPIN)
    return world


def readings(world: World, model: Any, data: Any) -> dict[str, Array]:
    """What MuJoCo's sensors read in the present state of the world, along the body's own axes."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, world.orientation[0, 1])
    axes = turn.reshape(3, 3)
    data.qpos[:] = world.orientation[0, 1]
    data.qvel[:] = axes.T @ world.angular_velocity[0, 1]
    mujoco.mj_forward(model, data)
    position, velocity, spin, acceleration, turning = data.sensordata.reshape(5, 3).copy()
    return {
        "frame": np.concatenate([position, velocity, spin]),
        "imu": np.concatenate([acceleration, axes.T @ turning]),
    }


def test_a_body_on_a_ball_joint() -> None:
    world = swinging()
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    assert model.body_mass[1] == pytest.approx(world.parameters.mass[0, 1], rel=1e-12)
    for _ in range(20):
        world.step(19)
        before = readings(world, model, data)
        world.step()
        after = readings(world, model, data)
        frame = world.sensor("frame")[0]
        np.testing.assert_allclose(np.delete(frame, range(3, 7)), after["frame"], atol=1e-6)
        # the mean over a step is that of its ends up to second order
        imu = world.sensor("imu")[0]
        np.testing.assert_allclose(imu, 0.5 * (before["imu"] + after["imu"]), atol=1e-4)
        assert abs(after["imu"] - before["imu"]).max() > 1e-3
