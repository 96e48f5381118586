"""3D: poses (position, quaternion), z up; shapes, joints and sensors, and the kernels of their geometry.

The files have the names of those in planar/.
"""

from ..specification.joints import Ball, Distance, Target, Weld
from ..specification.sensors import ContactSensor, JointSensor, PoseSensor, VelocitySensor
from .shapes import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere

__all__ = [
    "Ball",
    "Box",
    "Capsule",
    "ContactSensor",
    "Cylinder",
    "Distance",
    "Heightfield",
    "Hull",
    "JointSensor",
    "Plane",
    "PoseSensor",
    "Shape",
    "Sphere",
    "Target",
    "VelocitySensor",
    "Weld",
]
