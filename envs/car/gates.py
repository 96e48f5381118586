"""GCar's gates: one at each bridge and each see-saw, which both wheels must pass on what lies below its bar."""

from __future__ import annotations

from gsenv.envs.car import scene
from gsenv.envs.car.course import height_at, place_thing, slot_x
from gsenv.solver.jit import njit

_SLOTS = scene.SLOTS
_GATES = scene.GATES
_HALF = scene.GATE_HALF
_REACH = scene.GATE_REACH
_PARKED = scene.PARKED_Y
_ARCH = scene.FIRST_ARCH
_RED = scene.FIRST_RED
_GREEN = scene.FIRST_GREEN
_REAR = scene.REAR_BODY


@njit
def next_gate(kinds, slot):  # type: ignore[no-untyped-def]
    """Return the first slot with a gate from `slot` on, or the number of slots; bridges and see-saws have gates."""
    while slot < _SLOTS and not 0 <= kinds[slot] < _GATES:
        slot += 1
    return slot


@njit
def place_gates(world):  # type: ignore[no-untyped-def]
    """Put arches with red bars over the bridges and see-saws of the course; begin with the first gate."""
    task, vertices = world.task.state, world.parameters.vertices
    slot = next_gate(task.kinds, 0)
    task.gate = slot
    while slot < _SLOTS:
        k, x = task.kinds[slot], slot_x(slot)
        y = height_at(x - _REACH, vertices)
        place_thing(world, _ARCH + k, x, y, 0.0)
        place_thing(world, _RED + k, x, y, 0.0)
        slot = next_gate(task.kinds, slot + 1)


@njit
def _turn_green(world, k):  # type: ignore[no-untyped-def]
    """Replace the red bar of gate k by a green one."""
    arch = world.state.bodies[_ARCH + k].position
    center = world.parameters.bodies[_ARCH + k].center
    place_thing(world, _GREEN + k, arch[0] - center[0], arch[1] - center[1], 0.0)
    place_thing(world, _RED + k, arch[0], _PARKED, 0.0)


@njit
def pass_gates(world):  # type: ignore[no-untyped-def]
    """Note wheels that touch something below the bar of the next gate; return whether a wheel has missed it."""
    task, bodies = world.task.state, world.state.bodies
    if task.gate >= _SLOTS:
        return False
    x = slot_x(task.gate)
    for k in range(2):
        ahead = bodies[_REAR + k].position[0] - x
        if task.touch[k] != 0.0 and abs(ahead) <= _HALF:
            task.below[k] = 1.0
        if ahead > _HALF and task.below[k] == 0.0:
            return True
    if task.below[0] != 0.0 and task.below[1] != 0.0:
        _turn_green(world, task.kinds[task.gate])
        task.gates += 1
        task.gate = next_gate(task.kinds, task.gate + 1)
        task.below[0] = task.below[1] = 0.0
    return False
