"""Scenes with known answers and scenes to look at: written once for tests, benchmarks and demos.

Each builder returns a Scene; ``SCENES`` names the ones that ``gsenv record scene:NAME`` films.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass

from gsenv.solver import Options, Scene, World

from .flight import bouncing_balls, projectile
from .slopes import box_on_incline, disk_on_incline, sliding_disk, terrain_slide
from .stacks import mass_ratio_stack, overhang, pyramid, stack


@dataclass(frozen=True)
class SceneSpec:
    """A scene that can be recorded.

    Attributes:
        build: makes the Scene.
        summary: one line for lists.
        duration: s worth watching.
    """

    build: Callable[[], Scene]
    summary: str
    duration: float


SCENES: dict[str, SceneSpec] = {
    "stack": SceneSpec(lambda: stack(10), "ten boxes stand on each other", 4.0),
    "pyramid": SceneSpec(lambda: pyramid(10), "a planar pyramid of 55 boxes", 4.0),
    "mass_ratio": SceneSpec(lambda: mass_ratio_stack(1000.0), "1000 kg on 1 kg", 4.0),
    "overhang": SceneSpec(lambda: overhang(5, 1.01), "blocks 1 % beyond the limit topple", 8.0),
    "incline": SceneSpec(lambda: box_on_incline(35.0), "a block slides down a slope", 2.0),
    "roll": SceneSpec(lambda: disk_on_incline(20.0), "a disk rolls down a slope", 2.0),
    "slide_to_roll": SceneSpec(sliding_disk, "a sliding disk starts to roll", 2.0),
    "bounce": SceneSpec(bouncing_balls, "balls of restitution 0 to 1", 6.0),
    "terrain": SceneSpec(terrain_slide, "a ball and boxes on hills", 8.0),
    "projectile": SceneSpec(projectile, "free flight of a spinning box", 1.5),
}


def make_world(name: str, world_count: int = 1, options: Options | None = None) -> World:
    """A World of a named scene.

    Raises:
        ValueError: unknown name.
    """
    if name not in SCENES:
        near = difflib.get_close_matches(name, SCENES, 1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"scene {name!r} is unknown; known are {', '.join(SCENES)}{hint}")
    return World(SCENES[name].build(), world_count=world_count, options=options)


__all__ = [
    "SCENES",
    "SceneSpec",
    "bouncing_balls",
    "box_on_incline",
    "disk_on_incline",
    "make_world",
    "mass_ratio_stack",
    "overhang",
    "projectile",
    "pyramid",
    "sliding_disk",
    "stack",
    "terrain_slide",
]
