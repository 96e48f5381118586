"""The sensors, one dataclass for each kind; ``Scene.add_sensor`` checks them.

``World.sensor`` reads one sensor, (world, number); ``World.sensors`` reads all of them into columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from ..dimension import dimension
from ..records.model import Array
from . import check
from .check import ALL_BITS
from .handles import Reference, find
from .specs import SceneSpec, SensorSpec

Vector = Sequence[float] | Array
WITH_COORDINATE = ("distance", "hinge", "slider", "wheel", "gear", "axis")  # 3D joints


@dataclass(frozen=True)
class Sensor:
    """The base class of all sensors."""

    kind: ClassVar[str]
    widths: ClassVar[Mapping[int, int]]  # dimension: length of a reading; 0: one number for each ray


@dataclass(frozen=True)
class BodySensor(Sensor):
    """A sensor of a body, which is given by handle, name or index."""

    body: Reference


@dataclass(frozen=True)
class PoseSensor(BodySensor):
    """Pose of the body's own frame: x, y m, angle rad; in 3D x, y, z m and the quaternion (w, x, y, z)."""

    kind: ClassVar[str] = "pose"
    widths: ClassVar[Mapping[int, int]] = {2: 3, 3: 7}


@dataclass(frozen=True)
class VelocitySensor(BodySensor):
    """Velocity of the body's centre of mass, m/s, and its angular velocity, rad/s."""

    kind: ClassVar[str] = "velocity"
    widths: ClassVar[Mapping[int, int]] = {2: 3, 3: 6}


@dataclass(frozen=True)
class ContactSensor(BodySensor):
    """Whether the body touches something, 0 or 1, and the mean contact force on it over the last step, N."""

    kind: ClassVar[str] = "contact"
    widths: ClassVar[Mapping[int, int]] = {2: 3, 3: 4}


@dataclass(frozen=True)
class ContactForceSensor(BodySensor):
    """The mean load on the body by all its contacts over the last step.

    In the world's axes: the force, N, the torque about the centre of mass at the start of the step, N m, and the
    sum of the normal forces, N, which is 0 without contact and also counts forces that cancel.
    """

    kind: ClassVar[str] = "contact_force"
    widths: ClassVar[Mapping[int, int]] = {2: 4, 3: 7}


@dataclass(frozen=True)
class SiteSensor(BodySensor):
    """A sensor of a site, a point that is fixed to the body."""

    _: KW_ONLY
    position: Vector | None = None  # m, in the body's own frame; None: its origin


@dataclass(frozen=True)
class FrameSensor(SiteSensor):
    """Place and velocity of a site on the body.

    2D: x, y m, cos and sin of the body's angle, its velocity along the body's own axes m/s, w rad/s. 3D: x, y, z m,
    the quaternion (w, x, y, z), velocity m/s and angular velocity rad/s, both along the body's own axes.

    Args:
        position: m, of the site in the body's own frame. Default: its origin.
    """

    kind: ClassVar[str] = "frame"
    widths: ClassVar[Mapping[int, int]] = {2: 7, 3: 13}


@dataclass(frozen=True)
class AccelerationSensor(SiteSensor):
    """The acceleration of a site on the body, m/s^2, and the body's angular acceleration, rad/s^2.

    Both are means over the last step, the change of the velocity divided by the timestep, so that impacts are
    included. They are along the body's own axes half-way between its rotations before and after the step, which makes
    them accurate to second order. They are 0 until the first step after a reset, and do not depend on poses and
    velocities that are set after the step.

    Args:
        position: m, of the site in the body's own frame. Default: its origin.
        subtract_gravity: whether gravity (times the body's ``gravity_scale``) is subtracted, as an accelerometer
            does: it reads 0 in free fall, and 9.81 upward at rest.
    """

    kind: ClassVar[str] = "acceleration"
    widths: ClassVar[Mapping[int, int]] = {2: 3, 3: 6}

    _: KW_ONLY
    subtract_gravity: bool = False


@dataclass(frozen=True)
class RaySensor(SiteSensor):
    """Distances from a site on the body to other bodies, m, one number for each ray.

    The distance to the first shape of another body, ``length`` where there is none, 0 inside a shape.

    Args:
        angles: rad, (ray,), in 2D: directions in the body's own frame.
        directions: (ray, dim) of any length but 0, in the body's own frame; in 3D, and in 2D instead of the angles.
        length: m, of the rays.
        position: m, of the site in the body's own frame. Default: its origin.
        mask: bits of the categories that the rays can hit, default all; they never hit sensor shapes.
    """

    kind: ClassVar[str] = "rays"
    widths: ClassVar[Mapping[int, int]] = {2: 0, 3: 0}

    _: KW_ONLY
    angles: Any = None
    directions: Any = None
    length: float
    mask: int = ALL_BITS


