"""The records of a world: Model (constant), Parameters and State (per world); scratch_dtypes.py has those of a step.

Each kind of item has one structured array, ``(world, item)`` for quantities that differ from world to
world and ``(item,)`` for constant ones.  Field lengths depend on the dimension alone, never on the size
of a scene, so a kernel is compiled once for all scenes.  ``dim`` is 2 or 3; ``ndof`` is 3 or 6.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

NDOF = {2: 3, 3: 6}
ROTATION_SIZE = {2: 2, 3: 4}  # (cos, sin) or a quaternion (w, x, y, z)
CONTACT_ROWS = {2: 2, 3: 6}  # at most: normal, tangents, and in 3D one of torsion and two of rolling
ROWS_PER_JOINT = {2: 7, 3: 11}  # at most: rows of the joint itself, limit, motor, spring, friction, armature


class BodyKind(IntEnum):
    STATIC = 0  # never moves
    KINEMATIC = 1  # moves at a given velocity, unaffected by forces
    DYNAMIC = 2  # moves by forces


class JointKind(IntEnum):
    """Kinds of 2D and 3D; the first three need no joint factor."""

    ROWS = 0  # user constraint
    WELD = 1
    TARGET = 2
    REVOLUTE = 3  # 2D
    PRISMATIC = 4  # 2D
    DISTANCE = 5
    WHEEL = 6
    GEAR = 7
    BALL = 8  # 3D
    HINGE = 9  # 3D
    SLIDER = 10  # 3D
    UNIVERSAL = 11  # 3D
    SIX_AXIS = 12  # 3D
    AXIS = 13  # 3D: one coordinate of a joint that has several


class ActuatorMode(IntEnum):
    VELOCITY = 0
    POSITION = 1
    TORQUE = 2


def body_model_dtype() -> np.dtype[Any]:
    """Return the dtype of the constant data of a body."""
    return np.dtype(
        [
            ("kind", "i4"),  # BodyKind
            ("continuous", "i4"),  # 1: continuous collision with all other bodies, never tunnels
            ("jointed", "i4"),  # 1: has a joint, so other bodies affect its path
            ("shape_first", "i4"),
            ("shape_count", "i4"),
        ],
        align=True,
    )


def shape_model_dtype() -> np.dtype[Any]:
    """Return the dtype of the constant data of a shape."""
    return np.dtype(
        [
            ("kind", "i4"),  # ShapeKind of its dimension
            ("body", "i4"),
            ("category", "i8"),  # bits of its own categories
            ("mask", "i8"),  # bits of the categories that it collides with
            ("sensor", "i4"),  # 1: reports contacts without forces
            ("vertex_first", "i4"),
            ("vertex_count", "i4"),
        ],
        align=True,
    )


def body_parameter_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the parameters of a body, which may differ from world to world."""
    inertia = () if dim == 2 else (3,)
    axes: list[Any] = [] if dim == 2 else [("axes", "f8", (4,))]  # principal axes in the body's own frame
    return np.dtype(
        [
            ("mass", "f8"),  # kg
            ("inertia", "f8", inertia),  # kg m^2 about the centre of mass, in 3D about the principal axes
            ("inv_mass", "f8"),  # 1/kg, 0 unless dynamic and enabled
            ("inv_inertia", "f8", inertia),  # 1/(kg m^2)
            *axes,
            ("center", "f8", (dim,)),  # m, centre of mass in the body's own frame
            ("linear_damping", "f8"),  # 1/s
            ("angular_damping", "f8"),  # 1/s
            ("gravity_scale", "f8"),
            ("extent", "f8"),  # m, smallest half-width of its shapes, the length scale of the body
            ("radius", "f8"),  # m, distance of the farthest point from the centre of mass
            ("enabled", "i4"),
        ],
        align=True,
    )


def shape_parameter_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the parameters of a shape, which may differ from world to world."""
    rolling: list[Any] = [] if dim == 2 else [("torsional_friction", "f8"), ("rolling_friction", "f8")]  # m
    return np.dtype(
        [
            ("local_position", "f8", (dim,)),  # m, in the body's own frame
            ("local_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("size", "f8", (dim,)),  # m, half-extents; a capsule's half-length is size[0], in 3D size[2]
            ("radius", "f8"),  # m, of round shapes, else 0
            ("extent", "f8"),  # m, smallest half-width
            ("friction", "f8"),
            *rolling,
            ("restitution", "f8"),
            ("density", "f8"),  # kg/m^2 or kg/m^3
            ("enabled", "i4"),
        ],
        align=True,
    )


def solid_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the mass properties that follow from a shape's size and density; see core/edit.py."""
    inertia = () if dim == 2 else (3,)
    return np.dtype(
        [
            ("extent", "f8"),  # m, smallest half-width; negative: as it was
            ("reach", "f8"),  # m, farthest point from the shape's own middle
            ("mass", "f8"),  # kg
            ("inertia", "f8", inertia),  # kg m^2, in 3D about the principal axes
        ],
        align=True,
    )


