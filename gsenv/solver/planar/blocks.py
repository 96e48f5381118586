"""Blocks of the sparse factor in 2D, 3 by 3, stored by columns: ``m[j, i]`` is entry (i, j).

Columns are held in local variables. The compiler cannot know that two blocks do not overlap, so it would store each
entry before it reads the next one; of local variables it computes several at once (see deferred_library.py).
"""

from __future__ import annotations

from typing import Any

from ..jit import njit


@njit
def add_outer(block: Any, left: Any, right: Any, scale: Any) -> None:
    """Add scale left right^T to a block; left and right (3,)."""
    m = block.m
    x0 = left[0]
    x1 = left[1]
    x2 = left[2]
    for j in range(3):
        f = scale * right[j]
        m[j, 0] += f * x0
        m[j, 1] += f * x1
        m[j, 2] += f * x2


@njit
def subtract_product(target: Any, left: Any, right: Any) -> None:
    """Subtract left right^T from ``target``, all blocks."""
    m = target.m
    one = left.m
    two = right.m
    for j in range(3):
        x0 = m[j, 0]
        x1 = m[j, 1]
        x2 = m[j, 2]
        for k in range(3):
            f = two[k, j]
            x0 -= f * one[k, 0]
            x1 -= f * one[k, 1]
            x2 -= f * one[k, 2]
        m[j, 0] = x0
        m[j, 1] = x1
        m[j, 2] = x2


@njit
def divide(block: Any, factor: Any) -> None:
    """Set block = block L^-T; ``factor`` has the lower factor L, with 1 / L_jj on the diagonal."""
    m = block.m
    lower = factor.m
    for j in range(3):
        x0 = m[j, 0]
        x1 = m[j, 1]
        x2 = m[j, 2]
        for k in range(j):
            f = lower[k, j]
            x0 -= f * m[k, 0]
            x1 -= f * m[k, 1]
            x2 -= f * m[k, 2]
        f = lower[j, j]  # its inverse
        m[j, 0] = f * x0
        m[j, 1] = f * x1
        m[j, 2] = f * x2


@njit
def subtract_forward(target: Any, block: Any, x: Any) -> None:
    """Subtract block x from ``target``, both (3,)."""
    m = block.m
    y0 = target[0]
    y1 = target[1]
    y2 = target[2]
    for k in range(3):
        f = x[k]
        y0 -= f * m[k, 0]
        y1 -= f * m[k, 1]
        y2 -= f * m[k, 2]
    target[0] = y0
    target[1] = y1
    target[2] = y2
