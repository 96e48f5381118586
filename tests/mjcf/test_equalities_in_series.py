"""Equalities of joints in series and on moving hands, against MuJoCo's equations of motion in reduced coordinates.

MuJoCo's own equalities are soft, so that the oracle is its mass matrix and bias on the rates that the equalities leave
free, M' = G^T M G, integrated by the classical method of Runge and Kutta.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from gsenv import load_mjcf
from gsenv.mjcf import parse_mjcf
from gsenv.mjcf.build import Names, build_scene
from gsenv.mjcf.model import MjcfModel
from gsenv.mjcf.state import coordinates, set_coordinates
from gsenv.solver import Options, World
from gsenv.solver.records.model import Array

SECONDS = 0.5
GRIPPER = """
<mujoco><compiler angle="radian" autolimits="true"/><option timestep="1e-3"/><worldbody>
  <body name="hand" pos="0 0 1"><freejoint/><geom type="box" size=".05 .08 .03" mass=".8" contype="0"/>
    <body name="left" pos="0 .02 .06"><joint name="l" type="slide" axis="0 1 0"/>
      <geom type="box" size=".01 .01 .04" pos=".01 0 .02" mass=".1" contype="0"/></body>
    <body name="right" pos="0 -.02 .06"><joint name="r" type="slide" axis="0 -1 0"/>
      <geom type="box" size=".01 .01 .04" pos="-.02 0 .01" mass=".25" contype="0"/></body>
    <body name="thumb" pos=".05 0 .03"><joint name="t" type="hinge" axis="1 .2 0"/>
      <geom type="capsule" fromto="0 0 0 0 .1 .1" size=".01" mass=".15" contype="0"/></body>
  </body></worldbody>
  <equality><joint name="jaws" joint1="l" joint2="r" polycoef="0 1"/>
    <joint name="rack" joint1="t" joint2="l" polycoef="0 8"/></equality></mujoco>"""
FINGER = """
<mujoco><compiler angle="radian"/><option timestep="1e-3"/><worldbody>
  <body name="palm" pos="0 0 1"><joint name="wrist" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" contype="0"/>
    <body name="near" pos=".3 0 0"><joint name="a" axis="0 1 0" armature=".001"/>
      <geom type="capsule" fromto="0 0 0 .1 .02 0" size=".01" mass=".1" contype="0"/>
      <body name="mid" pos=".1 .02 0"><joint name="b" axis="0 .96 .28"/>
        <geom type="capsule" fromto="0 0 0 .08 0 0" size=".01" mass=".08" contype="0"/>
        <body name="far" pos=".08 0 0"><joint name="c" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 .05 0 .01" size=".01" mass=".05" contype="0"/></body></body></body></body>
  </worldbody>
  <equality><joint joint1="b" joint2="a" polycoef="0 .8"/><joint joint1="c" joint2="b" polycoef="0 -1.5"/></equality>
</mujoco>"""
SCREW = """
<mujoco><compiler angle="radian"/><option timestep="1e-3"/><worldbody>
  <body name="arm" pos="0 0 1"><joint name="tilt" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 .4 0 0" size=".02" mass="1" contype="0"/>
    <body name="nut" pos=".2 0 0"><joint name="slide" type="slide" axis="1 0 0"/><joint name="spin" axis="1 0 0"/>
      <geom type="box" size=".04 .05 .06" pos="0 .01 0" mass=".5" contype="0"/></body></body></worldbody>
  <equality><joint joint1="slide" joint2="spin" polycoef="0 .05"/></equality></mujoco>"""
# for each file: the equalities (dependent joint, joint, factor), and start rates of free coordinates
FILES: dict[str, tuple[str, list[tuple[str, str, float]], dict[str, float]]] = {
    "gripper": (GRIPPER, [("r", "l", 1.0), ("t", "l", 8.0)], {"l": 0.2}),
    "finger": (FINGER, [("b", "a", 0.8), ("c", "b", -1.5)], {"wrist": 1.0, "a": -3.0}),
    "screw": (SCREW, [("spin", "slide", 20.0)], {"tilt": 1.0, "slide": 0.3}),
}


class Reduced:
    """MuJoCo's model with its equalities solved for the rates that they leave free."""

    def __init__(self, text: str, equalities: list[tuple[str, str, float]]) -> None:
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        whole = np.eye(self.model.nv)
        place = {self.model.joint(j).name: int(self.model.jnt_dofadr[j]) for j in range(self.model.njnt)}
        for dependent, of, factor in equalities:
            whole[place[dependent]] = factor * whole[place[of]]
        kept = [v for v in range(self.model.nv) if v not in {place[name] for name, _, _ in equalities}]
        self.place = place
        self.kept = kept
        self.ways: Array = whole[:, kept]

    def accelerations(self, q: Array, u: Array) -> Array:
        self.data.qpos[:] = q
        self.data.qvel[:] = self.ways @ u
        mujoco.mj_forward(self.model, self.data)
        masses = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, masses)
        force = self.data.qfrc_passive - self.data.qfrc_bias
        return np.linalg.solve(self.ways.T @ masses @ self.ways, self.ways.T @ force)

    def moved(self, q: Array, u: Array, h: float) -> Array:
        new = q.copy()
        mujoco.mj_integratePos(self.model, new, self.ways @ u, h)
        return new

    def run(self, q: Array, u: Array, seconds: float, h: float = 1e-3) -> tuple[Array, Array]:
        for _ in range(round(seconds / h)):
            a = self.accelerations(q, u)
            b = self.accelerations(self.moved(q, u, h / 2), u + h / 2 * a)
            c = self.accelerations(self.moved(q, u + h / 4 * a, h / 2), u + h / 2 * b)
            d = self.accelerations(self.moved(q, u + h / 2 * b, h), u + h * c)
            q = self.moved(q, u + h / 6 * (a + b + c), h)
            u = u + h / 6 * (a + 2 * b + 2 * c + d)
        return q, self.ways @ u


