"""GCar3D's road and ground: the centre line of an episode's road, and the heightfield around it.

The centre line is a table `path` (node, column) of points that are equally spaced along it: x, y, z and heading.
Lengths along it, `s`, are horizontal, and 0 at the start.
"""

from __future__ import annotations

import math

from gsenv.envs.car3d import scene as n
from gsenv.envs.core.kernels import between, smooth, within
from gsenv.solver.core.trig import atan2, sin_cos
from gsenv.solver.jit import njit
from gsenv.solver.spatial.math import multiply, turn_about

WEAVE = (40.0, 56.0)  # m, range of the wave length of the heading between chicanes
WEAVE_TURN, WEAVE_GROWTH = 0.05, 0.05  # rad at difficulty 0, and what difficulty 1 adds
CHICANE_TURN, CHICANE_GROWTH = 0.2, 1.2  # rad, the largest turn of a bend; it grows as d (2 - d)
LEAST_TURN = 0.75  # share of that
RADIUS, RADIUS_GROWTH = 3.4, 4.4  # m, the tightest bend at difficulty 1, and what (1 - d)^4 adds
WIDEST = 1.6  # times the tightest
LINKS = (1.0, 5.0)  # m between the two bends of a chicane
CHICANE_JITTER = 2.0  # m, to both sides
NEAR_MIDDLE = 2.0  # m, from where on chicanes lead back
RISES = ((11.0, 16.0), (30.0, 45.0))  # m, ranges of the wave lengths of its height
RISE_SLOPES = (0.02, 0.03)
RISE_GROWTH = (0.16, 0.14)
HILL_LENGTHS = (13.0, 19.0)  # m, of the hills beside the road
HILLS = 0.8  # m
HILL_GROWTH = 1.4  # m
LEVEL_START = 6.0  # m, where bends and rises begin
BLEND = 6.0  # m
LEVEL_HALF = 3.0  # m, of the road at an obstacle
WINDOW = 9.0  # m in x, within which nodes of the road shape the ground
CHICANE_DRAWS = 5
ROAD_DRAWS = 2 + 4 + CHICANE_DRAWS * n.CHICANES + 2

X, Y, Z, HEADING = 0, 1, 2, 3  # columns of the path
COLUMNS = 4

_S0, _STEP, _NODES = n.FIRST_X, n.STEP, n.NODES
_X0, _COLUMNS, _ROWS, _CELL, _Y0 = n.FIRST_X, n.COLUMNS, n.ROWS, n.CELL, -n.HALF_DEPTH
_CHICANES, _FIRST_CHICANE, _CHICANE_SPACING = n.CHICANES, n.FIRST_CHICANE, n.CHICANE_SPACING
_FINISH, _SHOULDER, _VERGE = n.FINISH, n.SHOULDER, n.VERGE
_RISES = tuple(low for low, _ in RISES)
_RISE_SPANS = tuple(high - low for low, high in RISES)
_HX, _HY = HILL_LENGTHS
_TWO_PI = 2.0 * math.pi
_UP = (0.0, 0.0, 1.0)
_LEFT = (0.0, 1.0, 0.0)


# ---------------------------------------------------------------- reading the centre line


@njit
def path_at(path, s, column):  # type: ignore[no-untyped-def]
    """Return a column of the centre line at s, interpolated between nodes."""
    place = within((s - _S0) / _STEP, _NODES - 1.001)
    i = int(place)
    low = path[i, column]
    return low + (place - i) * (path[i + 1, column] - low)


@njit
def path_slope(path, s, column):  # type: ignore[no-untyped-def]
    """Return the derivative of a column with respect to s; of the heading this is the curvature in 1/m."""
    return (path_at(path, s + _STEP, column) - path_at(path, s - _STEP, column)) / (2.0 * _STEP)


@njit
def road_point(path, s):  # type: ignore[no-untyped-def]
    """Return the point of the centre line at s."""
    return (path_at(path, s, X), path_at(path, s, Y), path_at(path, s, Z))


