"""Saved models of Stable-Baselines3: damaged, strange and far too large ones are refused in one sentence."""

from __future__ import annotations

import io
import re
import shutil
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from gsenv import cli
from gsenv.envs.core.mlp import MlpPolicy, read_members
from gsenv.train.evaluate import make_actor
from gsenv.train.export import export, load_zip, restore, save_normalize, statistics_of
from tests.train.test_safety import complaint, one_sentence

CLIENTS = Path(__file__).parents[2] / "docs/clients.md"
DEEP = b"[" * 100_000 + b"]" * 100_000

Change = Callable[[dict[str, Any]], Any]


class Saved(NamedTuple):
    """A model, and the folder where it was saved."""

    model: PPO
    folder: Path


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Saved:
    folder = tmp_path_factory.mktemp("saved")
    envs = VecNormalize(DummyVecEnv([lambda: gymnasium.make("gsenv:GStack-v0")]))
    model = PPO("MlpPolicy", envs, n_steps=32, batch_size=32, policy_kwargs={"net_arch": [8]}).learn(32)
    model.save(folder / "policy.zip")
    save_normalize(statistics_of(envs, 32), folder / "normalize.npz")
    return Saved(model, folder)


@pytest.fixture
def folder(saved: Saved, tmp_path: Path) -> Path:
    """A copy of the model's files."""
    shutil.copytree(saved.folder, tmp_path / "copy")
    return tmp_path / "copy"


def rewrite(path: Path, compression: int = zipfile.ZIP_STORED, **members: Any) -> None:
    """Replace members of an archive; without `pth` in their names, and None leaves them out."""
    content = read_members(path)
    for name, value in members.items():
        full = name if name in content else f"{name}.pth".replace("_optimizer", ".optimizer")
        assert full in content
        if value is None:
            del content[full]
        else:
            content[full] = value
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, value in content.items():
            archive.writestr(name, value)


def torch_bytes(content: Any) -> bytes:
    buffer = io.BytesIO()
    torch.save(content, buffer)
    return buffer.getvalue()


def refusals(saved: Saved, folder: Path) -> list[str]:
    """What an evaluation and `--resume` say, none of which may warn beside it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        messages = [complaint(folder / "policy.zip")]
        with pytest.raises(ValueError, match=r"policy\.zip") as error:
            restore(saved.model, folder / "policy.zip")
    return [*messages, one_sentence(error.value)]


def changed(saved: Saved, change: Change) -> bytes:
    """The weights of the policy after a change in place, or what `change` returns in their stead."""
    weights: dict[str, Any] = dict(saved.model.policy.state_dict())
    result = change(weights)
    return torch_bytes(weights if result is None else result)


# ---------------------------------------------------------------- damaged files


def test_a_flipped_bit_is_refused(saved: Saved, folder: Path) -> None:
    path = folder / "policy.zip"
    content = bytearray(path.read_bytes())
    content[content.find(b"num_timesteps")] ^= 1
    path.write_bytes(content)
    for message in refusals(saved, folder):
        assert "it is damaged, cut off or no zip archive (Bad CRC-32 for file 'data')" in message


@pytest.mark.parametrize("name", ["data", "policy.pth", "pytorch_variables.pth"])
def test_damaged_compressed_members_are_refused(saved: Saved, folder: Path, name: str) -> None:
    path = folder / "policy.zip"
    rewrite(path, zipfile.ZIP_DEFLATED)
    with zipfile.ZipFile(path) as archive:
        member = archive.getinfo(name)
    content = bytearray(path.read_bytes())
    middle = member.header_offset + 30 + len(name) + member.compress_size // 2
    for k in range(middle, middle + 20):
        content[k] ^= 0x5A
    path.write_bytes(content)
    for message in refusals(saved, folder):
        assert "it is damaged, cut off or no zip archive" in message


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9, 0.999])
def test_a_file_that_is_cut_off_is_called_so(saved: Saved, folder: Path, kept: float) -> None:
    """In half of a file zipfile finds a whole archive: policy.pth is one."""
    path = folder / "policy.zip"
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content))])
    for message in refusals(saved, folder):
        assert re.search("it is damaged(,| or) cut off", message)
        assert "evaluate_policy" not in message


def test_a_file_with_a_hole_is_called_damaged(saved: Saved, folder: Path) -> None:
    """Its table of contents leads to before the file's beginning."""
    path = folder / "policy.zip"
    content = path.read_bytes()
    path.write_bytes(content[100:])
    for message in refusals(saved, folder):
        assert "it is damaged" in message


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (DEEP, "its member data is JSON that is nested too deeply"),
        (b"[" * 100_000, "its member data is"),
        (b"[1]", "its member data must be a JSON object, got a list"),
        (b"\xff\x00", "its member data is no JSON"),
        (None, "it has no member data"),
    ],
)
def test_a_model_that_tells_nothing_of_itself_is_refused(
    saved: Saved, folder: Path, data: bytes | None, message: str
) -> None:
    """Its activation function and its steps would be guesses."""
    rewrite(folder / "policy.zip", data=data)
    for refusal in refusals(saved, folder):
        assert message in refusal


