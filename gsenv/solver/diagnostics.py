"""What a step says of itself: contacts, counters, residuals, penetration, joint error, energies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .dimension import dimension
from .model import Array, Model

if TYPE_CHECKING:
    from .parameters import Parameters
    from .state import State


@dataclass(frozen=True)
class Contacts:
    """Contact points of one world's last step; arrays with one entry a contact.

    Attributes:
        body_a, body_b, shape_a, shape_b: indices; the normal points from a to b.
        point: m, (contact, dim), midway between the surfaces where the contact was found, at the
            start of the step or, for a fast approach, where it was predicted.
        normal: unit, (contact, dim), of that moment as well.
        separation: m, at the end of the step; negative is overlap, positive a contact to come.
        impulse: N s, (contact, 2), normal and tangent, summed over the step; in 3D (contact, 6): normal, two
            tangents, torque about the normal (N m s), two of rolling.
        sensor: bool, reports only.
    """

    body_a: Array
    body_b: Array
    shape_a: Array
    shape_b: Array
    point: Array
    normal: Array
    separation: Array
    impulse: Array
    sensor: Array

    def __len__(self) -> int:
        return len(self.body_a)

    @property
    def touching(self) -> Array:
        """(contact,) bool: pushed in the step, or overlapping."""
        return (self.impulse[:, 0] > 0.0) | (self.separation <= 0.0)

    def force_vector(self, timestep: float) -> Array:
        """(contact, dim) N, mean force on body b over the step."""
        n = self.normal
        if n.shape[1] == 3:
            from .spatial.sensors import tangents_of

            t, s = tangents_of(n)
            p = self.impulse
            return np.asarray((n * p[:, :1] + t * p[:, 1:2] + s * p[:, 2:3]) / timestep)
        t = np.stack([-n[:, 1], n[:, 0]], -1)
        return (n * self.impulse[:, :1] + t * self.impulse[:, 1:2]) / timestep


def contacts_of(state: State, world: int) -> Contacts:
    """A copy of the contacts of one world."""
    c = state.contacts[world, : state.worlds["contact_count"][world]].copy()
    return Contacts(
        c["body_a"], c["body_b"], c["shape_a"], c["shape_b"], c["point"], c["normal"],
        c["separation"], c["total_impulse"], c["sensor"] != 0,
    )  # fmt: skip


@dataclass(frozen=True)
class Diagnostics:
    """How wrong the last step was, and what it did; (world,) arrays.

    Attributes:
        residual: nm, the natural-map residual of the last substep's solve, free of units.
        penetration: m, deepest overlap at the end of the step.
        joint_error: m, largest error of a rigid joint: anchors apart, off the axis, a rod or rope too long.
        kinetic_energy, potential_energy, spring_energy: J; energy is their sum. Targets count as motors.
        momentum: kg m/s, (world, dim).
        angular_momentum: kg m^2/s about the origin, (world,), in 3D (world, 3).
        sweeps: of all islands and substeps; unconverged: island substeps that ran out of them.
        contacts, pairs, rows, islands, awake, impacts: counts of the last step.
    """

    residual: Array
    penetration: Array
    joint_error: Array
    kinetic_energy: Array
    potential_energy: Array
    spring_energy: Array
    momentum: Array
    angular_momentum: Array
    sweeps: Array
    unconverged: Array
    contacts: Array
    pairs: Array
    rows: Array
    islands: Array
    awake: Array
    impacts: Array

    @property
    def energy(self) -> Array:
        """J, of motion, height and springs."""
        return self.kinetic_energy + self.potential_energy + self.spring_energy


def _turning(model: Model, p: Array, bodies: Array, dynamic: Array) -> tuple[Array, Array]:
    """(world, body) twice the energy of turning, and the angular momentum about the centre of mass."""
    if model.dim == 2:
        spin = np.where(dynamic, p["inertia"], 0.0) * bodies["velocity"][..., 2]
        return spin * bodies["velocity"][..., 2], spin
    from .spatial.authored import multiplied, turned_by

    axes = multiplied(bodies["rotation"], p["axes"])
    own = turned_by(axes * np.array([1.0, -1.0, -1.0, -1.0]), bodies["velocity"][..., 3:])
    spin = np.where(dynamic[..., None], p["inertia"], 0.0) * own
    return (spin * own).sum(-1), turned_by(axes, spin)


def _about_origin(position: Array, linear: Array, spin: Array) -> Array:
    if position.shape[-1] == 2:
        orbit = position[..., 0] * linear[..., 1] - position[..., 1] * linear[..., 0]
    else:
        orbit = np.cross(position, linear)
    return np.asarray((orbit + spin).sum(1))


def diagnose(model: Model, parameters: Parameters, state: State) -> Diagnostics:
    worlds = state.worlds
    counts = worlds["contact_count"]
    used = np.arange(state.contacts.shape[1]) < counts[:, None]
    contacts = state.contacts
    deep = np.where(used & (contacts["sensor"] == 0), -contacts["separation"], 0.0)
    p = parameters.bodies
    dynamic = (model.bodies["kind"] == 2) & (p["enabled"] != 0)
    mass = np.where(dynamic, p["mass"], 0.0)
    v = state.bodies["velocity"]
    turning, spin = _turning(model, p, state.bodies, dynamic)
    kinetic = 0.5 * (mass * (v[..., : model.dim] ** 2).sum(-1) + turning).sum(-1)
    linear = mass[..., None] * v[..., : model.dim]
    weight = (mass * p["gravity_scale"])[..., None] * parameters.worlds["gravity"][:, None]
    potential = -(weight * state.bodies["position"]).sum((-1, -2))
    joint_error, spring_energy = dimension(model.dim).readings.joint_errors_and_energies(model, parameters, state)
    return Diagnostics(
        residual=worlds["natural_residual"].copy(),
        penetration=np.maximum(deep.max(-1, initial=0.0), 0.0),
        joint_error=joint_error,
        kinetic_energy=kinetic,
        potential_energy=potential,
        spring_energy=spring_energy,
        momentum=linear.sum(1),
        angular_momentum=_about_origin(state.bodies["position"], linear, spin),
        sweeps=worlds["sweeps"].copy(),
        unconverged=worlds["unconverged"].copy(),
        contacts=counts.copy(),
        pairs=worlds["pair_count"].copy(),
        rows=worlds["row_count"].copy(),
        islands=worlds["island_count"].copy(),
        awake=worlds["awake_count"].copy(),
        impacts=worlds["impacts"].copy(),
    )