@njit
def road_turn(path, s):  # type: ignore[no-untyped-def]
    """Return the rotation whose x axis points along the road at s, and whose y axis is level."""
    yaw = turn_about(_UP, path_at(path, s, HEADING))
    return multiply(yaw, turn_about(_LEFT, -atan2(path_slope(path, s, Z), 1.0)))


@njit
def nearest(path, s, x, y):  # type: ignore[no-untyped-def]
    """Return s in m of the point of the centre line nearest to (x, y), and the distance in m to the left of it.

    Newton iterations from an s nearby; they converge within the road's own radius of curvature.
    """
    for _ in range(5):
        cosine, sine = sin_cos(path_at(path, s, HEADING))
        dx, dy = x - path_at(path, s, X), y - path_at(path, s, Y)
        off = cosine * dx + sine * dy
        shrink = 1.0 - path_slope(path, s, HEADING) * (cosine * dy - sine * dx)
        s += min(max(off / max(shrink, 0.3), -2.0), 2.0)
    cosine, sine = sin_cos(path_at(path, s, HEADING))
    return s, cosine * (y - path_at(path, s, Y)) - sine * (x - path_at(path, s, X))


# ---------------------------------------------------------------- laying it


@njit
def _lay_chicane(difficulty, k, draws, y):  # type: ignore[no-untyped-def]
    """Return begin and length (m) of the first bend of chicane k, begin of its second, and its turn (rad).

    It leads back to the middle of the ground from y (m) beyond NEAR_MIDDLE, else to the side that is drawn.
    """
    turn = (CHICANE_TURN + CHICANE_GROWTH * difficulty * (2.0 - difficulty)) * between(LEAST_TURN, 1.0, draws[0])
    easy = (1.0 - difficulty) ** 4
    radius = (RADIUS + RADIUS_GROWTH * easy) * between(1.0, WIDEST, draws[1])
    length = 1.5 * turn * radius  # a smooth step turns 1.5 times as fast in its middle as on average
    link = between(LINKS[0], LINKS[1], draws[2])
    middle = _FIRST_CHICANE + k * _CHICANE_SPACING + between(-CHICANE_JITTER, CHICANE_JITTER, draws[3])
    left = y < 0.0 if abs(y) > NEAR_MIDDLE else draws[4] < 0.5
    return middle - 0.5 * link - length, length, middle + 0.5 * link, turn if left else -turn


@njit
def _level_share(s, slots):  # type: ignore[no-untyped-def]
    """Return the factor of the road's rise at s: 0 at the start, at obstacles and beyond the finish, else 1."""
    share = smooth((s - LEVEL_START) / BLEND) * smooth((_FINISH + 8.0 - s) / BLEND)
    for k in range(len(slots)):
        share *= smooth((abs(s - slots[k]) - LEVEL_HALF) / 4.0)
    return share


@njit
def _rise(difficulty, s, draws):  # type: ignore[no-untyped-def]
    """Return the slope of the road's height at s: two waves, each with draws for its length and its phase."""
    rise = 0.0
    for k in range(2):
        length = _RISES[k] + _RISE_SPANS[k] * draws[2 * k]
        rise += (RISE_SLOPES[k] + RISE_GROWTH[k] * difficulty) * sin_cos(_TWO_PI * (s / length + draws[2 * k + 1]))[0]
    return rise


