"""The one argument of a step: all records of the worlds that one thread steps, as a bundle of bundles."""

from __future__ import annotations

from typing import Any

import numpy as np

from .bundle import Bundle, per_world
from .kernel_variants import KernelVariant
from .model import Array, Model
from .scratch import Scratch

PRESENT = np.ones(1)  # any value but None: the scene has the part


def has_restitution(variant: KernelVariant, parameters: Any) -> bool:
    """Return whether the step needs its code for impacts: any shape of any world has a restitution."""
    return variant.all or bool(parameters.shapes["restitution"].any())


def kernel_world(
    model: Model,
    parameters: Any,
    state: Any,
    scratch: Scratch,
    options: Array,
    variant: KernelVariant,
    restitution: bool,
    solver: str,
    until: Array,
    articulated: bool,
) -> Bundle:
    """Return the bundle that kernels call ``world``; its fields are those below.

    ``world.shapes`` has what the narrowphase needs of shapes: its leaves take that instead of ``world``, so
    that scenes with and without joints share their compiled code.

    ``world.state`` and ``world.parameters`` show the world that ``select_world`` has selected.
    ``world.variant.restitution`` is None without ``restitution`` (see ``has_restitution``), ``world.variant.soft``
    and ``newton`` are None unless that is the solver, ``world.variant.axes`` without 3D joints with axes. Further
    parts that are None in scenes without them: joints, vertices, start_poses, closing_poses, joint_factor,
    articulation, broadphase, narrowphase.field, narrowphase.convex.
    """
    dim = model.dim
    jointed = variant.joints
    return Bundle(
        "World",
        dim,
        options=options.copy(),  # a thread's own: the length of a step may be divided
        control=state.control,
        until=until,
        model=Bundle(
            "Model",
            dim,
            bodies=model.bodies,
            shapes=model.shapes,
            joints=model.joints if jointed else None,
            actuators=model.actuators if jointed else None,
            exclusions=model.exclusions,
            trees=model.trees if articulated else None,
        ),
        parameters=Bundle(
            "Parameters",
            dim,
            world=per_world(parameters.worlds),
            bodies=per_world(parameters.bodies),
            shapes=per_world(parameters.shapes),
            joints=per_world(parameters.joints) if jointed else None,
            rows=per_world(parameters.rows) if jointed else None,
            vertices=per_world(parameters.vertices) if variant.vertices else None,
        ),
        state=Bundle(
            "State",
            dim,
            world=per_world(state.worlds),
            bodies=per_world(state.bodies),
            contacts=per_world(state.contacts),
            joints=per_world(state.joints) if jointed else None,
            control=per_world(state.control),
        ),
        shapes=Bundle(
            "Shapes",
            dim,
            models=model.shapes,
            parameters=per_world(parameters.shapes),
            vertices=per_world(parameters.vertices) if variant.vertices else None,
        ),
        scratch=scratch.bundle(articulated),
        variant=Bundle(
            "Variant",
            dim,
            restitution=PRESENT if restitution else None,
            soft=PRESENT if solver == "soft" else None,
            newton=PRESENT if solver == "newton" else None,
            axes=PRESENT if variant.axes else None,
        ),
    ).seal()
