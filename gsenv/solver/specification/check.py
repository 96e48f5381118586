"""Checks of user input: each raises ValueError with one sentence saying what and where, before anything changes."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dimension import PACKAGES
from ..records.text import shown

Array = NDArray[Any]


ALL_BITS = -1  # every bit of an int64
LARGEST = 1e36  # magnitude of a number; squares and products of larger ones may overflow
SMALLEST = 1e-36  # of numbers that must be positive


def finite(value: Any, what: str) -> float:
    """Return a finite float."""
    number = _number(value, what)
    if not np.isfinite(number):
        raise ValueError(f"{what} must be finite, got {shown(value)}.")
    if abs(number) > LARGEST:
        raise ValueError(f"{what} must lie within -{LARGEST:g} and {LARGEST:g}, got {shown(value)}.")
    return number


def _number(value: Any, what: str) -> float:
    dimensions: Any = getattr(value, "ndim", 0)
    if isinstance(value, (bool, np.bool_, str, bytes, list, tuple)) or dimensions:
        raise ValueError(f"{what} must be a number, got {shown(value)}.")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} must be a number, got {shown(value)}.") from None


def _floats(value: Any) -> Array:
    """Return float64 values, a copy; raises TypeError, ValueError or OverflowError for anything but numbers."""
    array = np.asarray(value)
    kind = array.dtype.kind
    if kind not in "uifO" or (kind == "O" and any(isinstance(one, (str, bytes, bool)) for one in array.flat)):
        raise TypeError("no numbers")
    return array.astype(np.float64)


def positive(value: Any, what: str) -> float:
    number = finite(value, what)
    if number <= 0.0:
        raise ValueError(f"{what} must be positive, got {shown(value)}.")
    if number < SMALLEST:
        raise ValueError(f"{what} must be at least {SMALLEST:g}, got {shown(value)}.")
    return number


def not_negative(value: Any, what: str) -> float:
    number = finite(value, what)
    if number < 0.0:
        raise ValueError(f"{what} must not be negative, got {shown(value)}.")
    return number


def bound(value: Any, what: str) -> float:
    """Return a float that is not negative; infinity is allowed."""
    number = _number(value, what)
    if not number >= 0.0:
        raise ValueError(f"{what} must not be negative or NaN, got {shown(value)}.")
    if LARGEST < number < np.inf:
        raise ValueError(f"{what} must not exceed {LARGEST:g} unless it is infinite, got {shown(value)}.")
    return number


def flag(value: Any, what: str) -> bool:
    """Return a truth value."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{what} must be True or False, got {shown(value)}.")
    return bool(value)


def vector(value: Any, size: int, what: str) -> Array:
    """Return a float64 vector of ``size`` finite numbers."""
    try:
        array = _floats(value)  # a copy, since the caller may change the original later
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} must be {size} numbers, got {shown(value)}.") from None
    if array.shape != (size,):
        raise ValueError(f"{what} must be {size} numbers, got an array of shape {array.shape}.")
    _check_range(array, value, what)
    return array


def _check_range(array: Array, value: Any, what: str) -> None:
    """Raise ValueError where an entry is NaN, infinite or too large."""
    if (np.abs(array) <= LARGEST).all():
        return
    if not np.isfinite(array).all():
        raise ValueError(f"{what} must be finite, got {shown(value)}.")
    raise ValueError(f"{what} must lie within -{LARGEST:g} and {LARGEST:g}, got {shown(value)}.")


