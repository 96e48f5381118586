"""GRagdoll2D's figure, pushes and ends; how policies without skill fare."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from gsenv.envs.core.policies import trained_actions
from gsenv.envs.ragdoll2d import rules, scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.env import RagdollEnv, RagdollVectorEnv
from gsenv.envs.ragdoll2d.policy import balance, lean
from tests.envs.standing import standing_time

G = 9.81
IDLE = np.zeros((1, 7))


def plain_env(push: float = 0.0) -> RagdollEnv:
    """The figure with its nominal masses and torques."""
    env = RagdollEnv(push=push, randomize={})
    env.reset(seed=0)
    return env


def momentum(env: RagdollEnv) -> Any:
    """(x, y) N s, and m/s, of all of the figure."""
    bodies = env.task.world.state.bodies[0, scene.FIRST_PART :]
    mass = env.task.world.parameters.bodies["mass"][0, scene.FIRST_PART :]
    return (mass[:, None] * bodies["velocity"][:, :2]).sum(0)


def schedule(env: RagdollEnv, push: float, step: int) -> None:
    state = env.task.task_state
    state["pushes"] = push
    state["next_push"] = state["steps"] + step


survival = partial(standing_time, RagdollVectorEnv)


# ---------------------------------------------------------------- figure


def test_the_figure_has_the_height_and_mass_of_a_person() -> None:
    env = plain_env()
    masses = env.task.world.parameters.bodies["mass"][0, scene.FIRST_PART :]
    assert masses.sum() == pytest.approx(60.0, rel=1e-3)
    assert masses.sum() == pytest.approx(scene.MASS, rel=1e-12)
    upright = scene.ANKLE + scene.SHIN + scene.THIGH + scene.WAIST + scene.SHOULDER + scene.HEAD
    assert upright == pytest.approx(scene.HEIGHT, abs=1e-3)


def test_it_starts_on_the_ground_within_the_bounds_of_its_stand() -> None:
    vector = RagdollVectorEnv(50)
    vector.reset(seed=0)
    world = vector.task.world
    for axis in scene.JOINTS:
        assert (abs(world.joint_coordinate(axis.name) - axis.stand) <= rules.START_ANGLE + 1e-12).all()
    tips = []
    for foot in scene.FEET:
        body, center = world.state.bodies[:, foot], world.parameters.bodies["center"][:, foot]
        for x in (scene.HEEL, scene.TOE):
            arm = np.array([x, -scene.ANKLE]) - center
            tips.append(
                body["position"][:, 1] + body["rotation"][:, 1] * arm[:, 0] + body["rotation"][:, 0] * arm[:, 1]
            )
    np.testing.assert_allclose(np.min(tips, 0), 0.0, atol=1e-12)


def test_the_feet_carry_the_weight_and_the_joints_hold() -> None:
    env = plain_env()
    for _ in range(20):
        env.task.step(IDLE)
    assert env.observation[8] + env.observation[9] == pytest.approx(1.0, abs=0.15)
    assert env.task.world.diagnostics().joint_error[0] < 1e-9


def test_drives_keep_to_the_bounds_of_their_torques() -> None:
    env = plain_env()
    generator = np.random.default_rng(0)
    largest = np.zeros(7)
    for _ in range(60):
        env.task.step(generator.choice([-1.0, 1.0], (1, 7)))
        impulse = env.task.world.state.joints["total_impulse"][0, :7, rules._SPRING_SLOT]
        largest = np.maximum(largest, abs(impulse) / env.task.world.timestep / [axis.effort for axis in scene.AXES])
    assert largest.max() <= 1.0 + 1e-9
    assert largest.max() > 0.99


# ---------------------------------------------------------------- pushes


@pytest.mark.parametrize("push", [0.3, -0.6, 1.0])
def test_a_push_changes_the_velocity_by_what_it_says(push: float) -> None:
    """Far above the ground, without gravity: the whole momentum changes by mass times push, within 0.1 s."""
    env = plain_env(push=1.0)
    for body in scene.BODIES[scene.FIRST_PART :]:
        place = env.task.world.position[0, scene.BODIES.index(body)]
        env.task.world.set_pose(body, position=(place[0], place[1] + 50.0))
    env.task.world.parameters.worlds["gravity"] = 0.0
    schedule(env, push, 2)
    before = momentum(env)
    for _ in range(2):
        env.task.step(IDLE)
    np.testing.assert_allclose(momentum(env), before, atol=2e-2)
    for _ in range(shared.PUSH_STEPS):
        env.task.step(IDLE)
    np.testing.assert_allclose(momentum(env) - before, (scene.MASS * push, 0.0), atol=2e-2)
    for _ in range(5):
        env.task.step(IDLE)
    np.testing.assert_allclose(momentum(env) - before, (scene.MASS * push, 0.0), atol=2e-2)


def test_pushes_come_every_2_to_4_s_where_the_schedule_begins_again() -> None:
    """The first gap of the schedule may be as short as 1 s; of 50 figures some have such a one."""
    vector = RagdollVectorEnv(50, push=0.8)
    vector.reset(seed=0)
    state = vector.task.task_state
    assert (state["gaps"][:, 0] < 60).any()
    come: list[list[int]] = [[] for _ in range(50)]
    for w in range(50):
        task = state[w]
        for step in range(3000):
            task["steps"] = step
            before = int(task["push_count"])
            shared.begin_push(task)
            if task["push_count"] > before:
                come[w].append(step)
    assert min(map(len, come)) > 2 * shared.PUSHES
    for steps in come:
        assert np.diff(steps).min() >= 60
        assert np.diff(steps).max() <= 120


def test_pushes_come_every_2_to_4_s_within_their_bounds_to_both_sides() -> None:
    vector = RagdollVectorEnv(200, push=0.8)
    vector.reset(seed=0)
    state = vector.task.task_state
    assert (state["gaps"][:, 0] >= 30).all()
    assert (state["gaps"][:, 1:] >= 60).all()
    assert (state["gaps"] < 120).all()
    size = abs(state["pushes"])
    assert (size >= 0.1).all()
    assert 0.75 < size.max() <= 0.8
    assert 0.4 < (state["pushes"] > 0.0).mean() < 0.6
    vector.reset(seed=0, options={"push": 0.0})
    assert (state["pushes"] == 0.0).all()


def test_delay_holds_back_an_action_for_a_step() -> None:
    targets = []
    for delay in (0.0, 1.0):
        env = RagdollEnv(push=0.0, randomize={"delay": (delay, delay)})
        env.reset(seed=0)
        seen = []
        for step in range(3):
            env.task.step(np.full((1, 7), 0.5 if step == 0 else 0.0))
            seen.append(env.task.world.control[0, 0] - scene.AXES[0].stand)
        targets.append(np.array(seen) / 0.42)  # of the waist
    np.testing.assert_allclose(targets[0], [0.5, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(targets[1], [0.0, 0.5, 0.0], atol=1e-12)


# ---------------------------------------------------------------- ends


def test_a_knee_on_the_ground_is_a_fall() -> None:
    env = plain_env()
    fold = np.array([[0.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0]])
    for _ in range(200):
        env.task.step(fold)
        if env.task.terminated[0]:
            break
    assert env.task.infos["fell"][0]
    assert not env.task.infos["success"][0]
    assert env.task.terms["fall"][0] == shared.FALL_REWARD


def test_feet_that_stay_apart_end_the_episode() -> None:
    """A figure that is held in the air, legs astride: the time runs, and legs together take it back."""
    env = plain_env()
    env.task.world.parameters.worlds["gravity"] = 0.0
    for body in scene.BODIES[scene.FIRST_PART :]:
        place = env.task.world.position[0, scene.BODIES.index(body)]
        env.task.world.set_pose(body, position=(place[0], place[1] + 50.0))
    astride = np.array([[0.0, 0.7, 0.0, 0.0, -0.7, 0.0, 0.0]])
    for _ in range(45):
        env.task.step(astride)
    assert not env.task.terminated[0]
    apart = float(env.task.task_state["apart"][0])
    assert 1.0 < apart < 1.6
    for _ in range(40):
        env.task.step(IDLE)
    assert float(env.task.task_state["apart"][0]) < apart
    for _ in range(75):
        env.task.step(astride)
        if env.task.terminated[0]:
            break
    assert env.task.terminated[0]
    assert not env.task.infos["fell"][0]
    assert env.task.terms["fall"][0] == shared.FALL_REWARD  # as the table says


# ---------------------------------------------------------------- policies


def test_zero_action_nearly_stands_but_falls() -> None:
    stood = survival(lambda observations: np.zeros((len(observations), 7)), 0.6)
    assert stood.min() > 1.0
    assert stood.max() < 15.0


@pytest.mark.parametrize("push", [0.3, 0.6])
def test_random_and_constant_actions_fall(push: float) -> None:
    """400 constant actions, half of them legs astride, which would hold pushes if the feet might stay apart."""
    generator = np.random.default_rng(0)
    constant = generator.uniform(-1.0, 1.0, (400, 7))
    constant[:100] *= 0.3
    constant[200:, 1] = generator.uniform(-0.6, 0.6, 200)
    constant[200:, 4] = -constant[200:, 1]
    constant[200:, [0, 2, 5]] *= 0.3
    assert survival(lambda _: constant, push, 400).max() < 20.0
    assert survival(lambda _: generator.uniform(-1.0, 1.0, (50, 7)), push).max() < 10.0


def test_ankles_alone_do_not_hold_the_pushes() -> None:
    assert (survival(lean, 0.6) == 20.0).mean() < 0.3


def test_stepping_to_the_capture_point_holds_most_pushes() -> None:
    assert (survival(balance, 0.3) == 20.0).mean() > 0.9
    assert (survival(balance, 0.6) == 20.0).mean() > 0.75


def test_trained_policy_holds_the_pushes_that_it_was_trained_for() -> None:
    assert (survival(trained_actions("GRagdoll2D-v0"), 0.6, 100) == 20.0).mean() >= 0.85
