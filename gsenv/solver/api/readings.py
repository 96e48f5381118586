"""Methods of World that read its state and what follows from it."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..dimension import Dimension
from ..readings.diagnostics import Contacts, Diagnostics, contacts_of, diagnose
from ..readings.overlaps import Overlaps
from ..readings.rays import RayCast, RayHits
from ..readings.sensors import read_sensors
from ..records.model import Array, Model
from ..records.state import State
from ..specification import check
from ..specification.check import ALL_BITS
from ..specification.handles import Reference, find
from . import threads
from .one_thread import OneThread
from .options import Options
from .parameters import Parameters, of_world
from .ranges import RangeWarnings
from .rays import checked_rays


class Readings:
    """Positions, velocities, joints, contacts, errors, sensors and rays; a base class of World, which sets these
    attributes."""

    model: Model
    parameters: Parameters
    state: State
    world_count: int
    threads: int
    _dimension: Dimension
    _options: Options
    _overlaps: Overlaps | None
    _ranges: RangeWarnings
    _use: OneThread

    @property
    @of_world
    def position(self) -> Array:
        """(world, body, dim) m, origins of the bodies' own frames; a copy, as are all readings."""
        bodies = self.state.bodies
        turned = self._dimension.joint_readings.rotated(bodies["rotation"], self.parameters.bodies["center"])
        return np.asarray(bodies["position"] - turned)

    @property
    @of_world
    def center_of_mass(self) -> Array:
        """(world, body, dim) m, centres of mass."""
        return self.state.bodies["position"].copy()

    @property
    @of_world
    def angle(self) -> Array:
        """(world, body) rad, not wrapped; in 2D."""
        if self.model.dim == 3:
            raise AttributeError("World: bodies in 3D have no angle; World.orientation has their quaternions.")
        return self.state.bodies["angle"].copy()

    @property
    @of_world
    def orientation(self) -> Array:
        """(world, body, 4) unit quaternions (w, x, y, z); in 3D."""
        if self.model.dim == 2:
            raise AttributeError("World: bodies in 2D have no orientation; World.angle has their angles.")
        return self.state.bodies["rotation"].copy()

    @property
    @of_world
    def linear_velocity(self) -> Array:
        """(world, body, dim) m/s, of the centres of mass."""
        return self.state.bodies["velocity"][..., : self.model.dim].copy()

    @property
    @of_world
    def angular_velocity(self) -> Array:
        """(world, body) rad/s; in 3D (world, body, 3), in the world's axes."""
        velocity = self.state.bodies["velocity"]
        return (velocity[..., 2] if self.model.dim == 2 else velocity[..., 3:]).copy()

    @property
    @of_world
    def asleep(self) -> Array:
        """(world, body) bool, whether each body sleeps."""
        return self.state.bodies["asleep"] != 0

    @property
    @of_world
    def time(self) -> Array:
        """(world,) s, number of steps since the last reset times the present timestep."""
        return self.state.worlds["step"] * self._options.timestep

    @property
    def lost(self) -> Array | None:
        """(world,) bool, worlds whose numbers overflowed, which rest until reset or restored; None where none did."""
        lost = self._ranges.lost
        return None if lost is None else lost.copy()

    @of_world
    def contacts(self, world: int = 0) -> Contacts:
        """Return the contacts of a world's last step; see Contacts."""
        index = check.worlds(check.whole(world, 0, "contacts: world"), self.world_count, "contacts: world")[0]
        return contacts_of(self.state, index)

    @of_world
    def diagnostics(self) -> Diagnostics:
        """Return errors, energies and counters of the last step; see Diagnostics."""
        if self._overlaps is None:
            self._overlaps = Overlaps(self.model, self.parameters, self.state)
        return diagnose(self.model, self.parameters, self.state, self._overlaps)

    @of_world
    def sensor(self, sensor: Reference) -> Array:
        """Return the reading (world, number) of a sensor; see Scene.add_sensor."""
        index = find(sensor, "sensor", self.model.sensor_names, "sensor")
        return self._read_sensors(index, index + 1)

    @of_world
    def sensors(self) -> Array:
        """Return the readings (world, number) of all sensors in columns, which Model.sensor_slices gives."""
        return self._read_sensors(0, len(self.model.sensors))

    def _read_sensors(self, first: int, last: int) -> Array:
        return read_sensors(self.model, self.parameters, self.state, self._options.timestep, first, last)

    @of_world
    def cast_rays(
        self,
        origin: Any,
        direction: Any,
        length: Any,
        *,
        worlds: Any = None,
        mask: int = ALL_BITS,
        exclude: Reference | None = None,
    ) -> RayHits:
        """Return the first hits of rays with the shapes at their present poses; see RayHits.

        Rays pass disabled and sensor shapes, and shapes that they only touch. A terrain or heightfield is hit
        only from its outside, but a start behind it by at most the extent (smallest half-width) of body
        ``exclude`` counts as inside it.

        Args:
            origin: m, (dim,), (ray, dim) or (chosen world, ray, dim).
            direction: likewise, of any length but 0.
            length: m, of the rays: one number, (ray,) or (chosen world, ray).
            worlds: None for all, an int, ints or a bool mask.
            mask: bits of the categories that rays can hit.
            exclude: a body that rays pass, such as the one that they start from.

        Raises:
            ValueError: arrays that do not fit or are not finite, a direction of 0, a length that is not positive,
                an unknown body.
        """
        chosen = check.worlds(worlds, self.world_count, "cast_rays: worlds")
        carrier = -1 if exclude is None else find(exclude, "body", self.model.body_names, "cast_rays: exclude")
        bits = check.bits(mask, "cast_rays: mask")
        rays = checked_rays(origin, direction, length, len(chosen), self.model.dim)
        made = RayCast(self.model, self.parameters, self.state, chosen, *rays)
        parts = threads.ranges(len(chosen), min(self.threads, max(len(chosen), 1)))
        if parts:
            threads.run([partial(made.cast, bits, carrier, first, last) for first, last in parts])
        return made.hits()

    @of_world
    def joint_coordinate(self, joint: Reference) -> Array:
        """Return the coordinate (world,): rad since the initial pose (revolute, hinge), m along the axis (prismatic,
        slider, wheel), m between the anchors (distance), or the error of a gear. Coordinates of a joint with several
        have names such as "hip/turn_x".

        Raises:
            ValueError: an unknown joint, or one without a coordinate.
        """
        j = find(joint, "joint", self.model.joint_names, "joint_coordinate")
        return np.asarray(self._dimension.joint_readings.coordinate(self.model, self.parameters, self.state, j))

    @of_world
    def joint_rate(self, joint: Reference) -> Array:
        """Return the rate of change of the coordinate (world,), rad/s or m/s."""
        j = find(joint, "joint", self.model.joint_names, "joint_rate")
        return np.asarray(self._dimension.joint_readings.rate(self.model, self.parameters, self.state, j))

    @of_world
    def joint_reaction(self, joint: Reference) -> Array:
        """Return (world, ndof) the mean force in N and torque in N m on body_b at its anchor in the last step,
        motors, springs and limits included; of a 3D joint with several coordinates with those of all."""
        j = find(joint, "joint", self.model.joint_names, "joint_reaction")
        reaction = self.state.joints["reaction"]
        whole = reaction[:, j] + reaction[:, self.model.parts_of(j)].sum(1)
        return np.asarray(whole / self._options.timestep)
