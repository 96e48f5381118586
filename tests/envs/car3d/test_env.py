"""GCar3D's roads, car and ends; how drivers with and without skill fare."""

from __future__ import annotations

import math
import warnings
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from gsenv.envs import time_limit
from gsenv.envs.car3d import course, road, rules, scene
from gsenv.envs.car3d.env import Car3DEnv, Car3DHardcoreVectorEnv, Car3DTask, Car3DVectorEnv
from gsenv.envs.car3d.observe import surface_at
from gsenv.envs.car3d.policy import HABITS, hold_speed, pursue
from tests.envs.car3d.level_road import drive_for, level_env, move_car
from tests.envs.single_worlds import SingleWorlds, assert_info

G = 9.81
INDEX = {entry.name: k for k, entry in enumerate(Car3DTask.observations)}
SOLID = 0x7FFFFFFF & ~scene.DECOR


def chassis(env: Car3DEnv) -> Any:
    return env.task.world.state.bodies[0, scene.CHASSIS_BODY]


# ---------------------------------------------------------------- contract


def test_gymnasium_checker_has_no_complaint() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("gsenv:GCar3D-v0").unwrapped, skip_render_check=True)


def test_the_hardcore_tier_is_the_largest_difficulty_against_the_same_clock() -> None:
    first, second = Car3DVectorEnv(2, difficulty=1.0), Car3DHardcoreVectorEnv(2)
    assert first.max_episode_steps == second.max_episode_steps == time_limit("GCar3D-hardcore-v0")
    for cars in (first, second):
        cars.reset(seed=3)
    actions = np.array([[1.0, 0.2], [0.6, -0.4]], np.float32)
    for _ in range(60):
        np.testing.assert_array_equal(first.step(actions)[0], second.step(actions)[0])
    assert gymnasium.make("gsenv:GCar3D-hardcore-v0").unwrapped.difficulty == 1.0  # type: ignore[attr-defined]


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize(("count", "threads"), [(1, 1), (5, 2)])
def test_equals_single_environments(mode: AutoresetMode, count: int, threads: int) -> None:
    arguments: dict[str, Any] = {"difficulty": 1.0, "randomize": {"friction": (0.6, 1.2), "mass": (120.0, 200.0)}}
    vector = Car3DVectorEnv(count, max_episode_steps=70, autoreset_mode=mode, threads=threads, **arguments)
    observations, infos = vector.reset(seed=40)
    singles = SingleWorlds(lambda: Car3DEnv(**arguments), count, mode, 40, 70)
    for i, (observation, info) in enumerate(singles.resets):
        np.testing.assert_array_equal(observations[i], observation)
        assert_info(infos, info, i)
    generator = np.random.default_rng(4)
    ended = np.zeros(2, int)
    for _ in range(120):
        actions = np.stack([generator.uniform(0.3, 1.0, count), generator.uniform(-1.0, 1.0, count)], 1)
        observations, terminated, truncated = singles.compare_step(vector, observations, actions.astype(np.float32))
        ended += terminated, truncated
    assert ended.sum() > 0


def test_every_observation_varies_and_stays_in_bounds() -> None:
    vector = Car3DVectorEnv(12, difficulty=1.0)
    observations, _ = vector.reset(seed=0)
    low, high = observations.min(0), observations.max(0)
    generator = np.random.default_rng(0)
    for k in range(400):
        actions = pursue(observations)
        actions[4:8] = (1.0, 0.2)
        actions[8:] = generator.uniform(-1.0, 1.0, (4, 2)) if k % 100 < 50 else (-1.0, 0.0)
        observations = vector.step(actions)[0]
        assert vector.observation_space.contains(observations)
        low, high = np.minimum(low, observations.min(0)), np.maximum(high, observations.max(0))
    constant = [name for name, k in INDEX.items() if not high[k] - low[k] > 0.05]
    assert not constant


# ---------------------------------------------------------------- car


def test_the_car_rests_on_its_springs() -> None:
    env = level_env()
    drive_for(env, 90, (0.0, 0.0))
    world = env.task.world
    assert chassis(env)["position"][2] == pytest.approx(scene.CHASSIS_Z, abs=2e-3)
    assert abs(chassis(env)["velocity"]).max() < 1e-3
    for k in range(4):
        assert world.state.bodies["position"][0, scene.FIRST_WHEEL + k, 2] == pytest.approx(scene.RADIUS, abs=2e-3)


