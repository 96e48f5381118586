"""Getting up, in 2D and in 3D: starts, actions, assistance, success, time limit, idle policies."""

from __future__ import annotations

from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest

from gsenv.envs.core.policies import trained_actions
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll import env as spatial
from gsenv.envs.ragdoll import figure
from gsenv.envs.ragdoll2d import env as planar
from gsenv.envs.ragdoll2d import rules, scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.lying import lying_poses
from gsenv.solver.records.model import BodyKind


class Figure(NamedTuple):
    """One of the two figures."""

    env_id: str
    module: Any
    joints: tuple[str, ...]  # with drives
    stand: Any  # rad
    span: Any
    limits: Any  # rad, (joint, 2)


FIGURES = [
    Figure(
        "GRagdoll2D-get-up-v0",
        planar,
        tuple(axis.name for axis in scene.AXES),
        np.array([axis.stand for axis in scene.AXES]),
        np.array(rules._SPAN),
        np.array([axis.limits for axis in scene.AXES]),
    ),
    Figure(
        "GRagdoll-get-up-v0",
        spatial,
        tuple(axis.name for axis in figure.AXES),
        np.array([axis.stand for axis in figure.AXES]),
        np.array([axis.span for axis in figure.AXES]),
        np.array([axis.limits for axis in figure.AXES]),
    ),
]
each_figure = pytest.mark.parametrize("figure", FIGURES, ids=["2D", "3D"])


def lying(figure: Figure, count: int = 40) -> TaskVectorEnv:
    vector: TaskVectorEnv = figure.module.RagdollGetUpVectorEnv(count)
    vector.reset(seed=3)
    return vector


def deviations(vector: TaskVectorEnv, figure: Figure) -> Any:
    """(world, drive) rad, of the joints from the stand, as observed."""
    first = [entry.name for entry in vector.task.observations].index(f"{figure.joints[0]}_angle")
    return vector.task.observation[:, first : first + len(figure.joints)]


@each_figure
def test_it_lies_on_the_ground_at_rest_in_many_ways(figure: Figure) -> None:
    vector = lying(figure)
    world, names = vector.task.world, [entry.name for entry in vector.task.observations]
    assert (world.state.bodies["velocity"] == 0.0).all()
    assert world.diagnostics().penetration.max() < 5e-5  # legs that touch, as far as the falls solved it
    assert (vector.task.observation[:, names.index("height")] / 5.0 + 1.0 < 0.35).all()
    low, high = figure.limits.T - figure.stand
    assert (low - 0.02 < deviations(vector, figure)).all()
    assert (deviations(vector, figure) < high + 0.02).all()
    assert (np.ptp(deviations(vector, figure), axis=0) > 0.25 * (high - low)).all()
    if figure.module is planar:
        sine = vector.task.observation[:, names.index("pelvis_sine")]
        assert 0.2 < (sine > 0.0).mean() < 0.8
    else:
        down = vector.task.observation[:, names.index("down_x") : names.index("down_z") + 1]
        for side in range(2):  # face up and face down, on the left and on the right
            assert (down[:, side] > 0.7).any()
            assert (down[:, side] < -0.7).any()


@each_figure
def test_it_lies_on_more_than_its_lowest_point_and_stays_where_it_lies(figure: Figure) -> None:
    """Drives that ask for the angles it lies with hardly move it: it does not fall from where it begins."""
    vector = lying(figure)
    world = vector.task.world
    up = world.model.dim - 1
    body = world.model.body_names.index("torso")
    control = np.broadcast_to(figure.stand + deviations(vector, figure), (40, len(figure.joints)))
    world.control[:, : len(figure.joints)] = control
    before = world.state.bodies["position"][:, body].copy()
    world.step(30)
    sunk = before[:, up] - world.state.bodies["position"][:, body, up]
    assert np.quantile(sunk, 0.9) < 0.03
    assert sunk.max() < 0.12
    assert (world.diagnostics().contacts >= 2).all()


@each_figure
def test_each_pose_is_one_of_those_that_falls_left(figure: Figure) -> None:
    poses = lying_poses(figure.env_id)
    assert len(poses) > 500
    assert np.isfinite(poses).all()
    assert len(np.unique(poses.round(6), axis=0)) == len(poses)
    vector = lying(figure)
    angles = poses[:, 1 if figure.module is planar else 4 :][:, : len(figure.joints)]
    nearest = np.abs(deviations(vector, figure)[:, None] - angles).max(-1).min(1)
    assert nearest.max() < 1e-6


