"""Playing a task: which keys and which parts of a gamepad set which entries of its action."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

RISE = 0.15  # s, in which an action gets from 0 to 1 while a key is held
DEAD_ZONE = 0.12  # of a stick


@dataclass(frozen=True)
class Key:
    """A key of the keyboard, by pygame's name, and the entries of the action that it sets while it is held."""

    key: str
    text: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Stick:
    """A gamepad's axis: "left_x", "left_y", "right_x", "right_y" (right and up are positive) or "triggers" (the right
    one less the left one), and the entries of the action that it moves, with factors."""

    axis: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Button:
    """A gamepad's button, "a", "b", "x" or "y", and the entries of the action that it sets while it is held."""

    button: str
    values: Mapping[str, float]


Control = Key | Stick | Button


def pair(low: str, high: str, text: str, *entries: str) -> tuple[Key, Key]:
    """Return two keys that set entries to -1 and to 1."""
    low_text, _, high_text = text.partition("|")
    return (
        Key(low, low_text, dict.fromkeys(entries, -1.0)),
        Key(high, high_text or low_text, dict.fromkeys(entries, 1.0)),
    )


ROWS = ("asdfghjkl", "qwertyuio")  # keys of tasks without a table: lower and raise the first entries


def default_controls(names: Sequence[str]) -> tuple[Control, ...]:
    """Return keys for a task that declares none: two for each of its first nine entries."""
    keys: list[Control] = []
    for low, high, name in zip(*ROWS, names, strict=False):
        keys += pair(low, high, name.replace("_", " "), name)
    sticks = [
        Stick(axis, {name: 1.0}) for axis, name in zip(("left_x", "left_y", "right_x", "right_y"), names, strict=False)
    ]
    return (*keys, *sticks)


class Steering:
    """The actions (agent, entry) that the held keys and the gamepad ask for; the gamepad acts for the first agent.

    names: of the entries of an action
    controls: of each agent
    """

    def __init__(self, names: Sequence[str], controls: Sequence[Sequence[Control]]) -> None:
        self._names = list(names)
        self._controls = [list(of_agent) for of_agent in controls]
        self._keys = {c.key for of_agent in self._controls for c in of_agent if isinstance(c, Key)}
        self._buttons = {c.button for of_agent in self._controls[:1] for c in of_agent if isinstance(c, Button)}
        self._held: set[str] = set()
        self._held_buttons: set[str] = set()
        self._axes: dict[str, float] = {}
        self._actions = np.zeros((len(self._controls), len(self._names)), np.float32)

    def takes(self, key: str) -> bool:
        """Whether a key steers."""
        return key in self._keys

    def press(self, key: str) -> None:
        self._held.add(key)

    def release(self, key: str) -> None:
        self._held.discard(key)

    def move_axis(self, axis: str, value: float) -> None:
        """Set a gamepad's axis, -1 to 1."""
        beyond = max(abs(value) - DEAD_ZONE, 0.0) / (1.0 - DEAD_ZONE)
        self._axes[axis] = beyond if value > 0.0 else -beyond

    def press_button(self, button: str) -> bool:
        """Press a gamepad's button and return whether it steers."""
        self._held_buttons.add(button)
        return button in self._buttons

    def release_button(self, button: str) -> None:
        self._held_buttons.discard(button)

    def release_all(self) -> None:
        """Release all keys, buttons and sticks."""
        self._held.clear()
        self._held_buttons.clear()
        self._axes.clear()

    def advance(self, elapsed: float) -> Array:
        """Return the actions (agent, entry) after `elapsed` s more; those of keys rise and fall within RISE."""
        wanted = np.zeros_like(self._actions)
        for a, controls in enumerate(self._controls):
            for control in controls:
                for name, value in control.values.items():
                    wanted[a, self._names.index(name)] += value * self._strength(control, a)
        wanted = np.clip(wanted, -1.0, 1.0)
        most = np.float32(elapsed / RISE)
        self._actions += np.clip(wanted - self._actions, -most, most)
        return self._actions.copy()

    def _strength(self, control: Control, agent: int) -> float:
        match control:
            case Key(key):
                return float(key in self._held)
            case Stick(axis):
                return self._axes.get(axis, 0.0) if agent == 0 else 0.0
            case Button(button):
                return float(agent == 0 and button in self._held_buttons)

    def rest(self) -> None:
        """Set the actions to zero at once, at the start of an episode; held keys stay held."""
        self._actions[:] = 0.0

    def help(self) -> list[tuple[str, str]]:
        """Return (keys, what they do); keys that do the same thing in two directions share a row."""
        keys = [c for of_agent in self._controls for c in of_agent if isinstance(c, Key)]
        rows: dict[str, list[str]] = {}
        for key in keys:
            rows.setdefault(key.text, []).append(key.key)
        return [("  ".join(names), text) for text, names in rows.items()]
