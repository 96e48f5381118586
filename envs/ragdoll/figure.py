"""What the file of GRagdoll's figure says, and tables of its joints for kernels. Everything in SI units.

Kernels get the tables as arguments, not as constants: compiled code that is kept from an earlier run would not know
that the file has changed.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.ragdoll.scene import AXIS_DTYPE, FEET, HANDS, LEGS, LINK_DTYPE, PARTS_DTYPE, PELVIS, TORSO
from gsenv.envs.ragdoll2d.scene import REACH
from gsenv.mjcf import MjcfModel, parse_mjcf
from gsenv.mjcf.build import Names
from gsenv.solver.records.bundle import Bundle
from gsenv.solver.records.model import Model


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


def tables(model: Model, names: Names, lying: NDArray[np.float64]) -> Bundle:
    """Return the tables of the figure in its scene for kernels.

    `axes` and `links` are records, `parts` is one; `joints` are the numbers of the driven joints of the scene, `stand`,
    `span` (rad) and `bounds` (N m) the angles and torques of their drives, `below` and `above` (rad) the ways from the
    stand to the limits, `legs` says which bodies are of a leg, and `lying` has the poses in which an episode
    may begin (ragdoll2d/lying.py).
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
        below=np.array([axis.stand - axis.limits[0] for axis in AXES]),
        above=np.array([axis.limits[1] - axis.stand for axis in AXES]),
        bounds=np.array([axis.effort for axis in AXES]),
        legs=np.array([name in LEGS for name in model.body_names]),
        lying=lying,
    ).seal()
