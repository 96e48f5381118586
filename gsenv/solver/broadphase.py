"""Pairs of shapes whose boxes meet, in 2D and 3D.

Few shapes are compared each with each.  Many are put in the order of a space-filling curve, with
boxes over runs of them in an implicit tree (node k has the children 2k and 2k+1, as in
planar/vertices.py); each shape then asks the tree for its partners.  The tree is built anew in each
step: the result depends on the present state alone.  Unbounded shapes stay outside of it.

Source of the method: T. Karras, "Maximizing parallelism in the construction of BVHs" (2012), with
the tree made implicit by cutting the curve into equal runs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import inline_njit, njit

Array = NDArray[Any]

BRUTE_FORCE_COUNT = 160  # at most so many shapes are compared each with each
LEAF_SHAPES = 4
RADIX = 1024  # buckets of a pass of the sort
PASSES = 3
CURVE_BITS = 10  # of each axis


def broadphase_dtype(dim: int) -> np.dtype[Any]:
    """Scratch of find_pairs; only the first `sort` entries of each part mean anything."""
    return np.dtype(
        [
            ("lower", "f8", (dim,)),  # m, entry k-1: box of node k
            ("upper", "f8", (dim,)),
            ("awake", "i4"),  # entry k-1: 1 if any shape under node k is awake
            ("key", "i4"),  # place on the curve
            ("order", "i4"),  # shapes along the curve
            ("spare_key", "i4"),
            ("spare_order", "i4"),
            ("loose", "i4"),  # shapes without bounds, ascending
            ("partner", "i4"),  # of the shape that asks
            ("mark", "i4"),  # 1: shape is a partner
            ("bucket", "i4"),
        ],
        align=True,
    )


def broadphase_scratch(shape_count: int, dim: int) -> Array | None:
    """Scratch of find_pairs for so many shapes; None where it needs (and compiles) no tree."""
    if shape_count <= BRUTE_FORCE_COUNT:
        return None
    leaves = 1
    while leaves * LEAF_SHAPES < shape_count:
        leaves *= 2
    return np.zeros(max(shape_count, 2 * leaves, RADIX), broadphase_dtype(dim))


def encode_exclusion(body_a: int, body_b: int) -> int:
    """Code of two bodies whose shapes never touch; find_pairs takes a sorted int64 array of them."""
    return (min(int(body_a), int(body_b)) << 32) | max(int(body_a), int(body_b))


@njit
def is_excluded(exclusions: Array, body_a: int, body_b: int) -> bool:
    """Binary search for the pair of bodies."""
    code = (np.int64(min(body_a, body_b)) << 32) | np.int64(max(body_a, body_b))
    low = 0
    high = len(exclusions)
    while low < high:
        middle = (low + high) >> 1
        if exclusions[middle] < code:
            low = middle + 1
        else:
            high = middle
    return low < len(exclusions) and exclusions[low] == code


@njit
def may_touch(shape_a: Any, shape_b: Any, exclusions: Array | None) -> bool:
    """Filters: body, category bits, excluded body pairs. The arguments are shape models."""
    if shape_a.body == shape_b.body:
        return False
    if (shape_a.category & shape_b.mask) == 0 or (shape_b.category & shape_a.mask) == 0:
        return False
    if exclusions is not None:
        return not is_excluded(exclusions, shape_a.body, shape_b.body)
    return True


@inline_njit
def boxes_meet(one: Any, other: Any) -> bool:
    """Two entries with `lower` and `upper`; written so that NaN meets nothing."""
    meet = True
    for axis in range(len(one.lower)):  # no branches: 10 times faster on piles
        meet = meet & (one.lower[axis] <= other.upper[axis]) & (other.lower[axis] <= one.upper[axis])
    return meet


@inline_njit
def is_near(one: Any, other: Any) -> bool:
    """What two entries of the geometry say: one awake, one dynamic, boxes that meet."""
    may = ((one.awake | other.awake) & (one.dynamic | other.dynamic) & other.active) != 0
    return may and boxes_meet(one, other)


@njit
def find_pairs(
    geometry: Array,
    shape_models: Array,
    exclusions: Array | None,
    scratch: Array | None,
    pairs: Array,
) -> int:
    """Pairs (shape_a < shape_b) that may touch in this step, sorted; returns how many there are.

    `geometry`, `shape_models` (shape,), `exclusions` sorted codes of encode_exclusion or None,
    `scratch` of broadphase_scratch or None, `pairs` of PAIR_DTYPE.  If the result exceeds
    len(pairs), only the first ones were written: make room for that many and ask again.

    At least one of the two is awake, at least one is dynamic, and they are on different bodies.
    """
    if scratch is not None:
        return find_pairs_by_tree(geometry, shape_models, exclusions, scratch, pairs)
    count = 0
    for a in range(len(geometry)):
        if geometry[a].active == 0:
            continue
        for b in range(a + 1, len(geometry)):
            if not is_near(geometry[a], geometry[b]):
                continue
            if may_touch(shape_models[a], shape_models[b], exclusions):
                if count < len(pairs):
                    pairs[count].shape_a = a
                    pairs[count].shape_b = b
                count += 1
    return count


@njit
def find_pairs_by_tree(
    geometry: Array, shape_models: Array, exclusions: Array | None, scratch: Array, pairs: Array
) -> int:
    """The same for many shapes."""
    shape_count, loose_count = list_shapes(geometry, scratch)
    sort_along_curve(geometry, scratch, shape_count)
    leaves = build_tree(geometry, scratch, shape_count)
    count = 0
    for a in range(len(geometry)):
        if geometry[a].active == 0:
            continue
        found = ask_tree(geometry, shape_models, exclusions, scratch, shape_count, leaves, loose_count, a)
        sort_partners(scratch, found, a, len(geometry))
        for i in range(found):
            if count < len(pairs):
                pairs[count].shape_a = a
                pairs[count].shape_b = scratch[i].partner
            count += 1
    return count


@njit
def list_shapes(geometry: Array, scratch: Array) -> tuple[int, int]:
    """Put active shapes with bounds into `order`, those without into `loose`; two counts."""
    bounded = 0
    loose = 0
    for k in range(len(geometry)):
        entry = geometry[k]
        if entry.active == 0:
            continue
        size = 0.0
        for axis in range(len(entry.lower)):
            size += entry.upper[axis] - entry.lower[axis]
        if size < np.inf:
            scratch[bounded].order = k
            bounded += 1
        else:  # NaN too: it meets nothing, but it must not spoil the curve
            scratch[loose].loose = k
            loose += 1
    return bounded, loose


@njit
def sort_along_curve(geometry: Array, scratch: Array, count: int) -> None:
    """Order the shapes along the Z curve of their centres, equal places by index."""
    for i in range(count):
        scratch[i].key = 0
    dim = len(geometry[0].lower)
    for axis in range(dim):
        lowest, width = spread(geometry, scratch, count, axis)
        scale = (1 << CURVE_BITS) / width if width > 0.0 else 0.0
        top = (1 << CURVE_BITS) - 1
        for i in range(count):
            place = (center(geometry[scratch[i].order], axis) - lowest) * scale
            cell = int(min(max(place, 0.0), float(top)))
            for bit in range(CURVE_BITS):
                scratch[i].key |= ((cell >> bit) & 1) << (bit * dim + axis)
    for sweep in range(PASSES):
        radix_pass(scratch, count, 10 * sweep)
        for i in range(count):
            scratch[i].order = scratch[i].spare_order
            scratch[i].key = scratch[i].spare_key


@njit
def center(entry: Any, axis: int) -> float:
    return 0.5 * (entry.lower[axis] + entry.upper[axis])


@njit
def spread(geometry: Array, scratch: Array, count: int, axis: int) -> tuple[float, float]:
    """Start and width of the range that the curve resolves along an axis.

    Eight mean deviations around the mean: one body that fell off the world must not blur the rest.
    """
    if count == 0:
        return 0.0, 0.0
    mean = 0.0
    for i in range(count):
        mean += center(geometry[scratch[i].order], axis)
    mean /= count
    deviation = 0.0
    for i in range(count):
        deviation += abs(center(geometry[scratch[i].order], axis) - mean)
    deviation /= count
    return mean - 4.0 * deviation, 8.0 * deviation


@njit
def radix_pass(scratch: Array, count: int, shift: int) -> None:
    for k in range(RADIX):
        scratch[k].bucket = 0
    for i in range(count):
        scratch[(scratch[i].key >> shift) & (RADIX - 1)].bucket += 1
    start = 0
    for k in range(RADIX):
        size = scratch[k].bucket
        scratch[k].bucket = start
        start += size
    for i in range(count):
        bucket = (scratch[i].key >> shift) & (RADIX - 1)
        place = scratch[bucket].bucket
        scratch[bucket].bucket = place + 1
        scratch[place].spare_key = scratch[i].key
        scratch[place].spare_order = scratch[i].order


@njit
def build_tree(geometry: Array, scratch: Array, count: int) -> int:
    """Boxes of all nodes; returns the number of leaves."""
    leaves = 1
    while leaves * LEAF_SHAPES < count:
        leaves *= 2
    for leaf in range(leaves):
        node = scratch[leaves + leaf - 1]
        clear_node(node)
        for i in range(leaf * LEAF_SHAPES, min((leaf + 1) * LEAF_SHAPES, count)):
            grow_node(node, geometry[scratch[i].order])
    for k in range(leaves - 1, 0, -1):
        node = scratch[k - 1]
        clear_node(node)
        grow_node(node, scratch[2 * k - 1])
        grow_node(node, scratch[2 * k])
    return leaves


@njit
def clear_node(node: Any) -> None:
    for axis in range(len(node.lower)):
        node.lower[axis] = np.inf
        node.upper[axis] = -np.inf
    node.awake = 0


@njit
def grow_node(node: Any, entry: Any) -> None:
    for axis in range(len(node.lower)):
        node.lower[axis] = min(node.lower[axis], entry.lower[axis])
        node.upper[axis] = max(node.upper[axis], entry.upper[axis])
    node.awake |= entry.awake


@njit
def ask_tree(
    geometry: Array,
    shape_models: Array,
    exclusions: Array | None,
    scratch: Array,
    count: int,
    leaves: int,
    loose_count: int,
    a: int,
) -> int:
    """Write the partners b > a of shape a, in any order; returns how many."""
    found = 0
    asking = geometry[a]
    for i in range(loose_count):
        b = int64(scratch[i].loose)
        if b > a and is_near(asking, geometry[b]):
            if may_touch(shape_models[a], shape_models[b], exclusions):
                scratch[found].partner = b
                found += 1
    node = 1
    while True:
        # a sleeping shape looks for awake ones alone
        entry = scratch[node - 1]
        if (asking.awake | entry.awake) != 0 and boxes_meet(asking, entry):
            if node < leaves:
                node *= 2
                continue
            first = (node - leaves) * LEAF_SHAPES
            for i in range(first, min(first + LEAF_SHAPES, count)):
                b = int64(scratch[i].order)
                if b > a and is_near(asking, geometry[b]):
                    if may_touch(shape_models[a], shape_models[b], exclusions):
                        scratch[found].partner = b
                        found += 1
        while node & 1:  # up from right children
            node >>= 1
        if node == 0:
            return found
        node += 1


@njit
def sort_partners(scratch: Array, found: int, a: int, shape_count: int) -> None:
    """Ascending: by insertion if they are few, else by marking them among all shapes."""
    if found * found > 4 * (shape_count - a):
        for i in range(found):
            scratch[scratch[i].partner].mark = 1
        place = 0
        for b in range(a + 1, shape_count):
            if scratch[b].mark != 0:
                scratch[b].mark = 0
                scratch[place].partner = b
                place += 1
        return
    for i in range(1, found):
        b = scratch[i].partner
        k = i
        while k > 0 and scratch[k - 1].partner > b:
            scratch[k].partner = scratch[k - 1].partner
            k -= 1
        scratch[k].partner = b
