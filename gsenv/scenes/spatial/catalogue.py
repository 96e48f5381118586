"""The 3D scenes that can be recorded."""

from __future__ import annotations

from collections.abc import Callable

from gsenv.solver import Scene

from ..spec import Point, SceneSpec
from .flight import bouncing_spheres, spinning_box, thrown_box
from .heaps import cube_rain, marble_bowl, sphere_grid, sphere_rain
from .machines import cart, swing_door
from .slopes import block_on_incline, rolling_cylinders, sliding_roller
from .springs import soft_cube
from .stacks import block_overhang, brick_wall, brick_wall_hit, cube_mass_ratio, cube_pyramid, cube_stack
from .swings import ball_chain, gyroscope, rod_pendulum, sphere_cradle, two_rods


def _spatial(build: Callable[[], Scene], summary: str, duration: float, eye: Point, target: Point) -> SceneSpec:
    return SceneSpec(build, summary, duration, camera=(eye, target))


SPATIAL: dict[str, SceneSpec] = {
    "cube_stack": _spatial(lambda: cube_stack(10), "a stack of ten cubes", 4.0,
                           (9.0, -14.0, 8.0), (0.0, 0.0, 4.5)),
    "cube_pyramid": _spatial(lambda: cube_pyramid(10), "a flat pyramid of 55 cubes", 4.0,
                             (5.0, -17.0, 8.0), (0.0, 0.0, 4.0)),
    "cube_mass_ratio": _spatial(lambda: cube_mass_ratio(1000.0), "a cube of 1000 kg on a cube of 1 kg", 4.0,
                                (3.0, -5.0, 2.5), (0.0, 0.0, 1.0)),
    "block_overhang": _spatial(lambda: block_overhang(5, 1.01),
                               "3D blocks shifted 1 % beyond the stable overhang topple", 4.0,
                               (3.0, -9.0, 3.0), (1.0, 0.0, 0.0)),
    "wall": _spatial(brick_wall, "a brick wall stands", 4.0, (3.0, -7.0, 2.4), (0.2, 0.0, 0.8)),
    "wall_hit": _spatial(brick_wall_hit, "a heavy ball hits a brick wall", 4.0, (5.5, -7.5, 3.5), (0.0, 0.5, 0.6)),
    "cube_rain": _spatial(cube_rain, "sixty 3D boxes of random sizes fall into a bin", 5.0,
                          (5.0, -7.0, 6.0), (0.0, 0.0, 1.5)),
    "balls_grid": _spatial(sphere_grid, "a cube of 216 frictionless balls falls apart", 3.0,
                           (12.0, -14.0, 9.0), (0.0, 0.0, 2.0)),
    "ball_rain": _spatial(sphere_rain, "666 balls rain into a bin", 5.0, (3.2, -4.4, 6.5), (0.0, 0.0, 1.0)),
    "marbles": _spatial(marble_bowl, "marbles run down a bowl", 8.0, (3.0, -4.0, 3.5), (0.0, 0.0, 0.3)),
    "soft_cube": _spatial(soft_cube, "a soft cube of balls and springs falls and recovers", 5.0,
                          (4.0, -5.0, 3.0), (0.0, 0.0, 1.2)),
    "ball_cradle": _spatial(lambda: sphere_cradle(2, arms=True), "two of five 3D balls swing in, two swing out", 8.0,
                            (1.5, -3.0, 1.0), (0.0, 0.0, 0.4)),
    "rod_pendulum": _spatial(rod_pendulum, "a rod on a ball joint swings down from 120 degrees", 6.0,
                             (1.2, -2.8, 0.4), (0.0, 0.0, -0.1)),
    "two_rods": _spatial(lambda: two_rods(heading=20.0), "two rods on ball joints fall from the horizontal", 8.0,
                         (1.9, -5.0, 1.0), (0.0, 0.0, -0.5)),
    "ball_chain": _spatial(ball_chain, "a chain on ball joints whose last link is 100 times heavier", 8.0,
                           (4.0, -8.0, 0.5), (0.0, 0.0, -2.5)),
    "tumbling": _spatial(lambda: spinning_box((0.4, 0.9, 1.1), (0.02, 5.0, 0.02)), "a spinning box flips over and over",
                         10.0, (3.0, -5.0, 2.0), (0.0, 0.0, 0.0)),
    "gyroscope": _spatial(gyroscope, "a spinning disk on an arm precesses instead of falling", 7.0,
                          (0.35, -0.45, 0.25), (0.0, 0.0, 0.0)),
    "rolling": _spatial(rolling_cylinders, "cylinders of different sizes roll down side by side", 3.0,
                        (6.5, -8.5, 3.5), (3.4, 0.0, -1.0)),
    "slide_to_roll_3d": _spatial(sliding_roller, "a sliding ball starts to roll", 2.0,
                                 (2.0, -7.0, 2.5), (2.0, 0.0, 0.4)),
    "block_slide": _spatial(lambda: block_on_incline(35.0, 30.0, 20.0), "a rotated block slides down a slope", 2.0,
                            (3.0, -4.0, 1.0), (1.0, 0.7, -0.8)),
    "thrown_box": _spatial(thrown_box, "free flight of a tumbling box", 1.4, (3.5, -9.0, 3.0), (3.5, 0.7, 2.0)),
    "bounce_3d": _spatial(bouncing_spheres, "3D balls of restitution 0 to 1 bounce", 6.0,
                          (1.5, -4.5, 1.8), (1.2, 0.0, 0.5)),
    "cart": _spatial(cart, "a cart with suspension and steered wheels coasts round a bend", 6.0,
                     (-6.0, -9.0, 6.0), (6.0, 4.0, 0.0)),
    "swing_door": _spatial(swing_door, "a ball opens a door on two hinges, which a spring closes", 6.0,
                           (2.5, -4.5, 2.5), (0.3, 0.0, 1.0)),
}  # fmt: skip
