"""A window on the screen: shows frames, reports events. The only module that imports pygame, at the first window.

All windows of a process share one queue of events, so events are taken for all windows at once and
sorted by window.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.view.events import (
    ButtonPressed,
    ButtonReleased,
    Closed,
    Event,
    Exposed,
    FocusLost,
    KeyPressed,
    KeyReleased,
    MouseMoved,
    PadMoved,
    PadPressed,
    PadReleased,
    Scrolled,
)

Frame = NDArray[np.uint8]
Size = tuple[int, int]

NO_PYGAME = "a window needs pygame-ce: pip install 'gsenv[human]'"
NO_DISPLAY = (
    "there is no display to open a window on; `gsenv record` and render_mode='rgb_array' need none, and the "
    "environment variable SDL_VIDEODRIVER=dummy is one that nobody sees, for checkers and tests"
)
LINUX_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")  # variables that name one
BUTTONS = {1: "left", 2: "middle", 3: "right"}
PAD_AXES = ("left_x", "left_y", "right_x", "right_y", "left_trigger", "right_trigger")  # SDL's numbers
PAD_BUTTONS = ("a", "b", "x", "y", "back", "guide", "start", "left_stick", "right_stick", "left_shoulder",
               "right_shoulder", "up", "down", "left", "right")  # fmt: skip
PAD_RANGE = 32767.0


class WindowError(RuntimeError):
    """There is no display."""


class _Screen:
    """pygame, and the windows and gamepads that are open in this process."""

    def __init__(self) -> None:
        self.pygame: Any = None
        self.windows: dict[int, Window] = {}
        self._pads: dict[int, Any] = {}
        self._triggers = [0.0, 0.0]
        self._owns_display = False

    def open(self) -> Any:
        """Return pygame with its display ready.

        Raises:
            ImportError: pygame-ce is missing.
            WindowError: there is no display.
        """
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            import pygame

            pygame.Window  # noqa: B018  # of pygame-ce; pygame has none
        except (ImportError, AttributeError):
            raise ImportError(NO_PYGAME, name="pygame") from None
        if not pygame.display.get_init():
            if sys.platform == "linux" and not any(os.environ.get(name) for name in LINUX_DISPLAYS):
                raise WindowError(NO_DISPLAY)  # SDL would choose a display in memory, and complain of missing ones
            try:
                pygame.display.init()
            except pygame.error as error:
                raise WindowError(f"{NO_DISPLAY} ({error})") from None
            self._owns_display = True
        if self.pygame is None:
            self.pygame = pygame
            self._open_pads()
        return pygame

    def _open_pads(self) -> None:
        try:
            from pygame._sdl2 import controller
        except ImportError:
            return
        controller.init()
        for number in range(controller.get_count()):
            if controller.is_controller(number):
                pad = controller.Controller(number)
                self._pads[pad.id] = pad

    def release(self) -> None:
        """Close pygame's display if no window is open."""
        if not self.windows:
            self._quit()

    def _quit(self) -> None:
        for pad in self._pads.values():
            pad.quit()
        self._pads.clear()
        if self._owns_display:
            self.pygame.display.quit()
        self._owns_display = False
        self.pygame = None

    def sort_events(self) -> None:
        """Take all events and give each to its window, those of gamepads to all windows."""
        pygame = self.pygame
        for event in pygame.event.get():
            if event.type == pygame.CONTROLLERDEVICEADDED:
                self._open_pads()
                continue
            pad_event = self._convert_pad(event)
            if pad_event is not None:
                for window in self.windows.values():
                    window.events.append(pad_event)
                continue
            owner = self.windows.get(getattr(getattr(event, "window", None), "id", -1))
            if owner is None:
                continue
            converted = _convert(pygame, event, owner)
            if converted is not None:
                owner.events.append(converted)

    def _convert_pad(self, event: Any) -> Event | None:
        pygame = self.pygame
        if event.type == pygame.CONTROLLERAXISMOTION and event.axis < len(PAD_AXES):
            value = max(-1.0, min(1.0, event.value / PAD_RANGE))
            if event.axis >= 4:
                self._triggers[event.axis - 4] = value
                return PadMoved("triggers", self._triggers[1] - self._triggers[0])
            name = PAD_AXES[event.axis]
            return PadMoved(name, -value if name.endswith("y") else value)
        if event.type in (pygame.CONTROLLERBUTTONDOWN, pygame.CONTROLLERBUTTONUP) and event.button < len(PAD_BUTTONS):
            kind = PadPressed if event.type == pygame.CONTROLLERBUTTONDOWN else PadReleased
            return kind(PAD_BUTTONS[event.button])
        return None


