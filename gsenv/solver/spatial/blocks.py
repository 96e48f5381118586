"""Blocks of the sparse factor in 3D, 6 by 6, stored by columns: ``m[j, i]`` is entry (i, j).

Columns are held in local variables. The compiler cannot know that two blocks do not overlap, so it would store each
entry before it reads the next one; of local variables it computes several at once (see deferred_library.py).
"""

from __future__ import annotations

from typing import Any

from ..jit import njit


@njit
def add_outer(block: Any, left: Any, right: Any, scale: Any) -> None:
    """Add scale left right^T to a block; left and right (6,)."""
    m = block.m
    x0 = left[0]
    x1 = left[1]
    x2 = left[2]
    x3 = left[3]
    x4 = left[4]
    x5 = left[5]
    for j in range(6):
        f = scale * right[j]
        m[j, 0] += f * x0
        m[j, 1] += f * x1
        m[j, 2] += f * x2
        m[j, 3] += f * x3
        m[j, 4] += f * x4
        m[j, 5] += f * x5


@njit
def subtract_product(target: Any, left: Any, right: Any) -> None:
    """Subtract left right^T from ``target``, all blocks."""
    m = target.m
    one = left.m
    two = right.m
    for j in range(6):
        x0 = m[j, 0]
        x1 = m[j, 1]
        x2 = m[j, 2]
        x3 = m[j, 3]
        x4 = m[j, 4]
        x5 = m[j, 5]
        for k in range(6):
            f = two[k, j]
            x0 -= f * one[k, 0]
            x1 -= f * one[k, 1]
            x2 -= f * one[k, 2]
            x3 -= f * one[k, 3]
            x4 -= f * one[k, 4]
            x5 -= f * one[k, 5]
        m[j, 0] = x0
        m[j, 1] = x1
        m[j, 2] = x2
        m[j, 3] = x3
        m[j, 4] = x4
        m[j, 5] = x5


@njit
def divide(block: Any, factor: Any) -> None:
    """Set block = block L^-T; ``factor`` has the lower factor L, with 1 / L_jj on the diagonal."""
    m = block.m
    lower = factor.m
    for j in range(6):
        x0 = m[j, 0]
        x1 = m[j, 1]
        x2 = m[j, 2]
        x3 = m[j, 3]
        x4 = m[j, 4]
        x5 = m[j, 5]
        for k in range(j):
            f = lower[k, j]
            x0 -= f * m[k, 0]
            x1 -= f * m[k, 1]
            x2 -= f * m[k, 2]
            x3 -= f * m[k, 3]
            x4 -= f * m[k, 4]
            x5 -= f * m[k, 5]
        f = lower[j, j]  # its inverse
        m[j, 0] = f * x0
        m[j, 1] = f * x1
        m[j, 2] = f * x2
        m[j, 3] = f * x3
        m[j, 4] = f * x4
        m[j, 5] = f * x5


@njit
def subtract_forward(target: Any, block: Any, x: Any) -> None:
    """Subtract block x from ``target``, both (6,)."""
    m = block.m
    y0 = target[0]
    y1 = target[1]
    y2 = target[2]
    y3 = target[3]
    y4 = target[4]
    y5 = target[5]
    for k in range(6):
        f = x[k]
        y0 -= f * m[k, 0]
        y1 -= f * m[k, 1]
        y2 -= f * m[k, 2]
        y3 -= f * m[k, 3]
        y4 -= f * m[k, 4]
        y5 -= f * m[k, 5]
    target[0] = y0
    target[1] = y1
    target[2] = y2
    target[3] = y3
    target[4] = y4
    target[5] = y5
