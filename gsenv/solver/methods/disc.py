"""The two tangent rows of a 3D contact, solved as one block on Coulomb's disc.

With A the 2x2 block of J M^-1 J^T and g the row velocities without t, the impulse t minimises
t.A t/2 + g.t on |t| <= R.  Where the unbounded minimum is outside the disc, t = -(A + s I)^-1 g with
|t| = R; s > 0 is found by Newton's method on 1/|t(s)| - 1/R, which is nearly linear in s (More,
Sorensen, "Computing a trust region step", SIAM J. Sci. Stat. Comput. 4 (1983)).  So friction opposes
the slip in any direction of the tangent plane.
"""

from __future__ import annotations

from typing import Any

from ..core.rows import apply_impulses, push_row, relative_velocity
from ..jit import njit

NEWTON_STEPS = 12
TINY = 1e-140  # N s and m/s
SINGULAR = 1e-12  # of a d: determinant of a block
ROUND = 1e-12  # of R: tolerance of |t|
NEAR = 1e-9  # the same where sweeps go on from what the last ones found


@njit
def minimise_on_disc(a: Any, c: Any, d: Any, g: Any, h: Any, bound: Any) -> Any:
    """Return t for A = [[a, c], [c, d]], g = (g, h) and R = ``bound``; 0 where A is singular and g is 0."""
    inside, x, y = _minimise_inside(a, c, d, g, h, bound)
    if inside:
        return x, y
    length = (g * g + h * h) ** 0.5
    if bound <= TINY or length <= TINY:  # squares would underflow
        return 0.0, 0.0
    # a lower bound of s, from the stiffest direction: |t| >= R
    s = max(length / bound - 0.5 * (a + d) - (0.25 * (a - d) ** 2 + c * c) ** 0.5, 0.0)
    return _on_rim(a, c, d, g, h, bound, s, ROUND)


@njit
def _minimise_inside(a: Any, c: Any, d: Any, g: Any, h: Any, bound: Any) -> Any:
    """Return (whether the unbounded minimum is in the disc, its two components)."""
    det = a * d - c * c
    if not det > SINGULAR * a * d:
        return False, 0.0, 0.0
    inverse = 1.0 / det
    x = (c * h - d * g) * inverse
    y = (c * g - a * h) * inverse
    return x * x + y * y <= bound * bound, x, y


@njit
def minimise_near(block: Any, side: Any, bound: Any, near: Any) -> Any:
    """Return the same for the block (a, c, d), (g, h) and R where the unbounded minimum is outside the disc.

    In fewer steps from a vector ``near`` the solution, of which s = -t.(g + A t) / t.t.
    """
    a, c, d = block
    g, h = side
    x, y = near
    square = x * x + y * y
    if bound <= TINY or not square > 0.25 * bound * bound:
        return minimise_on_disc(a, c, d, g, h, bound)
    s = -(x * (g + a * x + c * y) + y * (h + c * x + d * y)) / square
    return _on_rim(a, c, d, g, h, bound, max(s, 0.0), NEAR)


@njit
def minimise_again(block: Any, side: Any, bound: Any, near: Any) -> Any:
    """Return the same for (a, c, d), (g, h) and R, in fewer steps where it is on the rim, from that of the last sweep.

    ``near``: the solution of the last sweep, or another of the size of the solution.
    """
    a, c, d = block
    inside, x, y = _minimise_inside(a, c, d, side[0], side[1], bound)
    if inside:
        return x, y
    if not a * d - c * c > SINGULAR * a * d:
        return minimise_on_disc(a, c, d, side[0], side[1], bound)
    return minimise_near(block, side, bound, near)


@njit
def _on_rim(a: Any, c: Any, d: Any, g: Any, h: Any, bound: Any, s: Any, tolerance: Any) -> Any:
    """Return t on the rim of the disc, from a first s."""
    x = 0.0
    y = 0.0
    for _ in range(NEWTON_STEPS):
        p = a + s
        q = d + s
        det = p * q - c * c
        if det <= 1e-14 * p * q:
            s += 1e-9 * (a + d)
            continue
        inverse = 1.0 / det
        x = (c * h - q * g) * inverse
        y = (c * g - p * h) * inverse
        square = x * x + y * y
        size = square**0.5
        if abs(size - bound) <= tolerance * bound:
            break
        slope = (q * x * x - 2.0 * c * x * y + p * y * y) * inverse  # t (A + s)^-1 t
        s = max(s + square / slope * (size / bound - 1.0), 0.0)  # no product of three that are tiny
    size = (x * x + y * y) ** 0.5
    if size <= bound:
        return x, y
    return x * bound / size, y * bound / size


@njit
def sweep_disc(rows: Any, r: Any, bodies: Any, normal: Any, push: Any) -> Any:
    """Solve rows r and r + 1 under the ``normal`` impulse; returns sum d^2 A_rr."""
    one = rows[r]
    two = rows[r + 1]
    if push is not None:
        push_row(one, push)
        push_row(two, push)
    bound = one.friction * max(normal, 0.0)
    x = one.impulse
    y = two.impulse
    if bound == 0.0 and x == 0.0 and y == 0.0:  # as of the many contacts of a moving pile that carry nothing
        return 0.0
    a = bodies[one.body_a]
    b = bodies[one.body_b]
    u = one.bias + relative_velocity(one, a, b)
    v = two.bias + relative_velocity(two, a, b)
    c = one.coupling
    e = one.diagonal
    f = two.diagonal
    s, t = minimise_again((e, c, f), (u - e * x - c * y, v - c * x - f * y), bound, (x, y))
    dx = s - x
    dy = t - y
    one.impulse = s
    two.impulse = t
    apply_impulses(one, dx, two, dy, a, b)
    return dx * dx * e + dy * dy * f
