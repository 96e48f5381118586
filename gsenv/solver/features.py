"""What of the step kernel a scene needs: each set of features has a kernel of its own, compiled when first needed."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np

from .model import Model

ONE_KERNEL = "GSENV_ONE_KERNEL"  # environment variable: dimensions whose scenes all share one kernel, "3" or "2,3"


class Features(NamedTuple):
    """True: compiled. What changes while a world runs (restitution, the solver) is not among them."""

    joints: bool
    linked: bool  # joints beyond rows, welds and targets
    vertices: bool
    fast: bool
    fields: bool  # of space: heightfields
    convex: bool  # of space: cylinders and hulls
    all: bool  # asked for by the environment: restitution too


def features_of(model: Model) -> Features:
    """The features of a scene; all of them where the environment asks for one kernel for all scenes.

    That one takes longest to compile and is slower to run by a few percent, but a test suite or a script
    with many different scenes compiles it once.  The results are the same bits.
    """
    if str(model.dim) in os.environ.get(ONE_KERNEL, "").split(","):
        return Features(True, True, True, True, True, True, True)
    fields = convex = False
    if model.dim == 3:
        from .spatial.kinds import CYLINDER, HEIGHTFIELD, HULL

        fields = bool((model.shapes["kind"] == HEIGHTFIELD).any())
        convex = bool(np.isin(model.shapes["kind"], (CYLINDER, HULL)).any())
    fast = bool(model.bodies["fast"].any())
    return Features(model.has_joints, model.is_linked, model.needs_vertices, fast, fields, convex, False)
