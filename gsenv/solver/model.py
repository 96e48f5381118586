"""What a world is made of: Options, Model (constant), Parameters and State (per world), Workspace (scratch).

Each kind of thing has one structured array, ``(world, item)`` for what differs from world to world
and ``(item,)`` for what does not.  Field lengths depend on the dimension alone, never on the size
of a scene, so a kernel is compiled once for all scenes.  ``dim`` is 2 or 3; ``ndof`` is 3 or 6.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import check

Array = NDArray[Any]

NDOF = {2: 3, 3: 6}
ROTATION_SIZE = {2: 2, 3: 4}  # (cos, sin) or a quaternion (w, x, y, z)


class BodyKind(IntEnum):
    STATIC = 0  # never moves
    KINEMATIC = 1  # moves as told, feels nothing
    DYNAMIC = 2


class SolverKind(IntEnum):
    PGS = 0
    NNCG = 1
    SUBSPACE = 2


SOLVERS = {"pgs": SolverKind.PGS, "nncg": SolverKind.NNCG, "subspace": SolverKind.SUBSPACE}


def body_model_dtype() -> np.dtype[Any]:
    """Constant facts of a body."""
    return np.dtype(
        [
            ("kind", "i4"),  # BodyKind
            ("fast", "i4"),  # 1: swept against everything, never tunnels
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
    return np.dtype(
        [
            ("mass", "f8"),  # kg
            ("inertia", "f8", inertia),  # kg m^2 about the centre of mass
            ("inv_mass", "f8"),  # 0 unless dynamic and enabled
            ("inv_inertia", "f8", inertia),
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
    return np.dtype(
        [
            ("local_position", "f8", (dim,)),  # m, in the body's own frame
            ("local_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("size", "f8", (dim,)),  # m, half-extents; a capsule's half-length is size[0]
            ("radius", "f8"),  # m, of circles and capsules, else 0
            ("extent", "f8"),  # m, smallest half-width
            ("friction", "f8"),
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
            ("restitution", "f8"),
            ("extent", "f8"),  # m, length scale of the pair
            ("impulse", "f8", (dim,)),  # N s of the last substep: normal, then tangents
            ("total_impulse", "f8", (dim,)),  # N s, summed over the step
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
            ("row_first", "i4"),  # of a constraint's own rows
            ("row_count", "i4"),
            ("wakes", "i4"),  # 1: driven from outside, so its island never sleeps
        ],
        align=True,
    )


def joint_parameter_dtype(dim: int) -> np.dtype[Any]:
    return np.dtype(
        [
            ("anchor_a", "f8", (dim,)),  # m, in the body's own frame
            ("anchor_b", "f8", (dim,)),
            ("reference", "f8", (ROTATION_SIZE[dim],)),  # rotation of b in a where the joint is at rest
            ("frequency", "f8"),  # Hz, 0 = rigid
            ("damping_ratio", "f8"),
            ("max_force", "f8"),  # N
            ("max_torque", "f8"),  # N m
            ("enabled", "i4"),
        ],
        align=True,
    )


def joint_state_dtype(dim: int) -> np.dtype[Any]:
    return np.dtype(
        [
            ("impulse", "f8", (NDOF[dim],)),  # N s and N m s of the last substep
            ("total_impulse", "f8", (NDOF[dim],)),  # summed over the step
            ("target_position", "f8", (dim,)),  # m, of target joints
            ("target_angle", "f8"),  # rad, unwrapped (2D)
            ("target_velocity", "f8", (NDOF[dim],)),  # m/s and rad/s
        ],
        align=True,
    )


ACTUATOR_DTYPE = np.dtype(
    [
        ("joint", "i4"),
        ("body", "i4"),  # body_b of the joint
        ("axis", "i4"),  # which coordinate of the joint
        ("position", "i4"),  # 1: control is a position, 0: a velocity
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
            ("active", "i4"),  # 1: enabled, on an enabled body
            ("dynamic", "i4"),  # 1: active, on a dynamic body
            ("awake", "i4"),  # 1: on an awake dynamic or a moving kinematic body
        ],
        align=True,
    )


PAIR_DTYPE = np.dtype([("shape_a", "i4"), ("shape_b", "i4")], align=True)


def motion_dtype(dim: int) -> np.dtype[Any]:
    """Scratch of a body within one step."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("acceleration", "f8", (ndof,)),  # of gravity and applied force
            ("start_velocity", "f8", (ndof,)),  # at the start of the substep, after impacts
            ("free_velocity", "f8", (ndof,)),  # before constraint impulses
            ("correction", "f8", (ndof,)),  # pseudo-velocity of the position pass
            ("shift", "f8", (ndof,)),  # displacement that impacts inside the substep take back
            ("displacement", "f8", (ndof,)),  # since contacts were found
            ("start_position", "f8", (dim,)),  # at the start of the step
            ("start_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("start_angle", "f8"),
            ("mass_matrix", "f8", (ndof, ndof)),  # kg and kg m^2, of dynamic bodies
            ("event_time", "f8"),  # s into the substep of the body's last impact
            ("parent", "i4"),  # union-find
            ("island", "i4"),
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
    ],
    align=True,
)

