"""PPO on one environment.

    python -m gsenv.train.ppo --env GStack-v0 --steps 1000000

Writes `policy.zip`, for `stable_baselines3.PPO.load`, and `settings.json` to runs/ppo/ENV-SEED, the
policy anew every so often, never half. Ctrl-C ends early and keeps the policy as it is then.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

import gsenv  # noqa: F401  (registers the environments)

if TYPE_CHECKING:
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback

EVALUATION_SEED = 1_000_000  # far from the seeds that are trained on
INTERRUPTED = 130


@dataclass(frozen=True)
class Settings:
    """One experiment."""

    env: str = "GStack-v0"
    steps: int = 1_000_000
    seed: int = 0
    env_count: int = 16
    rollout: int = 256  # steps of each environment between updates
    batch_size: int = 512
    epochs: int = 5
    learning_rate: float = 3e-4
    discount: float = 0.99
    gae_lambda: float = 0.95
    entropy_weight: float = 0.0
    layers: tuple[int, ...] = (128, 128)
    torch_threads: int = 1  # more do not help nets this small
    checkpoint_every: int = 100_000  # steps
    evaluation_episodes: int = 20


@dataclass(frozen=True)
class Evaluation:
    """Episodes with the mean action, on seeds that training has not seen."""

    episodes: int
    mean_return: float
    success_rate: float
    mean_length: float


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment of a command line; returns the exit code."""
    settings, out = _parse(arguments)
    try:
        import stable_baselines3  # noqa: F401
        import torch
    except ImportError as error:
        print(
            f"ppo: {error.name} is missing; pip install 'gsenv[train]' brings it.", file=sys.stderr
        )
        return 1
    torch.set_num_threads(settings.torch_threads)
    try:
        return _run(settings, out)
    except KeyboardInterrupt:
        print("ppo: interrupted", file=sys.stderr)
        return INTERRUPTED


def _run(settings: Settings, out: Path) -> int:
    model = make_model(settings)
    out.mkdir(parents=True, exist_ok=True)
    (out / "settings.json").write_text(json.dumps(asdict(settings), indent=2) + "\n")
    began = perf_counter()
    finished = train(model, settings, out)
    rate = model.num_timesteps / (perf_counter() - began)
    how = "trained" if finished else "interrupted after"
    print(f"{how} {model.num_timesteps} steps, {rate:.0f}/s; the policy is in {out / 'policy.zip'}")
    if not finished:
        return INTERRUPTED
    result = evaluate(model, settings.env, settings.evaluation_episodes)
    print(
        f"{result.episodes} unseen episodes: return {result.mean_return:.2f}, "
        f"success {result.success_rate:.0%}, {result.mean_length:.0f} steps"
    )
    return 0


def _parse(arguments: Sequence[str] | None) -> tuple[Settings, Path]:
    default = Settings()
    parser = argparse.ArgumentParser(prog="ppo", description="Train PPO on an environment.")
    parser.add_argument("--env", default=default.env, help="default: %(default)s")
    parser.add_argument(
        "--steps", type=_positive, default=default.steps, help="default: %(default)s"
    )
    parser.add_argument("--seed", type=int, default=default.seed, help="default: %(default)s")
    parser.add_argument("--out", type=Path, help="folder; default: runs/ppo/ENV-SEED")
    given = parser.parse_args(arguments)
    if given.env.rpartition(":")[2] not in gymnasium.registry:
        parser.error(f"there is no environment {given.env!r}")
    out = given.out or Path("runs") / "ppo" / f"{given.env.rpartition(':')[2]}-{given.seed}"
    return Settings(env=given.env, steps=given.steps, seed=given.seed), out


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive whole number")
    return int(text)


def make_model(settings: Settings) -> PPO:
    """An untrained agent with its environments; equal settings give equal agents."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_util import make_vec_env

    return PPO(
        "MlpPolicy",
        make_vec_env(settings.env, n_envs=settings.env_count, seed=settings.seed),
        learning_rate=settings.learning_rate,
        n_steps=settings.rollout,
        batch_size=settings.batch_size,
        n_epochs=settings.epochs,
        gamma=settings.discount,
        gae_lambda=settings.gae_lambda,
        ent_coef=settings.entropy_weight,
        policy_kwargs={"net_arch": list(settings.layers)},
        seed=settings.seed,
        device="cpu",
    )


def train(model: PPO, settings: Settings, out: Path) -> bool:
    """Train with a progress bar; False if Ctrl-C ended it. The policy is saved in any case."""
    finished = True
    with _progress() as progress:
        try:
            model.learn(settings.steps, callback=_watcher(progress, settings, out))
        except KeyboardInterrupt:
            finished = False
    save(model, out)
    return finished


def save(model: PPO, out: Path) -> None:
    """Write policy.zip whole or not at all."""
    partial = out / f"policy.{os.getpid()}.tmp.zip"
    try:
        model.save(partial)
        os.replace(partial, out / "policy.zip")
    finally:
        partial.unlink(missing_ok=True)


def _progress() -> Any:
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    )


def _watcher(progress: Any, settings: Settings, out: Path) -> BaseCallback:
    """Moves the progress bar and saves checkpoints."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Watcher(BaseCallback):
        def _on_training_start(self) -> None:
            self.task = progress.add_task(settings.env, total=settings.steps)
            self.saved = 0

        def _on_step(self) -> bool:
            return True

        def _on_rollout_end(self) -> None:
            steps = self.num_timesteps
            progress.update(self.task, completed=steps, description=self._description())
            if steps - self.saved >= settings.checkpoint_every:
                save(self.model, out)  # type: ignore[arg-type]
                self.saved = steps

        def _description(self) -> str:
            text = settings.env
            if self.model.ep_info_buffer:
                text += f"  return {np.mean([e['r'] for e in self.model.ep_info_buffer]):.2f}"
            if self.model.ep_success_buffer:
                text += f"  success {np.mean(self.model.ep_success_buffer):.0%}"
            return text

    return Watcher()


def evaluate(model: Any, env_id: str, episodes: int, seed: int = EVALUATION_SEED) -> Evaluation:
    """One episode on each of `episodes` seeds, side by side."""
    envs = gymnasium.make_vec(env_id, num_envs=episodes)
    observations, _ = envs.reset(seed=seed)
    returns, lengths = np.zeros(episodes), np.zeros(episodes, np.int64)
    running, success = np.ones(episodes, bool), np.zeros(episodes, bool)
    while running.any():
        actions, _ = model.predict(observations, deterministic=True)
        observations, rewards, terminated, truncated, infos = envs.step(actions)
        returns += np.where(running, rewards, 0.0)
        lengths += running
        ended = terminated | truncated
        success |= running & ended & infos.get("is_success", np.zeros(episodes, bool))
        running &= ~ended
    envs.close()
    return Evaluation(episodes, float(returns.mean()), float(success.mean()), float(lengths.mean()))


if __name__ == "__main__":
    sys.exit(main())