def test_acceleration_of_all_wheels_is_the_closed_form() -> None:
    """4 T / R over the mass with that of the rolling wheels, where no wheel slips."""
    env = level_env()
    drive_for(env, 60, (0.0, 0.0))
    drive_for(env, 20, (0.3, 0.0))
    before = chassis(env)["velocity"][0].copy()
    drive_for(env, 15, (0.3, 0.0))
    mass = scene.CHASSIS_MASS + 4.0 * (scene.WHEEL_MASS + scene.WHEEL_INERTIA / scene.RADIUS**2)
    expected = 4.0 * 0.3 * scene.TORQUE / scene.RADIUS / mass
    assert 2.0 * (chassis(env)["velocity"][0] - before) == pytest.approx(expected, rel=2e-2)


def test_steering_is_limited_in_rate_and_turns_the_car_on_a_circle() -> None:
    """The circle is somewhat wider than that of rolling on thin tyres, which has the wheelbase over tan(angle) as the
    radius at the rear axle: both front wheels are steered to the same angle, and wide tyres resist turning."""
    env = level_env()
    drive_for(env, 30, (0.0, 0.0))
    angles = []
    for _ in range(10):
        drive_for(env, 1, (0.15, 1.0))
        angles.append(float(env.task.task_state["steering"][0]))
    assert np.diff([0.0, *angles]).max() <= scene.STEERING_RATE / 30.0 + 1e-12
    assert angles[-1] == pytest.approx(scene.STEERING)
    drive_for(env, 20, (0.2, 1.0))
    velocity = chassis(env)["velocity"]
    speed, rate = math.hypot(*velocity[:2]), float(velocity[5])
    to_rear = 2.0 * scene.AXLES / math.tan(scene.STEERING)
    assert 0.3 < speed < 3.0
    assert 1.0 < speed / rate / math.hypot(to_rear, scene.AXLES) < 1.3


def test_brakes_stop_the_car_and_hold_it() -> None:
    env = level_env()
    drive_for(env, 45, (0.5, 0.0))
    assert chassis(env)["velocity"][0] > 3.0
    drive_for(env, 30, (-1.0, 0.0))
    place = chassis(env)["position"][0]
    drive_for(env, 60, (-1.0, 0.0))
    assert chassis(env)["position"][0] == pytest.approx(place, abs=2e-3)


# ---------------------------------------------------------------- courses


def test_roads_differ_from_world_to_world_and_from_episode_to_episode() -> None:
    vector = Car3DVectorEnv(3, difficulty=1.0)
    vector.reset(seed=0)
    first = vector.task.world.parameters.vertices["position"][..., 2].copy()
    vector.reset(options={"reset_mask": np.array([False, True, False])})
    second = vector.task.world.parameters.vertices["position"][..., 2]
    assert abs(first[0] - first[1]).max() > 0.5
    assert abs(first[1] - second[1]).max() > 0.5
    np.testing.assert_array_equal(first[[0, 2]], second[[0, 2]])


def test_heights_are_those_of_ground_and_obstacles() -> None:
    """Against rays cast down from the sky, on and beside the road."""
    env = Car3DEnv(difficulty=1.0)
    generator = np.random.default_rng(0)
    off = []
    for seed in range(6):
        env.reset(seed=seed)
        world, path = env.task.kernel_world, env.task.task_state["path"][0]
        for slot in range(scene.SLOTS):
            for _ in range(12):
                x, y, _ = road.road_point(path, env.task.task_state["places"][0, slot] + generator.uniform(-3.0, 3.0))
                y += generator.uniform(-1.1, 1.1)
                hits = env.task.world.cast_rays((x, y, 30.0), (0.0, 0.0, -1.0), 80.0, mask=SOLID)
                off.append(30.0 - hits.distance[0, 0] - surface_at(world, slot, x, y))
    assert np.median(abs(np.array(off))) < 0.01
    assert (abs(np.array(off)) < 0.08).mean() > 0.95  # edges of obstacles


def test_the_ground_is_level_across_the_road_and_courses_grow_harder() -> None:
    bends = []
    for difficulty in (0.0, 0.5, 1.0):
        vector = Car3DVectorEnv(10, difficulty=difficulty)
        vector.reset(seed=0)
        path = vector.task.task_state["path"]
        bends.append(abs(np.diff(path[..., road.HEADING])).max())
        assert abs(path[..., road.Y]).max() < scene.HALF_DEPTH - scene.STRAY
        assert np.diff(path[..., road.X]).min() > 0.0
        for w in range(10):
            x, y, _ = road.road_point(path[w], 45.0)
            heading = road.path_at(path[w], 45.0, road.HEADING)
            heights = [
                road.ground_at(
                    vector.task.world.parameters.vertices[w], x - s * math.sin(heading), y + s * math.cos(heading)
                )
                for s in (-1.0, 0.0, 1.0)
            ]
            assert np.ptp(heights) < 0.1
    assert bends[0] < bends[1] < bends[2]


