"""The part of the world that an automatic camera shows: it grows when bodies leave the picture."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

SLACK = 0.08  # of the first box's largest side, by which bodies may leave it: less than the cameras' margin
MOST_GROWTH = 4.0  # of the sides: bodies that fall forever must not make all others too small to see


class GrowingBox:
    """An axis-aligned box (low, high) in m around the first bodies, which grows continuously with what leaves it.

    Attributes:
        low, high: (dim,), of the present box.
    """

    def __init__(self, low: ArrayLike, high: ArrayLike) -> None:
        self.low, self.high = np.array(low, np.float64), np.array(high, np.float64)
        side = float((self.high - self.low).max())
        self._slack = SLACK * side
        reach = 0.5 * (MOST_GROWTH - 1.0) * side
        self._lowest, self._highest = self.low - reach, self.high + reach

    def include(self, low: ArrayLike, high: ArrayLike) -> bool:
        """Grow by what is outside; returns whether the box has grown."""
        lower = np.maximum(np.minimum(self.low, np.asarray(low) + self._slack), self._lowest)
        upper = np.minimum(np.maximum(self.high, np.asarray(high) - self._slack), self._highest)
        if np.array_equal(lower, self.low) and np.array_equal(upper, self.high):
            return False
        self.low, self.high = lower, upper
        return True
