"""SceneRenderer: renders a 2D World to uint8 pictures; it reads the simulation and never writes to it."""

from collections.abc import Iterable, Sequence
from math import inf
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from gsenv.render import overlay as marks
from gsenv.render.camera import Bounds, Camera, FollowCamera
from gsenv.render.camera_checks import check_follow, checked_camera
from gsenv.render.canvas import Canvas
from gsenv.render.checks import (
    WorldUse,
    check_dimension,
    check_finite,
    checked_bodies,
    checked_hud,
    checked_index,
    checked_lines,
    checked_names,
)
from gsenv.render.draw_list import DrawList, join
from gsenv.render.growing_box import GrowingBox
from gsenv.render.hud import draw_hud
from gsenv.render.joint_items import DRAWN_JOINTS, KNOWN_JOINTS, make_joint_stencil
from gsenv.render.shape_items import enclose, find_bounds, make_stencil, moving_boxes
from gsenv.render.sizes import check_size
from gsenv.render.theme import AXIS_COLORS, CONTACT_COLOR, DEFAULT_THEME, FORCE_COLOR, JOINT_COLOR, LINE_COLOR, Theme
from gsenv.render.world_view import (
    Frames,
    find_wheels,
    read_bodies,
    read_contacts,
    read_joint_frames,
    read_joint_table,
    read_joints,
    read_state,
    read_table,
    read_time,
)
from gsenv.solver.api.one_thread import OneThread, one_thread
from gsenv.solver.api.world import World

OVERLAYS = ("contacts", "joints")

# Fractions of the picture's height.
PEN_RADIUS = 0.0030
PEN_RADIUS_MIN = 0.6  # px
ARROW_LENGTH = 0.11  # arrow of the largest force in the picture
AXIS_LENGTH = 0.035  # axes of a joint frame


