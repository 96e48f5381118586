"""Pairs of items of which one may shadow or occlude the other, and the pixels concerned."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.primitives import HEIGHTFIELD, PLANE
from gsenv.render.spatial.setup import NO_BOUNDS, Bounds, corner, grow, store_bounds, to_frame
from gsenv.solver.jit import njit

MARGIN = 0.01  # m


@njit
def find_shadow_range(receiver: Any, occluder: Any, view: Any) -> tuple[float, float]:
    """Return the range (m) of displacements along the sunlight that move the occluder's box into the receiver's.

    A point enters the receiver's box when it has entered all three slabs. This time is a convex function of the
    point's position, so the occluder's corners bound it for all its points. The range is empty if first > last.
    """
    plane = receiver.kind == PLANE
    limit, spread = 1e9, 0.0
    if not plane:
        x = occluder.center_x - receiver.center_x
        y = occluder.center_y - receiver.center_y
        z = occluder.center_z - receiver.center_z
        ahead = x * view.sun_x + y * view.sun_y + z * view.sun_z
        limit = ahead + occluder.bound + receiver.bound
        spread = view.softness * max(limit, 0.0) + MARGIN
        room = occluder.bound + receiver.bound + spread
        if limit <= 0.0 or x * x + y * y + z * z - ahead * ahead > room * room:
            return 1.0, 0.0
    elif receiver.sun_z <= 1e-3:
        return 1.0, 0.0
    first, last, leave = -1e30, -1e30, 1e30
    speeds = (-receiver.sun_x, -receiver.sun_y, -receiver.sun_z)
    mids = (receiver.mid_x, receiver.mid_y, receiver.mid_z)
    halves = (receiver.half_x, receiver.half_y, receiver.half_z)
    for axis in range(2 if plane else 0, 3):
        speed = abs(speeds[axis])
        if speed < 1e-6:
            continue
        low, high = 1e30, -1e30
        for k in range(8):
            x, y, z = corner(occluder, k)
            place = to_frame(receiver, x - receiver.at_x, y - receiver.at_y, z - receiver.at_z)
            middle = -(place[axis] - mids[axis]) / speeds[axis]
            low, high = min(low, middle), max(high, middle)
        outer, inner = (halves[axis] + spread) / speed, (halves[axis] - spread) / speed
        first, last, leave = max(first, low - outer), max(last, high - inner), min(leave, high + outer)
    if first > leave or leave < 0.0:
        return 1.0, 0.0
    return max(first, 0.0), min(last, limit)


@njit
def is_near(receiver: Any, occluder: Any, reach: float) -> bool:
    """Whether a part of the receiver may lie within `reach` m of the occluder."""
    x = occluder.center_x - receiver.center_x
    y = occluder.center_y - receiver.center_y
    z = occluder.center_z - receiver.center_z
    room = occluder.bound + receiver.bound + reach
    if occluder.kind == PLANE:
        return to_frame(occluder, -x, -y, -z)[2] < receiver.bound + reach
    if receiver.kind == PLANE:
        return to_frame(receiver, x, y, z)[2] < occluder.bound + reach
    return x * x + y * y + z * z < room * room


@njit
def find_bounds(box: Any, view: Any, first: float, last: float, radius: float) -> Bounds:
    """Return the picture bounds of a box swept along the sunlight from `first` to `last` m, grown by `radius` m."""
    bounds = NO_BOUNDS
    for k in range(16):
        x, y, z = corner(box, k % 8)
        s = first if k < 8 else last
        bounds = grow(bounds, view, x - s * view.sun_x, y - s * view.sun_y, z - s * view.sun_z, radius)
    return bounds


@njit
def find_pairs(
    items: NDArray[np.void],
    count: int,
    views: NDArray[np.void],
    shadows: NDArray[np.void],
    contacts: NDArray[np.void],
) -> tuple[int, int]:
    """Find the pairs for shadows and for ambient occlusion (`contacts`); return the number of each.

    The numbers are right even if an array is too short. The last entry of each array is scratch.
    """
    view = views[0]
    shadow_count, contact_count = 0, 0
    for r in range(count):
        receiver = items[r]
        if receiver.top >= receiver.bottom:
            continue
        for k in range(count):
            occluder = items[k]
            if k == r or occluder.kind == HEIGHTFIELD:
                continue
            first, last = (1.0, 0.0) if occluder.kind == PLANE else find_shadow_range(receiver, occluder, view)
            if first <= last:
                bounds = find_bounds(occluder, view, first, last, view.softness * last + MARGIN)
                pair = shadows[min(shadow_count, len(shadows) - 1)]
                shadow_count += store_pair(pair, r, k, receiver, view, bounds)
            reach = 2.0 * occluder.reach  # the probe is already one reach above the receiver
            both = occluder.kind == PLANE and receiver.kind == PLANE
            if len(contacts) > 1 and not both and is_near(receiver, occluder, reach):
                bounds = find_bounds(receiver if occluder.kind == PLANE else occluder, view, 0.0, 0.0, reach)
                pair = contacts[min(contact_count, len(contacts) - 1)]
                contact_count += store_pair(pair, r, k, receiver, view, bounds)
    return shadow_count, contact_count


@njit
def store_pair(pair: Any, r: int, k: int, receiver: Any, view: Any, bounds: Bounds) -> int:
    """Store a pair; return 1 if the receiver has pixels in `bounds`, else 0."""
    store_bounds(pair, view, bounds)
    pair.receiver, pair.occluder = r, k
    pair.top, pair.bottom = max(pair.top, receiver.top), min(pair.bottom, receiver.bottom)
    pair.left, pair.right = max(pair.left, receiver.left), min(pair.right, receiver.right)
    return 1 if pair.top < pair.bottom and pair.left < pair.right else 0
