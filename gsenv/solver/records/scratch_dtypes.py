"""The records of a step's scratch: pairs of shapes, bodies within a substep, islands. See model.py for the others."""

from __future__ import annotations

from typing import Any

import numpy as np

from .model import NDOF, ROTATION_SIZE


def shape_geometry_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the scratch of a shape: its present pose and box."""
    return np.dtype(
        [
            ("position", "f8", (dim,)),  # m, world
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("lower", "f8", (dim,)),  # m, bounding box, swept over the step and widened by the margin
            ("upper", "f8", (dim,)),
            ("reach", "f8"),  # m, largest motion in a step beyond the linear one: by rotation, gravity and forces
            ("extent", "f8"),  # m, length scale of a dynamic shape, else infinite
            ("form", "f8"),  # code of size and place on the body; see core/recycling.py
            ("calm", "i4"),  # 1: not round, and on a static body or one without joints that rests
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


def kept_box_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the boxes of core/kept_pairs.py, one for each shape."""
    return np.dtype(
        [
            ("lower", "f8", (dim,)),  # m
            ("upper", "f8", (dim,)),
            ("flags", "i4"),
            # of the first shape:
            ("pairs", "i4"),  # 1 + number of kept pairs; 0: none are
            ("wait", "i4"),  # searches until it is tried again
            ("pause", "i4"),  # twice the length of the last wait, or 0, 1
        ],
        align=True,
    )


KEPT_PAIR_DTYPE = np.dtype([("shape_a", "i4"), ("shape_b", "i4")], align=True)


SUBSTEP_BODY_FIELDS_3D: list[Any] = [
    # rows: principal axes half a substep ahead, or the world's axes where all moments are equal
    ("frame", "f8", (3, 3)),
    ("rotated_frame", "i4"),  # 1: the rows of ``frame`` are principal axes, not the world's axes
    ("mid_rotation", "f8", (4,)),  # own frame at the middle of the substep, where ``rotated_frame`` is 1
]


def substep_body_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the scratch of a body within one step.

    In 3D angular quantities are in the body's ``frame`` of the substep, in which its inertia is diagonal.
    """
    ndof = NDOF[dim]
    spatial: list[Any] = [] if dim == 2 else SUBSTEP_BODY_FIELDS_3D
    return np.dtype(
        [
            ("acceleration", "f8", (ndof,)),  # m/s^2 and rad/s^2, by gravity and applied forces
            ("constrained_acceleration", "f8", (ndof,)),  # the same with the forces of rigid joints
            ("start_velocity", "f8", (ndof,)),  # at the start of the substep, after impacts
            ("free_velocity", "f8", (ndof,)),  # before constraint impulses
            ("correction", "f8", (ndof,)),  # pseudo-velocity of the position pass; then the displacement of the substep
            ("inverse", "f8", (ndof,)),  # 1/kg and 1/(kg m^2)
            ("impact_displacement", "f8", (ndof,)),  # m and rad, added to the substep's motion by its impacts
            ("displacement", "f8", (ndof,)),  # m and rad, since the contacts were found
            ("saved_velocity", "f8", (ndof,)),  # of a disabled body, restored after the step
            ("start_position", "f8", (dim,)),  # at the start of the step
            ("start_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("start_angle", "f8"),
            # rotation since the start of the step, now and at the middle of the substep; see core/turning.py
            ("turn", "f8", (ROTATION_SIZE[dim],)),
            ("mid_turn", "f8", (ROTATION_SIZE[dim],)),
            ("mass_matrix", "f8", (ndof, ndof)),  # kg and kg m^2, of dynamic bodies
            ("event_time", "f8"),  # s, time of the body's last impact within the substep
            ("swing", "f8"),  # 1/s^2, stiffness over inertia by the tension of the joints on the body
            # m/s, per axis, smallest and largest velocity that impacts of the step may cause
            ("velocity_lower", "f8", (dim,)),
            ("velocity_upper", "f8", (dim,)),
            ("velocity_center", "f8", (dim,)),  # m/s, centre of a ball that contains these velocities
            ("velocity_radius", "f8"),  # m/s, radius of this ball
            ("widened_radius", "f8"),  # m/s, the radius by which the boxes of its shapes were last widened
            ("turning", "i4"),  # 1: contact rows follow its rotation in this substep
            ("turn_known", "i4"),  # 1: ``turn`` and ``mid_turn`` are those of this substep
            ("blocked", "i4"),  # 1: it may hit a fixed body in the step, directly or through others
            ("widened_in", "i4"),  # the last pass over all contacts that widened its velocities; -1: none
            *spatial,
        ],
        align=True,
    )


def start_pose_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a body's pose before the step, for continuous collision."""
    return np.dtype(
        [
            ("position", "f8", (dim,)),  # m
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("angle", "f8"),  # rad, unwrapped (2D)
        ],
        align=True,
    )


