"""Files that a user was handed run no code, and broken ones are refused in one sentence."""

from __future__ import annotations

import json
import os
import pickle
import re
import shlex
import zipfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from gsenv import cli
from gsenv.envs.core.mlp import MlpPolicy
from gsenv.train.evaluate import PolicyError, make_actor
from tests.train.small import EXPERIMENTS, PPO
from tests.train.test_evaluate import still

COUNT = 32  # observations of GStack-v0


class Trap:
    """Makes a folder where it is unpickled."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __reduce__(self) -> Any:
        return os.mkdir, (str(self.folder),)


@pytest.fixture
def trained(tmp_path: Path) -> Path:
    """The folder of a run."""
    pytest.importorskip("stable_baselines3")
    from gsenv.train import experiment

    kind, _ = EXPERIMENTS[0]
    experiment.train(experiment.prepare(kind, replace(PPO, steps=128), tmp_path / "run"))
    return tmp_path / "run"


def one_sentence(error: BaseException) -> str:
    message = str(error)
    assert "\n" not in message
    assert len(re.sub(r"/\S*/", "", message)) < 500  # however long the folder's name is
    return message


def complaint(path: Path) -> str:
    with pytest.raises(PolicyError) as error:
        make_actor(str(path), "GStack-v0")
    return one_sentence(error.value)


# ---------------------------------------------------------------- no code is run


def test_a_pickle_beside_a_policy_is_not_read(trained: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trap = trained / "sprung"
    (trained / "normalize.pkl").write_bytes(pickle.dumps(Trap(trap)))
    make_actor(str(trained / "policy.zip"), "GStack-v0")  # its statistics are in normalize.npz
    (trained / "normalize.npz").unlink()
    assert "is a pickle" in complaint(trained / "policy.zip")
    assert cli.main(["evaluate", "GStack-v0", "--policy", str(trained / "policy.zip"), "--episodes", "1"]) == 1
    assert "is a pickle" in capsys.readouterr().err
    assert not trap.exists()


@pytest.mark.parametrize(
    ("name", "place"),
    [("normalize.pkl", "plain"), ("vecnormalize.pkl", "it's $HOME"), ("VecNormalize.pkl", 'a "b" `c`')],
)
def test_what_the_sentence_about_a_pickle_says_works(
    name: str, place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    envs = VecNormalize(DummyVecEnv([lambda: gymnasium.make("gsenv:GStack-v0")]))
    model = stable_baselines3.PPO("MlpPolicy", envs, n_steps=32, batch_size=32).learn(32)
    folder = tmp_path / place
    folder.mkdir()
    model.save(folder / "PPO.zip")
    envs.save(str(folder / name))
    (command,) = re.findall(r"run `(.*)` once", complaint(folder / "PPO.zip"))
    program, option, code, *arguments = shlex.split(command)
    assert (program, option, arguments) == ("python", "-c", [str(folder / name)])
    assert not {"$", "'", "`"} & set(code)  # it stands between double quotes
    monkeypatch.setattr("sys.argv", [option, *arguments])
    exec(code, {})
    actor = make_actor(str(folder / "PPO.zip"), "GStack-v0")
    envs.training = False
    observation: Any = envs.reset()
    seen: Any = envs.get_original_obs()
    expected = np.clip(model.predict(observation, deterministic=True)[0], -1.0, 1.0)
    np.testing.assert_allclose(actor(seen), expected, atol=1e-5)


def refused_pickles(folder: Path, policy: str) -> str:
    pytest.importorskip("stable_baselines3")
    from gsenv.train.export import refuse_pickle

    with pytest.raises(ValueError, match="pickle") as error:
        refuse_pickle(folder / policy)
    return one_sentence(error.value)


def test_of_several_pickles_that_of_the_same_steps_is_named(tmp_path: Path) -> None:
    for steps in (10000, 20000, 110000):
        (tmp_path / f"rl_model_vecnormalize_{steps}_steps.pkl").touch()
    named = refused_pickles(tmp_path, "rl_model_20000_steps.zip")
    assert f"{tmp_path}/rl_model_vecnormalize_20000_steps.pkl is a pickle" in named
    assert "10000_steps" not in named
    assert "rl_model_vecnormalize_10000_steps.pkl is a pickle" in refused_pickles(tmp_path, "rl_model_10000_steps.zip")


def test_pickles_of_which_none_stands_out_are_all_named(tmp_path: Path) -> None:
    names = ["a_vecnormalize_10_steps.pkl", "b_VecNormalize_10_steps.PKL", "vecnormalize_20_steps.pickle"]
    for name in names:
        (tmp_path / name).touch()
    (tmp_path / "notes.pkl").touch()
    assert f"has 3 pickles ({', '.join(names)})" in refused_pickles(tmp_path, "final.zip")
    assert f"has 3 pickles ({', '.join(names)})" in refused_pickles(tmp_path, "a_30_steps.zip")
    assert f"has 2 pickles ({', '.join(names[:2])})" in refused_pickles(tmp_path, "a_10_steps.zip")


def test_only_a_normalisation_is_converted(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3")
    from gsenv.train.export import convert_pickle

    (tmp_path / "normalize.pkl").write_bytes(pickle.dumps([1.0]))
    with pytest.raises(TypeError, match="holds a list, not a VecNormalize"):
        convert_pickle(tmp_path / "normalize.pkl")


def test_a_converted_normalisation_is_of_one_checkpoint(tmp_path: Path) -> None:
    """Stable-Baselines3's CheckpointCallback writes a pickle beside each zip; only one of them is normalize.npz."""
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    from gsenv.train.export import convert_pickle

    env = VecNormalize(DummyVecEnv([partial(gymnasium.make, "gsenv:GStack-v0")]))
    model = stable_baselines3.PPO("MlpPolicy", env)
    for steps in (64, 128):
        model.num_timesteps = steps
        model.save(tmp_path / f"rl_model_{steps}_steps.zip")
        env.save(str(tmp_path / f"rl_model_vecnormalize_{steps}_steps.pkl"))
    convert_pickle(tmp_path / "rl_model_vecnormalize_64_steps.pkl")
    assert make_actor(str(tmp_path / "rl_model_64_steps.zip"), "GStack-v0") is not None
    assert "is of 128 steps and normalize.npz beside it of 64" in complaint(tmp_path / "rl_model_128_steps.zip")


