"""Forces of actuators within their ranges are those of MuJoCo, or there is a warning."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from gsenv.mjcf import build_scene, parse_mjcf, set_coordinates
from gsenv.mjcf.errors import Notes
from gsenv.solver import Options, World

STEP = 1e-4  # s
CONTROLS = (-10.0, -0.7, 0.0, 0.4, 10.0)
EXACT = {
    "unequal bounds": ('<motor joint="j" forcerange="-1 5" gear="3"/>', ""),
    "negative gear": ('<motor joint="j" forcerange="-1 5" gear="-3"/>', ""),
    "pushes only": ('<motor joint="j" forcerange="0 5"/>', ""),
    "never rests": ('<motor joint="j" forcerange="1 5"/>', ""),
    "with an offset": (
        '<general joint="j" gainprm="2" biastype="affine" biasprm="1 0 0" forcerange="-1 3" ctrlrange="-1 1"/>',
        "",
    ),
    "offset alone": ('<general joint="j" gainprm="0" biastype="affine" biasprm="3 0 0" forcerange="-1 2"/>', ""),
    "range of the joint": ('<motor joint="j" gear="2"/>', 'actuatorfrcrange="-1 4"'),
    "one side of the joint": ('<motor joint="j" gear="2"/>', 'actuatorfrcrange="0 4"'),
    "ranges apart": ('<motor joint="j" forcerange="2 5"/>', 'actuatorfrcrange="-1 1"'),
    "equal bounds": ('<position joint="j" kp="10" kv="1" forcerange="-2 2"/>', ""),
    "gear 0": ('<motor joint="j" gear="0"/>', ""),
    "position, gear 0": ('<position joint="j" gear="0"/>', ""),
    "kp 0": ('<position joint="j" kp="0"/>', ""),
}
TOLD = {
    "position": ('<position joint="j" kp="10" forcerange="-1 5"/>', "", "larger bound in both directions"),
    "velocity": ('<velocity joint="j" kv="10" forcerange="-1 5"/>', "", "larger bound in both directions"),
    "two motors": (
        '<motor joint="j" name="a"/><motor name="b" joint="j"/>',
        'actuatorfrcrange="-1 1"',
        "bounds each of them",
    ),
}


def text(actuators: str, joint: str) -> str:
    return f"""
<mujoco><option gravity="0 0 0" timestep="{STEP}"/>
  <worldbody><body><joint name="j" type="slide" axis="1 0 0" {joint}/>
    <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/></body></worldbody>
  <actuator>{actuators}</actuator>
</mujoco>"""


def accelerations(source: str, notes: Notes) -> tuple[Any, Any]:
    """Those of the body at each of CONTROLS, by us and by MuJoCo."""
    model = parse_mjcf(source)
    scene, names = build_scene(model, notes)
    world = World(scene, world_count=len(CONTROLS), options=Options(timestep=STEP, articulated=False))
    set_coordinates(world, model, names, [0.05], [0.2])
    world.control[:] = np.array(CONTROLS)[:, None]
    world.step()
    theirs = mujoco.MjModel.from_xml_string(source)
    data = mujoco.MjData(theirs)
    wanted = []
    for control in CONTROLS:
        data.ctrl[:], data.qpos[:], data.qvel[:] = control, 0.05, 0.2
        mujoco.mj_forward(theirs, data)
        wanted.append(data.qacc[0])
    return (world.joint_rate("j") - 0.2) / STEP, np.array(wanted)


@pytest.mark.parametrize("name", list(EXACT))
def test_forces_within_their_range(name: str) -> None:
    notes = Notes()
    ours, theirs = accelerations(text(*EXACT[name]), notes)
    assert not notes.sentences()
    np.testing.assert_allclose(ours, theirs, rtol=2e-3, atol=2e-3)


@pytest.mark.parametrize("name", list(TOLD))
def test_ranges_that_no_drive_has_are_told(name: str) -> None:
    actuators, joint, sentence = TOLD[name]
    notes = Notes()
    build_scene(parse_mjcf(text(actuators, joint)), notes)
    assert [sentence in one for one in notes.sentences()] == [True]
