"""Joints."""

from __future__ import annotations

import numpy as np

from .attributes import Attributes
from .compiler import Compiler
from .frames import Pose
from .model import Joint

KINDS = ("free", "ball", "slide", "hinge")
POLYNOMIAL = "only the first coefficient of stiffness and damping, the linear one, is used"


def read_joint(attributes: Attributes, body: int, frame: Pose, compiler: Compiler) -> Joint:
    """Return a joint, without its indices of qpos and qvel.

    Raises:
        MjcfError: an attribute out of its range.
    """
    kind = attributes.choice("type", KINDS, "hinge") if attributes.element.tag == "joint" else "free"
    axis = attributes.array("axis", (0.0, 0.0, 1.0))
    length = float(np.linalg.norm(axis))
    if kind in ("slide", "hinge") and length < 1e-14:
        raise attributes.error("axis must not be zero")
    attributes.read.update(("range", "limited"))
    limits = None if kind == "free" else attributes.limits("range", "limited", compiler.autolimits)
    unit = compiler.angles.unit if kind in ("hinge", "ball") else 1.0
    if kind == "ball" and limits is not None and limits[0] != 0.0:
        raise attributes.error(f"the range of a ball joint must start at 0, got {limits[0]:g}")
    anchor = attributes.array("pos", (0.0, 0.0, 0.0))
    of_angle = unit if kind == "hinge" else 1.0
    joint = Joint(
        name=attributes.text("name"),
        kind=kind,
        body=body,
        position=np.zeros(3) if kind == "free" else frame.point(anchor),
        axis=frame.axes @ (axis / length) if kind in ("slide", "hinge") else np.array([0.0, 0.0, 1.0]),
        limits=None if limits is None else (limits[0] * unit, limits[1] * unit),
        reference=attributes.number("ref", 0.0) * of_angle,
        spring_reference=attributes.number("springref", 0.0) * of_angle,
        stiffness=_linear(attributes, "stiffness"),
        damping=_linear(attributes, "damping"),
        armature=_not_negative(attributes, "armature"),
        friction_loss=_not_negative(attributes, "frictionloss"),
        force_range=attributes.limits("actuatorfrcrange", "actuatorfrclimited", compiler.autolimits),
        coordinate=-1,
        rate=-1,
        place=attributes.element.place,
    )
    spring = attributes.vector("springdamper", (0.0, 0.0))
    if min(spring) > 0.0:
        attributes.notes.add("springdamper is ignored; give stiffness and damping", attributes.title)
    attributes.read.add("align")
    attributes.finish()
    return joint


def _not_negative(attributes: Attributes, name: str) -> float:
    value = attributes.number(name, 0.0)
    if value < 0.0:
        raise attributes.error(f"{name} must not be negative, got {value:g}")
    return value


def _linear(attributes: Attributes, name: str) -> float:
    """Return the first of a polynomial's coefficients."""
    first, *others = attributes.vector(name, (0.0, 0.0, 0.0))
    if first < 0.0:
        raise attributes.error(f"{name} must not be negative, got {first:g}")
    if any(others):
        attributes.notes.add(POLYNOMIAL, attributes.title)
    return first
