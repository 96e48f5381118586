"""What a world is made of: Model (constant), Parameters and State (per world), Workspace (scratch).

Each kind of thing has one structured array, ``(world, item)`` for what differs from world to world
and ``(item,)`` for what does not.  Field lengths depend on the dimension alone, never on the size
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
CONTACT_ROWS = {2: 2, 3: 6}  # at most: normal, tangents, and in space torsion about it and two of rolling
ROWS_PER_JOINT = {2: 5, 3: 8}  # at most: those of the joint itself, limit, motor, spring


class BodyKind(IntEnum):
    STATIC = 0  # never moves
    KINEMATIC = 1  # moves as told, feels nothing
    DYNAMIC = 2


class ActuatorMode(IntEnum):
    VELOCITY = 0
    POSITION = 1
    TORQUE = 2


def body_model_dtype() -> np.dtype[Any]:
    """Constant facts of a body."""
    return np.dtype(
        [
            ("kind", "i4"),  # BodyKind
            ("fast", "i4"),  # 1: swept against everything, never tunnels
            ("jointed", "i4"),  # 1: other bodies bend its path
            ("shape_first", "i4"),
            ("shape_count", "i4"),
        ],
        align=True,
    )


def shape_model_dtype() -> np.dtype[Any]:
    """Constant facts of a shape."""
    return np.dtype(
        [
            ("kind", "i4"),  # ShapeKind of its dimension
            ("body", "i4"),
            ("category", "i8"),  # bit mask: what it is
            ("mask", "i8"),  # bit mask: what it touches
            ("sensor", "i4"),  # 1: reports contacts, pushes nothing
            ("vertex_first", "i4"),
            ("vertex_count", "i4"),
        ],
        align=True,
    )


def body_parameter_dtype(dim: int) -> np.dtype[Any]:
    """What of a body may differ from world to world."""
    inertia = () if dim == 2 else (3,)
    axes: list[Any] = [] if dim == 2 else [("axes", "f8", (4,))]  # principal axes in the body's own frame
    return np.dtype(
        [
            ("mass", "f8"),  # kg
            ("inertia", "f8", inertia),  # kg m^2 about the centre of mass, in 3D about the principal axes
            ("inv_mass", "f8"),  # 0 unless dynamic and enabled
            ("inv_inertia", "f8", inertia),
            *axes,
            ("center", "f8", (dim,)),  # m, centre of mass in the body's own frame
            ("linear_damping", "f8"),  # 1/s
            ("angular_damping", "f8"),  # 1/s
            ("gravity_scale", "f8"),
            ("extent", "f8"),  # m, smallest half-width of its shapes: the body's length scale
            ("radius", "f8"),  # m, farthest point from the centre of mass
            ("enabled", "i4"),
        ],
        align=True,
    )


def shape_parameter_dtype(dim: int) -> np.dtype[Any]:
    """What of a shape may differ from world to world."""
    turning: list[Any] = [] if dim == 2 else [("torsional_friction", "f8"), ("rolling_friction", "f8")]  # m
    return np.dtype(
        [
            ("local_position", "f8", (dim,)),  # m, in the body's own frame
            ("local_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("size", "f8", (dim,)),  # m, half-extents; a capsule's half-length is size[0], in 3D size[2]
            ("radius", "f8"),  # m, of round shapes, else 0
            ("extent", "f8"),  # m, smallest half-width
            ("friction", "f8"),
            *turning,
            ("restitution", "f8"),
            ("density", "f8"),  # kg/m^2 or kg/m^3
            ("enabled", "i4"),
        ],
        align=True,
    )


def world_parameter_dtype(dim: int) -> np.dtype[Any]:
    return np.dtype([("gravity", "f8", (dim,))], align=True)  # m/s^2


def body_state_dtype(dim: int) -> np.dtype[Any]:
    """Where a body is and how it moves."""
    return np.dtype(
        [
            ("position", "f8", (dim,)),  # m, centre of mass
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("angle", "f8"),  # rad, unwrapped (2D)
            ("velocity", "f8", (NDOF[dim],)),  # m/s and rad/s: [vx, vy, w] or [v, w]
            ("force", "f8", (NDOF[dim],)),  # N and N m, of the next step; cleared after it
            ("sleep_time", "f8"),  # s at rest so far
            ("asleep", "i4"),
        ],
        align=True,
    )


def contact_dtype(dim: int) -> np.dtype[Any]:
    """One contact point. Sorted by (shape_a, shape_b, feature); normal from a to b."""
    turning: list[Any] = [] if dim == 2 else [("torsional_friction", "f8"), ("rolling_friction", "f8")]  # m
    miss: list[Any] = [] if dim == 2 else [("miss", "f8")]  # m, of candidates for secondary impacts, else 0
    return np.dtype(
        [
            ("shape_a", "i4"),
            ("shape_b", "i4"),
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("feature", "i4"),  # which corner of which edge: same number, same contact
            ("sensor", "i4"),
            ("point", "f8", (dim,)),  # m
            ("normal", "f8", (dim,)),
            ("separation", "f8"),  # m, negative = overlap
            ("friction", "f8"),
            *turning,
            ("restitution", "f8"),
            ("extent", "f8"),  # m, length scale of the pair
            *miss,
            ("impulse", "f8", (CONTACT_ROWS[dim],)),  # N s of the last substep: normal, then tangents
            ("total_impulse", "f8", (CONTACT_ROWS[dim],)),  # N s, summed over the step
        ],
        align=True,
    )


def world_state_dtype() -> np.dtype[Any]:
    """Counters of a world, and what its last step says of itself."""
    return np.dtype(
        [
            ("step", "i8"),  # steps taken since reset
            ("contact_count", "i4"),
            ("awake_count", "i4"),
            ("pair_count", "i4"),
            ("row_count", "i4"),  # of the last step, all islands
            ("island_count", "i4"),
            ("sweeps", "i4"),  # of the last step, all islands and substeps
            ("unconverged", "i4"),  # island substeps that ran out of sweeps
            ("impacts", "i4"),
            ("residual", "f8"),  # largest stopping residual of the step
            ("natural_residual", "f8"),  # nm of the last substep, all islands
        ],
        align=True,
    )


def joint_model_dtype() -> np.dtype[Any]:
    return np.dtype(
        [
            ("kind", "i4"),  # JointKind of its dimension
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("joint_a", "i4"),  # of gears: the joints that are coupled
            ("joint_b", "i4"),
            ("row_first", "i4"),  # of a constraint's own rows
            ("row_count", "i4"),
            ("wakes", "i4"),  # 1: driven from outside, so its island never sleeps
            ("torque", "i4"),  # 1: an actuator sets the motor's effort instead of its speed
            ("frame", "i4"),  # of a constraint: 1 = directions fixed in body_a
        ],
        align=True,
    )


def joint_parameter_dtype(dim: int) -> np.dtype[Any]:
    return np.dtype(
        [
            ("anchor_a", "f8", (dim,)),  # m, in the body's own frame
            ("anchor_b", "f8", (dim,)),
            ("axis", "f8", (dim,)),  # unit, in the frame of body a
            ("reference", "f8", (ROTATION_SIZE[dim],)),  # rotation of b in a where the joint is at rest
            ("reference_angle", "f8"),  # rad, the same, unwrapped (2D); of gears the coupled coordinate
            ("length", "f8"),  # m, of distance joints
            ("lower", "f8"),  # m or rad, limits of the coordinate; infinite = none
            ("upper", "f8"),
            ("frequency", "f8"),  # Hz, of the spring on the mass that the row sees
            ("damping_ratio", "f8"),
            ("stiffness", "f8"),  # N/m or N m/rad; counts where it or the damping is positive
            ("damping", "f8"),  # N s/m or N m s/rad
            ("spring_effort", "f8"),  # N or N m, bound of the spring
            ("motor_effort", "f8"),  # N or N m, bound of the motor; 0 = no motor
            ("max_force", "f8"),  # N, of targets
            ("max_torque", "f8"),  # N m
            ("ratio", "f8"),  # of gears
            ("rigid", "i4"),  # 1: no spring
            ("enabled", "i4"),
        ],
        align=True,
    )


def joint_state_dtype(dim: int) -> np.dtype[Any]:
    turn: list[Any] = [] if dim == 2 else [("target_rotation", "f8", (4,))]  # of target joints
    return np.dtype(
        [
            ("impulse", "f8", (ROWS_PER_JOINT[dim],)),  # N s and N m s of the last substep
            ("total_impulse", "f8", (ROWS_PER_JOINT[dim],)),  # summed over the step
            ("reaction", "f8", (NDOF[dim],)),  # N s and N m s on body b at its anchor, over the step
            ("motor_speed", "f8"),  # m/s or rad/s
            ("rest", "f8"),  # m or rad, where the spring is relaxed
            ("effort", "f8"),  # N or N m, of a motor that a torque actuator drives
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
        ("axis", "i4"),  # which coordinate of a target; -1: the one coordinate of another joint
        ("mode", "i4"),  # ActuatorMode: what the control is
        ("lower", "f8"),  # control is clipped to [lower, upper]
        ("upper", "f8"),
    ],
    align=True,
)


def constraint_row_dtype(dim: int) -> np.dtype[Any]:
    """One row of a user-written constraint."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("jacobian_a", "f8", (ndof,)),
            ("jacobian_b", "f8", (ndof,)),
            ("lower", "f8"),  # N or N m
            ("upper", "f8"),
            ("bias", "f8"),  # m/s or rad/s
            ("softness", "f8"),  # 1/(kg) or 1/(kg m^2), of the impulse
            ("error", "f8"),  # m or rad, what the position pass takes back
        ],
        align=True,
    )


