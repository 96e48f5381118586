"""GCar's courses: hills and obstacles of an episode, from its draws and its difficulty."""

from __future__ import annotations

import math

from gsenv.envs.car import scene
from gsenv.envs.core.kernels import active_contacts, smooth, within
from gsenv.solver.core.edit import enable_body, enable_joint, place_body, set_box, set_inertia, set_mass, sleep_body
from gsenv.solver.core.trig import sin_cos
from gsenv.solver.jit import njit
from gsenv.solver.planar.edit import set_capsule_size
from gsenv.solver.planar.vertices import derive_outline

HILLS = ((5.5, 8.0), (9.0, 14.0), (18.0, 28.0))  # m, ranges of the wave lengths
LEAST_SLOPE = 0.01  # of each wave, at difficulty 0
SLOPE = 1.0  # what difficulty 1 adds
STEEPEST = 0.8  # that the waves come near where they meet
DRAWS_PER_SLOT = 8
DRAW_COUNT = 2 * len(HILLS) + scene.SLOTS * (2 + DRAWS_PER_SLOT)
FLAT_START = 3.0  # m, where the hills begin
FLAT_HALF = 3.4  # m, of the ground around an obstacle
BLEND = 2.5  # m, from there to the hills
REST_GAP = 0.001  # m, between a see-saw's end and the ground
OFTEN = 2.5  # times the difficulty: how likely a slot has its obstacle

_SLOTS = scene.SLOTS
_FIRST_SLOT = scene.FIRST_SLOT
_SLOT_SPACING = scene.SLOT_SPACING
_SPACING = scene.SPACING
_FIRST_X = scene.FIRST_X
_VERTICES = scene.VERTICES
_WALL_X = scene.WALL_X
_WALL_HEIGHT = scene.WALL_HEIGHT
_FINISH = scene.FINISH
_BRIDGES = scene.BRIDGES
_PLANKS = scene.PLANKS
_HINGES = scene.HINGES
_PLANK_RADIUS = scene.PLANK_RADIUS
_PLANK_MASS = scene.PLANK_MASS
_BEND = scene.BRIDGE_BEND
_GAP_DEPTH = scene.GAP_DEPTH
_SEESAWS = scene.SEESAWS
_THICK = scene.BOARD_THICKNESS
_BOARD_MASS = scene.BOARD_MASS
_BOARD_OFFSET = scene.BOARD_OFFSET
_GROUP = scene.GROUP_BOXES
_BOX_DENSITY = scene.BOX_DENSITY
_PLANK_BODY = scene.FIRST_PLANK
_BOARD_BODY = scene.FIRST_BOARD
_FULCRUM_BODY, _WEDGE_HALF = scene.FIRST_FULCRUM, scene.WEDGE_HALF
_BOX_BODY = scene.FIRST_BOX
_FLAG_BODY = scene.FLAG_BODY
_SHAPE_OFFSET = scene.FIRST_OBSTACLE_SHAPE - scene.FIRST_PLANK
_HINGE = scene.FIRST_HINGE
_PIVOT = scene.FIRST_PIVOT
_WAVES = len(HILLS)
_LENGTHS = tuple(low for low, _ in HILLS)
_LENGTH_SPANS = tuple(high - low for low, high in HILLS)
_TWO_PI = 2.0 * math.pi


# ---------------------------------------------------------------- hills


@njit
def _slope(x, difficulty, draws):  # type: ignore[no-untyped-def]
    """Return the slope at x (m) of the hills without obstacles."""
    slope = 0.0
    for i in range(_WAVES):
        length = _LENGTHS[i] + _LENGTH_SPANS[i] * draws[2 * i]
        slope += sin_cos(_TWO_PI * (x / length + draws[2 * i + 1]))[0]
    slope *= LEAST_SLOPE + SLOPE * difficulty
    return slope / math.sqrt(1.0 + (slope / STEEPEST) * (slope / STEEPEST))


@njit
def slot_x(slot):  # type: ignore[no-untyped-def]
    """Return x in m of the middle of a slot, which is on a vertex of the terrain."""
    return _FIRST_X + _SPACING * math.floor((_FIRST_SLOT + slot * _SLOT_SPACING - _FIRST_X) / _SPACING)


@njit
def _hilliness(x, kinds):  # type: ignore[no-untyped-def]
    """Return the factor of the slope at x: 1 in the hills, 0 on the flat ground of the start and of obstacles."""
    share = smooth((x - FLAT_START) / BLEND)
    slot = math.floor((x - _FIRST_SLOT) / _SLOT_SPACING + 0.5)
    if 0 <= slot < _SLOTS and kinds[slot] >= 0:
        share *= smooth((abs(x - slot_x(slot)) - FLAT_HALF) / BLEND)
    return share


