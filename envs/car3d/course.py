"""GCar3D's courses: road, hills and obstacles of an episode, from its draws and its difficulty."""

from __future__ import annotations

import math

from gsenv.envs.car3d import scene as n
from gsenv.envs.core.kernels import active_contacts
from gsenv.solver.core.edit import enable_body, place_body, sleep_body
from gsenv.solver.core.trig import atan2, sin_cos
from gsenv.solver.jit import njit
from gsenv.solver.spatial.math import multiply, turn_about, turned

BENDS = ((40.0, 56.0), (20.0, 28.0))  # m, ranges of the wave lengths of the centre line
BEND_SLOPES = (0.3, 0.15)  # dy/dx of the waves at difficulty 0
BEND_GROWTH = (0.5, 0.45)  # what difficulty 1 adds
RISES = ((14.0, 20.0), (30.0, 45.0))  # m, of its height
RISE_SLOPES = (0.02, 0.03)
RISE_GROWTH = (0.16, 0.14)
HILL_LENGTHS = (13.0, 19.0)  # m, of the hills beside the road
HILLS = 0.8  # m
HILL_GROWTH = 1.4  # m
OFTEN = 2.5  # times the difficulty: how likely a slot has its obstacle
LEVEL_START = 6.0  # m, where bends and rises begin
BLEND = 6.0  # m
LEVEL_HALF = 3.0  # m, of the road at an obstacle
DRAWS_PER_SLOT = 3
WAVES = 2
DRAW_COUNT = 4 * WAVES + 2 + 2 * (n.RAMPS + n.BUMPS + n.BOX_GROUPS) + DRAWS_PER_SLOT * n.SLOTS
KINDS = n.RAMPS + n.BUMPS + n.BOX_GROUPS

_X0, _STEP, _NODES = n.FIRST_X, n.STEP, n.NODES
_COLUMNS, _ROWS, _CELL, _Y0 = n.COLUMNS, n.ROWS, n.CELL, -n.HALF_DEPTH
_BENDS = tuple(low for low, _ in BENDS)
_BEND_SPANS = tuple(high - low for low, high in BENDS)
_RISES = tuple(low for low, _ in RISES)
_RISE_SPANS = tuple(high - low for low, high in RISES)
_HX, _HY = HILL_LENGTHS
_SHOULDER, _VERGE = n.SHOULDER, n.VERGE
_SLOTS, _FIRST_SLOT, _SLOT_SPACING = n.SLOTS, n.FIRST_SLOT, n.SLOT_SPACING
_RAMPS, _BUMPS = n.RAMPS, n.BUMPS
_STRIPS, _STRIP, _DASH_SPACING, _LIFT = n.STRIPS, n.STRIP, n.DASH_SPACING, n.LIFT
_STRIP_SHAPE, _DASH_SHAPE = n.FIRST_STRIP_SHAPE, n.FIRST_DASH_SHAPE
_ARCH, _RED, _RAMP_BODY, _BUMP_BODY, _BOX_BODY = n.FIRST_ARCH, n.FIRST_RED, n.FIRST_RAMP, n.FIRST_BUMPS, n.FIRST_BOX
_FINISH_BODY, _FINISH_X = n.FINISH_BODY, n.FINISH_X
_GROUP, _BOX_HALF = n.GROUP_BOXES, n.BOX_HALF
_TWO_PI = 2.0 * math.pi
_UP = (0.0, 0.0, 1.0)
_LEFT = (0.0, 1.0, 0.0)
_Y, _Z, _S = 0, 1, 2  # columns of the path


# ---------------------------------------------------------------- centre line


