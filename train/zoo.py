"""Writes the settings of ppo.py and sac.py as zoo_ppo.yml and zoo_sac.yml, for RL Baselines3 Zoo.

python -m gsenv.train.zoo
python -m rl_zoo3.train --algo ppo --env GStack-v0 --gym-packages gsenv --conf-file train/zoo_ppo.yml
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gsenv.envs import ENVS
from gsenv.files import write_text
from gsenv.train import ppo, sac

FOLDER = Path(__file__).parent


def ppo_entry(settings: ppo.Settings) -> dict[str, Any]:
    layers = list(settings.layers)
    return {
        "normalize": True,
        "n_envs": settings.world_count,
        "n_timesteps": settings.steps,
        "policy": "MlpPolicy",
        "learning_rate": f"lin_{settings.learning_rate}",
        "n_steps": settings.rollout,
        "batch_size": settings.batch_size,
        "n_epochs": settings.epochs,
        "gamma": settings.discount,
        "gae_lambda": settings.gae_lambda,
        "clip_range": settings.clip,
        "ent_coef": settings.entropy_weight,
        "policy_kwargs": f'"dict(net_arch={layers}, log_std_init={settings.log_std})"',
    }


def sac_entry(settings: sac.Settings) -> dict[str, Any]:
    return {
        "normalize": True,
        "n_envs": settings.world_count,
        "n_timesteps": settings.steps,
        "policy": "MlpPolicy",
        "learning_rate": f"lin_{settings.learning_rate}",
        "buffer_size": settings.buffer_size,
        "batch_size": settings.batch_size,
        "learning_starts": settings.learning_starts,
        "tau": settings.target_update,
        "gamma": settings.discount,
        "train_freq": 1,
        "gradient_steps": settings.gradient_steps,
        "policy_kwargs": f'"dict(net_arch={list(settings.layers)})"',
    }


def text(algorithm: str) -> str:
    """Return the YAML text of an algorithm's settings; environments keep their default arguments."""
    lines = [f"# Written by gsenv.train.zoo from the settings of {algorithm}.py."]
    for entry in ENVS:
        values = ppo_entry(ppo.settings_for(entry.id)) if algorithm == "ppo" else sac_entry(sac.settings_for(entry.id))
        lines += ["", f"{entry.id}:", *(f"  {name}: {_yaml(value)}" for name, value in values.items())]
    return "\n".join(lines) + "\n"


def _yaml(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def path(algorithm: str) -> Path:
    return FOLDER / f"zoo_{algorithm}.yml"


def main() -> None:
    for algorithm in ("ppo", "sac"):
        write_text(path(algorithm), text(algorithm))


if __name__ == "__main__":
    main()
