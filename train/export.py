"""Conversion of Stable-Baselines3 policies to networks that only need numpy, and files that are safe to read.

Nothing here unpickles: a pickle runs whatever code its writer put into it. Weights are read as tensors, statistics as
arrays.
"""

from __future__ import annotations

import json
import pickle
import re
import shlex
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.save_util import load_from_zip_file, recursive_setattr
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from gsenv.envs.core.mlp import MlpPolicy, read_arrays
from gsenv.files import replacing
from gsenv.train.checkpoint import NORMALIZE

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

PICKLES = re.compile(r".*norm.*\.(pkl|pickle)", re.IGNORECASE)  # usual names of what SB3's VecNormalize.save writes
STEPS = re.compile(r"(\d+)_steps")  # in the names of files of Stable-Baselines3's CheckpointCallback
ACTIVATIONS = {"torch.nn.modules.activation.Tanh": "tanh", "torch.nn.modules.activation.ReLU": "relu"}

_BROKEN = (AssertionError, AttributeError, EOFError, IndexError, KeyError, RuntimeError, TypeError, ValueError)


@dataclass(frozen=True)
class Statistics:
    """What a VecNormalize has learnt: running moments of the observations (entry,) and of the return ().

    `steps` is the number of environment steps of the model beside it.
    """

    observation_mean: NDArray[np.float64]
    observation_variance: NDArray[np.float64]
    observation_count: NDArray[np.float64]
    return_mean: NDArray[np.float64]
    return_variance: NDArray[np.float64]
    return_count: NDArray[np.float64]
    epsilon: NDArray[np.float64]
    steps: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name, array in asdict(self).items():
            if not np.issubdtype(array.dtype, np.number) or not np.isfinite(array).all():
                raise ValueError(f"{name} must be finite numbers.")
            vector = name in ("observation_mean", "observation_variance")
            if array.shape != (self.observation_mean.shape if vector else ()) or (vector and array.ndim != 1):
                raise ValueError(f"{name} has the wrong shape {array.shape}.")
            if not name.endswith("mean") and array.min(initial=0.0) < 0.0:
                raise ValueError(f"{name} must not be negative.")

    @property
    def scale(self) -> NDArray[np.float64]:
        """(entry,), what observations are divided by."""
        return np.sqrt(self.observation_variance + self.epsilon)


def statistics_of(normalize: VecNormalize, steps: int = 0) -> Statistics:
    """Return what a VecNormalize of Box observations has learnt."""
    seen: Any = normalize.obs_rms
    gained = normalize.ret_rms
    values = (
        *((seen.mean, seen.var, seen.count) if normalize.norm_obs else _unit(normalize)),
        gained.mean, gained.var, gained.count, normalize.epsilon if normalize.norm_obs else 0.0, steps,
    )  # fmt: skip
    return Statistics(*(np.array(value, np.float64) for value in values))


def _unit(normalize: VecNormalize) -> tuple[Any, Any, float]:
    shape = normalize.observation_space.shape
    assert shape is not None
    return np.zeros(shape), np.ones(shape), 1.0


def save_normalize(statistics: Statistics, path: Path) -> None:
    """Write normalize.npz."""
    with replacing(path) as partial:
        np.savez(partial, **asdict(statistics))


def read_normalize(path: Path) -> Statistics:
    """Read normalize.npz.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no such file.
    """
    try:
        return Statistics(**read_arrays(path))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path} holds no statistics that gsenv has written: {error}") from error


def load_normalize(path: Path, envs: VecEnv, **arguments: Any) -> VecNormalize:
    """Return a VecNormalize with the statistics of normalize.npz; `arguments` are those of VecNormalize.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is no such file, or it does not fit the environment.
    """
    statistics = read_normalize(path)
    if statistics.observation_mean.shape != envs.observation_space.shape:
        raise ValueError(
            f"{path} is for {len(statistics.observation_mean)} observations, not {envs.observation_space.shape}."
        )
    normalize = VecNormalize(envs, **arguments)
    seen: Any = normalize.obs_rms
    seen.mean, seen.var = statistics.observation_mean, statistics.observation_variance
    seen.count = float(statistics.observation_count)
    gained = normalize.ret_rms
    gained.mean, gained.var = statistics.return_mean, statistics.return_variance
    gained.count = float(statistics.return_count)
    return normalize


def restore(model: BaseAlgorithm, path: Path) -> None:
    """Set weights, optimiser states and steps of a model to those of policy.zip and of normalize.npz beside it.

    Its settings stay as they are.

    Raises:
        OSError: a file cannot be read.
        ValueError: it is of another network or algorithm, or the two are of different checkpoints.
    """
    weights, variables = _read_zip(path)
    steps = _checked_steps(path, read_normalize(path.with_name(NORMALIZE)), "cannot be continued; policy.npz is whole")
    model.num_timesteps = steps
    try:
        model.set_parameters(weights, device="cpu")
        for name, value in variables.items():
            recursive_setattr(model, f"{name}.data", value.data)
    except _BROKEN as error:
        raise ValueError(f"{path} does not fit these settings: {_first_line(error)}") from error


