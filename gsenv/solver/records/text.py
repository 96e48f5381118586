"""Values in sentences for people."""

from __future__ import annotations

from typing import Any

MOST_SHOWN = 80  # characters of a value


def shown(value: Any) -> str:
    """Return a value as a sentence shows it: on one line, and shortened."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # an int of more than 4,300 digits, or a class that can't be shown
        text = f"a value of type {type(value).__name__} that cannot be shown"
    return text if len(text) <= MOST_SHOWN else text[: MOST_SHOWN - 3] + "..."
