"""Writes the settings of ppo.py as zoo_ppo.yml, for RL Baselines3 Zoo.

python -m gsenv.train.zoo
python -m rl_zoo3.train --algo ppo --env GStack-v0 --gym-packages gsenv --conf-file train/zoo_ppo.yml
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gsenv.envs import ENVS
from gsenv.files import write_text
from gsenv.train import ppo

PATH = Path(__file__).with_name("zoo_ppo.yml")


def entry_of(settings: ppo.Settings) -> dict[str, Any]:
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


def text() -> str:
    """Return the YAML text of the settings; environments keep their default arguments."""
    lines = ["# Written by gsenv.train.zoo from the settings of ppo.py."]
    for entry in ENVS:
        values = entry_of(ppo.settings_for(entry.id))
        lines += ["", f"{entry.id}:", *(f"  {name}: {_yaml(value)}" for name, value in values.items())]
    return "\n".join(lines) + "\n"


def _yaml(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


if __name__ == "__main__":
    write_text(PATH, text())
