"""The argument ``world`` of kernels, for tests that have arrays instead of a World."""

from __future__ import annotations

from typing import Any

import numpy as np

from gsenv.solver.core.broadphase import broadphase_scratch
from gsenv.solver.dimension import dimension
from gsenv.solver.records import model as records
from gsenv.solver.records import scratch_dtypes
from gsenv.solver.records.bundle import Bundle
from gsenv.solver.records.model import Array
from gsenv.solver.records.options import OPTIONS_DTYPE

NOTHING = np.zeros(0, np.int64)


def shapes_bundle(dim: int, models: Array, parameters: Array, vertices: Array | None) -> Any:
    """``world.shapes``."""
    return Bundle("Shapes", dim, models=models, parameters=parameters, vertices=vertices)


def narrowphase_bundle(dim: int, fields: bool = False, convex: bool = False) -> Any:
    """``world.scratch.narrowphase``."""
    return Bundle("Narrowphase", dim, **dimension(dim).scratch.narrowphase_scratch(fields, convex))


def kernel_world(
    arrays: Any,
    gravity: Array,
    timestep: float,
    exclusions: Array = NOTHING,
    pairs: Array | int = 4096,
    found: Array | int = 256,
) -> Any:
    """One world's detection and continuous collision.

    Args:
        arrays: has ``bodies``, ``body_models``, ``body_parameters``, ``shape_models``, ``shape_parameters``,
            ``vertices`` (or None) and ``geometry``, which the kernels write.
        gravity: (dim,) m/s^2.
        timestep: s.
        exclusions: codes of encode_exclusion, sorted.
        pairs, found: these buffers, or new ones of so many entries.
    """
    dim = len(gravity)
    options = np.zeros((), OPTIONS_DTYPE)
    options["timestep"] = timestep
    world_parameters = np.zeros((), records.world_parameter_dtype(dim))
    world_parameters["gravity"] = gravity
    body_count = len(arrays.bodies)
    return Bundle(
        "World",
        dim,
        options=options,
        model=Bundle("Model", dim, bodies=arrays.body_models, exclusions=exclusions),
        parameters=Bundle("Parameters", dim, world=world_parameters, bodies=arrays.body_parameters),
        state=Bundle(
            "State",
            dim,
            bodies=arrays.bodies,
            contacts=np.zeros(0, records.contact_dtype(dim)),  # of the last step
            world=np.zeros((), records.world_state_dtype()),
        ),
        shapes=shapes_bundle(dim, arrays.shape_models, arrays.shape_parameters, arrays.vertices),
        scratch=Bundle(
            "Scratch",
            dim,
            geometry=arrays.geometry,
            broadphase=broadphase_scratch(len(arrays.shape_models), dim),
            pairs=np.zeros(pairs, scratch_dtypes.PAIR_DTYPE) if isinstance(pairs, int) else pairs,
            kept_boxes=None,
            found=np.zeros(found, records.contact_dtype(dim)) if isinstance(found, int) else found,
            narrowphase=narrowphase_bundle(dim),
            start_poses=np.zeros(body_count, scratch_dtypes.start_pose_dtype(dim)),
            substep_bodies=np.zeros(body_count, scratch_dtypes.substep_body_dtype(dim)),
        ),
    ).seal()
