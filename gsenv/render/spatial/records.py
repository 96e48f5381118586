"""Records that the 3D kernels share, and the lines of the row buffer.

A picture is computed row by row. `lines` (LINE_COUNT, width) float32 holds all buffers of the current row and
stays in the L1 and L2 caches. Kernels take the columns first..last-1 as unsigned integers and all constants
as float32: loops over signed columns do not vectorise, and one float64 would promote the whole row.

A ray is d = forward + x right + y up, not normalised: its parameter is the depth along `forward`, and its
components in any frame are linear in the column.
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

LANES = 8  # columns per SIMD group

SAMPLES = 4  # antialiasing samples per pixel

# Lines of the row buffer. VISIBILITY is the fraction of the sky that a surface sees.
PIXEL_X, DEPTH, ID, NORMAL_X, NORMAL_Y, NORMAL_Z, RED, GREEN, BLUE, SHADOW, VISIBILITY = range(11)
SCRATCH = 11  # six lines of scratch
SUB_DEPTH = 17
SUB_ID = 18  # one line for each sample
LINE_COUNT = SUB_ID + SAMPLES

FLOATS = (
    # the eye, the picture's axes and the direction to the sun, in the item's frame
    *("eye_x", "eye_y", "eye_z", "forward_x", "forward_y", "forward_z", "right_x", "right_y", "right_z"),
    *("up_x", "up_y", "up_z", "sun_x", "sun_y", "sun_z"),
    # the item's axes in the world
    *("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
    *("size_x", "size_y", "size_z", "radius", "reach"),
    *("red", "green", "blue", "mark_red", "mark_green", "mark_blue"),
)
DOUBLES = (
    # position from the eye; bounding box in its own frame: centre and half extents; bounding sphere from the eye
    *("at_x", "at_y", "at_z", "mid_x", "mid_y", "mid_z", "half_x", "half_y", "half_z"),
    *("center_x", "center_y", "center_z", "bound"),
)


def item_dtype() -> np.dtype[Any]:
    """Return the dtype of a projected primitive; its rows top..bottom-1 are empty if it is out of view."""
    names = ("kind", "ball", "mark", "top", "bottom", "left", "right", "first", "count", "columns", "rows")
    fields = [(name, "i4") for name in names]
    fields += [(name, "f8") for name in DOUBLES]
    fields += [(name, "f4") for name in FLOATS]
    return np.dtype(fields, align=True)


def pair_dtype() -> np.dtype[Any]:
    """Return the dtype of a pair: the pixels of item `receiver` that item `occluder` may shadow or occlude."""
    names = ("receiver", "occluder", "top", "bottom", "left", "right")
    return np.dtype([(name, "i4") for name in names], align=True)


def view_dtype() -> np.dtype[Any]:
    """Return the dtype of camera and light; pixel (i, j) has x = left + (j + 1/2) step, y = top - (i + 1/2) step."""
    names: tuple[str, ...] = ("eye_x", "eye_y", "eye_z", "forward_x", "forward_y", "forward_z")
    names += ("right_x", "right_y", "right_z", "up_x", "up_y", "up_z", "sun_x", "sun_y", "sun_z")
    names += ("left", "top", "step", "softness", "reach", "cell")
    return np.dtype([(name, "f8") for name in names] + [("width", "i4"), ("height", "i4")], align=True)


def look_dtype() -> np.dtype[Any]:
    """Return the float32 dtype of row kernels: view, linear light of sun, sky and bounce, colours of the air."""
    names: tuple[str, ...] = ("forward_x", "forward_y", "forward_z", "right_x", "right_y", "right_z")
    names += ("up_x", "up_y", "up_z", "sun_x", "sun_y", "sun_z", "left", "top", "step", "softness", "cell", "fog")
    for name in ("sun", "sky", "bounce", "horizon", "zenith"):
        names += (f"{name}_red", f"{name}_green", f"{name}_blue")
    return np.dtype([(name, "f4") for name in names], align=True)


ITEM = item_dtype()
PAIR = pair_dtype()
VIEW = view_dtype()
LOOK = look_dtype()
