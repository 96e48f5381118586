"""What happens at a window: keys, mouse, gamepad. Positions are in px from the top left corner."""

from dataclasses import dataclass


@dataclass(frozen=True)
class KeyPressed:
    """A key, by the name on it ("a", "space", "left shift"), and the text that it types ("+"; "" for none)."""

    key: str
    text: str = ""


@dataclass(frozen=True)
class KeyReleased:
    key: str


@dataclass(frozen=True)
class ButtonPressed:
    """A mouse button: "left", "middle" or "right"."""

    button: str
    x: float
    y: float
    shift: bool = False


@dataclass(frozen=True)
class ButtonReleased:
    button: str


@dataclass(frozen=True)
class MouseMoved:
    x: float
    y: float


@dataclass(frozen=True)
class Scrolled:
    """The wheel, by `amount` notches away from the user, with the mouse at (x, y)."""

    amount: float
    x: float
    y: float


@dataclass(frozen=True)
class PadMoved:
    """A gamepad's axis, -1 to 1: "left_x", "left_y", "right_x", "right_y" (right and up are positive), "triggers"
    (the right one less the left one)."""

    axis: str
    value: float


@dataclass(frozen=True)
class PadPressed:
    """A gamepad's button: "a", "b", "x", "y", "start", "back", or another one by SDL's name."""

    button: str


@dataclass(frozen=True)
class PadReleased:
    button: str


@dataclass(frozen=True)
class FocusLost:
    """Another window gets the keys from now on; releases of held ones will not be reported."""


@dataclass(frozen=True)
class Exposed:
    """The window has another size or has been uncovered, so it needs a picture."""


@dataclass(frozen=True)
class Closed:
    """The window's close button."""


Event = (
    KeyPressed
    | KeyReleased
    | ButtonPressed
    | ButtonReleased
    | MouseMoved
    | Scrolled
    | PadMoved
    | PadPressed
    | PadReleased
    | FocusLost
    | Exposed
    | Closed
)
