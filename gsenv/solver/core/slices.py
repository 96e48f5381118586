"""Slices of arrays inside kernels.

numba lets only a kernel that counts references return an array; ``part`` is inlined before that matters.
"""

from __future__ import annotations

from numba.extending import overload

from ..jit import UNCOUNTED


def part(array, first, count):  # type: ignore[no-untyped-def]
    """Return ``array[first : first + count]``."""
    return array[first : first + count]


@overload(part, inline="always", jit_options=dict.fromkeys(UNCOUNTED, True))
def _part(array, first, count):  # type: ignore[no-untyped-def]
    return lambda array, first, count: array[first : first + count]
