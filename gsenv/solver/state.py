"""State (all that a bit-exact restore needs, with Parameters), Workspace (scratch), Snapshot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .broadphase import broadphase_scratch
from .dimension import dimension
from .features import Features
from .model import (
    CONTACT_ROWS,
    ISLAND_DTYPE,
    PAIR_DTYPE,
    ROWS_PER_JOINT,
    Array,
    Model,
    contact_dtype,
    motion_dtype,
    shape_geometry_dtype,
    world_state_dtype,
)
from .parameters import Parameters
from .rows import mover_dtype, row_dtype
from .solvers.cholesky import BLOCKS_PER_BODY, block_dtype, factor_dtype

STATE_ARRAYS = ("worlds", "bodies", "joints", "control")


def first_contact_capacity(model: Model) -> int:
    """A guess; a step that needs more grows the buffers."""
    return 16 + 4 * len(model.shapes)


class State:
    """Everything of N worlds that changes: (world,) or (world, item) arrays."""

    def __init__(self, model: Model, world_count: int, contact_capacity: int) -> None:
        n = world_count
        self.worlds = np.zeros(n, world_state_dtype())
        self.bodies = np.zeros((n, len(model.bodies)), model.start_bodies.dtype)
        self.joints = np.zeros((n, len(model.joints)), model.start_joints.dtype)
        self.contacts = np.zeros((n, contact_capacity), contact_dtype(model.dim))
        self.control = np.zeros((n, len(model.actuators)))
        self.reset(model, np.arange(n))

    def reset(self, model: Model, chosen: Array) -> None:
        self.worlds[chosen] = np.zeros((), self.worlds.dtype)
        self.bodies[chosen] = model.start_bodies
        self.joints[chosen] = model.start_joints
        self.contacts[chosen] = np.zeros((), self.contacts.dtype)
        self.control[chosen] = 0.0

    def grow_contacts(self, capacity: int) -> None:
        grown = np.zeros((len(self.worlds), capacity), self.contacts.dtype)
        grown[:, : self.contacts.shape[1]] = self.contacts
        self.contacts = grown

    def forget_impulses(self, chosen: Array, body: int) -> None:
        """No warm start for the contacts of a body that was put elsewhere."""
        contacts = self.contacts[chosen]
        touched = (contacts["body_a"] == body) | (contacts["body_b"] == body)
        contacts["impulse"][touched] = 0.0
        self.contacts[chosen] = contacts


def _factor_scratch(model: Model) -> tuple[Array, Array]:
    bodies = len(model.bodies)
    factor = np.zeros(bodies, factor_dtype(model.dim))
    factor["place"] = -1
    return factor, np.zeros(BLOCKS_PER_BODY * bodies, block_dtype(model.dim))


def narrow_scratch(features: Features) -> tuple[Array | None, ...]:
    """A manifold, what it is made with, what heightfields need, and whether there are curved or many-faced shapes."""
    from .spatial.narrowphase.manifold import manifold_dtype
    from .spatial.narrowphase.scratch import scratch_dtype
    from .spatial.narrowphase.spread import SCRATCH_SIZE, field_scratch_dtype

    field = np.zeros(SCRATCH_SIZE, field_scratch_dtype()) if features.fields else None
    convex = np.ones(1) if features.convex else None  # what GJK and EPA are for
    return np.zeros(1, manifold_dtype()), np.zeros(1, scratch_dtype()), field, convex


class Workspace:
    """Scratch for stepping one world at a time; one for each thread, never saved."""

    def __init__(self, model: Model, features: Features, contact_capacity: int) -> None:
        self._model = model
        bodies = len(model.bodies)
        self.geometry = np.zeros(len(model.shapes), shape_geometry_dtype(model.dim))
        self.motions = np.zeros(bodies, motion_dtype(model.dim))
        self.movers = np.zeros(bodies, mover_dtype(model.dim))
        self.islands = np.zeros(bodies, ISLAND_DTYPE)
        self.island_bodies = np.zeros(bodies, np.int32)
        self.island_joints = np.zeros(len(model.joints), np.int32)
        self.broadphase = broadphase_scratch(len(model.shapes), model.dim)
        start = dimension(model.dim).sweep_fast.sweep_start_dtype() if features.fast else None
        self.fast_start = np.zeros(bodies, start) if features.fast else None
        self.narrow = narrow_scratch(features) if model.dim == 3 else ()
        self.factor, self.blocks = _factor_scratch(model)
        self.tree: Array | None = None
        self.tree_blocks: Array | None = None
        if features.linked:
            self.tree, self.tree_blocks = _factor_scratch(model)
        self.pairs = np.zeros(16 + 4 * len(model.shapes), PAIR_DTYPE)
        self.grow_contacts(contact_capacity)

    def grow_pairs(self, capacity: int) -> None:
        self.pairs = np.zeros(capacity, PAIR_DTYPE)

    def grow_contacts(self, capacity: int) -> None:
        dim = self._model.dim
        self.found = np.zeros(capacity, contact_dtype(dim))
        self.displaced = np.zeros(capacity, contact_dtype(dim))
        self.island_contacts = np.zeros(2 * capacity, np.int32)  # second half: places of found ones
        joint_rows = ROWS_PER_JOINT[dim] * len(self._model.joints)
        self.rows = np.zeros(CONTACT_ROWS[dim] * capacity + joint_rows, row_dtype(dim))
        self.edges = np.zeros(4 * len(self.rows), np.int32)

    def arrays(self) -> tuple[Array | None, ...]:
        """In the order of the step kernel's arguments."""
        return (
            self.geometry, self.pairs, self.found, self.displaced, self.motions, self.movers,
            self.islands, self.island_bodies, self.island_contacts, self.island_joints, self.rows,
            self.broadphase, self.fast_start, self.factor, self.edges, self.blocks, self.tree, self.tree_blocks,
            *self.narrow,
        )  # fmt: skip


@dataclass(frozen=True)
class Snapshot:
    """Saved worlds. Restoring continues bit for bit, also in another process."""

    scene: str  # digest of the model it belongs to
    state: dict[str, Array]
    contacts: Array
    parameters: dict[str, Array]

    @property
    def world_count(self) -> int:
        return len(self.state["worlds"])

    @property
    def contact_capacity(self) -> int:
        return int(self.contacts.shape[1])

    def check(self, model: Model, chosen: int) -> None:
        if self.scene != model.digest:
            raise ValueError("restore: the snapshot belongs to another scene.")
        if self.world_count not in (1, chosen):
            raise ValueError(f"restore: {self.world_count} saved worlds do not fit into {chosen} chosen ones.")

    def write(self, parameters: Parameters, state: State, chosen: Array) -> None:
        for name, array in self.state.items():
            getattr(state, name)[chosen] = array
        for name, array in self.parameters.items():
            getattr(parameters, name)[chosen] = array
        state.contacts[chosen] = np.zeros((), state.contacts.dtype)
        state.contacts[chosen, : self.contact_capacity] = self.contacts


def take_snapshot(model: Model, parameters: Parameters, state: State, chosen: Array) -> Snapshot:
    used = int(state.worlds["contact_count"][chosen].max(initial=0))
    return Snapshot(
        model.digest,
        {name: getattr(state, name)[chosen].copy() for name in STATE_ARRAYS},
        state.contacts[chosen, :used].copy(),
        {name: array[chosen].copy() for name, array in parameters.arrays().items()},
    )
