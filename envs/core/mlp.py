"""Trained policies as small numpy files: a multilayer perceptron with its observation normalisation."""

from __future__ import annotations

import errno
import io
import json
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from gsenv.files import write_bytes

Array = NDArray[np.float32]

_CLIP = 10.0  # normalised observations stay within this
_MOST = float(np.finfo(np.float32).max)
MOST_BYTES = 2**28  # that an .npz file or a policy.zip may unpack to; a few of them are bombs
_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # of numpy, torch and Stable-Baselines3
_HEAD = ("activation", "squash", "notes")  # what is written as JSON
_LONGEST = 300  # characters of a reason, some of which quote the file


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
        if not isinstance(self.activation, str) or self.activation not in _ACTIVATIONS:
            raise ValueError(f"activation must be one of {list(_ACTIVATIONS)}, got {self.activation!r}.")
        if not isinstance(self.squash, bool) or not isinstance(self.notes, dict):
            raise ValueError("squash must be True or False, and notes a dict.")
        if not self.layers:
            raise ValueError("there must be at least one layer, got none.")
        _check_numbers("mean", self.mean, 1)
        _check_numbers("scale", self.scale, 1)
        if self.scale.shape != self.mean.shape or not (self.scale > 0.0).all():
            raise ValueError(f"scale must be {len(self.mean)} positive numbers, as many as mean has.")
        width = len(self.mean)
        for k, (weight, bias) in enumerate(self.layers):
            _check_numbers(f"the weight of layer {k}", weight, 2)
            _check_numbers(f"the bias of layer {k}", bias, 1)
            if weight.shape != (len(bias), width):
                raise ValueError(f"layer {k} must have the shape ({len(bias)}, {width}), got {weight.shape}.")
            width = len(bias)
        self._check_range()

    def _check_range(self) -> None:
        """Raise ValueError where some observation could make numbers that float32 does not hold."""
        most = np.full(len(self.mean), _CLIP)
        for k, (weight, bias) in enumerate(self.layers):
            sums = np.abs(weight).astype(np.float64) @ most + np.abs(bias)
            if not (sums < _MOST).all():
                largest = max(float(np.abs(weight).max()), float(np.abs(bias).max()))
                raise ValueError(
                    f"layer {k} has numbers of up to {largest:.2g}, with which its outputs can exceed what float32 "
                    f"holds ({_MOST:.2g}); its actions could be NaN."
                )
            most = np.ones(len(bias)) if self.activation == "tanh" else sums

    @property
    def observation_count(self) -> int:
        return len(self.mean)

    @property
    def action_count(self) -> int:
        return len(self.layers[-1][1])

    def __call__(self, observations: NDArray[Any]) -> Array:
        x = (np.asarray(observations, np.float32) - self.mean) / self.scale
        x = np.clip(x, -_CLIP, _CLIP)
        activate = _ACTIVATIONS[self.activation]
        for weight, bias in self.layers[:-1]:
            x = activate(x @ weight.T + bias)
        weight, bias = self.layers[-1]
        x = x @ weight.T + bias
        return np.tanh(x) if self.squash else np.clip(x, np.float32(-1.0), np.float32(1.0))

    def save(self, file: str | Path | BinaryIO) -> None:
        """Write an .npz file, given by its path or open.

        Raises:
            OSError: it cannot be written; an old file is as it was.
        """
        arrays: dict[str, Any] = {"mean": self.mean, "scale": self.scale}
        for k, (weight, bias) in enumerate(self.layers):
            arrays |= {f"weight_{k}": weight, f"bias_{k}": bias}
        head = {name: getattr(self, name) for name in _HEAD}
        buffer = io.BytesIO()  # numpy would add a suffix to a path
        np.savez_compressed(buffer, head=np.array(json.dumps(head)), **arrays)
        if isinstance(file, (str, Path)):
            write_bytes(Path(file), buffer.getvalue())
        else:
            file.write(buffer.getvalue())

    @classmethod
    def load(cls, file: str | Path | BinaryIO) -> MlpPolicy:
        """Read an .npz file, given by its path or open; nothing in it is run.

        Raises:
            OSError: it cannot be read.
            ValueError: it is no such policy: layers or shapes that do not fit, or numbers that are not finite or too
                large to compute with.
        """
        try:
            arrays = read_arrays(Path(file) if isinstance(file, str) else file)
            head = parse_object(str(arrays.pop("head")), "its head")
            count = sum(name.startswith("weight_") for name in arrays)
            layers = tuple((arrays.pop(f"weight_{k}"), arrays.pop(f"bias_{k}")) for k in range(count))
            mean, scale = arrays.pop("mean"), arrays.pop("scale")
            if arrays:
                raise ValueError(f"it has arrays of other names: {', '.join(sorted(arrays))}.")
            if others := sorted(set(head) - set(_HEAD)):
                raise ValueError(f"its head has other names: {', '.join(others)}.")
            return cls(mean, scale, layers, **head)
        except KeyError as error:
            raise ValueError(f"{file} is not a policy that gsenv has written: it has no {error}.") from error
        except (TypeError, ValueError) as error:
            raise ValueError(f"{file} is not a policy that gsenv has written: {summary(error)}") from error


