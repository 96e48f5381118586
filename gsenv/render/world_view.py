"""Reads from a 2D World what its picture shows; no other 2D render module knows how a World stores it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.api.world import World
from gsenv.solver.planar.kinds import ShapeKind
from gsenv.solver.records.model import BodyKind, JointKind

FloatArray = NDArray[np.float64]

STRUT_REACH = 1.65  # length of a wheel's drawn suspension, in wheel radii, so that it shows above the wheel
SPRING_SLIMNESS = 0.12  # half width of a drawn spring over its length outside the bodies
SPRING_REACH = 6.0  # drawn length of a spring without limits, in half widths of the body


class ShapeTable(NamedTuple):
    """Constant fields of shapes; (shape,) arrays."""

    kinds: NDArray[np.int32]  # ShapeKind
    bodies: NDArray[np.int32]
    vertex_first: NDArray[np.int32]
    vertex_count: NDArray[np.int32]
    static: NDArray[np.bool_]
    sensor: NDArray[np.bool_]
    closed: NDArray[np.bool_]  # terrains only
    colors: NDArray[np.uint8] | None  # (shape, 3)


class ShapeState(NamedTuple):
    """Shapes of one world, in the world's frame."""

    position: FloatArray  # (shape, 2) m
    rotation: FloatArray  # (shape, 2) cos, sin
    size: FloatArray  # (shape, 2) m
    radius: FloatArray  # (shape,) m
    enabled: NDArray[np.bool_]  # (shape,)
    vertices: FloatArray  # (vertex, 2) m, in the frames of their shapes


class JointTable(NamedTuple):
    """Constant fields of joints; (joint,) arrays."""

    kinds: tuple[str, ...]  # "revolute", "distance", ...
    body_a: NDArray[np.int32]
    body_b: NDArray[np.int32]
    fixed: NDArray[np.bool_]  # body a is static
    has_spring: NDArray[np.bool_]  # has a spring
    rigid: NDArray[np.bool_]  # a distance joint is a rod
    size: FloatArray  # m, length scale of the drawing: half width of the slimmer moving body; inf if neither moves
    span: FloatArray  # m, distance of body b's farthest point from its anchor
    mount: FloatArray  # m along the axis, end on body a of a spring along the axis


class JointState(NamedTuple):
    """Joints of one world, in the world's frame."""

    anchor_a: FloatArray  # (joint, 2) m
    anchor_b: FloatArray  # (joint, 2) m
    axis: FloatArray  # (joint, 2) unit; joints that slide along an axis
    lower: FloatArray  # (joint,) m, lower limit of the translation or distance; -inf: none
    upper: FloatArray  # (joint,) m, upper limit; inf: none
    goal: FloatArray  # (joint, 2) m; position of a target joint's target
    down: FloatArray  # (2,) unit, direction of gravity
    enabled: NDArray[np.bool_]  # (joint,); the joint and both bodies are enabled


class Frames(NamedTuple):
    """Coordinate frames in the world."""

    position: FloatArray  # (frame, 2) m
    rotation: FloatArray  # (frame, 2) cos, sin


def rotate(rotation: FloatArray, vectors: FloatArray) -> FloatArray:
    """Rotate (..., 2) vectors by (..., 2) (cos, sin); a complex product is the fastest way."""
    a = np.ascontiguousarray(rotation, np.float64).view(np.complex128)
    b = np.ascontiguousarray(vectors, np.float64).view(np.complex128)
    turned: FloatArray = (a * b).view(np.float64)
    return turned


def read_table(world: World) -> ShapeTable:
    """Return the constant fields of all shapes."""
    shapes = world.model.shapes
    static = world.model.bodies["kind"] == BodyKind.STATIC
    kinds, first, count = shapes["kind"], shapes["vertex_first"], shapes["vertex_count"]
    closed = np.zeros(len(shapes), bool)
    for k in np.flatnonzero(kinds == ShapeKind.TERRAIN):
        closed[k] = world.model.nominal_vertices["next"][first[k] + count[k] - 1] >= 0
    return ShapeTable(
        kinds=kinds,
        bodies=shapes["body"],
        vertex_first=first,
        vertex_count=count,
        static=static[shapes["body"]],
        sensor=shapes["sensor"] != 0,
        closed=closed,
        colors=world.model.shape_colors,
    )


def read_bodies(world: World, index: int) -> Frames:
    """Return the body frames (body,) of one world."""
    states = world.state.bodies[index]
    rotation = states["rotation"]
    center = rotate(rotation, world.parameters.bodies[index]["center"])
    return Frames(states["position"] - center, rotation)


def read_state(world: World, index: int, table: ShapeTable, bodies: Frames) -> ShapeState:
    """Return the poses and sizes of one world's shapes."""
    parameters = world.parameters
    shapes = parameters.shapes[index]
    rotation = bodies.rotation[table.bodies]
    offset = rotate(rotation, shapes["local_position"])
    enabled = (shapes["enabled"] != 0) & (parameters.bodies[index]["enabled"] != 0)[table.bodies]
    return ShapeState(
        position=bodies.position[table.bodies] + offset,
        rotation=rotate(rotation, shapes["local_rotation"]),
        size=shapes["size"],
        radius=shapes["radius"],
        enabled=enabled,
        vertices=parameters.vertices[index]["position"],
    )


def read_time(world: World, index: int) -> float:
    """Return the time in s since the last reset."""
    return float(world.time[index])


def read_contacts(world: World, index: int) -> tuple[FloatArray, FloatArray]:
    """Return points (contact, 2) in m and mean forces (contact, 2) in N of the touching contacts."""
    contacts: Any = world.contacts(index)
    touching = contacts.touching & ~contacts.sensor
    return contacts.point[touching], contacts.force_vector(world.timestep)[touching]


