"""URDF files against MuJoCo's own reader of them, and one sentence for each malformed file."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import gsenv
from gsenv.mjcf import MjcfError, MjcfWarning, build_scene, coordinates, parse_urdf, set_coordinates
from gsenv.solver import Options, World
from tests.mjcf.oracle import axes, same, same_pose

pytest.importorskip("yourdfpy", reason="the extra urdf is not installed")

INERTIAL = (
    '<inertial><origin xyz="{x} .02 .1" rpy=".1 .2 .3"/><mass value="{m}"/>'
    '<inertia ixx="{i}" ixy=".002" ixz="-.001" iyy=".03" iyz=".001" izz=".025"/></inertial>'
)
CONTENT = """
  <link name="base"><collision><geometry><box size="2 2 .1"/></geometry></collision></link>
  <link name="tower">{a}<collision><origin xyz="0 0 .2"/><geometry><cylinder radius=".1" length=".4"/></geometry>
    </collision></link>
  <link name="arm">{b}<collision name="rod"><origin xyz=".2 0 0" rpy="0 .3 0"/>
    <geometry><box size=".4 .1 .05"/></geometry></collision></link>
  <link name="slider">{c}<collision><geometry><sphere radius=".07"/></geometry></collision></link>
  <link name="tool">{d}</link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="tower"/><origin xyz="0 0 .1" rpy="0 0 .4"/>
    <axis xyz="0 0 2"/><dynamics damping=".3"/></joint>
  <joint name="lift" type="revolute"><parent link="tower"/><child link="arm"/><origin xyz="0 .1 .4" rpy=".2 .1 0"/>
    <axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="7" velocity="3"/><dynamics damping=".1"/></joint>
  <joint name="reach" type="prismatic"><parent link="arm"/><child link="slider"/><origin xyz=".4 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="0" velocity="0"/><dynamics damping="4"/></joint>
  <joint name="bolt" type="fixed"><parent link="slider"/><child link="tool"/><origin xyz="0 0 .1" rpy="1 0 0"/></joint>
