"""Arguments that all environments share: randomize, fidelity, diagnostics, settings."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from gsenv.envs.car.env import CarEnv, CarVectorEnv
from gsenv.envs.core.arguments import DIAGNOSTICS
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.policies import make_batch
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll2d.env import RagdollEnv
from gsenv.envs.stack.env import StackEnv, StackVectorEnv
from gsenv.envs.tower_v0 import parallel_env
from tests.envs.stack.worlds import assert_equal

SINGLE = pytest.mark.parametrize("single", [StackEnv, CarEnv])
BATCH = pytest.mark.parametrize("batch", [StackVectorEnv, CarVectorEnv])


def ranges(task: Any) -> dict[str, tuple[float, float]]:
    """A range around each nominal value, a fifth of it to either side."""
    return {q.name: (0.8 * q.nominal, 1.2 * q.nominal) for q in task.quantities}


def parameters(env: Any) -> dict[str, Any]:
    return {name: array.copy() for name, array in env.task.world.parameters.arrays().items()}


@BATCH
def test_quantities_are_drawn_per_world_and_episode_from_scratch(batch: type[TaskVectorEnv]) -> None:
    given = ranges(batch.task_class)
    env = batch(20, randomize=given)
    drawn: list[Any] = []
    for _ in range(30):
        env.reset(seed=0 if not drawn else None)
        drawn.append(np.array(list(env.physics.values())))
    values = np.array(drawn)  # (episode, quantity, world)
    for k, (low, high) in enumerate(given.values()):
        part = (values[:, k] - low) / (high - low)
        assert part.min() >= 0.0
        assert part.max() <= 1.0
        assert part.mean() == pytest.approx(0.5, abs=0.05)
        assert abs(np.diff(values[:, k], axis=0)).min() > 0.0
        assert len(np.unique(values[0, k])) == 20
    assert list(env.physics) == list(given)


@SINGLE
def test_episodes_do_not_depend_on_those_before(single: type[TaskEnv]) -> None:
    """Whatever was randomised before: nothing accumulates."""
    env, other = (single(randomize=ranges(single.task_class)) for _ in range(2))
    for seed in range(5):
        env.reset(seed=seed)
    env.reset(seed=7)
    other.reset(seed=7)
    assert_equal(parameters(env), parameters(other))
    assert env.physics == other.physics


@SINGLE
def test_without_randomising_all_is_nominal_and_the_course_is_the_same(single: type[TaskEnv]) -> None:
    plain = single()
    env = single(randomize={"gravity": (5.0, 6.0)})
    for seed in (3, None):
        start = plain.reset(seed=seed)[0]
        assert plain.physics == {q.name: q.nominal for q in single.task_class.quantities}
        np.testing.assert_array_equal(env.reset(seed=seed)[0], start)
        assert 5.0 <= env.physics["gravity"] <= 6.0
        assert env.task.world.parameters.gravity[0, 1] == -env.physics["gravity"]
        other = parameters(env) | {"worlds": parameters(plain)["worlds"]}  # which have the gravity
        assert_equal(parameters(plain), other)


@pytest.mark.parametrize("name", [q.name for q in CarEnv.task_class.quantities])
def test_each_quantity_of_the_car_reaches_the_physics(name: str) -> None:
    nominal = next(q.nominal for q in CarEnv.task_class.quantities if q.name == name)
    assert_matters(CarEnv, name, nominal, np.array([[0.6, 0.8]] * 30 + [[-0.5, -0.5]] * 30))


@pytest.mark.parametrize("name", [q.name for q in StackEnv.task_class.quantities])
def test_each_quantity_of_the_tower_reaches_the_physics(name: str) -> None:
    nominal = next(q.nominal for q in StackEnv.task_class.quantities if q.name == name)
    # full speed sideways, so that the drive is at its bounds; then let go and fall on the ground
    actions = np.array([[1.0, 0.0, 0.5, -1.0]] * 15 + [[-1.0, 0.2, 0.0, 1.0]] * 45)
    assert_matters(StackEnv, name, nominal, actions)


def assert_matters(single: type[TaskEnv], name: str, nominal: float, actions: Any) -> None:
    ends = []
    for factor in (1.0, 1.4):
        env = single(randomize={name: (factor * nominal, factor * nominal)})
        env.reset(seed=0)
        for action in actions:
            env.task.step((action,))
        ends.append(env.task.world.position[0].copy())
    assert abs(ends[0] - ends[1]).max() > 1e-4


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"frictoin": (0.4, 0.9)}, "unknown quantity 'frictoin'; known are friction, mass"),
        ({"friction": 0.5}, "friction must be a pair"),
        ({"friction": (0.1, 0.2, 0.3)}, "friction must be a pair"),
        ({"friction": ("a", "b")}, "friction must be a pair"),
        ({"friction": (0.9, 0.4)}, "the lower first"),
        ({"friction": (0.4, np.inf)}, "finite"),
        ({"friction": (np.nan, 0.9)}, "finite"),
        ({"friction": (0.0, 0.9)}, "must lie within"),
        ({"mass": (-1.0, 0.9)}, "must lie within"),
        (["friction"], "must map names"),
        ("friction", "must map names"),
    ],
)
@pytest.mark.parametrize("make", [StackEnv, CarEnv, CarVectorEnv])
def test_bad_randomisation_is_refused_in_one_sentence(make: Any, given: Any, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint) as error:
        make(randomize=given)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith("randomize")


@SINGLE
def test_fidelity_chooses_the_options(single: type[TaskEnv]) -> None:
    substeps = [single(fidelity=name).task.world.options.substeps for name in ("fast", "balanced", "accurate")]
    assert substeps[0] <= substeps[1] < substeps[2]
    for bad in ("best", None, 3, ["fast"]):
        with pytest.raises(ValueError, match="fidelity must be one of"):
            single(fidelity=bad)  # type: ignore[arg-type]


@SINGLE
def test_diagnostics_come_on_request(single: type[TaskEnv]) -> None:
    assert not [key for key in single().reset(seed=0)[1] if key.startswith("diagnostic_")]
    env = single(diagnostics=True)
    _, info = env.reset(seed=0)
    names = [f"diagnostic_{name}" for name, _ in DIAGNOSTICS]
    assert list(info)[-len(names) :] == names
    for _ in range(5):
        info = env.step(env.action_space.sample().astype(np.float32))[4]
    assert list(info)[-len(names) :] == names
    assert info["diagnostic_sweeps"] > 0
    assert info["diagnostic_energy"] != 0.0
    assert {type(info[name]) for name in names} == {int, float}


@BATCH
def test_diagnostics_of_a_batch(batch: type[TaskVectorEnv]) -> None:
    env = batch(3, diagnostics=True)
    env.reset(seed=0)
    infos = env.step(env.action_space.sample())[4]
    for name, _ in DIAGNOSTICS:
        assert infos[f"diagnostic_{name}"].shape == (3,)
        assert infos[f"_diagnostic_{name}"].all()


@pytest.mark.parametrize("make", [StackEnv, CarEnv, StackVectorEnv, CarVectorEnv])
def test_unknown_arguments_are_refused_by_name(make: Any) -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'wheels'; its own are"):
        make(wheels=4)


@pytest.mark.parametrize(("make", "name", "meant"), [
    (StackVectorEnv, "thread", "'threads', which vector environments have"), (StackEnv, "bloks", "'blocks'"),
    (RagdollEnv, "taks", "'task', which GRagdoll-v0"), (parallel_env, "max_cyles", "'max_cycles', which parallel"),
    (StackEnv, "splt", "'split'"),
])  # fmt: skip
def test_a_mistyped_argument_is_guessed(make: Any, name: str, meant: str) -> None:
    with pytest.raises(TypeError, match=f"did you mean {meant}"):
        make(**{name: 2})


def test_the_time_limit_of_agents_has_the_name_of_its_page_in_a_batch_too() -> None:
    assert make_batch("tower_v0", 1, max_cycles=70).max_episode_steps == 70


def test_docstrings_list_the_quantities() -> None:
    for single in (StackEnv, CarEnv):
        for quantity in single.task_class.quantities:
            assert f"| {quantity.name} " in (single.__doc__ or "")


def test_arguments_pass_through_make() -> None:
    env: Any = gymnasium.make("GCar-v0", randomize={"friction": (0.4, 0.9)}, fidelity="fast", diagnostics=True)
    env.reset(seed=0)
    assert 0.4 <= env.unwrapped.physics["friction"] <= 0.9
    vector: Any = gymnasium.make_vec("GCar-v0", num_envs=2, randomize={"friction": (0.4, 0.9)})
    vector.reset(seed=0)
    assert vector.physics["friction"].shape == (2,)


# ---------------------------------------------------------------- arguments of methods

BEYOND_FLOATS = 10**400  # float() raises OverflowError
MAKERS = pytest.mark.parametrize("make", [StackEnv, StackVectorEnv, parallel_env])


def after(env: Any) -> Any:
    """The state after a reset and a step of zeros, by which two environments are compared."""
    env.reset(seed=3)
    return env.task.save().arrays["observation"].tolist()


@MAKERS
@pytest.mark.parametrize("options", [3, [], "blocks", [("blocks", 2)], {1: 2}])
def test_options_that_are_no_dict_are_refused_in_one_sentence(make: Any, options: Any) -> None:
    env = make()
    before = after(env)
    with pytest.raises(ValueError, match="reset: options must be a dict"):
        env.reset(seed=4, options=options)
    assert env.task.save().arrays["observation"].tolist() == before


@pytest.mark.parametrize(
    "seed", [1.5, [1.9, 2], [True] * 2, True, "12", b"12", [1, "2"], [[1], [2]], {0: 1, 1: 2}, np.array([1.0, 2.0])]
)
def test_seeds_of_a_batch_are_whole_numbers(seed: Any) -> None:
    env = StackVectorEnv(2)
    before = after(env)
    with pytest.raises(ValueError, match=r"reset: (a )?seed must be a whole number"):
        env.reset(seed=seed)
    assert env.task.save().arrays["observation"].tolist() == before
    good: Any
    for good in ([3, 4], (3, 4), np.array([3, 4]), range(3, 5), np.int64(3), [None, 4]):
        env.reset(seed=good)


@MAKERS
def test_numbers_beyond_all_floats_are_no_actions(make: Any) -> None:
    env = make()
    env.reset(seed=0)
    action: Any = [BEYOND_FLOATS] * 4
    if make is not StackEnv:
        action = dict.fromkeys(env.agents, action) if make is parallel_env else [action]
    with pytest.raises(ValueError, match="step: actions must be numbers, got") as error:
        env.step(action)
    assert len(str(error.value)) < 300


@MAKERS
def test_numbers_beyond_all_floats_are_no_settings(make: Any) -> None:
    with pytest.raises(ValueError, match="crack_speed"):
        make(crack_speed=BEYOND_FLOATS)
    with pytest.raises(ValueError, match="must be a pair"):
        make(randomize={"friction": (0.5, 10**5000)})


def test_what_a_batch_was_made_from_cannot_be_set() -> None:
    env = StackVectorEnv(2)
    for name, value in (("render_mode", "human"), ("render_mode", "x"), ("num_envs", 3), ("autoreset_mode", "x")):
        before = env.get_attr(name)
        with pytest.raises(ValueError, match=f"set_attr: '{name}' is set when the environment is made"):
            env.set_attr(name, value)
        assert env.get_attr(name) == before
    env.set_attr("render_mode", None)
