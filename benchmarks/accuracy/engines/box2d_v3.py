"""Box2D v3 behind the common interface: the same bodies, shapes, masses and joints as in our Model.

It is built from its sources (peers.py), twice: with its widest vectors and without any. Its polygons have no skin. Its
defaults combine friction as the geometric mean and restitution as the maximum, as gsenv does. The threshold of
restitution is 0, continuous collision is off; half-planes are large boxes.

Settings: substeps; build: "SIMD" or "scalar"; contact: hertz (an eighth of the rate of substeps at most, which it
enforces itself), damping ratio and speed (m/s) of contacts' recovery; joint: hertz (a quarter of that rate at most) and
damping ratio; recycle: whether it keeps a contact's points while the pair moves by less than 5 cm; sleep.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.planar.kinds import BOX, CIRCLE, HALF_PLANE
from gsenv.solver.records.model import BodyKind, JointKind, Model

from ..trajectory import STATE
from . import Setting, touching_shapes
from .peers import NATIVE, Peer, World, has_avx2

Array = NDArray[np.float64]
GROUND_HALF = (40.0, 2.0)  # m, of the box that stands for a half-plane
CONTACT, JOINT = (30.0, 10.0, 3.0), (60.0, 2.0)  # its defaults
JOINTS = {JointKind.REVOLUTE: 0.0, JointKind.DISTANCE: 1.0}
PEER = Peer(
    name="Box2D v3",
    target="box2d",
    shim="box2d_v3.c",
    variants={
        "SIMD": ("-DBOX2D_AVX2=ON",) if has_avx2() else (),
        "scalar": ("-DBOX2D_DISABLE_SIMD=ON",),
    },
)
FILES = (Path(__file__).with_name("peers.py"), NATIVE / PEER.shim, NATIVE / "CMakeLists.txt")


def version(source: Path) -> str:
    return PEER.version(source) + (", AVX2" if has_avx2() else "")


class Simulation:
    """A b2World; one call takes any number of steps."""

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
        library = PEER.library(source, values.get("build", "SIMD"))
        self.world = World(library, settings, body_rows(model), shapes, joints, STATE)
        self.angle = model.start_bodies["angle"].copy()

    def step(self, count: int) -> None:
        self.world.step(self.timestep, self.substeps, count)

    def profile(self, count: int) -> Array:
        return self.world.profile(self.timestep, self.substeps, count)

    def read(self) -> Array:
        """Return the states; angles go on from those of the last call, less than half a turn away."""
        out = self.world.read()
        turned = out[:, 2] - self.angle
        self.angle = self.angle + turned - 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
        out[:, 2] = self.angle
        return out


def body_rows(model: Model) -> Array:
    """Return (body, 9): dynamic, position (m), angle (rad), velocity, angular velocity, mass (kg), inertia (kg m^2)."""
    start, nominal = model.start_bodies, model.nominal_bodies
    dynamic = model.bodies["kind"] == BodyKind.DYNAMIC
    columns = (dynamic, start["position"], start["angle"], start["velocity"], nominal["mass"], nominal["inertia"])
    return np.column_stack(columns).astype(np.float64)


def shape_row(model: Model, index: int) -> tuple[float, ...]:
    """Return body, is a box, position (m), angle (rad), radius or half-extents (m), friction, restitution.

    Raises:
        ValueError: it is no box, circle or half-plane.
    """
    kind, shape = model.shapes["kind"][index], model.nominal_shapes[index]
    c, s = shape["local_rotation"]
    center, size = shape["local_position"], shape["size"]
    if kind == CIRCLE:
        size = np.array([shape["radius"], 0.0])
    elif kind == HALF_PLANE:
        size = np.array(GROUND_HALF)
        center = center - GROUND_HALF[1] * np.array([-s, c])
    elif kind != BOX:
        raise ValueError(f"shape {model.shape_names[index]!r}: the benchmark has boxes, circles and half-planes.")
    owner, angle = model.shapes["body"][index], np.arctan2(s, c)
    return owner, kind != CIRCLE, *center, angle, *size, shape["friction"], shape["restitution"]


def joint_row(model: Model, index: int) -> tuple[float, ...]:
    """Return is a spring, bodies, anchors (m), length (m), frequency (Hz), damping ratio.

    Raises:
        ValueError: it is no hinge or spring.
    """
    joint, nominal = model.joints[index], model.nominal_joints[index]
    kind = JointKind(int(joint["kind"]))
    if kind not in JOINTS:
        raise ValueError(f"joint {model.joint_names[index]!r}: the benchmark has hinges and springs.")
    ends = joint["body_a"], joint["body_b"], *nominal["anchor_a"], *nominal["anchor_b"]
    return JOINTS[kind], *ends, nominal["length"], nominal["frequency"], nominal["damping_ratio"]
