"""Convert joints to draw items: paths are built once and stretched between the anchors for each picture.

Every item is a polyline. Its points are given as fractions of the line between two points of the joint,
so a spring has the same number of windings at any length and does not flicker between pictures.
"""

from collections.abc import Collection
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Bounds
from gsenv.render.draw_list import DrawFlag, DrawKind, DrawList, Layer, draw_items
from gsenv.render.rope import find_sag
from gsenv.render.theme import (
    HUB_COLOR,
    METAL_LINE,
    PIN_COLOR,
    RAIL_COLOR,
    ROD_COLOR,
    ROPE_COLOR,
    SPRING_COLOR,
    STATIC_COLOR,
    TARGET_COLOR,
    Rgb,
)
from gsenv.render.world_view import JointState, JointTable

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

DRAWN_JOINTS = ("revolute", "prismatic", "distance", "wheel")  # drawn by default
KNOWN_JOINTS = (*DRAWN_JOINTS, "weld", "target")
SWINGING_JOINTS = ("revolute", "distance")

# Lengths of parts are fractions of the picture's height. They shrink with the body where its half width
# is below 1 / FULL_SIZE of that height.
FULL_SIZE = 45.0
RAIL_REACH = 50.0  # drawn half length of a rail without limits, in picture heights

ROPE_POINTS = 25
TURNS = 14  # zigzags of a spring
LEAD = 0.12  # length of each straight end of a spring, as a fraction of its length


class Spot(IntEnum):
    """Points of a joint between which its parts are drawn."""

    A = 0  # anchor on body a
    B = 1  # anchor on body b
    LOWER = 2  # anchor b at the lower limit of the translation
    UPPER = 3  # anchor b at the upper limit
    MOUNT = 4  # end on body a of the spring along the axis
    AHEAD = 5  # anchor b plus the unit axis
    GOAL = 6  # position of a target joint's target


class Part(NamedTuple):
    """One polyline of a joint; lengths are fractions of the picture's height.

    path: (point, 4) fraction of the line from `start` to `end`, offset along the line, offset to its
        left, and fraction of the sag
    full_size: the part has its full size if the body's half width is at least 1 / full_size of the
        picture's height
    """

    path: FloatArray
    start: Spot
    end: Spot
    radius: float
    color: Rgb
    flags: DrawFlag = DrawFlag.OUTLINE | DrawFlag.SHADOW
    layer: Layer = Layer.LINK
    full_size: float = FULL_SIZE


def line_path() -> FloatArray:
    """Return the path of a straight line from start to end."""
    return np.array([(0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)])


def dash_path(along: float, left: float = 0.0) -> FloatArray:
    """Return the path of a short line centred on the start; with both half lengths 0 it is drawn as a dot."""
    return np.array([(0.0, -along, -left, 0.0), (0.0, along, left, 0.0)])


def rail_path(half: float) -> FloatArray:
    """Return the path of a straight line with a crossbar of half length `half` at each end."""
    points = [(0.0, half), (0.0, -half), (0.0, 0.0), (1.0, 0.0), (1.0, half), (1.0, -half)]
    return np.array([(share, 0.0, left, 0.0) for share, left in points])


def rope_path() -> FloatArray:
    """Return the path of a rope: a parabola, scaled by the sag."""
    path = np.zeros((ROPE_POINTS, 4))
    path[:, 0] = share = np.linspace(0.0, 1.0, ROPE_POINTS)
    path[:, 3] = 4.0 * share * (1.0 - share)
    return path


def spring_path(half: float) -> FloatArray:
    """Return the path of a spring: a zigzag of amplitude `half` between straight ends."""
    turns = np.arange(TURNS)
    path = np.zeros((TURNS + 4, 4))
    path[1:-1, 0] = np.linspace(LEAD, 1.0 - LEAD, TURNS + 2)
    path[2:-2, 0] = LEAD + (1.0 - 2.0 * LEAD) * (turns + 0.5) / TURNS
    path[2:-2, 2] = np.where(turns % 2, -half, half)
    path[-1, 0] = 1.0
    return path


def dot(spot: Spot, radius: float) -> Part:
    """Return a dot in front of the bodies."""
    return Part(dash_path(0.0), spot, spot, radius, PIN_COLOR, DrawFlag.OUTLINE, Layer.PIN)


