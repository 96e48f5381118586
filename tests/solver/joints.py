"""Joints by the name of their kind, for tests that run over kinds."""

from __future__ import annotations

from typing import Any

from gsenv.solver.specification.joint_base import Joint
from gsenv.solver.specification.joints import JOINT_TYPES


def make_joint(kind: str, body_a: Any, body_b: Any, **arguments: Any) -> Joint:
    """A joint of kind "weld", "revolute", ...; a target pulls ``body_b``."""
    made: Any = JOINT_TYPES[kind]
    bodies = (body_b,) if kind == "target" else (body_a, body_b)
    return made(*bodies, **arguments)
