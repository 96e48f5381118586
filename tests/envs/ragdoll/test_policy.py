"""The scripted policy of GRagdoll: the geometry of a leg and of the pelvis, and how long it stands."""

from __future__ import annotations

from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from gsenv.envs.ragdoll import mirror
from gsenv.envs.ragdoll.env import RagdollVectorEnv
from gsenv.envs.ragdoll.policy import _in_pelvis, _level, balance, leg_angles, leg_point
from tests.envs.standing import standing_time

survival = partial(standing_time, RagdollVectorEnv)


def random_legs(count: int) -> tuple[Any, Any, Any]:
    generator = np.random.default_rng(0)
    spread, hip, knee = (generator.uniform(low, high, count) for low, high in ((-0.4, 0.8), (-0.6, 1.2), (-1.8, -0.25)))
    return spread, hip, knee


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_ankle_is_where_mujoco_has_it(side: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(files("gsenv.assets").joinpath("ragdoll.xml").read_text("utf-8"))
    data = mujoco.MjData(model)
    sign = 1.0 if side == "left" else -1.0
    for angles in zip(*random_legs(20), strict=True):
        for joint, angle in zip(("hip_spread", "hip", "knee"), angles, strict=True):
            data.qpos[model.joint(f"{side}_{joint}").qposadr[0]] = angle
        mujoco.mj_kinematics(model, data)
        forwards, outwards, up = leg_point(*angles)
        ankle = data.body(f"{side}_foot").xpos - data.body(f"{side}_thigh").xpos
        np.testing.assert_allclose((forwards, sign * outwards, up), ankle, atol=1e-12)


def test_leg_angles_undo_leg_point() -> None:
    angles = random_legs(200)
    np.testing.assert_allclose(leg_angles(leg_point(*angles)), angles, atol=1e-9)
    far = leg_point(*leg_angles((np.array(0.9), np.array(0.1), np.array(-0.9))))  # beyond the leg's reach
    np.testing.assert_allclose(np.array(far) / far[0], np.array((0.9, 0.1, -0.9)) / 0.9, atol=1e-9)
    assert 0.82 < np.linalg.norm(far) < 0.8345


def turn(axis: int, angle: float) -> Any:
    """The matrix of a rotation about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    return matrix


def test_vectors_turn_with_the_pelvis() -> None:
    """Rotations of the pelvis by heading, pitch and roll; the observation has gravity in its frame."""
    generator = np.random.default_rng(0)
    for heading, pitch, roll in generator.uniform(-0.8, 0.8, (20, 3)):
        pelvis = turn(2, heading) @ turn(1, pitch) @ turn(0, roll)
        down = pelvis.T @ (0.0, 0.0, -1.0)
        seen = {"down_x": down[0], "down_y": down[1]}
        vector = generator.standard_normal(3)
        level = turn(2, -heading) @ pelvis @ vector
        np.testing.assert_allclose(_level(seen, tuple(vector)), level, atol=1e-12)
        np.testing.assert_allclose(_in_pelvis(seen, tuple(level)), vector, atol=1e-12)


def test_it_acts_alike_on_both_sides() -> None:
    """Where it does not choose between two legs that are equally good, its action mirrors with what it sees."""
    vector = RagdollVectorEnv(20, push=0.8)
    seen, _ = vector.reset(seed=0)
    index, sign = mirror.OBSERVATION
    swapped, turned = mirror.ACTION
    for _ in range(120):
        action = balance(seen)
        np.testing.assert_allclose(balance(seen[:, index] * sign), action[:, swapped] * turned, atol=1e-6)
        seen = vector.step(action)[0]


@pytest.mark.parametrize(("push", "least"), [(0.0, 1.0), (0.3, 0.9), (0.6, 0.75)])
def test_it_stands(push: float, least: float) -> None:
    assert (survival(balance, push) == 20.0).mean() >= least
