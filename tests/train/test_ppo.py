from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsenv.train import ppo
from tests.processes import hear_interrupts

ROOT = Path(__file__).parent.parent.parent
pytest.importorskip("stable_baselines3")

SMALL = ppo.Settings(
    steps=256, env_count=2, rollout=64, batch_size=64, epochs=1, layers=(16,), evaluation_episodes=2
)


def test_trains_saves_and_evaluates(tmp_path: Path) -> None:
    from stable_baselines3 import PPO

    model = ppo.make_model(SMALL)
    assert ppo.train(model, SMALL, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.zip"]
    loaded = PPO.load(tmp_path / "policy.zip", device="cpu")
    observation = np.ones(30, np.float32)
    np.testing.assert_array_equal(
        loaded.predict(observation, deterministic=True)[0],
        model.predict(observation, deterministic=True)[0],
    )
    result = ppo.evaluate(loaded, "GStack-v0", 3)
    assert result == ppo.evaluate(model, "GStack-v0", 3)
    assert result.episodes == 3
    assert 0.0 <= result.success_rate <= 1.0


def test_equal_seeds_train_equal_policies(tmp_path: Path) -> None:
    weights = []
    for seed in (0, 0, 1):
        settings = replace(SMALL, seed=seed)
        model = ppo.make_model(settings)
        ppo.train(model, settings, tmp_path)
        weights.append(model.policy.action_net.weight.detach().numpy().copy())  # type: ignore[operator]
    np.testing.assert_array_equal(weights[0], weights[1])
    assert (weights[0] != weights[2]).any()


def test_interrupt_keeps_a_usable_policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from stable_baselines3 import PPO

    model = ppo.make_model(SMALL)
    monkeypatch.setattr(model, "train", lambda: (_ for _ in ()).throw(KeyboardInterrupt))
    assert not ppo.train(model, SMALL, tmp_path)
    PPO.load(tmp_path / "policy.zip", device="cpu").predict(np.zeros(30, np.float32))


def test_a_failed_save_leaves_the_old_policy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "policy.zip").write_text("old")
    model = ppo.make_model(SMALL)

    def fail(path: Path) -> None:
        path.write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(model, "save", fail)
    with pytest.raises(OSError, match="disk full"):
        ppo.save(model, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.zip"]
    assert (tmp_path / "policy.zip").read_text() == "old"


@pytest.mark.parametrize("start", [["-m", "gsenv.train.ppo"], ["train/ppo.py"]])
def test_command_line_and_ctrl_c(start: list[str], tmp_path: Path) -> None:
    command = [
        sys.executable,
        *start,
        "--env",
        "GStack-v0",
        "--steps",
        "1000000",
        "--out",
        str(tmp_path),
    ]
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hear_interrupts,
    )
    try:
        deadline = time.monotonic() + 120
        while not (tmp_path / "settings.json").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(2)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == ppo.INTERRUPTED, errors
    assert "interrupted after" in output
    assert (tmp_path / "policy.zip").exists()
    assert json.loads((tmp_path / "settings.json").read_text())["steps"] == 1000000


def test_short_run_to_the_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ppo.main(["--steps", "1", "--out", str(tmp_path)]) == 0
    assert "unseen episodes" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["--env", "GNothing-v0"], ["--steps", "0"]])
def test_wrong_command_lines_are_refused(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as error:
        ppo.main(arguments)
    assert error.value.code == 2


def test_missing_libraries_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    assert ppo.main(["--steps", "10"]) == 1
    assert "pip install 'gsenv[train]'" in capsys.readouterr().err
