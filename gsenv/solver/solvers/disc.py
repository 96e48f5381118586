"""The two tangents of a contact in space, solved as one block on Coulomb's disc.

With A the 2x2 block of J M^-1 J^T and g what the rows lack, the impulse minimises t.A t/2 + g.t on
|t| <= R.  Outside of the disc it is t = -(A + s I)^-1 g with |t| = R; s > 0 by Newton's method on
1/|t(s)| - 1/R, which is nearly linear in s (More, Sorensen, "Computing a trust region step", SIAM J.
Sci. Stat. Comput. 4 (1983)).  So a slide opposes the slip whatever its direction in the plane.
"""

from __future__ import annotations

from typing import Any

from numba.extending import overload

from ..jit import njit
from ..optional import is_spatial
from ..rows import apply_impulse, push_row, relative_velocity

NEWTON_STEPS = 12
TINY = 1e-140  # N s and m/s
ROUND = 1e-12  # of R: how far |t| may be off


@njit
def minimise_on_disc(a: Any, c: Any, d: Any, g: Any, h: Any, bound: Any) -> Any:
    """t of [[a, c], [c, d]], g = (g, h) and R = ``bound``; 0 where the block is singular and g is 0 as well."""
    det = a * d - c * c
    if det > 1e-12 * a * d:
        x = (c * h - d * g) / det
        y = (c * g - a * h) / det
        if x * x + y * y <= bound * bound:
            return x, y
    length = (g * g + h * h) ** 0.5
    if bound <= TINY or length <= TINY:  # squares would underflow
        return 0.0, 0.0
    # at least so large that |t| >= R: the least s is that of the stiffest direction
    s = max(length / bound - 0.5 * (a + d) - (0.25 * (a - d) ** 2 + c * c) ** 0.5, 0.0)
    x = 0.0
    y = 0.0
    for _ in range(NEWTON_STEPS):
        p = a + s
        q = d + s
        det = p * q - c * c
        if det <= 1e-14 * p * q:
            s += 1e-9 * (a + d)
            continue
        x = (c * h - q * g) / det
        y = (c * g - p * h) / det
        square = x * x + y * y
        size = square**0.5
        if abs(size - bound) <= ROUND * bound:
            break
        slope = (q * x * x - 2.0 * c * x * y + p * y * y) / det  # t (A + s)^-1 t
        s = max(s + square / slope * (size - bound) / bound, 0.0)
    size = (x * x + y * y) ** 0.5
    if size <= bound:
        return x, y
    return x * bound / size, y * bound / size


@njit
def _sweep_disc(rows: Any, r: Any, bodies: Any, normal: Any, push: Any) -> Any:
    one = rows[r]
    two = rows[r + 1]
    if push is not None:
        push_row(one, push)
        push_row(two, push)
    a = bodies[one.body_a]
    b = bodies[one.body_b]
    x = one.impulse
    y = two.impulse
    u = one.bias + relative_velocity(one, a, b)
    v = two.bias + relative_velocity(two, a, b)
    c = one.coupling
    s, t = minimise_on_disc(
        one.diagonal, c, two.diagonal, u - one.diagonal * x - c * y, v - c * x - two.diagonal * y,
        one.friction * max(normal, 0.0),
    )  # fmt: skip
    dx = s - x
    dy = t - y
    one.impulse = s
    two.impulse = t
    apply_impulse(one, a, b, dx)
    apply_impulse(two, a, b, dy)
    return dx * dx * one.diagonal + dy * dy * two.diagonal


def sweep_disc(rows, r, bodies, normal, push):  # type: ignore[no-untyped-def]
    """Solve rows r and r + 1 under the ``normal`` impulse; returns sum d^2 A_rr. Rows of the plane have none."""
    return _sweep_disc(rows, r, bodies, normal, push)


@overload(sweep_disc)
def _typed_sweep_disc(rows, r, bodies, normal, push):  # type: ignore[no-untyped-def]
    if is_spatial(rows):
        return lambda rows, r, bodies, normal, push: _sweep_disc(rows, r, bodies, normal, push)
    return lambda rows, r, bodies, normal, push: 0.0