@each_figure
def test_full_actions_ask_for_the_limits_of_the_joints_and_zero_for_the_stand(figure: Figure) -> None:
    vector = lying(figure, 2)
    vector.task.physics[:, -1] = 0.0  # no delay
    low, high = figure.limits.T
    for action, asked in ((0.0, figure.stand), (1.0, high), (-1.0, low), (0.5, 0.5 * (figure.stand + high))):
        vector.task.apply_action(np.full_like(vector.task._actions, action))
        control = vector.task.world.control[:, : len(figure.joints)]
        np.testing.assert_allclose(control, np.broadcast_to(asked, control.shape), atol=1e-12)


@each_figure
def test_assistance_carries_its_share_of_the_weight(figure: Figure) -> None:
    """High above the ground, the centre of mass falls with the rest of gravity, whatever the joints do."""
    vector: TaskVectorEnv = figure.module.RagdollGetUpVectorEnv(3, assist=0.4)
    vector.reset(seed=0)
    task, up = vector.task, vector.task.world.model.dim - 1
    dynamic = task.world.model.bodies["kind"] == BodyKind.DYNAMIC
    task.world.state.bodies["position"][:, dynamic, up] += 50.0
    mass = np.where(dynamic, task.world.parameters.bodies["mass"], 0.0)
    for action in (0.0, 1.0, -1.0):
        before = (mass * task.world.state.bodies["velocity"][..., up]).sum(1) / mass.sum(1)
        task.step(np.full_like(task._actions, action))
        after = (mass * task.world.state.bodies["velocity"][..., up]).sum(1) / mass.sum(1)
        np.testing.assert_allclose(after - before, -0.6 * 9.81 / 30.0, rtol=1e-6)
    for bad in (-0.1, 0.95, None, True):
        with pytest.raises(ValueError, match="assist must be a share of the weight"):
            figure.module.RagdollGetUpVectorEnv(1, assist=bad)


@each_figure
def test_assistance_acts_at_the_middle_of_the_chest(figure: Figure) -> None:
    vector: TaskVectorEnv = figure.module.RagdollGetUpVectorEnv(3, assist=0.4)
    vector.reset(seed=0)
    world = vector.task.world
    vector.task.apply_action(np.zeros_like(vector.task._actions))
    wanted = np.zeros_like(world.state.bodies["force"])
    weight = 9.81 * vector.task.task_state["mass"]
    wanted[:, world.model.body_names.index("torso"), world.model.dim - 1] = 0.4 * weight * vector.task.engine_steps
    np.testing.assert_allclose(world.state.bodies["force"], wanted)


def test_sines_and_cosines_of_the_trunk_tell_its_tilt() -> None:
    vector = lying(FIGURES[0])
    names = [entry.name for entry in vector.task.observations]
    for part, body in (("pelvis", scene.PELVIS), ("chest", scene.TORSO)):
        seen = [vector.task.observation[:, names.index(f"{part}_{f}")] for f in ("sine", "cosine")]
        angle = vector.task.world.state.bodies["angle"][:, body]
        np.testing.assert_allclose(np.exp(1j * np.arctan2(*seen)), np.exp(1j * angle), atol=1e-6)


@each_figure
def test_nothing_pushes_and_nothing_ends_before_the_limit(figure: Figure) -> None:
    vector: Any = gymnasium.make_vec(f"gsenv:{figure.env_id}", num_envs=8)
    vector.reset(seed=0)
    for step in range(300):
        _, _, terminated, truncated, info = vector.step(np.zeros(vector.action_space.shape, np.float32))
        assert not terminated.any()
        assert (truncated == (step == 299)).all()
    assert (info["pushes"] == 0).all()
    assert not info["success"].any()
    assert (info["reward_fall"] == 0.0).all()
    assert gymnasium.spec(figure.env_id).max_episode_steps == 300


