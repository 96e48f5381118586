"""``at(array, w)``: one world's part of an array, or None of an array that the scene lacks.

Numba types the result as None then, and compiles nothing behind ``if part is not None``.
"""

from __future__ import annotations


from numba import types
from numba.extending import overload


def at(array, w):  # type: ignore[no-untyped-def]
    return None if array is None else array[w]


@overload(at, inline="always")
def _at(array, w):  # type: ignore[no-untyped-def]
    if isinstance(array, types.NoneType):
        return lambda array, w: None
    return lambda array, w: array[w]
