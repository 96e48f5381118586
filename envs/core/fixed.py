"""Attributes of all environments that stay as they were when the environment was made."""

from __future__ import annotations

from typing import Any


def check_fixed(what: str, value: Any, present: Any) -> None:
    """Raise ValueError unless the value is the present one of what stays as it was when the environment was made."""
    if value != present:
        raise ValueError(f"{what} is set when the environment is made, and stays.")


def _set_render_mode(env: Any, value: str | None) -> None:
    check_fixed("render_mode", value, env.render_mode)


# Any: the libraries' classes declare plain attributes of these names.
RENDER_MODE: Any = property(
    lambda env: env._painter.render_mode,
    _set_render_mode,
    doc='None, "human" or "rgb_array"; setting another one than that which it was made with raises ValueError.',
)
SPLIT: Any = property(
    lambda env: env._split, doc='"train" or "test", of all episodes; it is set when the environment is made.'
)
