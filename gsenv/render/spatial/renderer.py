"""Rendering of primitives to pictures."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.ambient_occlusion import occlude_band
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.checks import check_stripes
from gsenv.render.spatial.depth import measure_cells, trace_band
from gsenv.render.spatial.edges import SAMPLE_X, SAMPLE_Y, blend_band
from gsenv.render.spatial.light import light_band
from gsenv.render.spatial.pairs import find_pairs
from gsenv.render.spatial.primitives import HEIGHTFIELD, HULL, Meshes, Primitives, check_primitives, read_meshes
from gsenv.render.spatial.records import (
    DEPTH,
    ID,
    ITEM,
    LANES,
    LINE_COUNT,
    LOOK,
    PAIR,
    PIXEL_X,
    SAMPLES,
    SUB_DEPTH,
    SUB_ID,
    VIEW,
    VISIBILITY,
    ZERO,
    FloatArray,
)
from gsenv.render.spatial.setup import prepare
from gsenv.render.spatial.shadow import shade_band
from gsenv.render.spatial.stripes import Stripes, stripe_band
from gsenv.render.spatial.style import DEFAULT_STYLE, Style
from gsenv.render.spatial.surface import paint_band
from gsenv.solver.records.plain import as_records

Quality = Literal["high", "fast"]
QUALITIES = ("high", "fast")
NO_MESHES = read_meshes(None)
BAND_BYTES = 1 << 20  # size of a band of rows, which fits the L2 cache


class PrimitiveRenderer:
    """Renders primitives at one size and quality; keeps its scratch arrays between pictures.

    width, height: px
    quality: "high" (soft shadows, ambient occlusion, antialiased edges) or "fast" (sharp shadows, one sample
        per pixel)

    Raises ValueError for a size below 1 px or an unknown quality.
    """

    def __init__(self, width: int, height: int, quality: Quality = "high", style: Style = DEFAULT_STYLE) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"width and height must be at least 1 px, got {width} x {height}.")
        if quality not in QUALITIES:
            raise ValueError(f"quality must be among {QUALITIES}, got {quality!r}.")
        self.width, self.height, self.quality, self.style = width, height, quality, style
        self.ids = np.full((height, width), -1, np.int32)
        padded = -(-width // LANES) * LANES
        rows = min(max(BAND_BYTES // (4 * LINE_COUNT * padded), 1), height)
        self._bands = [(start, min(start + rows, height)) for start in range(0, height, rows)]
        self._band = np.zeros((rows, LINE_COUNT, padded), np.float32)
        self._band[:, PIXEL_X] = np.arange(padded) + 0.5
        self._band[:, VISIBILITY] = 1.0
        self._colors = np.zeros((3, height, width), np.float32) if quality == "high" else None
        self._items = as_records(np.zeros(0, ITEM))
        self._spans = np.zeros((rows, 0, 2), np.int64)
        pair_room = 64 if quality == "high" else 1
        self._shadows, self._contacts = as_records(np.zeros(64, PAIR)), as_records(np.zeros(pair_room, PAIR))
        self._view, self._look = as_records(np.zeros(1, VIEW)), as_records(np.zeros(1, LOOK))

    def draw(
        self,
        camera: SpatialCamera,
        primitives: Primitives,
        vertices: NDArray[np.void] | None = None,
        stripes: Stripes | None = None,
        depths: NDArray[np.float32] | None = None,
    ) -> NDArray[np.uint8]:
        """Return a new (height, width, 3) RGB picture; `ids` then holds the item that each pixel shows (-1: sky).

        camera: its width and height are replaced by the renderer's
        vertices: `vertex_dtype` entries of hulls and heightfields
        stripes: painted on the heightfields
        depths: (height, width), gets the depth of what each pixel shows, in m along the view

        Raises ValueError for bad primitives, a bad camera or bad stripes.
        """
        check_stripes(stripes)
        meshed = (primitives.kind == HULL) | (primitives.kind == HEIGHTFIELD)
        meshes = read_meshes(vertices) if meshed.any() else NO_MESHES
        check_primitives(primitives, len(meshes.point))
        self._set_view(camera._replace(width=self.width, height=self.height))
        faces, points = find_meshes(primitives, meshes)
        count = self._prepare(primitives, None if faces is None and points is None else meshes)
        if points is not None:
            measure_cells(self._items, count, self._look, points)
        shadow_count, contact_count = self._find_pairs(count)
        image = np.empty((self.height, self.width, 3), np.uint8)
        shadows, contacts = self._shadows[:shadow_count], self._contacts[:contact_count]
        for band in self._bands:
            rows = (self._band, *band)
            trace_band(*rows, self._items, count, self._look, faces, points, ZERO, ZERO, DEPTH, ID)
            if depths is not None:
                depths[slice(*band)] = self._band[: band[1] - band[0], DEPTH, : self.width]
            paint_band(*rows, self._items, count, self._look, faces, points, self._spans)
            if stripes is not None:
                stripe_band(*rows, self._items, count, self._look, stripes, self._spans)
            shade_band(*rows, self._items, shadows, self._look, faces, self._spans)
            if self._colors is not None:
                occlude_band(*rows, self._items, contacts, self._look, faces, self._spans)
            light_band(*rows, self._look, image, self.ids, self._colors)
        if self._colors is not None:
            self._smooth_edges(image, count, faces, points)
        return image

    def _smooth_edges(
        self, image: NDArray[np.uint8], count: int, faces: FloatArray | None, points: FloatArray | None
    ) -> None:
        for band in self._bands:
            rows = (self._band, *band)
            assert self._colors is not None
            for s in range(SAMPLES):
                shift = (SAMPLE_X[s], SAMPLE_Y[s])
                trace_band(*rows, self._items, count, self._look, faces, points, *shift, SUB_DEPTH, SUB_ID + s)
            blend_band(*rows, self._items, count, image, self.ids, self._colors)

    def _set_view(self, camera: SpatialCamera) -> None:
        style = self.style
        right, up, forward = camera.axes()
        eye = np.asarray(camera.eye, float)
        distance = float(np.sqrt(((np.asarray(camera.target, float) - eye) ** 2).sum()))
        sun = style.find_sun()
        step = 2.0 * np.tan(0.5 * camera.fov) / camera.height
        left, top = -0.5 * step * camera.width, 0.5 * step * camera.height
        softness = style.softness if self.quality == "high" else 0.0
        cell = style.find_cell(distance)
        frame = (*forward, *right, *up, *sun, left, top, step, softness)
        self._view[0] = (*eye, *frame, style.reach * distance, cell, camera.width, camera.height)
        self._look[0] = (*frame, cell, 1.0 / (style.fog * distance), *style.find_lights())

    def _prepare(self, primitives: Primitives, meshes: Meshes | None) -> int:
        if len(self._items) < len(primitives.kind) or not len(self._items):
            self._items = as_records(np.zeros(len(primitives.kind) + 1, ITEM))
            self._spans = np.zeros((len(self._band), len(primitives.kind) + 1, 2), np.int64)
        return prepare(self._items, primitives, meshes, self._view)

    def _find_pairs(self, count: int) -> tuple[int, int]:
        while True:
            found = find_pairs(self._items, count, self._view, self._shadows, self._contacts)
            if found[0] < len(self._shadows) and (found[1] < len(self._contacts) or found[1] == 0):
                return found
            self._shadows = as_records(np.zeros(max(2 * found[0], 64), PAIR))
            if len(self._contacts) > 1:
                self._contacts = as_records(np.zeros(max(2 * found[1], 64), PAIR))


def find_meshes(primitives: Primitives, meshes: Meshes) -> tuple[FloatArray | None, FloatArray | None]:
    """Return the faces of hulls (v, 4) and points of heightfields (v, 5); None for a kind that does not occur.

    The last two columns of points are for `measure_cells`.

    Kernels compile no code for None.
    """
    faces = points = None
    if (primitives.kind == HULL).any():
        faces = np.concatenate([meshes.normal, meshes.offset[:, None]], axis=1).astype(np.float32)
    if (primitives.kind == HEIGHTFIELD).any():
        points = np.zeros((len(meshes.point), 5), np.float32)
        points[:, :3] = meshes.point
    return faces, points


def render_primitives(
    camera: SpatialCamera,
    primitives: Primitives,
    vertices: NDArray[np.void] | None = None,
    quality: Quality = "high",
    style: Style = DEFAULT_STYLE,
) -> NDArray[np.uint8]:
    """Return a new (height, width, 3) RGB picture of the camera's size; equal arguments give bit-identical pictures.

    vertices: `vertex_dtype` entries of hulls and heightfields
    quality: "high" (soft shadows, ambient occlusion, antialiased edges) or "fast" (sharp shadows, one sample
        per pixel)

    Raises ValueError for bad primitives, a bad camera or an unknown quality.
    """
    return PrimitiveRenderer(camera.width, camera.height, quality, style).draw(camera, primitives, vertices)
