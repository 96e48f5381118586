"""Scratch: the temporary arrays of a step. Never saved; one set for each thread, which steps one world at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.broadphase import BRUTE_FORCE_COUNT, broadphase_scratch
from ..core.kept_pairs import LEAST_SHAPES
from ..core.rows import row_dtype, solver_body_dtype
from ..dimension import dimension
from ..methods.cholesky import BLOCKS_PER_BODY, PLAN_DTYPE, block_dtype, factor_dtype, graph_size
from .articulation import articulation_scratch, other_joints, others_scratch
from .bundle import Bundle
from .kernel_variants import KernelVariant
from .model import CONTACT_ROWS, ROWS_PER_JOINT, Array, Model, contact_dtype, world_state_dtype
from .scratch_dtypes import (
    ISLAND_DTYPE,
    ISLAND_STEP_DTYPE,
    KEPT_PAIR_DTYPE,
    PAIR_DTYPE,
    closing_pose_dtype,
    kept_box_dtype,
    shape_geometry_dtype,
    start_pose_dtype,
    substep_body_dtype,
)


def first_contact_capacity(model: Model) -> int:
    """Return an estimate of the number of contacts; a step that needs more makes the buffers grow."""
    return 16 + 4 * len(model.shapes)


def broadphase_of(model: Model, variant: KernelVariant) -> Array | None:
    """Return the scratch of ``find_pairs``; one kernel for all scenes always has the tree."""
    shapes = max(len(model.shapes), BRUTE_FORCE_COUNT + 1) if variant.all else len(model.shapes)
    return broadphase_scratch(shapes, model.dim)


class Scratch:
    """The arrays of one thread; ``bundle`` makes them the argument of kernels."""

    def __init__(self, model: Model, variant: KernelVariant, contact_capacity: int) -> None:
        self._model = model
        self._variant = variant
        bodies, dim = len(model.bodies), model.dim
        self.geometry = np.zeros(len(model.shapes), shape_geometry_dtype(dim))
        self.substep_bodies = np.zeros(bodies, substep_body_dtype(dim))
        self.solver_bodies = np.zeros(bodies, solver_body_dtype(dim))
        self.islands = np.zeros(bodies, ISLAND_DTYPE)
        self.island = np.zeros((), ISLAND_STEP_DTYPE)
        self.island_bodies = np.zeros(bodies, np.int32)
        self.island_joints = np.zeros(len(model.joints), np.int32)
        self.broadphase = broadphase_of(model, variant)
        keeps = self.broadphase is not None or len(model.shapes) >= LEAST_SHAPES
        entries = max(len(model.shapes), 1)  # the first one has the number of kept pairs
        self.kept_boxes = np.zeros(entries, kept_box_dtype(dim)) if keeps else None
        self.start_poses = np.zeros(bodies, start_pose_dtype(dim)) if variant.continuous else None
        self.closing_poses = np.zeros(bodies, closing_pose_dtype(dim)) if variant.linked else None
        self._narrowphase = dimension(dim).scratch.narrowphase_scratch(variant.fields, variant.convex)
        self._factor, self._joint_factor = (_factor_arrays(model) for _ in range(2))
        self.grow_pairs(16 + 4 * len(model.shapes))
        self.grow_contacts(contact_capacity)

    def grow_pairs(self, capacity: int) -> None:
        """Make room for ``capacity`` pairs of shapes; earlier bundles are invalid afterwards."""
        self.pairs = np.zeros(capacity, PAIR_DTYPE)
        self.kept_pairs = None
        if self.kept_boxes is not None:
            self.kept_pairs = np.zeros(capacity, KEPT_PAIR_DTYPE)
            self.kept_boxes["pairs"] = 0

    def grow_contacts(self, capacity: int) -> None:
        """Make room for ``capacity`` contacts and their rows; earlier bundles are invalid afterwards."""
        dim = self._model.dim
        self.found = np.zeros(capacity, contact_dtype(dim))
        self.displaced = np.zeros(capacity, contact_dtype(dim))
        self.island_contacts = np.zeros(capacity, np.int32)
        self.found_places = np.zeros(capacity, np.int32)
        joint_rows = ROWS_PER_JOINT[dim] * len(self._model.joints)
        self.rows = np.zeros(CONTACT_ROWS[dim] * capacity + joint_rows, row_dtype(dim))
        bodies = len(self._model.bodies)
        self.graph = np.zeros(graph_size(len(self.rows), bodies, BLOCKS_PER_BODY * bodies), np.int32)
        self._articulation: dict[str, Any] | None = None
        self._division = self._division_arrays(capacity)

    def _division_arrays(self, capacity: int) -> dict[str, Any]:
        """Return room for two copies of what a step changes; see core/division.py."""
        model = self._model
        return {
            "bodies": np.zeros((2, len(model.bodies)), model.start_bodies.dtype),
            "joints": np.zeros((2, len(model.joints)), model.start_joints.dtype),
            "joint_sums": np.zeros(len(model.joints), model.start_joints.dtype),
            "contacts": np.zeros((2, capacity), contact_dtype(model.dim)),
            "overlaps": np.zeros(capacity, contact_dtype(model.dim)),
            "overlap_count": np.zeros(1, np.int64),
            "worlds": np.zeros(2, world_state_dtype()),
            "timesteps": np.zeros(2),
            "substeps": np.ones(2, np.int64),
            "many": np.zeros(1, np.bool_),  # whether many bodies are awake
            "finest": np.zeros(1, np.int64),  # substeps of the whole step; 0 in a step that is not divided
            "share": np.ones(1),  # length of a substep of the present part over that of one of the whole step
        }

    def bundle(self, articulated: bool = False) -> Bundle:
        """Return all arrays as a bundle for kernels; parts that the scene does not need are None.

        The kernel of all scenes has each part, with no links where the scene has no trees.
        """
        dim = self._model.dim
        if articulated and self._articulation is None:
            joints, trees = self._model.joints, self._model.trees
            if not self._model.has_trees:
                joints, trees = joints[:0], trees[:0]
            self._articulation = articulation_scratch(dim, trees, len(joints), len(self.rows))
            if self._variant.all or other_joints(joints, trees) > 0:
                others = others_scratch(dim, joints, trees)
                self._articulation["others"] = Bundle("Others", dim, **others)
        narrowphase = Bundle("Narrowphase", dim, **self._narrowphase) if self._narrowphase else None
        return Bundle(
            "Scratch",
            dim,
            geometry=self.geometry,
            broadphase=self.broadphase,
            kept_boxes=self.kept_boxes,
            kept_pairs=self.kept_pairs,
            pairs=self.pairs,
            narrowphase=narrowphase,
            found=self.found,
            displaced=self.displaced,
            found_places=self.found_places,
            start_poses=self.start_poses,
            closing_poses=self.closing_poses,
            islands=self.islands,
            island=self.island,
            island_bodies=self.island_bodies,
            island_contacts=self.island_contacts,
            island_joints=self.island_joints,
            substep_bodies=self.substep_bodies,
            solver_bodies=self.solver_bodies,
            rows=self.rows,
            division=Bundle("Division", dim, **self._division),
            articulation=Bundle("Articulation", dim, **(self._articulation or {})) if articulated else None,
            factor=Bundle("Factor", dim, graph=self.graph, **self._factor),
            joint_factor=Bundle("Factor", dim, graph=self.graph, **self._joint_factor)
            if self._variant.linked
            else None,
        )


def _factor_arrays(model: Model) -> dict[str, Array]:
    bodies = len(model.bodies)
    entries = np.zeros(bodies, factor_dtype(model.dim))
    entries["place"] = -1
    blocks = np.zeros(BLOCKS_PER_BODY * bodies, block_dtype(model.dim))
    plan = np.zeros((), PLAN_DTYPE)
    plan["used"] = model.is_linked
    return {"plan": plan, "entries": entries, "blocks": blocks}
