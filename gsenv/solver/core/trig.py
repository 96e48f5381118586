"""Trigonometric functions of scalars, bit-equal on all machines.

libm's sin, cos and atan2 differ in the last bit between machines and code paths; these use only
+, -, * and /, which are exactly defined, so golden hashes hold everywhere.
"""

from __future__ import annotations

import numpy as np

from ..jit import inline_njit, njit

# pi/2 in three parts: the first two have 33 significant bits each, so that their product with k is
# exact for |k| < 2^20; the third is the remainder.  Reduction is good to |x| of about 1.6e6 rad.
_HALF_PI_1 = 1.5707963267341256  # pi/2 cut to 33 bits
_HALF_PI_2 = 6.077100506303966e-11  # the next 33 bits
_HALF_PI_3 = 2.0222662487959506e-21

# Taylor series: for |r| <= pi/4 the first omitted term is below 1e-18.
_S3, _S5, _S7, _S9 = -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0
_S11, _S13, _S15 = -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0
_S17 = 1.0 / 355687428096000.0
_C4, _C6, _C8, _C10 = 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0, -1.0 / 3628800.0
_C12, _C14, _C16 = 1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0


@inline_njit
def sin_cos(x: float) -> tuple[float, float]:
    """Return (cos x, sin x), in the order of a 2D rotation; to about 1 ulp for |x| < 1e6 rad."""
    k = np.floor(x * 0.6366197723675814 + 0.5)
    r = ((x - k * _HALF_PI_1) - k * _HALF_PI_2) - k * _HALF_PI_3
    z = r * r
    tail = _S9 + z * (_S11 + z * (_S13 + z * (_S15 + z * _S17)))
    sin = r + r * z * (_S3 + z * (_S5 + z * (_S7 + z * tail)))
    tail = _C10 + z * (_C12 + z * (_C14 + z * _C16))
    rest = z * z * (_C4 + z * (_C6 + z * (_C8 + z * tail)))
    half = 0.5 * z
    head = 1.0 - half
    cos = head + (((1.0 - head) - half) + rest)  # adds the rounding error of 1 - z/2
    quadrant = k - 4.0 * np.floor(0.25 * k)
    if quadrant == 1.0:
        return -sin, cos
    if quadrant == 2.0:
        return -cos, -sin
    if quadrant == 3.0:
        return sin, -cos
    return cos, sin


_PI = 3.141592653589793
_HALF_PI = 1.5707963267948966
# atan(k / 8), k = 0..8
_ATAN = (
    0.0,
    0.12435499454676144,
    0.24497866312686414,
    0.35877067027057225,
    0.4636476090008061,
    0.5585993153435624,
    0.6435011087932844,
    0.7188299996216245,
    0.7853981633974483,
)


@njit
def atan2(y: float, x: float) -> float:
    """Return the angle of (x, y) in rad, (-pi, pi]; to about 1 ulp.  atan2(0, 0) = 0.

    With |y| <= |x| and c the nearest eighth to y/x: atan(y/x) = atan(c) + atan(u),
    u = (y - c x) / (x + c y), |u| <= 1/16, where seven Taylor terms are enough.
    """
    ax = abs(x)
    ay = abs(y)
    low = min(ax, ay)
    high = max(ax, ay)
    if not ax + ay < np.inf:  # infinite or NaN
        return np.nan
    if high == 0.0:
        return 0.0
    k = int(8.0 * (low / high) + 0.5)
    c = 0.125 * k
    u = (low - c * high) / (high + c * low)
    z = u * u
    series = -1.0 / 7.0 + z * (1.0 / 9.0 + z * (-1.0 / 11.0 + z * (1.0 / 13.0)))
    angle = _ATAN[k] + (u + u * z * (-1.0 / 3.0 + z * (1.0 / 5.0 + z * series)))
    if ay > ax:
        angle = _HALF_PI - angle
    if x < 0.0:
        angle = _PI - angle
    return -angle if y < 0.0 else angle


@njit
def exp_minus(x: float) -> float:
    """Return e^-x for 0 <= x <= 4, to a few ulp: Taylor series of x/8, squared three times."""
    z = -0.125 * x
    tail = 1.0 / 5040.0 + z * (1.0 / 40320.0 + z * (1.0 / 362880.0 + z * (1.0 / 3628800.0)))
    tail = 1.0 / 24.0 + z * (1.0 / 120.0 + z * (1.0 / 720.0 + z * (tail + z**4 * (1.0 / 39916800.0))))
    e = 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z * tail)))
    e *= e
    e *= e
    return e * e
