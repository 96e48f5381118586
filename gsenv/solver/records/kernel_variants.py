"""Kernel variants: each set of features that scenes need has its own step kernel, compiled when first needed."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import NamedTuple

from .model import Model

ONE_KERNEL = "GSENV_ONE_KERNEL"  # environment variable: dimensions whose scenes all share one kernel, "3" or "2,3"
OWN_KERNELS = "GSENV_OWN_KERNELS"  # environment variable: "1" compiles the kernel of a scene that has none


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
        return general_variant(model.dim)
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


def general_variant(dim: int) -> KernelVariant:
    """Return all features, with which a kernel steps any scene of the dimension."""
    return KernelVariant(True, True, dim == 3, True, True, True, True, True)


def choose_variant(model: Model, is_compiled: Callable[[KernelVariant], bool]) -> KernelVariant:
    """Return the features of a scene, or all where only the kernel of these is compiled.  The results are bit-equal."""
    own, general = kernel_variant_of(model), general_variant(model.dim)
    if own == general or os.environ.get(OWN_KERNELS) == "1" or is_compiled(own) or not is_compiled(general):
        return own
    return general