def started(name: str, timestep: float) -> tuple[World, MjcfModel, Names, Reduced, tuple[Array, Array]]:
    text, equalities, rates = FILES[name]
    model = parse_mjcf(text)
    scene, names = build_scene(model)
    world = World(scene, options=Options(timestep=timestep, sleep=False))
    oracle = Reduced(text, equalities)
    u = np.zeros(len(oracle.kept))
    for joint, rate in rates.items():
        u[oracle.kept.index(oracle.place[joint])] = rate
    q = oracle.data.qpos.copy()
    set_coordinates(world, model, names, q, oracle.ways @ u)
    return world, model, names, oracle, (q, u)


@pytest.mark.parametrize("name", FILES)
def test_motion_is_that_of_the_equations(name: str) -> None:
    errors = []
    for timestep in (1 / 250, 1 / 500):
        world, model, names, oracle, start = started(name, timestep)
        q, v = oracle.run(*start, SECONDS)
        for _ in range(round(SECONDS / timestep)):
            world.step()
            assert world.diagnostics().unconverged[0] == 0
        mine, rates = coordinates(world, model, names)
        errors.append((np.abs(mine[0] - q).max(), np.abs(rates[0] - v).max()))
        for dependent, of, factor in FILES[name][1]:
            one, other = (mine[0][int(oracle.model.joint(joint).qposadr[0])] for joint in (dependent, of))
            assert one == pytest.approx(factor * other, abs=1e-6)
    assert errors[1][0] < 1e-4
    assert errors[1][1] < 2e-3
    if name == "finger":  # of second order
        assert errors[1][1] < 0.3 * errors[0][1]


def kept(equality: str, where: str = "") -> World:
    """A pendulum and a slider beside it, with one equality."""
    text = f"""<mujoco><compiler angle="radian"/><worldbody>
      <body pos="0 0 1"><joint name="p" axis="0 1 0" {where}/>
        <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" contype="0" conaffinity="0"/>
        <body name="slide" pos=".1 0 0"><joint name="s" type="slide" axis="1 0 0" damping=".3"/>
          <geom size=".02" mass=".2" contype="0" conaffinity="0"/></body></body></worldbody>
      <equality>{equality}</equality></mujoco>"""
    world = World(load_mjcf(text), options=Options(timestep=1 / 250, sleep=False))
    world.step(50)
    return world


def test_constants_of_equalities() -> None:
    """MuJoCo: q1 - q1_0 = a0 + a1 (q2 - q2_0), and without joint2 q1 - q1_0 = a0."""
    world = kept('<joint joint1="s" joint2="p" polycoef=".02 .1"/>')
    p = world.joint_coordinate("p")[0]
    assert p > 0.1
    assert world.joint_coordinate("s")[0] == pytest.approx(0.02 + 0.1 * p, abs=1e-6)
    world = kept('<joint joint1="p" polycoef="-.2"/>')
    assert world.joint_coordinate("p")[0] == pytest.approx(-0.2, abs=1e-6)
    assert abs(world.joint_coordinate("s")[0]) > 0.005
    with pytest.warns(UserWarning, match=r"the polynomial between these two joints is not supported\.$"):
        kept('<joint joint1="s" joint2="p" polycoef="0 .1 .3"/>')


def test_a_geared_gripper_lifts_a_cube() -> None:
    """One motor closes both fingers, which push the cube to the middle between them, and friction lifts it."""
    finger = '<geom type="box" size=".01 .008 .03" pos="0 {} -.03" mass=".05"/>'
    text = f"""<mujoco><compiler angle="radian"/><worldbody><geom type="plane" size="1 1 .1"/>
      <body pos="0 0 .2"><joint name="lift" type="slide" axis="0 0 1" damping="5"/>
        <geom type="box" size=".03 .1 .02" mass=".8" contype="0" conaffinity="0"/>
        <body pos="0 .04 -.05"><joint name="l" type="slide" axis="0 -1 0"/>{finger.format(".008")}</body>
        <body pos="0 -.04 -.05"><joint name="r" type="slide" axis="0 1 0"/>{finger.format("-.008")}</body></body>
      <body name="cube" pos="0 .005 .025"><freejoint/><geom type="box" size=".025 .025 .025" mass=".3"/></body>
    </worldbody><equality><joint joint1="l" joint2="r" polycoef="0 1"/></equality>
    <actuator><position name="lift" joint="lift" kp="800" kv="80"/><motor name="grip" joint="l"/></actuator></mujoco>"""
    world = World(load_mjcf(text), options=Options(timestep=1 / 240, sleep=False))
    cube = world.model.body_names.index("cube")
    worst = 0.0
    for k in range(600):
        t = k / 240
        world.control = np.array([[-0.09 + 0.3 * min(max(t - 1.0, 0.0), 0.5), 0.0 if t < 0.5 else 20.0]])
        world.step()
        worst = max(worst, world.diagnostics().penetration[0])
    lift = world.joint_coordinate("lift")[0]
    assert lift == pytest.approx(0.06 - 1.2 * 9.81 / 800, abs=1e-5)
    assert world.position[0, cube, 1] == pytest.approx(0.0, abs=1e-5)
    assert world.joint_coordinate("l")[0] == pytest.approx(0.015, abs=1e-5)
    assert world.joint_coordinate("r")[0] == pytest.approx(0.015, abs=1e-5)
    assert world.position[0, cube, 2] - 0.025 == pytest.approx(lift + 0.09, abs=2e-4)  # fingers stood on the ground
    assert worst < 2e-5
