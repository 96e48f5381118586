"""Pairs of near shapes that are kept for several steps, while all shapes stay within somewhat wider boxes.

Where little moves, the pairs of the wider boxes are searched once; in later steps only these are tested.  One body that
moves much ends this for all.  The result is always that of find_pairs, whatever was kept and of whichever world, so
nothing here belongs to the state of a world.  Box2D and Bullet widen boxes too, and search those again that were left.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ..jit import njit
from .broadphase import find_pairs, is_near, put_pair

Array = NDArray[Any]

LEAST_SHAPES = 48  # of a scene that keeps pairs: the kernels of others do without
WIDER = 0.1  # of a body's extent: how much wider the boxes are
SLOW = 0.25  # of that: a motion in one step up to which the search for wider boxes is worth its time
LONGEST = 63  # twice the searches without a try where much moves, so that tries cost nothing there


@njit
def find_near_pairs(world: Any, boxes: Array | None) -> int:
    """Do the same as find_pairs with the scratch of a world; ``boxes`` (shape,): the kept ones, or None."""
    if boxes is not None:
        if len(boxes) >= LEAST_SHAPES:  # the kernel of all scenes has them for small ones, too
            return pairs_from_kept(world, boxes)
    return find_all_pairs(world)


@njit
def find_all_pairs(world: Any) -> int:
    """Search all pairs."""
    scratch = world.scratch
    return find_pairs(scratch.geometry, world.shapes.models, world.model.exclusions, scratch.broadphase, scratch.pairs)


@njit
def pairs_from_kept(world: Any, boxes: Array) -> int:
    """Do the same where pairs may be kept."""
    geometry = world.scratch.geometry
    first = boxes[0]
    if first.wait > 0:
        first.wait -= 1
        if first.wait == 0:
            keep_boxes(geometry, boxes)
        return find_all_pairs(world)
    if first.pairs > 0 and all_inside(geometry, boxes, np.inf):
        return near_of_kept(world, boxes)
    if first.pairs > 0 or not all_inside(geometry, boxes, SLOW * WIDER):
        first.pause = 0 if first.pairs > 0 else min(2 * first.pause + 1, LONGEST)
        first.wait = first.pause // 2
        first.pairs = 0
        if first.wait == 0:
            keep_boxes(geometry, boxes)
        return find_all_pairs(world)
    first.pause = 0
    exchange_boxes(geometry, boxes, WIDER)
    count = find_all_pairs(world)
    exchange_boxes(geometry, boxes, 0.0)
    pairs = world.scratch.pairs
    kept = world.scratch.kept_pairs
    if count > len(kept):
        return count
    for i in range(count):
        kept[i].shape_a = pairs[i].shape_a
        kept[i].shape_b = pairs[i].shape_b
    first.pairs = count + 1
    return near_of_kept(world, boxes)


@njit
def all_inside(geometry: Array, boxes: Array, share: float) -> bool:
    """Whether each active shape lies in its kept box, and all are active, dynamic and awake as they were then.

    With a finite ``share`` of the extent, by which the kept boxes are wider than those of their step, the present ones
    may not be smaller than these by more: the boxes of a shorter step are, however fast their shapes.
    """
    for k in range(len(geometry)):
        entry = geometry[k]
        box = boxes[k]
        if box.flags != flags_of(entry):
            return False
        if entry.active == 0:
            continue
        most = 2.0 * margin_of(entry, share) if share < np.inf else np.inf
        for axis in range(len(entry.lower)):
            if not (box.lower[axis] <= entry.lower[axis] and entry.upper[axis] <= box.upper[axis]):
                return False
            if entry.lower[axis] > box.lower[axis] + most or entry.upper[axis] < box.upper[axis] - most:
                return False
    return True


@njit
def flags_of(entry: Any) -> Any:
    """Return a number that is not 0 and tells what, beside the boxes, decides whether a shape may have partners."""
    return 1 + 2 * entry.active + 4 * entry.dynamic + 8 * entry.awake


@njit
def keep_boxes(geometry: Array, boxes: Array) -> None:
    """Keep the present boxes, wider by what a slow shape may move in one step."""
    for k in range(len(geometry)):
        entry = geometry[k]
        box = boxes[k]
        box.flags = flags_of(entry)
        margin = margin_of(entry, SLOW * WIDER)
        for axis in range(len(entry.lower)):
            box.lower[axis] = entry.lower[axis] - margin
            box.upper[axis] = entry.upper[axis] + margin


@njit
def exchange_boxes(geometry: Array, boxes: Array, wider: float) -> None:
    """Widen the present boxes and keep what they were; with 0, set them to that again and keep the wider ones."""
    for k in range(len(geometry)):
        entry = geometry[k]
        box = boxes[k]
        margin = margin_of(entry, wider)
        for axis in range(len(entry.lower)):
            lower = entry.lower[axis]
            upper = entry.upper[axis]
            entry.lower[axis] = lower - margin if wider > 0.0 else box.lower[axis]
            entry.upper[axis] = upper + margin if wider > 0.0 else box.upper[axis]
            box.lower[axis] = lower
            box.upper[axis] = upper


@njit
def margin_of(entry: Any, share: float) -> float:
    """Return this share of the extent of the shape's body, in m; 0 where it has none, as a static body."""
    return share * entry.extent if entry.dynamic != 0 and entry.extent < np.inf else 0.0


@njit
def near_of_kept(world: Any, boxes: Array) -> int:
    """Write the kept pairs whose shapes are near now; returns their number. They stay sorted."""
    geometry = world.scratch.geometry
    pairs = world.scratch.pairs
    kept = world.scratch.kept_pairs
    count = int64(0)
    for i in range(int64(boxes[0].pairs) - 1):
        a = int64(kept[i].shape_a)
        b = int64(kept[i].shape_b)
        if is_near(geometry[a], geometry[b]):
            put_pair(pairs, count, a, b)
            count += 1
    return count
