"""How far a slack rope hangs through."""

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit

FloatArray = NDArray[np.float64]

ROUNDS = 6  # the length is then right to 1e-6 of itself
SMALL = 1e-9  # of a rope's length: less slack, and less way across gravity, count as none


@njit
def find_sag(across: FloatArray, along: FloatArray, length: FloatArray) -> FloatArray:
    """Depth (rope,) m below the middle of the chord at which a parabola has the rope's length m.

    across, along: (rope,) m, the way between the ends across and along gravity
    length: (rope,) m, inf: not a rope but a straight line

    A parabola whose slope changes by k / (half the chord) to either side has the sag k / 4 and the
    length s(k) = (F(along + k) - F(along - k)) / 2k, where F'(u) = hypot(across, u). Newton's method
    on s^2 as a function of k^2, which is nearly straight: its slope is at most 1/3 (a level rope, just
    slack), and k is largest where the rope is folded in a vertical line.
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
