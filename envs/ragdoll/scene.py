"""GRagdoll's figure as numbers: what its file says, and tables of its joints for kernels. Everything in SI units.

The lengths are those of GRagdoll2D's figure. Kernels get the tables as arguments, not as constants: compiled code that
is kept from an earlier run would not know that the file has changed.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from gsenv.envs.ragdoll2d import scene as lengths
from gsenv.mjcf import MjcfModel, parse_mjcf
from gsenv.mjcf.build import Names
from gsenv.solver.records.bundle import Bundle
from gsenv.solver.records.model import Model

REACH = 0.6  # of half a joint's range: what a full action adds to the angle of the stand
ARROW_LENGTH = 0.5  # m, of the arrow of a push of 1 m/s
ARROW_GAP = 0.24  # m, from the middle of the pelvis to its tip
ARROW_BARB = 0.085  # m, half the length of the two barbs of its head
ARROW_RADIUS = 0.016  # m
PARKED = (0.0, 0.0, -40.0)  # m, of the arrow while no push is shown

CROWN = lengths.CROWN  # m, above the waist
STAND_HEIGHT = lengths.stand_height()  # m, of the crown in the stand
ANKLE, HEEL, TOE = lengths.ANKLE, lengths.HEEL, lengths.TOE  # of the sole, from the ankle
HALF_SOLE = 0.047  # m, half its width
HAND = (0.004, 0.0, -0.3)  # m, the middle of a hand in the frame of the forearm

PELVIS, TORSO = "pelvis", "torso"
FEET = ("left_foot", "right_foot")
HANDS = ("left_forearm", "right_forearm")
LEGS = tuple(f"{side}_{part}" for side in ("left", "right") for part in ("thigh", "shin", "foot"))

LINK_DTYPE = np.dtype(
    [
        ("body", "i4"),
        ("parent", "i4"),
        ("joint", "i4"),
        ("first", "i4"),  # of its axes
        ("count", "i4"),
    ],
    align=True,
)
AXIS_DTYPE = np.dtype(
    [
        ("turn", "i4"),  # number of the coordinate (gsenv/solver/spatial/joints/axes.py)
        ("sign", "f8"),  # of the coordinate over the angle of the file
    ],
    align=True,
)
PARTS_DTYPE = np.dtype(
    [
        ("pelvis", "i4"),
        ("torso", "i4"),
        ("arrow", "i4"),
        ("shaft", "i4"),  # shape
        ("feet", "i4", (2,)),
        ("hands", "i4", (2,)),
        ("first", "i4"),  # the figure's bodies are those from first to last
        ("last", "i4"),
    ],
    align=True,
)


class Axis(NamedTuple):
    """A driven joint of the figure."""

    name: str
    limits: tuple[float, float]  # rad
    stand: float  # rad, angle of the stand with bent knees
    stiffness: float  # N m/rad
    effort: float  # N m, the largest torque of its drive

    @property
    def span(self) -> float:
        """What a full action adds to the angle of the stand, rad."""
        return 0.5 * REACH * (self.limits[1] - self.limits[0])


@cache
def figure() -> MjcfModel:
    """Return what the figure's file says."""
    return parse_mjcf(files("gsenv.assets").joinpath("ragdoll.xml").read_text("utf-8"))


def _axes() -> tuple[Axis, ...]:
    model = figure()
    joints = {joint.name: joint for joint in model.joints}
    axes = []
    for actuator, stand in zip(model.actuators, model.keyframes[0].controls, strict=True):
        limits, force = joints[actuator.target].limits, actuator.force_range
        assert limits is not None
        assert force is not None
        axes.append(Axis(actuator.name, limits, float(stand), -float(actuator.bias[1]), force[1]))
    return tuple(axes)


AXES = _axes()
MASS = sum(body.inertia.mass for body in figure().bodies)  # kg


def tables(model: Model, names: Names) -> Bundle:
    """Return the tables of the figure in its scene for kernels.

    `axes` and `links` are records, `parts` is one; `joints` are the numbers of the driven joints of the scene, `stand`,
    `span` (rad) and `bounds` (N m) the angles and torques of their drives, and `legs` says which bodies are of a leg.
    """
    places = [names.joints[k] for k, joint in enumerate(figure().joints) if joint.kind == "hinge"]
    numbers = np.array([model.joint_names.index(place.joint) for place in places])
    axes = np.zeros(len(places), AXIS_DTYPE)
    axes["turn"] = model.joints["coordinate"][numbers]
    axes["sign"] = [place.sign for place in places]
    bodies = model.joints["body_b"][numbers]
    first = np.flatnonzero(np.diff(bodies, prepend=-1))
    links = np.zeros(len(first), LINK_DTYPE)
    links["joint"] = numbers[first]
    links["body"] = bodies[first]
    links["parent"] = model.joints["body_a"][numbers[first]]
    links["first"] = first
    links["count"] = np.diff(first, append=len(numbers))
    body = model.body_names.index
    parts = np.zeros((), PARTS_DTYPE)
    parts["pelvis"], parts["torso"], parts["arrow"] = body(PELVIS), body(TORSO), body("arrow")
    parts["shaft"] = model.shape_names.index("arrow_shaft")
    parts["feet"] = [body(name) for name in FEET]
    parts["hands"] = [body(name) for name in HANDS]
    parts["first"], parts["last"] = body(PELVIS), body(FEET[1])
    return Bundle(
        "Figure",
        3,
        axes=axes,
        links=links,
        parts=parts,
        joints=numbers,
        stand=np.array([axis.stand for axis in AXES]),
        span=np.array([axis.span for axis in AXES]),
        bounds=np.array([axis.effort for axis in AXES]),
        legs=np.array([name in LEGS for name in model.body_names]),
    ).seal()
