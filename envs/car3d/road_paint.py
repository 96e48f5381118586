"""GCar3D's road as pictures show it: painted on the ground along the centre line."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.car3d import scene as n
from gsenv.envs.car3d.build import ASPHALT, PAINT, RED
from gsenv.envs.car3d.road import HEADING, X, Y
from gsenv.render.spatial.stripes import UNKNOWN, Stripes, band

Array = NDArray[Any]

SPACING = 0.5  # m, of the points for which the place beside the road is computed
REACH = 3.4  # m from the centre line, up to which it is
DASH, DASH_HALF = 1.2, 0.07  # m, length and half width
KERB_PERIOD = 2.0 * n.STRIP  # m, of a red and a white mark of the kerbs; the red one is in its middle
KERB_TAPER = 1.3  # m, over which the white ends of kerbs lose their width, for none to be left at a next red mark
KERB_REST = 0.15  # m, beside a red mark, where they keep it
HIDDEN = 0.1  # m below the asphalt, where kerbs without width end
LEAST = -4.0  # share of a kerb's width far from one: there it is only below the middle of the road
MOST_KEPT = 64  # roads of worlds, of 0.3 MB each

BANDS = np.array(
    [
        band(n.ROAD_HALF + n.EDGE, PAINT),
        band(n.ROAD_HALF - HIDDEN, PAINT, widening=HIDDEN + n.KERB),
        band(n.ROAD_HALF - HIDDEN, RED, widening=HIDDEN + n.KERB, period=KERB_PERIOD, mark=n.STRIP),
        band(n.ROAD_HALF, ASPHALT),
        band(DASH_HALF, PAINT, period=n.DASH_SPACING * n.STRIP, mark=DASH),
    ],
    np.float32,
)
X_POINTS = np.arange(n.FIRST_X, n.LAST_X + 0.5 * SPACING, SPACING)
Y_POINTS = np.arange(-n.HALF_DEPTH, n.HALF_DEPTH + 0.5 * SPACING, SPACING)
GRID = np.array(
    [-0.5 * (n.LAST_X - n.FIRST_X), -n.HALF_DEPTH, 1.0 / SPACING, n.FIRST_STRIP, n.FINISH + 8.0], np.float32
)


class RoadPaint:
    """The stripes of the roads of worlds; those of an episode are computed once. Copies and pickles begin empty."""

    def __init__(self) -> None:
        self._kept: OrderedDict[int, tuple[Array, Stripes]] = OrderedDict()

    def stripes(self, world: int, path: Array) -> Stripes:
        """Return the stripes of a world's road, whose centre line has the nodes `path`."""
        known = self._kept.pop(world, None)
        if known is None or not np.array_equal(known[0], path):
            known = path.copy(), Stripes(find_places(path), GRID, BANDS)
        self._kept[world] = known
        if len(self._kept) > MOST_KEPT:
            self._kept.popitem(last=False)
        return known[1]

    def __getstate__(self) -> dict[str, Any]:
        return {"_kept": OrderedDict()}


def find_places(path: Array) -> NDArray[np.float32]:
    """Return (row, column, 3): metres to the left of the centre line, along it, and the share of the kerbs' width.

    The share, LEAST to 1, is at most 0 where no kerb is.
    """
    places = np.full((len(Y_POINTS), len(X_POINTS), 3), (UNKNOWN, 0.0, 0.0), np.float32)
    nearest = _nearest_nodes(path)
    rows, columns = np.nonzero(nearest >= 0)
    nodes = n.FIRST_X + n.STEP * np.arange(n.NODES)
    bends = np.gradient(path[:, HEADING], n.STEP)
    s, x, y = nodes[nearest[rows, columns]], X_POINTS[columns], Y_POINTS[rows]
    for _ in range(4):  # Newton, as in road.nearest
        heading, bend, dx, dy = _at(path, nodes, bends, s, x, y)
        off, aside = np.cos(heading) * dx + np.sin(heading) * dy, np.cos(heading) * dy - np.sin(heading) * dx
        s = s + np.clip(off / np.maximum(1.0 - bend * aside, 0.3), -1.0, 1.0)
    heading, _, dx, dy = _at(path, nodes, bends, s, x, y)
    places[rows, columns, 0] = np.cos(heading) * dy - np.sin(heading) * dx
    places[rows, columns, 1] = s
    red = find_kerbs(path)
    white = 0.5 * (red[:-1] + red[1:])[np.diff(red) < 1.5 * KERB_PERIOD]
    away = np.abs(s[:, None] - np.append(red, white)).min(axis=1, initial=np.inf) - 0.5 * n.STRIP - KERB_REST
    places[rows, columns, 2] = np.clip(1.0 - away / KERB_TAPER, LEAST, 1.0)
    return places


def find_kerbs(path: Array) -> NDArray[np.float64]:
    """Return the middles of the kerbs' red marks in m along the centre line: those in bends, which are whole."""
    nodes = n.FIRST_X + n.STEP * np.arange(n.NODES)
    middles = KERB_PERIOD * (np.arange(n.FIRST_STRIP // KERB_PERIOD, n.LAST_X // KERB_PERIOD) + 0.5)
    bends = np.abs(np.interp(middles, nodes, np.gradient(path[:, HEADING], n.STEP)))
    return np.asarray(middles[bends > n.KERB_BEND])


def _at(path: Array, nodes: Array, bends: Array, s: Array, x: Array, y: Array) -> tuple[Array, Array, Array, Array]:
    """Return heading (rad) and curvature (1/m) of the centre line at s, and the vectors in m from there to (x, y)."""
    heading, bend = np.interp(s, nodes, path[:, HEADING]), np.interp(s, nodes, bends)
    return heading, bend, x - np.interp(s, nodes, path[:, X]), y - np.interp(s, nodes, path[:, Y])


def _nearest_nodes(path: Array) -> NDArray[np.int64]:
    """Return (row, column) the node nearest to each point, -1 where none is within REACH."""
    least = np.full((len(Y_POINTS), len(X_POINTS)), REACH * REACH)
    nearest = np.full(least.shape, -1, np.int64)
    lows = ((path[:, (X, Y)] - REACH - (n.FIRST_X, -n.HALF_DEPTH)) / SPACING).astype(np.int64).clip(0)
    wide = int(2.0 * REACH / SPACING) + 2
    for k, (i, j) in enumerate(lows.tolist()):
        window = slice(j, j + wide), slice(i, i + wide)
        square = (X_POINTS[window[1]] - path[k, X]) ** 2 + ((Y_POINTS[window[0]] - path[k, Y]) ** 2)[:, None]
        nearer = square < least[window]
        least[window] = np.where(nearer, square, least[window])
        nearest[window] = np.where(nearer, k, nearest[window])
    return nearest