def values(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """Return finite float64 values broadcast to ``shape``."""
    try:
        array = _floats(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} must be numbers, got {shown(value)}.") from None
    _check_range(array, value, what)
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{what} must fit the shape {shape}, got an array of shape {array.shape}.") from None


def vectors(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """Return finite float64 vectors broadcast to ``shape``; a single number is refused."""
    array = values(value, shape, what)
    if np.shape(value)[-1:] != shape[-1:]:
        raise ValueError(f"{what} must be {shape[-1]} numbers, or as many for each chosen world, got {shown(value)}.")
    return array


def bounds(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """Return float64 values broadcast to ``shape``; infinity is allowed, NaN is not."""
    try:
        array = _floats(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} must be numbers, got {shown(value)}.") from None
    if np.isnan(array).any():
        raise ValueError(f"{what} must not be NaN, got {shown(value)}.")
    if (np.isfinite(array) & (np.abs(array) > LARGEST)).any():
        raise ValueError(f"{what} must lie within -{LARGEST:g} and {LARGEST:g} or be infinite, got {shown(value)}.")
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{what} must fit the shape {shape}, got an array of shape {array.shape}.") from None


def flags(value: Any, shape: tuple[int, ...], what: str) -> Array:
    """Return truth values broadcast to ``shape``; the numbers 0 and 1 count as such."""
    array = np.asarray(value)
    if array.dtype != np.bool_ and not (array.dtype.kind in "uif" and np.isin(array, (0, 1)).all()):
        raise ValueError(f"{what} must be True or False, got {shown(value)}.")
    return values(array.astype(np.float64), shape, what)


def ordered_bounds(lower: Array, upper: Array, where: str) -> None:
    """Raise ValueError for bounds that no finite impulse satisfies."""
    if (lower > upper).any():
        raise ValueError(f"{where}: lower must not be above upper.")
    if (lower == np.inf).any() or (upper == -np.inf).any():
        raise ValueError(f"{where}: lower must be below infinity and upper above -infinity.")


def whole(value: Any, least: int, what: str, most: int | None = None) -> int:
    """Return an int from ``least`` to ``most``."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ValueError(f"{what} must be a whole number of at least {least}, got {shown(value)}.")
    if most is not None and value > most:
        raise ValueError(f"{what} must not exceed {most}, got {shown(value)}.")
    return int(value)


def choice(value: Any, known: Iterable[str], what: str) -> str:
    """Return ``value`` if it is one of ``known``; otherwise the error lists them and the nearest."""
    names = list(known)
    if isinstance(value, str) and value in names:
        return value
    near = difflib.get_close_matches(str(value), names, 1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(f"{what} {shown(value)} is unknown; known are {', '.join(names) or 'none'}{hint}.")


def worlds(selection: Any, count: int, what: str = "worlds") -> NDArray[np.intp]:
    """Return the indices of the chosen worlds: None for all, an int, a sequence of ints or a bool mask."""
    if selection is None:
        return np.arange(count)
    array = np.asarray(selection)
    if array.dtype == np.bool_:
        if array.shape != (count,):
            raise ValueError(f"{what}: a mask needs the shape ({count},), got an array of shape {array.shape}.")
        return np.flatnonzero(array)
    array = np.atleast_1d(array)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise ValueError(f"{what} must be world numbers or a bool mask, got {shown(selection)}.")
    index = array.astype(np.intp)
    if index.size and (index.min() < 0 or index.max() >= count):
        raise ValueError(f"{what} must be from 0 to {count - 1}, got {shown(selection)}.")
    if len(index) > 1 and len(np.unique(index)) != len(index):
        raise ValueError(f"{what} must not name a world twice, got {shown(selection)}.")
    return index


def unique(name: Any, taken: Sequence[str] | dict[str, Any], what: str) -> str:
    if not isinstance(name, str) or not name:
        raise ValueError(f"{what} needs a name, got {shown(name)}.")
    if name in taken:
        raise ValueError(f"{what} {shown(name)} exists already.")
    return name


def numbers(value: Any, what: str) -> Array:
    """Return finite float64 values of any shape, a copy."""
    try:
        array = _floats(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} must be numbers, got {shown(value)}.") from None
    return values(array, array.shape, what)


def bits(mask: Any, what: str) -> int:
    """Return category bits as a signed 64-bit number."""
    if isinstance(mask, bool) or not isinstance(mask, (int, np.integer)) or not -(2**63) <= int(mask) < 2**64:
        raise ValueError(f"{what} must be an integer of 64 bits, got {shown(mask)}.")
    return signed(int(mask))


def signed(mask: int) -> int:
    """Return 64 bits as a signed number."""
    number = mask & (2**64 - 1)
    return number - 2**64 if number >= 2**63 else number


def other_dimension(item: Any, dim: int) -> str:
    """Return the sentence that a shape, joint or sensor does not belong to a scene of ``dim`` dimensions."""
    other = 5 - dim
    return f"a {type(item).__name__} of gsenv.solver.{PACKAGES[other]} has {other} dimensions, the scene {dim}"


def orientation(value: Any, what: str) -> Array:
    """Return a quaternion (w, x, y, z) of any length but 0."""
    quaternion = vector(value, 4, what)
    if not np.hypot.reduce(quaternion) > 1e-12:
        raise ValueError(f"{what} must be a quaternion (w, x, y, z) other than zero, got {shown(value)}.")
    return quaternion


def inertia(value: Any, what: str) -> Array:
    """Return (3,) moments or a (3, 3) tensor; all positive, none above the sum of the others."""
    try:
        array = _floats(value)
    except (TypeError, ValueError, OverflowError):
        array = np.zeros(0)
    if array.shape not in ((3,), (3, 3)) or not (np.abs(array) <= LARGEST).all():
        raise ValueError(f"{what} must be three finite moments or a (3, 3) tensor in kg m^2, got {shown(value)}.")
    if array.ndim == 2 and abs(array - array.T).max() > 1e-9 * abs(array).max():
        raise ValueError(f"{what} must be symmetric, got {shown(value)}.")
    moments = np.linalg.eigvalsh(array) if array.ndim == 2 else np.sort(array)
    if not moments[0] > 0.0:
        raise ValueError(f"{what} must be positive, got the moment {float(moments[0])!r}.")
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        raise ValueError(
            f"{what}: no body has a moment above the sum of the two others, got {[float(m) for m in moments]}."
        )
    return array
