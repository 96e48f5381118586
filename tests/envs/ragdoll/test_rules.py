"""GRagdoll's figure against MuJoCo, its symmetries, pushes and ends; how policies without skill fare."""

from __future__ import annotations

from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from gsenv.envs.core.policies import trained_actions
from gsenv.envs.ragdoll import figure, mirror, rules, scene
from gsenv.envs.ragdoll.env import RagdollEnv, RagdollVectorEnv
from gsenv.envs.ragdoll.policy import balance, lean
from gsenv.envs.ragdoll2d import scene as planar
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.mjcf import set_coordinates
from tests.envs.standing import standing_time

IDLE = np.zeros((1, 21))
AXIS = {axis.name: k for k, axis in enumerate(figure.AXES)}
survival = partial(standing_time, RagdollVectorEnv)


def plain_env(push: float = 0.0) -> RagdollEnv:
    """The figure with its nominal masses and torques."""
    env = RagdollEnv(push=push, randomize={})
    env.reset(seed=0)
    return env


def even_worlds(count: int, fidelity: str = "balanced") -> Any:
    """Worlds whose figures stand evenly: every draw is in the middle of its range."""
    task = RagdollVectorEnv(count, push=0.0, randomize={}, fidelity=fidelity, autoreset_mode="Disabled").task
    task.reset(np.arange(count), np.full((count, task.reset_draws), 0.5), {"push": 0.0})
    return task


def lift_off(env: RagdollEnv) -> None:
    """Take the figure 50 m up, without gravity."""
    task: Any = env.task
    task.world.state.bodies["position"][:, 1 : task.figure.parts["last"] + 1, 2] += 50.0
    task.world.parameters.worlds["gravity"] = 0.0


def momentum(env: RagdollEnv) -> Any:
    """(x, y, z) N s of all of the figure."""
    mass = env.task.world.parameters.bodies["mass"][0]
    return (mass[:, None] * env.task.world.state.bodies["velocity"][0, :, :3]).sum(0)


# ---------------------------------------------------------------- figure


def test_the_figure_has_the_lengths_and_mass_of_the_planar_one() -> None:
    assert len(figure.AXES) == scene.AXIS_COUNT
    assert -sum(axis.stand for axis in figure.AXES[-4:-1]) == pytest.approx(scene.STAND_TILT, abs=1e-12)
    bodies = {body.name: body for body in figure.figure().bodies}
    assert pytest.approx(60.0, rel=1e-3) == figure.MASS
    assert figure.MASS == pytest.approx(planar.MASS, rel=1e-12)
    assert bodies["pelvis"].pose.position[2] == pytest.approx(planar.ANKLE + planar.SHIN + planar.THIGH, abs=1e-12)
    for side in ("left", "right"):
        assert bodies[f"{side}_shin"].pose.position[2] == pytest.approx(-planar.THIGH)
        assert bodies[f"{side}_foot"].pose.position[2] == pytest.approx(-planar.SHIN)
        sole = next(geom for geom in figure.figure().geoms if geom.name == f"{side}_sole")
        assert sole.pose.position[2] - sole.size[2] == pytest.approx(-planar.ANKLE)
        ends = sole.pose.position[0] + sole.size[0] * np.array([-1.0, 1.0])
        np.testing.assert_allclose(ends, (planar.HEEL, planar.TOE), atol=1e-12)
        assert sole.size[1] == scene.HALF_SOLE
    assert bodies["torso"].pose.position[2] == pytest.approx(planar.WAIST)


