"""GRagdoll's scene, from the figure's file."""

from __future__ import annotations

import math

from gsenv.envs.ragdoll import figure
from gsenv.envs.ragdoll import scene as numbers
from gsenv.envs.ragdoll2d.build import ARROW
from gsenv.mjcf import build_scene as scene_of
from gsenv.mjcf.build import Names
from gsenv.solver import Scene
from gsenv.solver.records.model import Model
from gsenv.solver.spatial import Capsule

_BARB_ANGLE = 0.7  # rad, between a barb of the arrow's head and its shaft


def build_scene() -> tuple[Scene, Names]:
    """Return the scene: level ground, the figure upright with all angles 0, the arrow; and the names in it."""
    scene, names = scene_of(figure.figure())
    _add_arrow(scene)
    return scene, names


def _add_arrow(scene: Scene) -> None:
    """Add the arrow that shows a push, with its tip at the origin of its frame and its shaft along -x."""
    n = numbers
    half = 0.5 * n.ARROW_LENGTH
    shaft = Capsule(
        half, n.ARROW_RADIUS, position=(-half, 0.0, 0.0), orientation=_across(0.0), mask=0, name="arrow_shaft"
    )
    barbs = []
    for side in (-1.0, 1.0):
        c, s = math.cos(_BARB_ANGLE), side * math.sin(_BARB_ANGLE)
        middle = (-c * n.ARROW_BARB, 0.0, -s * n.ARROW_BARB)
        barbs.append(
            Capsule(n.ARROW_BARB, n.ARROW_RADIUS, position=middle, orientation=_across(side * _BARB_ANGLE), mask=0)
        )
    scene.add_body("arrow", "static", [shaft, *barbs], position=n.PARKED, color=ARROW)


def _across(angle: float) -> tuple[float, float, float, float]:
    """Return the quaternion that lays a capsule along x and then lifts it by an angle in rad towards z."""
    half = 0.5 * (0.5 * math.pi - angle)
    return math.cos(half), 0.0, math.sin(half), 0.0


def paint(model: Model) -> None:
    """Give each shape the colour that it has in the file; a scene has one for each body."""
    colors = model.shape_colors
    assert colors is not None
    for geom in figure.figure().geoms:
        colors[model.shape_names.index(geom.name)] = (255.0 * geom.rgba[:3]).round()
