"""Records as attributes in plain Python (NUMBA_DISABLE_JIT=1), and as bytes."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np


class _Record(np.record):  # type: ignore[misc]
    """Fields as attributes, also those whose names are attributes of np.record (size)."""

    def __getattribute__(self, name: str) -> Any:
        if name in (np.record.__getattribute__(self, "dtype").names or ()):
            return self[name]
        return np.record.__getattribute__(self, name)


def as_records(array: Any) -> Any:
    """Return the array, with NUMBA_DISABLE_JIT=1 with elements whose fields are attributes, as in kernels."""
    if numba.config.DISABLE_JIT and array is not None and array.dtype.names:
        return array.view(np.dtype((_Record, array.dtype)))
    return array


def as_bytes(array: Any) -> Any:
    """Return a view (row, byte) of an array: numpy copies records field by field, which takes six times as long."""
    return array.view(np.uint8).reshape(len(array), array.nbytes // len(array))


def rows(chosen: Any) -> Any:
    """Return indices of worlds (chosen world,) as an index that is fast where it is of one world."""
    return slice(chosen[0], chosen[0] + 1) if len(chosen) == 1 else chosen