def closing_pose_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of what closing rods and ropes changes of a body."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            *((name, start_pose_dtype(dim)[name]) for name in ("position", "rotation", "angle")),
            ("velocity", "f8", (ndof,)),
            ("impact_displacement", "f8", (ndof,)),  # m and rad, of the substep body
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
        ("activity", "i4"),  # 0 all asleep, 1 awake, 2 driven, 3 kinematic contact; see core/islands.py
        ("parent", "i4"),  # entry b: parent of body b in union-find, negative outside all islands
        ("label", "i4"),  # entry b: island of body b, or a negative label of core/islands.py
    ],
    align=True,
)

ISLAND_STEP_DTYPE = np.dtype(
    [
        ("body_first", "i4"),  # ranges of its lists, as in ISLAND_DTYPE
        ("body_count", "i4"),
        ("contact_first", "i4"),
        ("contact_count", "i4"),
        ("joint_first", "i4"),
        ("joint_count", "i4"),
        ("activity", "i4"),
        ("kinematic", "i4"),  # 1: the world has enabled kinematic bodies
        ("driven", "i4"),  # 1: joints or kinematic bodies may do work on it
        ("has_springs", "i4"),  # 1: a joint has a spring, which may release energy
        ("slowed", "i4"),  # 1: masses are scaled, see slow_swings
        ("guarded", "i4"),  # 1: its energy at the end of the step is limited, see core/step_energy.py
        ("has_restitution", "i4"),  # 1: a contact has a restitution
        ("calm", "i4"),  # 1: its bodies rest on each other and take one substep
        ("stopped", "i4"),  # 1: the next step starts from the impulses of its rows less their ``direction``
        ("may_land", "i4"),  # 1: its bodies are fast enough for a landing, and its contacts few enough
        ("rotated_frame", "i4"),  # 1: one of its bodies has a rotated frame (3D)
        ("servos", "i4"),  # 1: joints of trees have limits, motors, springs or rotors
        ("coordinates", "i4"),  # those of joints of trees
        ("taut", "i4"),  # 1: the tension of links is implicit, in joint coordinates; 2: in the rest of a step
        ("touched", "i4"),  # 1: rows act in this substep, in joint coordinates
        ("apart", "i4"),  # 1: joints in no tree cannot hold in this substep, in joint coordinates
        ("substeps", "i8"),
        ("freedoms", "i8"),  # degrees of freedom, in joint coordinates
        ("joint_rows", "i8"),  # number of joint rows, which come before those of contacts
        ("other_rows", "i8"),  # rows of joints that are not of trees, in joint coordinates; they come first
        ("equations", "i8"),  # those among them that are solved together
        ("rows", "i8"),  # all rows
        ("h", "f8"),  # s, one substep, or a part of it between landings
        ("whole", "f8"),  # s, one substep
        ("time", "f8"),  # s, from the start of the step to that of the substep or part
        ("end", "f8"),  # s, from the start of the step to the end of the substep or part
        ("swing", "f8"),  # 1/s^2, squared frequency at which taut joints swing
        ("stored_scale", "f8"),  # factor of impulses that are stored for substeps of the usual length
        ("warm_start", "f8"),  # factor of the stored impulses; 0 for a cold start
        ("gravity_norm", "f8"),  # m/s^2
        ("mass", "f8"),  # kg, of its bodies, in joint coordinates
        ("residual_scale", "f8"),  # of the squared residual in this substep
        ("residual", "f8"),  # of this substep's solve
        ("energy", "f8"),  # J, kinetic and of springs, at the start of the step
        ("kinetic", "f8"),  # J, twice the kinetic energy at the start of the substep, in joint coordinates
        ("spin", "f8"),  # rad/s, fastest rotation of a link, in joint coordinates
        ("turning", "f8"),  # rad, fastest rotation of a link in a substep, in joint coordinates
        ("share", "f8"),  # of the correction of positions that is made in this substep, in joint coordinates
        ("smooth", "f8"),  # 1: no velocity jumped in this substep, else 0
        ("error_sum", "f8"),  # J; sums |e|^2, |q/s|^2, |s r|^2 of the last substep, see natural_residual
        ("velocity_sum", "f8"),
        ("impulse_sum", "f8"),
    ],
    align=True,
)
"""Scratch of the island that is being stepped, shared by its stages."""
