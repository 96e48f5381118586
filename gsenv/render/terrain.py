"""Terrains in pixels: what the row kernels need to tell ground from air."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Camera
from gsenv.render.draw_list import DrawFlag, DrawKind, DrawList

FloatArray = NDArray[np.float32]

FAR = 1e9  # px
RUNOUT = 64.0  # px beyond the picture to which the loose ends of a chain are led


class TerrainLines(NamedTuple):
    """All terrains of a list in px.

    tops: (terrain,) y of the highest point of the ground
    surfaces: (terrain, 1 or height, width) y of the surface above or below which ground is, by
        column, or by row and column where some chain folds over itself
    segments: (segment, 4) ax, ay, bx, by of those in sight
    segment_first: (terrain + 1,) where the segments of each terrain begin
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


def project_terrains(
    draw_list: DrawList, camera: Camera, width: int, height: int, reach: float
) -> TerrainLines:
    """All terrains of the list; `reach` in px is how far from the chain distances are exact."""
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
    """(vertex, 2) in m, world frame."""
    first = item["vertex_first"]
    chain = vertices[first : first + item["vertex_count"]]
    cos, sin = item["rotation"]
    placed: NDArray[np.float64] = chain @ np.array([[cos, sin], [-sin, cos]]) + item["position"]
    return placed


def close_chain(chain: NDArray[np.float64], height: int) -> NDArray[np.float64]:
    """Lead both ends out of the picture: down where the chain runs to the right, else up.

    The ground is on the right hand along the chain, so walls show where it ends in sight.
    """
    runs_right = chain[-1, 0] >= chain[0, 0]
    out = max(chain[:, 1].max(), height) if runs_right else min(chain[:, 1].min(), 0.0)
    out += RUNOUT if runs_right else -RUNOUT
    return np.concatenate([[[chain[0, 0], out]], chain, [[chain[-1, 0], out]]])


def fold_surface(
    outline: NDArray[np.float64], width: int, height: int, reach: float
) -> NDArray[np.float64]:
    """(height, width) surface just above pixels inside the outline and far below the others.

    A pixel's crossings to the left, each counted with its direction, tell on which hand it lies.
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
    # Pixel y points down: with the ground on the right hand, a positive area encloses ground.
    ground = winding != 0.0 if area > 0.0 else winding == 0.0
    return np.asarray(rows[:, None] + np.where(ground, -reach, FAR), np.float64)


def select_segments(
    outline: NDArray[np.float64], width: int, height: int, reach: float
) -> FloatArray:
    """(segment, 4) segments of the closed outline that come near the picture."""
    segments = np.concatenate([outline, np.roll(outline, -1, axis=0)], axis=1)
    low = np.minimum(segments[:, :2], segments[:, 2:])
    high = np.maximum(segments[:, :2], segments[:, 2:])
    near = (high > -reach).all(axis=1) & (low < (width + reach, height + reach)).all(axis=1)
    return segments[near].astype(np.float32)