def test_a_plain_policy_acts_with_its_own_activation_or_is_refused(tmp_path: Path) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    import torch

    env = gymnasium.make("gsenv:GStack-v0")
    observations = np.random.default_rng(0).standard_normal((20, COUNT)).astype(np.float32)
    for activation in (torch.nn.ReLU, torch.nn.Tanh, torch.nn.ELU):
        model = stable_baselines3.PPO("MlpPolicy", env, policy_kwargs={"activation_fn": activation})
        with torch.no_grad():
            model.policy.action_net.weight.mul_(20.0)
        model.save(tmp_path / "PPO.zip")
        if activation is torch.nn.ELU:
            assert "its activation function is torch.nn.modules.activation.ELU" in complaint(tmp_path / "PPO.zip")
        else:
            expected = np.clip(model.predict(observations, deterministic=True)[0], -1.0, 1.0)
            np.testing.assert_allclose(
                make_actor(str(tmp_path / "PPO.zip"), "GStack-v0")(observations), expected, atol=1e-4
            )


@pytest.mark.parametrize(
    ("algorithm", "arguments", "message"),
    [
        ("SAC", {"use_sde": True, "buffer_size": 10}, "is of SAC with gSDE (use_sde=True)"),
        ("PPO", {"use_sde": True, "policy_kwargs": {"squash_output": True}}, "has squash_output=True"),
    ],
)
def test_policies_that_act_in_other_ways_are_refused(
    algorithm: str, arguments: dict[str, Any], message: str, tmp_path: Path
) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    model = getattr(stable_baselines3, algorithm)("MlpPolicy", gymnasium.make("gsenv:GStack-v0"), **arguments)
    model.save(tmp_path / "policy.zip")
    assert message in complaint(tmp_path / "policy.zip")


def test_ppo_with_gsde_acts_with_its_mean(tmp_path: Path) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    model = stable_baselines3.PPO("MlpPolicy", gymnasium.make("gsenv:GStack-v0"), use_sde=True)
    for tensor in model.policy.action_net.parameters():
        tensor.data.mul_(100.0)
    model.save(tmp_path / "PPO.zip")
    observations = np.random.default_rng(0).standard_normal((20, COUNT)).astype(np.float32)
    expected = np.clip(model.predict(observations, deterministic=True)[0], -1.0, 1.0)
    assert np.abs(expected).max() > 0.5
    np.testing.assert_allclose(make_actor(str(tmp_path / "PPO.zip"), "GStack-v0")(observations), expected, atol=1e-4)


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_policies_of_pixels_are_refused(algorithm: str, tmp_path: Path) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    arguments = {"buffer_size": 10} if algorithm == "SAC" else {}
    env = gymnasium.make("gsenv:GStack-v0", observation="pixels")
    getattr(stable_baselines3, algorithm)("CnnPolicy", env, **arguments).save(tmp_path / "pixels.zip")
    assert "is not an MlpPolicy of Stable-Baselines3's PPO or SAC, and gsenv reads no others" in complaint(
        tmp_path / "pixels.zip"
    )