@each_figure
def test_standing_for_one_second_is_success(figure: Figure) -> None:
    """A figure on its feet whose drives hold the stand; then it lets go and sinks."""
    vector: TaskVectorEnv = figure.module.RagdollVectorEnv(5, push=0.0, randomize={})
    vector.reset(seed=0)
    task = vector.task
    task.task_state["getting_up"] = 1
    for step in range(1, 33):
        task.step(np.zeros_like(task._actions))
        assert (task.infos["success"] == (step >= shared.STOOD_STEPS)).all()
    for _ in range(60):
        task.step(np.ones_like(task._actions))
    assert not task.infos["success"].any()
    assert not task.terminated.any()
    last = [k for k, entry in enumerate(task.observations) if entry.name.startswith("last_")]
    np.testing.assert_array_equal(task.observation[:, last], 1.0)  # in its place: the length decides on the layout


@each_figure
def test_the_argument_task_gives_the_same_episodes(figure: Figure) -> None:
    one = figure.module.RagdollEnv(task="get_up")
    other: Any = gymnasium.make(f"gsenv:{figure.env_id}").unwrapped
    for env in (one, other):
        env.reset(seed=5)
    action = np.full(other.action_space.shape, 0.2, np.float32)
    for _ in range(20):
        first, second = one.step(action), other.step(action)
        np.testing.assert_array_equal(first[0], second[0])
        assert first[1:4] == second[1:4]
        assert first[4] == second[4]
    vector = figure.module.RagdollVectorEnv(2, task="get_up")
    assert vector.max_episode_steps == 300
    other.reset(seed=5)
    np.testing.assert_array_equal(vector.reset(seed=5)[0][0], other.observation)
    made: Any = gymnasium.make_vec(f"gsenv:{figure.env_id.replace('-get-up', '')}", num_envs=2, task="get_up")
    np.testing.assert_array_equal(made.reset(seed=5)[0], vector.reset(seed=5)[0])
    assert vector.assist == 0.0
    vector.set_attr("assist", 0.3)
    assert vector.task.settings["assist"] == 0.3
    for balancing in (figure.module.RagdollEnv(), figure.module.RagdollVectorEnv(2)):
        assert not hasattr(balancing, "assist")
        with pytest.raises(AttributeError, match="has no 'assist' with this task"):
            balancing.assist = 0.3
    for bad in ("getup", None, 1):
        for env_class in (figure.module.RagdollEnv, figure.module.RagdollVectorEnv):
            with pytest.raises(ValueError, match=r"task must be one of \['balance', 'get_up'\], got"):
                env_class(task=bad)


@each_figure
def test_zero_constant_and_random_actions_do_not_get_up(figure: Figure) -> None:
    count = 60
    vector = lying(figure, count)
    generator = np.random.default_rng(0)
    constant: Any = generator.uniform(-1.0, 1.0, vector.task._actions.shape)
    constant[0] = 0.0
    for policy in (lambda: constant, lambda: generator.uniform(-1.0, 1.0, constant.shape)):
        vector.reset(seed=4)
        for _ in range(299):
            vector.task.step(policy())
            assert not vector.task.infos["success"].any()


def test_the_figure_stays_in_the_picture_while_it_gets_up() -> None:
    """The middles of all parts, feet among them, with a margin for how far the parts reach."""
    vector, policy = lying(FIGURES[1]), trained_actions("GRagdoll-get-up-v0")
    parts = vector.task.world.model.bodies["kind"] == BodyKind.DYNAMIC
    seen, margin = vector.task.observation, 24
    for _ in range(75):
        seen = vector.step(policy(seen))[0]
        for world, middles in enumerate(vector.task.world.position[:, parts]):
            pixels = vector.task.camera(world, 640, 480).to_pixel(middles)
            assert (pixels > margin).all()
            assert (pixels < (640 - margin, 480 - margin)).all()


@each_figure
def test_pictures_say_how_long_it_has_stood_and_that_it_fell(figure: Figure) -> None:
    task = lying(figure, 1).task
    assert list(task.captions(0)) == ["0.0 s"]
    task.task_state["stood"] = 15
    assert list(task.captions(0)) == ["0.0 s", "stands 0.5 s"]
    vector = figure.module.RagdollVectorEnv(1, push=0.0)
    vector.reset(seed=0)
    action = np.ones_like(vector.task._actions)
    for _ in range(200):
        vector.task.step(action)
        if vector.task.terminated[0]:
            break
    assert vector.task.captions(0)[-1] == "fell"