def read_asset(name: str) -> dict[str, NDArray[Any]]:
    """Return the arrays of an .npz file among the package's assets by name."""
    return read_arrays(io.BytesIO((files("gsenv.assets") / name).read_bytes()))


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays into an .npz file at once; OSError: nothing is written."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]
    write_bytes(path, buffer.getvalue())


def read_arrays(file: Path | BinaryIO) -> dict[str, NDArray[Any]]:
    """Return the arrays of an .npz file by name, without unpickling.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no such file, holds objects, or unpacks to more than 256 MB.
    """
    arrays = {}
    members = read_members(file)
    for name in list(members):
        content = io.BytesIO(members.pop(name))  # so that large files are not held twice
        try:
            arrays[name.removesuffix(".npy")] = np.lib.format.read_array(content, allow_pickle=False)
        except Exception as error:  # numpy raises all kinds of things for a broken file
            raise ValueError(f"its member {name} cannot be read as an array ({summary(error)}).") from error
    return arrays


def read_members(file: Path | BinaryIO) -> dict[str, bytes]:
    """Return the content of a zip archive's members by name.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no archive, it is damaged or cut off, or `check_archive` refuses it.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            check_archive(archive)
            members = {}
            for member in archive.infolist():
                with archive.open(member) as opened:
                    members[member.filename] = opened.read(member.file_size)  # all at once could unpack to far more
            return members
    except ValueError:
        raise
    except Exception as error:  # zipfile and zlib raise all kinds of things for a broken file
        if (
            isinstance(error, OSError) and error.errno != errno.EINVAL
        ):  # which is of a place before the file's beginning
            raise
        raise ValueError(f"it is damaged, cut off or no zip archive ({summary(error)}).") from error


def check_archive(archive: zipfile.ZipFile) -> None:
    """Check what a zip archive says of its members, before any of them is read.

    Raises:
        ValueError: they unpack to more than 256 MB, one is compressed by an unusual method, or the file lacks a part.
    """
    members = archive.infolist()
    size = sum(member.file_size for member in members)
    if size > MOST_BYTES:
        raise ValueError(f"it would unpack to {size / 2**20:.0f} MB.")
    for member in members:
        if member.compress_type not in _COMPRESSIONS:  # of these, others unpack a whole block whatever is asked for
            raise ValueError(f"its member {member.filename} is compressed by another method than deflate.")
    if min((member.header_offset for member in members), default=0) > 0:  # an archive within the file was found instead
        raise ValueError("it is damaged or cut off.")


def parse_object(text: str | bytes, what: str) -> dict[str, Any]:
    """Return the object that a JSON text holds; ValueError, in which it is called `what`, where it holds none."""
    try:
        value = json.loads(text)
    except RecursionError:
        raise ValueError(f"{what} is JSON that is nested too deeply.") from None
    except ValueError as error:
        raise ValueError(f"{what} is no JSON: {error}.") from error
    if not isinstance(value, dict):
        raise ValueError(f"{what} must be a JSON object, got a {type(value).__name__}.")
    return value


def summary(error: Exception) -> str:
    """Return what an error says in one line, shortened where it quotes much; of one that says nothing, its kind."""
    first, *others = str(error).strip().splitlines() or [type(error).__name__]
    line = f"{first} {others[0].strip()}" if others and first.endswith(":") else first  # a list, as torch writes
    return line if len(line) <= _LONGEST else f"{line[:_LONGEST]}..."


def _check_numbers(what: str, array: Any, dimensions: int) -> None:
    """Raise ValueError for anything but a float array of finite numbers."""
    if not isinstance(array, np.ndarray) or not np.issubdtype(array.dtype, np.floating):
        raise ValueError(f"{what} must be an array of floats.")
    if array.ndim != dimensions or array.size == 0:
        raise ValueError(f"{what} must have {dimensions} dimension(s) and not be empty, got the shape {array.shape}.")
    if not np.isfinite(array).all():
        raise ValueError(f"{what} has numbers that are not finite.")
