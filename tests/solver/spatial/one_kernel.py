"""Scenes that all have every feature, far away and disabled: one variant of the step kernel steps them all."""

from __future__ import annotations

from typing import Any

import numpy as np

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Ball, Heightfield, Hull, Plane, Sphere

FAR = 1e4  # m
AWAKE = Options(sleep=False)
CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))


def complete(scene: Scene) -> Scene:
    """Add, far away, what decides how the step kernel is compiled: a joint, a hull, a heightfield, restitution,
    a continuous body.  Nothing of it moves, touches or counts."""
    shapes = [Hull(vertices=CORNERS, restitution=0.5), Heightfield(heights=np.zeros((2, 2)), size=(1, 1))]
    scene.add_body("far", "static", shapes=shapes, position=(FAR, FAR, FAR))
    scene.add_body(
        "far_fast", shapes=[Sphere(radius=0.1)], position=(FAR, FAR, 2.0 * FAR), continuous=True, enabled=False
    )
    scene.add_joint("far_ball", Ball("far", "far_fast", enabled=False))
    return scene


def full_world(scene: Scene, worlds: int = 1, options: Options = AWAKE, **given: Any) -> World:
    """A world of a scene that this completes."""
    return World(complete(scene), worlds, options=options, **given)


def space(weight: float = 0.0) -> Scene:
    """An empty scene with the gravity of ``weight`` m/s^2 down."""
    return Scene(dim=3, gravity=(0.0, 0.0, -weight))


def on_plane(weight: float = 9.81, **material: Any) -> Scene:
    """A scene with the ground z <= 0 as body 0."""
    scene = space(weight)
    scene.add_body("ground", "static", shapes=[Plane(**material)])
    return scene
