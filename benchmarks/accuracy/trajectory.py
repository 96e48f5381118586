"""What a run yields: poses and velocities of all bodies at sampled times, whoever computed them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.records.model import BodyKind, Model

Array = NDArray[np.float64]

STATE = 6  # numbers of a body: x, y (m, centre of mass), angle (rad, unwrapped), vx, vy (m/s), w (rad/s)
STATE3 = 13  # in 3D: position (3), quaternion (4), velocity (3), angular velocity in the world (3)


def ball_joints(model: Model) -> NDArray[np.intp]:
    """Indices of a spatial model's ball joints."""
    from gsenv.solver.records.model import JointKind

    return np.flatnonzero(model.joints["kind"] == JointKind.BALL)


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
    def dim(self) -> int:
        return self.model.dim

    @property
    def position(self) -> Array:
        """(sample, body, dim) m."""
        return self.states[..., : self.dim]

    @property
    def height(self) -> Array:
        """(sample, body) m: y in 2D, z in 3D."""
        return self.states[..., self.dim - 1]

    @property
    def angle(self) -> Array:
        """(sample, body) rad; 2D only."""
        return self.states[..., 2]

    @property
    def rotation(self) -> Array:
        """(sample, body, 4) unit quaternion; 3D only."""
        return self.states[..., 3:7]

    @property
    def linear_velocity(self) -> Array:
        """(sample, body, dim) m/s."""
        return self.states[..., 3:5] if self.dim == 2 else self.states[..., 7:10]

    @property
    def angular_velocity(self) -> Array:
        """(sample, body) rad/s; (sample, body, 3) in 3D."""
        return self.states[..., 5] if self.dim == 2 else self.states[..., 10:13]

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
        """(dynamic body,) kg m^2; (dynamic body, 3) along the bodies' axes in 3D."""
        return self.model.nominal_bodies["inertia"][self.dynamic]
