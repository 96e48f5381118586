"""Canvas: paints a draw list into an image, row by row."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Camera
from gsenv.render.draw_list import DrawList
from gsenv.render.projection import CAPSULE, HALF_PLANE, LOOK, SCREEN_ITEM, TERRAIN, project
from gsenv.render.scanline import (
    BAND,
    BLUE,
    DISTANCE,
    FAR,
    GREEN,
    HALF,
    LINE_COUNT,
    ONE,
    PIXEL_X,
    RED,
    SHADOW,
    TWO,
    ZERO,
    add_distance_shadow,
    add_polygon_shadow,
    apply_shadow,
    blend_ground,
    blend_shape,
    find_capsule_distance,
    find_polygon_distance,
    find_terrain_distance,
    store_line,
)
from gsenv.render.terrain import project_terrains
from gsenv.render.theme import DEFAULT_THEME, Theme
from gsenv.solver.jit import inline_njit, njit

FloatArray = NDArray[np.float32]


@inline_njit
def clip_span(low: Any, high: Any, limit: int) -> tuple[int, int]:
    """Pixels first..last-1 whose middles may lie within one px of [low, high]."""
    return max(int(low - ONE), 0), min(int(high + ONE) + 1, limit)


@inline_njit
def paint_ground(
    item: Any,
    lines: FloatArray,
    row: int,
    y: Any,
    edges: FloatArray,
    surfaces: FloatArray,
    segments: FloatArray,
    segment_first: NDArray[np.int64],
) -> None:
    distance, xs = lines[DISTANCE], lines[PIXEL_X]
    if item.kind == TERRAIN:
        own = segments[segment_first[item.terrain] : segment_first[item.terrain + 1]]
        reach = item.outline + TWO
        surface = surfaces[item.terrain, row % surfaces.shape[1]]
        find_terrain_distance(distance, xs, y, surface, own, reach)
    else:
        find_polygon_distance(distance, xs, y, edges, item.edge_first, item.edge_count)
        if min(distance[0], distance[distance.shape[0] - 1]) > HALF:
            return
    blend_ground(lines[RED], lines[GREEN], lines[BLUE], distance, lines[BAND], item)


@inline_njit
def paint_shape(item: Any, lines: FloatArray, y: Any, edges: FloatArray) -> None:
    first, last = clip_span(item.left, item.right, lines.shape[1])
    if last <= first:
        return
    distance = lines[DISTANCE, first:last]
    xs = lines[PIXEL_X, first:last]
    if item.kind == CAPSULE:
        find_capsule_distance(distance, xs, y, ZERO, item)
    else:
        find_polygon_distance(distance, xs, y, edges, item.edge_first, item.edge_count)
    shade = item.shade_top + item.shade_slope * (y - item.top)
    red, green, blue = lines[RED, first:last], lines[GREEN, first:last], lines[BLUE, first:last]
    blend_shape(red, green, blue, distance, item, shade)


@inline_njit
def cast_shadow(item: Any, lines: FloatArray, y: Any, edges: FloatArray, look: Any) -> None:
    """Add the item's shadow to the row's; `y` is already in the frame of the caster."""
    softness = look.softness
    reach = HALF * softness
    shift = look.shadow_x
    width = lines.shape[1]
    first, last = clip_span(item.left + shift - reach, item.right + shift + reach, width)
    if last <= first:
        return
    shadow = lines[SHADOW, first:last]
    distance = lines[DISTANCE, first:last]
    xs = lines[PIXEL_X, first:last]
    if item.kind == CAPSULE:
        find_capsule_distance(distance, xs, y, shift, item)
        add_distance_shadow(shadow, distance, softness)
    else:
        first_edge, count = item.edge_first, item.edge_count
        add_polygon_shadow(shadow, distance, xs, y, shift, softness, edges, first_edge, count)


@inline_njit
def paint_shadows(
    screen: NDArray[np.void],
    count: int,
    lines: FloatArray,
    y: Any,
    edges: FloatArray,
    look: Any,
) -> None:
    """One union of all shadows, so that overlapping ones do not add up to black."""
    source_y = y - look.shadow_y
    shift, reach = look.shadow_x, HALF * look.softness
    low, high = FAR, -FAR
    for k in range(count):
        item = screen[k]
        if item.casts_shadow and item.top - reach < source_y < item.bottom + reach:
            low, high = min(low, item.left), max(high, item.right)
    begin, end = clip_span(low + shift - reach, high + shift + reach, lines.shape[1])
    if end <= begin:
        return
    lines[SHADOW, begin:end] = ZERO
    for k in range(count):
        item = screen[k]
        if item.casts_shadow and item.top - reach < source_y < item.bottom + reach:
            cast_shadow(item, lines, source_y, edges, look)
    red, green, blue = lines[RED, begin:end], lines[GREEN, begin:end], lines[BLUE, begin:end]
    apply_shadow(red, green, blue, lines[SHADOW, begin:end], look.shadow_alpha)


@njit
def paint(
    image: NDArray[np.uint8],
    screen: NDArray[np.void],
    count: int,
    edges: FloatArray,
    surfaces: FloatArray,
    segments: FloatArray,
    segment_first: NDArray[np.int64],
    lines: FloatArray,
    sky: FloatArray,
    dither: FloatArray,
    look: NDArray[np.void],
) -> None:
    """Sky, grounds, shadows, shapes: one row after the other, back to front."""
    for i in range(image.shape[0]):
        y = np.float32(i) + HALF
        lines[RED, :] = sky[i, 0]
        lines[GREEN, :] = sky[i, 1]
        lines[BLUE, :] = sky[i, 2]
        for k in range(count):
            item = screen[k]
            if item.kind >= HALF_PLANE and item.top - ONE < y < item.bottom + ONE:
                paint_ground(item, lines, i, y, edges, surfaces, segments, segment_first)
        paint_shadows(screen, count, lines, y, edges, look[0])
        for k in range(count):
            item = screen[k]
            if item.kind < HALF_PLANE and item.top - ONE < y < item.bottom + ONE:
                paint_shape(item, lines, y, edges)
        store_line(image[i], lines[RED], lines[GREEN], lines[BLUE], dither[i & 7])


def make_dither(width: int) -> FloatArray:
    """(8, width) thresholds in (0, 1), an 8 x 8 ordered matrix repeated along the row."""
    matrix = np.zeros((1, 1))
    for _ in range(3):
        matrix = np.block([[4 * matrix, 4 * matrix + 2], [4 * matrix + 3, 4 * matrix + 1]])
    tile = (matrix + 0.5) / 64.0
    return np.ascontiguousarray(np.tile(tile, (1, width // 8 + 1))[:, :width], np.float32)


def make_sky(height: int, theme: Theme) -> FloatArray:
    """(height, 3) colours of the rows."""
    part = np.minimum((np.arange(height) + 0.5) / (theme.sky_end * height), 1.0)[:, None]
    top, bottom = np.array(theme.sky_top), np.array(theme.sky_bottom)
    return (top + (bottom - top) * part).astype(np.float32)


def make_look(height: int, theme: Theme) -> NDArray[np.void]:
    """(1,) LOOK of a picture of that height."""
    look = np.zeros(1, LOOK)
    look["outline"] = max(theme.outline * height, theme.outline_min)
    look["ground_edge"] = max(theme.ground_edge * height, 1.0)
    look["ground_depth"] = theme.ground_depth * height
    look["shadow_x"] = theme.shadow_offset[0] * height
    look["shadow_y"] = theme.shadow_offset[1] * height
    look["softness"] = max(theme.shadow_softness * height, 2.0)
    look["shadow_alpha"] = theme.shadow_alpha
    return look


class Canvas:
    """Paints draw lists at one picture size; the same list and camera always give the same bits.

    width, height: px
    """

    def __init__(self, width: int, height: int, theme: Theme = DEFAULT_THEME) -> None:
        self.width = width
        self.height = height
        self._theme = theme
        self._sky = make_sky(height, theme)
        self._dither = make_dither(width)
        self._look = make_look(height, theme)
        self._reach = float(self._look["ground_edge"][0]) + float(TWO)
        self._lines = np.zeros((LINE_COUNT, width), np.float32)
        self._lines[PIXEL_X] = np.arange(width) + 0.5
        self._screen = np.zeros(0, SCREEN_ITEM)
        self._edges = np.zeros((0, 4), np.float32)
        self._camera: Camera | None = None

    def draw(self, draw_list: DrawList, camera: Camera) -> NDArray[np.uint8]:
        """New (height, width, 3) RGB image."""
        layers = draw_list.items["layer"]
        if (layers[1:] < layers[:-1]).any():
            order = np.argsort(layers, kind="stable")
            draw_list = draw_list._replace(items=draw_list.items[order])
        width, height = self.width, self.height
        self._reserve(draw_list)
        if camera != self._camera:
            self._lines[BAND] = self._make_bands(camera)
            self._camera = camera
        terrain = project_terrains(draw_list, camera, self.width, self.height, self._reach)
        (x, y), scale = camera.center, camera.scale(height)
        screen, edges, look = self._screen, self._edges, self._look
        count = project(*draw_list, x, y, scale, width, height, look, terrain.tops, screen, edges)
        image = np.empty((height, width, 3), np.uint8)
        paint(
            image,
            screen,
            count,
            edges,
            terrain.surfaces,
            terrain.segments,
            terrain.segment_first,
            self._lines,
            self._sky,
            self._dither,
            look,
        )
        return image

    def _reserve(self, draw_list: DrawList) -> None:
        """Grow the scratch arrays to what the list can need at most."""
        items = draw_list.items
        edge_count = 4 * len(items) + int(items["vertex_count"].sum())
        if len(self._screen) < len(items) + 1:
            self._screen = np.zeros(len(items) + 1, SCREEN_ITEM)
        if len(self._edges) < edge_count:
            self._edges = np.zeros((edge_count, 4), np.float32)

    def _make_bands(self, camera: Camera) -> FloatArray:
        """(width,) light of the ground by column: stripes of 1, 2, 5, 10 ... m, box filtered."""
        scale = camera.scale(self.height)
        wanted = 0.11 * self.height / scale
        decade = 10.0 ** np.floor(np.log10(wanted))
        stripe = decade * next(step for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= wanted)
        pixel_edges = np.arange(self.width + 1) - 0.5 * self.width
        phase = (pixel_edges / scale + camera.center[0]) / (2.0 * stripe)
        # Integral of the unit square wave: a triangle wave of the phase.
        triangle = np.abs((phase % 1.0) - 0.5)
        wave = -np.diff(triangle) * 2.0 * stripe * scale
        return (1.0 + self._theme.band_contrast * wave).astype(np.float32)