@dataclass(frozen=True)
class JointSensor(Sensor):
    """A sensor of a joint, which is given by handle, name or index.

    In 2D it reads the coordinate, its rate, the reaction force x, y N and torque N m on body_b at its anchor; in 3D the
    coordinate and its rate, of joints that have one, and the reaction force (3,) N and torque (3,) N m.
    """

    kind: ClassVar[str] = "joint"
    widths: ClassVar[Mapping[int, int]] = {2: 5, 3: 6}

    joint: Reference


SENSOR_TYPES: dict[str, type[Sensor]] = {
    cls.kind: cls
    for cls in (
        PoseSensor, VelocitySensor, ContactSensor, ContactForceSensor, FrameSensor, AccelerationSensor, RaySensor,
        JointSensor,
    )
}  # fmt: skip


def sensor_spec(name: str, sensor: Sensor, scene: SceneSpec) -> SensorSpec:
    """Return the checked sensor.

    Raises:
        ValueError: not a sensor of this dimension, an unknown body or joint, or an argument out of its range.
    """
    what = f"sensor {name!r}"
    if not isinstance(sensor, Sensor) or type(sensor) not in SENSOR_TYPES.values():
        raise ValueError(f"{what}: {sensor!r} is not a sensor such as PoseSensor(body).")
    if scene.dim not in sensor.widths:
        raise ValueError(f"{what}: {check.other_dimension(sensor, scene.dim)}.")
    spec = SensorSpec(name, sensor.kind, -1, -1, np.zeros(scene.dim), np.zeros((0, scene.dim)), 0.0, ALL_BITS, False)
    spec.width = sensor.widths[scene.dim]
    if isinstance(sensor, JointSensor):
        spec.joint = find(sensor.joint, "joint", list(scene.joints), what)
        if list(scene.joints.values())[spec.joint].kind in WITH_COORDINATE:
            spec.width = 8
    if isinstance(sensor, BodySensor):
        spec.body = find(sensor.body, "body", list(scene.bodies), what)
    if isinstance(sensor, SiteSensor) and sensor.position is not None:
        spec.position = check.vector(sensor.position, scene.dim, f"{what}: position")
    if isinstance(sensor, AccelerationSensor):
        spec.subtract_gravity = check.flag(sensor.subtract_gravity, f"{what}: subtract_gravity")
    if isinstance(sensor, RaySensor):
        spec.rays = _directions(sensor, scene.dim, what)
        spec.length = check.positive(sensor.length, f"{what}: length")
        spec.mask = check.bits(sensor.mask, f"{what}: mask")
    return spec


def _directions(sensor: RaySensor, dim: int, what: str) -> Array:
    """Return the unit directions (ray, dim) of a sensor's rays in the body's frame."""
    if sensor.directions is None:
        if dim == 3:
            raise ValueError(f"{what}: rays in 3D need directions (ray, 3).")
        return _directions_of_angles(sensor.angles, what)
    if sensor.angles is not None:
        other = " or angles, not both" if dim == 2 else "; rays in 3D have no angles"
        raise ValueError(f"{what}: give directions{other}.")
    given = check.numbers(sensor.directions, f"{what}: directions")
    if given.ndim != 2 or given.shape[1] != dim or not given.size:
        raise ValueError(f"{what}: directions must have the shape (rays, {dim}), got {given.shape}.")
    largest = np.abs(given).max(1, keepdims=True)
    if (largest == 0.0).any():
        raise ValueError(f"{what}: directions must not be zero.")
    way = given / largest  # squares of large numbers might overflow
    return np.asarray(way / np.sqrt((way * way).sum(1, keepdims=True)))


def _directions_of_angles(value: Any, what: str) -> Array:
    angles = check.numbers(value, f"{what}: angles")
    if angles.ndim != 1 or not angles.size:
        raise ValueError(f"{what}: angles must be a list of numbers, got an array of shape {angles.shape}.")
    return np.array([dimension(2).initial_state.rotation_of(angle) for angle in angles])
