"""The inverse mass of a joint's coordinate at its reference pose; see spatial/joints/reference.py."""

from __future__ import annotations

from typing import Any

from ...jit import njit


@njit
def reference_give(joint: Any, a: Any, b: Any) -> Any:
    """Return 0 for that of the row: coordinates in the plane have the same inverse mass at each pose."""
    return 0.0
