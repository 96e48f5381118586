"""The sensors, one dataclass for each kind; ``Scene.add_sensor`` checks them.

``World.sensor`` reads one sensor, (world, number); ``World.sensors`` reads all of them into columns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

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
class FrameSensor(BodySensor):
    """2D: a site on the body: x, y m, cos and sin of its angle, its velocity along the body's own axes m/s, w rad/s.

    Args:
        position: m, of the site in the body's own frame. Default: its origin.
    """

    kind: ClassVar[str] = "frame"
    widths: ClassVar[Mapping[int, int]] = {2: 7}

    _: KW_ONLY
    position: Vector = (0.0, 0.0)


@dataclass(frozen=True)
class RaySensor(BodySensor):
    """2D: distances from a site on the body to other bodies, m, one number for each ray.

    The distance to the first shape of another body, ``length`` where there is none, 0 inside a shape.

    Args:
        angles: rad, (ray,) directions in the body's own frame.
        length: m, of the rays.
        position: m, of the site in the body's own frame. Default: its origin.
        mask: bits of the categories that the rays can hit, default all; they never hit sensor shapes.
    """

    kind: ClassVar[str] = "rays"
    widths: ClassVar[Mapping[int, int]] = {2: 0}

    _: KW_ONLY
    angles: Any
    length: float
    position: Vector = (0.0, 0.0)
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
    cls.kind: cls for cls in (PoseSensor, VelocitySensor, ContactSensor, FrameSensor, RaySensor, JointSensor)
}


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
    spec = SensorSpec(name, sensor.kind, -1, -1, np.zeros(2), np.zeros(0), 0.0, ALL_BITS)
    spec.width = sensor.widths[scene.dim]
    if isinstance(sensor, JointSensor):
        spec.joint = find(sensor.joint, "joint", list(scene.joints), what)
        if list(scene.joints.values())[spec.joint].kind in WITH_COORDINATE:
            spec.width = 8
    if isinstance(sensor, BodySensor):
        spec.body = find(sensor.body, "body", list(scene.bodies), what)
    if isinstance(sensor, (FrameSensor, RaySensor)):
        spec.position = check.vector(sensor.position, 2, f"{what}: position")
    if isinstance(sensor, RaySensor):
        spec.angles = check.numbers(sensor.angles, f"{what}: angles")
        if spec.angles.ndim != 1 or not spec.angles.size:
            shape = spec.angles.shape
            raise ValueError(f"{what}: angles must be a list of numbers, got an array of shape {shape}.")
        spec.length = check.positive(sensor.length, f"{what}: length")
        spec.mask = check.bits(sensor.mask, f"{what}: mask")
    return spec
