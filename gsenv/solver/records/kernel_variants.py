"""Kernel variants: each set of features that scenes need has its own step kernel, compiled when first needed."""

from __future__ import annotations

import os
from typing import NamedTuple

from .model import Model

ONE_KERNEL = "GSENV_ONE_KERNEL"  # environment variable: dimensions whose scenes all share one kernel, "3" or "2,3"


class KernelVariant(NamedTuple):
    """The compiled features, without those that may change while a world runs (restitution, solver)."""

    joints: bool
    linked: bool  # joints other than user constraints, welds and targets
    axes: bool  # 3D: joints with axes, gears
    vertices: bool
    continuous: bool
    fields: bool  # 3D: heightfields
    convex: bool  # 3D: cylinders and hulls
    all: bool  # set by the environment variable: restitution and the broadphase's tree, too


def kernel_variant_of(model: Model) -> KernelVariant:
    """Return the features of a scene, or all where the environment variable selects one kernel for all scenes.

    That kernel takes longest to compile and runs slower by a few percent, but a test suite or a script with
    many different scenes compiles it only once.  The results are bit-equal.
    """
    if str(model.dim) in os.environ.get(ONE_KERNEL, "").split(","):
        return KernelVariant(True, True, model.dim == 3, True, True, True, True, True)
    continuous = bool(model.bodies["continuous"].any())
    return KernelVariant(
        model.has_joints,
        model.is_linked,
        model.has_axes,
        model.needs_vertices,
        continuous,
        model.needs_fields,
        model.needs_convex,
        False,
    )