OPTIONS_DTYPE = np.dtype(
    [
        ("timestep", "f8"),
        ("tolerance", "f8"),
        ("slop", "f8"),
        ("push_speed", "f8"),
        ("correction_rate", "f8"),
        ("sleep_speed", "f8"),
        ("sleep_time", "f8"),
        ("substeps", "i4"),
        ("solver", "i4"),
        ("sweeps", "i4"),
        ("position_sweeps", "i4"),
        ("warm_start", "i4"),
        ("sleep", "i4"),
    ],
    align=True,
)


@dataclass(frozen=True)
class Options:
    """How a world is stepped. The defaults hold for stacks, ropes of rows and mass ratios to 1000.

    Attributes:
        timestep: s, one ``World.step``.
        substeps: solves per step; contacts are found once per step.
        solver: ``"pgs"`` (plain projected Gauss-Seidel) or ``"nncg"`` (the same sweeps,
            accelerated as a conjugate gradient method) or ``"subspace"`` (these with direct
            steps on the active rows, where an island is a tower or chain).
        sweeps: most sweeps per island and substep.
        tolerance: natural-map residual at which an island's sweeps stop.
        position_sweeps: sweeps of the position pass.
        warm_start: start from the last impulses.
        sleep: let islands at rest stop.
        sleep_speed: m/s, fastest point of a body that counts as at rest.
        sleep_time: s at rest before an island sleeps.
        slop: overlap that is left alone, as a part of the bodies' extent.
        push_speed: extents per second, fastest separation of an overlap.
        correction_rate: part of a position error corrected per substep, 0 to 1.
    """

    timestep: float = 1.0 / 60.0
    substeps: int = 2
    solver: str = "subspace"
    sweeps: int = 30
    tolerance: float = 1e-4
    position_sweeps: int = 2
    warm_start: bool = True
    sleep: bool = True
    sleep_speed: float = 0.003
    sleep_time: float = 0.5
    slop: float = 1e-4
    push_speed: float = 3.0
    correction_rate: float = 0.2

    def __post_init__(self) -> None:
        check.positive(self.timestep, "Options: timestep")
        for name in ("tolerance", "sleep_speed", "sleep_time", "slop", "push_speed", "correction_rate"):
            check.not_negative(getattr(self, name), f"Options: {name}")
        if self.correction_rate > 1.0:
            raise ValueError(f"Options: correction_rate must not exceed 1, got {self.correction_rate!r}.")
        for name, least in (("substeps", 1), ("sweeps", 1), ("position_sweeps", 0)):
            check.whole(getattr(self, name), least, f"Options: {name}")
        for name in ("warm_start", "sleep"):
            if not isinstance(getattr(self, name), (bool, np.bool_)):
                raise ValueError(f"Options: {name} must be True or False, got {getattr(self, name)!r}.")
        if self.solver not in SOLVERS:
            names = ", ".join(SOLVERS)
            raise ValueError(f"Options: unknown solver {self.solver!r}; known are {names}.")

    def record(self) -> Array:
        """The options as a one-element structured array for the kernels."""
        record = np.zeros(1, OPTIONS_DTYPE)
        for name in OPTIONS_DTYPE.names or ():
            value = getattr(self, name)
            record[name] = int(SOLVERS[value]) if name == "solver" else value
        return record


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
    sensors: tuple[tuple[str, int], ...]  # (kind, body) (sensor,)
    exclusions: Array  # int64, encoded body pairs, sorted
    nominal_world: Array  # world_parameter_dtype ()
    nominal_bodies: Array  # body_parameter_dtype (body,)
    nominal_shapes: Array  # shape_parameter_dtype (shape,)
    nominal_joints: Array  # joint_parameter_dtype (joint,)
    nominal_rows: Array  # constraint_row_dtype (row,)
    nominal_vertices: Array  # vertex dtype of the dimension (vertex,)
    start_bodies: Array  # body_state_dtype (body,)
    start_joints: Array  # joint_state_dtype (joint,)
    mass_given: Array  # bool (body,): mass was given, not derived from density
    inertia_given: Array  # bool (body,)
    shape_colors: Array | None  # uint8 (shape, 3), or None
    needs_vertices: bool  # the scene has polygons or terrain

    @property
    def has_joints(self) -> bool:
        return len(self.joints) > 0

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
