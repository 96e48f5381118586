"""Readings of sensors, cameras and keyframes are those of MuJoCo in the same state."""

from __future__ import annotations

import warnings
from typing import Any

import mujoco
import numpy as np
import pytest

from gsenv.mjcf import build_scene, camera_view, coordinates, parse_mjcf, sensor_data, set_coordinates, set_keyframe
from gsenv.mjcf.errors import Notes
from gsenv.mjcf.site_volumes import ray_meets
from gsenv.render.spatial import SpatialCamera
from gsenv.solver import Options, World
from tests.mjcf.oracle import same

FRAMES = "framepos framequat framexaxis frameyaxis framezaxis framelinvel frameangvel".split()
OBJECTS = {"site": ("tip", "rod", "back", "fixed"), "xbody": ("trunk", "wrist", "plate"), "geom": ("lump",)}
POSITIONS = "".join(
    f'<{kind} objtype="{what}" objname="{name}"/>' for kind in FRAMES for what, some in OBJECTS.items() for name in some
)
RELATIVE = "".join(
    f'<{kind} objtype="site" objname="{name}" reftype="{what}" refname="{to}"/>'
    for kind in FRAMES
    for name, what, to in (("tip", "site", "back"), ("rod", "xbody", "plate"), ("fixed", "geom", "lump"))
)
BODIES = "".join(f'<{kind} objtype="body" objname="wrist"/>' for kind in ("framepos", "framelinvel", "frameangvel"))
OF_SITES = "".join(f'<{kind} site="{s}"/>' for kind in ("velocimeter", "gyro") for s in ("tip", "rod", "back"))
JOINTS = """
    <jointpos joint="elbow"/><jointvel joint="elbow"/><jointpos joint="lift"/><jointvel joint="roll"/>
    <ballquat joint="shoulder"/><ballangvel joint="shoulder"/><jointpos joint="yaw" cutoff=".1"/>
    <actuatorpos actuator="push"/><actuatorvel actuator="push"/><actuatorfrc actuator="push"/>
    <actuatorpos actuator="hold"/><actuatorfrc actuator="hold"/>
"""
LOADS = "".join(
    f'<{kind} name="{kind} {site}" site="{site}"/>'
    for kind in ("accelerometer", "force", "torque")
    for site in ("tip", "rod", "back", "middle")
) + "".join(
    f'<{kind} objtype="site" objname="{s}"/>' for kind in ("framelinacc", "frameangacc") for s in ("tip", "rod")
)

ROBOT = f"""
<mujoco model="sensors">
  <compiler angle="degree"/>
  <option timestep="0.001"><flag contact="disable"/></option>
  <worldbody>
    <site name="fixed" pos="1 2 3" euler="10 20 30"/>
    <camera name="wall" pos="3 0 2" xyaxes="0 1 0 -.5 0 1" fovy="50"/>
    <camera name="watch" pos="-2 1 3" mode="targetbody" target="wrist"/>
    <body name="trunk" pos="0 0 1"><freejoint/>
      <geom type="box" size=".2 .1 .3" pos=".05 .02 0"/>
      <site name="back" pos="-.2 .1 .1" euler="90 0 40"/>
      <camera name="follow" pos="0 -3 1" xyaxes="1 0 0 0 .3 1" mode="trackcom"/>
      <camera name="beside" pos="0 -3 1" mode="track"/>
      <camera name="eye" pos=".2 0 .3" euler="0 -90 20"/>
      <camera name="whole" pos="0 4 1" mode="targetbodycom" target="trunk"/>
      <body name="plate" pos="0 0 .4" euler="5 5 5"><geom name="lump" type="box" size=".1 .2 .05" pos=".1 0 0"/></body>
      <body name="upper" pos=".3 .1 .2">
        <joint name="shoulder" type="ball" damping=".1"/>
        <geom type="capsule" fromto="0 0 0 .4 .1 0" size=".05"/>
        <site name="middle" pos=".2 0 0" euler="20 0 0"/>
        <body name="wrist" pos=".4 .1 0" euler="0 30 0">
          <joint name="elbow" axis="0 1 0" damping=".2" armature=".01" ref="10"/>
          <geom type="box" size=".1 .05 .02" pos=".1 0 .03"/>
          <site name="tip" pos=".2 0 0" euler="30 40 50"/>
        </body>
      </body>
      <body pos="-.3 0 0">
        <joint name="lift" type="slide" axis="0 0 1" stiffness="300" damping="3"/>
        <joint name="roll" axis="1 0 0" damping=".1"/><joint name="yaw" axis="0 0 1" armature=".02"/>
        <geom type="capsule" fromto="0 0 0 -.3 0 .1" size=".04"/>
        <site name="rod" pos="-.2 0 .1" zaxis="1 1 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="push" joint="elbow" gear="3" ctrlrange="-1 1"/>
    <position name="hold" joint="roll" kp="20" kv="1"/></actuator>
  <sensor>{POSITIONS}{RELATIVE}{BODIES}{OF_SITES}{JOINTS}{LOADS}</sensor>
  <keyframe><key name="start"/>
    <key name="bent" qpos="1 2 3 1 0 0 0 .8 .6 0 0 .5 .1 .2 .3" qvel="1 2 3 4 5 6 7 8 9 1 2 3 4" ctrl=".5 -.2"/>
  </keyframe>
</mujoco>
"""


