"""Conversion of Stable-Baselines3 policies to networks that only need numpy, and files that are safe to read.

Nothing here unpickles: a pickle runs whatever code its writer put into it. Weights are read as tensors, statistics as
arrays.
"""

from __future__ import annotations

import io
import pickle
import re
import shlex
import warnings
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.save_util import recursive_getattr, recursive_setattr
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from gsenv.envs.core.mlp import MlpPolicy, check_archive, parse_object, read_arrays, read_members, summary
from gsenv.files import replacing
from gsenv.solver.jit import say_once
from gsenv.train.checkpoint import NORMALIZE

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

PICKLES = re.compile(r".*norm.*\.(pkl|pickle)", re.IGNORECASE)  # usual names of what SB3's VecNormalize.save writes
STEPS = re.compile(r"(\d+)_steps")  # in the names of files of Stable-Baselines3's CheckpointCallback
ACTIVATIONS = {"torch.nn.modules.activation.Tanh": "tanh", "torch.nn.modules.activation.ReLU": "relu"}
MOST_ENTRIES = 100_000  # of all dicts and lists in one member of a saved model; an optimiser has four per tensor
VARIABLES = ("pytorch_variables", "tensors")  # members of tensors that belong to no state dict; long ago the second


@dataclass(frozen=True)
class _Saved:
    """What is in a zip file of Stable-Baselines3, by name.

    data: what the model says about itself as JSON; the pickles in that stay unread, as text.
    states: state dicts of the policy and the optimisers.
    variables: tensors that belong to none of these.
    """

    data: dict[str, Any]
    states: dict[str, Any]
    variables: dict[str, Any]


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


def save_normalize(statistics: Statistics, path: str | Path) -> None:
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
    saved = _read_zip(path)
    statistics = read_normalize(path.with_name(NORMALIZE))
    steps = _checked_steps(path, saved, statistics, "cannot be continued; policy.npz is whole")
    model.num_timesteps = steps
    try:
        model.set_parameters(saved.states, device="cpu")
        for name, value in saved.variables.items():
            if recursive_getattr(model, name).shape != value.shape:
                raise ValueError(f"{name} has the shape {tuple(value.shape)}.")
            recursive_setattr(model, f"{name}.data", value.data)
    except Exception as error:  # Stable-Baselines3 and torch raise all kinds of things for what is of another network
        raise ValueError(f"{path} does not fit these settings: {summary(error)}") from error


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
    saved = _read_zip(path)
    refuse_pickle(path)
    beside = path.with_name(NORMALIZE)
    statistics = read_normalize(beside) if beside.is_file() else None
    if statistics is not None:
        _checked_steps(path, saved, statistics, "make no policy; convert the pickle of this one's steps")
    weights = saved.states["policy"]
    _refuse_other_actions(path, saved, is_sac="actor.latent_pi.0.weight" in weights)
    strange = [name for name in weights if "features_extractor." in name]  # a CnnPolicy's
    if strange or not ({"action_net.weight", "actor.mu.weight"} & set(weights)):
        raise ValueError(
            f"{path} is not an MlpPolicy of Stable-Baselines3's PPO or SAC, and gsenv reads no others; score it with "
            "stable_baselines3.common.evaluation.evaluate_policy instead."
        )
    try:
        policy = _from_weights(weights, statistics, {}, _activation_of(saved))
    except Exception as error:  # torch raises all kinds of things for strange tensors
        raise ValueError(f"{path} is not an MlpPolicy of PPO or SAC: {summary(error)}") from error
    if statistics is None:
        say_once(
            f"normalisation of {path.resolve()}",
            f"gsenv: {path} has no {NORMALIZE} beside it, so observations are passed to it as they are; if it was "
            "trained with VecNormalize, docs/clients.md shows how to write that file",
        )
    return policy


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


def _read_zip(path: Path) -> _Saved:
    """Return what a saved model holds; the pickles in it are not read.

    Raises:
        OSError: it cannot be read.
        ValueError: it is damaged, too large, or not what Stable-Baselines3 writes.
    """
    if not path.is_file():
        raise FileNotFoundError(2, "there is no such file", str(path))
    refused = f"{path} is not an MlpPolicy of Stable-Baselines3's PPO or SAC"
    try:
        members = read_members(path)
        for name in ("data", "policy.pth"):
            if name not in members:
                raise ValueError(f"it has no member {name}.")
        data = parse_object(members["data"], "its member data")
        tensors = {
            name.removesuffix(".pth"): _tensors_of(name, content)
            for name, content in members.items()
            if name.endswith(".pth")
        }
    except OSError:
        raise
    except pickle.UnpicklingError as error:  # of torch, for anything but tensors
        raise ValueError(
            f"{refused}: where such a file has tensors it has pickled objects, which gsenv does not read because they "
            "can run any code."
        ) from error
    except Exception as error:  # torch raises all kinds of things for strange tensors
        raise ValueError(f"{refused}: {summary(error)}") from error
    variables = [tensors.pop(name) for name in VARIABLES if name in tensors]
    return _Saved(data, tensors, variables[0] if variables else {})