class SceneRenderer:
    """Renders the worlds of one 2D World at one picture size.

    world: the World to show
    width, height: px
    camera: a Camera, a FollowCamera, or None to fit the bodies in the first picture, to widen the view by up to
        four times where bodies leave it, and to follow them where all leave that too
    overlay: any of "contacts" (points and forces) and "joints" (anchors with their frames)
    wheels: indices of bodies whose circles are drawn as wheels; a circle that rotates about its centre
        on a joint is always drawn so
    joints: kinds of joints that are drawn; by default all but "weld" and "target"
    force_scale: m/N, length of the force arrows; None scales the largest force in each picture to a
        fixed length

    Raises ValueError, in one sentence, for a 3D World, a size that is not 1 to 8192 px and other bad arguments.
    """

    def __init__(
        self,
        world: World,
        width: int = 640,
        height: int = 480,
        camera: Camera | FollowCamera | None = None,
        overlay: Iterable[str] = (),
        *,
        wheels: Sequence[int] = (),
        joints: Iterable[str] = DRAWN_JOINTS,
        force_scale: float | None = None,
        theme: Theme = DEFAULT_THEME,
    ) -> None:
        check_size(width, height)
        check_dimension(world, 2, "SceneRenderer")
        self.overlay = checked_names(overlay, OVERLAYS, "overlay")
        kinds = checked_names(joints, KNOWN_JOINTS, "joints")
        if force_scale is not None and not (isinstance(force_scale, Real) and 0.0 <= force_scale < inf):
            raise ValueError(f"force_scale must be None or a finite number of at least 0, got {force_scale!r}.")
        self.world = world
        self._use, self._world_use = OneThread(), WorldUse(world)
        self.camera = camera
        self.force_scale = force_scale
        self._fitted: Camera | None = None  # the camera that was made here, if any
        self._shown: GrowingBox | None = None
        self._canvas = Canvas(width, height, theme)
        self._table = read_table(world)
        self._joints = make_joint_stencil(read_joint_table(world), kinds)
        wheel_bodies = checked_bodies(wheels, "wheels", len(world.model.bodies))
        is_wheel = np.isin(self._table.bodies, wheel_bodies) | find_wheels(world)
        self._shapes = make_stencil(self._table, is_wheel)

    @property
    def width(self) -> int:
        """px"""
        return self._canvas.width

    @property
    def height(self) -> int:
        """px"""
        return self._canvas.height

    @one_thread("SceneRenderer")
    def render(
        self, world_index: int = 0, hud: Sequence[str] = (), lines: NDArray[np.float64] | None = None
    ) -> NDArray[np.uint8]:
        """Return a new (height, width, 3) RGB picture of one world, with the `hud` lines of text at the top left.

        lines: (line, 2, 2) m, dark lines over the bodies

        Raises:
            ValueError: a bad argument or camera, or a body whose pose is not finite.
            RuntimeError: another thread is using the renderer or the World.
        """
        number, texts, checked = checked_index(self.world, world_index), checked_hud(hud), checked_lines(lines, 2)
        image = self._world_use.render(lambda: self._draw(number, checked))
        if texts:
            draw_hud(image, texts)
        return image

    def _draw(self, world_index: int, lines: NDArray[np.float64] | None) -> NDArray[np.uint8]:
        check_finite(self.world, world_index)
        bodies = read_bodies(self.world, world_index)
        draw_list = self._shapes.fill(read_state(self.world, world_index, self._table, bodies))
        camera = self._aim(draw_list, bodies, world_index)
        if self._joints is not None:
            joints = read_joints(self.world, world_index, self._joints.table, bodies)
            draw_list = join(draw_list, self._joints.fill(joints, camera.height))
        for name in self.overlay:
            add = self._draw_contacts if name == "contacts" else self._draw_joints
            draw_list = join(draw_list, *add(world_index, camera))
        if lines is not None:
            draw_list = join(draw_list, marks.lines(lines[:, 0], lines[:, 1], self._pen(camera, 0.8), LINE_COLOR))
        return self._canvas.draw(draw_list, camera)

    def _aim(self, shapes: DrawList, bodies: Frames, world_index: int) -> Camera:
        if self.camera is None or self.camera is self._fitted:
            self._fit(shapes, bodies, world_index)
        if isinstance(self.camera, Camera):
            return checked_camera(self.camera)
        if isinstance(self.camera, FollowCamera):
            check_follow(self.camera, len(bodies.position))
            time = read_time(self.world, world_index)
            return checked_camera(self.camera.update(bodies.position, time, self.width, self.height))
        raise TypeError(f"camera must be a Camera, a FollowCamera or None, got {self.camera!r}.")

    def _fit(self, shapes: DrawList, bodies: Frames, world_index: int) -> None:
        """Set the camera to one that shows all bodies, or widen or shift it where some have left the picture."""
        bounds = find_bounds(shapes)
        if self._joints is not None:
            joints = read_joints(self.world, world_index, self._joints.table, bodies)
            bounds = enclose(bounds, self._joints.find_bounds(joints))
        if self.camera is None or self._shown is None:
            self._shown = GrowingBox(bounds[:2], bounds[2:])
        elif not self._shown.include(bounds[:2], bounds[2:], moving_boxes(shapes, self._shapes.is_moving)):
            return
        low, high = self._shown.low.tolist(), self._shown.high.tolist()
        self.camera = self._fitted = Camera.fit(Bounds(*low, *high), self.width, self.height)

    def _pen(self, camera: Camera, thickness: float = 1.0) -> marks.Pen:
        radius = thickness * max(PEN_RADIUS * self.height, PEN_RADIUS_MIN)
        scale = camera.scale(self.height)
        return marks.Pen(radius / scale, 0.7 * radius / scale)

    def _draw_contacts(self, world_index: int, camera: Camera) -> list[DrawList]:
        points, forces = read_contacts(self.world, world_index)
        scale = self.force_scale
        if scale is None:
            largest = np.hypot(*forces.T).max(initial=0.0)
            scale = ARROW_LENGTH * camera.height / largest if largest > 0.0 else 0.0
        arrows = marks.arrows(points, points + scale * forces, self._pen(camera), FORCE_COLOR)
        return [arrows, marks.dots(points, self._pen(camera, 1.5), CONTACT_COLOR)]

    def _draw_joints(self, world_index: int, camera: Camera) -> list[DrawList]:
        bodies = read_bodies(self.world, world_index)
        position, rotation = read_joint_frames(self.world, world_index, bodies)
        length = AXIS_LENGTH * camera.height
        pen = self._pen(camera, 0.7)
        normal = np.stack([-rotation[:, 1], rotation[:, 0]], axis=-1)
        axes = [
            marks.arrows(position, position + length * direction, pen, color)
            for direction, color in zip((rotation, normal), AXIS_COLORS, strict=True)
        ]
        return [*axes, marks.dots(position, self._pen(camera, 1.4), JOINT_COLOR)]
