from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.envs.core.mlp import MlpPolicy


def make(activation: str = "tanh", squash: bool = False) -> MlpPolicy:
    generator = np.random.default_rng(0)

    def normal(*shape: int) -> NDArray[np.float32]:
        return generator.standard_normal(shape).astype(np.float32)

    layers = ((normal(5, 3), normal(5)), (normal(2, 5), normal(2)))
    return MlpPolicy(normal(3), np.float32(0.5) + normal(3) ** 2, layers, activation, squash, {"seed": 1})


@pytest.mark.parametrize("activation", ["tanh", "relu"])
@pytest.mark.parametrize("squash", [False, True])
def test_is_the_net_that_it_says(activation: str, squash: bool) -> None:
    policy = make(activation, squash)
    x = np.array([0.1, -2.0, 3.0])
    hidden = policy.layers[0][0] @ np.clip((x - policy.mean) / policy.scale, -10, 10) + policy.layers[0][1]
    hidden = np.tanh(hidden) if activation == "tanh" else np.maximum(hidden, 0)
    out = policy.layers[1][0] @ hidden + policy.layers[1][1]
    expected = np.tanh(out) if squash else np.clip(out, -1, 1)
    np.testing.assert_allclose(policy(x), expected, rtol=1e-5)
    np.testing.assert_allclose(policy(np.stack([x, x]))[1], expected, rtol=1e-5)
    assert policy(x).dtype == np.float32


def test_far_observations_are_clipped() -> None:
    policy = make()
    np.testing.assert_array_equal(policy(np.full(3, 1e9)), policy(np.full(3, 1e6)))


def test_saves_and_loads_and_the_file_is_always_the_same(tmp_path: Path) -> None:
    policy = make("relu", True)
    policy.save(tmp_path / "policy.npz")
    loaded = MlpPolicy.load(tmp_path / "policy.npz")
    x = np.random.default_rng(1).standard_normal((4, 3))
    np.testing.assert_array_equal(loaded(x), policy(x))
    assert loaded.notes == {"seed": 1}
    buffer = io.BytesIO()
    policy.save(buffer)
    assert buffer.getvalue() == (tmp_path / "policy.npz").read_bytes()
    policy.save(str(tmp_path / "other.npz"))
    assert (tmp_path / "other.npz").read_bytes() == buffer.getvalue()
    np.testing.assert_array_equal(MlpPolicy.load(str(tmp_path / "other.npz"))(x), policy(x))


def test_broken_files_are_refused(tmp_path: Path) -> None:
    for name, content in (("text", b"nothing"), ("empty", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match=f"{name} is not a policy"):
            MlpPolicy.load(tmp_path / name)
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(ValueError, match="is not a policy"):
        MlpPolicy.load(tmp_path / "other.npz")
    with pytest.raises(OSError, match="missing"):
        MlpPolicy.load(tmp_path / "missing")


def test_layers_must_fit() -> None:
    policy = make()
    with pytest.raises(ValueError, match="layer 1 must have the shape"):
        MlpPolicy(policy.mean, policy.scale, (policy.layers[0], policy.layers[0]))
    with pytest.raises(ValueError, match="activation must be one of"):
        MlpPolicy(policy.mean, policy.scale, policy.layers, "gelu")


@pytest.mark.parametrize("activation", ["tanh", "relu"])
def test_weights_that_overflow_are_refused(activation: str, tmp_path: Path) -> None:
    policy = make(activation)
    huge = np.full_like(policy.layers[0][0], 3e38)
    arrays = {"mean": policy.mean, "scale": policy.scale, "weight_0": huge, "bias_0": policy.layers[0][1]}
    arrays |= {"weight_1": policy.layers[1][0], "bias_1": policy.layers[1][1]}
    head = json.dumps({"activation": activation, "squash": False, "notes": {}})
    np.savez(tmp_path / "huge.npz", allow_pickle=False, head=np.array(head), **arrays)
    with pytest.raises(ValueError, match=r"huge\.npz is not .*layer 0 has numbers of up to 3e\+38") as caught:
        MlpPolicy.load(tmp_path / "huge.npz")
    assert str(caught.value).count(". ") == 0  # one sentence
    assert str(caught.value).endswith("its actions could be NaN.")  # the bound does not show that they are


def test_overflow_over_several_layers_is_refused_only_where_it_can_happen() -> None:
    policy = make("relu")
    large = tuple((np.float32(1e15) * np.abs(weight), bias) for weight, bias in policy.layers)
    wide = MlpPolicy(policy.mean, policy.scale, large, "relu")
    assert np.isfinite(wide(np.full(3, 1e30))).all()
    larger = tuple((np.float32(1e20) * np.abs(weight), bias) for weight, bias in policy.layers)
    with pytest.raises(ValueError, match="layer 1 has numbers"):
        MlpPolicy(policy.mean, policy.scale, larger, "relu")
    bounded = MlpPolicy(policy.mean, policy.scale, larger, "tanh")  # whose hidden layer ends at 1
    assert np.isfinite(bounded(np.full(3, -1e30))).all()
