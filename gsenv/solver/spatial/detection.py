"""Scratch of the detection of 3D contacts; the stage is in core/detection.py."""

from __future__ import annotations

from typing import Any

import numpy as np

from .narrowphase.manifold import manifold_dtype
from .narrowphase.scratch import scratch_dtype
from .narrowphase.spread import SCRATCH_SIZE, field_scratch_dtype


def narrowphase_scratch(fields: bool, convex: bool) -> dict[str, Any]:
    """Return the fields of ``world.scratch.narrowphase``: the manifold, and scratch of its computation."""
    return {
        "manifold": np.zeros((), manifold_dtype()),
        "clip": np.zeros((), scratch_dtype()),
        "field": np.zeros(SCRATCH_SIZE, field_scratch_dtype()) if fields else None,  # of heightfields
        "convex": np.ones(1) if convex else None,  # any value but None: GJK and EPA are needed
    }
