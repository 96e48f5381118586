"""Scenes of models: all of Gymnasium's run, and every part of a file is where it belongs."""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any

import mujoco
import numpy as np
import pytest

import gsenv
from gsenv.mjcf import MjcfError, MjcfWarning, build_scene, coordinates, load_mjcf, parse_mjcf
from gsenv.mjcf.contact_bits import contact_bits
from gsenv.mjcf.errors import Notes
from gsenv.mjcf.inertia import rigid_roots
from gsenv.solver import Options, World
from tests.mjcf import examples
from tests.mjcf.oracle import FILES, GYMNASIUM, axes, same


def told(source: Any) -> list[str]:
    """What load_mjcf warns of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load_mjcf(source)
    assert all(issubclass(one.category, MjcfWarning) for one in caught)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize("name", FILES)
def test_gymnasiums_robots_run(name: str) -> None:
    model = parse_mjcf(GYMNASIUM / name)
    scene, names = build_scene(model)
    world = World(scene, options=Options(timestep=0.005))
    actuators = world.model.actuators
    rng = np.random.default_rng(0)
    for step in range(100):
        if step % 5 == 0 and len(actuators):
            world.control[:] = rng.uniform(actuators["lower"], actuators["upper"])
        world.step()
    assert np.isfinite(world.position).all()
    assert world.diagnostics().joint_error.max() < 0.01
    qpos = coordinates(world, model, names)[0][0]
    for joint in model.joints:
        if joint.limits is not None:
            lower, upper = min(joint.limits[0], joint.reference), max(joint.limits[1], joint.reference)
            assert lower - 0.02 < qpos[joint.coordinate] < upper + 0.02, joint.name  # the ant starts beyond its limits


def test_load_mjcf_is_in_gsenv() -> None:
    assert gsenv.load_mjcf is load_mjcf
    with pytest.raises(AttributeError, match="module 'gsenv' has no attribute 'load_sdf'"):
        _ = gsenv.load_sdf


@pytest.mark.parametrize("name", ["humanoid.xml", "ant.xml", "pusher_v5.xml"])
def test_masses_and_anchors_of_the_compiled_scene(name: str) -> None:
    """World frames, masses and inertias in the engine are MuJoCo's, of all that is rigidly connected."""
    model = parse_mjcf(GYMNASIUM / name)
    scene, names = build_scene(model)
    compiled = scene.compile()
    theirs = mujoco.MjModel.from_xml_path(str(GYMNASIUM / name))
    data = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, data)
    jointed = {joint.body for joint in model.joints}
    for k, root in enumerate(rigid_roots(model.bodies, jointed)):
        if root != k or k == 0:
            continue
        group = [b for b in range(theirs.nbody) if theirs.body_weldid[b] == k]
        masses = theirs.body_mass[group]
        center = masses @ data.xipos[group] / masses.sum()
        tensor = np.zeros((3, 3))
        for b in group:
            own = data.ximat[b].reshape(3, 3)
            arm = data.xipos[b] - center
            tensor += own @ np.diag(theirs.body_inertia[b]) @ own.T
            tensor += theirs.body_mass[b] * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
        body = compiled.body_names.index(names.bodies[k][0])
        parameters, start = compiled.nominal_bodies[body], compiled.start_bodies[body]
        same(parameters["mass"], masses.sum(), "mass")
        same(start["position"], center, "centre")
        turn = axes(start["rotation"]) @ axes(parameters["axes"])
        same(turn @ np.diag(parameters["inertia"]) @ turn.T, tensor, "inertia", 1e-8)


def test_controls_mean_what_they_mean_in_mujoco() -> None:
    scene, _ = build_scene(parse_mjcf(GYMNASIUM / "humanoid.xml"))
    theirs = mujoco.MjModel.from_xml_path(str(GYMNASIUM / "humanoid.xml"))
    assert list(scene.actuators) == [theirs.actuator(k).name for k in range(theirs.nu)]
    for k, spec in enumerate(scene.actuators.values()):
        assert (spec.lower, spec.upper) == tuple(theirs.actuator_ctrlrange[k])
        assert abs(spec.gain) == theirs.actuator_gear[k, 0]


CONTACTS = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" conaffinity="3" contype="0"/>
    <body name="a"><freejoint/><geom name="a1" size=".1" contype="1" conaffinity="0"/>
      <geom name="a2" size=".1" contype="4" conaffinity="2" pos="1 0 0"/></body>
    <body name="b" pos="3 0 0"><freejoint/><geom name="b1" size=".1" contype="2" conaffinity="1"/></body>
    <body name="c" pos="6 0 0"><freejoint/><geom name="c1" size=".1" contype="0" conaffinity="0"/>
      <geom name="c2" size=".1" contype="0" conaffinity="0"/></body>
  </worldbody>
  <contact><pair geom1="c1" geom2="floor"/></contact>
