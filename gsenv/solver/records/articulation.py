"""Records of bodies in joint coordinates: which body hangs on which, and the links of the island that is stepped."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from .model import NDOF, ROTATION_SIZE, ROWS_PER_JOINT, Array, JointKind

MOST_EQUATIONS = 160  # of joints in no tree; an island with more is solved in body space
MOST_VALUES = 2_000_000  # of all rows in joint space; an island that needs more is solved in body space


MOST_AXES = {2: 2, 3: 6}  # of a joint
SLIDES = 3  # coordinates with lower numbers are translations, as in spatial/joints/axes.py
TURN = 3  # 2D: the number of the rotation


class LinkKind(IntEnum):
    """How a link moves relative to its parent."""

    FREE = 0  # no joint: the root of a tree
    PIVOT = 1  # 3D ball
    AXES = 2  # all other rigid joints: any number of slides and turns, of a weld none


TREE_DTYPE = np.dtype(
    [
        ("parent", "i4"),  # body that it hangs on, fixed or not; -1: the root of a tree
        ("joint", "i4"),  # -1: none
        ("kind", "i4"),  # LinkKind
        ("count", "i4"),  # degrees of freedom
        ("numbers", "i4", (6,)),  # of their coordinates (spatial/joints/axes.py), from the parent outward; -1: no axis
        ("flipped", "i4"),  # 1: the body is body_a of its joint
        ("rank", "i4"),  # place in an order in which parents come first
        ("depth", "i4"),  # most degrees of freedom between it and a fixed body, its own included
    ],
    align=True,
)
"""The place of a body in the forest of all rigid joints without loops."""


def link_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a body of the island in joint coordinates. Vectors are in the axes of the world."""
    ndof = NDOF[dim]
    spin = ndof - dim
    most = MOST_AXES[dim]
    return np.dtype(
        [
            ("body", "i4"),
            ("parent", "i4"),  # link, -1: none, or a fixed body
            ("holder", "i4"),  # body of the parent, -1: none
            ("joint", "i4"),
            ("kind", "i4"),  # LinkKind
            ("flipped", "i4"),
            ("first", "i4"),  # its degrees of freedom
            ("count", "i4"),
            ("slides", "i4"),  # those among them that are translations
            ("numbers", "i4", (most,)),  # of their coordinates
            ("last", "i4"),  # last degree of freedom on the way to it, -1: none
            ("tree", "i4"),  # link that is the root of its tree
            ("neighbour", "i4"),  # of the root of a free tree: root of the first tree that a rod or rope ties it to
            ("position", "f8", (dim,)),  # m, centre of mass
            ("rotation", "f8", (ROTATION_SIZE[dim],)),
            ("angle", "f8"),  # rad, unwrapped (2D)
            ("base_position", "f8", (dim,)),  # pose from which displacements are counted
            ("base_rotation", "f8", (ROTATION_SIZE[dim],)),
            ("base_angle", "f8"),
            ("base_coordinates", "f8", (most,)),
            ("base_directions", "f8", (most, dim)),
            ("base_halves", "f8", (most, 2)),
            ("coordinates", "f8", (most,)),  # rad or m, of turns and slides
            ("halves", "f8", (most, 2)),  # cosine and sine of half the coordinate of turns (3D)
            ("axes", "f8", (most, dim)),  # unit, of turns and slides, in the frame of body a
            (
                "directions",
                "f8",
                (most, dim),
            ),  # unit, the same in the world and outward; not of 2D turns
            ("pin", "f8", (dim,)),  # m, anchor of the joint on body b
            ("reach", "f8", (dim,)),  # m, from the parent's centre of mass to the pin
            ("arm", "f8", (dim,)),  # m, from the pin to the link's centre of mass
            ("turn", "f8", (spin,)),  # rad, of the last displacement
            ("center", "f8", (dim,)),  # m, centre of mass from the origin, half a substep ahead
            ("anchor", "f8", (dim,)),  # m, pin from the origin, half a substep ahead
            ("half", "f8", (spin,)),  # rad, displacement in the first half of the substep
            ("start", "f8", (dim,)),  # m, centre of mass at the start of the substep
            ("start_pin", "f8", (dim,)),  # m, pin at the same time, in steps of Runge-Kutta
            ("start_spin", "f8", (spin,)),  # rad/s, at the start of the substep
            ("taut", "f8", (1 if dim == 2 else 6,)),  # kg m^2, h^2/4 of the stiffness by tension, as ``moment``
            ("velocity", "f8", (ndof,)),  # m/s and rad/s, of the centre of mass
            ("acceleration", "f8", (ndof,)),
            ("moment", "f8", (1 if dim == 2 else 6,)),  # kg m^2 about the centre of mass: I, or xx xy xz yy yz zz
            ("applied", "f8", (ndof,)),  # N and N m about the origin: gravity, applied forces, damping
            ("force", "f8", (ndof,)),  # N and N m, or N s and N m s, about the origin
            ("response", "f8", (ndof,)),  # change of the velocity at the origin
            ("inertia", "f8", (ndof, ndof)),  # articulated inertia about the origin; of 3D its lower triangle
            ("momentum", "f8", (ndof,)),  # kg m/s and kg m^2/s about the centre of mass
            ("push", "f8", (ndof,)),  # momentum at the start of the substep, with what gravity and forces add to it
            ("contact", "f8", (ndof,)),  # N s and N m s about the centre of mass, by the rows of the substep
        ],
        align=True,
    )


