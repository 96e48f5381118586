"""GCar3D's observations, as kernels."""

from __future__ import annotations

import math

from gsenv.envs.car3d import scene as n
from gsenv.envs.car3d.course import class_of, gate_place
from gsenv.envs.car3d.road import HEADING, ground_at, path_slope, road_point
from gsenv.envs.core.kernels import clip
from gsenv.solver.jit import njit
from gsenv.solver.spatial.math import conjugate, quaternion, sub, turned, vec

AHEAD = (3.0, 6.0, 10.0, 15.0, 20.0)  # m along the centre line, of the waypoints
LOOK = 20.0  # m, the unit of waypoints
BENDS_AHEAD = (0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5)  # m along the centre line, where its curvature is seen
BEND_UNIT = 0.25  # 1/m
PATCH_ROWS, PATCH_COLUMNS = 7, 5
FIRST_ROW, ROW_SPACING = 0.8, 0.8  # m ahead of the middle of the car
COLUMN_SPACING = 0.6  # m
SPEED_UNIT, SPIN_UNIT, HEIGHT_UNIT = 10.0, 3.0, 1.0
FLIGHT_STEPS = 15  # without a wheel on anything, after which progress is not paid
TIME_UNIT = 600  # control steps

_CHASSIS, _WHEEL = n.CHASSIS_BODY, n.FIRST_WHEEL
_RADIUS, _TRAVEL, _STEERING, _CHASSIS_Z = n.RADIUS, n.TRAVEL, n.STEERING, n.CHASSIS_Z
_SLOTS, _FINISH, _ROAD_HALF = n.SLOTS, n.FINISH, n.ROAD_HALF
_RAMPS, _BUMPS, _GROUP = n.RAMPS, n.BUMPS, n.GROUP_BALLS
_RAMP_BODY, _BUMP_BODY, _BALL_BODY = n.FIRST_RAMP, n.FIRST_BUMPS, n.FIRST_BALL
_BASE, _TOP, _RAMP_HEIGHT, _RAMP_HALF = n.RAMP_BASE, n.RAMP_TOP, n.RAMP_HEIGHT, n.RAMP_HALF
_BUMP_SPACING, _BUMP_RADIUS, _BUMP_HEIGHT, _BALL_RADIUS = n.BUMP_SPACING, n.BUMP_RADIUS, n.BUMP_HEIGHT, n.BALL_RADIUS


@njit
def _profile(kind, x, y):  # type: ignore[no-untyped-def]
    """Return the height in m of a ramp (0) or a group of bumps (1) at (x, y) in its own frame; 0 beside it."""
    if kind == 0:
        if abs(y) > _RAMP_HALF:
            return 0.0
        return _RAMP_HEIGHT * min(max((_BASE - abs(x)) / (_BASE - _TOP), 0.0), 1.0)
    height = 0.0
    for k in range(-1, 2):
        off = x - k * _BUMP_SPACING
        square = _BUMP_RADIUS * _BUMP_RADIUS - off * off
        if square > 0.0 and abs(y) <= _ROAD_HALF:
            height = max(height, math.sqrt(square) + _BUMP_HEIGHT - _BUMP_RADIUS)
    return height


@njit
def surface_at(world, slot, x, y):  # type: ignore[no-untyped-def]
    """Return the height in m of what a wheel would meet at (x, y): ground, or the obstacle of a slot (-1: none)."""
    bodies = world.state.bodies
    height = ground_at(world.parameters.vertices, x, y)
    kind = world.task.state.kinds[slot] if slot >= 0 else -1
    if 0 <= kind < _RAMPS + _BUMPS:
        fixed = bodies[_RAMP_BODY + kind]  # bumps come behind ramps
        back = conjugate(quaternion(fixed.rotation))
        local = turned(back, sub((x, y, height), vec(fixed.position)))
        height += _profile(0 if kind < _RAMPS else 1, local[0], local[1])
    elif kind >= 0:
        first = _BALL_BODY + (kind - _RAMPS - _BUMPS) * _GROUP
        for b in range(first, first + _GROUP):
            ball = bodies[b].position
            square = _BALL_RADIUS * _BALL_RADIUS - (x - ball[0]) * (x - ball[0]) - (y - ball[1]) * (y - ball[1])
            if square > 0.0:
                height = max(height, ball[2] + math.sqrt(square))
    return height