def test_bends_have_the_radius_that_the_difficulty_allows() -> None:
    vector = Car3DVectorEnv(20, difficulty=1.0)
    vector.reset(seed=0)
    curvature = np.diff(vector.task.task_state["path"][..., road.HEADING]) / scene.STEP
    assert 0.9 / (road.WIDEST * road.RADIUS) < abs(curvature).max(axis=1).min()
    assert abs(curvature).max() < 1.1 / road.RADIUS


def test_the_nearest_point_of_the_road_is_that_of_a_search_over_all_nodes() -> None:
    vector = Car3DVectorEnv(4, difficulty=1.0)
    vector.reset(seed=0)
    generator = np.random.default_rng(0)
    for path in vector.task.task_state["path"]:
        for _ in range(40):
            s, aside = generator.uniform(0.0, scene.FINISH), generator.uniform(-2.0, 2.0)
            x, y, _ = road.road_point(path, s)
            heading = road.path_at(path, s, road.HEADING)
            x, y = x - aside * math.sin(heading), y + aside * math.cos(heading)
            found, distance = road.nearest(path, s + generator.uniform(-0.5, 0.5), x, y)
            least = np.hypot(path[:, road.X] - x, path[:, road.Y] - y).min()
            assert abs(found - s) < 0.1
            assert distance == pytest.approx(aside, abs=0.03)
            assert abs(distance) < least + 0.02


# ---------------------------------------------------------------- ends


def test_a_car_on_its_roof_ends_the_episode() -> None:
    env = level_env()
    env.task.world.set_pose("chassis", position=(0.0, 0.0, 5.0), orientation=(0.0, 1.0, 0.0, 0.0))
    _, _, terminated, _, info = env.step(np.zeros(2, np.float32))
    assert terminated
    assert info["rolled_over"]
    assert info["reward_failure"] == pytest.approx(-0.5 - 0.005 * 584)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("throttle", [0.1, 0.6])
def test_beside_the_road_the_car_pays_for_distance_and_time_until_it_strays(side: int, throttle: float) -> None:
    env = level_env()
    step, steps, terminated, info = 0, 0, False, dict[str, Any]()
    while not terminated:
        _, _, terminated, _, info = env.step(np.array([throttle, 0.3 * side], np.float32))
        step += 1
        aside = abs(env.task.world.state.bodies["position"][0, scene.CHASSIS_BODY, 1])
        off = aside > scene.ROAD_HALF
        steps += off
        assert info["off_road"] == off
        assert info["off_road_time"] == pytest.approx(steps / 30.0)
        cost = 0.02 + 0.01 * (aside - scene.ROAD_HALF) if off else 0.0
        assert info["reward_off_road"] == pytest.approx(-cost)
        assert info["reward_progress"] > 0.0 or off
        assert info["reward_progress"] <= 0.0 or not off
        assert terminated == info["strayed"] == (aside > scene.STRAY or steps == 30)
    assert (steps == 30) == (throttle < 0.3)
    assert steps > 5
    assert info["reward_failure"] == pytest.approx(-0.5 - 0.005 * (585 - step))
    assert not info["success"]


def test_a_car_that_turns_round_strays_and_earns_less_than_one_that_stands_still() -> None:
    env = level_env()
    terminated, info, total, steps = False, dict[str, Any](), 0.0, 0
    while not terminated:
        _, reward, terminated, _, info = env.step(np.array((0.3, 1.0), np.float32))
        total, steps = total + reward, steps + 1
    assert steps > 60
    assert info["strayed"]
    assert info["off_road_time"] == pytest.approx(1.0)  # the road is too narrow to turn round on it
    assert total < 585 * rules.TIME_REWARD


@pytest.mark.parametrize("beyond", [-0.2, 0.2])
def test_a_car_behind_the_start_strays(beyond: float) -> None:
    env = level_env()
    move_car(env, 0, -scene.STRAY_BEHIND - beyond)
    _, _, terminated, _, info = env.step(np.zeros(2, np.float32))
    assert terminated == info["strayed"] == (beyond > 0.0)


def test_a_ride_beside_the_road_is_no_success() -> None:
    env = level_env()
    terminated, info, steps = False, dict[str, Any](), 0
    while not terminated:
        if steps in (60, 64):
            move_car(env, 1, 3.0 if steps == 60 else -3.0)
        _, _, terminated, _, info = env.step(np.array([0.3, 0.0], np.float32))
        steps += 1
    assert info["reward_finish"] == rules.FINISH_REWARD
    assert info["off_road_time"] == pytest.approx(4 / 30)
    assert not info["off_road"]
    assert not info["strayed"]
    assert not info["success"]


