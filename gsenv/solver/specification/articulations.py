"""The forest of a scene's rigid joints: which body hangs on which."""

from __future__ import annotations

import numpy as np

from ..records.articulation import LINK_KINDS, TREE_DTYPE, LinkKind, freedom
from ..records.model import Array, BodyKind, JointKind


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
    neighbours = _neighbours(len(body_kinds), joints, parameters)
    order: list[int] = []
    placed = ~dynamic
    for root in [*np.flatnonzero(~dynamic).tolist(), *np.flatnonzero(dynamic).tolist()]:
        if placed[root] and dynamic[root]:
            continue
        placed[root] = True
        trees["depth"][root] = freedom(LinkKind.FREE, dim) if dynamic[root] else 0
        queue = [root]
        while queue:
            body = queue.pop(0)
            order.append(body)
            for joint, other in neighbours[body]:
                if not placed[other]:
                    placed[other] = True
                    kind = LINK_KINDS[JointKind(int(joints["kind"][joint]))]
                    flipped = joints["body_a"][joint] == other
                    trees[other] = (body, joint, kind, flipped, 0, trees["depth"][body] + freedom(kind, dim))
                    queue.append(other)
    trees["rank"][order] = np.arange(len(order))
    return trees


def _neighbours(body_count: int, joints: Array, parameters: Array) -> list[list[tuple[int, int]]]:
    """Return (joint, other body) of each body's rigid joints, enabled ones first."""
    neighbours: list[list[tuple[int, int]]] = [[] for _ in range(body_count)]
    rigid = np.isin(joints["kind"], list(LINK_KINDS))
    weld = joints["kind"] == JointKind.WELD
    soft = (parameters["frequency"] > 0.0) | (parameters["stiffness"] > 0.0) | (parameters["damping"] > 0.0)
    rigid &= ~(weld & soft)
    for j in np.argsort(parameters["enabled"] == 0, kind="stable").tolist():
        if rigid[j]:
            a, b = int(joints["body_a"][j]), int(joints["body_b"][j])
            neighbours[a].append((j, b))
            neighbours[b].append((j, a))
    return neighbours
