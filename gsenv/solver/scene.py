"""Scene: what a user writes down. ``compile`` turns it into the arrays that the kernels read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import check
from .model import Array, BodyKind, Model

KINDS = {"static": BodyKind.STATIC, "kinematic": BodyKind.KINEMATIC, "dynamic": BodyKind.DYNAMIC}
GRAVITY = {2: (0.0, -9.81), 3: (0.0, 0.0, -9.81)}
AXES = {"x": 0, "y": 1, "angle": 2}
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
    name: str
    kind: BodyKind
    shapes: tuple[Any, ...]
    position: Array
    angle: float
    linear_velocity: Array
    angular_velocity: float
    mass: float | None
    inertia: float | None
    linear_damping: float
    angular_damping: float
    gravity_scale: float
    fast: bool
    enabled: bool
    color: tuple[int, int, int] | None


@dataclass
class JointSpec:
    name: str
    kind: str
    body_a: int
    body_b: int
    anchor_a: Array | None
    anchor_b: Array | None
    frequency: float
    damping_ratio: float
    max_force: float
    max_torque: float
    enabled: bool
    rows: list[dict[str, Any]] = field(default_factory=list)


@dataclass
class ActuatorSpec:
    name: str
    joint: int
    axis: int
    mode: str
    lower: float
    upper: float


@dataclass
class SensorSpec:
    name: str
    kind: str
    body: int


class Scene:
    """Bodies, joints, actuators, sensors and constraints, by name. Compiled when a World is made.

    Args:
        dim: 2; 3 follows.
        gravity: m/s^2, ``dim`` numbers.

    Raises:
        ValueError: on any bad argument of any method, naming it; the scene is then unchanged.
    """

    def __init__(self, dim: int = 2, gravity: Vector | None = None) -> None:
        if dim != 2:
            raise ValueError(f"Scene: dim must be 2, got {dim!r}.")
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
        position: Vector = (0.0, 0.0),
        angle: float = 0.0,
        linear_velocity: Vector = (0.0, 0.0),
        angular_velocity: float = 0.0,
        mass: float | None = None,
        inertia: float | None = None,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
        gravity_scale: float = 1.0,
        fast: bool = False,
        enabled: bool = True,
        color: tuple[int, int, int] | None = None,
    ) -> Handle:
        """Add a rigid body.

        Args:
            kind: "dynamic", "kinematic" (moves at its velocity, feels nothing) or "static".
            shapes: geometry in the body's own frame; a dynamic body needs one with area, or a
                mass and an inertia.
            position: m, where the body's own frame is; the centre of mass follows from the shapes.
            angle: rad.
            linear_velocity: m/s, of the centre of mass; angular_velocity: rad/s.
            mass: kg; None takes it from the shapes' densities.
            inertia: kg m^2 about the centre of mass; None takes it from the shapes, scaled to
                ``mass`` where that is given.
            linear_damping, angular_damping: 1/s.
            fast: swept against everything, never tunnels (dearer; for small or thin and fast).
            enabled: False keeps it out of the world until ``Parameters`` enable it.
            color: RGB for renderers.
        """
        what = f"body {name!r}"
        name = check.unique(name, self.bodies, "body")
        spec = BodySpec(
            name=name,
            kind=KINDS[check.choice(kind, KINDS, f"{what}: kind")],
            shapes=tuple(shapes) if isinstance(shapes, (list, tuple)) else (shapes,),
            position=check.vector(position, self.dim, f"{what}: position"),
            angle=check.finite(angle, f"{what}: angle"),
            linear_velocity=check.vector(linear_velocity, self.dim, f"{what}: linear_velocity"),
            angular_velocity=check.finite(angular_velocity, f"{what}: angular_velocity"),
            mass=None if mass is None else check.positive(mass, f"{what}: mass"),
            inertia=None if inertia is None else check.positive(inertia, f"{what}: inertia"),
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
        frequency: float | None = None,
        damping_ratio: float = 1.0,
        max_force: float = np.inf,
        max_torque: float = np.inf,
        collide: bool = False,
        enabled: bool = True,
    ) -> Handle:
        """Add a joint.

        Args:
            kind: "weld" (holds body_b fixed to body_a) or "target" (pulls body_b to a moving pose
                in the world by a spring of bounded force; needs no body_a).
            anchor: m, world point at the authored poses; or anchor_a, anchor_b in the bodies' own
                frames. Default: the origin of body_b.
            frequency: Hz, damping_ratio: of the spring; None is rigid for a weld, 5 Hz for a target.
            max_force, max_torque: N and N m, bounds of a target.
            collide: whether the two bodies collide with each other.
        """
        what = f"joint {name!r}"
        name = check.unique(name, self.joints, "joint")
        check.choice(kind, ("weld", "target"), f"{what}: kind")
        if body_b is None:
            raise ValueError(f"{what}: body_b is missing.")
        b = self._body(body_b, what)
        if kind == "target":
            a = b
        elif body_a is None:
            raise ValueError(f"{what}: body_a is missing.")
        else:
            a = self._body(body_a, what)
            if a == b:
                raise ValueError(f"{what} needs two different bodies, got {body_b!r} twice.")
        unused: dict[str, Any] = {}
        if kind == "target":
            unused = {"body_a": body_a, "anchor_a": anchor_a}
        if kind == "weld":
            unused = {
                name: value for name, value in (("max_force", max_force), ("max_torque", max_torque)) if value != np.inf
            }
        for word, value in unused.items():
            if value is not None:
                raise ValueError(f"{what}: a {kind} has no {word}, got {value!r}.")
        if frequency is None:
            frequency = 5.0 if kind == "target" else 0.0
        if kind == "target" and list(self.bodies.values())[b].kind != BodyKind.DYNAMIC:
            raise ValueError(f"{what}: a target pulls a dynamic body, got {body_b!r}.")
        if kind == "target":
            check.positive(frequency, f"{what}: frequency")
        anchors = [
            None if value is None else check.vector(value, self.dim, f"{what}: {label}")
            for value, label in ((anchor_a, "anchor_a"), (anchor_b, "anchor_b"))
        ]
        if anchor is not None:
            point = check.vector(anchor, self.dim, f"{what}: anchor")
            bodies = list(self.bodies.values())
            from .compile import local_point

            anchors = [local_point(bodies[a], point), local_point(bodies[b], point)]
        spec = JointSpec(
            name, kind, a, b, anchors[0], anchors[1],
            check.not_negative(frequency, f"{what}: frequency"),
            check.not_negative(damping_ratio, f"{what}: damping_ratio"),
            check.bound(max_force, f"{what}: max_force"),
            check.bound(max_torque, f"{what}: max_torque"),
            bool(enabled),
        )  # fmt: skip
        self.joints[name] = spec
        if not collide and a != b:
            self.excluded.add((min(a, b), max(a, b)))
        return Handle("joint", name, len(self.joints) - 1)

    def add_constraint(
        self,
        name: str,
        bodies: Sequence[Handle | str | int],
        jacobian: Any,
        lower: Any = -np.inf,
        upper: Any = np.inf,
        bias: Any = 0.0,
        softness: Any = 0.0,
        enabled: bool = True,
    ) -> Handle:
        """Add a rule of your own: rows ``J v + bias + softness * impulse`` in the world frame.

        Args:
            bodies: one or two.
            jacobian: (row, bodies * 3) in 2D: [vx, vy, w] of each body; at most 3 rows.
            lower, upper: N or N m, bounds of the rows' forces: a lock has none, a limit one-sided
                ones, a motor both.
            bias: m/s; softness: 1/kg.
        """
        what = f"constraint {name!r}"
        name = check.unique(name, self.joints, "constraint")
        if isinstance(bodies, (Handle, str, int)):
            bodies = (bodies,)
        index = [self._body(body, what) for body in bodies]
        if len(index) not in (1, 2) or len(set(index)) != len(index):
            raise ValueError(f"{what} needs one body or two different ones, got {len(index)}.")
        ndof = 3
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
        self.joints[name] = JointSpec(
            name, "rows", index[0], index[-1], None, None, 0.0, 0.0, 0.0, 0.0, bool(enabled), made
        )
        return Handle("joint", name, len(self.joints) - 1)

    def add_actuator(
        self,
        name: str,
        joint: Handle | str | int,
        axis: str,
        mode: str = "velocity",
        lower: float = -np.inf,
        upper: float = np.inf,
    ) -> Handle:
        """Let one entry of ``World.control`` drive one coordinate of a target joint.

        Args:
            axis: "x", "y" (m or m/s) or "angle" (rad or rad/s).
            mode: "velocity" moves the target at the control's speed, "position" puts it there.
            lower, upper: the control is clipped to this range.
        """
        what = f"actuator {name!r}"
        name = check.unique(name, self.actuators, "actuator")
        index = find(joint, "joint", list(self.joints), what)
        if list(self.joints.values())[index].kind != "target":
            raise ValueError(f"{what} needs a target joint, got {joint!r}.")
        number = AXES[check.choice(axis, AXES, f"{what}: axis")]
        check.choice(mode, ("velocity", "position"), f"{what}: mode")
        low = float(check.bounds(lower, (), f"{what}: lower"))
        high = float(check.bounds(upper, (), f"{what}: upper"))
        check.ordered_bounds(np.array(low), np.array(high), what)
        self.actuators[name] = ActuatorSpec(name, index, number, mode, low, high)
        return Handle("actuator", name, len(self.actuators) - 1)

    def add_sensor(self, name: str, kind: str, body: Handle | str | int) -> Handle:
        """Add a reading: "pose" (x, y, angle), "velocity" (vx, vy, w) or "contact" (touching,
        force x, force y of the last step) of a body."""
        what = f"sensor {name!r}"
        name = check.unique(name, self.sensors, "sensor")
        check.choice(kind, ("pose", "velocity", "contact"), f"{what}: kind")
        self.sensors[name] = SensorSpec(name, kind, self._body(body, what))
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
