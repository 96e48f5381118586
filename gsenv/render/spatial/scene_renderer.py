"""SpatialRenderer: renders a 3D World to uint8 pictures; it reads the simulation and never writes to it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.checks import WorldUse, check_finite, checked_hud, checked_index, checked_lines
from gsenv.render.growing_box import GrowingBox
from gsenv.render.hud import draw_hud
from gsenv.render.sizes import check_size
from gsenv.render.spatial.arrows import PARTS, Arrow, has_length, shine_through, with_arrows
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.checks import checked_arrows
from gsenv.render.spatial.links import with_lines, with_links
from gsenv.render.spatial.primitives import (
    BOX,
    CAPSULE,
    HEIGHTFIELD,
    HULL,
    PLANE,
    SPHERE,
    Primitives,
    read_meshes,
)
from gsenv.render.spatial.renderer import PrimitiveRenderer, Quality
from gsenv.render.spatial.stripes import Stripes
from gsenv.render.spatial.style import DEFAULT_STYLE, Style
from gsenv.render.spatial.world_view import (
    ShapeTable,
    read_link_table,
    read_links,
    read_primitives,
    read_table,
    read_vertices,
)
from gsenv.solver.api.one_thread import OneThread, one_thread

FloatArray = NDArray[np.float64]


class SpatialRenderer:
    """Renders the worlds of one 3D World at one picture size.

    world: the World to show
    width, height: px
    camera: None fits the moving bodies in the first picture, widens the view by up to four times where they leave it,
        and follows them where all leave that too
    quality: "high" for videos, "fast" for pixel observations; see PrimitiveRenderer

    Raises ValueError, in one sentence, for a 2D World, a size that is not 1 to 8192 px or an unknown quality.
    """

    def __init__(
        self,
        world: Any,
        width: int = 640,
        height: int = 480,
        camera: SpatialCamera | None = None,
        quality: Quality = "high",
        *,
        style: Style = DEFAULT_STYLE,
    ) -> None:
        check_size(width, height)
        self.world = world
        self.camera = camera
        self._fitted: SpatialCamera | None = None  # the camera that was made here, if any
        self._shown: GrowingBox | None = None
        self._renderer = PrimitiveRenderer(width, height, quality, style)
        self._use, self._world_use = OneThread(), WorldUse(world)
        self._table = read_table(world)
        self._links = read_link_table(world)

    @property
    def width(self) -> int:
        """px"""
        return self._renderer.width

    @property
    def height(self) -> int:
        """px"""
        return self._renderer.height

    @one_thread("SpatialRenderer")
    def frame(
        self,
        world_index: int = 0,
        camera: SpatialCamera | None = None,
        lines: FloatArray | None = None,
        arrows: Sequence[Arrow] = (),
        stripes: Stripes | None = None,
    ) -> NDArray[np.uint8]:
        """Return a new (height, width, 3) RGB picture of one world, seen by `camera` or the renderer's own.

        lines: (line, 2, 3) m, dark lines on the bodies
        arrows: which shine faintly through what hides them
        stripes: painted on the heightfields

        Raises:
            ValueError: a bad argument or camera, or a body whose pose is not finite.
            RuntimeError: another thread is using the renderer or the World.
        """
        number, checked = checked_index(self.world, world_index), checked_lines(lines, 3)
        arrows = checked_arrows(arrows)
        return self._world_use.render(lambda: self._draw(number, camera, checked, arrows, stripes))

    def _draw(
        self,
        world_index: int,
        camera: SpatialCamera | None,
        lines: FloatArray | None,
        arrows: Sequence[Arrow],
        stripes: Stripes | None,
    ) -> NDArray[np.uint8]:
        check_finite(self.world, world_index)
        primitives = read_primitives(self.world, world_index, self._table)
        vertices = read_vertices(self.world, world_index)
        if camera is None:
            camera = self._aim(primitives, vertices)
        if not isinstance(camera, SpatialCamera):
            raise TypeError(f"camera must be a SpatialCamera or None, got {camera!r}.")
        primitives = with_links(primitives, self._links, read_links(self.world, world_index, self._links))
        if lines is not None:
            primitives = with_lines(primitives, lines)
        if not arrows:
            return self._renderer.draw(camera, primitives, vertices, stripes)
        first = int(primitives.enabled.sum())
        depths = np.empty((self.height, self.width), np.float32)
        image = self._renderer.draw(camera, *with_arrows(primitives, vertices, arrows), stripes, depths)
        sized = camera._replace(width=self.width, height=self.height)
        for k, arrow in enumerate(arrow for arrow in arrows if has_length(arrow)):
            own = first + PARTS * k
            other = (self._renderer.ids < own) | (self._renderer.ids >= own + PARTS)
            shine_through(image, other, depths, sized, arrow)
        return image

    def _aim(self, primitives: Primitives, vertices: NDArray[np.void] | None) -> SpatialCamera:
        """Return the renderer's camera; without one, fit the moving bodies, and change the view where they leave it."""
        if self.camera is not None and self.camera is not self._fitted:
            return self.camera
        lower, upper = find_bounds(primitives, vertices, self._table)
        if self.camera is None or self._shown is None:
            self._shown = GrowingBox(lower, upper)
        elif not self._shown.include(lower, upper, find_moving(primitives, vertices, self._table)):
            return self.camera
        self._fitted = SpatialCamera.look_at_bounds(self._shown.low, self._shown.high, self.width, self.height)
        self.camera = self._fitted
        return self._fitted

    @one_thread("SpatialRenderer")
    def render(
        self,
        world_index: int = 0,
        hud: Sequence[str] = (),
        lines: FloatArray | None = None,
        arrows: Sequence[Arrow] = (),
        stripes: Stripes | None = None,
    ) -> NDArray[np.uint8]:
        """Return a picture as `frame` does, by the renderer's own camera, with the `hud` lines at the top left."""
        texts = checked_hud(hud)
        image: NDArray[np.uint8] = self.frame(world_index, lines=lines, arrows=arrows, stripes=stripes)
        if texts:
            draw_hud(image, texts)
        return image