# ---------------------------------------------------------------- strange tensors


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda weights: torch.zeros(3), r"policy\.pth must hold a dict by names"),
        (lambda weights: [1, 2], r"policy\.pth must hold a dict by names"),
        (lambda weights: {1: 2}, r"policy\.pth must hold a dict by names"),
        (lambda weights: weights.update(log_std=torch.zeros(1).expand(10**10)), "too few numbers for a tensor"),
        (lambda weights: weights.update({"action_net.bias": torch.zeros(1).expand(4)}), "too few numbers"),
        (lambda weights: weights.update({"action_net.bias": torch.zeros(4, dtype=torch.complex64)}), "no plain array"),
        (lambda weights: weights.update({"action_net.bias": torch.zeros(4).to_sparse()}), "no plain array"),
        (lambda weights: weights.update({"action_net.bias": torch.zeros(4, device="meta")}), "no plain array"),
        (lambda weights: weights.update({"action_net.bias": torch.zeros(3)}), "layer 1 must have|size mismatch for"),
        (lambda weights: weights.update(dict.fromkeys(weights, 1)), "no tensor of floats called|does not fit"),
        (lambda weights: weights.update(lists=[[1] * 1000] * 1000), "more than 100000 entries"),
    ],
    ids=[
        *("tensor", "list", "whole keys", "expanded", "a little expanded", "complex", "sparse", "without numbers"),
        *("of another shape", "scalars", "lists of lists"),
    ],
)
def test_strange_weights_are_refused(saved: Saved, folder: Path, change: Change, message: str) -> None:
    rewrite(folder / "policy.zip", policy=changed(saved, change))
    for refusal in refusals(saved, folder):
        assert re.search(message, refusal)


def test_weights_must_be_floats(saved: Saved, folder: Path) -> None:
    whole = changed(saved, lambda weights: weights.update({"action_net.bias": torch.zeros(4, dtype=torch.int64)}))
    rewrite(folder / "policy.zip", policy=whole)
    assert "it has no tensor of floats called action_net.bias" in complaint(folder / "policy.zip")


@pytest.mark.parametrize("content", [b"abc", b"", b"PK\x03\x04 and no more"])
def test_members_that_torch_does_not_read_are_refused(saved: Saved, folder: Path, content: bytes) -> None:
    rewrite(folder / "policy.zip", policy=content)
    for message in refusals(saved, folder):
        assert "its member policy.pth holds no tensors that can be read" in message


def test_a_model_without_a_policy_is_refused(saved: Saved, folder: Path) -> None:
    rewrite(folder / "policy.zip", policy=None)
    for message in refusals(saved, folder):
        assert "it has no member policy.pth" in message


@pytest.mark.parametrize("member", ["policy_optimizer", "pytorch_variables"])
@pytest.mark.parametrize(
    "content",
    [[1], torch.zeros(2), {0: 1}, {"state": {0: {"exp_avg": torch.zeros(1).expand(10**10)}}, "param_groups": [{}]}],
    ids=["list", "tensor", "whole keys", "expanded"],
)
def test_the_other_members_are_checked_as_well(saved: Saved, folder: Path, member: str, content: Any) -> None:
    members: dict[str, Any] = {member: torch_bytes(content)}
    rewrite(folder / "policy.zip", **members)
    for message in refusals(saved, folder):
        assert member.replace("_optimizer", ".optimizer") in message


@pytest.mark.parametrize("variables", [{"policy": torch.zeros(1)}, {"nothing": torch.zeros(1)}, {"ent_coef": 1.0}])
def test_variables_that_the_algorithm_does_not_have_do_not_fit(
    saved: Saved, folder: Path, variables: dict[str, Any]
) -> None:
    rewrite(folder / "policy.zip", pytorch_variables=torch_bytes(variables))
    with pytest.raises(ValueError, match="does not fit these settings") as error:
        restore(saved.model, folder / "policy.zip")
    one_sentence(error.value)


def test_pickles_are_refused_without_a_warning(saved: Saved, folder: Path) -> None:
    import pickle

    rewrite(folder / "policy.zip", policy=pickle.dumps(Saved, protocol=4))
    for message in refusals(saved, folder):
        assert "has pickled objects" in message


