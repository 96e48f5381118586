"""Which item may darken which, and in which pixels."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.primitives import HEIGHTFIELD, PLANE
from gsenv.render.spatial.setup import NO_BOUNDS, Bounds, corner, grow, store_bounds, to_frame
from gsenv.solver.jit import njit

MARGIN = 0.01  # m


@njit
def find_sweep(receiver: Any, occluder: Any, view: Any) -> tuple[float, float]:
    """First and last distance (m) along the sunlight at which the occluder's box can darken the receiver's.

    A corner enters the receiver's box at the latest of its entries into the three slabs. That is convex in the
    corner's place, so the corners bound it for all points of the occluder. Empty: first > last.
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
def find_shadow(receiver: Any, occluder: Any, view: Any) -> Bounds:
    """Picture of the part of the occluder's shadow that can lie on the receiver."""
    first, last = find_sweep(receiver, occluder, view)
    bounds = NO_BOUNDS
    if first > last:
        return bounds
    for k in range(8):
        x, y, z = corner(occluder, k)
        for end in range(2):
            s = first if end == 0 else last
            radius = view.softness * s + MARGIN
            bounds = grow(bounds, view, x - s * view.sun_x, y - s * view.sun_y, z - s * view.sun_z, radius)
    return bounds


@njit
def find_vicinity(receiver: Any, occluder: Any, view: Any) -> Bounds:
    """Picture of what lies within the occluder's reach; of a plane, that part of the receiver."""
    bounds = NO_BOUNDS
    box, reach = occluder, 2.0 * occluder.reach  # from a probe that is itself one reach away
    if occluder.kind == PLANE:
        box = receiver
        nearest = 1e30
        for k in range(8):
            x, y, z = corner(receiver, k)
            place = to_frame(occluder, x - occluder.at_x, y - occluder.at_y, z - occluder.at_z)
            nearest = min(nearest, place[2])
        if nearest > reach:
            return bounds
    elif receiver.kind == PLANE:
        x, y, z = occluder.center_x - receiver.at_x, occluder.center_y - receiver.at_y, occluder.center_z - receiver.at_z
        if to_frame(receiver, x, y, z)[2] > occluder.bound + reach:
            return bounds
    else:
        x, y, z = occluder.center_x - receiver.center_x, occluder.center_y - receiver.center_y, occluder.center_z - receiver.center_z
        if x * x + y * y + z * z > (occluder.bound + receiver.bound + reach) ** 2:
            return bounds
    for k in range(8):
        x, y, z = corner(box, k)
        bounds = grow(bounds, view, x, y, z, reach)
    return bounds


@njit
def find_pairs(
    items: NDArray[np.void],
    count: int,
    views: NDArray[np.void],
    shadows: NDArray[np.void],
    contacts: NDArray[np.void],
) -> tuple[int, int]:
    """Fill both kinds of pairs; returns how many there are of each, also where the arrays are too short.

    The last entry of each array is scratch.
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
            if occluder.kind != PLANE:
                pair = shadows[min(shadow_count, len(shadows) - 1)]
                if store_pair(pair, r, k, receiver, view, find_shadow(receiver, occluder, view)):
                    shadow_count += 1
            elif receiver.kind == PLANE:
                continue
            if len(contacts) > 1:
                pair = contacts[min(contact_count, len(contacts) - 1)]
                if store_pair(pair, r, k, receiver, view, find_vicinity(receiver, occluder, view)):
                    contact_count += 1
    return shadow_count, contact_count


@njit
def store_pair(pair: Any, r: int, k: int, receiver: Any, view: Any, bounds: Bounds) -> bool:
    """Whether the receiver has pixels in `bounds`."""
    if bounds[0] > bounds[1]:
        return False
    store_bounds(pair, view, bounds)
    pair.receiver, pair.occluder = r, k
    pair.top, pair.bottom = max(pair.top, receiver.top), min(pair.bottom, receiver.bottom)
    pair.left, pair.right = max(pair.left, receiver.left), min(pair.right, receiver.right)
    return pair.top < pair.bottom and pair.left < pair.right