def _convert(pygame: Any, event: Any, window: Window) -> Event | None:
    """Return what a window's event means, or None for one of no interest."""
    kind = event.type
    if kind == pygame.KEYDOWN:
        return KeyPressed(pygame.key.name(event.key), getattr(event, "unicode", ""))
    if kind == pygame.KEYUP:
        return KeyReleased(pygame.key.name(event.key))
    if kind == pygame.MOUSEBUTTONDOWN and event.button in BUTTONS:
        shift = bool(pygame.key.get_mods() & pygame.KMOD_SHIFT)
        x, y = event.pos
        return ButtonPressed(BUTTONS[event.button], float(x), float(y), shift)
    if kind == pygame.MOUSEBUTTONUP and event.button in BUTTONS:
        return ButtonReleased(BUTTONS[event.button])
    if kind == pygame.MOUSEMOTION:
        window.mouse = (float(event.pos[0]), float(event.pos[1]))
        return MouseMoved(*window.mouse)
    if kind == pygame.MOUSEWHEEL:
        return Scrolled(float(getattr(event, "precise_y", event.y)), *window.mouse)
    simple: dict[int, type[FocusLost] | type[Exposed] | type[Closed]] = {
        pygame.WINDOWFOCUSLOST: FocusLost,
        pygame.WINDOWSIZECHANGED: Exposed,
        pygame.WINDOWEXPOSED: Exposed,
        pygame.WINDOWCLOSE: Closed,
    }
    return simple[kind]() if kind in simple else None


_SCREEN = _Screen()


class Window:
    """A window that can be resized.

    title: its title; size: px, of the picture area

    Raises:
        ImportError: pygame-ce is missing.
        WindowError: there is no display.
    """

    def __init__(self, title: str, size: Size) -> None:
        pygame = _SCREEN.open()
        try:
            self._window: Any = pygame.Window(title, size, resizable=True)
        except pygame.error as error:
            raise WindowError(f"{NO_DISPLAY} ({error})") from None
        self.events: list[Event] = []  # not yet taken
        self.mouse = (0.5 * size[0], 0.5 * size[1])
        _SCREEN.windows[self._window.id] = self

    @property
    def is_open(self) -> bool:
        return self._window is not None

    @property
    def size(self) -> Size:
        """px, of the picture area"""
        width, height = self._window.get_surface().get_size()
        return int(width), int(height)

    @property
    def title(self) -> str:
        return str(self._window.title)

    @title.setter
    def title(self, title: str) -> None:
        if title != self._window.title:
            self._window.title = title

    def show(self, frame: Frame) -> None:
        """Show a (height, width, 3) frame, scaled to the window if it has another shape."""
        pygame = _SCREEN.pygame
        surface = self._window.get_surface()
        picture = pygame.image.frombuffer(np.ascontiguousarray(frame), (frame.shape[1], frame.shape[0]), "RGB")
        if picture.get_size() != surface.get_size():
            size = fit(picture.get_size(), surface.get_size())
            picture = pygame.transform.smoothscale(picture.convert(surface), size)
            surface.fill((0, 0, 0))
        left, top = (surface.get_width() - picture.get_width()) // 2, (surface.get_height() - picture.get_height()) // 2
        surface.blit(picture, (left, top))
        self._window.flip()

    def read(self) -> Frame:
        """Return what the window shows, (height, width, 3)."""
        frame: Frame = _SCREEN.pygame.surfarray.array3d(self._window.get_surface()).swapaxes(0, 1)
        return frame

    def take_events(self) -> list[Event]:
        """Return the events since the last call."""
        _SCREEN.sort_events()
        events, self.events = self.events, []
        return events

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        if self._window is not None:
            window, self._window = self._window, None
            number = window.id
            window.destroy()
            del _SCREEN.windows[number]
            _SCREEN.release()

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def fit(picture: Size, room: Size) -> Size:
    """Return the largest size of the picture's shape that fits into the room."""
    scale = min(room[0] / picture[0], room[1] / picture[1])
    return max(round(scale * picture[0]), 1), max(round(scale * picture[1]), 1)


def default_size() -> Size:
    """Return the size in px of a window on this screen: 640 x 480, doubled on screens of about 2160 px in height.

    Raises:
        ImportError: pygame-ce is missing.
        WindowError: there is no display.
    """
    pygame = _SCREEN.open()
    heights = [height for _, height in pygame.display.get_desktop_sizes()]
    _SCREEN.release()
    factor = max(1, round(heights[0] / 1080)) if heights else 1
    return 640 * factor, 480 * factor