def shape_geometry_dtype(dim: int) -> np.dtype[Any]:
    """Scratch: where a shape is now."""
    return np.dtype(
        [
            ("position", "f8", (dim,)),  # m, world
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("lower", "f8", (dim,)),  # m, bounding box, swept over the step and widened by the margin
            ("upper", "f8", (dim,)),
            ("reach", "f8"),  # m, travel in a step beyond the linear motion: spin, gravity, force
            ("extent", "f8"),  # m, length scale of a dynamic shape, else infinite
            ("active", "i4"),  # 1: enabled, on an enabled body
            ("dynamic", "i4"),  # 1: active, on a dynamic body
            ("awake", "i4"),  # 1: on an awake dynamic or a moving kinematic body
        ],
        align=True,
    )


PAIR_DTYPE = np.dtype(
    [
        ("shape_a", "i4"),
        ("shape_b", "i4"),
        ("spare_a", "i4"),  # scratch of the sort
        ("spare_b", "i4"),
    ],
    align=True,
)


TURNING: list[Any] = [
    ("frame", "f8", (3, 3)),  # rows: principal axes half a substep ahead, or the world's where all moments are equal
    ("tilted", "i4"),  # 1: the frame is not the world's
    ("middle", "f8", (4,)),  # rotation of a tilted body half a substep ahead
    ("slowest", "f8", (3,)),  # m/s, each axis for itself: what impacts of the step may make of the velocity
    ("fastest", "f8", (3,)),
    ("likely", "f8", (3,)),  # m/s, of the ball around these
    ("spread", "f8"),  # m/s, its radius
    ("backed", "i4"),  # 1: what does not move may stop it in the step
]


