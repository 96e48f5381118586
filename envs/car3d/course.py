"""GCar3D's courses: road, ground and obstacles of an episode, from its draws and its difficulty."""

from __future__ import annotations

from gsenv.envs.car3d import scene as n
from gsenv.envs.car3d.road import (
    ROAD_DRAWS,
    lay_path,
    raise_ground,
    road_point,
    road_turn,
)
from gsenv.envs.core.kernels import active_contacts, between
from gsenv.solver.core.edit import enable_body, place_body, sleep_body
from gsenv.solver.jit import njit
from gsenv.solver.spatial.math import add, turned

OFTEN = 2.5  # times the difficulty: how likely a slot has its obstacle
SLOT_JITTER = 2.0  # m, to both sides
KINDS = n.RAMPS + n.BUMPS + n.BALL_GROUPS
SLOT_DRAWS = 1 + n.GROUP_BALLS
DRAW_COUNT = ROAD_DRAWS + 2 * KINDS + SLOT_DRAWS * n.SLOTS
FAR = 1e9  # m, place of slots without an obstacle

_SLOTS, _FIRST_SLOT, _SLOT_SPACING = n.SLOTS, n.FIRST_SLOT, n.SLOT_SPACING
_RAMPS, _BUMPS = n.RAMPS, n.BUMPS
_GATE_AHEAD = n.GATE_AHEAD
_ARCH, _RED, _RAMP_BODY, _BUMP_BODY, _BALL_BODY = n.FIRST_ARCH, n.FIRST_RED, n.FIRST_RAMP, n.FIRST_BUMPS, n.FIRST_BALL
_FINISH_BODY, _FINISH = n.FINISH_BODY, n.FINISH
_GROUP, _BALL_RADIUS, _PARKED = n.GROUP_BALLS, n.BALL_RADIUS, n.PARKED_Z


@njit
def class_of(kind):  # type: ignore[no-untyped-def]
    """Return 0 for ramps, 1 for bumps, 2 for balls."""
    if kind < _RAMPS:
        return 0
    return 1 if kind < _RAMPS + _BUMPS else 2


@njit
def gate_place(task, slot):  # type: ignore[no-untyped-def]
    """Return s in m of the gate of a slot that has an obstacle."""
    return task.places[slot] + _GATE_AHEAD[class_of(task.kinds[slot])]


@njit
def place_thing(world, b, at, turn):  # type: ignore[no-untyped-def]
    """Place body b, enabled and at rest."""
    parameters = world.parameters.bodies
    still = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    place_body(b, world.state.bodies, parameters, active_contacts(world), at, turn, still)
    enable_body(parameters[b])


@njit
def _scatter_balls(world, first, at, turn, draws):  # type: ignore[no-untyped-def]
    """Place a row of loose balls across the road, from body `first` on; they sleep until something touches them."""
    for i in range(_GROUP):
        aside = 1.35 * (i - 1) + 0.5 * (draws[i] - 0.5)
        forth = 0.9 * (draws[(i + 1) % _GROUP] - 0.5)
        offset = turned(turn, (forth, aside, _BALL_RADIUS + 1e-3))
        place_thing(world, first + i, add(at, offset), turn)
        sleep_body(world.state.bodies[first + i])


@njit
def _deal(difficulty, draws, task):  # type: ignore[no-untyped-def]
    """Draw kind and place of the obstacle of each slot, from a shuffled deck with two of each kind; -1 is none."""
    kinds = task.kinds
    for k in range(KINDS):
        kinds[k] = k
    for k in range(KINDS - 1, 0, -1):
        other = int(draws[2 * k] * (k + 1))
        kinds[k], kinds[other] = kinds[other], kinds[k]
    for k in range(KINDS):
        if k >= _SLOTS or draws[2 * k + 1] >= OFTEN * difficulty:
            kinds[k] = -1
    for slot in range(_SLOTS):
        jitter = between(-SLOT_JITTER, SLOT_JITTER, draws[2 * KINDS + SLOT_DRAWS * slot])
        task.places[slot] = _FIRST_SLOT + slot * _SLOT_SPACING + jitter if kinds[slot] >= 0 else FAR


@njit
def _build_obstacle(world, slot, draws):  # type: ignore[no-untyped-def]
    """Place the obstacle of a slot and its gate."""
    task = world.task.state
    path, kind = task.path, task.kinds[slot]
    at, turn = road_point(path, task.places[slot]), road_turn(path, task.places[slot])
    if kind < _RAMPS:
        place_thing(world, _RAMP_BODY + kind, at, turn)
    elif kind < _RAMPS + _BUMPS:
        place_thing(world, _BUMP_BODY + kind - _RAMPS, at, turn)
    else:
        _scatter_balls(world, _BALL_BODY + (kind - _RAMPS - _BUMPS) * _GROUP, at, turn, draws)
    gate = gate_place(task, slot)
    at, turn = road_point(path, gate), road_turn(path, gate)
    place_thing(world, _ARCH + slot, at, turn)
    place_thing(world, _RED + slot, at, turn)


@njit
def build_course(world, difficulty, draws):  # type: ignore[no-untyped-def]
    """Build road, ground and obstacles of one world; fill the task state's `kinds`, `places` and `path`."""
    task = world.task.state
    own = draws[ROAD_DRAWS:]
    _deal(difficulty, own, task)
    lay_path(difficulty, draws, task.places, task.path)
    raise_ground(difficulty, draws[ROAD_DRAWS - 2 :], task.path, world.parameters.vertices)
    for slot in range(_SLOTS):
        if task.kinds[slot] >= 0:
            _build_obstacle(world, slot, own[2 * KINDS + SLOT_DRAWS * slot + 1 :])
    for k in range(3):
        place_thing(world, _FINISH_BODY + k, road_point(task.path, _FINISH), road_turn(task.path, _FINISH))