def world_parameter_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the parameters of a world."""
    return np.dtype([("gravity", "f8", (dim,))], align=True)  # m/s^2


def body_state_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the state of a body."""
    return np.dtype(
        [
            ("position", "f8", (dim,)),  # m, centre of mass
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("angle", "f8"),  # rad, unwrapped (2D)
            ("velocity", "f8", (NDOF[dim],)),  # m/s and rad/s: [vx, vy, w] or [v, w]
            ("force", "f8", (NDOF[dim],)),  # N and N m, applied in the next step and then cleared
            ("sleep_time", "f8"),  # s at rest so far
            ("travel", "f8"),  # m, bound of the path of its fastest point, summed over all steps
            ("asleep", "i4"),
        ],
        align=True,
    )


def contact_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a contact. Contacts are sorted by (shape_a, shape_b, feature); normals point from a to b."""
    rolling: list[Any] = [] if dim == 2 else [("torsional_friction", "f8"), ("rolling_friction", "f8")]  # m
    return np.dtype(
        [
            ("shape_a", "i4"),
            ("shape_b", "i4"),
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("feature", "i4"),  # id of the touching corner, edge or face, equal from step to step
            ("sensor", "i4"),  # 1: no rows
            ("face", "i4"),  # which shape's face has the normal, which turns with it; see core/faces.py
            ("point", "f8", (dim,)),  # m
            ("normal", "f8", (dim,)),  # unit, from a to b
            ("separation", "f8"),  # m, negative for an overlap; see core/contact_rows.py for its value within a step
            ("start_separation", "f8"),  # m, at the start of the step
            ("core_distance", "f8"),  # m, from the point into the shape without the face, to what is fixed on its body
            ("friction", "f8"),
            *rolling,
            ("restitution", "f8"),
            ("extent", "f8"),  # m, length scale of the pair
            ("travel", "f8"),  # m, sum of its bodies' when the narrowphase found it
            ("form", "f8"),  # code of the forms of its shapes then; see core/recycling.py
            ("miss_distance", "f8"),  # m, distance by which a candidate for a secondary impact misses, else 0
            ("impulse", "f8", (CONTACT_ROWS[dim],)),  # N s, from which the next substep starts: normal, then tangents
            ("total_impulse", "f8", (CONTACT_ROWS[dim],)),  # N s, summed over the step
            # N m s, moments of these about the centres of a and b, beyond those at the arms of the start of the step
            ("moments", "f8", (2, NDOF[dim] - dim)),
        ],
        align=True,
    )


def world_state_dtype() -> np.dtype[Any]:
    """Return the dtype of a world's counters and residuals of its last step."""
    return np.dtype(
        [
            ("step", "i8"),  # steps taken since reset
            ("contact_count", "i4"),
            ("awake_count", "i4"),  # bodies of awake islands
            ("pair_count", "i4"),
            ("row_count", "i4"),  # of the last step, all islands
            ("island_count", "i4"),
            ("sweeps", "i4"),  # of the last step, all islands and substeps
            ("unconverged", "i4"),  # island substeps that ran out of sweeps
            ("impacts", "i4"),
            ("residual", "f8"),  # largest residual at which a solve of the step stopped
            ("natural_residual", "f8"),  # natural-map residual of the last substep, all islands
        ],
        align=True,
    )


def joint_model_dtype() -> np.dtype[Any]:
    """Return the dtype of the constant data of a joint."""
    return np.dtype(
        [
            ("kind", "i4"),  # JointKind of its dimension
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("joint_a", "i4"),  # of gears: the coupled joints; of an axis: the joint that it belongs to
            ("joint_b", "i4"),
            ("row_first", "i4"),  # of user constraints: first of their rows in the parameters
            ("row_count", "i4"),  # rows besides those of limit, motor, spring and friction
            ("driven", "i4"),  # 1: a target, actuated or with an update function, so its island never sleeps
            ("effort_controlled", "i4"),  # 1: an actuator sets the effort of the motor instead of its speed
            ("frame", "i4"),  # of user constraints: 1 = directions fixed in body_a
            ("repeats", "i4"),  # the joint that holds all that this one holds, so that it needs no rows; -1: none
            ("locked", "i4"),  # 3D: bits of the locked axes, 0 to 2 translations, 3 to 5 rotations
            ("coordinate", "i4"),  # 3D: number of the coordinate of limit and spring (spatial/joints/axes.py); -1: none
            ("motor_coordinate", "i4"),  # 3D: of motor and friction
        ],
        align=True,
    )