def test_other_algorithms_are_told_where_to_be_scored(tmp_path: Path) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    model = stable_baselines3.TD3("MlpPolicy", gymnasium.make("gsenv:GStack-v0"), buffer_size=10)
    model.save(tmp_path / "TD3.zip")
    assert "gsenv reads no others; score it with" in complaint(tmp_path / "TD3.zip")


def test_resuming_reads_no_pickle_either(trained: Path) -> None:
    from gsenv.train import experiment

    trap = trained / "sprung"
    kind, _ = EXPERIMENTS[0]
    with zipfile.ZipFile(trained / "policy.zip") as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    import base64

    data = json.loads(members["data"])
    data["lr_schedule"] = {
        ":type:": "<class 'function'>",
        ":serialized:": base64.b64encode(pickle.dumps(Trap(trap))).decode(),
    }
    members["data"] = json.dumps(data).encode()
    with zipfile.ZipFile(trained / "policy.zip", "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    assert experiment.prepare(kind, PPO, trained, resume=True).steps == 128
    make_actor(str(trained / "policy.zip"), "GStack-v0")
    (trained / "normalize.pkl").write_bytes(pickle.dumps(Trap(trap)))
    (trained / "normalize.npz").unlink()
    with pytest.raises(ValueError, match="is a pickle"):
        experiment.prepare(kind, PPO, trained, resume=True)
    assert not trap.exists()


def test_pickles_in_place_of_tensors_are_not_read(trained: Path) -> None:
    trap = trained / "sprung"
    with zipfile.ZipFile(trained / "policy.zip", "w") as archive:
        archive.writestr("policy.pth", pickle.dumps(Trap(trap)))
    assert "is not an MlpPolicy" in complaint(trained / "policy.zip")
    assert not trap.exists()


def test_pickles_in_an_npz_are_not_read(tmp_path: Path) -> None:
    trap = tmp_path / "sprung"
    np.savez(tmp_path / "policy.npz", head=np.array(Trap(trap), object), mean=np.zeros(COUNT))
    assert "is not a policy" in complaint(tmp_path / "policy.npz")
    (tmp_path / "bare.npz").write_bytes(pickle.dumps(Trap(trap)))
    assert "is not a policy" in complaint(tmp_path / "bare.npz")
    assert not trap.exists()


# ---------------------------------------------------------------- broken files


def write(path: Path, fields: dict[str, Any] | None = None, **changes: Any) -> Path:
    """A policy file with some arrays replaced or, where None, left out."""
    policy = still()
    arrays: dict[str, Any] = {"mean": policy.mean, "scale": policy.scale}
    arrays |= {"weight_0": policy.layers[0][0], "bias_0": policy.layers[0][1]}
    arrays["head"] = np.array(json.dumps({"activation": "tanh", "squash": False, "notes": {}} | (fields or {})))
    arrays = {name: array for name, array in (arrays | changes).items() if array is not None}
    np.savez(path, **arrays)
    return path


NAN = np.full((4, COUNT), np.nan, np.float32)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weight_0": NAN}, "the weight of layer 0 has numbers that are not finite"),
        ({"bias_0": np.full(4, np.inf, np.float32)}, "the bias of layer 0 has numbers that are not finite"),
        ({"mean": np.full(COUNT, np.nan, np.float32)}, "mean has numbers that are not finite"),
        ({"scale": np.zeros(COUNT, np.float32)}, "scale must be 32 positive numbers"),
        ({"scale": np.ones(COUNT - 1, np.float32)}, "scale must be 32 positive numbers"),
        ({"scale": np.ones((COUNT, 1), np.float32)}, "scale must have 1 dimension"),
        ({"weight_0": np.zeros((4, COUNT - 1), np.float32)}, r"layer 0 must have the shape \(4, 32\), got \(4, 31\)"),
        ({"weight_0": np.zeros((COUNT, 4), np.float32)}, "layer 0 must have the shape"),
        ({"weight_0": np.array(["a"])}, "must be an array of floats"),
        ({"bias_0": np.zeros((4, 1), np.float32)}, "the bias of layer 0 must have 1 dimension"),
        ({"weight_0": None, "bias_0": None}, "at least one layer"),
        ({"weight_0": None}, "at least one layer|other names"),
        ({"bias_0": None}, "it has no 'bias_0'"),
        ({"scale": None}, "it has no 'scale'"),
        ({"head": None}, "it has no 'head'"),
        ({"weight_2": np.zeros((4, 4), np.float32)}, "it has no 'weight_1'"),
        ({"extra": np.zeros(2)}, "arrays of other names: extra"),
        ({"head": np.array("no json")}, "is not a policy"),
        ({"head": np.array('["list"]')}, "its head must be a JSON object, got a list"),
        ({"head": np.array("[" * 100_000 + "]" * 100_000)}, "its head is JSON that is nested too deeply"),
        ({"bias_0": np.zeros(4, np.complex64)}, "the bias of layer 0 must be an array of floats"),
    ],
)
def test_broken_policies_are_refused(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    path = write(tmp_path / "policy.npz", **changes)
    with pytest.raises(ValueError, match=message) as error:
        MlpPolicy.load(path)
    one_sentence(error.value)
    assert str(path) in complaint(path)


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ({"activation": "gelu"}, "activation must be one of"),
        ({"activation": ["tanh"]}, "activation must be one of"),
        ({"squash": "yes"}, "squash must be True or False"),
        ({"notes": "text"}, "notes a dict"),
        ({"colour": 1}, "its head has other names: colour"),
        ({"mean": [0.0]}, "its head has other names: mean"),
    ],
)
def test_broken_heads_are_refused(head: dict[str, Any], message: str, tmp_path: Path) -> None:
    path = write(tmp_path / "policy.npz", fields=head)
    with pytest.raises(ValueError, match=message) as error:
        MlpPolicy.load(path)
    one_sentence(error.value)


