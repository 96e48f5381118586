"""Motion without contacts is that of MuJoCo on the same file."""

from __future__ import annotations

import dataclasses
from typing import Any

import mujoco
import numpy as np
import pytest

from gsenv.mjcf import build_scene, coordinates, motions, parse_mjcf, set_coordinates
from gsenv.solver import Options, World
from tests.mjcf import examples
from tests.mjcf.oracle import GYMNASIUM, axes, same

DURATION = 2.0  # s
UNSTABLE = ("inverted_double_pendulum.xml",)  # its error is 2.0e-3 rad at 1 ms, and a quarter of that at half
STEP = 1e-3
FREE = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_EULERDAMP
# share of the controls' range, so that robots without limits turn a few times but not hundreds of times
CASES = {
    "humanoid.xml": 0.3,
    "ant.xml": 0.02,
    "half_cheetah.xml": 0.3,
    "hopper.xml": 0.1,
    "walker2d.xml": 0.005,
    "inverted_double_pendulum.xml": 0.3,
    "reacher.xml": 0.01,
    "swimmer.xml": 0.3,
    "CHAIN": 1.0,
    "CROSSING": 1.0,
}


def both(name: str) -> tuple[Any, mujoco.MjModel]:
    """The model as read by us and by MuJoCo, without contacts, limits and fluid."""
    if name.endswith(".xml"):
        path = GYMNASIUM / name
        ours, theirs = parse_mjcf(path), mujoco.MjModel.from_xml_path(str(path))
    else:
        text = getattr(examples, name)
        ours, theirs = parse_mjcf(text), mujoco.MjModel.from_xml_string(text)
    ours.simulation = dataclasses.replace(ours.simulation, contacts=False, limits=False)
    theirs.opt.disableflags |= FREE
    theirs.opt.density = theirs.opt.viscosity = 0.0
    theirs.opt.timestep = 2e-4
    theirs.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    return ours, theirs


def error(name: str, share: float, step: float, duration: float = DURATION) -> float:
    """Largest difference of a coordinate to MuJoCo's, m or rad, from random velocities and constant controls."""
    ours, theirs = both(name)
    rng = np.random.default_rng(0)
    data = mujoco.MjData(theirs)
    data.qvel[:] = 0.3 * rng.normal(size=theirs.nv)
    data.ctrl[:] = share * rng.uniform(-1.0, 1.0, theirs.nu) * theirs.actuator_ctrlrange[:, 1]
    scene, names = build_scene(ours)
    world = World(scene, options=Options(timestep=step, sleep=False))
    set_coordinates(world, ours, names, data.qpos, data.qvel)
    assert len(names.actuators) == theirs.nu
    world.control[0] = data.ctrl
    for _ in range(round(duration / step)):
        world.step()
    start = data.qpos.copy()
    for _ in range(round(duration / theirs.opt.timestep)):
        mujoco.mj_step(theirs, data)
    assert abs(data.qpos - start).max() > 0.5
    q, v = coordinates(world, ours, names)
    known = ~np.isnan(v[0])
    assert known.sum() >= ours.rate_count - 6
    assert abs(v[0] - data.qvel)[known].max() < 2e-2 * (1.0 + abs(data.qvel).max())
    return float(abs(q[0] - data.qpos).max())


@pytest.mark.parametrize("name", list(CASES))
def test_motion(name: str) -> None:
    step = 0.5 * STEP if name in UNSTABLE else STEP
    assert error(name, CASES[name], step) < 1e-3


def test_error_is_of_second_order() -> None:
    coarse, fine = (error("CHAIN", 1.0, step, 1.0) for step in (2e-3, 1e-3))
    assert 1e-7 < fine < 0.3 * coarse


@pytest.mark.parametrize("name", ["humanoid.xml", "hopper.xml", "FRAMES"])
def test_kinematics(name: str) -> None:
    ours, theirs = both(name)
    data = mujoco.MjData(theirs)
    rng = np.random.default_rng(1)
    mujoco.mj_integratePos(theirs, data.qpos, rng.normal(size=theirs.nv), 1.0)
    data.qvel[:] = rng.normal(size=theirs.nv)
    mujoco.mj_forward(theirs, data)
    for k, motion in enumerate(motions(ours, data.qpos, data.qvel)):
        same(motion.pose.position, data.xpos[k], f"body {k}: position")
        same(motion.pose.axes, axes(data.xquat[k]), f"body {k}: axes")
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(theirs, data, mujoco.mjtObj.mjOBJ_XBODY, k, velocity, 0)
        same(motion.spin, velocity[:3], f"body {k}: spin")
        same(motion.velocity, velocity[3:], f"body {k}: velocity")


def test_state_survives_a_round_trip() -> None:
    ours, theirs = both("humanoid.xml")
    rng = np.random.default_rng(2)
    qpos = mujoco.MjData(theirs).qpos.copy()
    qpos[7:] = 0.5 * rng.normal(size=theirs.nq - 7)
    qvel = rng.normal(size=theirs.nv)
    scene, names = build_scene(ours)
    world = World(scene, world_count=2)
    set_coordinates(world, ours, names, qpos, qvel, worlds=1)
    q, v = coordinates(world, ours, names)
    same(q[1], qpos, "qpos")
    same(v[1, 6:], qvel[6:], "qvel")
    assert abs(q[0] - qpos).max() > 0.1
    with pytest.raises(ValueError, match=r"qpos must be 24 numbers, got an array of shape \(3,\)"):
        set_coordinates(world, ours, names, [1, 2, 3])
    with pytest.raises(ValueError, match=r"qvel must be 23 numbers, got 'fast'"):
        set_coordinates(world, ours, names, qpos, "fast")


def test_bad_coordinates_change_nothing() -> None:
    """The bodies before the one with the bad number had moved."""
    model = parse_mjcf(GYMNASIUM / "ant.xml")
    scene, names = build_scene(model)
    world = World(scene, world_count=2)
    good = np.array([1.0, 2.0, 3.0, 1.0, *np.full(model.coordinate_count - 4, 0.1)])
    rates = np.ones(model.rate_count)
    before = world.state.bodies.tobytes()
    for place, value, reason in ((-1, np.nan, "finite"), (0, np.inf, "finite"), (slice(3, 7), 0.0, "'root'.*zero")):
        bad = good.copy()
        bad[place] = value
        with pytest.raises(ValueError, match=reason):
            set_coordinates(world, model, names, bad, rates)
    with pytest.raises(ValueError, match="finite"):
        set_coordinates(world, model, names, good, np.where(np.arange(model.rate_count) == 9, np.nan, rates))
    assert world.state.bodies.tobytes() == before
    set_coordinates(world, model, names, good, rates)
    assert world.state.bodies.tobytes() != before
