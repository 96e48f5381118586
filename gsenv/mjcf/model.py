"""MjcfModel: what a file says, checked and with all defaults filled in, and nothing of the engine.

Units are SI and rad, quaternions (w, x, y, z). Lists have MuJoCo's order: bodies depth first, the geoms, joints and
sites of a body together.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..solver.records.model import Array
from .errors import Place
from .frames import Pose

Range = tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class Inertia:
    """Mass properties of a body or geom.

    Attributes:
        mass: kg.
        center: (3,) m, centre of mass in the body's own frame.
        tensor: (3, 3) kg m^2 about the centre of mass, in the axes of the body's own frame.
    """

    mass: float
    center: Array
    tensor: Array


NO_INERTIA = Inertia(0.0, np.zeros(3), np.zeros((3, 3)))


@dataclass(eq=False)
class Body:
    """A body; the world is body 0.

    Attributes:
        parent: index of its parent, -1 of the world.
        pose: in its parent's frame where all joints are at their references.
        world_pose: the same in the world.
        gravity_compensation: share of its weight that is compensated.
        mocap: whether it is moved by the user.
    """

    name: str
    parent: int
    pose: Pose
    world_pose: Pose
    inertia: Inertia
    gravity_compensation: float
    mocap: bool
    place: Place
    explicit_inertia: Inertia | None = None


@dataclass(frozen=True, eq=False)
class Geom:
    """A geometry of a body.

    Attributes:
        kind: plane, sphere, capsule, cylinder, box, ellipsoid, mesh or hfield.
        body: index of its body.
        pose: in the body's own frame; of a mesh, that of the frame that its file is written in.
        size: (3,) m, as MuJoCo's: radius, half length; half extents; semi-axes.
        inertia: in the body's own frame.
        contype, conaffinity: bits; two geoms touch where one's contype meets the other's conaffinity.
        condim: 1 without friction, 3 with, 4 and torsional, 6 and rolling friction.
        friction: (3,) sliding, torsional in m, rolling in m.
        asset: name of its mesh or hfield.
    """

    name: str
    kind: str
    body: int
    pose: Pose
    size: Array
    inertia: Inertia
    group: int
    contype: int
    conaffinity: int
    condim: int
    friction: Array
    rgba: Array
    asset: str
    place: Place


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint between a body and its parent; a body may have several, the first is nearest the parent.

    Attributes:
        kind: free, ball, slide or hinge.
        position: (3,) m, anchor in the body's own frame.
        axis: (3,) unit, in the body's own frame.
        limits: rad or m; of a ball (0, largest angle); None for none.
        reference: rad or m, the coordinate in the initial pose.
        spring_reference: rad or m, the coordinate at which the spring is relaxed.
        stiffness: N/m or N m/rad.
        damping: N s/m or N m s/rad.
        armature: kg or kg m^2, of the rotor.
        friction_loss: N or N m, of dry friction.
        force_range: N or N m, bounds of the actuators' total.
        coordinate, rate: index of its first entry of qpos and of qvel.
    """

    name: str
    kind: str
    body: int
    position: Array
    axis: Array
    limits: Range
    reference: float
    spring_reference: float
    stiffness: float
    damping: float
    armature: float
    friction_loss: float
    force_range: Range
    coordinate: int
    rate: int
    place: Place


@dataclass(frozen=True, eq=False)
class Site:
    """A named frame on a body."""

    name: str
    body: int
    pose: Pose
    size: Array
    kind: str
    place: Place


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera on a body; it looks along -z of its pose, x is to the right.

    Attributes:
        mode: fixed, track, trackcom, targetbody or targetbodycom.
        target: name of the body that it looks at, or empty.
        fovy: rad, vertical field of view.
    """

    name: str
    body: int
    pose: Pose
    mode: str
    target: str
    fovy: float
    place: Place


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh, scaled: vertices (n, 3) m and faces (m, 3), which a mesh of points alone does not have."""

    name: str
    vertices: Array
    faces: Array
    inertia: str
    place: Place


@dataclass(frozen=True, eq=False)
class HeightGrid:
    """A heightfield's heights (rows, columns) in m, row 0 at the lowest y, and full size (2,) m along x and y."""

    name: str
    heights: Array
    size: Array
    place: Place


