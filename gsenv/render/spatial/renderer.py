"""Primitives to pictures."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial import frame
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.pairs import find_pairs
from gsenv.render.spatial.primitives import Meshes, Primitives, check_primitives, read_meshes
from gsenv.render.spatial.records import ITEM, LINE_COUNT, LOOK, PAIR, PIXEL_X, VIEW
from gsenv.render.spatial.setup import prepare
from gsenv.render.spatial.style import DEFAULT_STYLE, Style
from gsenv.solver.optional import as_records

Quality = Literal["high", "fast"]
QUALITIES = ("high", "fast")


class PrimitiveRenderer:
    """Renders primitives at one size and quality, with scratch arrays that it keeps.

    width, height: px
    quality: "high" (soft shadows, dim creases, smooth edges) or "fast" (sharp shadows, one sample a pixel)
    """

    def __init__(self, width: int, height: int, quality: Quality = "high", style: Style = DEFAULT_STYLE) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"width and height must be at least 1 px, got {width} x {height}.")
        if quality not in QUALITIES:
            raise ValueError(f"quality must be among {QUALITIES}, got {quality!r}.")
        self.width, self.height, self.quality, self.style = width, height, quality, style
        self.ids = np.full((height, width), -1, np.int32)
        self._lines = np.zeros((LINE_COUNT, width), np.float32)
        self._lines[PIXEL_X] = np.arange(width) + 0.5
        self._colors = np.zeros((3, height, width), np.float32) if quality == "high" else None
        self._items = as_records(np.zeros(0, ITEM))
        self._spans = np.zeros((0, 2), np.int64)
        pair_room = 64 if quality == "high" else 1
        self._shadows, self._contacts = as_records(np.zeros(64, PAIR)), as_records(np.zeros(pair_room, PAIR))
        self._view, self._look = as_records(np.zeros(1, VIEW)), as_records(np.zeros(1, LOOK))
        self._faces = np.zeros((0, 4), np.float32)

    def draw(
        self, camera: SpatialCamera, primitives: Primitives, vertices: NDArray[np.void] | None = None
    ) -> NDArray[np.uint8]:
        """New (height, width, 3) RGB picture; afterwards `ids` holds what each pixel shows (-1: sky).

        camera: its width and height give way to the renderer's
        vertices: entries of `vertex_dtype` of hulls and heightfields
        """
        meshes = read_meshes(vertices)
        check_primitives(primitives, len(meshes.point))
        self._set_view(camera._replace(width=self.width, height=self.height))
        count = self._prepare(primitives, meshes)
        shadow_count, contact_count = self._find_pairs(count)
        image = np.empty((self.height, self.width, 3), np.uint8)
        shadows, contacts = self._shadows[:shadow_count], self._contacts[:contact_count]
        scene = (self._items, count, self._look, self._faces, shadows, contacts, self._spans)
        if self._colors is not None:
            frame.draw_high(image, self.ids, self._lines, *scene, self._colors)
        else:
            frame.draw_fast(image, self.ids, self._lines, *scene)
        return image

    def _set_view(self, camera: SpatialCamera) -> None:
        view, look, style = self._view, self._look, self.style
        right, up, forward = camera.axes()
        eye = np.asarray(camera.eye, float)
        distance = float(np.linalg.norm(np.asarray(camera.target, float) - eye))
        sun = style.find_sun(right, forward)
        for name, vector in (("eye", eye), ("forward", forward), ("right", right), ("up", up), ("sun", sun)):
            for axis, value in zip("xyz", vector, strict=True):
                view[f"{name}_{axis}"] = value
        step = 2.0 * np.tan(0.5 * camera.fov) / camera.height
        view["step"], view["left"], view["top"] = step, -0.5 * step * camera.width, 0.5 * step * camera.height
        view["softness"] = style.softness if self.quality == "high" else 0.0
        view["reach"] = style.reach * distance
        view["cell"] = style.find_cell(distance)
        view["width"], view["height"] = camera.width, camera.height
        for name in LOOK.names or ():
            if name in (VIEW.names or ()):
                look[name] = view[name]
        look["fog"] = 1.0 / (style.fog * distance)
        for name, color in style.find_lights().items():
            for channel, value in zip(("red", "green", "blue"), color, strict=True):
                look[f"{name}_{channel}"] = value

    def _prepare(self, primitives: Primitives, meshes: Meshes) -> int:
        if len(self._items) < len(primitives.kind) or not len(self._items):
            self._items = as_records(np.zeros(len(primitives.kind) + 1, ITEM))
            self._spans = np.zeros((len(primitives.kind) + 1, 2), np.int64)
        self._faces = np.concatenate([meshes.normal, meshes.offset[:, None]], axis=1).astype(np.float32)
        return prepare(self._items, primitives, meshes, self._view)

    def _find_pairs(self, count: int) -> tuple[int, int]:
        while True:
            found = find_pairs(self._items, count, self._view, self._shadows, self._contacts)
            if found[0] < len(self._shadows) and (found[1] < len(self._contacts) or found[1] == 0):
                return found
            self._shadows = as_records(np.zeros(max(2 * found[0], 64), PAIR))
            if len(self._contacts) > 1:
                self._contacts = as_records(np.zeros(max(2 * found[1], 64), PAIR))


def render_primitives(
    camera: SpatialCamera,
    primitives: Primitives,
    vertices: NDArray[np.void] | None = None,
    quality: Quality = "high",
    style: Style = DEFAULT_STYLE,
) -> NDArray[np.uint8]:
    """New (height, width, 3) RGB picture, of the camera's size; the same arguments always give the same bits.

    vertices: entries of `vertex_dtype` of hulls and heightfields
    quality: "high" (soft shadows, dim creases, smooth edges) or "fast" (sharp shadows, one sample a pixel)
    """
    return PrimitiveRenderer(camera.width, camera.height, quality, style).draw(camera, primitives, vertices)