@njit
def _observe_patch(world, out, slot):  # type: ignore[no-untyped-def]
    """Write the heights of a patch ahead, above the level ground that the chassis would stand on."""
    chassis = world.state.bodies[_CHASSIS]
    ahead = turned(quaternion(chassis.rotation), (1.0, 0.0, 0.0))
    flat = math.sqrt(max(ahead[0] * ahead[0] + ahead[1] * ahead[1], 1e-12))
    c, s = ahead[0] / flat, ahead[1] / flat
    for i in range(PATCH_ROWS):
        for j in range(PATCH_COLUMNS):
            forth = FIRST_ROW + ROW_SPACING * i
            aside = COLUMN_SPACING * (PATCH_COLUMNS // 2 - j)
            x = chassis.position[0] + c * forth - s * aside
            y = chassis.position[1] + s * forth + c * aside
            height = surface_at(world, slot, x, y) - chassis.position[2] + _CHASSIS_Z
            out[i * PATCH_COLUMNS + j] = height / HEIGHT_UNIT


@njit
def _nearest_slot(task):  # type: ignore[no-untyped-def]
    """Return the slot whose obstacle the patch may show: the one nearest to 3 m ahead, or -1."""
    found, least = -1, 7.0
    for slot in range(_SLOTS):
        off = abs(task.places[slot] - task.place - 3.0)
        if task.kinds[slot] >= 0 and off < least:
            found, least = slot, off
    return found


@njit
def _observe_wheels(world, out, back):  # type: ignore[no-untyped-def]
    """Write for each wheel its rolling speed, the compression of its suspension, and whether it touches something."""
    task, chassis = world.task.state, world.state.bodies[_CHASSIS]
    for k in range(4):
        wheel = world.state.bodies[_WHEEL + k]
        spin = turned(back, (wheel.velocity[3], wheel.velocity[4], wheel.velocity[5]))
        place = turned(back, sub(vec(wheel.position), vec(chassis.position)))
        out[k] = spin[1] * _RADIUS / SPEED_UNIT
        out[4 + k] = (place[2] + _CHASSIS_Z - _RADIUS) / _TRAVEL
        out[8 + k] = task.touch[k]


@njit
def _observe_gate(task, out):  # type: ignore[no-untyped-def]
    """Write the distance to the next gate, and which kind of obstacle it belongs to."""
    out[0], out[1], out[2], out[3] = 2.0, 0.0, 0.0, 0.0
    if task.slot < _SLOTS:
        out[0] = (gate_place(task, task.slot) - task.place) / 10.0
        out[1 + class_of(task.kinds[task.slot])] = 1.0


@njit
def observe_world(world):  # type: ignore[no-untyped-def]
    """Write all observations of a world, clipped to their bounds."""
    task, out, chassis = world.task.state, world.task.observation, world.state.bodies[_CHASSIS]
    back = conjugate(quaternion(chassis.rotation))
    velocity, position = chassis.velocity, vec(chassis.position)
    moves = turned(back, (velocity[0], velocity[1], velocity[2]))
    turns = turned(back, (velocity[3], velocity[4], velocity[5]))
    up = turned(back, (0.0, 0.0, 1.0))
    for d in range(3):
        out[d] = moves[d] / SPEED_UNIT
        out[3 + d] = turns[d] / SPIN_UNIT
        out[6 + d] = up[d]
    _observe_wheels(world, out[9:], back)
    out[21] = task.steering / _STEERING
    out[22], out[23] = task.action[0], task.action[1]
    out[24] = task.aside / _ROAD_HALF
    out[25] = task.flight / FLIGHT_STEPS
    out[26] = (_FINISH - task.place) / 100.0
    out[27] = task.steps / TIME_UNIT
    _observe_gate(task, out[28:])
    for k in range(len(AHEAD)):
        seen = turned(back, sub(road_point(task.path, task.place + AHEAD[k]), position))
        for d in range(3):
            out[32 + 3 * k + d] = seen[d] / LOOK
    for k in range(len(BENDS_AHEAD)):
        out[47 + k] = path_slope(task.path, task.place + BENDS_AHEAD[k], HEADING) / BEND_UNIT
    _observe_patch(world, out[55:], _nearest_slot(task))
    clip(out, world.task.low, world.task.high)
