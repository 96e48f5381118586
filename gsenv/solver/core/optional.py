"""Arrays that a scene may lack.

``at(array, w)`` is the part of an array that belongs to world ``w``, or None where the array is None: numba
types the result as None then, and compiles nothing behind ``if part is not None``.
"""

from __future__ import annotations

from numba import types
from numba.extending import overload

from ..jit import UNCOUNTED


def at(array, w):  # type: ignore[no-untyped-def]
    return None if array is None else array[w]


# numba lets only a kernel that counts references return an array; inlined, none is counted
@overload(at, inline="always", jit_options=dict.fromkeys(UNCOUNTED, True))
def _at(array, w):  # type: ignore[no-untyped-def]
    if isinstance(array, types.NoneType):
        return lambda array, w: None
    return lambda array, w: array[w]