""".format(
    a=INERTIAL.format(x=0, m=3, i=".04"),
    b=INERTIAL.format(x=".2", m="1.5", i=".02"),
    c=INERTIAL.format(x=0, m="0.8", i=".03"),
    d=INERTIAL.format(x=0, m="0.4", i=".02"),
)
OPTIONS = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
ROBOT = f'<robot name="crane">{OPTIONS}{CONTENT}</robot>'


def theirs_of(text: str) -> mujoco.MjModel:
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    return model


def test_links_are_those_of_mujocos_reader() -> None:
    ours, theirs = parse_urdf(ROBOT), theirs_of(ROBOT)
    data = mujoco.MjData(theirs)
    mujoco.mj_kinematics(theirs, data)
    for body in ours.bodies[2:]:  # MuJoCo makes the root a part of the world
        k = theirs.body(body.name).id
        same_pose(body.world_pose, data.xpos[k], data.xquat[k], body.name)
        same(body.inertia.mass, theirs.body_mass[k], f"{body.name}: mass")
        same(body.inertia.center, theirs.body_ipos[k], f"{body.name}: centre")
        principal = axes(theirs.body_iquat[k])
        same(body.inertia.tensor, principal @ np.diag(theirs.body_inertia[k]) @ principal.T, f"{body.name}: inertia")
    for joint in ours.joints:
        k = theirs.joint(joint.name).id
        same(joint.axis, theirs.jnt_axis[k], f"{joint.name}: axis")
        same(joint.damping, theirs.dof_damping[theirs.jnt_dofadr[k]], f"{joint.name}: damping")
        assert (joint.limits is not None) == bool(theirs.jnt_limited[k])
    boxes = {geom.kind: geom for geom in ours.geoms[1:]}  # the first is that of the root
    same(boxes["box"].size, [0.2, 0.05, 0.025], "box")
    same(boxes["cylinder"].size[:2], [0.1, 0.2], "cylinder")
    same(boxes["sphere"].size[0], 0.07, "sphere")


def test_motion_is_that_of_mujoco() -> None:
    ours, theirs = parse_urdf(ROBOT), theirs_of(ROBOT)
    theirs.opt.timestep, theirs.opt.integrator = 2e-4, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(theirs)
    ours.simulation = dataclasses.replace(ours.simulation, contacts=False)
    scene, names = build_scene(ours)
    world = World(scene, options=Options(timestep=1e-3, sleep=False))
    start = np.array([0.3, -0.4, 0.1])
    data.qpos[:], data.qvel[:] = start, (1.0, -0.5, 0.2)
    set_coordinates(world, ours, names, data.qpos, data.qvel)
    assert list(names.actuators.values()) == ["lift"]
    world.control[:] = 50.0  # within the bounds of the effort: 7 N m
    lift = theirs.joint("lift").dofadr[0]
    for _ in range(5000):
        data.qfrc_applied[lift] = 7.0
        mujoco.mj_step(theirs, data)
    world.step(1000)
    q, v = coordinates(world, ours, names)
    assert abs(data.qpos - start).max() > 0.5
    np.testing.assert_allclose(q[0], data.qpos, atol=1e-3)
    np.testing.assert_allclose(v[0], data.qvel, atol=1e-2)


def test_load_urdf_tells_what_it_ignores(tmp_path: Path) -> None:
    path = tmp_path / "crane.urdf"
    path.write_text(ROBOT)
    with pytest.warns(MjcfWarning, match=r"crane.urdf, line \d+: joint 'lift': limits of joint velocities are ignored"):
        scene = gsenv.load_urdf(path)
    assert list(scene.bodies) == ["world", "base", "tower", "arm", "slider"]  # the tool is fixed to the slider


def two(kind: str, more: str = "", link: str = "", third: str = "") -> str:
    """A link on a joint of a kind to the root."""
    inertial = INERTIAL.format(x=0, m=1, i=".03")
    return (
        f'<robot name="r"><link name="a"/><link name="b">{link or inertial}</link>{third}'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{more}</joint></robot>'
    )


def test_a_floating_link_falls_and_a_planar_one_slides() -> None:
    for kind in ("floating", "planar"):
        model = parse_urdf(two(kind, '<axis xyz="0 -.8 .6"/>'))
        scene, names = build_scene(model)
        world = World(scene, options=Options(timestep=1e-3, sleep=False))
        world.step(100)
        acceleration = world.linear_velocity[0, world.model.body_names.index(names.bodies[2][0])] / 0.1
        along = np.array([0.0, -0.8, 0.6])
        wanted = np.array([0, 0, -9.81]) - (0.0 if kind == "floating" else -9.81 * 0.6) * along
        np.testing.assert_allclose(acceleration, wanted, atol=2e-3)


def test_a_mimic_joint_is_geared() -> None:
    inertial = INERTIAL.format(x=0, m=1, i=".03")
    third = (
        f'<link name="c">{inertial}</link><joint name="k" type="continuous"><parent link="a"/><child link="c"/>'
        '<origin xyz="1 0 0"/><axis xyz="0 0 1"/><mimic joint="j" multiplier="-2"/></joint>'
    )
    model = parse_urdf(two("continuous", '<axis xyz="0 0 1"/>', third=third))
    scene, names = build_scene(model)
    world = World(scene, options=Options(timestep=1e-3, sleep=False))
    for _ in range(100):
        world.apply_force("b", torque=(0.0, 0.0, 0.5))
        world.step()
    q = coordinates(world, model, names)[0][0]
    driving, mimicking = (next(j.coordinate for j in model.joints if j.name == name) for name in "jk")
    whole = 0.025 + 4.0 * 0.025 + 5.0 * 0.02**2  # kg m^2: both links about their axes, through the gear, roughly
    assert q[driving] == pytest.approx(0.5 * 0.5 / whole * 0.1**2, rel=0.05)
    assert q[mimicking] == pytest.approx(-2.0 * q[driving], rel=1e-3)


def test_meshes_are_hulls(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    (tmp_path / "meshes" / "cube.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3\n")
    link = INERTIAL.format(x=0, m=1, i=".03")
    link += (
        '<collision><geometry><mesh filename="package://robot/meshes/cube.obj" scale="1 2 .5"/></geometry></collision>'
    )
    path = tmp_path / "r.urdf"
    path.write_text(two("continuous", link=link))
    model = parse_urdf(path)
    (mesh,) = model.meshes.values()
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [1.0, 2.0, 0.5])
    assert len(build_scene(model)[0].bodies["b"].shapes) == 1


def test_a_bad_mesh_of_a_package_is_named_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "y.stl").write_bytes(b"")
    link = INERTIAL.format(x=0, m=1, i=".03")
    link += '<collision><geometry><mesh filename="package://x/y.stl"/></geometry></collision>'
    path = tmp_path / "r.urdf"
    path.write_text(two("continuous", link=link))
    with pytest.raises(MjcfError, match=r"the file 'package://x/y\.stl' \(.*y\.stl\) is not an STL file"):
        parse_urdf(path)


LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
BAD: dict[str, tuple[Any, str]] = {
    "not well-formed": ("<robot name='r'><link></robot>", "string, line 1: not well-formed XML: mismatched tag"),
    "another root": ("<mujoco/>", "the outermost element of a URDF file is robot, not mujoco"),
    "link without a name": ("<robot name='r'><link/></robot>", "string, line 1: link: name is missing"),
    "no links": ("<robot name='r'/>", "the links must form one tree, got 0 links without a parent"),
    "two of a name": ("<robot><link name='a'/><link name='a'/></robot>", "link 'a': the name is given twice"),
    "unknown type": (two("rubber"), "joint 'j': type must be one of revolute, .*, got 'rubber'"),
    "no such link": (two("fixed").replace('child link="b"', 'child link="x"'), "joint 'j': child must name a link"),
    "loop": (two("fixed").replace('child link="b"', 'child link="a"'), "some of them form a loop"),
    "no limit": (two("revolute"), "joint 'j': a revolute joint needs a limit with lower and upper"),
    "crossed limits": (
        two("revolute", LIMIT.replace('"-1"', '"2"')), "joint 'j': its lower limit 2 is above its upper one, 1",
    ),
    "zero axis": (two("continuous", '<axis xyz="0 0 0"/>'), "joint 'j': axis must be three numbers, not all 0"),
    "words for numbers": (two("continuous", '<origin xyz="a b c"/>'), "joint 'j': could not convert string to float"),
    "damping": (two("continuous", '<dynamics damping="-1"/>'), "joint 'j': damping must be a number that is not neg"),
    "infinite": (two("continuous", '<origin xyz="inf 0 0"/>'), "joint 'j': origin must be finite"),
    "no radius": (
        two("fixed", link="<collision><geometry><sphere/></geometry></collision>"), "link 'b': radius is missing",
    ),
    "no geometry": (two("fixed", link="<collision/>"), "collision of 'b': geometry must be one of box, .*, got none"),
    "flat box": (
        two("fixed", link='<collision><geometry><box size="1 0 1"/></geometry></collision>'),
        "collision 'b': the sizes of its box must be positive",
    ),
    "no mesh": (
        two("fixed", link='<collision><geometry><mesh filename="x.stl"/></geometry></collision>'),
        "the file 'x.stl' cannot be read: No such file",
    ),
    "massless": (two("continuous", link="<visual/>"), "link 'b': it moves, and needs an inertial with"),
    "mimics nothing": (two("continuous", '<mimic joint="x"/>'), "joint 'j': it mimics 'x', which is no joint that"),
    "document type": ("<!DOCTYPE robot><robot name='r'/>", "a document type declaration is not allowed"),
    "no file": ("nowhere.urdf", "nowhere.urdf: the file 'nowhere.urdf' cannot be read"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(BAD))
def test_malformed_files_raise_one_sentence(name: str) -> None:
    text, message = BAD[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(MjcfError, match=message) as caught:
            parse_urdf(text)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")
