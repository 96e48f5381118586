"""Scenes for tests, benchmarks and demos; many have closed-form solutions.

Each builder returns a Scene; ``SCENES`` lists those that ``gsenv record scene:NAME`` can record.
"""

from __future__ import annotations

import difflib

from gsenv.solver import Options, World

from .chains import chain, hanging_chain, hanging_mode, heavy_chain, plank_bridge, rope
from .flight import bouncing_balls, projectile
from .heaps import cube_drop, dominoes
from .machines import mixer, motor_rig, wrecking_ball
from .pendulums import cradle, double_pendulum, pendulum
from .slopes import box_on_incline, disk_on_incline, sliding_disk, terrain_slide
from .spatial.catalogue import SPATIAL
from .spec import SceneSpec
from .springs import jelly, spring_mass
from .stacks import mass_ratio_stack, overhang, pyramid, stack
from .vehicles import car, hill_car

SCENES: dict[str, SceneSpec] = {
    "stack": SceneSpec(lambda: stack(10), "a stack of ten boxes", 4.0),
    "pyramid": SceneSpec(lambda: pyramid(10), "a pyramid of 55 boxes", 4.0),
    "mass_ratio": SceneSpec(
        lambda: mass_ratio_stack(1000.0), "a box of 1000 kg on a box of 1 kg", 4.0, (-1.8, -0.4, 1.8, 2.3)
    ),
    "overhang": SceneSpec(
        lambda: overhang(5, 1.01), "blocks shifted 1 % beyond the stable overhang topple", 4.0, (-2.8, -3.0, 5.2, 3.0)
    ),
    "incline": SceneSpec(lambda: box_on_incline(35.0), "a block slides down a slope", 2.0, (-1.0, -2.8, 4.0, 0.95)),
    "roll": SceneSpec(lambda: disk_on_incline(20.0), "a disk rolls down a slope", 2.0, (-1.2, -2.6, 5.2, 2.2)),
    "slide_to_roll": SceneSpec(sliding_disk, "a sliding disk starts to roll", 2.0, (-1.0, -0.8, 5.8, 2.2)),
    "bounce": SceneSpec(bouncing_balls, "balls of restitution 0 to 1 bounce", 6.0, (-0.4, -0.4, 2.9, 1.6)),
    "terrain": SceneSpec(terrain_slide, "a ball and boxes on hills", 8.0, (0.1, -6.0, 23.9, 8.0)),
    "projectile": SceneSpec(projectile, "free flight of a spinning box", 1.5, (-0.8, -0.5, 8.6, 4.5)),
    "cubes": SceneSpec(cube_drop, "fifty boxes of random sizes fall into a bin", 5.0, (-6.0, -0.8, 6.0, 8.2)),
    "dominoes": SceneSpec(dominoes, "a small domino knocks down larger and larger ones", 5.0, (-0.5, -1.2, 11.8, 6.0)),
    "pendulum": SceneSpec(pendulum, "a rod swings down from 120 degrees", 6.0, (-1.5, -1.35, 1.5, 0.9)),
    "double_pendulum": SceneSpec(double_pendulum, "two rods fall from the horizontal", 10.0, (-2.9, -2.3, 2.9, 2.05)),
    "cradle": SceneSpec(
        lambda: cradle(2, arms=True), "two of five balls swing in, two swing out", 8.0, (-1.2, -0.4, 1.2, 1.4)
    ),
    "chain": SceneSpec(
        lambda: chain(degrees=60.0), "a straight chain of twenty links swings down", 8.0, (-5.0, -5.6, 5.0, 1.0)
    ),
    "heavy_chain": SceneSpec(heavy_chain, "a chain whose last link is 100 times heavier", 8.0, (-4.2, -5.7, 4.2, 0.6)),
    "hanging_chain": SceneSpec(
        lambda: hanging_chain(degrees=25.0), "the slowest mode of a hanging chain", 8.0, (-0.9, -1.15, 0.9, 0.2)
    ),
    "rope": SceneSpec(rope, "a rope falls over a drum", 8.0, (-4.0, -3.2, 4.4, 2.4)),
    "bridge": SceneSpec(plank_bridge, "boxes fall onto a plank bridge", 6.0, (-6.0, -3.6, 6.0, 5.4)),
    "spring": SceneSpec(
        lambda: spring_mass(1.0, 0.03, stretch=0.55), "a mass oscillates on a spring", 6.0, (-1.3, -1.9, 1.3, 0.2)
    ),
    "jelly": SceneSpec(jelly, "a soft block of balls and springs falls and recovers", 5.0, (-3.8, -0.7, 3.8, 5.2)),
    "mixer": SceneSpec(mixer, "two geared paddle wheels stir balls", 10.0),
    "car": SceneSpec(hill_car, "a car with suspension drives over hills", 10.0, follow="chassis"),
    "burnout": SceneSpec(
        lambda: car(suspension=2.0), "a rear-drive car spins its wheels on flat ground", 4.0, follow="chassis"
    ),
    "wrecking_ball": SceneSpec(wrecking_ball, "a ball on a chain knocks down a wall", 6.0, (-7.6, -1.2, 8.4, 8.2)),
    **SPATIAL,
}


def make_world(name: str, world_count: int = 1, options: Options | None = None) -> World:
    """Return a World of a named scene.

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
    "car",
    "chain",
    "cradle",
    "cube_drop",
    "disk_on_incline",
    "dominoes",
    "double_pendulum",
    "hanging_chain",
    "hanging_mode",
    "heavy_chain",
    "hill_car",
    "jelly",
    "make_world",
    "mass_ratio_stack",
    "mixer",
    "motor_rig",
    "overhang",
    "pendulum",
    "plank_bridge",
    "projectile",
    "pyramid",
    "rope",
    "sliding_disk",
    "spring_mass",
    "stack",
    "terrain_slide",
    "wrecking_ball",
]
