"""Every vector wrapper of gymnasium over the native vector environments, in the modes it supports.

Each gives what it gives over gymnasium's own vector environment of single ones, bit for bit.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gymnasium import spaces, wrappers
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.wrappers import vector as vector_wrappers

from tests.envs.registered import EACH_TASK, MODES, digest, make_sync, make_vector, random_actions

Wrap = Callable[[Any], Any]
LIMIT = 3
COUNT = 2


def wrapper(name: str) -> Any:
    return getattr(vector_wrappers, name)


def add_one(values: Any) -> Any:
    return np.clip(values + np.float32(1.0), -1e3, 1e3)


def as_dict(env: VectorEnv[Any, Any, Any]) -> Any:
    space = spaces.Dict({"state": env.single_observation_space, "other": spaces.Box(0, 1, (1,))})
    return wrapper("VectorizeTransformObservation")(
        env,
        wrappers.TransformObservation,
        func=lambda observation: {"state": observation, "other": np.zeros(1, np.float32)},
        observation_space=space,
    )


def array_conversion(env: Any) -> Any:
    import torch

    return wrapper("ArrayConversion")(env, env_xp=np, target_xp=torch)


RECIPES: dict[str, Wrap] = {
    "ArrayConversion": array_conversion,
    "ClipAction": lambda env: wrapper("ClipAction")(env),
    "ClipReward": lambda env: wrapper("ClipReward")(env, -0.001, 0.001),
    "DictInfoToList": lambda env: wrapper("DictInfoToList")(env),
    "DtypeObservation": lambda env: wrapper("DtypeObservation")(env, np.float64),
    "FilterObservation": lambda env: wrapper("FilterObservation")(as_dict(env), ["state"]),
    "FlattenObservation": lambda env: wrapper("FlattenObservation")(env),
    "GrayscaleObservation": lambda env: wrapper("GrayscaleObservation")(env, keep_dim=True),
    "HumanRendering": lambda env: wrapper("HumanRendering")(env, (96, 64)),
    "NormalizeObservation": lambda env: wrapper("NormalizeObservation")(env),
    "NormalizeReward": lambda env: wrapper("NormalizeReward")(env),
    "NumpyToTorch": lambda env: wrapper("NumpyToTorch")(env),
    "RecordEpisodeStatistics": lambda env: wrapper("RecordEpisodeStatistics")(env),
    "RescaleAction": lambda env: wrapper("RescaleAction")(env, np.float32(-2.0), np.float32(2.0)),
    "RescaleObservation": lambda env: wrapper("RescaleObservation")(env, np.float32(0.0), np.float32(1.0)),
    "ReshapeObservation": lambda env: wrapper("ReshapeObservation")(env, (1, *env.single_observation_space.shape)),
    "ResizeObservation": lambda env: wrapper("ResizeObservation")(env, (32, 48)),
    "TransformAction": lambda env: wrapper("TransformAction")(env, np.negative),
    "TransformObservation": lambda env: wrapper("TransformObservation")(env, add_one),
    "TransformReward": lambda env: wrapper("TransformReward")(env, add_one),
    "VectorizeTransformAction": lambda env: wrapper("VectorizeTransformAction")(
        env, wrappers.TransformAction, func=np.negative, action_space=env.single_action_space
    ),
    "VectorizeTransformObservation": lambda env: wrapper("VectorizeTransformObservation")(
        env, wrappers.TransformObservation, func=add_one, observation_space=env.single_observation_space
    ),
    "VectorizeTransformReward": lambda env: wrapper("VectorizeTransformReward")(
        env, wrappers.TransformReward, func=add_one
    ),
}
ELSEWHERE = {  # those that this file does not run, and why
    "RecordVideo": "tests/envs/test_recording.py",
    "JaxToNumpy": "for environments whose arrays are JAX's; ours are NumPy's",
    "JaxToTorch": "for environments whose arrays are JAX's; ours are NumPy's",
}
PIXELS = {"GrayscaleObservation", "ResizeObservation"}
OBSERVATION_WRAPPERS = {
    "DtypeObservation", "FilterObservation", "FlattenObservation", "GrayscaleObservation", "NormalizeObservation",
    "RescaleObservation", "ReshapeObservation", "ResizeObservation", "TransformObservation",
    "VectorizeTransformObservation",
}  # fmt: skip
# What the wrapper refuses over gymnasium's own vector environments too.
NO_FINAL_OBS = "it would leave final_obs as it is, or so says VectorObservationWrapper"
UNSUPPORTED: dict[tuple[str, AutoresetMode], str] = {
    **{(name, AutoresetMode.SAME_STEP): NO_FINAL_OBS for name in OBSERVATION_WRAPPERS},
    ("NormalizeObservation", AutoresetMode.DISABLED): "it normalises all worlds at each reset, of whichever",
    ("ArrayConversion", AutoresetMode.SAME_STEP): "it cannot convert final_obs, an array of objects",
    ("NumpyToTorch", AutoresetMode.SAME_STEP): "it cannot convert final_obs, an array of objects",
    ("NumpyToTorch", AutoresetMode.DISABLED): "gymnasium 1.1 cannot convert reset_mask",
}
NEEDED = {  # packages of gymnasium's extras; the extra `test` brings them, older gymnasium needs fewer
    "ArrayConversion": ["torch", "array_api_compat"],
    "HumanRendering": ["pygame", "cv2"],
    "NumpyToTorch": ["torch"],
    "ResizeObservation": ["cv2"],
}


def known_wrappers() -> set[str]:
    public = set(vector_wrappers.__all__)
    loaded = {name for name, value in vars(vector_wrappers).items() if isinstance(value, type)}
    return public | {name for name in loaded if issubclass(getattr(vector_wrappers, name), VectorWrapper)}


PRESENT = sorted(known_wrappers() & set(RECIPES))


def test_no_wrapper_is_forgotten() -> None:
    assert not known_wrappers() - set(RECIPES) - set(ELSEWHERE)
    assert len(PRESENT) > 15


def arguments(name: str) -> dict[str, Any]:
    given: dict[str, Any] = {"max_episode_steps": LIMIT}
    if name in PIXELS:
        given["observation"] = "pixels"
    if name == "HumanRendering":
        given |= {"render_mode": "rgb_array", "width": 96, "height": 64}
    return given


def play(env: Any, mode: AutoresetMode, env_id: str) -> list[Any]:
    """All that comes out, without times and as NumPy."""
    log: list[Any] = [plain(env.reset(seed=3))]
    for actions in random_actions(env_id, 0, 3 * LIMIT, COUNT):
        result = plain(env.step(torch_like(env, actions)))
        log.append(result)
        assert len(result[0]) == COUNT if not isinstance(result[0], dict) else True
        if mode == AutoresetMode.DISABLED:
            ended = np.asarray(result[2]) | np.asarray(result[3])
            if ended.any():
                log.append(plain(env.reset(options={"reset_mask": ended})))
    env.close()
    return log


def torch_like(env: Any, actions: Any) -> Any:
    if type(env).__name__ not in ("NumpyToTorch", "ArrayConversion"):
        return actions
    import torch

    return torch.as_tensor(actions)


def plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items() if key != "t"}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if type(value).__module__ == "torch":
        return value.numpy().copy()
    return value.copy() if isinstance(value, np.ndarray) else value


def masked(value: Any) -> Any:
    """Without what masks hide: there the native environment has zeros, gymnasium's has leftovers."""
    if isinstance(value, list):
        return [masked(item) for item in value]
    if not isinstance(value, dict):
        return value
    shown = {}
    for key, item in value.items():
        mask = value.get(f"_{key}")
        shown[key] = item[np.asarray(mask)] if isinstance(item, np.ndarray) and mask is not None else masked(item)
    return shown


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", PRESENT)
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_wrapper_does_what_it_does_over_single_environments(env_id: str, name: str, mode: AutoresetMode) -> None:
    for package in NEEDED.get(name, []):
        pytest.importorskip(package)

    def outcome(env: Any) -> Any:
        return masked(play(RECIPES[name](env), mode, env_id))

    sync = make_sync(env_id, COUNT, mode, **arguments(name))
    native = make_vector(env_id, COUNT, autoreset_mode=mode, **arguments(name))
    if (name, mode) not in UNSUPPORTED:
        assert digest(outcome(native)) == digest(outcome(sync))
        return
    try:
        expected = digest(outcome(sync))
    except (ValueError, AssertionError, TypeError, BufferError) as error:
        with pytest.raises(type(error), match=re.escape(str(error)[:30])):  # the rest may name addresses
            outcome(native)
    else:  # older versions support some of them
        assert digest(outcome(native)) == expected