PIN = dot(Spot.B, 0.0105)
PLATE = Part(dash_path(0.0), Spot.A, Spot.A, 0.0190, STATIC_COLOR, DrawFlag.OUTLINE, full_size=110.0)
ROD = Part(line_path(), Spot.A, Spot.B, 0.0062, ROD_COLOR)
ROPE = Part(rope_path(), Spot.A, Spot.B, 0.0030, ROPE_COLOR, DrawFlag.SHADOW)
SPRING = Part(spring_path(0.0220), Spot.A, Spot.B, 0.0048, SPRING_COLOR)
ENDS = (dot(Spot.A, 0.0075), dot(Spot.B, 0.0075))
RAIL = Part(rail_path(0.0120), Spot.LOWER, Spot.UPPER, 0.0036, RAIL_COLOR, DrawFlag.SHADOW)
COIL = SPRING._replace(start=Spot.MOUNT)
SLIDER = dot(Spot.B, 0.0085)._replace(path=dash_path(0.0150), end=Spot.AHEAD)
TOWER = Part(line_path(), Spot.A, Spot.MOUNT, 0.0050, HUB_COLOR, DrawFlag.OUTLINE, Layer.STRUT)
STRUT = COIL._replace(flags=DrawFlag.OUTLINE, layer=Layer.STRUT)
STRUT_END = dot(Spot.MOUNT, 0.0075)
WELD = dot(Spot.B, 0.0085)._replace(color=STATIC_COLOR)
LEASH = Part(line_path(), Spot.B, Spot.GOAL, 0.0016, TARGET_COLOR, DrawFlag.NONE, Layer.PIN)
CROSS = tuple(LEASH._replace(path=path, start=Spot.GOAL) for path in (dash_path(0.0140), dash_path(0.0, 0.0140)))


def choose_parts(kind: str, fixed: bool, has_spring: bool, rigid: bool) -> tuple[Part, ...]:
    """Return the parts of a joint from its fields in JointTable; a kind that is never drawn has none."""
    plate = (PLATE,) if fixed else ()
    if kind == "revolute":
        return (*plate, PIN)
    if kind == "distance":
        return (*plate, SPRING if has_spring else ROD if rigid else ROPE, *ENDS)
    if kind == "prismatic":
        return (RAIL, COIL, SLIDER) if has_spring else (RAIL, SLIDER)
    if kind == "wheel":
        return (TOWER, STRUT, STRUT_END) if has_spring else ()
    return {"weld": (WELD,), "target": (LEASH, *CROSS)}.get(kind, ())