def joint_parameter_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the parameters of a joint, which may differ from world to world."""
    frame: list[Any] = [] if dim == 2 else [("frame", "f8", (4,))]  # rotation of the joint's axes in body a
    return np.dtype(
        [
            ("anchor_a", "f8", (dim,)),  # m, in the body's own frame
            ("anchor_b", "f8", (dim,)),
            ("axis", "f8", (dim,)),  # unit, in the frame of body a
            ("reference", "f8", (ROTATION_SIZE[dim],)),  # rotation of b in a where the joint is at rest
            *frame,
            ("reference_angle", "f8"),  # rad, the same angle, unwrapped (2D); of gears the coupled coordinate
            ("length", "f8"),  # m, of distance joints
            ("lower", "f8"),  # m or rad, limits of the coordinate; infinite: none
            ("upper", "f8"),
            ("limit_restitution", "f8"),
            ("limit_frequency", "f8"),  # Hz, of a soft limit on the effective mass of the coordinate; 0: rigid
            ("limit_damping_ratio", "f8"),
            ("frequency", "f8"),  # Hz, of the spring on the effective mass of the row
            ("damping_ratio", "f8"),
            ("stiffness", "f8"),  # N/m or N m/rad; replaces the frequency where it or the damping is positive
            ("damping", "f8"),  # N s/m or N m s/rad
            ("spring_effort", "f8"),  # N or N m, largest effort of the spring
            ("motor_effort", "f8"),  # N or N m, largest effort of the motor; 0: no motor
            ("motor_gain", "f8"),  # N s/m or N m s/rad, effort for each unit of the error of speed; infinite: rigid
            ("friction_effort", "f8"),  # N or N m, dry friction of the joint
            ("armature", "f8"),  # kg or kg m^2, inertia of the rotor that turns with the coordinate
            ("max_force", "f8"),  # N, of targets
            ("max_torque", "f8"),  # N m
            ("ratio", "f8"),  # of gears, q_a + ratio q_b is constant
            ("rigid", "i4"),  # 1: no spring
            ("enabled", "i4"),
        ],
        align=True,
    )


def joint_state_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the state of a joint."""
    turn: list[Any] = (
        []
        if dim == 2
        else [
            ("target_rotation", "f8", (4,)),  # of target joints
            ("angle", "f8"),  # rad, unwrapped coordinate of a rotation at the start of the last substep
        ]
    )
    return np.dtype(
        [
            ("impulse", "f8", (ROWS_PER_JOINT[dim],)),  # N s and N m s of the last substep; armature has the last slot
            ("rate", "f8"),  # rad/s or m/s of the rotor of a joint with armature
            ("total_impulse", "f8", (ROWS_PER_JOINT[dim],)),  # summed over the step
            ("reaction", "f8", (NDOF[dim],)),  # N s and N m s on body b at its anchor, summed over the step
            ("credit", "f8"),  # J that its island may gain by errors of time steps; see core/step_energy.py
            ("motor_speed", "f8"),  # m/s or rad/s
            ("rest", "f8"),  # m or rad, coordinate at which the spring is relaxed
            ("effort", "f8"),  # N or N m, of a motor driven by a torque actuator
            ("target_position", "f8", (dim,)),  # m, of target joints
            ("target_angle", "f8"),  # rad, unwrapped (2D)
            *turn,
            ("target_velocity", "f8", (NDOF[dim],)),  # m/s and rad/s
        ],
        align=True,
    )


ACTUATOR_DTYPE = np.dtype(
    [
        ("joint", "i4"),
        ("body", "i4"),  # body_b of the joint
        ("axis", "i4"),  # index of a target's coordinate; -1: the coordinate of another joint
        ("mode", "i4"),  # ActuatorMode, the quantity that the control sets
        ("lower", "f8"),  # control is clipped to [lower, upper]
        ("upper", "f8"),
        ("gain", "f8"),  # what is set: gain * control + offset
        ("offset", "f8"),
    ],
    align=True,
)