@njit
def _shape_terrain(difficulty, draws, kinds, vertices):  # type: ignore[no-untyped-def]
    """Set the terrain's heights as sums of slopes, so that no obstacle makes the ground beside it steeper."""
    height = 0.0
    for i in range(_VERTICES):
        x = _FIRST_X + _SPACING * (i - 0.5)
        share = _hilliness(x, kinds)
        if share > 0.0:
            height += _SPACING * share * _slope(x, difficulty, draws)
        vertices[i].position[1] = height
    for i in range(_VERTICES):
        if vertices[i].position[0] < _WALL_X:
            vertices[i].position[1] += _WALL_HEIGHT


@njit
def height_at(x, vertices):  # type: ignore[no-untyped-def]
    """Return the height in m of the terrain at x, interpolated between its vertices."""
    place = within((x - _FIRST_X) / _SPACING, _VERTICES - 1.001)
    i = int(place)
    low = vertices[i].position[1]
    return low + (place - i) * (vertices[i + 1].position[1] - low)


# ---------------------------------------------------------------- obstacles


@njit
def place_thing(world, b, x, y, sine):  # type: ignore[no-untyped-def]
    """Place body b of an obstacle, a gate or a mark, enabled and at rest, rotated by the angle with this sine."""
    turn = (math.sqrt(1.0 - sine * sine), sine, math.asin(sine))
    parameters = world.parameters.bodies
    place_body(b, world.state.bodies, parameters, active_contacts(world), (x, y), turn, (0.0, 0.0, 0.0))
    enable_body(parameters[b])


@njit
def _build_bridge(world, k, slot, difficulty, draws):  # type: ignore[no-untyped-def]
    """Build a gap, and planks that hang across it in an arc and are hinged to its edges."""
    vertices = world.parameters.vertices
    cells = int(10.0 + difficulty * (4.0 + 6.0 * draws[0]))
    first = int((slot_x(slot) - _FIRST_X) / _SPACING + 0.5) - cells // 2
    top = vertices[first].position[1]
    for i in range(first + 1, first + cells):
        vertices[i].position[1] -= _GAP_DEPTH
    left = _FIRST_X + _SPACING * first
    _hang_planks(world, k, left, top, _SPACING * cells)


@njit
def _hang_planks(world, k, left, top, width):  # type: ignore[no-untyped-def]
    """Place the planks of bridge k over a gap that starts at x = `left`; its ends are at the height `top` (m)."""
    radius = 0.5 * width / sin_cos(_BEND)[1]
    half = radius * sin_cos(_BEND / _PLANKS)[1]
    mass = 2.0 * half * _PLANK_MASS
    x, y = left, top - _PLANK_RADIUS
    for i in range(_PLANKS):
        c, s = sin_cos(_BEND * ((2.0 * i + 1.0) / _PLANKS - 1.0))
        b = _PLANK_BODY + k * _PLANKS + i
        body = world.parameters.bodies[b]
        set_capsule_size(body, world.parameters.shapes[_SHAPE_OFFSET + b], half, _PLANK_RADIUS)
        set_mass(body, mass)
        set_inertia(body, mass * half * half / 3.0)  # of a thin rod
        place_thing(world, b, x + half * c, y + half * s, s)
        x += 2.0 * half * c
        y += 2.0 * half * s
    _hinge_planks(world, k, half)
    joints = world.parameters.joints
    ends = joints[_HINGE + k * _HINGES], joints[_HINGE + k * _HINGES + _PLANKS]
    for i in range(2):
        ends[i].anchor_a[0] = left + i * width
        ends[i].anchor_a[1] = top - _PLANK_RADIUS
        ends[i].anchor_b[0] = (2.0 * i - 1.0) * half


@njit
def _hinge_planks(world, k, half):  # type: ignore[no-untyped-def]
    """Hinge bridge k, whose planks are 2 `half` m long, at both ends and between planks; put the planks to sleep."""
    first = _PLANK_BODY + k * _PLANKS
    for i in range(_HINGES):
        joint = world.parameters.joints[_HINGE + k * _HINGES + i]
        joint.anchor_a[0] = half
        joint.anchor_b[0] = -half
        left, right = max(i - 1, 0), min(i, _PLANKS - 1)
        enable_joint(joint, world.state.bodies[first + left], world.state.bodies[first + right])
    for i in range(_PLANKS):
        sleep_body(world.state.bodies[first + i])


