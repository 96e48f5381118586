"""Scene: what a user writes down. ``compile`` turns it into the arrays that the kernels read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import check
from .check import ALL_BITS
from .joint_spec import DRIVEN, KINDS_OF, JointSpec, gear_spec, joint_spec
from .model import NDOF, Array, BodyKind, Model
from .sensors import SensorSpec, sensor_spec

KINDS = {"static": BodyKind.STATIC, "kinematic": BodyKind.KINEMATIC, "dynamic": BodyKind.DYNAMIC}
GRAVITY = {2: (0.0, -9.81), 3: (0.0, 0.0, -9.81)}
AXES = {
    2: {"x": 0, "y": 1, "angle": 2},
    3: {"x": 0, "y": 1, "z": 2, "turn_x": 3, "turn_y": 4, "turn_z": 5},
}
Vector = Sequence[float] | Array


@dataclass(frozen=True)
class Handle:
    """A named thing of a scene: what it is ("body", "joint", ...), its name and its index."""

    what: str
    name: str
    index: int

    def __index__(self) -> int:
        return self.index


@dataclass
class BodySpec:
    dim: int
    name: str
    kind: BodyKind
    shapes: tuple[Any, ...]
    position: Array
    angle: float  # of the plane
    rotation: Array  # quaternion, of space
    linear_velocity: Array
    angular_velocity: Any  # a float, or (3,)
    mass: float | None
    inertia: Any  # a float, or (3,) or (3, 3)
    linear_damping: float
    angular_damping: float
    gravity_scale: float
    fast: bool
    enabled: bool
    color: tuple[int, int, int] | None


@dataclass
class ActuatorSpec:
    name: str
    joint: int
    axis: int
    mode: str
    lower: float
    upper: float


class Scene:
    """Bodies, joints, actuators, sensors and constraints, by name. Compiled when a World is made.

    Args:
        dim: 2 (x, y, with y up) or 3 (x, y, z, with z up).
        gravity: m/s^2, ``dim`` numbers.

    Raises:
        ValueError: on any bad argument of any method, naming it; the scene is then unchanged.
    """

    def __init__(self, dim: int = 2, gravity: Vector | None = None) -> None:
        if dim not in (2, 3):
            raise ValueError(f"Scene: dim must be 2 or 3, got {dim!r}.")
        self.dim = dim
        self.gravity = check.vector(GRAVITY[dim] if gravity is None else gravity, dim, "Scene: gravity")
        self.bodies: dict[str, BodySpec] = {}
        self.joints: dict[str, JointSpec] = {}
        self.actuators: dict[str, ActuatorSpec] = {}
        self.sensors: dict[str, SensorSpec] = {}
        self.excluded: set[tuple[int, int]] = set()

    def add_body(
        self,
        name: str,
        kind: str = "dynamic",
        shapes: Sequence[Any] = (),
        position: Vector | None = None,
        angle: float = 0.0,
        linear_velocity: Vector | None = None,
        angular_velocity: float | Vector | None = None,
        mass: float | None = None,
        inertia: float | Vector | None = None,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
        gravity_scale: float = 1.0,
        fast: bool = False,
        enabled: bool = True,
        color: tuple[int, int, int] | None = None,
        rotation: Vector | None = None,
    ) -> Handle:
        """Add a rigid body.

        Args:
            kind: "dynamic", "kinematic" (moves at its velocity, feels nothing) or "static".
            shapes: geometry in the body's own frame; a dynamic body needs one with area, or a
                mass and an inertia.
            position: m, where the body's own frame is; the centre of mass follows from the shapes.
            angle: rad, in 2D; rotation: quaternion (w, x, y, z), in 3D.
            linear_velocity: m/s, of the centre of mass; angular_velocity: rad/s, in 3D (3,) in the world.
            mass: kg; None takes it from the shapes' densities.
            inertia: kg m^2 about the centre of mass; in 3D (3,) about the body's axes or a (3, 3)
                tensor; None takes it from the shapes, scaled to ``mass`` where that is given.
            linear_damping, angular_damping: 1/s.
            fast: swept against everything, never tunnels (dearer; for small or thin and fast).
            enabled: False keeps it out of the world until ``Parameters`` enable it; see ``Parameters.set``.
            color: RGB for renderers.
        """
        what = f"body {name!r}"
        name = check.unique(name, self.bodies, "body")
        zero = np.zeros(self.dim)
        spec = BodySpec(
            dim=self.dim,
            name=name,
            kind=KINDS[check.choice(kind, KINDS, f"{what}: kind")],
            shapes=tuple(shapes) if isinstance(shapes, (list, tuple)) else (shapes,),
            position=check.vector(zero if position is None else position, self.dim, f"{what}: position"),
            angle=self._angle(angle, what),
            rotation=self._rotation(rotation, what),
            linear_velocity=check.vector(
                zero if linear_velocity is None else linear_velocity, self.dim, f"{what}: linear_velocity"
            ),
            angular_velocity=self._spin(angular_velocity, f"{what}: angular_velocity"),
            mass=None if mass is None else check.positive(mass, f"{what}: mass"),
            inertia=None if inertia is None else self._inertia(inertia, f"{what}: inertia"),
            linear_damping=check.not_negative(linear_damping, f"{what}: linear_damping"),
            angular_damping=check.not_negative(angular_damping, f"{what}: angular_damping"),
            gravity_scale=check.finite(gravity_scale, f"{what}: gravity_scale"),
            fast=bool(fast),
            enabled=bool(enabled),
            color=None if color is None else _color(color, f"{what}: color"),
        )
        from .compile import check_body

        check_body(spec)
        self.bodies[name] = spec
        return Handle("body", name, len(self.bodies) - 1)

    def _angle(self, angle: Any, what: str) -> float:
        if self.dim == 3 and angle != 0.0:
            raise ValueError(f"{what}: in 3D it is rotation=(w, x, y, z) that turns a body, got angle={angle!r}.")
        return check.finite(angle, f"{what}: angle")

    def _rotation(self, rotation: Any, what: str) -> Array:
        if rotation is None:
            return np.array([1.0, 0.0, 0.0, 0.0])
        if self.dim == 2:
            raise ValueError(f"{what}: in 2D it is angle that turns a body, got rotation={rotation!r}.")
        return check.rotation(rotation, f"{what}: rotation")

    def _spin(self, value: Any, what: str) -> Any:
        if self.dim == 2:
            return check.finite(0.0 if value is None else value, what)
        return check.vector(np.zeros(3) if value is None else value, 3, what)

    def _inertia(self, value: Any, what: str) -> Any:
        return check.positive(value, what) if self.dim == 2 else check.inertia(value, what)

    def _body(self, body: Handle | str | int, what: str) -> int:
        """Index of a body given by handle, name or index."""
        return find(body, "body", list(self.bodies), what)

    def add_joint(
        self,
        name: str,
        kind: str,
        body_a: Handle | str | int | None = None,
        body_b: Handle | str | int | None = None,
        anchor: Vector | None = None,
        anchor_a: Vector | None = None,
        anchor_b: Vector | None = None,
        axis: Vector | None = None,
        length: float | None = None,
        limits: tuple[float, float] | None = None,
        frequency: float | None = None,
        damping_ratio: float = 1.0,
        stiffness: float | None = None,
        damping: float = 0.0,
        rest: float = 0.0,
        spring_effort: float = np.inf,
        motor_speed: float = 0.0,
        motor_effort: float = 0.0,
        max_force: float = np.inf,
        max_torque: float = np.inf,
        joint_a: Handle | str | int | None = None,
        joint_b: Handle | str | int | None = None,
        ratio: float = 1.0,
        collide: bool = False,
        enabled: bool = True,
    ) -> Handle:
        """Add a joint. Its coordinate q is an angle (revolute), a translation (prismatic, wheel) or a length.

        Args:
            kind: in 3D "ball" (b turns about a point of a), "weld", "distance" or "target"; in 2D
                "revolute" (b turns about a point of a), "prismatic" (b slides along an axis of a),
                "weld" (b fixed to a), "distance" (rod; a rope if only ``limits`` are given; a spring),
                "wheel" (b turns, and slides along an axis of a on a spring), "gear" (q of joint_a +
                ratio * q of joint_b stays as it is) or "target" (pulls body_b to a moving pose in the
                world; needs no body_a). What holds on to the world needs a static body.
            anchor: m, world point at the authored poses; or anchor_a, anchor_b in the bodies' own
                frames. Default: the origin of body_b; of a distance joint, that of each body.
            axis: direction in the world at the authored poses; fixed in body_a from then on.
            length: m, of a rod or relaxed spring; None is the authored distance.
            limits: (lower, upper) of q in rad or m, infinite for none; q is 0 as authored.
            frequency: Hz, damping_ratio: of a spring on the mass that the joint sees; None is no
                spring, 5 Hz for a target. Or stiffness, N/m or N m/rad, and damping, N s/m or N m s/rad.
            rest: q at which the spring is relaxed; spring_effort: N or N m, its bound.
            motor_speed: of q (of the angle, of a wheel), rad/s or m/s; motor_effort: N m or N, its
                bound, 0 for no motor.
            max_force, max_torque: N and N m, bounds of a target.
            joint_a, joint_b, ratio: of a gear; revolute or prismatic joints.
            collide: whether the two bodies collide with each other.
        """
        what = f"joint {name!r}"
        name = check.unique(name, self.joints, "joint")
        check.choice(kind, KINDS_OF[self.dim], f"{what}: kind")
        bodies = list(self.bodies.values())
        given = {
            "anchor": anchor, "anchor_a": anchor_a, "anchor_b": anchor_b, "axis": axis, "length": length,
            "limits": limits, "frequency": frequency, "damping_ratio": damping_ratio, "stiffness": stiffness,
            "damping": damping, "rest": rest, "spring_effort": spring_effort, "motor_speed": motor_speed,
            "motor_effort": motor_effort, "max_force": max_force, "max_torque": max_torque,
            "joint_a": joint_a, "joint_b": joint_b, "ratio": ratio,
        }  # fmt: skip
        if kind == "gear":
            spec = self._gear(name, body_a, body_b, joint_a, joint_b, ratio, enabled)
        else:
            a, b = self._joined(kind, body_a, body_b, what)
            spec = joint_spec(name, kind, a, b, bodies, given, enabled)
        self.joints[name] = spec
        if not collide and spec.body_a != spec.body_b:
            self.excluded.add((min(spec.body_a, spec.body_b), max(spec.body_a, spec.body_b)))
        return Handle("joint", name, len(self.joints) - 1)

    def _joined(self, kind: str, body_a: Any, body_b: Any, what: str) -> tuple[int, int]:
        if body_b is None:
            raise ValueError(f"{what}: body_b is missing.")
        b = self._body(body_b, what)
        if kind == "target":
            if body_a is not None:
                raise ValueError(f"{what}: a target has no body_a, got {body_a!r}.")
            return b, b
        if body_a is None:
            raise ValueError(f"{what}: body_a is missing.")
        a = self._body(body_a, what)
        if a == b:
            raise ValueError(f"{what} needs two different bodies, got {body_b!r} twice.")
        return a, b

    def _gear(
        self, name: str, body_a: Any, body_b: Any, joint_a: Any, joint_b: Any, ratio: float, enabled: bool
    ) -> JointSpec:
        what = f"joint {name!r}"
        for word, value in (("body_a", body_a), ("body_b", body_b)):
            if value is not None:
                raise ValueError(f"{what}: a gear has no {word}, it couples joint_a and joint_b.")
        for word, value in (("joint_a", joint_a), ("joint_b", joint_b)):
            if value is None:
                raise ValueError(f"{what}: {word} is missing.")
        names = list(self.joints)
        first, second = (find(joint, "joint", names, what) for joint in (joint_a, joint_b))
        joints = list(self.joints.values())
        return gear_spec(name, first, second, ratio, joints, list(self.bodies.values()), enabled)

    def add_constraint(
        self,
        name: str,
        bodies: Sequence[Handle | str | int],
        jacobian: Any,
        lower: Any = -np.inf,
        upper: Any = np.inf,
        bias: Any = 0.0,
        softness: Any = 0.0,
        frame: str = "world",
        update: Callable[[Any], Mapping[str, Any]] | None = None,
        enabled: bool = True,
    ) -> Handle:
        """Add a rule of your own: rows ``J v + bias + softness * impulse``, made true in each step.

        Args:
            bodies: one or two.
            jacobian: (row, bodies * 3) in 2D: [vx, vy, w] of each body; at most 3 rows. In 3D
                (row, bodies * 6): [v, w] of each; at most 6 rows.
            lower, upper: N or N m, bounds of the rows' forces: a lock has none, a limit one-sided
                ones, a motor both.
            bias: m/s; softness: 1/kg.
            frame: "world", or "body": the directions are fixed in the first body and turn with it.
            update: called as ``update(world)`` before each step; returns new values of any of jacobian
                (world, row, as above), lower, upper, bias, softness and error (world, row), m or rad:
                what the position pass takes back of locks and one-sided rows. Anything that
                broadcasts to these shapes will do. Its bodies never sleep.
        """
        what = f"constraint {name!r}"
        name = check.unique(name, self.joints, "constraint")
        if isinstance(bodies, (Handle, str, int)):
            bodies = (bodies,)
        index = [self._body(body, what) for body in bodies]
        if len(index) not in (1, 2) or len(set(index)) != len(index):
            raise ValueError(f"{what} needs one body or two different ones, got {len(index)}.")
        ndof = NDOF[self.dim]
        try:
            rows = np.atleast_2d(np.array(jacobian, np.float64))
        except (TypeError, ValueError):
            raise ValueError(f"{what}: jacobian must be numbers, got {jacobian!r}.") from None
        if rows.ndim != 2 or rows.shape[1] != ndof * len(index) or not 1 <= len(rows) <= ndof:
            raise ValueError(
                f"{what}: jacobian must have 1 to {ndof} rows of {ndof * len(index)} numbers, "
                f"got an array of shape {np.shape(jacobian)}."
            )
        if not np.isfinite(rows).all():
            raise ValueError(f"{what}: jacobian must be finite.")
        low = check.bounds(lower, (len(rows),), f"{what}: lower")
        high = check.bounds(upper, (len(rows),), f"{what}: upper")
        check.ordered_bounds(low, high, what)
        shift = check.values(bias, (len(rows),), f"{what}: bias")
        soft = check.values(softness, (len(rows),), f"{what}: softness")
        if (soft < 0.0).any():
            raise ValueError(f"{what}: softness must not be negative.")
        made = []
        for r in range(len(rows)):
            if len(index) == 2:
                ja, jb = rows[r, :ndof], rows[r, ndof:]
            else:
                ja, jb = np.zeros(ndof), rows[r]
            made.append(
                {
                    "jacobian_a": ja,
                    "jacobian_b": jb,
                    "lower": low[r],
                    "upper": high[r],
                    "bias": shift[r],
                    "softness": soft[r],
                }
            )
        check.choice(frame, ("world", "body"), f"{what}: frame")
        if update is not None and not callable(update):
            raise ValueError(f"{what}: update must be a function of the world, got {update!r}.")
        self.joints[name] = JointSpec(
            name, "rows", index[0], index[-1], bool(enabled), rows=made, frame=frame, update=update
        )
        return Handle("joint", name, len(self.joints) - 1)

    def add_actuator(
        self,
        name: str,
        joint: Handle | str | int,
        axis: str | None = None,
        mode: str = "velocity",
        lower: float = -np.inf,
        upper: float = np.inf,
    ) -> Handle:
        """Let one entry of ``World.control`` drive a joint.

        Args:
            joint: a target, or a joint with a motor (for "velocity" and "torque") or a spring (for
                "position"); their bounds, motor_effort and spring_effort, hold.
            axis: of a target: "x", "y" (m or m/s) or "angle" (rad or rad/s); in 3D "x", "y", "z" or
                "turn_x", "turn_y", "turn_z" (rad/s about the world's axes).
            mode: the control is the "velocity" of a motor or target, the "position" of a target or at
                which a spring is relaxed, or the "torque" (N m, or N of a prismatic) of a motor.
            lower, upper: the control is clipped to this range.
        """
        what = f"actuator {name!r}"
        name = check.unique(name, self.actuators, "actuator")
        index = find(joint, "joint", list(self.joints), what)
        spec = list(self.joints.values())[index]
        check.choice(mode, DRIVEN, f"{what}: mode")
        low = float(check.bounds(lower, (), f"{what}: lower"))
        high = float(check.bounds(upper, (), f"{what}: upper"))
        check.ordered_bounds(np.array(low), np.array(high), what)
        number = self._driven_axis(spec, axis, mode, what)
        taken = [other for other in self.actuators.values() if (other.joint, other.axis) == (index, number)]
        if any(spec.kind == "target" or DRIVEN[other.mode] == DRIVEN[mode] for other in taken):
            raise ValueError(f"{what}: {taken[0].name!r} drives the same part of joint {spec.name!r}.")
        self.actuators[name] = ActuatorSpec(name, index, number, mode, low, high)
        return Handle("actuator", name, len(self.actuators) - 1)

    def _driven_axis(self, spec: JointSpec, axis: str | None, mode: str, what: str) -> int:
        if spec.kind == "target":
            check.choice(mode, ("velocity", "position"), f"{what}: mode of a target")
            return self._target_axis(axis, mode, what)
        if spec.kind in ("rows", "weld", "gear"):
            raise ValueError(f"{what} needs a target, a motor or a spring, {spec.name!r} is a {spec.kind}.")
        if axis is not None:
            raise ValueError(f"{what}: only a target has an axis to choose, got {axis!r}.")
        if DRIVEN[mode] == "motor" and not spec.motor_effort > 0.0:
            raise ValueError(f"{what}: joint {spec.name!r} has no motor; give it a motor_effort.")
        if DRIVEN[mode] == "spring" and (spec.kind == "distance" or not spec.has_spring):
            raise ValueError(f"{what}: joint {spec.name!r} has no spring to set the rest of; give it a frequency.")
        return -1

    def _target_axis(self, axis: Any, mode: str, what: str) -> int:
        axes = AXES[self.dim]
        number = axes[check.choice(axis, axes, f"{what}: axis")]
        if number >= 3 and mode == "position":
            raise ValueError(f"{what}: turning is driven by velocity; {axis} has no position.")
        return number

    def add_sensor(
        self,
        name: str,
        kind: str,
        body: Handle | str | int | None = None,
        *,
        joint: Handle | str | int | None = None,
        local_position: Vector | None = None,
        angles: Any = None,
        length: float | None = None,
        mask: int = ALL_BITS,
    ) -> Handle:
        """Add a reading of a body or joint, for ``World.sensor`` and ``World.sensors``.

        Args:
            kind: what is read, of a body
                "pose": x, y, angle of its own frame, m and rad;
                "velocity": vx, vy of its centre of mass, w, m/s and rad/s;
                "contact": touching (0 or 1), force x, y on it, the mean of the last step, N;
                "frame": of a site on it, x, y m, cos, sin of its angle, the site's velocity along
                the body's own axes m/s, w rad/s;
                "rays": how far it sees from a site, m, one number a ray: the distance to the
                first shape of another body, ``length`` where there is none, 0 inside a shape;
                of a joint "joint": coordinate, rate, reaction force x, y N, torque N m.
            local_position: m, the site in the body's own frame; default its origin.
            angles: rad, (ray,) directions in the body's own frame.
            length: m, how far the rays look.
            mask: categories of shapes that the rays see; they never see sensor shapes.
        """
        what = f"sensor {name!r}"
        name = check.unique(name, self.sensors, "sensor")
        b = -1 if body is None else self._body(body, what)
        j = -1 if joint is None else find(joint, "joint", list(self.joints), what)
        self.sensors[name] = sensor_spec(name, kind, b, j, local_position, angles, length, mask, self.dim)
        return Handle("sensor", name, len(self.sensors) - 1)

    def exclude(self, body_a: Handle | str | int, body_b: Handle | str | int) -> None:
        """Keep two bodies from colliding with each other."""
        a = self._body(body_a, "exclude")
        b = self._body(body_b, "exclude")
        if a == b:
            raise ValueError(f"exclude needs two different bodies, got {body_a!r} twice.")
        self.excluded.add((min(a, b), max(a, b)))

    def compile(self) -> Model:
        """The constant part and the nominal values of a world.

        Raises:
            ValueError: a scene without bodies.
        """
        from .compile import compile_scene

        return compile_scene(self)


def find(item: Handle | str | int, what: str, names: Sequence[str], where: str) -> int:
    """Index of a thing given by handle, name or index, or ValueError naming ``where``."""
    if isinstance(item, Handle):
        if item.what != what:
            raise ValueError(f"{where} needs a {what}, got the {item.what} {item.name!r}.")
        if item.index >= len(names) or names[item.index] != item.name:
            raise ValueError(f"{where}: {what} {item.name!r} belongs to another scene.")
        return item.index
    if isinstance(item, str):
        check.choice(item, names, f"{where}: {what}")
        return list(names).index(item)
    if isinstance(item, (int, np.integer)) and 0 <= item < len(names):
        return int(item)
    raise ValueError(f"{where}: {what} {item!r} is unknown.")


def _color(value: Any, what: str) -> tuple[int, int, int]:
    channels = [int(x) for x in check.vector(value, 3, what)]
    if min(channels) < 0 or max(channels) > 255:
        raise ValueError(f"{what} must be three numbers from 0 to 255, got {value!r}.")
    return channels[0], channels[1], channels[2]
