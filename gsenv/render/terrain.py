"""Projected terrains: the surfaces and segments from which the row kernels find the ground."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Camera
from gsenv.render.draw_list import DrawFlag, DrawKind, DrawList

FloatArray = NDArray[np.float32]

FAR = 1e9  # px
RUNOUT = 64.0  # px beyond the picture to which the ends of an open chain are extended


class TerrainLines(NamedTuple):
    """All terrains of a draw list in px.

    tops: (terrain,) y of the highest point of the ground
    surfaces: (terrain, 1 or height, width) y of the surface: by column for a height profile, by row
        and column if any chain is closed or overhangs
    segments: (segment, 4) ax, ay, bx, by of segments near the picture
    segment_first: (terrain + 1,) index of each terrain's first segment
    """

    tops: FloatArray
    surfaces: FloatArray
    segments: FloatArray
    segment_first: NDArray[np.int64]


NO_TERRAIN = TerrainLines(
    tops=np.zeros(1, np.float32),
    surfaces=np.zeros((1, 1, 1), np.float32),
    segments=np.zeros((1, 4), np.float32),
    segment_first=np.zeros(2, np.int64),
)


def project_terrains(draw_list: DrawList, camera: Camera, width: int, height: int, reach: float) -> TerrainLines:
    """Project all terrains of the list; distances will be exact within `reach` px of the chains."""
    items, vertices = draw_list
    terrains = items[items["kind"] == DrawKind.TERRAIN]
    if not len(terrains):
        return NO_TERRAIN
    tops, surfaces, segments = [], [], []
    for item in terrains:
        chain = camera.to_pixel(place_chain(item, vertices), width, height)
        closed = bool(item["flags"] & DrawFlag.CLOSED)
        outline = chain if closed else close_chain(chain, height)
        if not closed and (np.diff(chain[:, 0]) >= 0.0).all():
            columns = np.arange(width) + 0.5
            x, y = chain.T
            surface = np.interp(columns, x, y, left=FAR, right=FAR)[None, :]
            tops.append(chain[:, 1].min())
        else:
            surface = fold_surface(outline, width, height, reach)
            tops.append(0.0)
        surfaces.append(surface)
        segments.append(select_segments(outline, width, height, reach))
    return TerrainLines(
        tops=np.array(tops, np.float32),
        surfaces=np.array(np.broadcast_arrays(*surfaces), np.float32),
        segments=np.concatenate(segments),
        segment_first=np.cumsum([0, *map(len, segments)]),
    )


def place_chain(item: Any, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the vertices (vertex, 2) in m in the world frame."""
    first = item["vertex_first"]
    chain = vertices[first : first + item["vertex_count"]]
    cos, sin = item["rotation"]
    placed: NDArray[np.float64] = chain @ np.array([[cos, sin], [-sin, cos]]) + item["position"]
    return placed


def close_chain(chain: NDArray[np.float64], height: int) -> NDArray[np.float64]:
    """Extend both ends vertically out of the picture: down if the chain runs to the right, else up.

    The ground is on the right of the chain's direction, so a chain that ends in the picture shows walls.
    """
    runs_right = chain[-1, 0] >= chain[0, 0]
    out = max(chain[:, 1].max(), height) if runs_right else min(chain[:, 1].min(), 0.0)
    out += RUNOUT if runs_right else -RUNOUT
    return np.concatenate([[[chain[0, 0], out]], chain, [[chain[-1, 0], out]]])


def fold_surface(outline: NDArray[np.float64], width: int, height: int, reach: float) -> NDArray[np.float64]:
    """Return a surface (height, width) that lies `reach` above each ground pixel and far below all others.

    The signed number of crossings to a pixel's left is its winding number, which tells ground from air.
    """
    after = np.roll(outline, -1, axis=0)
    rows = np.arange(height) + 0.5
    turns = np.zeros((height, width + 1))
    for (ax, ay), (bx, by) in zip(outline, after, strict=True):
        first, last = np.clip(np.ceil(np.sort([ay, by]) - 0.5), 0, height).astype(int)
        if last > first:
            crossing = ax + (bx - ax) * (rows[first:last] - ay) / (by - ay)
            columns = np.clip(np.ceil(crossing - 0.5), 0, width).astype(int)
            turns[np.arange(first, last), columns] += np.sign(by - ay)
    winding = np.cumsum(turns, axis=1)[:, :width]
    area = 0.5 * np.sum(outline[:, 0] * after[:, 1] - after[:, 0] * outline[:, 1])
    # Pixel y points down, and the ground is on the right: a positive area encloses ground.
    ground = winding != 0.0 if area > 0.0 else winding == 0.0
    return np.asarray(rows[:, None] + np.where(ground, -reach, FAR), np.float64)


def select_segments(outline: NDArray[np.float64], width: int, height: int, reach: float) -> FloatArray:
    """Return the segments (segment, 4) of the closed outline within `reach` px of the picture."""
    segments = np.concatenate([outline, np.roll(outline, -1, axis=0)], axis=1)
    low = np.minimum(segments[:, :2], segments[:, 2:])
    high = np.maximum(segments[:, :2], segments[:, 2:])
    near = (high > -reach).all(axis=1) & (low < (width + reach, height + reach)).all(axis=1)
    return segments[near].astype(np.float32)