</mujoco>
"""


def test_contact_bits() -> None:
    model = parse_mjcf(CONTACTS)
    bits = dict(zip([geom.name for geom in model.geoms], contact_bits(model, Notes()), strict=True))
    for one in model.geoms:
        for other in model.geoms:
            wanted = bool(one.contype & other.conaffinity or other.contype & one.conaffinity)
            wanted = wanted or {one.name, other.name} == {"c1", "floor"}
            (category, mask), (others, masked) = bits[one.name], bits[other.name]
            assert bool(category & masked and others & mask) == wanted, (one.name, other.name)
    model.simulation = dataclasses.replace(model.simulation, contacts=False)
    assert {mask for _, mask in contact_bits(model, Notes())} == {0}


def test_friction_with_the_floor_is_the_larger_one() -> None:
    model = parse_mjcf(GYMNASIUM / "hopper.xml")
    scene, _ = build_scene(model)
    coefficients = {shape.name: shape.friction for body in scene.bodies.values() for shape in body.shapes}
    for geom in model.geoms[1:]:
        contact = np.sqrt(coefficients["floor"] * coefficients[geom.name])
        assert contact == pytest.approx(max(geom.friction[0], model.geoms[0].friction[0]))


def test_what_is_not_honoured_is_told_once() -> None:
    sentences = told(GYMNASIUM / "humanoid.xml")
    assert [sentence.split(": ", 1)[0] for sentence in sentences] == [
        "humanoid.xml, line 91", "humanoid.xml, line 25", "humanoid.xml, line 30",
    ]  # fmt: skip
    assert "tendons are not supported" in sentences[0]
    assert "soft-contact parameters are ignored" in sentences[1]
    assert told(GYMNASIUM / "swimmer.xml") == ["swimmer.xml, line 3: option: fluid forces are not simulated."]


def test_joints_that_cross_at_an_angle_get_a_body_between_them() -> None:
    assert len(told(examples.CROSSING)) == 1
    assert "bodies of 1/100,000 of its mass are put between them" in told(examples.CROSSING)[0]
    scene, names = build_scene(parse_mjcf(examples.CROSSING))
    assert len(scene.bodies) == 3
    assert {at.joint for at in names.joints.values()} == {"a", "b"}


def test_equalities_and_sensors() -> None:
    model = parse_mjcf(examples.EQUALITIES)
    notes = Notes()
    scene, names = build_scene(model, notes)
    assert [sentence.split(": ", 1)[1] for sentence in notes.sentences()] == [
        "clock 'time': sensors of this kind are not supported.",
    ]
    world = World(scene, options=Options(timestep=0.005))
    for _ in range(60):
        world.step()
    qpos = coordinates(world, model, names)[0][0]
    first, second = (model.joints[k].coordinate for k in (0, 1))
    assert abs(qpos[second] - 0.5) > 0.05  # the heavy cart falls and drives the other
    same(qpos[first], 2.0 * (qpos[second] - 0.5), "gear", 1e-4)
    same(qpos[2:4], 0.0, "two pinned arms are a rigid triangle", 1e-4)
    where = {name: world.position[0, world.model.body_names.index(name)] for name in ("held", "loose")}
    same(where["held"], [6.0, 0.0, 1.0], "welded body", 1e-6)
    assert where["loose"][2] < 0.7
    same(world.sensor("q")[0, 0], qpos[second] - 0.5, "a sensor reads the coordinate from the initial pose", 1e-9)
    same(world.sensor("pose")[0, :3], where["held"], "pose sensor", 1e-9)
    assert world.sensor("velocity")[0, 9] < -2.0


def test_nothing_is_built_of_a_plane_on_a_moving_body() -> None:
    plane = '<body><freejoint/><geom size="1"/><geom type="plane" size="1 1 1"/></body>'
    with pytest.raises(MjcfError, match="string, line 1: a plane belongs on a fixed or mocap body"):
        load_mjcf(f"<mujoco><worldbody>{plane}</worldbody></mujoco>")


def test_numbers_that_overflow() -> None:
    actuator = '<actuator><position joint="yaw" gear="1e200" kp="1e200"/></actuator>'
    with pytest.raises(MjcfError, match="a number of this model is too large to be simulated"):
        load_mjcf(examples.CHAIN.replace("</mujoco>", f"{actuator}</mujoco>"))


STANDING = """
<mujoco model="standing">
  <option timestep="0.0005"/>
  <default><geom condim="1" density="500"/><joint damping="2" armature=".01"/><position kp="300" kv="10"/></default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="torso" pos="0 0 .62">
      <joint name="x" type="slide" axis="1 0 0" damping="0" armature="0"/>
      <joint name="z" type="slide" axis="0 0 1" damping="0" armature="0"/>
      <joint name="pitch" axis="0 1 0" damping="0" armature="0"/>
      <geom type="box" size=".3 .1 .05" density="1000"/>
      <body pos="-.3 0 0">
        <joint name="hip" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 -.1 0 -.3" size=".03"/>
        <body pos="-.1 0 -.3"><joint name="knee" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 .15 0 -.28" size=".03"/></body>
      </body>
      <body pos=".3 0 0">
        <joint name="hip2" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 -.1 0 -.3" size=".03"/>
        <body pos="-.1 0 -.3"><joint name="knee2" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 .15 0 -.28" size=".03"/></body>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="hip"/><position joint="knee"/><position joint="hip2"/><position joint="knee2"/></actuator>
