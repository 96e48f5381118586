"""A chain of hinges and a slider against MuJoCo at a hundredth of the timestep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options
from gsenv.solver.spatial import Box, Hinge, Slider
from tests.solver.spatial.one_kernel import full_world, space

mujoco: Any = pytest.importorskip("mujoco")

# axis and anchor of each joint and half extents of each link; links lie along x at the start
LINKS: tuple[tuple[str, Any, Any, dict[str, float]], ...] = (
    ("hinge", (0, 1, 0), (0.25, 0.05, 0.08), {}),
    ("hinge", (0, 0.6, 0.8), (0.2, 0.06, 0.04), {"stiffness": 0.8, "damping": 0.02}),
    ("slide", (0.8, 0, 0.6), (0.15, 0.05, 0.05), {"stiffness": 60.0, "damping": 0.5}),
    ("hinge", (1, 0, 0), (0.2, 0.1, 0.03), {"damping": 0.01}),
)
XML = """<mujoco><option timestep="{timestep}" integrator="RK4" gravity="0 0 -9.81"><flag contact="disable"/></option>
<worldbody>{bodies}</worldbody></mujoco>"""


def mujoco_model(timestep: float) -> Any:
    text, end = "", ""
    for k, (kind, axis, size, spring) in enumerate(LINKS):
        place = 0.0 if k == 0 else LINKS[k - 1][2][0] * 2.0
        given = " ".join(f'{word}="{value}"' for word, value in spring.items())
        numbers = " ".join(map(str, axis))
        text += f'<body pos="{place} 0 0"><joint type="{kind}" axis="{numbers}" {given}/>'
        text += f'<geom type="box" size="{" ".join(map(str, size))}" pos="{size[0]} 0 0" density="300"/>'
        end += "</body>"
    return mujoco.MjModel.from_xml_string(XML.format(timestep=timestep, bodies=text + end))


def gsenv_world(timestep: float) -> Any:
    scene = space(9.81)
    last: Any = scene.add_body("base", "static")
    x = 0.0
    for k, (kind, axis, size, spring) in enumerate(LINKS):
        link = Box(half_extents=size, density=300.0, mask=0)
        body = scene.add_body(f"link_{k}", shapes=[link], position=(x + size[0], 0, 0))
        joint: Any = Hinge if kind == "hinge" else Slider
        scene.add_joint(f"joint_{k}", joint(last, body, anchor=(x, 0, 0), axis=axis, **spring))
        last = body
        x += 2.0 * size[0]
    return full_world(scene, options=Options(timestep=timestep, substeps=1, max_substeps=1, sleep=False))


def test_a_chain_moves_as_in_mujoco_and_converges_with_the_timestep() -> None:
    fine = mujoco_model(1.0 / 24000.0)
    data = mujoco.MjData(fine)
    worlds = [gsenv_world(1.0 / rate) for rate in (240, 480)]
    worst = np.zeros(2)
    for k in range(1, 61):
        for _ in range(400):
            mujoco.mj_step(fine, data)
        for w, world in enumerate(worlds):
            world.step(4 * (w + 1))
            q = [world.joint_coordinate(f"joint_{j}")[0] for j in range(4)]
            worst[w] = max(worst[w], np.abs(q - data.qpos).max())
            assert world.diagnostics().joint_error[0] < 1e-4, k
    assert worst[0] < 5e-4
    assert worst[1] < 0.4 * worst[0]  # second order: a quarter
    rates = [worlds[1].joint_rate(f"joint_{j}")[0] for j in range(4)]
    assert_allclose(rates, data.qvel, atol=2e-3)
