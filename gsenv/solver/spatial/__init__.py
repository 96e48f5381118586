"""3D: poses (position, quaternion), z up; shapes, joints and sensors, and the kernels of their geometry.

The files have the names of those in planar/.
"""

from ..specification.axis_joints import Hinge, SixAxis, Slider, Universal
from ..specification.joint_base import Axis
from ..specification.joints import Ball, Distance, Gear, Target, Weld, Wheel
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
    "Axis",
    "Ball",
    "Box",
    "Capsule",
    "ContactForceSensor",
    "ContactSensor",
    "Cylinder",
    "Distance",
    "FrameSensor",
    "Gear",
    "Heightfield",
    "Hinge",
    "Hull",
    "JointSensor",
    "Plane",
    "PoseSensor",
    "RaySensor",
    "Shape",
    "SixAxis",
    "Slider",
    "Sphere",
    "Target",
    "Universal",
    "VelocitySensor",
    "Weld",
    "Wheel",
]
