"""Box3D behind the common interface: the same bodies, shapes, masses and joints as in our Model.

It is built from its sources (peers.py) as it builds by default, which is with SSE2 on x86. Its defaults combine
friction as the geometric mean and restitution as the maximum, as gsenv does. The threshold of restitution is 0,
continuous collision is off; half-spaces are large boxes, and cylinders, which it lacks, prisms with 32 sides, the most
that its own function makes.

Settings: substeps; contact, joint, recycle and sleep as in box2d_v3.py.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.records.model import BodyKind, JointKind, Model
from gsenv.solver.spatial.kinds import BOX, CYLINDER, PLANE, SPHERE

from ..geometry3d import rotated
from ..trajectory import STATE3
from . import Setting, touching_shapes
from .peers import NATIVE, Peer, World

Array = NDArray[np.float64]
GROUND_HALF = (40.0, 40.0, 2.0)  # m, of the box that stands for a half-space
CONTACT, JOINT = (30.0, 10.0, 3.0), (60.0, 2.0)  # its defaults
KINDS = {SPHERE: 0.0, BOX: 1.0, PLANE: 1.0, CYLINDER: 2.0}
PEER = Peer(name="Box3D", target="box3d", shim="box3d.c", variants={"default": ()})
FILES = (Path(__file__).with_name("peers.py"), NATIVE / PEER.shim, NATIVE / "CMakeLists.txt")


def version(source: Path) -> str:
    return PEER.version(source)


class Simulation:
    """A b3World; one call takes any number of steps."""

    def __init__(self, model: Model, setting: Setting, source: Path) -> None:
        values = setting.values
        self.timestep, self.substeps = setting.timestep, values["substeps"]
        settings = (
            *model.nominal_world["gravity"], *values.get("contact", CONTACT), *values.get("joint", JOINT),
            values.get("sleep", False), values.get("recycle", True),
        )  # fmt: skip
        touching = [k for body in range(len(model.bodies)) for k in touching_shapes(model, body)]
        shapes = np.array([shape_row(model, k) for k in touching])
        joints = np.array([joint_row(model, k) for k in range(len(model.joints))])
        library = PEER.library(source, "default")
        self.world = World(library, settings, body_rows(model), shapes, joints, STATE3)

    def step(self, count: int) -> None:
        self.world.step(self.timestep, self.substeps, count)

    def profile(self, count: int) -> Array:
        return self.world.profile(self.timestep, self.substeps, count)

    def read(self) -> Array:
        return self.world.read()


def body_rows(model: Model) -> Array:
    """Return (body, 18): dynamic, position (m), quaternion, velocities, mass (kg), inertia (kg m^2)."""
    start, nominal = model.start_bodies, model.nominal_bodies
    dynamic = model.bodies["kind"] == BodyKind.DYNAMIC
    columns = (dynamic, start["position"], start["rotation"], start["velocity"], nominal["mass"], nominal["inertia"])
    return np.column_stack(columns).astype(np.float64)


def shape_row(model: Model, index: int) -> tuple[float, ...]:
    """Return body, kind, position (m), quaternion, size (m), friction, restitution.

    Raises:
        ValueError: it is no box, sphere, cylinder or half-space.
    """
    kind, shape = int(model.shapes["kind"][index]), model.nominal_shapes[index]
    if kind not in KINDS:
        raise ValueError(f"shape {model.shape_names[index]!r}: the benchmark has no such shapes.")
    owner = model.shapes["body"][index]
    turn, center = shape["local_rotation"], shape["local_position"] - model.nominal_bodies["center"][owner]
    size = {
        SPHERE: (shape["radius"], 0.0, 0.0),
        BOX: tuple(shape["size"]),
        CYLINDER: (shape["radius"], shape["size"][2], 0.0),
        PLANE: GROUND_HALF,
    }[kind]
    if kind == PLANE:
        center = center - rotated(turn, np.array([0.0, 0.0, GROUND_HALF[2]]))
    return owner, KINDS[kind], *center, *turn, *size, shape["friction"], shape["restitution"]


def joint_row(model: Model, index: int) -> tuple[float, ...]:
    """Return bodies and anchors (m).

    Raises:
        ValueError: it is no ball joint.
    """
    joint, nominal = model.joints[index], model.nominal_joints[index]
    if joint["kind"] != JointKind.BALL:
        raise ValueError(f"joint {model.joint_names[index]!r}: the benchmark has ball joints.")
    return joint["body_a"], joint["body_b"], *nominal["anchor_a"], *nominal["anchor_b"]
