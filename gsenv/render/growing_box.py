"""The part of the world that an automatic camera shows: it grows when bodies leave the picture, and then follows them.

Three boxes lie in one another: that which is shown, the limits that it may grow to, and between them the zone in which
the limits keep what moves.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

SLACK = 0.08  # of the first box's largest side, by which bodies may leave it: less than the cameras' margin
MOST_GROWTH = 4.0  # of the sides: bodies that fall forever must not make all others too small to see
EDGE = 0.15  # of the limits' sides, between them and the zone: what is followed is not at the picture's edge


class GrowingBox:
    """An axis-aligned box (low, high) in m around the first bodies, which grows continuously with what leaves it.

    It grows to four times the largest side at most. Where all that moves is about to leave these limits, they are
    shifted: so far that all of it stays within, or as much as fits; the rest is lost. They move no faster than what is
    followed, and the box not more than twice as fast.

    Attributes:
        low, high: (dim,), of the present box.
    """

    def __init__(self, low: ArrayLike, high: ArrayLike) -> None:
        self.low, self.high = np.array(low, np.float64), np.array(high, np.float64)
        side = float((self.high - self.low).max())
        self._slack = SLACK * side
        reach = 0.5 * (MOST_GROWTH - 1.0) * side
        self._lowest, self._highest = self.low - reach, self.high + reach

    def include(self, low: ArrayLike, high: ArrayLike, moving: tuple[FloatArray, FloatArray] | None = None) -> bool:
        """Grow by what is outside; returns whether the box has changed.

        low, high: (dim,), around all that is to be shown
        moving: lower and upper corners (body, dim) of what moves, if anything does
        """
        before = self.low, self.high
        if moving is not None and len(moving[0]):
            self._follow(*moving)
        lower = np.minimum(self.low, np.asarray(low) + self._slack)
        upper = np.maximum(self.high, np.asarray(high) - self._slack)
        self.low, self.high = np.maximum(lower, self._lowest), np.minimum(upper, self._highest)
        return not (np.array_equal(self.low, before[0]) and np.array_equal(self.high, before[1]))

    def _follow(self, lows: FloatArray, highs: FloatArray) -> None:
        """Shift the limits with what moves, by all of it where that fits, else by what would be the last to leave."""
        first, last = self._zone()
        low, high = lows.min(axis=0), highs.max(axis=0)
        shift = np.minimum(np.maximum(high - last, 0.0), np.maximum(low - first, 0.0))
        shift -= np.minimum(np.maximum(first - low, 0.0), np.maximum(last - high, 0.0))
        self._shift(shift)
        first, last = self._zone()
        needed = np.maximum(highs - last, 0.0) + np.minimum(lows - first, 0.0)  # in two directions: to the middle
        self._shift(needed[np.argmin((needed**2).sum(axis=1))])

    def _zone(self) -> tuple[FloatArray, FloatArray]:
        edge = EDGE * (self._highest - self._lowest)
        return self._lowest + edge, self._highest - edge

    def _shift(self, by: FloatArray) -> None:
        """Shift the limits, and let the box grow towards them, ahead of what is followed."""
        self._lowest, self._highest = self._lowest + by, self._highest + by
        self.low = np.where(by < 0.0, np.maximum(self.low + 2.0 * by, self._lowest), self.low)
        self.high = np.where(by > 0.0, np.minimum(self.high + 2.0 * by, self._highest), self.high)