@njit
def _smooth(x):  # type: ignore[no-untyped-def]
    """Return a smooth step: 0 below 0, 1 above 1, and a cubic with level ends in between."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@njit
def slot_x(slot):  # type: ignore[no-untyped-def]
    """Return x in m of the middle of a slot."""
    return _FIRST_SLOT + slot * _SLOT_SPACING


@njit
def path_at(path, x, column):  # type: ignore[no-untyped-def]
    """Return y (0), z (1) or the length from the start (2) of the centre line at x, interpolated between nodes."""
    place = min(max((x - _X0) / _STEP, 0.0), _NODES - 1.001)
    i = int(place)
    low = path[i, column]
    return low + (place - i) * (path[i + 1, column] - low)


@njit
def path_slope(path, x, column):  # type: ignore[no-untyped-def]
    """Return the derivative of a column with respect to x."""
    return (path_at(path, x + _STEP, column) - path_at(path, x - _STEP, column)) / (2.0 * _STEP)


@njit
def nearest(path, x, y):  # type: ignore[no-untyped-def]
    """Return x in m of the nearest point of the centre line, and the distance in m to the left of it.

    Four damped Newton iterations from the point beside; they converge within the road's own radius of curvature.
    """
    at = x
    for _ in range(4):
        m = path_slope(path, at, _Y)
        at += ((x - at) + (y - path_at(path, at, _Y)) * m) / (1.0 + m * m)
    m = path_slope(path, at, _Y)
    c = 1.0 / math.sqrt(1.0 + m * m)
    return at, c * ((y - path_at(path, at, _Y)) - (x - at) * m)


@njit
def path_x(path, s, x):  # type: ignore[no-untyped-def]
    """Return x at the length s (m) of the centre line, searched from x on, forwards."""
    i = int(min(max((x - _X0) / _STEP, 0.0), _NODES - 2.0))
    while i < _NODES - 2 and path[i + 1, _S] < s:
        i += 1
    share = (s - path[i, _S]) / (path[i + 1, _S] - path[i, _S])
    return _X0 + _STEP * (i + min(max(share, 0.0), 1.0))


@njit
def _level_share(x, kinds):  # type: ignore[no-untyped-def]
    """Return the factor of the road's slope at x: 0 at the start, at obstacles and beyond the finish, else 1."""
    share = _smooth((x - LEVEL_START) / BLEND) * _smooth((_FINISH_X + 8.0 - x) / BLEND)
    slot = math.floor((x - _FIRST_SLOT) / _SLOT_SPACING + 0.5)
    if 0 <= slot < _SLOTS and kinds[slot] >= 0:
        share *= _smooth((abs(x - slot_x(slot)) - LEVEL_HALF) / 4.0)
    return share


@njit
def _lay_path(difficulty, draws, kinds, path):  # type: ignore[no-untyped-def]
    """Set y, z and length of the nodes of the centre line, as sums of slopes."""
    y, z, s = 0.0, 0.0, 0.0
    for i in range(_NODES):
        x = _X0 + _STEP * (i - 0.5)
        bend, rise = 0.0, 0.0
        for k in range(WAVES):
            length = _BENDS[k] + _BEND_SPANS[k] * draws[4 * k]
            steep = BEND_SLOPES[k] + BEND_GROWTH[k] * difficulty
            bend += steep * sin_cos(_TWO_PI * (x / length + draws[4 * k + 1]))[0]
            length = _RISES[k] + _RISE_SPANS[k] * draws[4 * k + 2]
            steep = RISE_SLOPES[k] + RISE_GROWTH[k] * difficulty
            rise += steep * sin_cos(_TWO_PI * (x / length + draws[4 * k + 3]))[0]
        bend *= _smooth((x - LEVEL_START) / BLEND)
        # The farther the road is from the middle of the field, the more it turns back.
        bend -= 0.004 * y * abs(y) * _smooth((abs(y) - 4.0) / 4.0)
        rise *= _level_share(x, kinds)
        if i > 0:
            y += _STEP * bend
            z += _STEP * rise
            s += _STEP * math.sqrt(1.0 + bend * bend + rise * rise)
        path[i, _Y], path[i, _Z], path[i, _S] = y, z, s
    start = path_at(path, 0.0, _S)
    for i in range(_NODES):
        path[i, _S] -= start


# ---------------------------------------------------------------- ground


@njit
def _raise_ground(difficulty, draws, path, vertices):  # type: ignore[no-untyped-def]
    """Set the heights of the field: level across the road, hills beside it."""
    hill = HILLS + HILL_GROWTH * difficulty
    low, high = math.inf, -math.inf
    for i in range(_COLUMNS):
        x = _X0 + _CELL * i
        along = sin_cos(_TWO_PI * (x / _HX + draws[0]))[0]
        for j in range(_ROWS):
            y = _Y0 + _CELL * j
            at, aside = nearest(path, x, y)
            share = _smooth((abs(aside) - _SHOULDER) / _VERGE)
            road = (1.0 - share) * path_at(path, at, _Z) + share * path_at(path, x, _Z)
            across = sin_cos(_TWO_PI * (y / _HY + draws[1]))[0]
            z = road + share * hill * (0.45 + 0.35 * along + 0.5 * along * across)
            vertices[j * _COLUMNS + i].position[2] = z
            low, high = min(low, z), max(high, z)
    vertices[0].normal[0], vertices[0].normal[1] = low, high


@njit
def ground_at(vertices, x, y):  # type: ignore[no-untyped-def]
    """Return the height in m of the field at (x, y), bilinear between its samples."""
    u = min(max((x - _X0) / _CELL, 0.0), _COLUMNS - 1.001)
    v = min(max((y - _Y0) / _CELL, 0.0), _ROWS - 1.001)
    i, j = int(u), int(v)
    u, v = u - i, v - j
    k = j * _COLUMNS + i
    one = (1.0 - u) * vertices[k].position[2] + u * vertices[k + 1].position[2]
    other = (1.0 - u) * vertices[k + _COLUMNS].position[2] + u * vertices[k + _COLUMNS + 1].position[2]
    return (1.0 - v) * one + v * other


