"""State, all that changes in a step; and Snapshot, a bit-exact copy of State and Parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .model import Array, Model, contact_dtype, world_state_dtype
from .parameters import ParameterArrays
from .plain import as_bytes, rows
from .sensors import ACCELERATION, CONTACT_FORCE, motion_dtype

STATE_ARRAYS = ("worlds", "bodies", "joints", "control")


class State:
    """The arrays of N worlds that change in a step: (world,) or (world, item).

    ``motions`` (world, body) of motion_dtype is None in a scene without sensors of accelerations and contact forces.
    """

    def __init__(self, model: Model, world_count: int, contact_capacity: int) -> None:
        n = world_count
        self.worlds = np.zeros(n, world_state_dtype())
        self.bodies = np.zeros((n, len(model.bodies)), model.start_bodies.dtype)
        self.joints = np.zeros((n, len(model.joints)), model.start_joints.dtype)
        self.contacts = np.zeros((n, contact_capacity), contact_dtype(model.dim))
        self.control = np.zeros((n, len(model.actuators)))
        has_motions = bool(np.isin(model.sensors["kind"], (ACCELERATION, CONTACT_FORCE)).any())
        self.motions = np.zeros((n, len(model.bodies)), motion_dtype(model.dim)) if has_motions else None
        self.reset(model, np.arange(n))

    def reset(self, model: Model, chosen: Array) -> None:
        """Set the chosen worlds to the initial state."""
        chosen = rows(chosen)
        as_bytes(self.worlds)[chosen] = 0
        as_bytes(self.bodies)[chosen] = as_bytes(model.start_bodies[None])
        as_bytes(self.joints)[chosen] = as_bytes(model.start_joints[None])
        as_bytes(self.contacts)[chosen] = 0
        self.control[chosen] = 0.0
        self.forget_motion(chosen)

    def keep_motion(self, start: Array) -> None:
        """Keep the motion of all bodies over the step that has just ended; ``start``: ``bodies`` before it."""
        if self.motions is not None:
            for name in ("position", "rotation", "velocity"):
                self.motions[name] = start[name]
            for name in ("rotation", "velocity"):
                self.motions[f"end_{name}"] = self.bodies[name]

    def forget_motion(self, chosen: Array) -> None:
        """Set the last step's motion of the chosen worlds to a uniform one, without acceleration."""
        if self.motions is not None:
            for name in ("position", "rotation", "velocity", "end_rotation", "end_velocity"):
                self.motions[name][chosen] = self.bodies[name.removeprefix("end_")][chosen]

    def grow_contacts(self, capacity: int) -> None:
        """Make room for ``capacity`` contacts in each world."""
        grown = np.zeros((len(self.worlds), capacity), self.contacts.dtype)
        grown[:, : self.contacts.shape[1]] = self.contacts
        self.contacts = grown

    def forget_impulses(self, chosen: Array, body: int) -> None:
        """Set the impulses of a body's contacts to 0 after its pose was set: they are no valid warm start."""
        contacts = self.contacts[chosen]
        touched = (contacts["body_a"] == body) | (contacts["body_b"] == body)
        contacts["impulse"][touched] = 0.0
        self.contacts[chosen] = contacts


@dataclass(frozen=True)
class Snapshot:
    """Saved worlds; a restored world continues bit for bit, also in another process."""

    scene: str  # digest of its model
    state: dict[str, Array]
    contacts: Array
    parameters: dict[str, Array]
    motions: Array | None = None  # of a scene with sensors of accelerations or contact forces

    @property
    def world_count(self) -> int:
        return len(self.state["worlds"])

    @property
    def contact_capacity(self) -> int:
        return int(self.contacts.shape[1])

    def check(self, model: Model, chosen: int) -> None:
        """Raise ValueError unless the snapshot fits the model and the number of chosen worlds."""
        if self.scene != model.digest:
            raise ValueError("restore: the snapshot belongs to another scene.")
        if self.world_count not in (1, chosen):
            raise ValueError(f"restore: {self.world_count} saved worlds do not fit into {chosen} chosen ones.")

    def write(self, parameters: ParameterArrays, state: State, chosen: Array) -> None:
        """Copy the saved worlds, or one to all, into the chosen worlds."""
        chosen = rows(chosen)
        for name, array in self.state.items():
            getattr(state, name)[chosen] = array
        for name, array in self.parameters.items():
            getattr(parameters, name)[chosen] = array
        as_bytes(state.contacts)[chosen] = 0
        state.contacts[chosen, : self.contact_capacity] = self.contacts
        state.forget_motion(chosen)
        if state.motions is not None and self.motions is not None:
            state.motions[chosen] = self.motions


def take_snapshot(model: Model, parameters: ParameterArrays, state: State, chosen: Array) -> Snapshot:
    """Return a copy of the chosen worlds, without unused entries of contacts."""
    used = int(state.worlds["contact_count"][chosen].max(initial=0))
    return Snapshot(
        model.digest,
        {name: getattr(state, name)[chosen].copy() for name in STATE_ARRAYS},
        state.contacts[chosen, :used].copy(),
        {name: array[chosen].copy() for name, array in parameters.arrays().items()},
        None if state.motions is None else state.motions[chosen].copy(),
    )