def read_joint_table(world: World) -> JointTable:
    """Return the constant fields of all joints."""
    model = world.model
    joints, nominal = model.joints, model.nominal_joints
    has_spring = (nominal["frequency"] > 0.0) | (nominal["stiffness"] > 0.0)
    size = find_sizes(world, has_spring & (joints["kind"] == JointKind.DISTANCE))
    arm = nominal["anchor_b"] - model.nominal_bodies["center"][joints["body_b"]]
    return JointTable(
        kinds=tuple(JointKind(kind).name.lower() for kind in joints["kind"]),
        body_a=joints["body_a"],
        body_b=joints["body_b"],
        fixed=model.bodies["kind"][joints["body_a"]] == BodyKind.STATIC,
        has_spring=has_spring,
        rigid=nominal["rigid"] != 0,
        size=size,
        span=np.hypot(*arm.T) + model.nominal_bodies["radius"][joints["body_b"]],
        mount=find_mounts(world, size),
    )


def find_sizes(world: World, springs: NDArray[np.bool_]) -> FloatArray:
    """Return (joint,) m, the length scale of each joint's drawing; inf where nothing limits it.

    It is the half width of the slimmer moving body. For springs it is also bounded by their length
    outside the bodies, and more tightly where many meet at a body, so that a net of springs stays readable.
    """
    model = world.model
    bodies = np.stack([model.joints["body_a"], model.joints["body_b"]])
    extent = np.zeros(len(model.bodies))
    np.maximum.at(extent, model.shapes["body"], model.nominal_shapes["extent"])
    extent[model.bodies["kind"] == BodyKind.STATIC] = 0.0
    size = np.where(extent > 0.0, extent, np.inf)[bodies].min(axis=0)
    length = model.nominal_joints["length"]
    length = np.maximum(length - extent[bodies].sum(axis=0), 0.3 * length)
    meeting = np.bincount(bodies[:, springs].ravel(), minlength=len(extent))
    crowd = np.where(extent > 0.0, meeting, 0)[bodies].max(axis=0)
    slim = SPRING_SLIMNESS * length * np.sqrt(2.0 / np.maximum(crowd, 2))
    slim = np.maximum(slim, np.where(np.isfinite(size), 0.1 * size, 0.0))
    return np.where(springs & (slim > 0.0), np.minimum(size, slim), size)


def find_mounts(world: World, size: FloatArray) -> FloatArray:
    """Return (joint,) m along the axis: struts end above their wheel, other springs at the limit of translation."""
    model = world.model
    joints, nominal = model.joints, model.nominal_joints
    radius = np.zeros(len(model.bodies))
    np.maximum.at(radius, model.shapes["body"], model.nominal_shapes["radius"])
    half = np.maximum(radius[joints["body_b"]], np.where(np.isfinite(size), size, 0.0))
    inward = model.nominal_bodies["center"][joints["body_a"]] - nominal["anchor_a"]
    side = np.where((inward * nominal["axis"]).sum(axis=1) < 0.0, -1.0, 1.0)
    lower, upper = nominal["lower"], nominal["upper"]
    end = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper, -SPRING_REACH * half))
    return np.where(joints["kind"] == JointKind.WHEEL, STRUT_REACH * half * side, end)


def find_wheels(world: World) -> NDArray[np.bool_]:
    """Return (shape,) bool: circles that rotate about their centres on wheel or revolute joints."""
    shapes, nominal = world.model.shapes, world.model.nominal_shapes
    wheels = np.zeros(len(shapes), bool)
    for joint, parameters in zip(world.model.joints, world.model.nominal_joints, strict=True):
        if joint["kind"] in (JointKind.WHEEL, JointKind.REVOLUTE):
            off = np.hypot(*(nominal["local_position"] - parameters["anchor_b"]).T)
            wheels |= (shapes["body"] == joint["body_b"]) & (off <= 0.01 * nominal["radius"])
    return wheels & (shapes["kind"] == ShapeKind.CIRCLE)


def read_joints(world: World, index: int, table: JointTable, bodies: Frames) -> JointState:
    """Return anchors, axes and limits of one world's joints."""
    parameters = world.parameters.joints[index]
    present = world.parameters.bodies[index]["enabled"] != 0
    rotation_a = bodies.rotation[table.body_a]
    anchor_a = rotate(rotation_a, parameters["anchor_a"])
    anchor_b = rotate(bodies.rotation[table.body_b], parameters["anchor_b"])
    gravity = world.parameters.worlds[index]["gravity"]
    gravity_norm = np.hypot(*gravity)
    return JointState(
        anchor_a=bodies.position[table.body_a] + anchor_a,
        anchor_b=bodies.position[table.body_b] + anchor_b,
        axis=rotate(rotation_a, parameters["axis"]),
        lower=parameters["lower"],
        upper=parameters["upper"],
        goal=world.state.joints[index]["target_position"],
        down=gravity / gravity_norm if gravity_norm > 0.0 else np.array([0.0, -1.0]),
        enabled=(parameters["enabled"] != 0) & present[table.body_a] & present[table.body_b],
    )


def read_joint_frames(world: World, index: int, bodies: Frames) -> Frames:
    """Return the frames (joint,) at the anchors on body b of enabled joints."""
    joints = world.model.joints
    enabled = world.parameters.joints[index]["enabled"] != 0
    of_joint = joints["body_b"][enabled]
    rotation = bodies.rotation[of_joint]
    anchors = world.parameters.joints[index]["anchor_b"][enabled]
    return Frames(bodies.position[of_joint] + rotate(rotation, anchors), rotation)