def test_joints_are_those_that_mujoco_reads_in_the_file() -> None:
    """Random poses and rates, set in both: places of all bodies, and the angles and rates of the rules."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(files("gsenv.assets").joinpath("ragdoll.xml").read_text("utf-8"))
    data = mujoco.MjData(model)
    task: Any = plain_env().task
    generator = np.random.default_rng(0)
    axes = [model.joint(axis.name) for axis in figure.AXES]
    for _ in range(10):
        data.qpos[:] = 0.0
        data.qpos[2:4] = 2.0, 1.0
        for axis, joint in zip(figure.AXES, axes, strict=True):
            low, high = axis.limits
            data.qpos[joint.qposadr] = generator.uniform(low, high)
        data.qvel[:] = generator.uniform(-1.0, 1.0, model.nv)
        mujoco.mj_kinematics(model, data)
        set_coordinates(task.world, figure.figure(), task._names, data.qpos, data.qvel)
        for name in ("torso", "left_forearm", "right_forearm", "left_foot", "right_foot"):
            body = task.world.model.body_names.index(name)
            np.testing.assert_allclose(task.world.position[0, body], data.body(name).xpos, atol=1e-9)
        task.kernel_world.select(0)
        rules._read_joints(task.kernel_world, task.figure)
        stand = [axis.stand for axis in figure.AXES]
        wanted = np.array([data.qpos[joint.qposadr[0]] for joint in axes]) - stand
        np.testing.assert_allclose(task.task_state["angles"][0], wanted, atol=1e-9)
        rates = np.array([data.qvel[joint.dofadr[0]] for joint in axes])
        np.testing.assert_allclose(task.task_state["rates"][0], rates, atol=1e-9)


def test_it_starts_on_the_ground_within_the_bounds_of_its_stand() -> None:
    vector = RagdollVectorEnv(30)
    vector.reset(seed=0)
    assert (abs(vector.task.task_state["angles"]) <= rules.START_ANGLE + 1e-12).all()
    task: Any = vector.task
    for world in range(30):
        task.kernel_world.select(world)
        assert rules._lowest_sole(task.kernel_world, task.figure) == pytest.approx(0.0, abs=1e-12)


def test_the_feet_carry_the_weight_and_the_joints_hold() -> None:
    task = even_worlds(1)
    for _ in range(20):
        task.step(IDLE)
    assert task.observation[0, 14] + task.observation[0, 15] == pytest.approx(1.0, abs=0.15)
    assert task.world.diagnostics().joint_error[0] < 1e-9


def test_random_drives_keep_to_their_bounds() -> None:
    vector = RagdollVectorEnv(16, push=0.0, randomize={})
    vector.reset(seed=0)
    task: Any = vector.task
    generator = np.random.default_rng(0)
    largest = np.zeros(21)
    bounds = [axis.effort for axis in figure.AXES]
    for _ in range(100):
        vector.step(generator.choice([-1.0, 1.0], (16, 21)))
        impulse = task.world.state.joints["total_impulse"][:, task.figure.joints, rules._SPRING_SLOT]
        largest = np.maximum(largest, abs(impulse / task.world.timestep / bounds).max(0))
    assert largest.max() <= 1.0 + 1e-9
    assert np.median(largest) > 0.99


def test_overlaps_are_small_while_it_balances() -> None:
    """Not under full random drives, which whip the feet: there, soles sink by up to 25 mm for a step."""
    vector = RagdollVectorEnv(16, push=0.6)
    observations, _ = vector.reset(seed=0)
    generator = np.random.default_rng(0)
    overlaps = []
    for _ in range(100):
        noise = generator.uniform(-0.2, 0.2, (16, 21)).astype(np.float32)
        observations = vector.step(balance(observations) + noise)[0]
        overlaps.append(vector.task.world.diagnostics().penetration)
    assert np.quantile(overlaps, 0.98) < 1e-3


# ---------------------------------------------------------------- symmetries


def test_the_mirror_image_of_the_actions_gives_the_mirror_image_of_the_motion() -> None:
    task = even_worlds(2, "accurate")
    generator = np.random.default_rng(0)
    (index, sign), (action_index, action_sign) = mirror.OBSERVATION, mirror.ACTION
    skeleton = [k for k, entry in enumerate(task.observations) if not entry.name.endswith(("load", "rate"))]
    worst = []
    for _ in range(15):
        action = generator.uniform(-0.5, 0.5, 21)
        task.step(np.stack([action, action[action_index] * action_sign]))
        image = task.observation[1][index] * sign
        worst.append(abs(image - task.observation[0])[skeleton].max())
    assert max(worst) < 2e-3
    assert abs(task.observation[1] - task.observation[0]).max() > 0.5


def test_mirror_images_twice_are_the_original() -> None:
    for index, sign in (mirror.OBSERVATION, mirror.ACTION):
        np.testing.assert_array_equal(index[index], np.arange(len(index)))
        np.testing.assert_array_equal(sign[index], sign)


def test_observations_do_not_depend_on_where_the_figure_looks() -> None:
    env = RagdollEnv()
    env.reset(seed=5)
    for _ in range(10):
        env.task.step(IDLE)
    bodies, task = env.task.world.state.bodies[0], env.task
    before, reward = task.observation.copy(), task.reward.copy()
    turn = 0.7
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    half = np.array([np.cos(0.5 * turn), np.sin(0.5 * turn)])
    for body in bodies[1:13]:
        body["position"][:2] = rotation @ body["position"][:2] + 3.0
        for first in (0, 3):
            body["velocity"][first : first + 2] = rotation @ body["velocity"][first : first + 2]
        w, x, y, z = body["rotation"]
        body["rotation"] = (half[0] * w - half[1] * z, half[0] * x - half[1] * y,
                            half[0] * y + half[1] * x, half[0] * z + half[1] * w)  # fmt: skip
    task.evaluate()
    np.testing.assert_allclose(task.observation, before, atol=2e-6)
    np.testing.assert_allclose(task.reward, reward, atol=1e-9)


# ---------------------------------------------------------------- pushes


@pytest.mark.parametrize(("push", "heading"), [(0.3, 0.0), (-0.6, 0.5), (1.0, 2.0)])
def test_a_push_changes_the_velocity_by_what_it_says(push: float, heading: float) -> None:
    env = plain_env(push=1.0)
    lift_off(env)
    state = env.task.task_state
    state["pushes"], state["headings"], state["next_push"] = push, heading, state["steps"] + 2
    before = momentum(env)
    for _ in range(2):
        env.task.step(IDLE)
    np.testing.assert_allclose(momentum(env), before, atol=2e-2)
    wanted = figure.MASS * push * np.array([np.cos(heading), np.sin(heading), 0.0])
    for steps in (shared.PUSH_STEPS, 5):
        for _ in range(steps):
            env.task.step(IDLE)
        np.testing.assert_allclose(momentum(env) - before, wanted, atol=5e-2)


def test_pushes_come_from_all_sides_within_their_bounds() -> None:
    vector = RagdollVectorEnv(200, push=0.8)
    vector.reset(seed=0)
    state = vector.task.task_state
    size = abs(state["pushes"])
    assert (size >= 0.1).all()
    assert 0.75 < size.max() <= 0.8
    heading = (state["headings"] + np.pi * (state["pushes"] < 0.0)).ravel()
    counts, _ = np.histogram(heading % (2.0 * np.pi), 8)
    assert counts.min() > 0.7 * counts.mean()
    vector.reset(seed=0, options={"push": 0.0})
    assert (state["pushes"] == 0.0).all()


# ---------------------------------------------------------------- ends and policies


def test_a_knee_on_the_ground_is_a_fall() -> None:
    env = plain_env()
    fold = IDLE.copy()
    for side in ("left", "right"):
        fold[0, AXIS[f"{side}_knee"]], fold[0, AXIS[f"{side}_hip"]], fold[0, AXIS[f"{side}_ankle"]] = -1.0, 1.0, 1.0
    for _ in range(200):
        env.task.step(fold)
        if env.task.terminated[0]:
            break
    assert env.task.infos["fell"][0]
    assert not env.task.infos["success"][0]
    assert env.task.terms["fall"][0] == shared.FALL_REWARD


def test_zero_action_nearly_stands_but_falls() -> None:
    stood = survival(lambda observations: np.zeros((len(observations), 21)), 0.6)
    assert stood.min() > 1.0
    assert stood.max() < 15.0


@pytest.mark.parametrize("push", [0.3, 0.6])
def test_random_and_constant_actions_fall(push: float) -> None:
    """200 constant actions, most of them with the feet apart in every direction."""
    generator = np.random.default_rng(0)
    constant = generator.uniform(-1.0, 1.0, (200, 21)) * np.repeat([0.2, 1.0], 100)[:, None]
    stride = generator.uniform(-0.7, 0.7, 150)
    constant[50:, AXIS["left_hip"]], constant[50:, AXIS["right_hip"]] = stride, -stride
    for side in ("left", "right"):
        constant[50:, AXIS[f"{side}_hip_spread"]] = generator.uniform(0.0, 1.0, 150)
        constant[50:, AXIS[f"{side}_knee"]] = generator.uniform(-0.2, 0.6, 150)
    assert survival(lambda _: constant, push, 200).max() < 20.0
    assert survival(lambda _: generator.uniform(-1.0, 1.0, (30, 21)), push, 30).max() < 10.0


def test_ankles_alone_do_not_hold_the_pushes() -> None:
    assert (survival(lean, 0.6) == 20.0).mean() < 0.3


def test_trained_policy_holds_light_pushes_always_and_harder_ones_mostly() -> None:
    trained = trained_actions("GRagdoll-v0")
    assert (survival(trained, 0.3) == 20.0).mean() >= 0.95
    assert (survival(trained, 0.6) == 20.0).mean() >= 0.92
