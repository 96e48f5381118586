"""Diagnostics of a step: contacts, counters, residuals, penetration, joint error, energies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..dimension import dimension
from ..records.model import Array, Model
from ..records.parameters import ParameterArrays
from ..records.state import State
from .joint_errors import read_joints
from .overlaps import Overlaps

TORN = 0.01  # of its length: a joint that is off by more counts as unconverged


@dataclass(frozen=True)
class Contacts:
    """Contact points of one world's last step; arrays with one entry for each contact.

    Attributes:
        body_a, body_b, shape_a, shape_b: indices; the normal points from a to b.
        point: m, (contact, dim), midway between the surfaces where the contact was found, at the
            start of the step or, for a fast approach, where it was predicted. Between bodies at rest it may have been
            found earlier, at most 1e-4 of their extent from here.
        normal: unit, (contact, dim), at the same time as ``point``.
        separation: m, at the end of the step; negative for an overlap, positive for a gap.
        impulse: N s, (contact, 2), normal and tangent, summed over the step; in 3D (contact, 6): normal, two
            tangents, torque about the normal (N m s), two of rolling.
        sensor: bool, whether one of the shapes is a sensor, which causes no forces.
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
        """Whether each contact had an impulse in the step or overlaps, (contact,) bool."""
        return (self.impulse[:, 0] > 0.0) | (self.separation <= 0.0)

    def force_vector(self, timestep: float) -> Array:
        """Return the mean force on body b over the step, (contact, dim) N; ``timestep`` in s."""
        force: Array = dimension(self.normal.shape[1]).sensor_readings.contact_force(self.normal, self.impulse)
        return force / timestep


def contacts_of(state: State, world: int) -> Contacts:
    """Return a copy of the contacts of one world."""
    c = state.contacts[world, : state.worlds["contact_count"][world]].copy()
    return Contacts(
        c["body_a"], c["body_b"], c["shape_a"], c["shape_b"], c["point"], c["normal"],
        c["separation"], c["total_impulse"], c["sensor"] != 0,
    )  # fmt: skip


@dataclass(frozen=True)
class Diagnostics:
    """Errors, energies and counters of the last step; (world,) arrays.

    Attributes:
        residual: natural-map residual of the last substep's solve, dimensionless.
        penetration: m, deepest overlap of two shapes that may touch, measured from the present poses.
        joint_error: m, largest error of a rigid joint: distance of the anchors from each other or from the axis, or
            difference of a rod or rope from its length, or by how much a slide is beyond a rigid limit; from the
            present poses. Also the error of a gear whose first coordinate is a length.
        angular_joint_error: rad, largest angle by which a rotation is off that a joint locks, or beyond a rigid limit,
            or error of a gear whose first coordinate is an angle; from the present poses.
        relative_joint_error: the largest error over the length of its joint, which is that of a rod or rope, and of
            other joints the diameter of the smaller body; or half the largest angular error.
        kinetic_energy, potential_energy, spring_energy: J; energy is their sum. Targets count as motors.
        momentum: kg m/s, (world, dim).
        angular_momentum: kg m^2/s about the origin, (world,), in 3D (world, 3).
        sweeps: of all islands and substeps.
        unconverged: island substeps that reached the largest number of sweeps; plus, whatever the cause, joints that
            are off by more than 1 % of their length and pairs of shapes that overlap by more than a tenth of the
            smaller extent.
        contacts, pairs, rows, islands, awake, impacts: counts of the last step.
        finite: bool, whether all poses and velocities are. Forces, speeds, masses or sizes of extreme magnitude can
            make a NaN or an infinity of them. The bodies of such a world stay as they are until it is reset or
            restored, while its time goes on; its residual and errors are NaN, and it counts as unconverged. From
            the step after that in which it was lost, it has no contacts; rays pass its bodies.
    """

    residual: Array
    penetration: Array
    joint_error: Array
    angular_joint_error: Array
    relative_joint_error: Array
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
    finite: Array

    @property
    def energy(self) -> Array:
        """Sum of kinetic, potential and spring energy, J."""
        return self.kinetic_energy + self.potential_energy + self.spring_energy


@np.errstate(invalid="ignore", over="ignore")  # of worlds that are not finite
def diagnose(model: Model, parameters: ParameterArrays, state: State, overlaps: Overlaps) -> Diagnostics:
    """Return the diagnostics of a World; ``overlaps`` measures its shapes."""
    worlds = state.worlds
    p = parameters.bodies
    dynamic = (model.bodies["kind"] == 2) & (p["enabled"] != 0)
    mass = np.where(dynamic, p["mass"], 0.0)
    v = state.bodies["velocity"]
    readings = dimension(model.dim).sensor_readings
    turning, spin = readings.turning(p, state.bodies, dynamic)
    kinetic = 0.5 * (mass * (v[..., : model.dim] ** 2).sum(-1) + turning).sum(-1)
    linear = mass[..., None] * v[..., : model.dim]
    weight = (mass * p["gravity_scale"])[..., None] * parameters.worlds["gravity"][:, None]
    potential = -(weight * state.bodies["position"]).sum((-1, -2))
    penetration, sunk = overlaps.measure()
    joints = read_joints(model, parameters, state, TORN)
    finite: Array = np.all(finite_bodies(state.bodies), axis=1)
    return Diagnostics(
        residual=np.where(finite, worlds["natural_residual"], np.nan),
        penetration=np.where(finite, penetration, np.nan),
        joint_error=np.where(finite, joints.error, np.nan),
        angular_joint_error=np.where(finite, joints.angular_error, np.nan),
        relative_joint_error=np.where(finite, joints.relative_error, np.nan),
        kinetic_energy=kinetic,
        potential_energy=potential,
        spring_energy=joints.spring_energy,
        momentum=linear.sum(1),
        angular_momentum=(readings.orbital(state.bodies["position"], linear) + spin).sum(1),
        sweeps=worlds["sweeps"].copy(),
        unconverged=worlds["unconverged"] + joints.torn + sunk + ~finite,
        contacts=worlds["contact_count"].copy(),
        pairs=worlds["pair_count"].copy(),
        rows=worlds["row_count"].copy(),
        islands=worlds["island_count"].copy(),
        awake=worlds["awake_count"].copy(),
        impacts=worlds["impacts"].copy(),
        finite=finite,
    )


def finite_bodies(bodies: Array) -> Array:
    """Return bool of the shape of ``bodies``, such as (world, body): whether pose and velocity of each are finite."""
    turn = np.square(bodies["rotation"]).sum(-1)  # 1; an angle that overflows gives NaN or 0
    finite: Array = (turn > 0.5) & (turn < 2.0)
    for name in ("position", "velocity"):
        finite &= np.isfinite(bodies[name]).all(-1)
    return finite
