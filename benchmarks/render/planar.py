"""The 2D picture that is timed."""

from __future__ import annotations

import numpy as np

from gsenv.render.camera import Camera
from gsenv.render.scene_renderer import SceneRenderer
from gsenv.solver import Scene, World
from gsenv.solver.planar.shapes import Box, Capsule, Circle, HalfPlane, Polygon


def make_world() -> World:
    """Return a pyramid of 28 boxes, a polygon, a circle and a capsule on a half-plane."""
    rng = np.random.default_rng(1)
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    for level in range(7):
        for k in range(7 - level):
            position = (-2.2 + (k - (6 - level) / 2) * 0.66, 0.3 + 0.605 * level)
            shapes = [Box(half_extents=(0.3, 0.3))]
            angle = 0.02 * rng.standard_normal()
            scene.add_body(f"box {level} {k}", shapes=shapes, position=position, angle=angle)
    corners = [(-0.55, -0.3), (0.5, -0.35), (0.7, 0.1), (0.1, 0.5), (-0.6, 0.3)]
    scene.add_body("polygon", shapes=[Polygon(vertices=corners)], position=(2.0, 0.42))
    scene.add_body("ball", shapes=[Circle(radius=0.45)], position=(3.6, 0.45))
    rod = Capsule(half_length=0.45, radius=0.18)
    scene.add_body("rod", shapes=[rod], position=(0.9, 0.9), angle=1.0)
    return World(scene)


def make_renderer(width: int, height: int) -> SceneRenderer:
    camera = Camera((0.0, 1.9), max(5.33, 9.6 * height / width))
    return SceneRenderer(make_world(), width, height, camera)