def test_policies_of_other_environments_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "policy.npz", weight_0=np.zeros((3, COUNT), np.float32), bias_0=np.zeros(3, np.float32))
    assert "is for 3 actions, and GStack-v0 has 4" in complaint(path)


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "policy.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("mean.npy", "w") as member:
        for _ in range(300):
            member.write(bytes(2**20))
    assert path.stat().st_size < 2**20
    assert "it would unpack to 300 MB" in complaint(path)


def test_half_a_file_is_called_damaged(tmp_path: Path) -> None:
    path = write(tmp_path / "policy.npz")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert "is not a policy that gsenv has written: it is damaged, cut off or no zip archive" in complaint(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"observation_mean": np.full(COUNT, np.nan)}, "observation_mean must be finite numbers"),
        ({"observation_variance": np.full(COUNT, -1.0)}, "observation_variance must not be negative"),
        ({"observation_variance": np.ones(COUNT + 1)}, "observation_variance has the wrong shape"),
        ({"return_mean": np.zeros(2)}, "return_mean has the wrong shape"),
        ({"epsilon": None}, "epsilon"),
        ({"extra": np.zeros(1)}, "extra"),
    ],
)
def test_broken_statistics_are_refused(changes: dict[str, Any], message: str, trained: Path) -> None:
    path = trained / "normalize.npz"
    with np.load(path) as data:
        arrays: dict[str, Any] = {name: data[name] for name in data.files} | changes
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    assert message in complaint(trained / "policy.zip")


def test_weights_of_nan_are_refused_in_a_zip_too(trained: Path) -> None:
    from gsenv.train import experiment

    kind, _ = EXPERIMENTS[0]
    run = experiment.prepare(kind, PPO, trained, resume=True)
    for tensor in run.model.policy.parameters():
        tensor.data.fill_(float("nan"))
    run.model.save(trained / "policy.zip")
    assert "numbers that are not finite" in complaint(trained / "policy.zip")


def test_a_policy_of_other_layers_cannot_be_resumed(trained: Path) -> None:
    from gsenv.train import experiment

    kind, _ = EXPERIMENTS[0]
    for complaint in (r"holds a run with layers \[", "does not fit these settings"):
        with pytest.raises(ValueError, match=complaint) as error:
            experiment.prepare(kind, replace(PPO, layers=(8, 8)), trained, resume=True)
        one_sentence(error.value)
        (trained / "settings.json").unlink(missing_ok=True)  # the policy itself tells, too


# ---------------------------------------------------------------- splits


def test_training_on_the_split_for_tests_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    from gsenv.train import ppo

    with pytest.raises(SystemExit):
        ppo.main(["--env", "GStack-v0", "--set", "split=test"])
    assert "training takes the split 'train'" in capsys.readouterr().err