def both(timestep: float = 1e-3) -> tuple[Any, ...]:
    """Model, names and world, and MuJoCo's model and data, in the same random state with the same controls."""
    model = parse_mjcf(ROBOT)
    notes = Notes()
    scene, names = build_scene(model, notes)
    assert len(names.sensors) == len(model.sensors)
    theirs = mujoco.MjModel.from_xml_string(ROBOT)
    data = mujoco.MjData(theirs)
    rng = np.random.default_rng(3)
    mujoco.mj_integratePos(theirs, data.qpos, 0.5 * rng.normal(size=theirs.nv), 1.0)
    data.qvel[:] = rng.normal(size=theirs.nv)
    data.ctrl[:] = (0.7, 0.2)
    mujoco.mj_forward(theirs, data)
    world = World(scene, options=Options(timestep=timestep, sleep=False))
    set_coordinates(world, model, names, data.qpos, data.qvel)
    world.control[:] = data.ctrl
    return model, names, world, theirs, data


def their(theirs: Any, data: Any, k: int) -> Any:
    first = theirs.sensor_adr[k]
    return data.sensordata[first : first + theirs.sensor_dim[k]]


def is_load(kind: str) -> bool:
    return kind in ("accelerometer", "force", "torque", "framelinacc", "frameangacc")


def test_positions_and_velocities_are_exact() -> None:
    model, names, world, theirs, data = both()
    found = sensor_data(world, model, names)
    count = 0
    for k, sensor in enumerate(model.sensors):
        if not is_load(sensor.kind):
            mine, wanted = found[names.sensors[k].name][0], their(theirs, data, k)
            if sensor.kind in ("framequat", "ballquat"):
                mine = mine * np.sign(mine @ wanted)
            same(mine, wanted, f"{sensor}", 1e-9)
            count += 1
    assert count > 80


def test_loads_and_accelerations() -> None:
    """They are means over a step; from two steps the value in the state itself is found."""
    means = []
    for timestep in (2e-4, 1e-4):
        model, names, world, theirs, data = both(timestep)
        world.step()
        means.append(sensor_data(world, model, names))
    for k, sensor in enumerate(model.sensors):
        if is_load(sensor.kind):
            coarse, fine = (mean[names.sensors[k].name][0] for mean in means)
            wanted = their(theirs, data, k)
            close = 1e-3 * (1.0 + abs(wanted).max())
            np.testing.assert_allclose(2.0 * fine - coarse, wanted, atol=close, err_msg=sensor.name or sensor.kind)


def test_coordinates_of_balls_and_free_bodies() -> None:
    model, names, world, _, data = both()
    q, v = coordinates(world, model, names)
    ball = model.joints[1].coordinate
    q[0, ball : ball + 4] *= np.sign(q[0, ball : ball + 4] @ data.qpos[ball : ball + 4])
    q[0, 3:7] *= np.sign(q[0, 3:7] @ data.qpos[3:7])
    same(q[0], data.qpos, "qpos")
    same(v[0], data.qvel, "qvel")


def test_keyframes() -> None:
    model, names, world, theirs, _ = both()
    set_keyframe(world, model, names, "bent")
    q, v = coordinates(world, model, names)
    same(q[0], theirs.key_qpos[1], "qpos")
    same(v[0], theirs.key_qvel[1], "qvel")
    same(world.control[0], [0.5, -0.2], "controls")
    set_keyframe(world, model, names, 0)
    same(coordinates(world, model, names)[0][0], theirs.qpos0, "qpos of the first")
    for key in ("bend", 2, -1):
        with pytest.raises(ValueError, match=r"there is no keyframe .*, the file has \['start', 'bent'\]"):
            set_keyframe(world, model, names, key)


