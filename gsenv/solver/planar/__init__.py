"""2D: poses (x, y, angle), y up; shapes, joints and sensors, and the kernels of their geometry."""

from ..specification.joints import Distance, Gear, Prismatic, Revolute, Target, Weld, Wheel
from ..specification.sensors import (
    AccelerationSensor,
    ContactForceSensor,
    ContactSensor,
    FrameSensor,
    JointSensor,
    PoseSensor,
    RaySensor,
    VelocitySensor,
)
from .shapes import Box, Capsule, Circle, HalfPlane, Polygon, Shape, Terrain

__all__ = [
    "AccelerationSensor",
    "Box",
    "Capsule",
    "Circle",
    "ContactForceSensor",
    "ContactSensor",
    "Distance",
    "FrameSensor",
    "Gear",
    "HalfPlane",
    "JointSensor",
    "Polygon",
    "PoseSensor",
    "Prismatic",
    "RaySensor",
    "Revolute",
    "Shape",
    "Target",
    "Terrain",
    "VelocitySensor",
    "Weld",
    "Wheel",
]
