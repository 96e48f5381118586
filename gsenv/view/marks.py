"""Arrows, lines and dots that are drawn onto a picture with a dark halo; all lengths are in px."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gsenv.render.theme import HALO_ALPHA, HALO_COLOR, Rgb
from gsenv.solver.jit import njit

FloatArray = NDArray[np.float32]
Frame = NDArray[np.uint8]

HEAD_LENGTH = 5.5  # of an arrow, in radii of its line
HEAD_SHARE = 0.6  # largest part of the arrow that is its head
HEAD_WIDTH = 2.7  # half width of the head, in radii of the line
FIELDS = 10  # ax, ay, bx, by, radius at a, radius at b, red, green, blue, alpha


@njit
def blend(image: NDArray[np.uint8], marks: NDArray[np.float32]) -> None:
    """Blend marks into an image (height, width, 3), in place, with smooth edges.

    A mark is a line from a to b. With equal radii it has round caps; with unequal ones it is a cone with a flat base
    at a, such as the head of an arrow.
    """
    height, width = image.shape[0], image.shape[1]
    for k in range(marks.shape[0]):
        ax, ay, bx, by = marks[k, 0], marks[k, 1], marks[k, 2], marks[k, 3]
        first, last, alpha = marks[k, 4], marks[k, 5], marks[k, 9]
        reach = max(first, last) + 1.0
        left = max(int(np.floor(min(ax, bx) - reach)), 0)
        right = min(int(np.ceil(max(ax, bx) + reach)), width - 1)
        top = max(int(np.floor(min(ay, by) - reach)), 0)
        bottom = min(int(np.ceil(max(ay, by) + reach)), height - 1)
        dx, dy = bx - ax, by - ay
        length = np.sqrt(dx * dx + dy * dy)
        square = max(length * length, 1e-9)
        cone = first != last
        for i in range(top, bottom + 1):
            for j in range(left, right + 1):
                px, py = j + 0.5 - ax, i + 0.5 - ay
                along = (px * dx + py * dy) / square
                t = min(max(along, 0.0), 1.0)
                ex, ey = px - t * dx, py - t * dy
                distance = np.sqrt(ex * ex + ey * ey) - (first + (last - first) * t)
                if cone:
                    distance = max(distance, -along * length)
                cover = min(max(0.5 - distance, 0.0), 1.0) * alpha
                if cover > 0.0:
                    for c in range(3):
                        old = float(image[i, j, c])
                        image[i, j, c] = np.uint8(old + (marks[k, 6 + c] - old) * cover + 0.5)


class Marks:
    """Marks that are collected and then drawn; all halos lie below all marks.

    radius: px, of the lines
    """

    def __init__(self, radius: float) -> None:
        self.radius = radius
        self.halo = max(0.6 * radius, 1.0)
        self._rows: list[FloatArray] = []

    def add_lines(self, starts: ArrayLike, ends: ArrayLike, color: Rgb, thickness: float = 1.0) -> None:
        """Add lines from (line, 2) to (line, 2); those with NaN are left out."""
        a, b = _points(starts), _points(ends)
        radius = thickness * self.radius
        self._add(a, b, radius, radius, color)

    def add_dots(self, points: ArrayLike, color: Rgb, thickness: float = 2.0) -> None:
        """Add discs at (dot, 2)."""
        self.add_lines(points, points, color, thickness)

    def add_arrows(self, starts: ArrayLike, ends: ArrayLike, color: Rgb, thickness: float = 1.0) -> None:
        """Add arrows from (arrow, 2) to (arrow, 2); short ones get smaller heads."""
        a, b = _points(starts), _points(ends)
        span = b - a
        length = np.sqrt((span**2).sum(-1, keepdims=True))
        radius = thickness * self.radius
        head = np.minimum(HEAD_LENGTH * radius, HEAD_SHARE * length)
        neck = b - span / np.maximum(length, 1e-9) * head
        self._add(a, neck, radius, radius, color)
        shown = length[:, 0] > 1.0
        share = (head / (HEAD_LENGTH * radius))[shown, 0]
        self._add(neck[shown], b[shown], HEAD_WIDTH * radius * share, 0.0, color)

    def _add(self, a: FloatArray, b: FloatArray, first: ArrayLike, last: ArrayLike, color: Rgb) -> None:
        rows = np.empty((len(a), FIELDS), np.float32)
        rows[:, 0:2], rows[:, 2:4] = a, b
        rows[:, 4], rows[:, 5] = first, last
        rows[:, 6:9], rows[:, 9] = color, 1.0
        self._rows.append(rows[np.isfinite(rows).all(1) & (np.abs(rows[:, :4]) < 1e5).all(1)])

    def draw(self, image: Frame) -> None:
        """Draw all marks into an image (height, width, 3), in place."""
        if not self._rows:
            return
        marks = np.concatenate(self._rows)
        halos = marks.copy()
        halos[:, 4:6] += self.halo
        halos[:, 6:9], halos[:, 9] = HALO_COLOR, HALO_ALPHA
        blend(image, np.concatenate([halos, marks]))


def _points(given: ArrayLike) -> FloatArray:
    return np.asarray(given, np.float32).reshape(-1, 2)
