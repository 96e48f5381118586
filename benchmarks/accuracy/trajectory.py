"""What a run yields: poses and velocities of all bodies at sampled times, whoever computed them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.model import BodyKind, Model

Array = NDArray[np.float64]

STATE = 6  # numbers of a body: x, y (m, centre of mass), angle (rad, unwrapped), vx, vy (m/s), w (rad/s)


@dataclass(frozen=True)
class Trajectory:
    """States of all bodies, static ones included, from time 0 on.

    Attributes:
        times: s, (sample,).
        states: (sample, body, STATE).
        model: masses and sizes; the same for all engines.
    """

    times: Array
    states: Array
    model: Model

    @property
    def position(self) -> Array:
        """(sample, body, 2) m."""
        return self.states[..., 0:2]

    @property
    def angle(self) -> Array:
        """(sample, body) rad."""
        return self.states[..., 2]

    @property
    def linear_velocity(self) -> Array:
        """(sample, body, 2) m/s."""
        return self.states[..., 3:5]

    @property
    def angular_velocity(self) -> Array:
        """(sample, body) rad/s."""
        return self.states[..., 5]

    @property
    def dynamic(self) -> NDArray[np.intp]:
        """Indices of the bodies that move."""
        return np.flatnonzero(self.model.bodies["kind"] == BodyKind.DYNAMIC)

    @property
    def mass(self) -> Array:
        """(dynamic body,) kg."""
        return self.model.nominal_bodies["mass"][self.dynamic]

    @property
    def inertia(self) -> Array:
        """(dynamic body,) kg m^2."""
        return self.model.nominal_bodies["inertia"][self.dynamic]