def find_bounds(
    primitives: Primitives, vertices: NDArray[np.void] | None, table: ShapeTable
) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corner (3,) in m of all moving shapes, or of all bounded ones if none moves."""
    shown = primitives.enabled & (primitives.kind != PLANE)
    for wanted in (shown & ~table.static, shown):
        if wanted.any():
            lower, upper = find_boxes(primitives, vertices, np.flatnonzero(wanted))
            return lower.min(axis=0), upper.max(axis=0)
    return np.full(3, -1.0), np.full(3, 1.0)


def find_moving(
    primitives: Primitives, vertices: NDArray[np.void] | None, table: ShapeTable
) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corners (k, 3) in m of the boxes around the moving shapes; planes have none."""
    chosen = primitives.enabled & (primitives.kind != PLANE) & ~table.static
    return find_boxes(primitives, vertices, np.flatnonzero(chosen))


def find_boxes(
    primitives: Primitives, vertices: NDArray[np.void] | None, index: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corners (k, 3) in m of the bounding boxes of the primitives `index`."""
    w, x, y, z = primitives.rotation[index].T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    turn = np.moveaxis(np.array(rows), 2, 0)
    kind, radius = primitives.kind[index], primitives.radius[index]
    middle = np.zeros((len(index), 3))
    is_round = (kind == SPHERE) | (kind == CAPSULE)  # the box around a ball does not change as it rolls
    half = primitives.size[index] + np.where((kind == BOX) | is_round, 0.0, radius)[:, None]
    meshes = read_meshes(vertices)
    for i in np.flatnonzero((kind == HULL) | (kind == HEIGHTFIELD)):
        first = primitives.vertex_first[index[i]]
        counts = meshes.counts[first]
        points = meshes.point[first : first + (counts[0] if kind[i] == HULL else counts[2] * counts[3])]
        lower, upper = points.min(axis=0), points.max(axis=0)
        middle[i], half[i] = 0.5 * (lower + upper), 0.5 * (upper - lower)
    center = primitives.position[index] + (turn @ middle[:, :, None])[:, :, 0]
    reach = (np.abs(turn) @ half[:, :, None])[:, :, 0] + np.where(is_round, radius, 0.0)[:, None]
    return center - reach, center + reach
