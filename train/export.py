"""Conversion of Stable-Baselines3 policies to networks that only need numpy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.vec_env import VecNormalize

from gsenv.envs.core.mlp import MlpPolicy

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

NORMALIZE = "normalize.pkl"  # in the folder of policy.zip


def export(model: BaseAlgorithm, normalize: VecNormalize | None, notes: dict[str, Any] | None = None) -> MlpPolicy:
    """Return the mean-action network of a PPO or SAC "MlpPolicy", including its observation normalisation."""
    return _from_weights(model.policy.state_dict(), normalize, notes or {})


def load_zip(path: Path) -> MlpPolicy:
    """Return the network of a saved model, with the normalisation of normalize.pkl if that is in the same folder.

    Raises:
        OSError: the file cannot be read.
        ValueError: the file is not an "MlpPolicy" of PPO or SAC.
    """
    if not path.is_file():
        raise FileNotFoundError(2, "there is no such file", str(path))
    try:
        _, weights, _ = load_from_zip_file(path, device="cpu", load_data=False)
        return _from_weights(weights["policy"], _read_normalize(path.with_name(NORMALIZE)), {})
    except (AssertionError, KeyError, ValueError) as error:
        raise ValueError(f"{path} is not an MlpPolicy of Stable-Baselines3's PPO or SAC: {error}") from error


def _read_normalize(path: Path) -> VecNormalize | None:
    import pickle

    if not path.is_file():
        return None
    with path.open("rb") as file:
        normalize: VecNormalize = pickle.load(file)
    return normalize


def _from_weights(weights: Any, normalize: VecNormalize | None, notes: dict[str, Any]) -> MlpPolicy:
    arrays = {name: tensor.detach().cpu().numpy().astype(np.float32) for name, tensor in weights.items()}
    is_sac = "actor.mu.weight" in arrays
    body, head = ("actor.latent_pi", "actor.mu") if is_sac else ("mlp_extractor.policy_net", "action_net")
    layers = []
    for k in range(0, 100, 2):  # torch numbers the modules; every other one is an activation
        if f"{body}.{k}.weight" not in arrays:
            break
        layers.append((arrays[f"{body}.{k}.weight"], arrays[f"{body}.{k}.bias"]))
    layers.append((arrays[f"{head}.weight"], arrays[f"{head}.bias"]))
    mean, scale = _statistics(normalize, layers[0][0].shape[1])
    return MlpPolicy(mean, scale, tuple(layers), "relu" if is_sac else "tanh", is_sac, notes)


def _statistics(normalize: VecNormalize | None, count: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    if normalize is None or not normalize.norm_obs:
        return np.zeros(count, np.float32), np.ones(count, np.float32)
    statistics: Any = normalize.obs_rms
    mean, variance = statistics.mean, statistics.var
    return mean.astype(np.float32), np.sqrt(variance + normalize.epsilon).astype(np.float32)
