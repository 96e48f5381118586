"""A session at a window: what keys, mouse and gamepad do. It needs no window; tests feed it with events."""

from __future__ import annotations

import time

from gsenv.view.dragging import Picked, Picker, Spring
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
from gsenv.view.screen import Frame, Screen, Shown, Size
from gsenv.view.simulation import Simulation

SPEEDS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0, 2.0, 4.0, 8.0, 16.0)
NORMAL = SPEEDS.index(1.0)
BUDGET = 1.0 / 30.0  # s of real time that the steps of one frame may take
SETTLED = 0.25  # s without a change, after which a still picture may take its time
RATE_WEIGHT = 0.1
DRAGGED, ORBITED, PANNED = "drag", "orbit", "pan"


class Session:
    """The state of a window on a simulation: speed, view, selected body, overlays.

    size: px of the picture; assign `screen.size` when the window's size changes
    running: whether the window should stay open
    """

    def __init__(self, simulation: Simulation, size: Size, *, paused: bool = False) -> None:
        self.simulation = simulation
        self.screen = Screen(simulation, size)
        self.shown = Shown()
        self.running = True
        self.paused = paused
        self.spring: Spring | None = None
        self._picker = Picker(simulation.world)
        self._speed = NORMAL
        self._debt = 0.0  # s of simulated time that are due
        self._rate = 1.0  # simulated over real time, a mean
        self._mouse = (0.0, 0.0)
        self._held: str | None = None  # what the pressed mouse button does
        self.screen.aim(self.shown)
        self._changed = True  # since the last picture
        self._settled_for = 0.0  # s since the last change
        self._is_fine = False  # the last picture took its time

    @property
    def speed(self) -> float:
        """Simulated over real time that is asked for."""
        return SPEEDS[self._speed]

    # ------------------------------------------------- time

    def tick(self, elapsed: float) -> None:
        """Advance the simulation by the steps that are due after `elapsed` s of real time."""
        self._settled_for += elapsed
        if self.paused:
            return
        self._debt += self.speed * elapsed
        began = time.perf_counter()
        done = 0.0
        period = self.simulation.period
        while self._debt >= period - 1e-9:
            self._advance()
            self._debt -= period
            done += period
            if time.perf_counter() - began > BUDGET:
                self._debt = min(self._debt, period)  # too slow for this speed: what is due is dropped
                break
        if elapsed > 0.0:
            self._rate += RATE_WEIGHT * (done / elapsed - self._rate)

    def _advance(self) -> None:
        if self.spring is not None:
            self._pull_to_mouse(self.spring)  # also where the mouse rests and the view moves
        before = float(self.simulation.world.time[self.shown.world])
        self.simulation.advance(None if self.spring is None else self.spring.pull)
        if float(self.simulation.world.time[self.shown.world]) < before:  # another episode has begun
            self._let_go()
        self._touch()

    def step(self) -> None:
        """Pause, and advance by one period."""
        self.paused = True
        self._advance()

    def restart(self, *, anew: bool) -> None:
        """Begin the shown world's episode again, or its next one; nothing is dragged any more."""
        self._let_go()
        world, seeds = self.shown.world, self.simulation.seeds
        self.simulation.restart(world, None if anew or seeds is None else seeds[world])
        self._touch()

    def _touch(self) -> None:
        self._changed = True
        self._settled_for = 0.0

    # ------------------------------------------------- pictures

    @property
    def needs_picture(self) -> bool:
        """Whether the last picture is out of date, or nothing moves and it could be finer."""
        return self._changed or self.screen.returns or (self._settled_for > SETTLED and not self._is_fine)

    def picture(self) -> Frame:
        """Return a new picture (height, width, 3)."""
        still = self._settled_for > SETTLED
        frame = self.screen.draw(self.shown, self.spring, self._status, still=still)
        self._changed = False
        self._is_fine = still
        return frame

    def _status(self) -> tuple[str, str, str]:
        world = self.simulation.world
        pace = f"{self.speed:g}x"
        if self.paused:
            pace = f"paused, {pace}"
        elif self._rate < 0.8 * self.speed:
            pace += f" ({self._rate:.2f}x reached)"
        parts = [pace, f"{float(world.time[self.shown.world]):.2f} s"]
        if self.simulation.seeds is not None:
            parts.append(f"seed {self.simulation.seeds[self.shown.world]}")
        if world.world_count > 1:
            parts.append(f"world {self.shown.world + 1} of {world.world_count}")
        middle = []
        if self.shown.selected is not None:
            middle.append(self._describe(self.shown.selected))
        if self.shown.contacts:
            middle.append(f"longest arrow {written(self.screen.largest_force)} N")
        return "   ".join(parts), "   ".join(middle), "h: help"

    def _describe(self, body: int) -> str:
        world = self.simulation.world
        mass = float(world.parameters.bodies["mass"][self.shown.world, body])
        parts = [world.model.body_names[body]]
        if self._picker.movable[body]:
            parts.append(f"{written(mass)} kg")
        if self.shown.following:
            parts.append("followed")
        elif world.state.bodies["asleep"][self.shown.world, body]:
            parts.append("asleep")
        return ", ".join(parts)

    # ------------------------------------------------- events

    def handle(self, event: Event) -> None:
        """Do what a key, the mouse or a gamepad asks for."""
        steering = self.simulation.steering
        match event:
            case Closed():
                self.running = False
            case KeyPressed(key, text):
                if steering is not None and steering.takes(key):
                    steering.press(key)
                else:
                    self._press(key, text)
            case KeyReleased(key) if steering is not None and steering.takes(key):
                steering.release(key)
            case FocusLost():
                self._let_go()
                if steering is not None:
                    steering.release_all()
            case PadMoved(axis, value) if steering is not None:
                steering.move_axis(axis, value)
            case PadPressed(button):
                self._press_pad(button)
            case PadReleased(button) if steering is not None:
                steering.release_button(button)
            case _:
                self._handle_mouse(event)
        if not isinstance(event, (KeyReleased, PadReleased, PadMoved)):
            self._touch()

    def _handle_mouse(self, event: Event) -> None:
        match event:
            case ButtonPressed(button, x, y, shift):
                self._mouse = (x, y)
                self._press_button(button, shift)
            case ButtonReleased():
                self._let_go()
            case MouseMoved(x, y):
                self._move_mouse(x, y)
            case Scrolled(amount, x, y):
                self.screen.control.zoom(amount, (x, y))
            case Exposed():
                self._is_fine = False
            case _:
                pass

    def _press(self, key: str, text: str) -> None:
        text = text or key
        if text in ("+", "=", "[+]"):
            self._set_speed(self._speed + 1)
        elif text in ("-", "_", "[-]"):
            self._set_speed(self._speed - 1)
        else:
            self._press_named(key)

    def _set_speed(self, number: int) -> None:
        self._speed = min(max(number, 0), len(SPEEDS) - 1)
        self._rate = self.speed

    def _press_named(self, key: str) -> None:
        shown = self.shown
        match key:
            case "space":
                self.paused = not self.paused
                self._debt = 0.0
            case "." | "right":
                self.step()
            case "r":
                self.restart(anew=False)
            case "n":
                self.restart(anew=True)
            case "c":
                shown.contacts = not shown.contacts
            case "j":
                shown.joints = not shown.joints
            case "i":
                shown.score = not shown.score
            case "h" | "f1" | "?":
                shown.help = not shown.help
            case "tab":
                self._show_world((shown.world + 1) % self.simulation.world.world_count)
            case "f":
                self._follow()
            case "home" | "0":
                self._show_world(shown.world)
                self.screen.control.reset()
            case "q" | "escape":
                self.running = False

    def _press_pad(self, button: str) -> None:
        steering = self.simulation.steering
        if steering is not None and steering.press_button(button):
            return
        if button == "start":
            self._press_named("space")
        elif button == "back":
            self._press_named("r")

    def _show_world(self, world: int) -> None:
        """Show a world, with nothing selected or dragged."""
        self._let_go()
        self.shown.world = world
        self.shown.selected = None
        self.shown.following = False

    def _follow(self) -> None:
        if self.shown.selected is not None:
            self.screen.follow(self.shown, not self.shown.following)

    # ------------------------------------------------- mouse

    def _press_button(self, button: str, shift: bool) -> None:
        self._let_go()
        if button == "left":
            self._grab()
        elif button == "middle" or shift:
            self._held = PANNED
        else:
            self._held = ORBITED

    def _grab(self) -> None:
        """Select what is under the mouse, and hold it if it can move."""
        picked: Picked | None = self._picker.pick(self.screen.control, self._mouse, self.shown.world)
        selected = None if picked is None else picked.body
        if self.shown.following and selected != self.shown.selected:
            self.screen.follow(self.shown, False)
        self.shown.selected = selected
        if picked is not None and self._picker.movable[picked.body]:
            self.spring = Spring(self.simulation.world, self.shown.world, picked)
            self._held = DRAGGED
            self.screen.hold(self.shown)

    def _move_mouse(self, x: float, y: float) -> None:
        dx, dy = x - self._mouse[0], y - self._mouse[1]
        self._mouse = (x, y)
        control = self.screen.control
        if self._held == DRAGGED and self.spring is not None:
            self._pull_to_mouse(self.spring)
        elif self._held == ORBITED:
            control.turn(dx, dy)
        elif self._held == PANNED:
            control.pan(dx, dy)

    def _pull_to_mouse(self, spring: Spring) -> None:
        """Pull to the mouse, in the plane parallel to the picture in which the body was picked."""
        spring.move(self.screen.control.on_plane(self._mouse, spring.target))

    def _let_go(self) -> None:
        self._held = None
        self.spring = None
        self.screen.release()


def written(value: float) -> str:
    """Return a number with three digits, or all of a large one, without an exponent where it can be read without."""
    return f"{value:.0f}" if 100.0 <= abs(value) < 1e7 else f"{value:.3g}"
