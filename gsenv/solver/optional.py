"""Arguments that a scene may lack, and arguments of kernels that run as plain Python.

``at(array, w)`` is one world's part of an array, or None of an array that the scene lacks: numba types
the result as None then, and compiles nothing behind ``if part is not None``.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import overload

from .jit import UNCOUNTED


def at(array, w):  # type: ignore[no-untyped-def]
    return None if array is None else array[w]


# numba lets only a kernel that counts references return an array; inlined, none is counted
@overload(at, inline="always", jit_options=dict.fromkeys(UNCOUNTED, True))
def _at(array, w):  # type: ignore[no-untyped-def]
    if isinstance(array, types.NoneType):
        return lambda array, w: None
    return lambda array, w: array[w]


class _Record(np.record):  # type: ignore[misc]
    """Fields as attributes, also those that np.record hides behind its own (size)."""

    def __getattribute__(self, name: str) -> Any:
        if name in (np.record.__getattribute__(self, "dtype").names or ()):
            return self[name]
        return np.record.__getattribute__(self, name)


def as_records(array: Any) -> Any:
    """With NUMBA_DISABLE_JIT=1, the array with elements whose fields are attributes, as kernels want."""
    if numba.config.DISABLE_JIT and array is not None and array.dtype.names:
        return array.view(np.dtype((_Record, array.dtype)))
    return array


def is_spatial(rows: Any) -> bool:
    """Whether a numba type of rows is that of three dimensions."""
    return bool(rows.dtype.typeof("jacobian_a").shape[0] == 6)
