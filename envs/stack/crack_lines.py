"""How a cracked block is drawn: jagged lines across its faces."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gsenv.solver import World

Array = NDArray[Any]

INNER = 0.95  # of the half-extents: lines are thick, and end within the outline
OUT = 1.004  # of the half-extents: just in front of the faces
_PATHS = (  # on a face of the half-extents 1
    ((-0.20, -1.0), (0.08, -0.62), (-0.16, -0.30), (0.12, 0.10), (-0.08, 0.52), (0.16, 1.0)),
    ((-0.16, -0.30), (-0.48, -0.12), (-0.66, 0.26), (-1.0, 0.38)),
    ((0.12, 0.10), (0.46, 0.02), (0.70, -0.36), (1.0, -0.28)),
    ((-0.48, -0.12), (-0.62, -0.55), (-0.52, -1.0)),
    ((0.46, 0.02), (0.62, 0.44), (0.50, 1.0)),
)
FACE = np.array([pair for path in _PATHS for pair in pairwise(path)])  # (line, 2, 2)


def _on_box() -> Array:
    """Return the lines (line, 2, 3) on the four sides and the top of a box of the half-extents 1."""
    faces = []
    for axis, side in ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0)):
        face = np.full((*FACE.shape[:2], 3), side * OUT)
        others = [d for d in range(3) if d != axis]
        face[..., others[0]] = side * FACE[..., 0]
        face[..., others[1]] = FACE[..., 1]
        faces.append(face)
    return np.concatenate(faces)


BOX = _on_box()


def crack_lines(world: World, index: int, first_block: int, first_shape: int, cracked: int) -> Array:
    """Return the lines (line, 2, dim) in m of the blocks in the bit mask `cracked` of a world."""
    lines = []
    for k in range(cracked.bit_length()):
        if cracked >> k & 1:
            body = world.state.bodies[index, first_block + k]
            half = world.parameters.shapes["size"][index, first_shape + k]
            pattern = INNER * FACE if len(body["position"]) == 2 else BOX
            sign = np.where(np.arange(pattern.shape[-1]) == 0, 1.0 - 2.0 * (k % 2), 1.0)  # not all alike
            local = pattern * sign * half[: pattern.shape[-1]]
            lines.append(body["position"] + local @ _rotation(body["rotation"]).T)
    return np.concatenate(lines)


def _rotation(turn: Array) -> Array:
    """Return the matrix of a rotation, (cos, sin) or a quaternion."""
    if len(turn) == 2:
        c, s = turn
        return np.array([[c, -s], [s, c]])
    w, x, y, z = turn
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