</mujoco>
"""


def test_joint_torques_of_a_standing_robot() -> None:
    """The drives hold the weight with the torques that MuJoCo's actuators need, on a floor without friction."""
    model = parse_mjcf(STANDING)
    scene, names = build_scene(model)
    world = World(scene, options=Options(timestep=0.005, sleep=False))
    theirs = mujoco.MjModel.from_xml_string(STANDING)
    data = mujoco.MjData(theirs)
    for _ in range(600):
        world.step()
    for _ in range(6000):
        mujoco.mj_step(theirs, data)
    assert abs(data.qvel[1:]).max() < 1e-3
    qpos, qvel = coordinates(world, model, names)
    assert abs(qvel[0, 1:]).max() < 1e-3
    wanted = data.actuator_force
    assert abs(wanted).min() > 1.0
    same(-300.0 * qpos[0, 3:], wanted, "torques", 0.02)
    reactions = [world.joint_reaction(names.joints[k].joint)[0, 4] for k in range(3, 7)]
    same(reactions, wanted, "reactions", 0.02)


@pytest.mark.parametrize("directions", [["0 0 1"], ["1 0 0", "0 1 0", "0 0 1"]], ids=["one", "three"])
def test_a_ball_after_slides_turns_about_all_axes(directions: list[str]) -> None:
    """The ball became a hinge, without a word."""
    slides = "".join(f'<joint type="slide" axis="{direction}"/>' for direction in directions)
    text = f"""<mujoco><option gravity="0 0 0"/><worldbody><body pos="0 0 1">
      {slides}<joint name="b" type="ball"/>
      <geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MjcfWarning)
        scene = load_mjcf(text)
    world = World(scene)
    for spin in np.eye(3):
        world.reset()
        body = int(np.flatnonzero(world.parameters.bodies["mass"][0] > 1.0)[0])
        world.set_velocity(world.model.body_names[body], angular=tuple(spin))
        world.step(30)
        np.testing.assert_allclose(world.angular_velocity[0, body], spin, atol=1e-2)


OVERRULED = """
<mujoco>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="a" pos="0 0 .1"><freejoint/><geom name="a1" size=".1"/></body>
    <body name="b" pos="0 0 .35"><freejoint/><geom name="b1" size=".1"/>
      <geom name="b2" size=".02" pos="0 0 -.12"/></body>
    <body name="c" pos="5 0 1"><joint axis="0 1 0"/><geom name="c1" size=".1"/>
      <body name="d" pos="0 0 .15"><joint type="slide" axis="0 0 1"/><geom name="d1" size=".1"/></body></body>
  </worldbody>
  <contact><exclude body1="a" body2="b"/><pair geom1="a1" geom2="b1"/>{pair}</contact>
</mujoco>
"""


def test_a_pair_overrules_an_exclude_and_the_filter_of_parents() -> None:
    def step(pair: str) -> World:
        world = World(load_mjcf(OVERRULED.format(pair=pair)), options=Options(timestep=1 / 240))
        world.step(240)
        return world

    world = step("")
    height = world.position[0, :, 2]
    assert height[world.model.body_names.index("a")] == pytest.approx(0.1, abs=1e-3)
    assert height[world.model.body_names.index("b")] == pytest.approx(0.3, abs=1e-3)  # b2 passes a by
    slide = world.model.body_names.index("d")
    assert height[slide] == pytest.approx(0.1, abs=1e-3)  # on the ground
    height = step('<pair geom1="c1" geom2="d1"/>').position[0, :, 2]
    assert height[slide] == pytest.approx(1.2, abs=1e-3)