def export(model: BaseAlgorithm, normalize: VecNormalize | None, notes: dict[str, Any] | None = None) -> MlpPolicy:
    """Return the mean-action network of a PPO or SAC "MlpPolicy", including its observation normalisation."""
    statistics = None if normalize is None else statistics_of(normalize)
    function: Any = model.policy.activation_fn
    activation = _known_activation(f"{function.__module__}.{function.__qualname__}")
    return _from_weights(model.policy.state_dict(), statistics, notes or {}, activation)


def load_zip(path: Path) -> MlpPolicy:
    """Return the network of a saved model, with the normalisation of normalize.npz if that is in the same folder.

    Raises:
        OSError: a file cannot be read.
        ValueError: the file is not an "MlpPolicy" of PPO or SAC, or acts in a way that gsenv's policies do not, or its
            normalisation is a pickle, which is not read, or that of another checkpoint.
    """
    weights, _ = _read_zip(path)
    refuse_pickle(path)
    beside = path.with_name(NORMALIZE)
    statistics = read_normalize(beside) if beside.is_file() else None
    if statistics is not None:
        _checked_steps(path, statistics, "make no policy; convert the pickle of this one's steps")
    policy = dict(weights.get("policy", {}))
    _refuse_other_actions(path, is_sac="actor.latent_pi.0.weight" in policy)
    strange = [name for name in policy if "features_extractor." in name]  # a CnnPolicy's
    if strange or not ({"action_net.weight", "actor.mu.weight"} & set(policy)):
        raise ValueError(
            f"{path} is not an MlpPolicy of Stable-Baselines3's PPO or SAC, and gsenv reads no others; score it with "
            "stable_baselines3.common.evaluation.evaluate_policy instead."
        )
    try:
        return _from_weights(policy, statistics, {}, _activation_of_zip(path))
    except _BROKEN as error:
        raise ValueError(f"{path} is not an MlpPolicy of PPO or SAC: {_first_line(error)}") from error


def refuse_pickle(policy: Path) -> None:
    """Raise ValueError where a folder has the normalisation of a policy only as a pickle, which could run any code."""
    found = _pickles_of(policy)
    if not found or policy.with_name(NORMALIZE).is_file():
        return
    if len(found) == 1:
        what, which, file = f"{found[0]} is a pickle", "it", shlex.quote(str(found[0]))
        otherwise = "if it is not of this policy, move it away"
    else:
        names = ", ".join(path.name for path in found)
        what, which, file = f"{policy.parent} has {len(found)} pickles ({names})", "the one of this policy", "FILE"
        otherwise = "if none is of this policy, move them away"
    raise ValueError(
        f"{what}, which gsenv does not read because a pickle can run any code: if you trust {which}, run `python -c "
        f'"import sys; from gsenv.train.export import convert_pickle; convert_pickle(sys.argv[1])" {file}` once, '
        f"which writes {NORMALIZE} beside it; {otherwise}."
    )


def _pickles_of(policy: Path) -> list[Path]:
    """Return the normalisations beside a policy: those of its number of steps if names tell of one, else all."""
    beside = policy.parent.iterdir() if policy.parent.is_dir() else ()
    found = sorted(path for path in beside if PICKLES.fullmatch(path.name))
    trained = _steps_in(policy)
    return [path for path in found if trained is not None and _steps_in(path) == trained] or found


def _steps_in(path: Path) -> int | None:
    """Return the number of steps in the name of a checkpoint, such as rl_model_10000_steps.zip."""
    match = STEPS.search(path.name)
    return int(match[1]) if match else None


def convert_pickle(file: str | Path) -> Path:
    """Write normalize.npz beside a trusted file of Stable-Baselines3's VecNormalize.save, and return its path.

    This runs whatever code is in the file; nothing else in gsenv calls it.

    Raises:
        OSError: a file cannot be read or written.
        TypeError: it holds something else.
    """
    with open(file, "rb") as opened:
        normalize = pickle.load(opened)
    if not isinstance(normalize, VecNormalize):
        raise TypeError(f"{file} holds a {type(normalize).__name__}, not a VecNormalize.")
    path = Path(file).with_name(NORMALIZE)
    save_normalize(statistics_of(normalize, _steps_in(Path(file)) or 0), path)
    return path


