"""GRagdoll's arrow of a push: its tip is where the push acts, the length of its shaft is proportional to the push."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsenv.envs.ragdoll import scene
from gsenv.envs.ragdoll2d.build import ARROW
from gsenv.render.spatial.arrows import Arrow
from gsenv.render.spatial.world_view import read_primitives, read_table, rotate

SHAFT = 0.9  # m, of the arrow of a push of 1 m/s
HEAD_ANGLE = 0.38  # rad, between the sides and the axis of its head
HEAD = (2.0 * scene.ARROW_BARB * math.cos(HEAD_ANGLE), 2.0 * scene.ARROW_BARB * math.sin(HEAD_ANGLE))  # m
START = 1.0  # m from the middle of the hips, outside of them


def find_arrow(world: Any, index: int, parts: Any, push: float) -> Arrow:
    """Return the arrow of a push of so many m/s in one world; without length while none is shown.

    `parts` has the numbers of the bodies. While the push acts, the tip touches the hips; then it withdraws, as the
    body "arrow" does.
    """
    bodies = world.state.bodies[index]
    mark = bodies[parts["arrow"]]
    if mark["position"][2] <= 0.5 * scene.PARKED[2] or push == 0.0:
        return Arrow(np.zeros(3), np.zeros(3), ARROW, HEAD)
    along = rotate(mark["rotation"], np.array([1.0, 0.0, 0.0]))
    hips = bodies[parts["pelvis"]]["position"]
    origin = mark["position"] - rotate(mark["rotation"], world.parameters.bodies["center"][index, parts["arrow"]])
    withdrawn = max(float(along @ (hips - origin)) - scene.ARROW_GAP, 0.0)
    tip = hips - (_depth(world, index, int(parts["pelvis"]), along) + withdrawn) * along
    return Arrow(tip - (HEAD[0] + SHAFT * abs(push)) * along, tip, ARROW, HEAD)


def _depth(world: Any, index: int, body: int, along: Any) -> float:
    """Return how far the surface of a body of capsules is from its centre, in m against the direction `along`."""
    table = read_table(world)
    shapes = read_primitives(world, index, table)
    own = table.body == body
    middle, radius = shapes.position[own], shapes.radius[own]
    axis = rotate(shapes.rotation[own], np.array([0.0, 0.0, 1.0]))
    half = shapes.size[own, 2]
    center = world.state.bodies[index][body]["position"]
    place = START
    for _ in range(40):  # towards the surface, each time by the distance to it
        to = center - place * along - middle
        share = np.clip((to * axis).sum(axis=1), -half, half)
        distance = float((np.sqrt(((to - share[:, None] * axis) ** 2).sum(axis=1)) - radius).min())
        place -= distance
        if distance < 1e-4:
            break
    return place