@njit
def _build_seesaw(world, k, slot, difficulty, draws):  # type: ignore[no-untyped-def]
    """Build a board on a fulcrum, with its near end on the ground."""
    bodies, parameters = world.state.bodies, world.parameters.bodies
    middle = slot_x(slot)
    ground = height_at(middle, world.parameters.vertices)
    half = 2.0 + 0.5 * draws[0]
    height = 0.35 + 0.15 * draws[1] + 0.3 * difficulty
    sine = (height - REST_GAP) / (half + _BOARD_OFFSET)  # its lower corner just over the ground
    cosine = math.sqrt(1.0 - sine * sine)
    board, fulcrum = _BOARD_BODY + k, _FULCRUM_BODY + k
    set_box(parameters[board], world.parameters.shapes[_SHAPE_OFFSET + board], (half, _THICK), 2.0 * half * _BOARD_MASS)
    # The hinge is at the board's underside, a little past its middle.
    x = middle - cosine * _BOARD_OFFSET - sine * _THICK
    y = ground + height - sine * _BOARD_OFFSET + cosine * _THICK
    place_thing(world, board, x, y, sine)
    place_thing(world, fulcrum, middle, ground + height - 1.0, 0.0)
    _cut_wedge(world, fulcrum, height)
    enable_joint(world.parameters.joints[_PIVOT + k], bodies[fulcrum], bodies[board])
    sleep_body(bodies[board])


@njit
def _cut_wedge(world, b, height):  # type: ignore[no-untyped-def]
    """Move the lower corners of fulcrum b, a wedge of 1 m, along its sides up to the ground, `height` below its top.

    It touches nothing, so only pictures depend on it.
    """
    first = world.model.shapes[_SHAPE_OFFSET + b].vertex_first
    cut = min(max(1.0 - height, 0.0), 0.9)
    for i in range(first, first + 3):
        place = world.parameters.vertices[i].position
        if place[1] < 1.0:
            place[0] = (1.0 - cut) * math.copysign(_WEDGE_HALF, place[0])
            place[1] = cut


@njit
def _build_boxes(world, k, slot, difficulty, draws):  # type: ignore[no-untyped-def]
    """Build loose boxes in a row on the ground: one at low difficulty, three from difficulty 2/3 on."""
    count = min(1 + int(3.0 * difficulty), _GROUP)
    for i in range(count):
        half_x = 0.12 + 0.08 * draws[2 * i] + 0.08 * difficulty
        half_y = 0.06 + 0.04 * draws[2 * i + 1] + 0.08 * difficulty
        x = slot_x(slot) + 1.6 * (i - 0.5 * (count - 1))
        y = height_at(x, world.parameters.vertices) + half_y
        b = _BOX_BODY + k * _GROUP + i
        mass = 4.0 * half_x * half_y * _BOX_DENSITY
        set_box(world.parameters.bodies[b], world.parameters.shapes[_SHAPE_OFFSET + b], (half_x, half_y), mass)
        place_thing(world, b, x, y, 0.0)
        sleep_body(world.state.bodies[b])


@njit
def _deal(difficulty, draws, kinds):  # type: ignore[no-untyped-def]
    """Draw the obstacle of each slot from a shuffled deck with two of each kind; -1 is none."""
    for slot in range(_SLOTS):
        kinds[slot] = slot
    for slot in range(_SLOTS - 1, 0, -1):
        other = int(draws[2 * slot] * (slot + 1))
        kinds[slot], kinds[other] = kinds[other], kinds[slot]
    for slot in range(_SLOTS):
        if draws[2 * slot + 1] >= OFTEN * difficulty:
            kinds[slot] = -1


@njit
def build_course(world, difficulty, draws):  # type: ignore[no-untyped-def]
    """Build the terrain and obstacles of one world, whose obstacles are all parked; fill the task state's `kinds`."""
    kinds, vertices = world.task.state.kinds, world.parameters.vertices
    _deal(difficulty, draws[2 * _WAVES :], kinds)
    _shape_terrain(difficulty, draws, kinds, vertices)
    for slot in range(_SLOTS):
        kind = kinds[slot]
        own = draws[2 * _WAVES + 2 * _SLOTS + DRAWS_PER_SLOT * slot :]
        if kind < 0:
            continue
        if kind < _BRIDGES:
            _build_bridge(world, kind, slot, difficulty, own)
        elif kind < _BRIDGES + _SEESAWS:
            _build_seesaw(world, kind - _BRIDGES, slot, difficulty, own)
        else:
            _build_boxes(world, kind - _BRIDGES - _SEESAWS, slot, difficulty, own)
    derive_outline(vertices[:_VERTICES])  # polygons come behind the terrain
    for i in range(3):
        place_thing(world, _FLAG_BODY + i, _FINISH, height_at(_FINISH, vertices), 0.0)