def test_half_precision_is_read(saved: Saved, folder: Path) -> None:
    path = folder / "policy.zip"
    halved = {name: tensor.bfloat16() for name, tensor in saved.model.policy.state_dict().items()}
    rewrite(path, policy=torch_bytes(halved))
    np.testing.assert_array_equal(load_zip(path).layers[0][1], halved["mlp_extractor.policy_net.0.bias"].float())


def test_an_exported_policy_does_not_change_with_the_model(saved: Saved) -> None:
    policy = export(saved.model, None)
    before = policy.layers[0][0].copy()
    parameter = dict(saved.model.policy.named_parameters())["mlp_extractor.policy_net.0.weight"]
    with torch.no_grad():
        parameter.add_(1.0)
        np.testing.assert_array_equal(policy.layers[0][0], before)
        parameter.sub_(1.0)


# ---------------------------------------------------------------- far too large files


@pytest.mark.parametrize("name", ["data", "notes.txt", "policy.pth"])
def test_a_bomb_is_not_unpacked(saved: Saved, folder: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = folder / "policy.zip"
    members = read_members(path) | {name: b" " * 2**26}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for each, content in members.items():
            archive.writestr(each, content)
    del members, content
    monkeypatch.setattr("gsenv.envs.core.mlp.MOST_BYTES", 2**25)
    tracemalloc.start()
    messages = refusals(saved, folder)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 2**22
    for message in messages:
        assert "it would unpack to 64 MB" in message


def test_a_bomb_in_a_member_is_not_unpacked(saved: Saved, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of torch are archives, too."""
    inner = io.BytesIO()
    with zipfile.ZipFile(inner, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data.pkl", b" " * 2**22)
    rewrite(folder / "policy.zip", policy=inner.getvalue())
    monkeypatch.setattr("gsenv.envs.core.mlp.MOST_BYTES", 2**21)
    for message in refusals(saved, folder):
        assert "policy.pth holds no tensors that can be read (it would unpack to 4 MB" in message


def test_no_more_is_unpacked_than_an_archive_says(tmp_path: Path) -> None:
    path = tmp_path / "lies.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("data", bytes(2**26))
    path.write_bytes(path.read_bytes().replace((2**26).to_bytes(4, "little"), (100).to_bytes(4, "little")))
    tracemalloc.start()
    with pytest.raises(ValueError, match="damaged"):
        read_members(path)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 2**22


def test_other_compressions_are_refused(saved: Saved, folder: Path) -> None:
    """A block of bzip2 is unpacked whole, however little of it is asked for."""
    rewrite(folder / "policy.zip", zipfile.ZIP_BZIP2)
    for message in refusals(saved, folder):
        assert "its member data is compressed by another method than deflate" in message


# ---------------------------------------------------------------- normalisation


def test_a_policy_without_its_normalisation_is_told_once(
    saved: Saved, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder / "policy.zip"
    make_actor(str(path), "GStack-v0")
    assert capsys.readouterr().err == ""
    (folder / "normalize.npz").unlink()
    given = ["--episodes", "1", "--set", "max_episode_steps=3"]
    assert cli.main(["evaluate", "GStack-v0", "--policy", str(path), *given]) == 0
    told = capsys.readouterr().err
    assert told.startswith(
        f"gsenv: {path} has no normalize.npz beside it, so observations are passed to it as they are"
    )
    assert told.count("\n") == 1
    make_actor(str(path), "GStack-v0")
    assert capsys.readouterr().err == ""


def test_the_files_that_the_documentation_writes_are_the_whole_policy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = CLIENTS.read_text(encoding="utf-8")
    (block,) = [each for each in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "import PPO" in each]
    (path,) = re.findall(r"`gsenv evaluate GRagdoll2D-v0 --policy (\S+)`", text)
    (line,) = re.findall(r"`gsenv\.train\.export\.(export\(.*?)`", text)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"export": export}
    exec(compile(f"{block}\n{line}", CLIENTS.name, "exec"), names)
    model, envs = names["model"], names["envs"]
    observations = envs.get_original_obs()
    expected = np.clip(model.predict(envs.normalize_obs(observations), deterministic=True)[0], -1.0, 1.0)
    for policy in (make_actor(path, "GRagdoll2D-v0"), MlpPolicy.load(tmp_path / "policy.npz")):
        np.testing.assert_allclose(policy(observations), expected, atol=1e-5)
    assert capsys.readouterr().err == ""
    assert np.abs(expected - MlpPolicy.load("policy.npz")(envs.normalize_obs(observations))).max() > 1e-3
