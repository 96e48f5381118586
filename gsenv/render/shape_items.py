"""Convert shapes to draw items: a stencil is built once and filled with poses and sizes for each picture."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gsenv.render.camera import Bounds
from gsenv.render.draw_list import SOLID, DrawFlag, DrawKind, DrawList, Layer, draw_items
from gsenv.render.theme import (
    HUB_COLOR,
    MEADOW,
    OUTLINE_DARKENING,
    PALETTE,
    RIM_COLOR,
    SLATE,
    STATIC_COLOR,
    TYRE_COLOR,
)
from gsenv.render.world_view import ShapeState, ShapeTable, rotate
from gsenv.solver.planar.kinds import ShapeKind

FloatArray = NDArray[np.float64]

SPOKE_COUNT = 5
SENSOR_ALPHA = 0.30
STRIPE_LIGHTENING = 0.55  # blend of a ball's stripe from its fill colour (0) to white (1)

_DRAW_KINDS = {
    ShapeKind.CIRCLE: DrawKind.CAPSULE,
    ShapeKind.BOX: DrawKind.BOX,
    ShapeKind.CAPSULE: DrawKind.CAPSULE,
    ShapeKind.POLYGON: DrawKind.POLYGON,
    ShapeKind.HALF_PLANE: DrawKind.HALF_PLANE,
    ShapeKind.TERRAIN: DrawKind.TERRAIN,
}


class Part(NamedTuple):
    """One item of a shape; lengths are multiples of the shape's radius.

    angle: rad, a direction in the shape's frame
    center: distance of the item's centre along that direction
    length: half length of a capsule along that direction
    """

    kind: DrawKind
    color: ArrayLike
    flags: DrawFlag = SOLID
    angle: float = 0.0
    center: float = 0.0
    length: float = 0.0
    radius: float = 1.0
    layer: Layer = Layer.BODY


def ball_parts(color: NDArray[np.float64], turns: bool) -> list[Part]:
    """Return a disc; if the circle can rotate, with an off-centre bar that shows its angle."""
    if not turns:
        return [Part(DrawKind.CAPSULE, color)]
    light = color + STRIPE_LIGHTENING * (255.0 - color)
    bar = Part(DrawKind.CAPSULE, light, DrawFlag.SHADE, center=0.38, length=0.28, radius=0.17)
    return [Part(DrawKind.CAPSULE, color), bar]


def wheel_parts() -> list[Part]:
    """Return a tyre, a rim, spokes and a hub."""
    angles = 2.0 * np.pi * np.arange(SPOKE_COUNT) / SPOKE_COUNT
    spoke = Part(DrawKind.CAPSULE, HUB_COLOR, DrawFlag.NONE, center=0.34, length=0.26, radius=0.062)
    parts = [
        Part(DrawKind.CAPSULE, TYRE_COLOR),
        Part(DrawKind.CAPSULE, RIM_COLOR, DrawFlag.SHADE, radius=0.66),
        *(spoke._replace(angle=float(angle)) for angle in angles),
        Part(DrawKind.CAPSULE, HUB_COLOR, DrawFlag.NONE, radius=0.20),
    ]
    return [part._replace(layer=Layer.WHEEL) for part in parts]


def pick_colors(table: ShapeTable) -> FloatArray:
    """Return (shape, 3) RGB: the given colour, else the palette's in the order of moving bodies."""
    moving = np.unique(table.bodies[~table.static])
    colors = PALETTE[np.searchsorted(moving, table.bodies) % len(PALETTE)].astype(np.float64)
    colors[table.static] = STATIC_COLOR
    if table.colors is not None:
        given = table.colors.any(axis=1)
        colors[given] = table.colors[given]
    return colors


@dataclass
class ShapeStencil:
    """Items of all shapes of a model; `fill` places them for one world.

    shape_of: (item,) source shape
    scale_by_radius: (item, 3) center, half length and radius in multiples of the shape's radius
    turn: (item, 2) cos, sin of the part's direction in the shape's frame
    keeps_size: (item,) 1 where the item has the shape's size, 0 for parts that scale with its radius
    moves: (item,) whether the body does
    is_moving: (drawn item,) of the last draw list
    """

    items: NDArray[np.void]
    shape_of: NDArray[np.int64]
    scale_by_radius: FloatArray
    turn: FloatArray
    keeps_size: FloatArray
    moves: NDArray[np.bool_]
    is_moving: NDArray[np.bool_]

    def fill(self, state: ShapeState) -> DrawList:
        """Return the draw list of one world; overwrites the stencil's items."""
        items, of = self.items, self.shape_of
        rotation = rotate(state.rotation[of], self.turn)
        radius = state.radius[of]
        shift = self.scale_by_radius[:, 0] * radius
        items["position"] = state.position[of] + rotation * shift[:, None]
        items["rotation"] = rotation
        items["size"] = state.size[of] * self.keeps_size[:, None]
        items["size"][:, 0] += self.scale_by_radius[:, 1] * radius
        items["radius"] = self.scale_by_radius[:, 2] * radius
        visible = state.enabled[of]
        self.is_moving = self.moves
        if not visible.all():
            items, self.is_moving = items[visible], self.moves[visible]
        return DrawList(items, state.vertices)