def freedom_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a degree of freedom; motions and forces refer to the origin of the tree."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("motion", "f8", (ndof,)),  # velocity of the link at the origin, per unit of the rate
            ("hold", "f8", (ndof,)),  # articulated inertia times motion
            ("inverse", "f8"),  # of motion . hold + stiffness + armature; 0: nothing to move
            ("root", "f8"),  # its square root
            ("stiffness", "f8"),  # kg or kg m^2, by an implicit spring
            ("pull", "f8"),  # N s or N m s, by the same
            ("armature", "f8"),  # kg or kg m^2, inertia of a rotor that turns with the coordinate alone
            ("parent", "i4"),  # the one before it on the way from the root, -1: none
            ("link", "i4"),
        ],
        align=True,
    )


SERVO_DTYPE = np.dtype(
    [
        ("joint", "i4"),
        ("link", "i4"),
        ("place", "i4"),  # of the coordinate among the degrees of freedom of the link, -1: not one of them
        ("driven", "i4"),  # the same of the coordinate of motor, friction and armature
        ("number", "i4"),  # of the coordinate
        ("turning", "i4"),  # of that of the motor
        ("limited", "i4"),  # 1: it has limits
        ("reached", "i4"),  # 1: it may do so in this substep, so that its limit needs a row
        ("side", "i4"),  # -1 or 1: the row is that of its lower or upper limit, 0: of the nearer one
        ("turned", "i4"),  # 1: the row was that of the other limit before
        ("row", "i4"),  # of the limit that is reached
        ("isotropic", "i4"),  # 1: of a ball without rotors whose springs are equal about all axes
        ("direction", "f8", (3,)),  # of these, outward: the axis that the coordinate is about
        ("begin", "f8"),  # rad or m, coordinate at the start of the substep
        ("curve", "f8"),  # rad/s or m/s, change of the rate of the limit's row by the end of the substep
        ("stiffness", "f8"),  # kg or kg m^2, part of the spring in that of the degree of freedom
        ("pull", "f8"),  # N s or N m s, the same
    ],
    align=True,
)
"""A coordinate of a joint of a tree, with its limit, motor and spring."""