def _read_zip(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the state dicts and the variables of a saved model; the pickles in it are not read."""
    if not path.is_file():
        raise FileNotFoundError(2, "there is no such file", str(path))
    try:
        _, weights, variables = load_from_zip_file(path, device="cpu", load_data=False)
    except pickle.UnpicklingError as error:  # of torch, for anything but tensors
        raise ValueError(
            f"{path} is not an MlpPolicy of Stable-Baselines3's PPO or SAC: where such a file has tensors it has "
            "pickled objects, which gsenv does not read because they can run any code."
        ) from error
    except _BROKEN as error:
        raise ValueError(
            f"{path} is not an MlpPolicy of Stable-Baselines3's PPO or SAC: {_first_line(error)}"
        ) from error
    return dict(weights), dict(variables or {})


def _data_of_zip(path: Path) -> dict[str, Any]:
    """Return what a saved model says about itself as JSON; the pickles in that stay unread, as text."""
    try:
        with zipfile.ZipFile(path) as archive:
            data = json.loads(archive.read("data"))
    except (KeyError, ValueError):
        return {}
    return data if isinstance(data, dict) else {}


def _checked_steps(path: Path, statistics: Statistics, what: str) -> int:
    """Return the steps of a normalisation; ValueError where the zip beside it is of others, so that the two `what`."""
    steps = int(statistics.steps)
    trained = _steps_of_zip(path)
    if steps and trained not in (None, steps):  # 0: `statistics_of` was not told
        raise ValueError(
            f"{path} is of {trained} steps and {NORMALIZE} beside it of {steps}, so they are of two checkpoints and "
            f"{what}."
        )
    return steps


def _steps_of_zip(path: Path) -> int | None:
    """Return how many steps a saved model has trained, or None if the file does not say."""
    steps = _data_of_zip(path).get("num_timesteps")
    return steps if isinstance(steps, int) else None


def _refuse_other_actions(path: Path, is_sac: bool) -> None:
    """Raise ValueError where a saved model makes actions of its network's output in a way that gsenv's policies do not.

    The mean action of PPO with gSDE (`use_sde`) is that without; SAC's is clipped before its tanh.
    """
    data = _data_of_zip(path)
    arguments = data.get("policy_kwargs")
    arguments = arguments if isinstance(arguments, dict) else {}
    if is_sac and (data.get("use_sde") or arguments.get("use_sde")):
        raise ValueError(f"{path} is of SAC with gSDE (use_sde=True), whose mean actions gsenv cannot compute.")
    if not is_sac and arguments.get("squash_output"):
        raise ValueError(f"{path} has squash_output=True, and gsenv squashes the actions of SAC alone.")


def _activation_of_zip(path: Path) -> str | None:
    """Return "tanh" or "relu" where the policy was made with an `activation_fn`; None: the algorithm's own.

    Raises:
        ValueError: another function.
    """
    arguments = _data_of_zip(path).get("policy_kwargs")
    written = arguments.get("activation_fn") if isinstance(arguments, dict) else None
    if written is None:
        return None
    return _known_activation(str(written).removeprefix("<class '").removesuffix("'>"))


def _known_activation(name: str) -> str:
    """Return "tanh" or "relu" for the full name of a class of torch; raises ValueError for another one."""
    if name not in ACTIVATIONS:
        raise ValueError(f"its activation function is {name}, and gsenv's policies have Tanh or ReLU.")
    return ACTIVATIONS[name]


def _first_line(error: BaseException) -> str:
    return str(error).strip().partition("\n")[0]


def _from_weights(
    weights: Any, statistics: Statistics | None, notes: dict[str, Any], activation: str | None
) -> MlpPolicy:
    arrays = {name: tensor.detach().cpu().numpy().astype(np.float32) for name, tensor in weights.items()}
    is_sac = "actor.mu.weight" in arrays
    body, head = ("actor.latent_pi", "actor.mu") if is_sac else ("mlp_extractor.policy_net", "action_net")
    layers = []
    for k in range(0, 100, 2):  # torch numbers the modules; every other one is an activation
        if f"{body}.{k}.weight" not in arrays:
            break
        layers.append((arrays[f"{body}.{k}.weight"], arrays[f"{body}.{k}.bias"]))
    layers.append((arrays[f"{head}.weight"], arrays[f"{head}.bias"]))
    count = layers[0][0].shape[1]
    mean, scale = np.zeros(count, np.float32), np.ones(count, np.float32)
    if statistics is not None:
        mean, scale = statistics.observation_mean.astype(np.float32), statistics.scale.astype(np.float32)
        critic = arrays.get("mlp_extractor.value_net.0.weight")
        if critic is not None and critic.shape[1] == len(mean):  # what follows the policy's entries is the critic's
            mean, scale = mean[:count], scale[:count]
    return MlpPolicy(mean, scale, tuple(layers), activation or ("relu" if is_sac else "tanh"), is_sac, notes)
