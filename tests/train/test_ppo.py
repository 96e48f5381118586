"""The command lines of the training scripts."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.train import experiment, ppo
from gsenv.train.adaptive import AdaptivePPO
from tests.processes import hear_interrupts
from tests.train.small import PPO

ROOT = Path(__file__).parent.parent.parent
pytest.importorskip("stable_baselines3")


def test_each_environment_has_settings_of_its_own() -> None:
    """The defaults learn none of the tasks."""
    names = {entry.id for entry in ENVS} | {entry.name for entry in PARALLEL_ENVS}
    assert set(ppo.SETTINGS) == names


@pytest.mark.parametrize("start", [["-m", "gsenv.train.ppo"], ["train/ppo.py"]])
def test_command_line_and_ctrl_c(start: list[str], tmp_path: Path) -> None:
    command = [sys.executable, *start, "--env", "GStack-v0", "--steps", "1000000", "--out", str(tmp_path)]
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hear_interrupts,
    )
    folder = tmp_path / "seed-0"
    try:
        deadline = time.monotonic() + 120
        while not (folder / "settings.json").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(2)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == experiment.INTERRUPTED, errors
    assert "interrupted after" in output
    assert (folder / "policy.npz").exists()
    assert json.loads((folder / "settings.json").read_text())["steps"] == 1000000


def test_seeds_steps_and_arguments(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--steps", "1", "--seeds", "3", "4", "--set", "blocks=1", "--out", str(tmp_path)]
    assert ppo.main(arguments) == 0
    assert "seed 4: trained" in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["curve.png", "seed-3", "seed-4"]
    settings = json.loads((tmp_path / "seed-4" / "settings.json").read_text())
    assert settings["seed"] == 4
    assert settings["arguments"] == {"blocks": 1, "crack_speed": 0.4}


@pytest.mark.parametrize("arguments", [
    ["--env", "GNothing-v0"], ["--steps", "0"], ["--seeds", "-1"], ["--seeds"], ["--set", "blocks"],
])  # fmt: skip
def test_wrong_command_lines_are_refused(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as error:
        ppo.main(arguments)
    assert error.value.code == 2


def test_bad_arguments_of_the_environment_are_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        ppo.main(["--set", "blocks=99", "--out", str(tmp_path)])
    assert stop.value.code == 2
    assert capsys.readouterr().err == "ppo: blocks must be a whole number from 1 to 8, got 99.\n"


def test_missing_libraries_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    assert ppo.main(["--steps", "10"]) == 1
    assert "pip install 'gsenv[train]'" in capsys.readouterr().err


def test_exploration_ends_with_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In its first half standard deviations are as learned; then they fall to the final one, and with --resume too."""
    settings = replace(PPO, steps=512, final_log_std=-3.0)
    assert settings.log_std == -1.0
    run = experiment.prepare(ppo.EXPERIMENT, settings, tmp_path)
    seen: dict[int, float] = {}
    learn = AdaptivePPO.train

    def train(model: Any) -> None:
        learn(model)
        seen[model.num_timesteps] = float(model.policy.log_std.detach().max())

    monkeypatch.setattr(AdaptivePPO, "train", train)
    experiment.train(run)
    assert list(seen) == [128, 256, 384, 512]
    assert abs(seen[128] + 1.0) < 0.1
    assert abs(seen[256] + 1.0) < 0.1
    assert seen[384] == pytest.approx(-2.0)
    assert seen[512] == pytest.approx(-3.0)
    again: Any = experiment.prepare(ppo.EXPERIMENT, replace(settings, steps=640), tmp_path, resume=True).model
    again.learn(128, reset_num_timesteps=False)
    assert float(again.policy.log_std.detach().max()) == pytest.approx(-3.0)
    free: Any = experiment.prepare(ppo.EXPERIMENT, replace(settings, final_log_std=None), tmp_path / "free").model
    free.learn(512)
    assert float(free.policy.log_std.detach().max()) > -1.1


def test_the_learning_rate_follows_the_policy_and_is_kept_by_resume(tmp_path: Path) -> None:
    """Updates that change a policy too much lower it; a run that continues begins where the first one ended."""
    settings = replace(PPO, wanted_kl=1e-9)
    run: Any = experiment.prepare(ppo.EXPERIMENT, settings, tmp_path)
    assert experiment.train(run)
    rate = run.model.policy.optimizer.param_groups[0]["lr"]
    assert rate == pytest.approx(settings.learning_rate / 1.5**2)  # two updates
    again: Any = experiment.prepare(ppo.EXPERIMENT, replace(settings, steps=384), tmp_path, resume=True)
    assert again.model.policy.optimizer.param_groups[0]["lr"] == rate
    assert experiment.train(again)
    assert again.model.policy.optimizer.param_groups[0]["lr"] == pytest.approx(rate / 1.5)


@pytest.mark.slow
def test_the_first_policy_of_the_readme_builds_what_random_actions_do_not(tmp_path: Path) -> None:
    command = ["--env", "GStack-v0", "--set", "blocks=2", "--steps", "1500000", "--out", str(tmp_path)]
    assert " ".join(command[2:6]) in (ROOT / "README.md").read_text()
    assert ppo.main(command) == experiment.OK
    result = json.loads((tmp_path / "seed-0" / "result.json").read_text())
    assert result["blocks 2: random"]["success_rate"] == 0.0
    assert result["blocks 2: trained"]["success_rate"] >= 0.5
