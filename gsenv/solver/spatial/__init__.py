"""3D: poses (position, quaternion), z up; shapes, joints and sensors, and the kernels of their geometry.

The files have the names of those in planar/.
"""

from ..specification.joints import Ball, Distance, Target, Weld
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
from .shapes import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere

__all__ = [
    "AccelerationSensor",
    "Ball",
    "Box",
    "Capsule",
    "ContactForceSensor",
    "ContactSensor",
    "Cylinder",
    "Distance",
    "FrameSensor",
    "Heightfield",
    "Hull",
    "JointSensor",
    "Plane",
    "PoseSensor",
    "RaySensor",
    "Shape",
    "Sphere",
    "Target",
    "VelocitySensor",
    "Weld",
]
