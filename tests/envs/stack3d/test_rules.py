"""GStack3D-v0: what counts as placed, fallen and built, on constructed states; its blocks, drive and builder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.envs.core.policies import scripted_actions
from gsenv.envs.stack import shared_rules as rules
from gsenv.envs.stack.settings import CRACK_SPEED
from gsenv.envs.stack3d import blocks as parts
from gsenv.envs.stack3d import scene
from gsenv.envs.stack3d.env import Stack3DEnv, Stack3DTask, Stack3DVectorEnv
from gsenv.envs.stack3d.policy import drop_blocks
from gsenv.envs.stack3d.scene import FIRST_BLOCK, FIRST_BLOCK_SHAPE, GRIPPER_BODY
from gsenv.train.evaluate import evaluate
from tests.envs.registered import terms_of
from tests.envs.stack3d.worlds import (
    DOWN,
    IDLE,
    RELEASE,
    block_position,
    mixed_actions,
    place_gripper,
    set_up_tower,
    turn_z,
)

INDEX = {entry.name: k for k, entry in enumerate(Stack3DTask.observations)}
build_tower = scripted_actions("GStack3D-v0")


@pytest.fixture
def env() -> Stack3DEnv:
    env = Stack3DEnv()
    env.reset(seed=0, options={"blocks": 3})
    return env


def run(env: Stack3DEnv, steps: int, action: Any = IDLE) -> tuple[Any, ...]:
    for _ in range(steps):
        result = env.step(action)
        if result[2]:
            break
    return result


def read(observation: Any, *names: str) -> Any:
    return np.array([observation[INDEX[name]] for name in names], float)


# ---------------------------------------------------------------- rules


def test_a_tower_succeeds_after_one_second(env: Stack3DEnv) -> None:
    set_up_tower(env.task, 3)
    for step in range(1, 31):
        _, _, terminated, _, info = env.step(IDLE)
        assert terminated == info["success"] == info["is_success"] == (step == 30)
        assert info["placed"] == 3
        assert info["stand_time"] == pytest.approx(step / 30)
    assert info["reward_success"] == 5.0


def test_a_block_counts_once(env: Stack3DEnv) -> None:
    set_up_tower(env.task, 2)
    env.task.task_state["blocks"] = 2
    assert env.step(IDLE)[4]["reward_placed"] == 1.0
    assert env.step(IDLE)[4]["reward_placed"] == 0.0


def test_a_tower_under_the_gripper_does_not_count(env: Stack3DEnv) -> None:
    heights = set_up_tower(env.task, 3)
    half = env.task.world.parameters.half_extents[0, FIRST_BLOCK_SHAPE + 2, 2]
    place_gripper(env.task, heights[2] + half + scene.PAD_HEIGHT)
    _, _, terminated, _, info = run(env, 60, 0.3 * DOWN)
    assert not terminated
    assert info["placed"] == 2
    assert info["stand_time"] == 0.0


def test_an_unfinished_tower_does_not_succeed(env: Stack3DEnv) -> None:
    env.task.task_state["blocks"] = 4
    set_up_tower(env.task, 3)
    _, _, terminated, _, info = run(env, 40)
    assert not terminated
    assert not info["success"]


@pytest.mark.parametrize("how", ["tipped", "beside", "sunk", "twisted"])
def test_a_fallen_block_ends_the_episode(env: Stack3DEnv, how: str) -> None:
    heights = set_up_tower(env.task, 3)
    assert not env.step(IDLE)[2]
    world = env.task.world
    if how == "tipped":
        world.set_pose("block_2", orientation=(np.cos(0.275), 0.0, np.sin(0.275), 0.0))
    elif how == "beside":
        world.set_pose("block_2", position=(1.5, 0.5, heights[2]))
    elif how == "sunk":
        world.set_pose("block_2", position=(1.5, 0.0, heights[2] - 0.1))
    else:
        world.set_pose("block_2", orientation=turn_z(0.35))
    _, _, terminated, _, info = run(env, 60)
    assert terminated
    assert not info["success"]
    assert info["reward_fall"] == -0.2
    assert info["reward_success"] == 0.0


@pytest.mark.parametrize("turn", [0.25, 0.5 * np.pi, -0.5 * np.pi + 0.2, np.pi - 0.1])
def test_sides_that_are_in_line_are_no_fall(env: Stack3DEnv, turn: float) -> None:
    """A box looks the same to the rule after a quarter turn."""
    set_up_tower(env.task, 3)
    env.task.world.set_pose("block_1", orientation=turn_z(turn))
    env.task.world.set_pose("block_2", orientation=turn_z(turn))
    observation, _, terminated, _, _ = env.step(IDLE)
    assert not terminated
    assert read(observation, "block_twist")[0] == pytest.approx(0.0, abs=0.01)
    nearest = (turn + 0.25 * np.pi) % (0.5 * np.pi) - 0.25 * np.pi
    assert read(observation, "support_heading")[0] == pytest.approx(nearest, abs=0.01)


def test_the_first_block_may_lie_as_it_likes(env: Stack3DEnv) -> None:
    set_up_tower(env.task, 1)
    env.task.world.set_pose("block_0", orientation=turn_z(0.7))
    assert not run(env, 30)[2]


def fastest_impact(env: Stack3DEnv, steps: int, action: Any = IDLE) -> float:
    """Return the fastest impact in m/s of the next steps."""
    fastest = 0.0
    for _ in range(steps):
        _, _, terminated, _, info = env.step(action)
        fastest = max(fastest, info["impact"])
        if terminated:
            break
    return fastest


@pytest.mark.parametrize("height", [0.002, 0.02, 0.3])
def test_an_impact_has_the_speed_of_a_free_fall(env: Stack3DEnv, height: float) -> None:
    env.reset(seed=0, options={"crack_speed": 100.0})
    heights = set_up_tower(env.task, 2)
    env.task.world.set_pose("block_1", position=(0.0, 0.0, heights[1] + height))
    assert fastest_impact(env, 20) == pytest.approx(np.sqrt(2.0 * 9.81 * height), rel=0.02)


@pytest.mark.parametrize(("height", "cracks"), [(0.007, False), (0.0095, True)])
def test_a_block_cracks_above_the_speed_that_is_set(env: Stack3DEnv, height: float, cracks: bool) -> None:
    heights = set_up_tower(env.task, 2)
    env.task.world.set_pose("block_1", position=(0.0, 0.0, heights[1] + height))
    _, _, terminated, _, info = run(env, 10)
    assert info["cracked"] == terminated == cracks
    assert info["reward_crack"] == (-0.2 if cracks else 0.0)
    assert (env.task.lines(0) is not None) == cracks


def test_a_tower_that_stands_has_no_impacts(env: Stack3DEnv) -> None:
    env.reset(seed=0, options={"blocks": 6, "success_time": 10.0})
    set_up_tower(env.task, 6)
    fastest_impact(env, 3)
    assert fastest_impact(env, 100) < 0.01


def test_only_careful_builders_build() -> None:
    scripted = evaluate(build_tower, "GStack3D-v0", 20)
    assert scripted.success_rate >= 0.9
    generator = np.random.default_rng(0)

    def random_policy(observations: Any) -> Any:
        return generator.uniform(-1.0, 1.0, (len(observations), 5)).astype(np.float32)

    for policy in (lambda seen: np.zeros((len(seen), 5), np.float32), random_policy, drop_blocks):
        other = evaluate(policy, "GStack3D-v0", 10)
        assert other.success_rate == 0.0
        assert other.mean_return < 0.3 * scripted.mean_return


def test_the_held_block_may_be_anywhere(env: Stack3DEnv) -> None:
    assert not run(env, 150, 0.2 * DOWN)[2]


def test_a_block_let_go_falls_to_the_ground_and_stays(env: Stack3DEnv) -> None:
    env.reset(seed=0, options={"crack_speed": 100.0})
    half = env.task.world.parameters.half_extents[0, FIRST_BLOCK_SHAPE, 2]
    observation, *_ = env.step(RELEASE)
    assert read(observation, "holding") == 0.0
    run(env, 40)
    assert block_position(env.task, 0)[2] == pytest.approx(half, abs=2e-3)


def test_the_next_block_arrives_in_the_gripper_and_only_where_there_is_room(env: Stack3DEnv) -> None:
    observation, _ = env.reset(seed=1, options={"blocks": 3})
    while read(observation, "holding"):
        observation = env.step(build_tower(observation))[0]
    for _ in range(60):  # the gripper stays where it let go
        observation = env.step(IDLE)[0]
        assert not read(observation, "holding")
    assert read(observation, "placed") == pytest.approx(1 / 6)
    rise = float(read(observation, "rise")[0])
    assert rise > 0.0
    before = float(read(observation, "gripper_z")[0])
    while not read(observation, "holding"):
        observation = env.step(np.array([0, 0, 0.5, 0, -1], np.float32))[0]
    assert read(observation, "gripper_z")[0] - before == pytest.approx(rise, abs=0.03)  # a step is 25 mm
    motion = env.task.world.state.bodies["velocity"][0]
    np.testing.assert_allclose(motion[FIRST_BLOCK + 1], motion[GRIPPER_BODY], atol=1e-9)


# ---------------------------------------------------------------- physics


def test_blocks_have_the_mass_and_inertia_of_their_size() -> None:
    """What the kernel writes is what Parameters.set derives from size and density, in all worlds."""
    env = Stack3DVectorEnv(5, randomize={"mass": (0.5, 2.0)})
    env.reset(seed=3)
    parameters = env.task.world.parameters
    names = ("mass", "inertia", "extent", "radius")
    drawn = {name: parameters.bodies[name].copy() for name in names}
    for k in range(scene.MAX_BLOCKS):
        shape = parameters.shapes[:, FIRST_BLOCK_SHAPE + k]
        size, density = shape["size"].copy(), shape["density"].copy()
        parameters.set(f"block_{k}", half_extents=2.0 * size, density=1.0)
        parameters.set(f"block_{k}", half_extents=size, density=density)
    for name in names:
        np.testing.assert_allclose(parameters.bodies[name], drawn[name], rtol=1e-12, err_msg=name)
    assert drawn["mass"][:, FIRST_BLOCK:].std() > 1.0


def test_the_drive_carries_the_weight_of_block_and_grasp() -> None:
    """At rest its force is m g, its torque about x and y the weight times how far off the middle it hangs."""
    env = Stack3DEnv(mass=(16.0, 16.0), grasp_offset=0.8)
    env.reset(seed=4)
    observation = run(env, 60)[0]
    weight = 16.0 * 9.81
    force = read(observation, "drive_x", "drive_y", "drive_z") * scene.MAX_FORCE
    np.testing.assert_allclose(force, [0.0, 0.0, weight], atol=0.5)
    dx, dy = -read(observation, "grasp_dx", "grasp_dy")  # of the block's middle from the gripper
    torque = read(observation, "drive_turn_x", "drive_turn_y", "drive_turn_z") * scene.MAX_TORQUE
    np.testing.assert_allclose(torque, [dy * weight, -dx * weight, 0.0], atol=0.3)
    assert abs(torque).max() > 5.0
    tilt = read(observation, "gripper_tilt_x", "gripper_tilt_y")
    assert tilt[0] * dx > 0.0  # it sags to where the block hangs
    assert tilt[1] * dy > 0.0


def test_the_gripper_stops_at_an_obstacle_and_comes_back_upright() -> None:
    env = Stack3DEnv(crack_speed=100.0)
    env.reset(seed=2)
    pressed = run(env, 90, DOWN)[0]
    assert abs(read(pressed, "drive_z")[0]) <= 1.0
    assert read(pressed, "gripper_z")[0] > 0.2
    lifted = run(env, 60, np.array([0, 0, 0.5, 0, -1], np.float32))[0]
    level = run(env, 60, IDLE)[0]
    assert read(lifted, "gripper_z")[0] > read(pressed, "gripper_z")[0] + 0.3
    assert abs(read(level, "gripper_tilt_x", "gripper_tilt_y")).max() < 0.05


def test_equal_seeds_give_equal_blocks_for_any_number_of_them(env: Stack3DEnv) -> None:
    env.reset(seed=3)
    three = env.task.world.parameters.shapes["size"].copy()
    env.reset(seed=3, options={"blocks": 6})
    np.testing.assert_array_equal(three, env.task.world.parameters.shapes["size"])


def test_reward_is_the_sum_of_its_terms(env: Stack3DEnv) -> None:
    seen: set[str] = set()
    for seed, policy in ((0, "random"), (1, "random"), (0, "builder")):
        observation, _ = env.reset(seed=seed, options={"blocks": 2})
        for action in mixed_actions(seed, (400,)):
            if policy == "builder":
                action = build_tower(observation)
            observation, reward, terminated, _, info = env.step(action)
            assert sum(terms_of(info).values()) == reward
            seen |= {name for name, value in terms_of(info).items() if value}
            if terminated:
                break
    env.reset(options={"blocks": 2})
    set_up_tower(env.task, 2)
    env.task.world.set_pose("block_1", position=(1.5, 0.5, 0.1))
    seen |= {name for name, value in terms_of(env.step(IDLE)[4]).items() if value}
    assert seen == {term.name for term in Stack3DTask.reward_terms}


def test_observations_stay_in_bounds_and_every_entry_varies(env: Stack3DEnv) -> None:
    low, high = np.full(len(INDEX), np.inf), np.full(len(INDEX), -np.inf)
    for seed in range(24):
        observation, _ = env.reset(seed=seed)
        for k, action in enumerate(mixed_actions(seed, (500,))):
            assert env.observation_space.contains(observation)
            low, high = np.minimum(low, observation), np.maximum(high, observation)
            built = seed % 2 == 0 and k < 250
            observation, _, terminated, _, _ = env.step(build_tower(observation) if built else action)
            if terminated:
                assert env.observation_space.contains(observation)
                break
    assert not [name for name, k in INDEX.items() if not high[k] - low[k] > 1e-4]


# ---------------------------------------------------------------- builder


@pytest.mark.parametrize(("blocks", "count", "least"), [(2, 30, 28), (3, 100, 95), (6, 20, 12)])
def test_builder_builds(blocks: int, count: int, least: int) -> None:
    vector = Stack3DVectorEnv(count, blocks=blocks, max_episode_steps=600, autoreset_mode="SameStep")
    observations, _ = vector.reset(seed=0)
    done = np.zeros(count, bool)
    built = 0
    for _ in range(600):
        observations, _, terminated, truncated, infos = vector.step(build_tower(observations))
        if "final_info" in infos:
            built += int((infos["final_info"]["success"] & ~done).sum())
        done |= terminated | truncated
        if done.all():
            break
    assert built >= least


def test_random_actions_do_not_build() -> None:
    vector = Stack3DVectorEnv(50, max_episode_steps=600, autoreset_mode="SameStep")
    vector.reset(seed=0)
    generator = np.random.default_rng(0)
    episodes = built = 0
    while episodes < 100:
        actions = generator.uniform(-1.0, 1.0, (50, 5)).astype(np.float32)
        _, _, terminated, truncated, infos = vector.step(actions)
        ended = terminated | truncated
        episodes += int(ended.sum())
        if ended.any():
            built += int(infos["final_info"]["success"].sum())
    assert built / episodes < 0.05


# ---------------------------------------------------------------- specification


@pytest.mark.parametrize(
    "text",
    [
        f"a body of {scene.GRIPPER_MASS:g} kg",
        f"at most {scene.MAX_FORCE:g} N along each axis",
        f"at most {scene.MAX_TORQUE:g} N m",
        f"slower than {rules.REST_SPEED:g} m/s and {1.5 * rules.REST_SPEED:g} rad/s",
        f"{100 * rules.ARRIVAL_MARGIN:g} cm wider than the block",
        f"within {scene.REACH:g} m of the middle along x and y, between {scene.REACH_Z[0]:g} and "
        f"{scene.REACH_Z[1]:g} m high, and within {scene.REACH_ANGLE:g} rad",
        f"up to {scene.START:g} m from the middle along x and y",
        f"{scene.START_Z[0]:.1f} to {scene.START_Z[1]:g} m high",
        f"m, of blocks along x and y: (lowest, highest), within 0.1 to 0.3 | {scene.HALF_WIDTH} |",
        f"m, of blocks: (lowest, highest), within 0.05 to 0.22 | {scene.HALF_HEIGHT} |",
        f"kg, of blocks: (lowest, highest), within 0.5 to 20 | {scene.MASS} |",
        f"coefficient, of blocks: (lowest, highest), within 0 to 1 | {scene.FRICTION} |",
        f"of its half-widths, within 0 to 0.8 | {scene.GRASP_OFFSET:g} |",
        f"rad, how far a block is turned in the gripper, within 0 to 0.75 | {scene.GRASP_TURN:g} |",
        f"m/s, of the slowest impact that cracks a block, within 0.05 to 100 | {CRACK_SPEED:g} |",
        f"tilted by more than {rules.TIPPED:g} rad, is twisted by more than {parts.TWISTED:g} rad",
        f"`Box(low, high, ({len(INDEX)},), float32)`",
        *(f"| {entry.name} " for entry in (*Stack3DTask.actions, *Stack3DTask.observations)),
        *(f"| {entry.name} " for entry in Stack3DTask.reward_terms),
        *(f"| {entry.name} " for entry in Stack3DTask.arguments),
        *(f"| {entry.name} " for entry in Stack3DTask.quantities),
    ],
)
def test_docstring_agrees_with_the_task(text: str) -> None:
    assert text in " ".join((Stack3DEnv.__doc__ or "").split())
