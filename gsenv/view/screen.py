"""The picture of a session: the world, marks over it, and panels of text."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render import make_renderer
from gsenv.render.camera import Camera
from gsenv.render.theme import CONTACT_COLOR, FORCE_COLOR, JOINT_COLOR, Rgb
from gsenv.solver.records.model import BodyKind
from gsenv.view.camera_control import Control, make_control
from gsenv.view.dragging import Spring
from gsenv.view.marks import Marks
from gsenv.view.panels import cap_height, draw_panel, draw_status, status_height
from gsenv.view.readings import read_contacts, read_joints
from gsenv.view.simulation import Simulation

Frame = NDArray[np.uint8]
FloatArray = NDArray[np.float64]
Size = tuple[int, int]

TURN_COLOR: Rgb = (92, 176, 255)  # of axes of rotation
SLIDE_COLOR: Rgb = (120, 224, 112)  # of directions of translation
LINK_COLOR: Rgb = (206, 211, 218)
SELECTED_COLOR: Rgb = (255, 255, 255)
SPRING_COLOR: Rgb = (255, 92, 208)
RESULT_COLOR: Rgb = (255, 236, 190)

LINE_SHARE, LINE_MIN = 0.0030, 1.0  # radius of lines over the picture's height, and px at least
LONGEST_FORCE = 0.13  # length of the arrow of the largest force over the picture's height
FORGETTING = 0.98  # the scale of the arrows follows a smaller largest force by this factor in each picture
AXIS_LENGTH = 0.05  # largest half length of an axis over the picture's height
AXIS_REACH = 0.9  # and over the radius of the body on it
RING_SIDES = 40
RETURN = 24  # pictures in which the view goes back to its camera after a drag

SLOW = 0.030  # s: where 3D pictures take longer, they become simpler
SLOWEST = 0.060
PATIENCE = 0.25  # s: a still picture may take this long
WEIGHT = 0.2  # of the last picture in the mean time of a picture
QUALITIES = (("high", 1), ("fast", 1), ("fast", 2))  # quality, and px of the window for one of the picture


@dataclass
class Shown:
    """What the picture shows beside the world."""

    world: int = 0
    contacts: bool = False
    joints: bool = False
    help: bool = False
    score: bool = True
    selected: int | None = None
    following: bool = False


class Screen:
    """Draws the pictures of a session and owns its view.

    size: px; may be assigned. The world is shown above the status bar, in `area`.
    """

    def __init__(self, simulation: Simulation, size: Size) -> None:
        self._simulation = simulation
        self.control: Control = make_control(simulation.world.model.dim)
        self.size = size
        self._renderers: dict[tuple[int, Size], Any] = {}
        self._largest_force = 0.0
        self._standing: Any = None  # the camera while a body is dragged
        self._return = 0.0  # from this one, 0, to the moving one, 1
        self._holds = False
        self._own_camera: Any = None  # where the simulation has none: made from the first picture

    @property
    def size(self) -> Size:
        """px"""
        return self._size

    @size.setter
    def size(self, size: Size) -> None:
        self._size = max(size[0], 1), max(size[1], 1)
        self.area = self._size[0], max(self._size[1] - status_height(self._size[1]), 1)
        self._renderers = {}
        self._quality, self._mean, self._taken = 0, 0.0, [0.0, 0.0, 0.0]

    # ------------------------------------------------- the view

    def base_camera(self, shown: Shown) -> Any:
        """Return the camera that the view is based on.

        It is the one of `_moving_camera`, unless a body is dragged: the view then stands still, or a camera that
        follows the body would move with it, and the mouse would pull for ever. Afterwards it goes back in a moment.
        """
        camera = self._moving_camera(shown)
        if self._standing is None:
            return camera
        return mix(self._standing, camera, self._return)

    def hold(self, shown: Shown) -> None:
        """Let the view stand still until `release`, which lets it go back within RETURN pictures."""
        self._standing, self._return = self.base_camera(shown), 0.0
        self._holds = True

    def release(self) -> None:
        self._holds = False

    @property
    def returns(self) -> bool:
        """Whether the view is going back to its moving camera."""
        return self._standing is not None and not self._holds

    def _moving_camera(self, shown: Shown) -> Any:
        """Return the simulation's camera, on the followed body if there is one."""
        camera = self._simulation.camera(shown.world, self.area)
        if camera is None:
            if self._own_camera is None:
                renderer = self._renderer(0)
                renderer.render(shown.world)
                self._own_camera = renderer.camera
            camera = self._own_camera
        if shown.following and shown.selected is not None:
            place = self._simulation.world.state.bodies["position"][shown.world, shown.selected]
            if self._simulation.world.model.dim == 2:
                return camera._replace(center=(float(place[0]), float(place[1])))
            return camera.following(place)
        return camera

    def aim(self, shown: Shown) -> Any:
        """Point the view to what is to be shown now, and return its camera."""
        return self.control.aim(self.base_camera(shown), self.area)

    def follow(self, shown: Shown, following: bool) -> None:
        """Begin or end following the selected body, without a jump of the view."""
        old = self._moving_camera(shown)
        shown.following = following
        new = self._moving_camera(shown)
        self._standing = None
        self.control.aim(old, self.area)
        self.control.rebase(old, new)

    def _renderer(self, quality: int) -> Any:
        name, coarseness = QUALITIES[quality]
        size = max(self.area[0] // coarseness, 1), max(self.area[1] // coarseness, 1)
        key = (quality, size)
        if key not in self._renderers:
            self._renderers[key] = make_renderer(self._simulation.world, *size, small=name == "fast")
        return self._renderers[key]

    # ------------------------------------------------- pictures

    def draw(
        self, shown: Shown, spring: Spring | None, status: Callable[[], tuple[str, str, str]], *, still: bool = False
    ) -> Frame:
        """Return a new (height, width, 3) picture.

        status: returns the left, middle and right part of the status bar; called once the world is drawn
        still: whether nothing moves, so that the picture may take its time
        """
        if self.returns:
            self._return += 1.0 / RETURN
            if self._return >= 1.0:
                self._standing = None
        camera = self.aim(shown)
        image = self._draw_world(shown, camera, still)
        marks = Marks(max(LINE_SHARE * self.area[1], LINE_MIN))
        if shown.joints:
            self._add_joints(marks, shown.world)
        if shown.contacts:
            self._add_contacts(marks, shown.world)
        if shown.selected is not None and spring is None:
            self._add_ring(marks, shown.world, shown.selected)
        if spring is not None:
            held, pulled = self.control.project(spring.point), self.control.project(spring.target)
            marks.add_lines(held, pulled, SPRING_COLOR)
            marks.add_dots(np.stack([held, pulled]), SPRING_COLOR)
        marks.draw(image)
        self._draw_panels(image, shown)
        return np.concatenate([image, draw_status(*self._size, *status())])[: self._size[1]]

    def _draw_world(self, shown: Shown, camera: Any, still: bool) -> Frame:
        finest = next((q for q, taken in enumerate(self._taken) if taken < PATIENCE), self._quality)
        quality = min(finest, self._quality) if still else self._quality
        renderer = self._renderer(quality)
        renderer.camera = camera
        began = time.perf_counter()
        simulation, world = self._simulation, shown.world
        frame: Frame = renderer.render(world, lines=simulation.lines(world), **simulation.decor(world))
        if self._simulation.world.model.dim == 3:
            self._taken[quality] = time.perf_counter() - began
            if not still:
                self._adapt(self._taken[quality])
        coarseness = QUALITIES[quality][1]
        return enlarge(frame, coarseness, self.area) if coarseness > 1 else frame

    def _adapt(self, taken: float) -> None:
        """Choose simpler pictures where they take too long."""
        self._mean = taken if self._mean == 0.0 else (1.0 - WEIGHT) * self._mean + WEIGHT * taken
        if self._mean > (SLOW, SLOWEST, math.inf)[self._quality]:
            self._quality += 1
            self._mean = 0.0

    def _add_contacts(self, marks: Marks, world: int) -> None:
        points, forces = read_contacts(self._simulation.world, world)
        size = np.sqrt((forces**2).sum(-1))
        self._largest_force = max(FORGETTING * self._largest_force, float(size.max(initial=0.0)))
        if not len(points):
            return
        scale = LONGEST_FORCE * self.control.view_height / max(self._largest_force, 1e-300)
        starts = self.control.project(points)
        marks.add_arrows(starts, self.control.project(points + scale * forces), FORCE_COLOR)
        marks.add_dots(starts, CONTACT_COLOR, 1.6)

    @property
    def largest_force(self) -> float:
        """N, of the longest arrow"""
        return self._largest_force

    def _add_joints(self, marks: Marks, world: int) -> None:
        places = read_joints(self._simulation.world, world)
        length = np.minimum(AXIS_LENGTH * self.control.view_height, AXIS_REACH * places.radii)
        reach = length[:, None] * places.axes
        starts, ends = self.control.project(places.centers - reach), self.control.project(places.centers + reach)
        links = self.control.project(places.links)
        marks.add_lines(links[:, 0], links[:, 1], LINK_COLOR, 0.7)
        marks.add_dots(links, JOINT_COLOR, 1.4)
        slides = places.slides
        marks.add_arrows(starts[slides], ends[slides], SLIDE_COLOR)
        marks.add_lines(starts[~slides], ends[~slides], TURN_COLOR)
        marks.add_dots(self.control.project(places.anchors), JOINT_COLOR, 1.6)

    def _add_ring(self, marks: Marks, world: int, body: int) -> None:
        """Draw a ring around a body that moves."""
        state = self._simulation.world
        if state.model.bodies["kind"][body] == BodyKind.STATIC:
            return
        center = state.state.bodies["position"][world, body]
        radius = float(state.parameters.bodies["radius"][world, body])
        middle = self.control.project(center)
        near = self.control.on_plane((float(middle[0]) + 1.0, float(middle[1])), center) - center  # m, one px
        px = radius / max(float(np.sqrt(near @ near)), 1e-12) + 4.0 * marks.radius
        angles = np.arange(RING_SIDES + 1) * (2.0 * math.pi / RING_SIDES)
        ring = middle + px * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        marks.add_lines(ring[:-1], ring[1:], SELECTED_COLOR, 0.6)

    def _draw_panels(self, image: Frame, shown: Shown) -> None:
        simulation, world = self._simulation, shown.world
        letter = cap_height(self._size[1])
        draw_panel(image, [list(simulation.captions(world))], 0.0, 0.0, letter=1.2 * letter)
        score = simulation.score(world) if shown.score and not shown.help else ()
        if score:
            draw_panel(image, [[name for name, _ in score], [value for _, value in score]], 1.0, 0.0, letter=letter)
        result = simulation.result(world)
        if result and not shown.help:
            draw_panel(image, [[result]], 0.5, 0.3, letter=1.5 * letter, color=RESULT_COLOR)
        if shown.help:
            rows = help_rows(simulation)
            draw_panel(
                image, [[key for key, _ in rows], [text for _, text in rows]], 0.5, 0.5, letter=letter, alpha=0.95
            )


def help_rows(simulation: Simulation) -> list[tuple[str, str]]:
    """Return the keys and what they do."""
    planar = simulation.world.model.dim == 2
    steering = simulation.steering
    rows = [
        ("space", "pause or go on"),
        (". (dot)", "single step"),
        ("+  -", "faster, slower"),
        ("r", "restart this episode"),
        ("n", "next episode"),
        ("c", "contact forces"),
        ("j", "joints and their axes"),
        ("i", "reward"),
        ("tab", "next world"),
        ("f", "follow the selected body"),
        ("home", "first view"),
        ("escape", "quit"),
        ("", ""),
        ("left mouse", "drag a body"),
        ("right mouse", "move the view" if planar else "turn the view"),
        *([] if planar else [("shift + right", "move the view")]),
        ("wheel", "zoom"),
    ]
    useless = {"tab"} if simulation.world.world_count == 1 else set()
    useless |= set() if simulation.score(0) else {"i"}
    useless |= {"n"} if simulation.seeds is None else set()
    rows = [row for row in rows if row[0] not in useless]
    if steering is None:
        return rows
    return [*steering.help(), ("", ""), *(row for row in rows if not steering.takes(row[0]))]


def mix(start: Any, end: Any, share: float) -> Any:
    """Return the camera at a share of the way between two of the same kind, smoothly at both ends."""
    share = share * share * (3.0 - 2.0 * share)
    if isinstance(start, Camera):
        (ax, ay), (bx, by) = start.center, end.center
        center = ax + share * (bx - ax), ay + share * (by - ay)
        return Camera(center, start.height + share * (end.height - start.height))
    points = {}
    for name in ("eye", "target", "up"):
        a, b = np.asarray(getattr(start, name), float), np.asarray(getattr(end, name), float)
        points[name] = a + share * (b - a)
    return end._replace(**points, fov=start.fov + share * (end.fov - start.fov))


def enlarge(frame: Frame, factor: int, size: Size) -> Frame:
    """Return the frame with each px repeated, cut or extended to (width, height) px."""
    rows = np.minimum(np.arange(size[1]) // factor, frame.shape[0] - 1)
    columns = np.minimum(np.arange(size[0]) // factor, frame.shape[1] - 1)
    return np.ascontiguousarray(frame[rows][:, columns])