@dataclass(frozen=True, eq=False)
class Actuator:
    """An actuator with force = gain * control + bias[0] + bias[1] * length + bias[2] * speed.

    Attributes:
        kind: the element's tag, such as motor or position.
        target_kind: joint, jointinparent, tendon, site, body or slider.
        target: its name.
        gear: (6,) length and speed are those of the joint times gear[0].
        affine: whether the formula above holds, without dynamics of its own.
        damping_ratio: of a position actuator, which then has bias[2] = 0: its damping as a share of the critical one.
        control_range, force_range: bounds of the control and of the force.
    """

    name: str
    kind: str
    target_kind: str
    target: str
    gear: Array
    gain: float
    bias: Array
    affine: bool
    control_range: Range
    force_range: Range
    place: Place
    damping_ratio: float = 0.0


@dataclass(frozen=True, eq=False)
class Equality:
    """A constraint between two bodies or two joints.

    Attributes:
        kind: connect, weld or joint.
        first, second: names of bodies or joints, or of sites where ``of_sites``; an empty second body is the world.
        anchor: (3,) m; of a connect in the first body's frame, of a weld in the second's.
        relative_pose: of the second body in the first, None for the initial one.
        coefficients: (5,) of the polynomial that gives the first joint from the second.
        active: whether it holds at the start.
    """

    name: str
    kind: str
    first: str
    second: str
    of_sites: bool
    anchor: Array
    relative_pose: Pose | None
    coefficients: Array
    active: bool
    place: Place


@dataclass(frozen=True, eq=False)
class ContactPair:
    """Two geoms that touch whatever their bits say, with their own material."""

    geom_a: str
    geom_b: str
    condim: int | None
    friction: Array | None
    place: Place


@dataclass(frozen=True)
class Sensor:
    """A sensor: its kind is the element's tag; what it reads, and relative to what, are kinds and names."""

    name: str
    kind: str
    object_kind: str
    object: str
    reference_kind: str
    reference: str
    cutoff: float
    place: Place


@dataclass(frozen=True, eq=False)
class Keyframe:
    """A state: qpos and qvel of all joints, and the controls."""

    name: str
    time: float
    coordinates: Array
    rates: Array
    controls: Array
    place: Place


@dataclass(frozen=True, eq=False)
class Simulation:
    """The element ``option``: timestep in s, gravity (3,) m/s^2, and the medium: density kg/m^3, viscosity Pa s."""

    timestep: float = 0.002
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    density: float = 0.0
    viscosity: float = 0.0
    wind: Array = field(default_factory=lambda: np.zeros(3))
    integrator: str = "Euler"
    contacts: bool = True
    parent_filter: bool = True
    limits: bool = True


@dataclass(eq=False)
class MjcfModel:
    """A whole file.

    Attributes:
        excludes: pairs of bodies, by index, between which there are no contacts.
        warnings: one sentence for each topic that is not honoured.
    """

    name: str
    simulation: Simulation
    bodies: list[Body]
    geoms: list[Geom]
    joints: list[Joint]
    sites: list[Site]
    cameras: list[Camera]
    meshes: dict[str, Mesh]
    grids: dict[str, HeightGrid]
    actuators: list[Actuator] = field(default_factory=list)
    equalities: list[Equality] = field(default_factory=list)
    pairs: list[ContactPair] = field(default_factory=list)
    excludes: list[tuple[int, int]] = field(default_factory=list)
    sensors: list[Sensor] = field(default_factory=list)
    keyframes: list[Keyframe] = field(default_factory=list)
    warnings: tuple[str, ...] = ()

    def joints_of(self, body: int) -> list[Joint]:
        """Return the joints of a body, the one nearest its parent first."""
        return [joint for joint in self.joints if joint.body == body]

    def geoms_of(self, body: int) -> list[Geom]:
        """Return the geoms of a body."""
        return [geom for geom in self.geoms if geom.body == body]

    @property
    def coordinate_count(self) -> int:
        """Length of qpos."""
        return sum(COORDINATES[joint.kind] for joint in self.joints)

    @property
    def rate_count(self) -> int:
        """Length of qvel."""
        return sum(RATES[joint.kind] for joint in self.joints)


COORDINATES = {"free": 7, "ball": 4, "slide": 1, "hinge": 1}
RATES = {"free": 6, "ball": 3, "slide": 1, "hinge": 1}
