"""Records that the kernels share, and the lines of the row buffer.

A picture is made row by row. `lines` (LINE_COUNT, width) float32 holds everything about the current row and
stays in the first cache levels. Kernels take the columns first..last-1 as unsigned integers and all constants
as float32: signed columns do not vectorise, and one double would promote the whole row.

A ray is d = forward + x right + y up, not normalised: its parameter is the depth along `forward`, and in any
frame it is linear in the column.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]

f4 = np.float32
ZERO, HALF, ONE, TWO = f4(0.0), f4(0.5), f4(1.0), f4(2.0)
TINY = f4(1e-12)
FAR = f4(1e6)  # m, depth of the sky
NEAR = f4(0.01)  # m, nothing nearer is drawn
SKY = f4(-1.0)  # id where there is nothing

LANES = 8  # columns that are worked on at a time

SAMPLES = 4  # of each pixel, for edges

# Lines of the row buffer.
PIXEL_X, DEPTH, ID, NORMAL_X, NORMAL_Y, NORMAL_Z, RED, GREEN, BLUE, SHADOW, OPEN = range(11)
SCRATCH = 11  # six lines of scratch
SUB_DEPTH = 17
SUB_ID = 18  # one line for each sample
LINE_COUNT = SUB_ID + SAMPLES

FLOATS = (
    # The eye, the picture's axes and the direction to the sun, in the item's frame.
    *("eye_x", "eye_y", "eye_z", "forward_x", "forward_y", "forward_z", "right_x", "right_y", "right_z"),
    *("up_x", "up_y", "up_z", "sun_x", "sun_y", "sun_z"),
    # Its axes in the world.
    *("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
    *("size_x", "size_y", "size_z", "radius", "reach"),
    *("red", "green", "blue", "mark_red", "mark_green", "mark_blue"),
)
DOUBLES = (
    # World place from the eye; bounding box in its own frame: middle and half extents; bounding sphere.
    *("at_x", "at_y", "at_z", "mid_x", "mid_y", "mid_z", "half_x", "half_y", "half_z"),
    *("center_x", "center_y", "center_z", "bound"),
)


def item_dtype() -> np.dtype[Any]:
    """A primitive, ready to be drawn. Empty rows top..bottom-1 where it is out of view."""
    names = ("kind", "ball", "mark", "top", "bottom", "left", "right", "first", "count", "columns", "rows")
    fields = [(name, "i4") for name in names]
    fields += [(name, "f8") for name in DOUBLES]
    fields += [(name, "f4") for name in FLOATS]
    return np.dtype(fields, align=True)


def pair_dtype() -> np.dtype[Any]:
    """Pixels of `receiver` that `occluder` may darken."""
    names = ("receiver", "occluder", "top", "bottom", "left", "right")
    return np.dtype([(name, "i4") for name in names], align=True)


def view_dtype() -> np.dtype[Any]:
    """Camera and light. Pixel (i, j) has x = left + (j + 1/2) step, y = top - (i + 1/2) step."""
    names: tuple[str, ...] = ("eye_x", "eye_y", "eye_z", "forward_x", "forward_y", "forward_z")
    names += ("right_x", "right_y", "right_z", "up_x", "up_y", "up_z", "sun_x", "sun_y", "sun_z")
    names += ("left", "top", "step", "softness", "reach", "cell")
    return np.dtype([(name, "f8") for name in names] + [("width", "i4"), ("height", "i4")], align=True)


def look_dtype() -> np.dtype[Any]:
    """What the row kernels need of `view_dtype`, linear lights, and the screen colours of the air."""
    names: tuple[str, ...] = ("forward_x", "forward_y", "forward_z", "right_x", "right_y", "right_z")
    names += ("up_x", "up_y", "up_z", "sun_x", "sun_y", "sun_z", "left", "top", "step", "softness", "cell", "fog")
    for name in ("sun", "sky", "bounce", "horizon", "zenith"):
        names += (f"{name}_red", f"{name}_green", f"{name}_blue")
    return np.dtype([(name, "f4") for name in names], align=True)


ITEM = item_dtype()
PAIR = pair_dtype()
VIEW = view_dtype()
LOOK = look_dtype()