def span_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a row in joint space: y = D^-1/2 L^-T J^T along the ways from its bodies to the root."""
    return np.dtype(
        [
            ("places", "i4"),  # first of the degrees of freedom
            ("count", "i4"),  # their number
            ("values", "i4"),  # first of the values
            ("stride", "i4"),  # rows of a contact alternate
            ("width", "i4"),  # rows that alternate from this one on; 0: not the first of them
            ("free", "f8"),  # m/s, velocity of the row before any impulse, with its bias
            ("one", "f8"),  # 1/kg, coupling of a normal to its first tangent
            ("two", "f8"),  # and to the second
            # what sweeps read and write of a normal with two tangents, in one place
            ("mass", "f8"),  # kg, effective mass of the normal
            ("give", "f8"),  # 1/kg, compliance in all three directions
            ("sizes", "f8", (3,)),  # 1/kg, diagonals, with it
            ("cross", "f8"),  # 1/kg, coupling of the tangents
            ("inverse", "f8", (3,)),  # kg, inverse of the tangents' block: xx, xy, yy; 0 where that is singular
            ("friction", "f8"),
            ("slip", "f8", (2,)),  # m/s, ``free`` of the tangents
            ("impulse", "f8", (3,)),  # N s
            ("previous", "f8", (3,)),  # N s, before the sweep
            ("direction", "f8", (3,)),  # N s, conjugate direction
        ],
        align=True,
    )


def articulation_scratch(dim: int, trees: Array, joint_count: int, row_capacity: int) -> dict[str, Any]:
    """Return the scratch of islands in joint coordinates: the fields of ``world.scratch.articulation``."""
    bodies = len(trees)
    freedoms = NDOF[dim] * bodies
    deepest = int(trees["depth"].max(initial=NDOF[dim]))
    values = min(row_capacity * 2 * deepest, MOST_VALUES)
    rates = ("start", "rate", "free", "change", "whitened", "before", "conjugate", "step", "shift", "mean")
    runge_kutta = ("path", "slope", "start_slope", "start_acceleration", "path_sum", "rate_sum")
    return {
        "links": np.zeros(bodies, link_dtype(dim)),
        "freedoms": np.zeros(freedoms, freedom_dtype(dim)),
        "places": np.zeros(bodies, np.int32),  # link of each body
        "servos": np.zeros(joint_count, SERVO_DTYPE),
        "spans": np.zeros(row_capacity, span_dtype(dim)),
        "ways": np.zeros(values + 2 * deepest, np.uint32),
        "values": np.zeros(values + 2 * deepest),
        "others": None,
        **{name: np.zeros(freedoms) for name in (*rates, *runge_kutta)},
    }


def other_joints(joints: Array, trees: Array) -> int:
    """Return the number of joints that are in no tree, so that joint coordinates need their rows."""
    mains = np.where(joints["kind"] == JointKind.AXIS, joints["joint_a"], np.arange(len(joints)))
    in_trees = np.isin(mains, trees["joint"])
    return int(len(joints) - in_trees.sum())


def others_scratch(dim: int, joints: Array, trees: Array) -> dict[str, Array]:
    """Return the scratch of the rows of joints in no tree: the fields of ``world.scratch.articulation.others``."""
    rows = ROWS_PER_JOINT[dim] * other_joints(joints, trees)
    equations = min(rows, MOST_EQUATIONS)
    return {
        "slots": np.zeros(rows, np.int32),  # of each row, as it was solved
        "free": np.zeros(rows),  # 1/kg, J M^-1 J^T of its bodies without joints in trees
        "mass": np.zeros(rows),  # kg or kg m^2, its effective mass in joint space
        "start_rate": np.zeros(
            rows
        ),  # m/s or rad/s: J v at the start of the substep; NaN where the bias is the joint's
        "moved": np.zeros(rows),  # m kg or rad kg m^2 in 1/s: impulses that closed the joints
        "last": np.zeros(rows),  # those of the last step of closing
        "order": np.zeros(equations, np.int32),  # row of each equation
        "give": np.zeros(equations),  # its softness
        "side": np.zeros(equations),
        "matrix": np.zeros((equations, equations)),  # Delassus matrix, then its Cholesky factor
        "dense": np.zeros(NDOF[dim] * len(trees)),  # one row in joint space; 0 between its uses
    }
