"""Elimination of degrees of freedom from an articulated inertia, half of which is enough."""

from __future__ import annotations

from typing import Any

from ..jit import inline_njit, njit

# lower triangle of a symmetric matrix, row by row
Half = tuple[
    float, float, float, float, float, float, float,
    float, float, float, float, float, float, float,
    float, float, float, float, float, float, float,
]  # fmt: skip
Six = tuple[float, float, float, float, float, float]


@njit
def eliminate_axes(inertia: Any, freedoms: Any, first: Any, last: Any, more: Any) -> None:
    """Set the factor of freedoms[first : last + 1], last one first; if ``more`` follow, remove them."""
    n = _half(inertia)
    for f in range(last, first - 1, -1):
        freedom = freedoms[f]
        s = freedom.motion
        x, y, z, a, b, c = s[0], s[1], s[2], s[3], s[4], s[5]
        h = _product(n, (x, y, z, a, b, c))
        size = freedom.stiffness + freedom.armature
        size += (x * h[0] + y * h[1]) + (z * h[2] + a * h[3]) + (b * h[4] + c * h[5])
        inverse = 1.0 / size if size > 0.0 else 0.0
        freedom.inverse = inverse
        freedom.root = inverse**0.5
        for d in range(6):
            freedom.hold[d] = h[d]
        n = _reduced(n, h, inverse)
    if more:
        _set_half(inertia, n)


@njit
def eliminate_pivot(inertia: Any, freedoms: Any, first: Any) -> None:
    """Do the same for three rotations about the axes of the world, of a pivot or a free link, without products by 0."""
    n = _half(inertia)
    for k in (2, 1, 0):
        s = freedoms[first + k].motion
        x, y, z = s[0], s[1], s[2]
        h = _columns(n, x, y, z, k)
        size = x * h[0] + y * h[1] + z * h[2] + h[3 + k] + freedoms[first + k].stiffness
        freedom = freedoms[first + k]
        inverse = 1.0 / size if size > 0.0 else 0.0
        freedom.inverse = inverse
        freedom.root = inverse**0.5
        for d in range(6):
            freedom.hold[d] = h[d]
        n = _reduced(n, h, inverse)
    _set_half(inertia, n)


@inline_njit
def _half(m: Any) -> Half:
    return (
        m[0, 0], m[1, 0], m[1, 1], m[2, 0], m[2, 1], m[2, 2], m[3, 0], m[3, 1], m[3, 2], m[3, 3],
        m[4, 0], m[4, 1], m[4, 2], m[4, 3], m[4, 4], m[5, 0], m[5, 1], m[5, 2], m[5, 3], m[5, 4], m[5, 5],
    )  # fmt: skip


@inline_njit
def _columns(n: Half, x: float, y: float, z: float, k: int) -> Six:
    """Return the product with (x, y, z) and a unit vector of rotation."""
    if k == 0:
        a, b, c, d, e, f = n[6], n[7], n[8], n[9], n[13], n[18]
    elif k == 1:
        a, b, c, d, e, f = n[10], n[11], n[12], n[13], n[14], n[19]
    else:
        a, b, c, d, e, f = n[15], n[16], n[17], n[18], n[19], n[20]
    return (
        n[0] * x + n[1] * y + n[3] * z + a,
        n[1] * x + n[2] * y + n[4] * z + b,
        n[3] * x + n[4] * y + n[5] * z + c,
        n[6] * x + n[7] * y + n[8] * z + d,
        n[10] * x + n[11] * y + n[12] * z + e,
        n[15] * x + n[16] * y + n[17] * z + f,
    )


@inline_njit
def _product(n: Half, s: Six) -> Six:
    """Return the product with a vector."""
    x, y, z, a, b, c = s
    return (
        (n[0] * x + n[1] * y) + (n[3] * z + n[6] * a) + (n[10] * b + n[15] * c),
        (n[1] * x + n[2] * y) + (n[4] * z + n[7] * a) + (n[11] * b + n[16] * c),
        (n[3] * x + n[4] * y) + (n[5] * z + n[8] * a) + (n[12] * b + n[17] * c),
        (n[6] * x + n[7] * y) + (n[8] * z + n[9] * a) + (n[13] * b + n[18] * c),
        (n[10] * x + n[11] * y) + (n[12] * z + n[13] * a) + (n[14] * b + n[19] * c),
        (n[15] * x + n[16] * y) + (n[17] * z + n[18] * a) + (n[19] * b + n[20] * c),
    )


@inline_njit
def _reduced(n: Half, h: Six, inverse: float) -> Half:
    """Return n - h h / size."""
    a, b, c, d, e, f = h[0] * inverse, h[1] * inverse, h[2] * inverse, h[3] * inverse, h[4] * inverse, h[5] * inverse
    return (
        n[0] - a * h[0],
        n[1] - b * h[0], n[2] - b * h[1],
        n[3] - c * h[0], n[4] - c * h[1], n[5] - c * h[2],
        n[6] - d * h[0], n[7] - d * h[1], n[8] - d * h[2], n[9] - d * h[3],
        n[10] - e * h[0], n[11] - e * h[1], n[12] - e * h[2], n[13] - e * h[3], n[14] - e * h[4],
        n[15] - f * h[0], n[16] - f * h[1], n[17] - f * h[2], n[18] - f * h[3], n[19] - f * h[4], n[20] - f * h[5],
    )  # fmt: skip


@njit
def _set_half(m: Any, n: Half) -> None:
    i = 0
    for d in range(6):
        for e in range(d + 1):
            m[d, e] = n[i]
            i += 1
