"""Arrows, lines and dots with a dark halo, drawn over a picture to show contact forces and joint frames.

Widths are in m; to give a width in px, divide it by the camera's scale.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gsenv.render.draw_list import NO_VERTICES, DrawKind, DrawList, Layer, draw_items, join
from gsenv.render.theme import HALO_ALPHA, HALO_COLOR, Rgb

FloatArray = NDArray[np.float64]

HEAD_LENGTH = 6.0  # length of an arrowhead, in pen radii
HEAD_SHARE = 0.6  # largest length of the head, as a fraction of the arrow
HEAD_SLOPE = 0.48  # half width of the head over its length


class Pen(NamedTuple):
    """Radius of a line and width of the halo around it, both in m."""

    radius: float
    halo: float


def lines(starts: ArrayLike, ends: ArrayLike, pen: Pen, color: Rgb) -> DrawList:
    """Draw segments with round caps from (line, 2) to (line, 2) in m; all halos lie below all lines."""
    a, span, length = _spans(starts, ends)
    items = draw_items(len(a))
    items["kind"] = DrawKind.CAPSULE
    items["layer"] = Layer.OVERLAY
    items["position"] = a + 0.5 * span
    items["rotation"][length > 0.0] = span[length > 0.0] / length[length > 0.0, None]
    items["size"][:, 0] = 0.5 * length
    items["radius"] = pen.radius
    items["fill"] = items["line"] = color
    halos = items.copy()
    halos["radius"] += pen.halo
    halos["fill"] = halos["line"] = HALO_COLOR
    halos["alpha"] = HALO_ALPHA
    return DrawList(np.concatenate([halos, items]), NO_VERTICES)


def dots(points: ArrayLike, pen: Pen, color: Rgb) -> DrawList:
    """Draw discs at (dot, 2) in m."""
    return lines(points, points, pen, color)


def arrows(starts: ArrayLike, ends: ArrayLike, pen: Pen, color: Rgb) -> DrawList:
    """Draw arrows from (arrow, 2) to (arrow, 2) in m; short ones get smaller heads, zero-length ones are left out."""
    a, span, length = _spans(starts, ends)
    a, span, length = a[length > 0.0], span[length > 0.0], length[length > 0.0]
    direction = span / length[:, None]
    head = np.minimum(HEAD_LENGTH * pen.radius, HEAD_SHARE * length)
    neck = a + direction * (length - head)[:, None]
    # The halo is the triangle with each side moved outward by the same distance; its tip moves by more.
    tip = pen.halo * np.hypot(1.0, HEAD_SLOPE) / HEAD_SLOPE
    tips = a + span
    halos = _heads(tips + tip * direction, direction, head + tip + pen.halo, HALO_COLOR)
    halos.items["alpha"] = HALO_ALPHA
    return join(halos, lines(a, neck, pen, color), _heads(tips, direction, head, color))


def _spans(starts: ArrayLike, ends: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the starts (n, 2), the vectors to the ends (n, 2) and their lengths (n,)."""
    a = np.reshape(np.asarray(starts, np.float64), (-1, 2))
    span = np.reshape(np.asarray(ends, np.float64), (-1, 2)) - a
    return a, span, np.hypot(span[:, 0], span[:, 1])


def _heads(tips: FloatArray, direction: FloatArray, length: FloatArray, color: Rgb) -> DrawList:
    """Draw triangles that point along `direction`, with their tips at (head, 2)."""
    items = draw_items(len(tips))
    items["kind"] = DrawKind.POLYGON
    items["layer"] = Layer.OVERLAY
    items["position"] = tips
    items["rotation"] = direction
    items["fill"] = items["line"] = color
    items["vertex_first"] = 3 * np.arange(len(tips))
    items["vertex_count"] = 3
    unit = np.array([(0.0, 0.0), (-1.0, HEAD_SLOPE), (-1.0, -HEAD_SLOPE)])
    return DrawList(items, (unit * length[:, None, None]).reshape(-1, 2))
