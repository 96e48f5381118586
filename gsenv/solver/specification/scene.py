"""Scene: the description that a user writes. ``compile`` turns it into the arrays that kernels read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..records.model import Array, Model
from . import bodies as body_checks
from . import check
from .actuators import actuator_spec
from .compile import compile_scene
from .constraints import constraint_spec
from .handles import Handle, Reference, find
from .joint_base import Joint
from .joint_spec import excluded_pair, joint_spec
from .sensors import Sensor, sensor_spec
from .specs import BodySpec, SceneSpec
from .terrains import warn_of_inverted_terrains

GRAVITY = {2: (0.0, -9.81), 3: (0.0, 0.0, -9.81)}
Vector = Sequence[float] | Array


class Scene(SceneSpec):
    """Bodies, joints, actuators, sensors and constraints, by name. Compiled when a World is made.

    Args:
        dim: 2 (x, y, with y up) or 3 (x, y, z, with z up).
        gravity: m/s^2, ``dim`` numbers.

    Raises:
        ValueError: on any bad argument of any method, naming it; the scene is then unchanged.
    """

    def __init__(self, dim: int = 2, gravity: Vector | None = None) -> None:
        if not isinstance(dim, (int, np.integer)) or dim not in (2, 3):
            raise ValueError(f"Scene: dim must be 2 or 3, got {dim!r}.")
        super().__init__(dim, check.vector(GRAVITY[dim] if gravity is None else gravity, dim, "Scene: gravity"))

    def add_body(
        self,
        name: str,
        kind: str = "dynamic",
        shapes: Sequence[Any] = (),
        *,
        position: Vector | None = None,
        angle: float = 0.0,
        orientation: Vector | None = None,
        linear_velocity: Vector | None = None,
        angular_velocity: float | Vector | None = None,
        mass: float | None = None,
        inertia: float | Vector | None = None,
        center: Vector | None = None,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
        gravity_scale: float = 1.0,
        continuous: bool = False,
        enabled: bool = True,
        color: tuple[int, int, int] | None = None,
    ) -> Handle:
        """Add a rigid body.

        Args:
            name: unique among the bodies.
            kind: "dynamic", "kinematic" (moves at its velocity, unaffected by forces) or "static".
            shapes: geometry in the body's own frame; a dynamic body needs a solid shape with density, or a
                mass and an inertia.
            position: m, (dim,), origin of the body's own frame; the centre of mass follows from the shapes.
            angle: rad, in 2D; orientation: quaternion (w, x, y, z) of any length but 0, in 3D.
            linear_velocity: m/s, (dim,), of the centre of mass; angular_velocity: rad/s, in 3D (3,), in the
                world's axes.
            mass: kg; None derives it from the shapes' densities.
            inertia: kg m^2 about the centre of mass; in 3D (3,) about the body's axes or a (3, 3)
                tensor; None derives it from the shapes, scaled to ``mass`` where that is given.
            center: m, centre of mass in the body's own frame, with a mass and an inertia; None derives it from
                the shapes.
            linear_damping, angular_damping: 1/s, rates at which the velocities decay.
            gravity_scale: factor of gravity for this body.
            continuous: whether the body is kept from passing through others however fast it is; this costs
                more and is meant for small or thin fast bodies.
            enabled: False excludes the body until ``Parameters.set`` enables it.
            color: RGB, 0 to 255, for renderers.

        Returns:
            A handle, which other methods accept in place of the name.

        Raises:
            ValueError: a name that exists, a bad value, or a dynamic body without mass or inertia.
        """
        what = f"body {name!r}"
        name = check.unique(name, self.bodies, "body")
        dim, zero = self.dim, np.zeros(self.dim)
        spec = BodySpec(
            dim=dim,
            name=name,
            kind=body_checks.KINDS[check.choice(kind, body_checks.KINDS, f"{what}: kind")],
            shapes=tuple(shapes) if isinstance(shapes, (list, tuple)) else (shapes,),
            position=check.vector(zero if position is None else position, dim, f"{what}: position"),
            angle=body_checks.angle(angle, dim, what),
            orientation=body_checks.orientation(orientation, dim, what),
            linear_velocity=check.vector(
                zero if linear_velocity is None else linear_velocity, dim, f"{what}: linear_velocity"
            ),
            angular_velocity=body_checks.angular_velocity(angular_velocity, dim, f"{what}: angular_velocity"),
            mass=None if mass is None else check.positive(mass, f"{what}: mass"),
            inertia=None if inertia is None else body_checks.inertia(inertia, dim, f"{what}: inertia"),
            linear_damping=check.not_negative(linear_damping, f"{what}: linear_damping"),
            angular_damping=check.not_negative(angular_damping, f"{what}: angular_damping"),
            gravity_scale=check.finite(gravity_scale, f"{what}: gravity_scale"),
            continuous=check.flag(continuous, f"{what}: continuous"),
            enabled=check.flag(enabled, f"{what}: enabled"),
            color=None if color is None else body_checks.color(color, f"{what}: color"),
            center=None if center is None else check.vector(center, dim, f"{what}: center"),
        )
        body_checks.check_body(spec)
        self.bodies[name] = spec
        return Handle("body", name, len(self.bodies) - 1)

    def add_joint(self, name: str, joint: Joint) -> Handle:
        """Add a joint, such as ``Revolute("torso", "thigh", anchor=(0, 1), limits=(-1, 0.5))``.

        Args:
            joint: of ``gsenv.solver.planar``: Revolute, Prismatic, Weld, Distance, Wheel, Gear or Target; of
                ``gsenv.solver.spatial``: Hinge, Slider, Universal, Ball, Wheel, Gear, SixAxis, Weld, Distance or
                Target.

        A joint with several coordinates adds further joints for them, such as "hip/turn_x"; its docstring names them.
        """
        name = check.unique(name, self.joints, "joint")
        spec = joint_spec(name, joint, self)
        for part in spec.parts:
            check.unique(part.name, self.joints, "joint")
        handle = Handle("joint", name, len(self.joints))
        for one in (spec, *spec.parts):
            self.joints[one.name] = one
        self.excluded |= excluded_pair(joint, spec)
        return handle

    def add_constraint(
        self,
        name: str,
        bodies: Sequence[Reference] | Reference,
        jacobian: Any,
        *,
        lower: Any = -np.inf,
        upper: Any = np.inf,
        bias: Any = 0.0,
        softness: Any = 0.0,
        frame: str = "world",
        update: Callable[[Any], Mapping[str, Any]] | None = None,
        enabled: bool = True,
    ) -> Handle:
        """Add a user constraint: rows ``J v + bias + softness * impulse``, solved in each step.

        Args:
            bodies: one or two.
            jacobian: (row, bodies * 3) in 2D: [vx, vy, w] of each body; at most 3 rows. In 3D
                (row, bodies * 6): [v, w] of each; at most 6 rows.
            lower, upper: N or N m, bounds of the rows' forces: none make a lock, one a one-sided limit, both
                a motor.
            bias: m/s; softness: 1/kg.
            frame: "world", or "body": the directions are fixed in the first body and rotate with it.
            update: called as ``update(world)`` before each step; returns new values of any of jacobian
                (world, row, as above), lower, upper, bias, softness and error (world, row), m or rad:
                position errors of locks and one-sided rows, which the position pass corrects. Values
                may have any shape that broadcasts to these. Its bodies never sleep.
        """
        name = check.unique(name, self.joints, "constraint")
        bounds = {"lower": lower, "upper": upper, "bias": bias, "softness": softness}
        self.joints[name] = constraint_spec(name, bodies, jacobian, bounds, frame, update, enabled, self)
        return Handle("joint", name, len(self.joints) - 1)

    def add_actuator(
        self,
        name: str,
        joint: Reference,
        axis: str | None = None,
        mode: str = "velocity",
        lower: float = -np.inf,
        upper: float = np.inf,
        gain: float = 1.0,
        offset: float = 0.0,
    ) -> Handle:
        """Add an entry of ``World.control`` that drives a joint.

        Args:
            joint: a target, or a joint with a motor (for "velocity" and "torque") or a spring (for
                "position"); the joint's motor_effort or spring_effort bounds its effort.
            axis: of a target: "x", "y" (m or m/s) or "angle" (rad or rad/s); in 3D "x", "y", "z" or
                "turn_x", "turn_y", "turn_z" (rad/s about the world's axes).
            mode: the control is the "velocity" of a motor or target, the "position" of a target or the
                rest of a spring, or the "torque" (N m, of a prismatic joint N) of a motor.
            lower, upper: the control is clipped to this range.
            gain, offset: what is set is gain * control + offset.

        Raises:
            ValueError: an unknown joint, one without the motor or spring, or one that is driven already.
        """
        name = check.unique(name, self.actuators, "actuator")
        self.actuators[name] = actuator_spec(name, joint, axis, mode, (lower, upper), (gain, offset), self)
        return Handle("actuator", name, len(self.actuators) - 1)

    def add_sensor(self, name: str, sensor: Sensor) -> Handle:
        """Add a sensor of a body or joint, for ``World.sensor`` and ``World.sensors``.

        Args:
            sensor: PoseSensor, VelocitySensor, FrameSensor, AccelerationSensor, ContactSensor, ContactForceSensor,
                RaySensor or JointSensor, of ``gsenv.solver.planar`` or ``gsenv.solver.spatial``, which have the same.
        """
        name = check.unique(name, self.sensors, "sensor")
        self.sensors[name] = sensor_spec(name, sensor, self)
        return Handle("sensor", name, len(self.sensors) - 1)

    def exclude(self, body_a: Reference, body_b: Reference) -> None:
        """Exclude contacts between two different bodies, given by handle, name or index."""
        a, b = (find(body, "body", list(self.bodies), "exclude") for body in (body_a, body_b))
        if a == b:
            raise ValueError(f"exclude needs two different bodies, got {body_a!r} twice.")
        self.excluded.add((min(a, b), max(a, b)))

    def compile(self) -> Model:
        """Return the Model: the constant data and the nominal values of a world.

        Warns of a 2D terrain that goes from right to left below bodies, which would fall through it.

        Raises:
            ValueError: a scene without bodies.
        """
        if self.dim == 2:
            warn_of_inverted_terrains(self.bodies.values(), 2)
        return compile_scene(self)
