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

_ALONG_X = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)  # of a capsule


def build_scene() -> tuple[Scene, Names]:
    """Return the scene: level ground, the figure upright with all angles 0, the arrow; and the names in it."""
    scene, names = scene_of(figure.figure())
    _add_arrow(scene)
    return scene, names


def _add_arrow(scene: Scene) -> None:
    """Add the mark of a push, with its tip at the origin of its frame; pictures show the arrow of push_arrow.py."""
    n = numbers
    half = 0.5 * n.ARROW_LENGTH
    shaft = Capsule(half, n.ARROW_RADIUS, position=(-half, 0.0, 0.0), orientation=_ALONG_X, mask=0, name="arrow_shaft")
    scene.add_body("arrow", "static", [shaft], position=n.PARKED, color=ARROW, enabled=False)


def paint(model: Model) -> None:
    """Give each shape the colour that it has in the file; a scene has one for each body."""
    colors = model.shape_colors
    assert colors is not None
    for geom in figure.figure().geoms:
        colors[model.shape_names.index(geom.name)] = (255.0 * geom.rgba[:3]).round()
