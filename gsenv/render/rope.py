"""Sag of a slack rope."""

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit

FloatArray = NDArray[np.float64]

ROUNDS = 6  # Newton iterations; the relative error of the length is then below 1e-6
SMALL = 1e-9  # fraction of a rope's length below which slack, or distance across gravity, counts as zero


@njit
def find_sag(across: FloatArray, along: FloatArray, length: FloatArray) -> FloatArray:
    """Return the sag (rope,) in m below the chord's midpoint of a parabola with the rope's length.

    across, along: (rope,) m, components of the vector between the ends across and along gravity
    length: (rope,) m; inf for a straight line that is not a rope

    A parabola whose slope changes by k / (half the chord) to either side has the sag k / 4 and the
    length s(k) = (F(along + k) - F(along - k)) / 2k, where F'(u) = hypot(across, u). Newton's method
    solves s^2(k^2) = length^2, since s^2 is nearly linear in k^2: its slope is at most 1/3 (a level rope
    with little slack), and k is largest for a rope folded into a vertical line.
    """
    sag = np.zeros(across.shape[0])
    for i in range(across.shape[0]):
        wanted = length[i] * length[i]
        y = abs(along[i])
        slack = wanted - across[i] * across[i] - y * y
        if not SMALL * wanted < slack < np.inf:
            continue
        x = max(abs(across[i]), SMALL * length[i])
        least, most = 3.0 * slack, (length[i] + np.sqrt(wanted - y * y)) ** 2
        square = most
        for _ in range(ROUNDS):
            k = np.sqrt(square)
            low, high = y - k, y + k
            slant_low, slant_high = np.hypot(x, low), np.hypot(x, high)
            area = high * slant_high - low * slant_low
            area += x * x * (np.arcsinh(high / x) - np.arcsinh(low / x))
            own = area / (4.0 * k)
            slope = own * (0.5 * (slant_low + slant_high) - own) / square
            square = min(max(square - (own * own - wanted) / slope, least), most)
        sag[i] = 0.25 * np.sqrt(square)
    return sag
