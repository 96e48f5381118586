"""GStack-v0's arguments: what they do, and what is said of bad ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.envs.core.policies import make_batch
from gsenv.envs.stack.env import StackEnv, StackVectorEnv
from gsenv.envs.stack.policy import build_tower
from gsenv.envs.stack.scene import FIRST_BLOCK, FIRST_BLOCK_SHAPE
from gsenv.solver import Options
from tests.envs.registered import terms_of
from tests.envs.stack.worlds import IDLE, assert_equal, mixed_actions

NAN = float("nan")


@pytest.mark.parametrize(("argument", "value"), [
    ("blocks", "3"), ("blocks", None), ("half_width", 3), ("half_width", (0.3, 0.1)), ("half_width", (NAN, 0.2)),
    ("half_height", (0.1,)), ("half_height", (0.1, 0.3)), ("mass", (0, 1)), ("mass", ("a", 1)), ("friction", (0, 2)),
    ("friction", None), ("grasp_offset", -0.1), ("grasp_offset", "a"), ("grasp_tilt", 0.6), ("grasp_tilt", NAN),
    ("success_time", 0), ("success_time", True), ("reward_weights", 3), ("reward_weights", {"x": 1}),
    ("reward_weights", {"fall": "a"}), ("reward_weights", {"fall": NAN}), ("reward_weights", None),
    ("observation", "image"), ("observation", []), ("fidelity", "high"), ("fidelity", []), ("diagnostics", "yes"),
    ("randomize", 3), ("randomize", {"x": (1, 2)}),
])  # fmt: skip
@pytest.mark.parametrize("cls", [StackEnv, StackVectorEnv])
def test_bad_values_are_refused_in_one_sentence(cls: Any, argument: str, value: Any) -> None:
    with pytest.raises(ValueError, match=argument) as error:
        cls(**{argument: value})
    message = str(error.value)
    assert message.endswith(".")
    assert "\n" not in message
    culprit = next(iter(value)) if isinstance(value, dict) else value
    assert repr(culprit) in message or str(culprit) in message


@pytest.mark.parametrize(("argument", "value"), [
    ("num_envs", 0), ("num_envs", True), ("max_episode_steps", 2.5), ("max_episode_steps", "a"), ("threads", 0),
    ("autoreset_mode", "never"),
])  # fmt: skip
def test_bad_values_of_the_vector_environment_are_refused(argument: str, value: Any) -> None:
    with pytest.raises(ValueError, match=argument):
        StackVectorEnv(**{argument: value})


def test_ranges_hold_for_all_blocks() -> None:
    ranges: dict[str, Any] = {
        "half_width": (0.3, 0.4), "half_height": (0.2, 0.25), "mass": (5, 6), "friction": (0.1, 0.2),
    }  # fmt: skip
    envs = StackVectorEnv(20, **ranges)
    envs.reset(seed=0)
    parameters = envs.task.world.parameters
    shapes = parameters.shapes[:, FIRST_BLOCK_SHAPE:]
    values = {
        "half_width": shapes["size"][..., 0],
        "half_height": shapes["size"][..., 1],
        "mass": parameters.mass[:, FIRST_BLOCK:],
        "friction": shapes["friction"],
    }
    for name, (low, high) in ranges.items():
        assert low <= values[name].min() < low + 0.1 * (high - low), name
        assert high >= values[name].max() > high - 0.1 * (high - low), name


def test_grasps_without_offset_and_tilt_are_straight() -> None:
    envs = StackVectorEnv(10, grasp_offset=0, grasp_tilt=0)
    observations, _ = envs.reset(seed=0)
    names = [entry.name for entry in envs.task.observations]
    for name in ("block_angle", "grasp_dx"):
        np.testing.assert_allclose(observations[:, names.index(name)], 0.0, atol=1e-6)


@pytest.mark.parametrize(("success_time", "steps"), [(0.1, 3), (1.0, 30), (2.0, 60)])
def test_success_time(success_time: float, steps: int) -> None:
    env = StackEnv(blocks=1, success_time=success_time)
    observation, _ = env.reset(seed=0)
    terminated, standing = False, 0
    while not terminated:
        observation, _, terminated, _, info = env.step(build_tower(observation))
        standing = standing + 1 if info["stand_time"] > 0 else 0
        assert standing == 0 or info["stand_time"] == pytest.approx(standing / 30)
    assert info["success"]
    assert standing == steps


def test_reward_weights_scale_their_terms() -> None:
    weights = {"approach": 0.0, "placed": 3.0, "effort": -1.0}
    plain, changed = StackEnv(blocks=1), StackEnv(blocks=1, reward_weights=weights)
    observation, _ = plain.reset(seed=0)
    changed.reset(seed=0)
    placed, terminated = 0.0, False
    while not terminated:
        action = build_tower(observation)
        observation, _, terminated, _, info = plain.step(action)
        _, reward, _, _, other = changed.step(action)
        terms, others = terms_of(info), terms_of(other)
        assert others["approach"] == 0.0
        assert others["placed"] == 3.0 * terms["placed"]
        assert others["effort"] == pytest.approx(500 * terms["effort"])
        assert others["success"] == terms["success"]
        assert reward == sum(others.values())
        placed += terms["placed"]
    assert placed == 1.0


def test_options_of_one_reset_override_arguments_in_those_worlds_alone() -> None:
    envs = StackVectorEnv(3, mass=(5, 5))
    envs.reset(seed=0)
    mask = np.array([False, True, False])
    envs.reset(options={"reset_mask": mask, "mass": (7, 7), "success_time": 2.0})
    assert envs.task.world.parameters.mass[:, FIRST_BLOCK].tolist() == [5.0, 7.0, 5.0]
    assert envs.task.task_state["stand_steps"].tolist() == [30, 60, 30]
    envs.reset(options={"reset_mask": mask})
    assert envs.task.world.parameters.mass[:, FIRST_BLOCK].tolist() == [5.0, 5.0, 5.0]


@pytest.mark.parametrize("fidelity", ["fast", "balanced", "accurate"])
def test_fidelity_reaches_the_solver(fidelity: str) -> None:
    env = StackEnv(fidelity=fidelity)
    assert env.task.world.options == Options.preset(fidelity, articulated=False)
    env.reset(seed=0)
    for _ in range(5):
        env.step(IDLE)


# ---------------------------------------------------------------- pixels


def test_pixels_are_pictures_of_the_state() -> None:
    pixels, state = StackEnv(observation="pixels"), StackEnv()
    first, _ = pixels.reset(seed=0)
    state.reset(seed=0)
    assert first.shape == (84, 84, 3)
    assert first.dtype == np.uint8
    assert first.std() > 10
    for action in mixed_actions(0, (20,)):
        frame, reward, terminated, _, info = pixels.step(action)
        assert pixels.observation_space.contains(frame)
        expected = state.step(action)
        assert (reward, terminated, info) == (expected[1], expected[2], expected[4])
        np.testing.assert_array_equal(pixels.observation, state.observation)
        if terminated:
            break
    assert (frame != first).any()


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_pixels_of_a_batch_equal_those_of_single_environments(mode: str) -> None:
    batch = StackVectorEnv(2, observation="pixels", autoreset_mode=mode)
    assert batch.observation_space.shape == (2, 84, 84, 3)
    frames, _ = batch.reset(seed=3)
    singles = [StackEnv(observation="pixels") for _ in range(2)]
    for i, env in enumerate(singles):
        np.testing.assert_array_equal(env.reset(seed=3 + i)[0], frames[i])
    running = [True, True]
    for actions in mixed_actions(1, (600, 2)):
        frames, _, terminated, _, infos = batch.step(actions)
        for i, env in enumerate(singles):
            if running[i]:
                frame, _, ended, _, _ = env.step(actions[i])
                assert ended == terminated[i]
                last = infos["final_obs"][i] if ended and mode == "SameStep" else frames[i]
                np.testing.assert_array_equal(frame, last)
                running[i] = not ended
        if not any(running):
            return
    pytest.fail("not all worlds ended")


def test_pixels_show_cracks() -> None:
    env = StackEnv(observation="pixels")
    env.reset(seed=0)
    state = env.task.task_state
    for action in mixed_actions(0, (200,)):
        shown, _, terminated, _, _ = env.step(action)
        if state["cracked"][0] or terminated:
            break
    assert state["cracked"][0]
    np.testing.assert_array_equal(env._observer.observe_world(env.task, 0), shown)
    state["cracked"] = 0
    whole = env._observer.observe_world(env.task, 0)
    assert (whole != shown).any(axis=-1).sum() > 10


def test_pixels_go_on_after_a_snapshot() -> None:
    env = StackEnv(observation="pixels")
    env.reset(seed=0)
    snapshot = env.save()
    first = env.step(IDLE)
    env.restore(snapshot)
    assert_equal(env.step(IDLE), first)


@pytest.mark.parametrize("env_id", ["GStack-v0", "GStack3D-v0", "tower_v0"])
def test_the_heaviest_and_roughest_blocks_are_seen_as_they_are(env_id: str) -> None:
    """At the ends of the arguments' and of the randomised ranges, where drives are strongest, too."""
    ends = {"friction": (3.0, 3.0), "mass": (3.0, 3.0), "force": (3.0, 3.0)}
    batch = make_batch(env_id, 2, mass=(20.0, 20.0), friction=(1.0, 1.0), randomize=ends)
    observations, _ = batch.reset(seed=0)
    at = {entry.name: k for k, entry in enumerate(batch.task.observations)}
    assert observations[..., at["block_mass"]] == pytest.approx(6.0)
    assert observations[..., at["block_friction"]] == pytest.approx(3.0)
    upwards = at["drive_z" if "drive_z" in at else "drive_y"]
    hard = np.zeros(len(batch.task.actions), np.float32)
    hard[2 if "drive_z" in at else 1] = 1.0  # upwards
    strongest = 0.0
    for _ in range(30):
        observations = batch.step(np.broadcast_to(hard, (*observations.shape[:-1], len(hard))))[0]
        strongest = max(strongest, float(observations[..., upwards].max()))
    assert strongest == pytest.approx(3.0, rel=1e-3)  # the whole force of the strongest drive, not cut off