def _tensors_of(name: str, content: bytes) -> dict[str, Any]:
    """Return what torch has written into a member of a saved model: a dict of tensors, or of dicts with tensors.

    Raises:
        UnpicklingError: it has objects other than tensors, numbers and texts.
        ValueError: it cannot be read, is something else, or `_check_tensor` refuses one of the tensors.
    """
    try:
        if zipfile.is_zipfile(io.BytesIO(content)):  # an archive within the archive, which torch unpacks
            with zipfile.ZipFile(io.BytesIO(content)) as archive:
                check_archive(archive)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # torch's, about formats that it may refuse next
            state = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except pickle.UnpicklingError:
        raise
    except Exception as error:  # torch raises all kinds of things for a broken file
        raise ValueError(f"its member {name} holds no tensors that can be read ({summary(error)}).") from error
    if not isinstance(state, dict) or not all(isinstance(key, str) for key in state):
        raise ValueError(f"its member {name} must hold a dict by names, and holds something else.")
    pending: list[Any] = [state]
    count = 0
    while pending:
        value = pending.pop()
        if isinstance(value, torch.Tensor):
            _check_tensor(name, value)
        elif isinstance(value, (dict, list, tuple)):
            count += len(value)
            if count > MOST_ENTRIES:  # a small file can hold one list a million times, or one that holds itself
                raise ValueError(f"its member {name} has more than {MOST_ENTRIES} entries.")
            pending.extend(value.values() if isinstance(value, dict) else value)
    return state


def _check_tensor(member: str, tensor: torch.Tensor) -> None:
    """Raise ValueError for a tensor of anything but real numbers, all of which are in the file."""
    if tensor.layout != torch.strided or tensor.device.type != "cpu" or tensor.is_complex() or tensor.is_quantized:
        kind = f"{tensor.dtype}, {tensor.layout}, {tensor.device}"
        raise ValueError(f"its member {member} has a tensor that is no plain array of real numbers ({kind}).")
    if tensor.numel() * tensor.element_size() > tensor.untyped_storage().nbytes():
        raise ValueError(f"its member {member} has too few numbers for a tensor of the shape {tuple(tensor.shape)}.")


def _checked_steps(path: Path, saved: _Saved, statistics: Statistics, what: str) -> int:
    """Return the steps of a normalisation; ValueError where the zip beside it is of others, so that the two `what`."""
    steps = int(statistics.steps)
    trained = saved.data.get("num_timesteps")
    if steps and isinstance(trained, int) and trained != steps:  # 0: `statistics_of` was not told
        raise ValueError(
            f"{path} is of {trained} steps and {NORMALIZE} beside it of {steps}, so they are of two checkpoints and "
            f"{what}."
        )
    return steps


def _refuse_other_actions(path: Path, saved: _Saved, is_sac: bool) -> None:
    """Raise ValueError where a saved model makes actions of its network's output in a way that gsenv's policies do not.

    The mean action of PPO with gSDE (`use_sde`) is that without; SAC's is clipped before its tanh.
    """
    arguments = _policy_arguments(saved)
    if is_sac and (saved.data.get("use_sde") or arguments.get("use_sde")):
        raise ValueError(f"{path} is of SAC with gSDE (use_sde=True), whose mean actions gsenv cannot compute.")
    if not is_sac and arguments.get("squash_output"):
        raise ValueError(f"{path} has squash_output=True, and gsenv squashes the actions of SAC alone.")


def _policy_arguments(saved: _Saved) -> dict[str, Any]:
    """Return the `policy_kwargs` of a saved model."""
    arguments = saved.data.get("policy_kwargs")
    return arguments if isinstance(arguments, dict) else {}


def _activation_of(saved: _Saved) -> str | None:
    """Return "tanh" or "relu" where the policy was made with an `activation_fn`; None: the algorithm's own.

    Raises:
        ValueError: another function.
    """
    written = _policy_arguments(saved).get("activation_fn")
    if written is None:
        return None
    return _known_activation(str(written).removeprefix("<class '").removesuffix("'>"))


def _known_activation(name: str) -> str:
    """Return "tanh" or "relu" for the full name of a class of torch; raises ValueError for another one."""
    if name not in ACTIVATIONS:
        raise ValueError(f"its activation function is {name}, and gsenv's policies have Tanh or ReLU.")
    return ACTIVATIONS[name]


def _from_weights(
    weights: dict[str, Any], statistics: Statistics | None, notes: dict[str, Any], activation: str | None
) -> MlpPolicy:
    is_sac = "actor.mu.weight" in weights
    body, head = ("actor.latent_pi", "actor.mu") if is_sac else ("mlp_extractor.policy_net", "action_net")
    modules = []
    for k in range(0, 100, 2):  # torch numbers the modules; every other one is an activation
        if f"{body}.{k}.weight" not in weights:
            break
        modules.append(f"{body}.{k}")
    modules.append(head)
    layers = tuple((_array(weights, f"{name}.weight"), _array(weights, f"{name}.bias")) for name in modules)
    count = np.atleast_2d(layers[0][0]).shape[1]
    mean, scale = np.zeros(count, np.float32), np.ones(count, np.float32)
    if statistics is not None:
        mean, scale = statistics.observation_mean.astype(np.float32), statistics.scale.astype(np.float32)
        critic = weights.get("mlp_extractor.value_net.0.weight")
        if critic is not None and critic.shape[1] == len(mean):  # what follows the policy's entries is the critic's
            mean, scale = mean[:count], scale[:count]
    return MlpPolicy(mean, scale, layers, activation or ("relu" if is_sac else "tanh"), is_sac, notes)


def _array(weights: dict[str, Any], name: str) -> NDArray[np.float32]:
    """Return a copy of a tensor; ValueError where there is none, or it is not of floats."""
    tensor = weights.get(name)
    if not isinstance(tensor, torch.Tensor) or not tensor.is_floating_point():
        raise ValueError(f"it has no tensor of floats called {name}.")
    return tensor.detach().to("cpu", torch.float32).numpy().copy()