@dataclass
class JointStencil:
    """Items of all drawn joints of a model; `fill` places them for one world.

    joint_of, start_of, end_of: (item,) joint and its Spots
    radius: (item,) fraction of the picture's height
    unit_most: (item,) m, upper bound of the picture height that lengths are scaled by
    ropes: indices of the items that sag when slack
    item_of, share, offset, sag_share: (point,) item and path; offsets are complex, along + 1j * left
    """

    table: JointTable
    items: NDArray[np.void]
    joint_of: NDArray[np.int64]
    start_of: NDArray[np.int64]
    end_of: NDArray[np.int64]
    radius: FloatArray
    unit_most: FloatArray
    ropes: NDArray[np.int64]
    item_of: NDArray[np.int64]
    share: FloatArray
    offset: ComplexArray
    sag_share: FloatArray

    def fill(self, state: JointState, view_height: float) -> DrawList:
        """Return the draw list of one world in a view of `view_height` m; overwrites the stencil's items."""
        spots = find_spots(state, self.table.mount, RAIL_REACH * view_height)
        start = spots[self.start_of, self.joint_of]
        span = spots[self.end_of, self.joint_of] - start
        length = np.abs(span)
        unit = np.minimum(self.unit_most, view_height)
        scaled = np.divide(unit * span, length, out=unit + 0j, where=length > 0.0)
        of = self.item_of
        points = start[of] + self.share * span[of] + self.offset * scaled[of]
        if len(self.ropes):
            sags = np.zeros_like(span)
            sags[self.ropes] = self._find_sags(state, span[self.ropes])
            points += self.sag_share * sags[of]
        self.items["radius"] = self.radius * unit
        self.items["alpha"] = state.enabled[self.joint_of]
        return DrawList(self.items, points.view(np.float64).reshape(-1, 2))

    def _find_sags(self, state: JointState, span: ComplexArray) -> ComplexArray:
        """Return (rope,) vectors in m from the midpoints of the chords to the ropes."""
        down = complex(*state.down)
        turned = span * down.conjugate()
        depth = find_sag(turned.imag.copy(), turned.real.copy(), state.upper[self.joint_of[self.ropes]])
        return np.asarray(depth * down, np.complex128)

    def find_bounds(self, state: JointState) -> Bounds:
        """Return the box in m around the anchors and the reach of bodies that swing on fixed anchors.

        Under gravity the reach above a fixed anchor is left out.
        """
        drawn = np.unique(self.joint_of)
        a, b = state.anchor_a[drawn], state.anchor_b[drawn]
        kinds, upper = np.array(self.table.kinds)[drawn], state.upper[drawn]
        rope = np.where(np.isfinite(upper), upper, 0.0)
        reach = self.table.span[drawn]
        reach = reach + np.where(kinds == "distance", np.maximum(np.hypot(*(b - a).T), rope), 0.0)
        swings = self.table.fixed[drawn] & np.isin(kinds, SWINGING_JOINTS)
        left = np.where(swings, reach, 0.0)[:, None]
        rises = not state.down[1] < 0.0
        low = np.minimum(a - left, b).min(axis=0)
        high = np.maximum(a + left * (1.0, rises), b).max(axis=0)
        return Bounds(float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def as_complex(vectors: FloatArray) -> ComplexArray:
    """Convert (..., 2) vectors to complex (...,), so that rotation and scaling are products."""
    return np.ascontiguousarray(vectors, np.float64).view(np.complex128)[..., 0]


def find_spots(state: JointState, mount: FloatArray, reach: float) -> ComplexArray:
    """Return (Spot, joint) points in m; a rail without limits ends at `reach` m."""
    a, b, axis = as_complex(state.anchor_a), as_complex(state.anchor_b), as_complex(state.axis)
    spots = np.empty((len(Spot), len(a)), np.complex128)
    spots[Spot.A] = a
    spots[Spot.B] = b
    spots[Spot.LOWER] = a + axis * np.maximum(state.lower, -reach)
    spots[Spot.UPPER] = a + axis * np.minimum(state.upper, reach)
    spots[Spot.MOUNT] = a + axis * mount
    spots[Spot.AHEAD] = b + axis
    spots[Spot.GOAL] = as_complex(state.goal)
    return spots


def make_joint_stencil(table: JointTable, kinds: Collection[str]) -> JointStencil | None:
    """Return the stencil of the joints of the given kinds; None if none of them has parts."""
    chosen = [
        (joint, part)
        for joint, kind in enumerate(table.kinds)
        if kind in kinds
        for part in choose_parts(kind, table.fixed[joint], table.has_spring[joint], table.rigid[joint])
    ]
    if not chosen:
        return None
    chosen.sort(key=lambda pair: pair[1] is not PLATE)  # plates are painted first in their layer
    joint_of = np.array([joint for joint, _ in chosen])
    parts = [part for _, part in chosen]
    counts = np.array([len(part.path) for part in parts])
    share, along, left, sag_share = np.concatenate([part.path for part in parts]).T.copy()
    return JointStencil(
        table=table,
        items=make_items(parts, counts),
        joint_of=joint_of,
        start_of=np.array([part.start for part in parts]),
        end_of=np.array([part.end for part in parts]),
        radius=np.array([part.radius for part in parts]),
        unit_most=np.array([part.full_size for part in parts]) * table.size[joint_of],
        ropes=np.flatnonzero([part.path[:, 3].any() for part in parts]),
        item_of=np.repeat(np.arange(len(parts)), counts),
        share=share,
        offset=along + 1j * left,
        sag_share=sag_share,
    )


def make_items(parts: list[Part], counts: NDArray[np.int64]) -> NDArray[np.void]:
    """Return (item,) items with all fields that do not depend on a world's state."""
    items = draw_items(len(parts))
    items["kind"] = DrawKind.POLYLINE
    items["flags"] = [part.flags for part in parts]
    items["layer"] = [part.layer for part in parts]
    items["fill"] = [part.color for part in parts]
    items["line"] = METAL_LINE
    items["vertex_count"] = counts
    items["vertex_first"] = np.cumsum(counts) - counts
    return items