# ---------------------------------------------------------------- things on the road


@njit
def road_turn(path, x):  # type: ignore[no-untyped-def]
    """Return the rotation whose x axis points along the road at x, and whose y axis is level."""
    m, rise = path_slope(path, x, _Y), path_slope(path, x, _Z)
    yaw = turn_about(_UP, atan2(m, 1.0))
    return multiply(yaw, turn_about(_LEFT, -atan2(rise, math.sqrt(1.0 + m * m))))


@njit
def place_thing(world, b, at, turn):  # type: ignore[no-untyped-def]
    """Place body b, enabled and at rest."""
    parameters = world.parameters.bodies
    still = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    place_body(b, world.state.bodies, parameters, active_contacts(world), at, turn, still)
    enable_body(parameters[b])


@njit
def road_point(path, x):  # type: ignore[no-untyped-def]
    """Return the point of the centre line at x."""
    return (x, path_at(path, x, _Y), path_at(path, x, _Z))


@njit
def _write_shape(shape, at, turn):  # type: ignore[no-untyped-def]
    for d in range(3):
        shape.local_position[d] = at[d]
    for d in range(4):
        shape.local_rotation[d] = turn[d]


@njit
def _paint_road(world, path):  # type: ignore[no-untyped-def]
    """Place the strips and dashes of the road, which are only drawn, along the centre line."""
    shapes = world.parameters.shapes
    x = -3.0
    for k in range(_STRIPS):
        s = path_at(path, x, _S) + 0.5 * _STRIP
        middle = path_x(path, s, x)
        at = road_point(path, middle)
        turn = road_turn(path, middle)
        _write_shape(shapes[_STRIP_SHAPE + k], (at[0], at[1], at[2] + _LIFT), turn)
        if k % _DASH_SPACING == 0:
            _write_shape(shapes[_DASH_SHAPE + k // _DASH_SPACING], (at[0], at[1], at[2] + _LIFT + 0.006), turn)
        x = path_x(path, s + 0.5 * _STRIP, middle)


@njit
def _scatter_boxes(world, k, path, x, draws):  # type: ignore[no-untyped-def]
    """Place a row of loose boxes across the road at x; they sleep until something touches them."""
    turn = road_turn(path, x)
    for i in range(_GROUP):
        aside = 1.35 * (i - 1) + 0.5 * (draws[i] - 0.5)
        forth = 0.9 * (draws[(i + 1) % _GROUP] - 0.5)
        offset = turned(turn, (forth, aside, _BOX_HALF + 1e-3))
        at = road_point(path, x)
        b = _BOX_BODY + k * _GROUP + i
        place_thing(world, b, (at[0] + offset[0], at[1] + offset[1], at[2] + offset[2]), turn)
        sleep_body(world.state.bodies[b])


@njit
def _deal(difficulty, draws, kinds):  # type: ignore[no-untyped-def]
    """Draw the obstacle of each slot from a shuffled deck with two of each kind; -1 is none."""
    for k in range(KINDS):
        kinds[k] = k
    for k in range(KINDS - 1, 0, -1):
        other = int(draws[2 * k] * (k + 1))
        kinds[k], kinds[other] = kinds[other], kinds[k]
    for k in range(KINDS):
        if k >= _SLOTS or draws[2 * k + 1] >= OFTEN * difficulty:
            kinds[k] = -1


@njit
def build_course(world, difficulty, draws):  # type: ignore[no-untyped-def]
    """Build road, ground and obstacles of one world; fill the task state's `kinds` and `path`."""
    kinds, path, vertices = world.task.state.kinds, world.task.state.path, world.parameters.vertices
    own = draws[4 * WAVES + 2 :]
    _deal(difficulty, own, kinds)
    _lay_path(difficulty, draws, kinds, path)
    _raise_ground(difficulty, draws[4 * WAVES :], path, vertices)
    _paint_road(world, path)
    for slot in range(_SLOTS):
        kind = kinds[slot]
        if kind < 0:
            continue
        x = slot_x(slot)
        at, turn = road_point(path, x), road_turn(path, x)
        place_thing(world, _ARCH + slot, at, turn)
        place_thing(world, _RED + slot, at, turn)
        if kind < _RAMPS:
            place_thing(world, _RAMP_BODY + kind, at, turn)
        elif kind < _RAMPS + _BUMPS:
            place_thing(world, _BUMP_BODY + kind - _RAMPS, at, turn)
        else:
            _scatter_boxes(world, kind - _RAMPS - _BUMPS, path, x, own[2 * KINDS + DRAWS_PER_SLOT * slot :])
    for k in range(3):
        place_thing(world, _FINISH_BODY + k, road_point(path, _FINISH_X), road_turn(path, _FINISH_X))
