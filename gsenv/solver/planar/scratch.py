"""Scratch of the 2D narrowphase."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..records.model import contact_dtype


def narrowphase_scratch(fields: bool, convex: bool) -> dict[str, Any]:
    """Return the fields of ``world.scratch.narrowphase``."""
    return {"no_contacts": np.zeros(0, contact_dtype(2))}  # for calls that need only the distance
