"""Poses: positions and the notations of rotations, composed down the tree of bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..solver.records.model import Array
from ..solver.spatial.shapes import rotation_matrix
from .attributes import Attributes

TINY = 1e-15  # of MuJoCo: a vector this short has no direction


@dataclass(frozen=True, eq=False)
class Pose:
    """Position and orientation in a frame.

    Attributes:
        position: (3,) m.
        orientation: (4,) unit quaternion (w, x, y, z).
    """

    position: Array
    orientation: Array

    @property
    def axes(self) -> Array:
        """The rotation matrix (3, 3), its columns the axes."""
        w, x, y, z = self.orientation.tolist()
        return rotation_matrix((w, x, y, z))

    def then(self, inner: Pose) -> Pose:
        """Return the pose, in the outer frame, of what is at ``inner`` in this one."""
        return Pose(self.point(inner.position), product(self.orientation, inner.orientation))

    def point(self, local: Array) -> Array:
        """Return a point of this frame, or many (..., 3), in the outer frame."""
        return self.position + local @ self.axes.T

    def inverse(self) -> Pose:
        """Return the pose of the outer frame in this one."""
        turn = conjugate(self.orientation)
        return Pose(-(self.axes.T @ self.position), turn)


def identity() -> Pose:
    """Return the pose of a frame in itself."""
    return Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))


def product(p: Array, q: Array) -> Array:
    """Return the quaternion of rotation ``q`` followed by ``p``."""
    a, b, c, d = p.tolist()
    e, f, g, h = q.tolist()
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def conjugate(q: Array) -> Array:
    """Return the quaternion of the opposite rotation."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def about(axis: Array, angle: float) -> Array:
    """Return the quaternion of a rotation by ``angle`` in rad about a unit axis."""
    return np.concatenate([[math.cos(0.5 * angle)], math.sin(0.5 * angle) * axis])


def from_z(direction: Array) -> Array:
    """Return the quaternion of the shortest rotation of z to a direction; z to -z is half a turn about x."""
    unit = direction / np.linalg.norm(direction)
    axis = np.array([-unit[1], unit[0], 0.0])
    length = float(np.linalg.norm(axis))
    if length < TINY:
        return about(np.array([1.0, 0.0, 0.0]), 0.0 if unit[2] > 0.0 else math.pi)
    return about(axis / length, math.atan2(length, float(unit[2])))


@dataclass(frozen=True)
class Angles:
    """How a file writes angles: their unit and the order of Euler rotations."""

    unit: float  # rad
    euler_order: str  # lower case: axes that rotate along, upper case: fixed axes

    def pose(self, attributes: Attributes) -> Pose:
        """Return ``pos`` and the rotation of an element.

        Raises:
            MjcfError: two notations of the rotation, or one without a direction.
        """
        return Pose(attributes.array("pos", (0.0, 0.0, 0.0)), self.orientation(attributes))

    def orientation(self, attributes: Attributes) -> Array:
        """Return the unit quaternion of quat, axisangle, euler, xyaxes or zaxis."""
        given = [name for name in ("quat", "axisangle", "euler", "xyaxes", "zaxis") if name in attributes]
        if len(given) > 1:
            raise attributes.error(f"the rotation is given twice, by {' and '.join(given)}")
        if not given:
            return np.array([1.0, 0.0, 0.0, 0.0])
        return {
            "quat": self._quaternion,
            "axisangle": self._axis_angle,
            "euler": self._euler,
            "xyaxes": self._two_axes,
            "zaxis": self._z_axis,
        }[given[0]](attributes)

    def _quaternion(self, attributes: Attributes) -> Array:
        return _unit(attributes, attributes.array("quat", (1.0, 0.0, 0.0, 0.0)), "quat")

    def _axis_angle(self, attributes: Attributes) -> Array:
        x, y, z, angle = attributes.vector("axisangle", (0.0, 0.0, 1.0, 0.0))
        return about(_unit(attributes, np.array([x, y, z]), "axisangle"), angle * self.unit)

    def _euler(self, attributes: Attributes) -> Array:
        turn = np.array([1.0, 0.0, 0.0, 0.0])
        for letter, angle in zip(self.euler_order, attributes.vector("euler", (0.0, 0.0, 0.0)), strict=True):
            single = about(np.eye(3)["xyz".index(letter.lower())], angle * self.unit)
            turn = product(turn, single) if letter.islower() else product(single, turn)
        return turn

    def _two_axes(self, attributes: Attributes) -> Array:
        numbers = attributes.array("xyaxes", (1.0, 0.0, 0.0, 0.0, 1.0, 0.0))
        x = _unit(attributes, numbers[:3], "xyaxes")
        y = _unit(attributes, numbers[3:] - (x @ numbers[3:]) * x, "xyaxes")
        upright = from_z(np.cross(x, y))
        seen = Pose(np.zeros(3), upright).axes.T @ x
        return product(upright, about(np.array([0.0, 0.0, 1.0]), math.atan2(seen[1], seen[0])))

    def _z_axis(self, attributes: Attributes) -> Array:
        return from_z(_unit(attributes, attributes.array("zaxis", (0.0, 0.0, 1.0)), "zaxis"))


def _unit(attributes: Attributes, vector: Array, name: str) -> Array:
    length = float(np.linalg.norm(vector))
    if length < TINY:
        raise attributes.error(f"{name} has no direction, got {attributes.text(name)!r}")
    return vector / length
