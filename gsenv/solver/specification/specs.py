"""The checked content of a scene: bodies, joints, actuators and sensors, with indices for names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..records.model import Array, BodyKind


@dataclass
class BodySpec:
    dim: int
    name: str
    kind: BodyKind
    shapes: tuple[Any, ...]
    position: Array
    angle: float  # rad, in 2D
    orientation: Array  # quaternion (w, x, y, z), in 3D
    linear_velocity: Array
    angular_velocity: Any  # a float, or (3,)
    mass: float | None
    inertia: Any  # a float, or (3,) or (3, 3)
    linear_damping: float
    angular_damping: float
    gravity_scale: float
    continuous: bool
    enabled: bool
    color: tuple[int, int, int] | None
    center: Array | None = None  # centre of mass in the body's own frame, None: of its shapes


@dataclass
class JointSpec:
    """A joint or a user constraint. Anchors are in the frames of the bodies, the axis is in the world."""

    name: str
    kind: str  # of joints.JOINT_TYPES, or "rows"
    body_a: int
    body_b: int
    enabled: bool
    row_count: int = 0  # rows besides those of limit, motor, spring and friction
    anchor_a: Array | None = None
    anchor_b: Array | None = None
    axis: Array | None = None  # unit
    orientation: Array | None = None  # of the axes of 3D joints, a quaternion in the world
    locked: int = 0  # as in joint_model_dtype
    coordinate: int = -1
    motor_coordinate: int = -1
    parent: int = 0  # own index
    parts: list[JointSpec] = field(default_factory=list)  # coordinates that have entries of their own
    length: float | None = None
    lower: float = -np.inf
    upper: float = np.inf
    limit_restitution: float = 0.0
    limit_frequency: float = 0.0
    limit_damping_ratio: float = 0.0
    frequency: float = 0.0
    damping_ratio: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    spring_effort: float = np.inf
    motor_speed: float = 0.0
    motor_effort: float = 0.0
    motor_gain: float = np.inf
    friction_effort: float = 0.0
    armature: float = 0.0
    max_force: float = np.inf
    max_torque: float = np.inf
    joint_a: int = 0
    joint_b: int = 0
    ratio: float = 0.0
    offset: float = 0.0
    halves: int = 1  # 2: of a gear whose row acts on the bodies of both joints
    drives_one: bool = False  # of a gear: both joints move the same body
    rows: list[dict[str, Any]] = field(default_factory=list)
    frame: str = "world"
    update: Callable[[Any], Mapping[str, Any]] | None = None

    @property
    def has_spring(self) -> bool:
        return self.frequency > 0.0 or self.stiffness > 0.0 or self.damping > 0.0

    @property
    def rigid(self) -> bool:
        """Whether the rows of the joint are rigid."""
        if self.kind == "distance":
            return not self.has_spring and not (np.isfinite(self.lower) or np.isfinite(self.upper))
        return not self.has_spring


@dataclass
class ActuatorSpec:
    name: str
    joint: int
    axis: int
    mode: str
    lower: float
    upper: float
    gain: float
    offset: float


@dataclass
class SensorSpec:
    name: str
    kind: str
    body: int  # -1: none
    joint: int  # -1: none
    position: Array  # m, of the site in the body's own frame
    rays: Array  # (ray, dim) unit directions in the body's own frame
    length: float  # m
    mask: int
    subtract_gravity: bool
    width: int = 0  # numbers of a reading; 0: one for each ray


@dataclass(eq=False, repr=False)
class SceneSpec:
    """The input of ``compile_scene``, which ``Scene`` fills."""

    dim: int
    gravity: Array
    bodies: dict[str, BodySpec] = field(default_factory=dict)
    joints: dict[str, JointSpec] = field(default_factory=dict)
    actuators: dict[str, ActuatorSpec] = field(default_factory=dict)
    sensors: dict[str, SensorSpec] = field(default_factory=dict)
    excluded: set[tuple[int, int]] = field(default_factory=set)
