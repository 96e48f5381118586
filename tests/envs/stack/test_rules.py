"""What counts as placed, fallen and built, on constructed states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.envs.stack.env import StackEnv, StackTask
from gsenv.envs.stack.policy import build_tower
from gsenv.envs.stack.scene import (
    DRIVE_JOINT,
    FIRST_BLOCK,
    FIRST_BLOCK_SHAPE,
    FIRST_WELD,
    GRIPPER_BODY,
    MAGNET_RADIUS,
    MAX_FORCE,
    MAX_TORQUE,
)
from tests.envs.stack.worlds import IDLE, RELEASE, block_position, mixed_actions, set_up_tower

DOWN = np.array([0, -1, 0, -1], np.float32)
UP = np.array([0, 1, 0, -1], np.float32)
INDEX = {entry.name: k for k, entry in enumerate(StackTask.observations)}


@pytest.fixture
def env() -> StackEnv:
    env = StackEnv()
    env.reset(seed=0, options={"blocks": 3})
    return env


def run(env: StackEnv, steps: int, action: Any = IDLE) -> tuple[Any, ...]:
    for _ in range(steps):
        result = env.step(action)
        if result[2]:
            break
    return result


def test_a_tower_succeeds_after_one_second(env: StackEnv) -> None:
    set_up_tower(env.task, 3)
    for step in range(1, 31):
        _, _, terminated, _, info = env.step(IDLE)
        assert terminated == info["success"] == info["is_success"] == (step == 30)
        assert info["placed"] == 3
        assert info["stand_time"] == pytest.approx(step / 30)
    assert info["reward_success"] == 5.0


def test_a_block_counts_once(env: StackEnv) -> None:
    set_up_tower(env.task, 2)
    env.task.task_state["blocks"] = 2
    assert env.step(IDLE)[4]["reward_placed"] == 1.0
    assert env.step(IDLE)[4]["reward_placed"] == 0.0


def test_a_tower_under_the_gripper_does_not_count(env: StackEnv) -> None:
    heights = set_up_tower(env.task, 3)
    half = env.task.world.parameters.half_extents[0, FIRST_BLOCK_SHAPE + 2, 1]
    place = (0.0, heights[2] + half + MAGNET_RADIUS)
    env.task.world.set_pose("gripper", position=place)
    env.task.world.set_target("drive", position=place)
    _, _, terminated, _, info = run(env, 60, 0.3 * DOWN)
    assert not terminated
    assert info["placed"] == 2
    assert info["stand_time"] == 0.0


def test_an_unfinished_tower_does_not_succeed(env: StackEnv) -> None:
    env.task.task_state["blocks"] = 4
    set_up_tower(env.task, 3)
    env.task.world.set_pose("gripper", position=(0.0, 0.8 + 1.0))
    _, _, terminated, _, info = run(env, 40)
    assert not terminated
    assert not info["success"]


@pytest.mark.parametrize("how", ["tipped", "beside", "sunk"])
def test_a_fallen_block_ends_the_episode(env: StackEnv, how: str) -> None:
    heights = set_up_tower(env.task, 3)
    assert not env.step(IDLE)[2]
    world = env.task.world
    if how == "tipped":
        world.set_pose("block_2", angle=0.55)
    elif how == "beside":
        world.set_pose("block_2", position=(1.5, heights[2]))
    else:
        world.set_pose("block_2", position=(1.5, heights[2] - 0.11))
    _, _, terminated, _, info = run(env, 60)
    assert terminated
    assert not info["success"]
    assert info["reward_fall"] == -0.2
    assert info["reward_success"] == 0.0


def test_the_held_block_may_be_anywhere(env: StackEnv) -> None:
    assert not run(env, 150, 0.2 * DOWN)[2]


def test_a_block_let_go_falls_to_the_ground_and_stays(env: StackEnv) -> None:
    env.reset(seed=0, options={"crack_speed": 100.0})
    observation, *_ = env.step(RELEASE)
    assert observation[INDEX["holding"]] == 0.0
    height = block_position(env.task, 0)[1]
    run(env, 20)
    assert block_position(env.task, 0)[1] < height - 0.3


def test_the_next_block_arrives_in_the_gripper_and_only_where_there_is_room(env: StackEnv) -> None:
    observation, _ = env.reset(seed=1, options={"blocks": 3})
    while observation[INDEX["holding"]]:
        observation = env.step(build_tower(observation))[0]
    for _ in range(60):  # the gripper stays where it let go
        observation = env.step(IDLE)[0]
        assert not observation[INDEX["holding"]]
    assert observation[INDEX["placed"]] == pytest.approx(1 / 8)
    assert observation[INDEX["rise"]] > 0.0
    while not observation[INDEX["holding"]]:
        observation, _, terminated, _, _ = env.step(UP)
        assert not terminated
    env.step(IDLE)
    contacts = env.task.world.contacts(0)
    arrived = (contacts.body_a == FIRST_BLOCK + 1) | (contacts.body_b == FIRST_BLOCK + 1)
    assert not (arrived & contacts.touching).any()
    assert env.task.world.diagnostics().joint_error[0] < 2e-3
    gap = block_position(env.task, 1) - block_position(env.task, 0)
    assert gap[1] > 0.3


def test_blocks_yet_to_come_are_out_of_the_world(env: StackEnv) -> None:
    enabled = env.task.world.parameters.enabled[0, FIRST_BLOCK:]
    np.testing.assert_array_equal(enabled, [True] + [False] * 7)
    assert (env.task.world.parameters.bodies["inv_mass"][0, FIRST_BLOCK + 1 :] == 0.0).all()


def test_the_drive_stays_within_its_bounds(env: StackEnv) -> None:
    timestep = env.task.world.timestep
    for action in mixed_actions(3, (200,)):
        terminated = env.step(action)[2]
        impulse = env.task.world.state.joints["total_impulse"][0, DRIVE_JOINT]
        assert (np.abs(impulse[:2]) <= timestep * MAX_FORCE * (1 + 1e-9)).all()
        assert abs(impulse[2]) <= timestep * MAX_TORQUE * (1 + 1e-9)
        if terminated:
            break


def test_the_ground_stops_the_gripper(env: StackEnv) -> None:
    run(env, 90, DOWN)
    assert env.task.world.diagnostics().penetration[0] < 0.01
    assert env.task.world.position[0, GRIPPER_BODY, 1] > 0.15


def test_the_gantry_has_ends(env: StackEnv) -> None:
    observation = run(env, 200, np.array([1, 1, 1, -1], np.float32))[0]
    assert 1.75 < observation[INDEX["gripper_x"]] < 1.85
    assert 4.2 < observation[INDEX["gripper_y"]] < 4.45
    assert 0.4 < observation[INDEX["gripper_angle"]] < 0.65


def test_the_weld_holds_through_rough_handling(env: StackEnv) -> None:
    for action in mixed_actions(11, (150,)):
        env.step(np.array([*np.sign(action[:3]), -1], np.float32))
        if env.task.world.parameters.joints["enabled"][0, FIRST_WELD]:
            assert env.task.world.diagnostics().joint_error[0] < 0.02


def test_going_to_and_fro_earns_nothing(env: StackEnv) -> None:
    env.step(IDLE)
    total = 0.0
    before = env.task.task_state["distance"][0]
    for _ in range(8):
        for action in (UP, DOWN):
            for _ in range(10):
                total += env.step(action)[4]["reward_approach"]
    after = env.task.task_state["distance"][0]
    assert total == pytest.approx(0.5 * (before - after), abs=1e-9)
