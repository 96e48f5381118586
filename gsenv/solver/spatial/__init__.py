"""3D: poses (position, quaternion), z up; shapes, joints and sensors, and the kernels of their geometry.

The files have the names of those in planar/.
"""

from ..specification.axis_joints import Hinge, SixAxis, Slider, Universal
from ..specification.joint_base import Axis
from ..specification.joints import Ball, Distance, Gear, Target, Weld, Wheel
from ..specification.sensors import ContactSensor, JointSensor, PoseSensor, VelocitySensor
from .shapes import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere

__all__ = [
    "Axis",
    "Ball",
    "Box",
    "Capsule",
    "ContactSensor",
    "Cylinder",
    "Distance",
    "Gear",
    "Heightfield",
    "Hinge",
    "Hull",
    "JointSensor",
    "Plane",
    "PoseSensor",
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
