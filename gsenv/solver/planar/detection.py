"""Scratch of the detection of 2D contacts; the stage is in core/detection.py."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..records.model import contact_dtype


def narrowphase_scratch(fields: bool, convex: bool) -> dict[str, Any]:
    """Return the fields of ``world.scratch.narrowphase``."""
    return {"no_contacts": np.zeros(0, contact_dtype(2))}  # for calls that need only the distance
