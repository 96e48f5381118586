"""Colours and lights of 3D pictures."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.theme import Rgb

FloatArray = NDArray[np.float64]

GROUND_COLOR: Rgb = (172, 180, 191)  # lighter squares of a plane; see setup.GROUND_SHADE for the darker ones


class Style(NamedTuple):
    """Sky, lights and fog; lengths are multiples of the distance from the eye to the target."""

    horizon: Rgb = (236, 238, 240)
    zenith: Rgb = (138, 178, 222)
    sun: tuple[float, float, float] = (0.98, 0.92, 0.82)  # linear light
    sky: tuple[float, float, float] = (0.44, 0.48, 0.56)
    bounce: tuple[float, float, float] = (0.24, 0.23, 0.22)
    sun_side: tuple[float, float] = (-0.70, -0.72)
    sun_height: float = 1.35
    softness: float = 0.05  # rad, angular radius of the sun
    reach: float = 0.035  # reach of ambient occlusion, at most
    fog: float = 4.2  # distance at which fog hides half
    cells: float = 7.0  # number of a plane's squares between the eye and the target

    def find_sun(self) -> FloatArray:
        """Return the unit vector (3,) towards the sun."""
        x, y = self.sun_side
        length = np.sqrt(x * x + y * y + self.sun_height**2)
        return np.array([x / length, y / length, self.sun_height / length])

    def find_cell(self, distance: float) -> float:
        """Return the side in m of a plane's squares: 1, 2 or 5 times a power of ten."""
        wanted = distance / self.cells
        decade = 10.0 ** np.floor(np.log10(wanted))
        return float(decade * min((1.0, 2.0, 5.0, 10.0), key=lambda step: abs(np.log(step * decade / wanted))))

    def find_lights(self) -> tuple[float, ...]:
        """Return the channels of sun, sky, bounce, horizon and zenith, in the order of `look_dtype`."""
        air = (channel / 255.0 for color in (self.horizon, self.zenith) for channel in color)
        return (*self.sun, *self.sky, *self.bounce, *air)


DEFAULT_STYLE = Style()
