"""Canvas: rasterises a draw list into an image, one pixel row at a time."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Camera
from gsenv.render.draw_list import DrawList
from gsenv.render.projection import CAPSULE, HALF_PLANE, LOOK, POLYLINE, SCREEN_ITEM, TERRAIN, project
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
    clip_span,
    fill_line,
    find_capsule_distance,
    find_polygon_distance,
    find_polyline_distance,
    find_terrain_distance,
    store_line,
)
from gsenv.render.terrain import project_terrains
from gsenv.render.theme import DEFAULT_THEME, Theme
from gsenv.solver.jit import inline_njit, njit

FloatArray = NDArray[np.float32]

BAND_ROWS = 16  # pixel rows that share one search for visible items
LINE_SOFTNESS = np.float32(4.0)  # largest blur of a polyline's shadow, in radii of the line


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
    """Paint one row of a half-plane or a terrain."""
    first, last = np.uint64(0), np.uint64(lines.shape[1])
    if item.kind == TERRAIN:
        surface = row % surfaces.shape[1]
        reach = item.outline + TWO
        find_terrain_distance(lines, y, surfaces, item.terrain, surface, segments, segment_first, reach)
    else:
        find_polygon_distance(lines, first, last, y, edges, item.edge_first, item.edge_count)
        if min(lines[DISTANCE, 0], lines[DISTANCE, lines.shape[1] - 1]) > HALF:
            return
    blend_ground(lines, first, last, item)


@inline_njit
def paint_shadows(
    screen: NDArray[np.void],
    active: NDArray[np.int64],
    count: int,
    lines: FloatArray,
    y: Any,
    edges: FloatArray,
    look: Any,
) -> None:
    """Darken the row once by the union of all drop shadows, so that overlapping shadows do not darken it twice."""
    y -= look.shadow_y  # shadows are found in the casters' coordinates
    shift, softness = look.shadow_x, look.softness
    reach = HALF * softness
    width = lines.shape[1]
    low, high = FAR, -FAR
    for k in range(count):
        item = screen[active[k]]
        if item.casts_shadow and item.top - reach < y < item.bottom + reach:
            low, high = min(low, item.left), max(high, item.right)
    begin, end = clip_span(low + shift - reach, high + shift + reach, width)
    fill_line(lines, SHADOW, begin, end, ZERO)
    for k in range(count):
        item = screen[active[k]]
        if item.casts_shadow and item.top - reach < y < item.bottom + reach:
            edge, edge_count = item.edge_first, item.edge_count
            first, last = clip_span(item.left + shift - reach, item.right + shift + reach, width)
            if item.kind == POLYLINE:
                blur = min(softness, LINE_SOFTNESS * item.radius)
                first, last = find_polyline_distance(lines, y, shift, edges, item, HALF * blur)
                add_distance_shadow(lines, first, last, blur)
            elif item.kind == CAPSULE:
                find_capsule_distance(lines, first, last, y, shift, item)
                add_distance_shadow(lines, first, last, softness)
            else:
                add_polygon_shadow(lines, first, last, y, shift, softness, edges, edge, edge_count)
    apply_shadow(lines, begin, end, look.shadow_alpha)


@inline_njit
def find_active(screen: NDArray[np.void], count: int, row: int, look: Any, active: NDArray[np.int64]) -> int:
    """Fill `active` with the items that may be visible in the BAND_ROWS rows from `row` on; return their number."""
    low = np.float32(row) - ONE
    high = np.float32(row + BAND_ROWS) + ONE
    found = 0
    for k in range(count):
        item = screen[k]
        bottom = item.bottom
        if item.casts_shadow:
            bottom += look.shadow_y + look.softness
        if item.top - look.softness < high and bottom > low:
            active[found] = k
            found += 1
    return found


@njit
def paint(
    pixels: NDArray[np.uint8],
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
    active: NDArray[np.int64],
) -> None:
    """Paint all rows; each row from back to front: sky, grounds, shadows, shapes."""
    style = look[0]
    first, last = np.uint64(0), np.uint64(lines.shape[1])
    near = 0
    for i in range(sky.shape[0]):
        if i % BAND_ROWS == 0:
            near = find_active(screen, count, i, style, active)
        y = np.float32(i) + HALF
        fill_line(lines, RED, first, last, sky[i, 0])
        fill_line(lines, GREEN, first, last, sky[i, 1])
        fill_line(lines, BLUE, first, last, sky[i, 2])
        for k in range(near):
            item = screen[active[k]]
            if item.kind >= HALF_PLANE and item.top - ONE < y < item.bottom + ONE:
                paint_ground(item, lines, i, y, edges, surfaces, segments, segment_first)
        paint_shadows(screen, active, near, lines, y, edges, style)
        for k in range(near):
            item = screen[active[k]]
            if item.kind < HALF_PLANE and item.top - ONE < y < item.bottom + ONE:
                begin, end = clip_span(item.left, item.right, lines.shape[1])
                if item.kind == POLYLINE:
                    begin, end = find_polyline_distance(lines, y, ZERO, edges, item, ONE)
                elif item.kind == CAPSULE:
                    find_capsule_distance(lines, begin, end, y, ZERO, item)
                else:
                    edge, edge_count = item.edge_first, item.edge_count
                    find_polygon_distance(lines, begin, end, y, edges, edge, edge_count)
                blend_shape(lines, begin, end, item, y)
        store_line(lines, i, dither, pixels)


def make_dither(width: int) -> FloatArray:
    """Return (8, width) dither thresholds in (0, 1): an 8 x 8 ordered (Bayer) matrix, repeated along the row."""
    matrix = np.zeros((1, 1))
    for _ in range(3):
        matrix = np.block([[4 * matrix, 4 * matrix + 2], [4 * matrix + 3, 4 * matrix + 1]])
    tile = (matrix + 0.5) / 64.0
    return np.ascontiguousarray(np.tile(tile, (1, width // 8 + 1))[:, :width], np.float32)


def make_sky(height: int, theme: Theme) -> FloatArray:
    """Return the sky's colour (height, 3) in each row."""
    part = np.minimum((np.arange(height) + 0.5) / (theme.sky_end * height), 1.0)[:, None]
    top, bottom = np.array(theme.sky_top), np.array(theme.sky_bottom)
    return (top + (bottom - top) * part).astype(np.float32)


