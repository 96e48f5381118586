"""The damping of position actuators from their damping ratio, against MuJoCo."""

from __future__ import annotations

import mujoco
import pytest

from gsenv.mjcf import MjcfError, parse_mjcf
from gsenv.mjcf.drives import drives_of
from gsenv.mjcf.errors import Notes

ARM = """<mujoco><compiler autolimits="true" {compiler}/><option gravity="0 0 0"/>
  <default><default class="soft"><position kp="30" dampratio="0.4"/></default></default>
  <worldbody>
    <body pos="0 0 1" euler="10 20 30">
      <joint name="lift" type="slide" axis="0 1 2" armature="0.3"/>
      <joint name="turn" axis="1 0 1" pos="0.1 0 0" armature="0.02" ref="15"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0.2"/>
      <body pos="0.3 0.1 0"><joint name="knee" axis="0 1 0"/>
        <geom type="capsule" size="0.05" fromto="0 0 0 0 0.1 -0.5"/>
      </body>
    </body>
  </worldbody>
  <actuator>{actuators}</actuator>
</mujoco>"""
ACTUATORS = {
    "lift": '<position joint="lift" kp="100" dampratio="1"/>',
    "gear": '<position joint="turn" kp="100" dampratio="0.7" gear="3"/>',
    "of its class": '<position class="soft" joint="knee"/>',
    "kv over its class": '<position class="soft" joint="knee" kv="2"/>',
    "kv of its class": '<position joint="knee" kp="5" kv="2"/>',
    "general": '<general joint="knee" gainprm="20" biastype="affine" biasprm="0 -20 0.5"/>',
}


@pytest.mark.parametrize("compiler", ["", 'settotalmass="7"', 'inertiafromgeom="true" boundmass="3"'])
@pytest.mark.parametrize("name", ACTUATORS)
def test_damping_is_mujocos(name: str, compiler: str) -> None:
    text = ARM.format(compiler=compiler, actuators=ACTUATORS[name])
    theirs = mujoco.MjModel.from_xml_string(text)
    model = parse_mjcf(text)
    notes = Notes()
    (drives,) = drives_of(model, notes).values()
    assert drives.spring is not None
    gear = theirs.actuator_gear[0, 0]
    assert drives.spring.damping == pytest.approx(-theirs.actuator_biasprm[0, 2] * gear**2, rel=1e-9)
    assert drives.spring.stiffness == pytest.approx(theirs.actuator_gainprm[0, 0] * gear**2)
    assert not notes.topics


def test_damping_of_a_robot_that_floats_is_mujocos() -> None:
    text = """<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom type="box" size="0.1 0.2 0.3"/>
      <body pos="0 0 0.4"><joint type="ball"/><geom size="0.1" pos="0.2 0 0"/>
        <body pos="0 0 0.2" euler="40 0 0"><joint name="j" axis="1 0 0" armature="0.1"/>
          <geom size="0.1" pos="0 0.2 0.1"/></body></body></body></worldbody>
      <actuator><position joint="j" kp="10" dampratio="0.8"/></actuator></mujoco>"""
    (drives,) = drives_of(parse_mjcf(text), Notes()).values()
    assert drives.spring is not None
    theirs = mujoco.MjModel.from_xml_string(text)
    assert drives.spring.damping == pytest.approx(-theirs.actuator_biasprm[0, 2], rel=1e-9)


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ('kp="5" kv="1" dampratio="1"', "kv and dampratio exclude each other"),
        ('kp="5" dampratio="-1"', "dampratio must not be negative, got -1"),
    ],
)
def test_wrong_damping_ratios_are_refused(attributes: str, message: str) -> None:
    text = ARM.format(compiler="", actuators=f'<position joint="knee" {attributes}/>')
    with pytest.raises(MjcfError, match=message):
        parse_mjcf(text)
    with pytest.raises(ValueError, match=r"dampratio|kv|negative"):
        mujoco.MjModel.from_xml_string(text)