def constraint_row_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of one row of a user constraint."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("jacobian_a", "f8", (ndof,)),
            ("jacobian_b", "f8", (ndof,)),
            ("lower", "f8"),  # N or N m
            ("upper", "f8"),
            ("bias", "f8"),  # m/s or rad/s
            ("softness", "f8"),  # 1/kg or 1/(kg m^2), factor of the impulse
            ("error", "f8"),  # m or rad, reduced by the position pass
        ],
        align=True,
    )


@dataclass(frozen=True)
class Model:
    """A compiled scene: the data that all worlds share, and the nominal values of parameters and state.

    ``nominal`` and ``start`` arrays have one entry for each item and no world axis; Parameters and State
    start as copies of them.
    """

    dim: int
    body_names: tuple[str, ...]
    joint_names: tuple[str, ...]
    actuator_names: tuple[str, ...]
    sensor_names: tuple[str, ...]
    shape_names: tuple[str, ...]
    bodies: Array  # body_model_dtype (body,)
    shapes: Array  # shape_model_dtype (shape,)
    joints: Array  # joint_model_dtype (joint,)
    actuators: Array  # ACTUATOR_DTYPE (actuator,)
    sensors: Array  # sensor_dtype (sensor,)
    sensor_rays: Array  # (ray, dim) unit directions in the frames of the sensors' bodies
    exclusions: Array  # int64, encoded body pairs, sorted
    trees: Array  # TREE_DTYPE (body,)
    nominal_world: Array  # world_parameter_dtype ()
    nominal_bodies: Array  # body_parameter_dtype (body,)
    nominal_shapes: Array  # shape_parameter_dtype (shape,)
    nominal_joints: Array  # joint_parameter_dtype (joint,)
    nominal_rows: Array  # constraint_row_dtype (row,)
    nominal_vertices: Array  # vertex dtype of the dimension (vertex,)
    start_bodies: Array  # body_state_dtype (body,)
    start_joints: Array  # joint_state_dtype (joint,)
    updates: tuple[tuple[int, Callable[[Any], Mapping[str, Any]]], ...]  # (joint, function of the world)
    mass_given: Array  # bool (body,): mass was given, not derived from density
    inertia_given: Array  # bool (body,)
    shape_colors: Array | None  # uint8 (shape, 3), 0, 0, 0 where none is given; or None
    needs_vertices: bool  # the scene has polygons or terrain, in 3D hulls or heightfields
    needs_fields: bool  # the scene has heightfields
    needs_convex: bool  # the scene has cylinders or hulls

    @property
    def has_joints(self) -> bool:
        return len(self.joints) > 0

    @property
    def is_linked(self) -> bool:
        """Whether there are joints other than user constraints, welds and targets, which need further compiled code."""
        return bool((self.joints["kind"] > JointKind.TARGET).any())

    @property
    def has_trees(self) -> bool:
        """Whether there are rigid joints that can be solved in joint coordinates."""
        return bool((self.trees["joint"] >= 0).any())

    def parts_of(self, joint: int) -> Array:
        """Return the indices of the joints that are coordinates of a joint."""
        return np.flatnonzero((self.joints["kind"] == JointKind.AXIS) & (self.joints["joint_a"] == joint))

    @property
    def has_axes(self) -> bool:
        """Whether there are 3D joints with axes or gears, which need further compiled code."""
        kinds = self.joints["kind"]
        return self.dim == 3 and bool(
            ((kinds > JointKind.BALL) | np.isin(kinds, (JointKind.WHEEL, JointKind.GEAR))).any()
        )

    @property
    def sensor_slices(self) -> dict[str, slice]:
        """Columns of each sensor in ``World.sensors()``, by name, in the order of the scene."""
        ends = np.cumsum(self.sensors["count"]).tolist()
        return {name: slice(a, b) for name, a, b in zip(self.sensor_names, [0, *ends], ends, strict=False)}

    @cached_property
    def digest(self) -> str:
        """Hex digest of the scene's topology, which must be equal for a snapshot to fit."""
        h = hashlib.sha256(repr((self.dim, self.body_names, self.joint_names)).encode())
        for array in (self.bodies, self.shapes, self.joints, self.actuators, self.exclusions):
            for name in array.dtype.names or ():
                h.update(np.ascontiguousarray(array[name]).tobytes())
            if not array.dtype.names:
                h.update(array.tobytes())
            h.update(b";")
        return h.hexdigest()