def test_cameras() -> None:
    model, names, world, theirs, data = both()
    for k, camera in enumerate(model.cameras):
        view = camera_view(world, model, names, camera.name)
        same(view.eye, data.cam_xpos[k], f"{camera.name}: eye")
        right, up, forward = SpatialCamera(*view, width=320, height=240).axes()
        same(np.stack([right, up, -forward], 1), data.cam_xmat[k].reshape(3, 3), f"{camera.name}: axes")
        same(np.degrees(view.fov), theirs.cam_fovy[k], f"{camera.name}: fov", 1e-6)
    with pytest.raises(ValueError, match="there is no camera 'x', the file has"):
        camera_view(world, model, names, "x")


STANDING = """
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body name="box" pos="0 0 .1"><freejoint/>
      <geom type="box" size=".3 .2 .1" mass="8"/>
      <geom type="sphere" size=".05" pos=".1 0 .15" mass="2"/>
      <site name="left" type="box" size=".4 .12 .02" pos="0 .12 -.1"/>
      <site name="right" type="box" size=".4 .12 .02" pos="0 -.12 -.1"/>
      <site name="all" type="sphere" size=".5"/>
      <site name="away" type="ellipsoid" size=".1 .1 .1" pos="0 0 .4"/>
      <site name="down" pos="0 0 -.1" zaxis="0 0 1"/>
      <site name="side" pos=".3 0 0" zaxis="1 0 0"/><site name="far" pos="0 .3 0" zaxis="0 1 .2"/>
    </body>
    <geom type="box" size=".1 5 5" pos="2 0 0"/>
  </worldbody>
  <sensor><touch name="left" site="left"/><touch name="right" site="right"/><touch name="all" site="all"/>
    <touch name="away" site="away"/><touch name="limited" site="all" cutoff="20"/>
    <rangefinder name="wall" site="side"/><rangefinder name="near" site="side" cutoff="1"/>
    <rangefinder name="sky" site="far"/><accelerometer name="up" site="side"/><force name="free" site="side"/></sensor>
</mujoco>
"""


def test_touch_and_rays_of_a_standing_box() -> None:
    model = parse_mjcf(STANDING)
    scene, names = build_scene(model)
    world = World(scene, options=Options(timestep=0.002, sleep=False))
    world.step(500)
    theirs = mujoco.MjModel.from_xml_string(STANDING)
    data = mujoco.MjData(theirs)
    mujoco.mj_step(theirs, data, 500)
    mujoco.mj_forward(theirs, data)
    found = sensor_data(world, model, names)
    for k, sensor in enumerate(model.sensors):
        tolerance = 2e-3 * 98.1 if sensor.kind in ("touch", "accelerometer", "force") else 1e-3
        np.testing.assert_allclose(found[sensor.name][0], their(theirs, data, k), atol=tolerance, err_msg=sensor.name)
    assert found["all"][0, 0] == pytest.approx(98.1, rel=1e-6)
    assert found["wall"][0, 0] == pytest.approx(1.6, abs=1e-3)
    assert found["sky"][0, 0] == -1.0


@pytest.mark.parametrize("kind", ["sphere", "capsule", "ellipsoid", "cylinder", "box"])
def test_rays_and_volumes(kind: str) -> None:
    rng = np.random.default_rng(0)
    size = np.array([0.3, 0.5, 0.4])
    hits = 0
    for _ in range(2000):
        start, ahead = rng.uniform(-1.0, 1.0, 3), rng.normal(size=3)
        distance = mujoco.mju_rayGeom(
            np.zeros(3), np.eye(3).ravel(), size, start, ahead, getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}"), None
        )
        assert ray_meets(kind, size, start, ahead) == (distance >= 0.0)
        hits += distance >= 0.0
    assert 50 < hits < 1800


BALL = """
<mujoco>
  <compiler angle="degree"/>
  <worldbody><body pos="0 0 1"><joint name="ball" type="ball" range="0 40"/>
    <geom type="capsule" fromto="0 0 0 .4 0 0" size=".05"/></body></worldbody>
</mujoco>
"""


def test_the_range_of_a_ball_holds() -> None:
    model = parse_mjcf(BALL)
    notes = Notes()
    scene, names = build_scene(model, notes)
    assert not notes.sentences()
    world = World(scene, options=Options(timestep=0.002))
    largest = 0.0
    for _ in range(500):
        world.step()
        largest = max(largest, 2.0 * np.degrees(np.arccos(coordinates(world, model, names)[0][0, 0])))
    assert largest == pytest.approx(40.0, abs=0.2)


def test_what_a_scene_has_no_sensor_for_is_told() -> None:
    text = STANDING.replace('<force name="free" site="side"/>', '<clock name="time"/><magnetometer site="all"/>')
    notes = Notes()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        build_scene(parse_mjcf(text), notes)
    (sentence,) = notes.sentences()
    assert sentence.endswith("clock 'time' (and 1 more): sensors of this kind are not supported.")
