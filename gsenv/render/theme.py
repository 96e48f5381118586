"""Colours and proportions of 2D pictures; lengths are fractions of the picture's height."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[float, float, float]

# Colours of bodies, assigned cyclically.
PALETTE: NDArray[np.uint8] = np.array(
    [
        (238, 90, 46),  # vermilion
        (252, 172, 20),  # amber
        (168, 203, 134),  # sage
        (104, 158, 196),  # sky blue
        (44, 54, 98),  # navy
        (126, 46, 143),  # plum
        (70, 174, 144),  # jade
        (248, 180, 148),  # peach
    ],
    dtype=np.uint8,
)
STATIC_COLOR: Rgb = (134, 143, 154)  # shapes of static bodies
TYRE_COLOR: Rgb = (44, 47, 56)
RIM_COLOR: Rgb = (206, 211, 218)
HUB_COLOR: Rgb = (96, 103, 114)

# Joints.
PIN_COLOR: Rgb = (240, 242, 245)
ROD_COLOR: Rgb = (172, 180, 190)
SPRING_COLOR: Rgb = (150, 160, 176)
RAIL_COLOR: Rgb = (112, 121, 134)
ROPE_COLOR: Rgb = (104, 84, 66)
TARGET_COLOR: Rgb = (104, 84, 66)
METAL_LINE: Rgb = (38, 42, 52)  # outlines of pins, rods and springs

LINE_COLOR: Rgb = (24, 26, 32)  # of lines that a task adds, such as cracks
FORCE_COLOR: Rgb = (255, 214, 10)
CONTACT_COLOR: Rgb = (255, 70, 70)
JOINT_COLOR: Rgb = (255, 255, 255)
AXIS_COLORS: tuple[Rgb, Rgb] = ((240, 70, 80), (90, 210, 90))
HALO_COLOR: Rgb = (16, 18, 26)
HALO_ALPHA = 0.6

INK_COLOR: Rgb = (30, 37, 56)
PANEL_COLOR: Rgb = (252, 252, 252)
PANEL_ALPHA = 0.62

OUTLINE_DARKENING = 0.42  # ratio of the outline's colour to the fill's


class Ground(NamedTuple):
    """Colours of a ground: just below its edge band, far below, and of the band itself."""

    top: Rgb
    deep: Rgb
    edge: Rgb


SLATE = Ground(top=(141, 151, 164), deep=(98, 106, 117), edge=(104, 113, 128))
MEADOW = Ground(top=(150, 128, 106), deep=(104, 88, 78), edge=(122, 165, 84))


class Theme(NamedTuple):
    """Sky, outlines, grounds and shadows."""

    sky_top: Rgb = (206, 223, 240)
    sky_bottom: Rgb = (247, 243, 236)
    sky_end: float = 0.87  # fraction of the height where the sky reaches its bottom colour
    outline: float = 0.0048
    outline_min: float = 0.8  # px
    ground_edge: float = 0.0070
    ground_depth: float = 0.20  # depth over which a ground darkens
    shadow_alpha: float = 0.34
    shadow_offset: tuple[float, float] = (0.0095, 0.0125)  # right and down
    shadow_softness: float = 0.0270  # width of the whole penumbra
    band_contrast: float = 0.018  # of the ground's stripes, which make the camera's motion visible


DEFAULT_THEME = Theme()
