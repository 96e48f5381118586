"""3D scenes, with z up; each builder returns a Scene."""

from .flight import bouncing_spheres, spinning_box, thrown_box
from .heaps import cube_rain, marble_bowl, sphere_grid, sphere_rain
from .machines import cart, swing_door
from .slopes import block_on_incline, roller_on_incline, rolling_cylinders, sliding_roller
from .springs import soft_cube
from .stacks import block_overhang, brick_wall, brick_wall_hit, cube_mass_ratio, cube_pyramid, cube_stack
from .swings import ball_chain, gyroscope, precession, rod_pendulum, small_period, sphere_cradle, two_rods

__all__ = [
    "ball_chain",
    "block_on_incline",
    "block_overhang",
    "bouncing_spheres",
    "brick_wall",
    "brick_wall_hit",
    "cart",
    "cube_mass_ratio",
    "cube_pyramid",
    "cube_rain",
    "cube_stack",
    "gyroscope",
    "marble_bowl",
    "precession",
    "rod_pendulum",
    "roller_on_incline",
    "rolling_cylinders",
    "sliding_roller",
    "small_period",
    "soft_cube",
    "sphere_cradle",
    "sphere_grid",
    "sphere_rain",
    "spinning_box",
    "swing_door",
    "thrown_box",
    "two_rods",
]