def make_stencil(table: ShapeTable, wheels: NDArray[np.bool_]) -> ShapeStencil:
    """Return the stencil of all shapes; `wheels` (shape,) marks circles that are drawn as wheels."""
    colors = pick_colors(table)
    parts: list[Part] = []
    shape_of: list[int] = []
    for shape, kind in enumerate(table.kinds):
        if kind == ShapeKind.CIRCLE:
            own = wheel_parts() if wheels[shape] else ball_parts(colors[shape], not table.static[shape])
        else:
            own = [Part(_DRAW_KINDS[ShapeKind(kind)], colors[shape])]
        parts += own
        shape_of += [shape] * len(own)
    of = np.array(shape_of, np.int64)
    angles = np.array([part.angle for part in parts])
    moves = ~table.static[of]
    return ShapeStencil(
        items=make_items(parts, of, table),
        shape_of=of,
        scale_by_radius=np.array([(p.center, p.length, p.radius) for p in parts]).reshape(-1, 3),
        turn=np.stack([np.cos(angles), np.sin(angles)], axis=-1),
        keeps_size=(table.kinds[of] != ShapeKind.CIRCLE).astype(np.float64),
        moves=moves,
        is_moving=moves,
    )


def make_items(parts: list[Part], shape_of: NDArray[np.int64], table: ShapeTable) -> NDArray[np.void]:
    """Return (item,) items with all fields that do not depend on a world's state."""
    items = draw_items(len(parts))
    items["kind"] = [part.kind for part in parts]
    items["flags"] = [part.flags for part in parts]
    items["fill"] = np.array([part.color for part in parts]).reshape(-1, 3)
    items["line"] = items["fill"] * OUTLINE_DARKENING
    items["vertex_first"] = table.vertex_first[shape_of]
    items["vertex_count"] = table.vertex_count[shape_of]
    items["alpha"] = np.where(table.sensor[shape_of], SENSOR_ALPHA, 1.0)
    items["layer"] = [part.layer for part in parts]
    items["flags"][table.sensor[shape_of]] &= ~DrawFlag.SHADOW
    for kind, ground in ((ShapeKind.HALF_PLANE, SLATE), (ShapeKind.TERRAIN, MEADOW)):
        chosen = table.kinds[shape_of] == kind
        items["layer"][chosen] = Layer.GROUND
        items["flags"][chosen] = DrawFlag.NONE
        for field, color in zip(("fill", "deep", "line"), ground, strict=True):
            items[field][chosen] = color
    items["flags"][table.closed[shape_of]] |= DrawFlag.CLOSED
    return items


def find_bounds(draw_list: DrawList) -> Bounds:
    """Return the box around all bounded items, or around the terrains if there are none; half-planes don't count."""
    low, high = item_boxes(draw_list)
    kinds = draw_list.items["kind"]
    for wanted in (kinds < DrawKind.HALF_PLANE, kinds == DrawKind.TERRAIN):
        if wanted.any():
            left, bottom = low[wanted].min(axis=0)
            right, top = high[wanted].max(axis=0)
            return Bounds(float(left), float(bottom), float(right), float(top))
    return Bounds(-5.0, -5.0, 5.0, 5.0)


def moving_boxes(draw_list: DrawList, is_moving: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corners (k, 2) in m of the boxes around the items that move; half-planes have none."""
    chosen = is_moving & (draw_list.items["kind"] < DrawKind.HALF_PLANE)
    return item_boxes(draw_list._replace(items=draw_list.items[chosen]))


def enclose(a: Bounds, b: Bounds) -> Bounds:
    """Return the box around two boxes."""
    return Bounds(min(a.left, b.left), min(a.bottom, b.bottom), max(a.right, b.right), max(a.top, b.top))


def item_boxes(draw_list: DrawList) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corners (item, 2) in m of the items' bounding boxes."""
    items, vertices = draw_list
    turn = np.abs(items["rotation"])
    extent = np.empty((len(items), 2))
    extent[:, 0] = turn[:, 0] * items["size"][:, 0] + turn[:, 1] * items["size"][:, 1]
    extent[:, 1] = turn[:, 1] * items["size"][:, 0] + turn[:, 0] * items["size"][:, 1]
    extent += items["radius"][:, None]
    low, high = items["position"] - extent, items["position"] + extent
    for k in np.flatnonzero(items["vertex_count"]):
        first = items["vertex_first"][k]
        own = vertices[first : first + items["vertex_count"][k]]
        placed = rotate(items["rotation"][k], own) + items["position"][k]
        low[k], high[k] = placed.min(axis=0), placed.max(axis=0)
    return low, high
