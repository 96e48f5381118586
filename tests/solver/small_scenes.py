"""Small scenes that several tests of the World share."""

from __future__ import annotations

from typing import Any

from gsenv.solver import Handle, Scene
from gsenv.solver.planar import Box, Circle, Target, Weld


def crate(gravity: tuple[float, float] = (0, 0), **given: Any) -> Scene:
    """One crate of 2 kg and 3 kg m^2, with a handle."""
    scene = Scene(gravity=gravity)
    scene.add_body("crate", shapes=[Box(half_extents=(0.5, 0.5))], mass=2.0, inertia=3.0, **given)
    return scene


def driven() -> Scene:
    scene = crate()
    scene.add_joint("pull", Target("crate", max_force=100.0))
    scene.add_joint("self", Target("crate"))
    scene.add_body("other", shapes=[Circle(radius=0.5)], position=(5, 0))
    scene.add_joint("glue", Weld("crate", "other"))
    scene.add_constraint("rule", ["crate", "other"], [[1, 0, 0, -1, 0, 0]], lower=-5, upper=5)
    scene.add_actuator("left", "pull", "x")
    scene.add_actuator("right", "pull", "y")
    return scene


def handle(what: str, name: str, names: tuple[str, ...]) -> Any:
    return Handle(what, name, names.index(name))