def test_the_finish_ends_the_episode_with_success() -> None:
    env = Car3DEnv(difficulty=0.0)
    observation, info = env.reset(seed=0)
    total, steps, terminated = 0.0, 0, False
    while not terminated:
        observation, reward, terminated, _, info = env.step(pursue(observation, HABITS._replace(cruise=7.0)))
        total, steps = total + reward, steps + 1
    assert info["success"]
    assert info["reward_finish"] == rules.FINISH_REWARD
    earned = rules.PROGRESS_WEIGHT * info["distance"] + steps * rules.TIME_REWARD + rules.FINISH_REWARD
    assert total == pytest.approx(earned, rel=0.02)


def test_progress_is_paid_up_to_a_speed_beyond_which_it_costs_and_to_and_fro_earns_nothing() -> None:
    env = level_env()
    state = env.task.task_state
    drive_for(env, 90, (1.0, 0.0))
    place = float(state["place"][0])
    info = env.step(np.array([1.0, 0.0], np.float32))[4]
    progress = float(state["place"][0]) - place
    assert 30.0 * progress > 10.0  # m/s
    assert info["reward_progress"] == pytest.approx(0.1 * 8.0 / 30.0 - 0.1 * (progress - 8.0 / 30.0))
    earned = 0.0
    for metres in (-1.0, 1.0):
        env.task.world.state.bodies["velocity"][0] = 0.0
        move_car(env, 0, metres)
        earned += env.step(np.zeros(2, np.float32))[4]["reward_progress"]
    assert earned < 0.0


def test_gates_that_are_driven_through_turn_green() -> None:
    env = Car3DEnv(difficulty=0.5)
    observation, info = env.reset(seed=2)
    while not info["gates"]:
        observation, _, terminated, _, info = env.step(pursue(observation))
        assert not terminated
    slot = int(np.flatnonzero(env.task.task_state["kinds"][0] >= 0)[0])
    enabled = env.task.world.parameters.bodies["enabled"][0]
    position = env.task.world.state.bodies["position"][0]
    assert enabled[scene.FIRST_GREEN + slot]
    assert not enabled[scene.FIRST_RED + slot]
    np.testing.assert_allclose(position[scene.FIRST_GREEN + slot], position[scene.FIRST_RED + slot], atol=1e-12)


# ---------------------------------------------------------------- policies


def successes(policy: Any, count: int = 16) -> float:
    """Share of episodes that succeed in time."""
    vector = Car3DVectorEnv(count, autoreset_mode="Disabled", split="test")
    vector.reset(seed=0)
    task = vector.task
    alive, success = np.ones(count, bool), np.zeros(count, bool)
    for _ in range(time_limit("GCar3D-v0")):
        task.step(policy(task.observation))
        success |= alive & task.infos["success"]
        alive &= ~task.terminated
        if not alive.any():
            break
    return float(success.mean())


def test_planning_of_speed_pays() -> None:
    """A held speed is too slow for the time, or too fast for the gates; docs/tiers.md has all tiers and policies."""
    assert successes(pursue) >= 0.85
    assert successes(partial(hold_speed, speed=6.5)) <= 0.4


# ---------------------------------------------------------------- docs


@pytest.mark.parametrize(
    "text",
    [
        f"A car of {scene.CHASSIS_MASS + 4 * scene.WHEEL_MASS:g} kg",
        f"from {1 / course.OFTEN:g} on all three stand",
        f"its torque, {scene.TORQUE:g} N m",
        f"{scene.TOP_SPEED:g} rad/s ({scene.TOP_SPEED * scene.RADIUS:.0f} m/s)",
        f"that fraction of {scene.BRAKE_TORQUE:g} N m each",
        f"of up to {scene.STEERING:g} rad, which they turn to at {scene.STEERING_RATE:g} rad/s at most",
        f"a wave of {road.WEAVE[0]:g} to {road.WEAVE[1]:g} m",
        "({:g} to {:g} m and {:g} to {:g} m)".format(*np.ravel(road.RISES)),
        f"below {rules.LEAST_UP:g}",
        f"more than {scene.OFF_ROAD:g} m from the centre line",
        f"strayed: more than {scene.STRAY:g} m from the centre line or {scene.STRAY_BEHIND:g} m behind the start",
        f"at {scene.FINISH:g} m along the centre line",
        f"within {scene.GATE_HALF:g} m before and behind the gate, and",
        f"within {scene.GATE_WIDTH:g} m of the centre line",
        f"an axle is {scene.GATE_HALF:g} m beyond it without",
        f"after {time_limit('GCar3D-v0')} steps",
        f"({len(Car3DTask.observations)},)",
    ],
)
def test_docstring_agrees_with_the_constants(text: str) -> None:
    assert text in " ".join((Car3DEnv.__doc__ or "").split())
