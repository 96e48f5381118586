"""Trained policies as small numpy files: a multilayer perceptron with its observation normalisation."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

_CLIP = 10.0  # normalised observations stay within this


def _relu(x: Array) -> Array:
    return np.maximum(x, np.float32(0.0))


_ACTIVATIONS: dict[str, Callable[[Array], Array]] = {"tanh": np.tanh, "relu": _relu}


@dataclass(frozen=True)
class MlpPolicy:
    """(..., entry) observations to (..., action) actions within [-1, 1]; its mean action, without noise.

    mean, scale: (entry,) of the observations: the net sees (observation - mean) / scale, clipped to 10.
    layers: (weight, bias) each, weight (output, input); `activation` between them.
    squash: tanh at the end instead of a clip.
    notes: how it came about, free text by name.
    """

    mean: Array
    scale: Array
    layers: tuple[tuple[Array, Array], ...]
    activation: str = "tanh"
    squash: bool = False
    notes: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.activation not in _ACTIVATIONS:
            raise ValueError(f"activation must be one of {list(_ACTIVATIONS)}, got {self.activation!r}.")
        width = len(self.mean)
        for k, (weight, bias) in enumerate(self.layers):
            if weight.shape != (len(bias), width):
                raise ValueError(f"layer {k} must have the shape ({len(bias)}, {width}), got {weight.shape}.")
            width = len(bias)

    @property
    def observation_count(self) -> int:
        return len(self.mean)

    def __call__(self, observations: NDArray[Any]) -> Array:
        x = (np.asarray(observations, np.float32) - self.mean) / self.scale
        x = np.clip(x, -_CLIP, _CLIP)
        activate = _ACTIVATIONS[self.activation]
        for weight, bias in self.layers[:-1]:
            x = activate(x @ weight.T + bias)
        weight, bias = self.layers[-1]
        x = x @ weight.T + bias
        return np.tanh(x) if self.squash else np.clip(x, np.float32(-1.0), np.float32(1.0))

    def save(self, file: Path | BinaryIO) -> None:
        """Write an .npz file."""
        arrays: dict[str, Any] = {"mean": self.mean, "scale": self.scale}
        for k, (weight, bias) in enumerate(self.layers):
            arrays |= {f"weight_{k}": weight, f"bias_{k}": bias}
        head = {"activation": self.activation, "squash": self.squash, "notes": self.notes}
        buffer = io.BytesIO()  # numpy would add a suffix to a path
        np.savez_compressed(buffer, head=np.array(json.dumps(head)), **arrays)
        if isinstance(file, Path):
            file.write_bytes(buffer.getvalue())
        else:
            file.write(buffer.getvalue())

    @classmethod
    def load(cls, file: Path | BinaryIO) -> MlpPolicy:
        """Read an .npz file.

        Raises:
            OSError: it cannot be read.
            ValueError: it is no such policy.
        """
        try:
            with np.load(file, allow_pickle=False) as data:
                arrays = {name: data[name] for name in data.files}
            head = json.loads(str(arrays["head"]))
            count = sum(name.startswith("weight_") for name in arrays)
            layers = tuple((arrays[f"weight_{k}"], arrays[f"bias_{k}"]) for k in range(count))
            return cls(arrays["mean"], arrays["scale"], layers, **head)
        except OSError:
            raise
        except Exception as error:  # numpy and zipfile raise all kinds of things for a broken file
            raise ValueError(f"{file} is not a policy that gsenv has written: {error}") from error