def make_look(height: int, theme: Theme) -> NDArray[np.void]:
    """Return the (1,) LOOK record, lengths in px, for a picture that is `height` px high."""
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
    """Paints draw lists at one picture size; equal lists and cameras give bit-identical images.

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
        self._active = np.zeros(0, np.int64)
        self._edges = np.zeros((0, 4), np.float32)
        self._camera: Camera | None = None

    def draw(self, draw_list: DrawList, camera: Camera) -> NDArray[np.uint8]:
        """Return a new (height, width, 3) RGB image of the list."""
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
            image.reshape(-1),
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
            self._active,
        )
        return image

    def _reserve(self, draw_list: DrawList) -> None:
        """Grow the scratch arrays to the most that the list can need."""
        items = draw_list.items
        edge_count = 4 * len(items) + int(items["vertex_count"].sum())
        if len(self._screen) < len(items) + 1:
            self._screen = np.zeros(len(items) + 1, SCREEN_ITEM)
            self._active = np.zeros(len(items) + 1, np.int64)
        if len(self._edges) < edge_count:
            self._edges = np.zeros((edge_count, 4), np.float32)

    def _make_bands(self, camera: Camera) -> FloatArray:
        """Return the ground's brightness factor (width,) by column: box-filtered stripes of 1, 2, 5, 10 ... m."""
        scale = camera.scale(self.height)
        wanted = 0.11 * self.height / scale
        decade = 10.0 ** np.floor(np.log10(wanted))
        stripe = decade * next(step for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= wanted)
        pixel_edges = np.arange(self.width + 1) - 0.5 * self.width
        phase = (pixel_edges / scale + camera.center[0]) / (2.0 * stripe)
        # The integral of a unit square wave is a triangle wave of the phase.
        triangle = np.abs((phase % 1.0) - 0.5)
        wave = -np.diff(triangle) * 2.0 * stripe * scale
        return (1.0 + self._theme.band_contrast * wave).astype(np.float32)
