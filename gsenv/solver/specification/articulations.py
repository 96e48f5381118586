"""The forest of a scene's rigid joints: which body hangs on which."""

from __future__ import annotations

import numpy as np

from ..records.articulation import SLIDES, TREE_DTYPE, TURN, LinkKind
from ..records.model import NDOF, Array, BodyKind, JointKind
from .axis_spec import FIRST_TURN, LAST_TURN, NODE_TURN, TWIST

_PLANAR = {  # numbers of the coordinates of 2D joints
    JointKind.REVOLUTE: (TURN,),
    JointKind.PRISMATIC: (0,),
    JointKind.WHEEL: (0, TURN),
}
_WITH_AXES = (JointKind.HINGE, JointKind.SLIDER, JointKind.UNIVERSAL, JointKind.WHEEL, JointKind.SIX_AXIS)
_TURNS = {  # by the bits of the locked rotations
    0b000: (FIRST_TURN, NODE_TURN, LAST_TURN),
    0b010: (FIRST_TURN, LAST_TURN),
    0b011: (TWIST,),
    0b111: (),
}


def trees_of(body_kinds: Array, joints: Array, parameters: Array, dim: int) -> Array:
    """Return TREE_DTYPE (body,) of a spanning forest of the rigid joints.

    Roots are the bodies whose joints hold them to bodies that are not dynamic, and else the first body of each
    component.  Enabled joints come before others; a joint that closes a loop is in no tree.

    Args:
        body_kinds: BodyKind (body,).
        joints, parameters: records (joint,).
    """
    trees = np.zeros(len(body_kinds), TREE_DTYPE)
    trees["parent"] = trees["joint"] = -1
    dynamic = body_kinds == BodyKind.DYNAMIC
    neighbours = _neighbours(len(body_kinds), joints, parameters, dim)
    order: list[int] = []
    placed = ~dynamic
    for root in [*np.flatnonzero(~dynamic).tolist(), *np.flatnonzero(dynamic).tolist()]:
        if placed[root] and dynamic[root]:
            continue
        placed[root] = True
        trees["depth"][root] = NDOF[dim] if dynamic[root] else 0
        queue = [root]
        while queue:
            body = queue.pop(0)
            order.append(body)
            for joint, other in neighbours[body]:
                if not placed[other]:
                    placed[other] = True
                    _hang(trees, other, body, joint, joints[joint], dim)
                    queue.append(other)
    trees["rank"][order] = np.arange(len(order))
    return trees


def _hang(trees: Array, body: int, parent: int, joint: int, model: Array, dim: int) -> None:
    """Hang a body on another by a joint."""
    numbers = coordinates_of(int(model["kind"]), int(model["locked"]), dim)
    pivots = JointKind(int(model["kind"])) == JointKind.BALL
    flipped = int(model["body_a"]) == body
    tree = trees[body]
    tree["parent"], tree["joint"] = parent, joint
    tree["kind"] = LinkKind.PIVOT if pivots else LinkKind.AXES
    tree["numbers"] = -1
    tree["count"] = 3 if pivots else len(numbers or ())
    if numbers:
        tree["numbers"][: len(numbers)] = numbers[::-1] if flipped else numbers
    tree["flipped"] = flipped
    tree["depth"] = trees["depth"][parent] + tree["count"]


def coordinates_of(kind: int, locked: int, dim: int) -> tuple[int, ...] | None:
    """Return the numbers of the coordinates of a rigid joint from a to b, translations first; None for other joints.

    A ball has no such numbers, but is a rigid joint.
    """
    joint = JointKind(kind)
    if joint in (JointKind.WELD, JointKind.BALL):
        return ()
    if dim == 2:
        return _PLANAR.get(joint)
    turns = _TURNS.get(locked >> SLIDES)
    if joint not in _WITH_AXES or turns is None or locked == 0:
        return None
    return tuple(k for k in range(SLIDES) if not (locked >> k) & 1) + turns


def _neighbours(body_count: int, joints: Array, parameters: Array, dim: int) -> list[list[tuple[int, int]]]:
    """Return (joint, other body) of each body's rigid joints: enabled ones first, those that repeat others last."""
    neighbours: list[list[tuple[int, int]]] = [[] for _ in range(body_count)]
    kinds = zip(joints["kind"].tolist(), joints["locked"].tolist(), strict=True)
    rigid = np.array([coordinates_of(kind, locked, dim) is not None for kind, locked in kinds], bool)
    weld = joints["kind"] == JointKind.WELD
    soft = (parameters["frequency"] > 0.0) | (parameters["stiffness"] > 0.0) | (parameters["damping"] > 0.0)
    rigid &= ~(weld & soft)
    late = 2 * (parameters["enabled"] == 0) + (joints["repeats"] >= 0)
    for j in np.argsort(late, kind="stable").tolist():
        if rigid[j]:
            a, b = int(joints["body_a"][j]), int(joints["body_b"][j])
            neighbours[a].append((j, b))
            neighbours[b].append((j, a))
    return neighbours