def motion_dtype(dim: int) -> np.dtype[Any]:
    """Scratch of a body within one step.

    In space all that turns stands in the body's ``frame`` of the substep, so that its inertia is diagonal.
    """
    ndof = NDOF[dim]
    turning: list[Any] = [] if dim == 2 else TURNING
    return np.dtype(
        [
            ("acceleration", "f8", (ndof,)),  # of gravity and applied force
            ("path", "f8", (ndof,)),  # acceleration with the rigid joints' forces, for the time of impacts
            ("start_velocity", "f8", (ndof,)),  # at the start of the substep, after impacts
            ("free_velocity", "f8", (ndof,)),  # before constraint impulses
            ("correction", "f8", (ndof,)),  # pseudo-velocity of the position pass
            ("inverse", "f8", (ndof,)),  # 1/kg and 1/(kg m^2)
            ("shift", "f8", (ndof,)),  # displacement that impacts inside the substep take back
            ("displacement", "f8", (ndof,)),  # since contacts were found
            ("held_velocity", "f8", (ndof,)),  # of a disabled body, given back after the step
            ("start_position", "f8", (dim,)),  # at the start of the step
            ("start_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("start_angle", "f8"),
            ("mass_matrix", "f8", (ndof, ndof)),  # kg and kg m^2, of dynamic bodies
            ("event_time", "f8"),  # s into the substep of the body's last impact
            *turning,
        ],
        align=True,
    )


ISLAND_DTYPE = np.dtype(
    [
        ("body_first", "i4"),
        ("body_count", "i4"),
        ("contact_first", "i4"),
        ("contact_count", "i4"),
        ("joint_first", "i4"),
        ("joint_count", "i4"),
        ("awake", "i4"),  # 0 asleep, 1 awake, 2 driven, 3 pressed; see islands.py
        ("parent", "i4"),  # entry b: of body b in union-find, negative outside of all islands
        ("label", "i4"),  # entry b: island of body b, or why it has none
    ],
    align=True,
)


@dataclass(frozen=True)
class Model:
    """A compiled scene: what is the same in all worlds, and the nominal values of what is not.

    ``nominal`` arrays have one entry an item and no world axis; Parameters and State start as
    copies of them.
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
    sensors: Array  # SENSOR_DTYPE (sensor,)
    sensor_rays: Array  # (ray, 2) unit directions in the frames of the bodies that carry them
    exclusions: Array  # int64, encoded body pairs, sorted
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
    shape_colors: Array | None  # uint8 (shape, 3), or None
    needs_vertices: bool  # the scene has polygons or terrain

    @property
    def has_joints(self) -> bool:
        return len(self.joints) > 0

    @property
    def is_linked(self) -> bool:
        """Whether there are joints from revolute on, which the kernels compile code of their own for."""
        return bool((self.joints["kind"] > 2).any())

    @property
    def sensor_slices(self) -> dict[str, slice]:
        """Columns of each sensor in ``World.sensors()``, by name, in the order of the scene."""
        ends = np.cumsum(self.sensors["count"]).tolist()
        return {name: slice(a, b) for name, a, b in zip(self.sensor_names, [0, *ends], ends, strict=False)}

    @cached_property
    def digest(self) -> str:
        """Identifies the scene's topology: what must agree for a snapshot to fit."""
        h = hashlib.sha256(repr((self.dim, self.body_names, self.joint_names)).encode())
        for array in (self.bodies, self.shapes, self.joints, self.actuators, self.exclusions):
            for name in array.dtype.names or ():
                h.update(np.ascontiguousarray(array[name]).tobytes())
            if not array.dtype.names:
                h.update(array.tobytes())
            h.update(b";")
        return h.hexdigest()
