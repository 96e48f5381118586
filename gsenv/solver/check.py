"""Checks of what users pass in: one clear sentence naming what and where, before anything changes."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


ALL_BITS = -1  # every bit of an int64


def finite(value: Any, what: str) -> float:
    """A finite float, or ValueError."""
    if isinstance(value, bool):
        raise ValueError(f"{what} must be a number, got {value!r}.")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be a number, got {value!r}.") from None
    if not np.isfinite(number):
        raise ValueError(f"{what} must be finite, got {value!r}.")
    return number


def positive(value: Any, what: str) -> float:
    number = finite(value, what)
    if number <= 0.0:
        raise ValueError(f"{what} must be positive, got {value!r}.")
    return number


def not_negative(value: Any, what: str) -> float:
    number = finite(value, what)
    if number < 0.0:
        raise ValueError(f"{what} must not be negative, got {value!r}.")
    return number


def bound(value: Any, what: str) -> float:
    """Not negative; infinity is allowed."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be a number, got {value!r}.") from None
    if not number >= 0.0:
        raise ValueError(f"{what} must not be negative or NaN, got {value!r}.")
    return number


def vector(value: Any, size: int, what: str) -> Array:
    """A float64 vector of ``size`` finite numbers."""
    try:
        array = np.array(value, np.float64)  # a copy: the caller may go on to change his own
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be {size} numbers, got {value!r}.") from None
    if array.shape != (size,):
        raise ValueError(f"{what} must be {size} numbers, got an array of shape {array.shape}.")
    if not np.isfinite(array).all():
        raise ValueError(f"{what} must be finite, got {value!r}.")
    return array


def values(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """Finite float64 values broadcast to ``shape``."""
    try:
        array = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be numbers, got {value!r}.") from None
    if not np.isfinite(array).all():
        raise ValueError(f"{what} must be finite, got {value!r}.")
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{what} must fit the shape {shape}, got an array of shape {array.shape}.") from None


def vectors(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """The same for vectors: one number does not stand for all three."""
    array = values(value, shape, what)
    if np.shape(value)[-1:] != shape[-1:]:
        raise ValueError(f"{what} must be {shape[-1]} numbers or that for each world, got {value!r}.")
    return array


def bounds(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """float64 values broadcast to ``shape``; infinity is allowed, NaN is not."""
    try:
        array = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be numbers, got {value!r}.") from None
    if np.isnan(array).any():
        raise ValueError(f"{what} must not be NaN, got {value!r}.")
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{what} must fit the shape {shape}, got an array of shape {array.shape}.") from None


def ordered_bounds(lower: Array, upper: Array, where: str) -> None:
    """Refuse bounds of impulses that no finite impulse can keep."""
    if (lower > upper).any():
        raise ValueError(f"{where}: lower must not be above upper.")
    if (lower == np.inf).any() or (upper == -np.inf).any():
        raise ValueError(f"{where}: lower must be below infinity and upper above -infinity.")


def whole(value: Any, least: int, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ValueError(f"{what} must be a whole number of at least {least}, got {value!r}.")
    return int(value)


def choice(value: Any, known: Iterable[str], what: str) -> str:
    """One of ``known``, or ValueError that lists them and the nearest."""
    names = list(known)
    if value in names:
        return str(value)
    near = difflib.get_close_matches(str(value), names, 1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(f"{what} {value!r} is unknown; known are {', '.join(names)}{hint}.")


def worlds(selection: Any, count: int, what: str = "worlds") -> NDArray[np.intp]:
    """Indices of the chosen worlds: None for all, an int, a sequence of ints or a bool mask."""
    if selection is None:
        return np.arange(count)
    array = np.asarray(selection)
    if array.dtype == np.bool_:
        if array.shape != (count,):
            raise ValueError(f"{what}: a mask needs the shape ({count},), got an array of shape {array.shape}.")
        return np.flatnonzero(array)
    array = np.atleast_1d(array)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise ValueError(f"{what} must be world numbers or a bool mask, got {selection!r}.")
    index = array.astype(np.intp)
    if index.size and (index.min() < 0 or index.max() >= count):
        raise ValueError(f"{what} must be from 0 to {count - 1}, got {selection!r}.")
    if len(np.unique(index)) != len(index):
        raise ValueError(f"{what} names a world twice: {selection!r}.")
    return index


def unique(name: Any, taken: Sequence[str] | dict[str, Any], what: str) -> str:
    if not isinstance(name, str) or not name:
        raise ValueError(f"{what} needs a name, got {name!r}.")
    if name in taken:
        raise ValueError(f"{what} {name!r} exists already.")
    return name


def rotation(value: Any, what: str) -> Array:
    """A quaternion (w, x, y, z) that has a direction; it need not be of length 1."""
    numbers = vector(value, 4, what)
    if not np.hypot.reduce(numbers) > 1e-12:
        raise ValueError(f"{what} must be a quaternion (w, x, y, z) other than zero, got {value!r}.")
    return numbers


def inertia(value: Any, what: str) -> Array:
    """(3,) moments or a (3, 3) tensor that a body can have: positive, none above the sum of the others."""
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.shape not in ((3,), (3, 3)) or not np.isfinite(array).all():
        raise ValueError(f"{what} must be three finite moments or a (3, 3) tensor in kg m^2, got {value!r}.")
    if array.ndim == 2 and abs(array - array.T).max() > 1e-9 * abs(array).max():
        raise ValueError(f"{what} must be symmetric, got {value!r}.")
    moments = np.linalg.eigvalsh(array) if array.ndim == 2 else np.sort(array)
    if not moments[0] > 0.0:
        raise ValueError(f"{what} must be positive, got the moment {float(moments[0])!r}.")
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        raise ValueError(
            f"{what}: no body has a moment above the sum of the two others, got {[float(m) for m in moments]}."
        )
    return array
