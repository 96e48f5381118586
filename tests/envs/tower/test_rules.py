"""tower_v0's rules, its batch, and its scripted builder."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.envs.stack import scene as stack
from gsenv.envs.tower import scene
from gsenv.envs.tower.env import TowerTask, TowerVectorEnv
from gsenv.envs.tower.policy import build_together, drop_together
from tests.envs.registered import terms_of
from tests.envs.stack.worlds import assert_equal, mixed_actions

INDEX = {entry.name: k for k, entry in enumerate(TowerTask.observations)}
STILL = np.tile(np.array([0, 0, 0, -1], np.float32), (1, 2, 1))


@pytest.fixture
def vector() -> TowerVectorEnv:
    env = TowerVectorEnv(1, autoreset_mode="Disabled")
    env.reset(seed=0)
    return env


def success_of(policy: Any, count: int, seed: int = 0, **settings: Any) -> NDArray[np.bool_]:
    """Success of the first episode of each world."""
    vector = TowerVectorEnv(count, max_episode_steps=900, autoreset_mode="SameStep", **settings)
    observations, _ = vector.reset(seed=seed)
    done, success = np.zeros(count, bool), np.zeros(count, bool)
    while not done.all():
        observations, _, terminated, truncated, infos = vector.step(policy(observations))
        ended = (terminated | truncated) & ~done
        if ended.any():
            success |= ended & infos["final_info"]["success"]
        done |= ended
    return success


@pytest.mark.parametrize(("blocks", "count", "least"), [(2, 20, 16), (4, 50, 40), (8, 20, 16)])
def test_builders_build(blocks: int, count: int, least: int) -> None:
    assert success_of(build_together, count, blocks=blocks).sum() >= least


@pytest.mark.parametrize("kind", ["uniform", "holding"])
def test_random_actions_do_not_build(kind: str) -> None:
    generator = np.random.default_rng(0)

    def policy(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        actions = generator.uniform(-1.0, 1.0, (100, 2, 4)).astype(np.float32)
        if kind == "holding":
            actions[..., 3] -= 0.99
        return actions

    assert success_of(policy, 100, blocks=2).mean() < 0.05


def test_one_builder_alone_does_not_succeed() -> None:
    def policy(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        actions = build_together(observations)
        actions[:, 1] = STILL[0, 1]
        return actions

    assert not success_of(policy, 10).any()


# ---------------------------------------------------------------- the batch


@pytest.mark.parametrize("threads", [1, 2])
def test_world_i_equals_the_single_environment_seeded_s_plus_i(threads: int) -> None:
    tower_v0 = pytest.importorskip("gsenv.envs.tower_v0")
    count, steps, seed = 5, 220, 40
    arguments: dict[str, Any] = {"randomize": {"mass": (0.5, 2.0), "force": (1.0, 2.0)}, "blocks": 6}
    vector = TowerVectorEnv(count, threads=threads, autoreset_mode="Disabled", **arguments)
    singles = [tower_v0.parallel_env(max_cycles=-1, **arguments) for _ in range(count)]
    observations, _ = vector.reset(seed=seed)
    for w, single in enumerate(singles):
        single.reset(seed=seed + w)
        np.testing.assert_array_equal(single.observations, observations[w])
    noise = mixed_actions(1, (steps, count, 2))
    for t in range(steps):
        actions = build_together(observations)
        actions[0] = noise[t, 0]  # one world of noise among builders with a little of it
        actions[1:, :, :3] += 0.2 * noise[t, 1:, :, :3]
        observations, rewards, terminated, _, infos = vector.step(actions)
        for w, single in enumerate(singles):
            _, reward, ends, _, info = single.step(dict(zip(single.agents, actions[w], strict=True)))
            assert single.observations.tobytes() == observations[w].tobytes()
            assert list(reward.values()) == rewards[w].tolist()
            assert list(ends.values()) == [terminated[w]] * 2
            for a, agent in enumerate(single.possible_agents):
                for name, value in terms_of(info[agent]).items():
                    assert value == infos[f"reward_{name}"][w, a]
        if terminated.any():
            vector.reset(options={"reset_mask": terminated})
            for w in np.flatnonzero(terminated).tolist():
                singles[w].reset()
            observations = vector.observe()


def test_snapshots_and_pickles_of_the_batch() -> None:
    vector = TowerVectorEnv(3, max_episode_steps=60, autoreset_mode="NextStep")
    observations, _ = vector.reset(seed=0)
    for _ in range(50):
        observations = vector.step(build_together(observations))[0]
    saved = pickle.loads(pickle.dumps(vector.save()))
    actions = mixed_actions(0, (40, 3, 2))
    first = [vector.step(action) for action in actions]
    other = TowerVectorEnv(3, max_episode_steps=60, autoreset_mode="NextStep")
    other.restore(saved)
    assert_equal(first, [other.step(action) for action in actions])


def test_observations_vary_and_stay_within_bounds() -> None:
    vector = TowerVectorEnv(24, max_episode_steps=600, autoreset_mode="SameStep", crack_speed=100.0)
    low, high = vector.task.low, vector.task.high
    observations, _ = vector.reset(seed=0)
    seen: list[NDArray[np.float32]] = []
    for actions in mixed_actions(0, (450, 24, 2)):
        actions[8:] = build_together(observations[8:])
        actions[8:16, :, :3] += 0.3 * mixed_actions(len(seen), (8, 2))[..., :3]
        leaving = observations[20:, :, INDEX["holding"]] < 0.5
        actions[20:, :, :2][leaving] = (-1.0, -0.5)  # low, where the gripper must rise for its next block
        observations = vector.step(actions)[0]
        assert (observations >= low).all()
        assert (observations <= high).all()
        seen.append(observations)
    for agent in range(2):
        spread = np.ptp(np.array(seen)[:, :, agent], axis=(0, 1))
        dead = [entry.name for entry, range_ in zip(TowerTask.observations, spread, strict=True) if range_ < 0.02]
        assert not dead


# ---------------------------------------------------------------- frames


def test_both_see_the_same_world_from_their_own_sides(vector: TowerVectorEnv) -> None:
    for actions in mixed_actions(3, (15, 1, 2)):
        actions[..., 3] = -1.0
        left, right = vector.step(actions)[0][0]
        physics = vector.task.world
        for a, (mine, other, side) in enumerate(((left, right, 1.0), (right, left, -1.0))):
            gripper = scene.FIRST_GRIPPER + a
            assert mine[INDEX["gripper_x"]] == np.float32(side * physics.position[0, gripper, 0])
            assert mine[INDEX["gripper_y"]] == np.float32(physics.position[0, gripper, 1])
            assert mine[INDEX["gripper_vx"]] == np.float32(side * physics.linear_velocity[0, gripper, 0])
            assert mine[INDEX["gripper_w"]] == np.float32(side * physics.angular_velocity[0, gripper])
            for name in ("dx", "gap"):
                sign = -1.0 if name == "dx" else 1.0
                assert mine[INDEX[f"other_block_{name}"]] == sign * other[INDEX[f"block_{name}"]]
            assert mine[INDEX["other_angle"]] == -other[INDEX["gripper_angle"]]
            assert mine[INDEX["other_to_go"]] == other[INDEX["to_go"]]
        assert left[INDEX["other_dx"]] == right[INDEX["other_dx"]]
        assert left[INDEX["other_dy"]] == -right[INDEX["other_dy"]]


def test_mirror_images_act_alike(vector: TowerVectorEnv) -> None:
    """Empty grippers at mirrored places, the same actions: the same observations of themselves."""
    task = vector.task
    task.world.parameters.joints["enabled"][0, scene.FIRST_WELD :] = 0
    for k, side in enumerate((-1.0, 1.0)):
        task.world.parameters.set(f"block_{k}", enabled=0)
        task.world.set_pose(f"gripper_{scene.AGENTS[k]}", position=(1.5 * side, 1.5), angle=0.0)
        task.world.set_target(f"drive_{scene.AGENTS[k]}", position=(1.5 * side, 1.5), angle=0.0)
    for action in mixed_actions(4, (30, 1)):
        observations = vector.step(np.stack([action, action], axis=1))[0]
        np.testing.assert_allclose(observations[0, 0, :9], observations[0, 1, :9], atol=1e-5)
    assert np.abs(observations[0, 0, [0, 2, 3, 5]]).min() > 1e-4


def test_grippers_collide() -> None:
    """Both go inwards: in every world they meet, with what they hold, and it costs both."""
    vector = TowerVectorEnv(8, autoreset_mode="Disabled", crack_speed=100.0)
    vector.reset(seed=0)
    actions = np.tile(STILL, (8, 1, 1))
    actions[..., 0] = 1.0
    met = np.zeros(8, bool)
    for step in range(60):
        infos = vector.step(actions)[4]
        assert step > 5 or not infos["bump"].any()
        paid = np.where(infos["bump"], -0.02, 0.0)
        np.testing.assert_array_equal(infos["reward_bump"], np.stack([paid, paid], axis=1))
        met |= infos["bump"]
    assert met.all()
    assert vector.task.world.diagnostics().penetration.max() < 0.01


# ---------------------------------------------------------------- rules


@pytest.mark.parametrize("first", [0, 1])
def test_either_may_begin(first: int) -> None:
    vector = TowerVectorEnv(1, autoreset_mode="Disabled", blocks=2)
    vector.reset(seed=1)
    # The one that waits is further from the tower: it is pushed out while the other builds.
    second = 1 - first
    vector.task.world.set_pose(f"gripper_{scene.AGENTS[second]}", position=(2.0 * (2 * second - 1), 1.9))
    observations = vector.observe()
    terms = np.zeros(2)
    partner = np.zeros(2)
    for _ in range(300):
        actions = build_together(observations)
        if vector.task.task_state["placed"][0] == 0:
            actions[:, second] = [-1.0, 0.0, 0.0, -1.0]
            actions[:, first] = build_together(seen_alone(observations[:, first]))
        observations, _, terminated, _, infos = vector.step(actions)
        terms += infos["reward_placed"][0]
        partner += infos["reward_partner"][0]
        if terminated[0]:
            break
    assert infos["success"][0]
    assert vector.task.task_state["order"][0, :2].tolist() == [first, second]
    assert terms.tolist() == [1.0, 1.0]
    assert partner.tolist() == [0.5, 0.5]
    np.testing.assert_array_equal(infos["reward_success"][0], [5.0, 5.0])


def seen_alone(observation: NDArray[np.float32]) -> NDArray[np.float32]:
    """As if the other were far away with nothing in hand."""
    observation = observation.copy()
    observation[..., INDEX["other_holding"]] = 0.0
    observation[..., INDEX["other_dx"]] = 3.0
    return observation


def test_released_beside_the_plinth_is_a_fall(vector: TowerVectorEnv) -> None:
    vector.reset(seed=0, options={"crack_speed": 100.0})
    actions = STILL.copy()
    actions[0, 1, 3] = 1.0
    for _ in range(60):
        _, rewards, terminated, _, infos = vector.step(actions)
        actions = STILL
        if terminated[0]:
            break
    assert terminated[0]
    assert not infos["success"][0]
    np.testing.assert_array_equal(infos["reward_fall"][0], [-0.2, -0.2])
    assert (rewards < -0.19).all()


def test_one_gripper_has_the_turn(vector: TowerVectorEnv) -> None:
    """The left one first; then the one that has released fewer blocks."""
    observations = vector.observe()
    state = vector.task.task_state[0]
    seen = set()
    for _ in range(400):
        turns = observations[0, :, INDEX["turn"]]
        released = state["arrived"] - state["held"]
        assert turns.tolist() == ([1.0, 0.0] if released[0] <= released[1] else [0.0, 1.0])
        seen.add(tuple(turns.tolist()))
        observations, _, terminated, _, _ = vector.step(build_together(observations))
        if terminated[0]:
            break
    assert seen == {(1.0, 0.0), (0.0, 1.0)}


def test_a_block_that_is_dropped_cracks(vector: TowerVectorEnv) -> None:
    actions = STILL.copy()
    actions[0, 1, 3] = 1.0
    for _ in range(60):
        _, rewards, terminated, _, infos = vector.step(actions)
        actions = STILL
        if terminated[0]:
            break
    assert infos["cracked"][0]
    assert infos["impact"][0] > 1.0
    np.testing.assert_array_equal(infos["reward_crack"][0], [-0.2, -0.2])
    assert (rewards < -0.19).all()
    assert vector.task.task_state["cracked"][0] == 2
    assert not success_of(drop_together, 20, blocks=2).any()


def test_the_next_block_comes_at_the_own_depot_only(vector: TowerVectorEnv) -> None:
    state = vector.task.task_state[0]
    observations = vector.observe()
    while state["released"] == 0:
        observations = vector.step(build_together(observations))[0]
    builder = int(state["order"][0])
    for _ in range(200):
        observations = vector.step(build_together(observations))[0]
        if state["arrived"][builder] == 2:
            break
        assert observations[0, builder, INDEX["holding"]] == 0.0
    out = -observations[0, builder, INDEX["gripper_x"]]
    assert out >= -scene.DEPOT_X - 0.01
    assert state["block"][builder] == 2 + builder
    assert state["placed"] >= 1


def test_waiting_earns_nothing_when_the_other_builds() -> None:
    """A new top is a new phase: it neither pays nor costs the one that waits."""
    vector = TowerVectorEnv(1, autoreset_mode="Disabled")
    observations, _ = vector.reset(seed=0)
    before = 0
    for _ in range(150):
        observations, _, _, _, infos = vector.step(build_together(observations))
        released = int(vector.task.task_state["released"][0])
        if released > before:
            np.testing.assert_array_equal(infos["reward_approach"][0], [0.0, 0.0])
            before = released
    assert before >= 1


def test_settings_last_for_an_episode_or_for_all() -> None:
    vector = TowerVectorEnv(2, blocks=2)
    vector.reset(seed=0, options={"blocks": 6})
    assert vector.task.task_state["blocks"].tolist() == [6, 6]
    vector.reset(seed=0)
    assert vector.task.task_state["blocks"].tolist() == [2, 2]
    vector.set_attr("blocks", 8)
    vector.reset(seed=0)
    assert vector.task.task_state["blocks"].tolist() == [8, 8]
    with pytest.raises(ValueError, match="blocks must be 2, 4, 6 or 8"):
        vector.set_attr("blocks", 5)


def test_randomize_scales_both_drives() -> None:
    vector = TowerVectorEnv(2, randomize={"force": (2.0, 2.0)})
    vector.reset(seed=0)
    forces = vector.task.world.parameters.joints["max_force"][:, :2]
    np.testing.assert_array_equal(forces, np.full((2, 2), 2.0 * stack.MAX_FORCE))