@njit
def lay_path(difficulty, draws, slots, path):  # type: ignore[no-untyped-def]
    """Set the nodes of the centre line; `slots` (slot,) are the places s of obstacles, where it is level."""
    x, y, z = _X0, 0.0, 0.0
    weave = between(WEAVE[0], WEAVE[1], draws[0])
    chicane, bends = -1, (0.0, 1.0, 0.0, 0.0)
    for i in range(_NODES):
        s = _S0 + _STEP * i
        k = min(max(math.floor((s - _FIRST_CHICANE) / _CHICANE_SPACING + 0.5), 0), _CHICANES - 1)
        if k != chicane:
            chicane = k
            bends = _lay_chicane(difficulty, k, draws[6 + CHICANE_DRAWS * k :], y)
        first, length, second, turn = bends
        heading = (WEAVE_TURN + WEAVE_GROWTH * difficulty) * sin_cos(_TWO_PI * (s / weave + draws[1]))[0]
        heading *= smooth((s - LEVEL_START) / BLEND)
        heading += turn * (smooth((s - first) / length) - smooth((s - second) / length))
        path[i, X], path[i, Y], path[i, Z], path[i, HEADING] = x, y, z, heading
        cosine, sine = sin_cos(heading)
        x += _STEP * cosine
        y += _STEP * sine
        z += _STEP * _level_share(s + 0.5 * _STEP, slots) * _rise(difficulty, s + 0.5 * _STEP, draws[2:])


# ---------------------------------------------------------------- ground


@njit
def _height_beside(path, x, y, first):  # type: ignore[no-untyped-def]
    """Return (height of the road, distance to it) in m for a point of the ground, and the first node near its x.

    Close to the road the height is that of its nearest point, farther off a mean of all points nearby, so that the
    ground has no steps between two stretches of the road.
    """
    while first < _NODES - 1 and path[first, X] < x - WINDOW:
        first += 1
    least, at, total, weights = math.inf, first, 0.0, 0.0
    for i in range(first, _NODES):
        dx, dy = x - path[i, X], y - path[i, Y]
        if dx < -WINDOW:
            break
        square = dx * dx + dy * dy
        if square < least:
            least, at = square, i
        weight = 1.0 / ((square + 1.0) * (square + 1.0))
        total += weight * path[i, Z]
        weights += weight
    if weights == 0.0:
        return path[first, Z], math.inf, first
    s, aside = nearest(path, _S0 + _STEP * at, x, y)
    aside = abs(aside) if abs(s - _S0 - _STEP * at) <= _STEP else math.sqrt(least)
    share = smooth((aside - _SHOULDER) / (0.5 * _VERGE))
    return (1.0 - share) * path_at(path, s, Z) + share * total / weights, aside, first


@njit
def raise_ground(difficulty, draws, path, vertices):  # type: ignore[no-untyped-def]
    """Set the heights of the field: level across the road, hills beside it, by two draws."""
    hill = HILLS + HILL_GROWTH * difficulty
    low, high = math.inf, -math.inf
    first = 0
    for i in range(_COLUMNS):
        x = _X0 + _CELL * i
        along = sin_cos(_TWO_PI * (x / _HX + draws[0]))[0]
        for j in range(_ROWS):
            y = _Y0 + _CELL * j
            z, aside, first = _height_beside(path, x, y, first)
            across = sin_cos(_TWO_PI * (y / _HY + draws[1]))[0]
            z += smooth((aside - _SHOULDER) / _VERGE) * hill * (0.45 + 0.35 * along + 0.5 * along * across)
            vertices[j * _COLUMNS + i].position[2] = z
            low, high = min(low, z), max(high, z)
    vertices[0].normal[0], vertices[0].normal[1] = low, high


@njit
def ground_at(vertices, x, y):  # type: ignore[no-untyped-def]
    """Return the height in m of the field at (x, y), bilinear between its samples."""
    u = within((x - _X0) / _CELL, _COLUMNS - 1.001)
    v = within((y - _Y0) / _CELL, _ROWS - 1.001)
    i, j = int(u), int(v)
    u, v = u - i, v - j
    k = j * _COLUMNS + i
    one = (1.0 - u) * vertices[k].position[2] + u * vertices[k + 1].position[2]
    other = (1.0 - u) * vertices[k + _COLUMNS].position[2] + u * vertices[k + _COLUMNS + 1].position[2]
    return (1.0 - v) * one + v * other
