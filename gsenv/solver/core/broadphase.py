"""Broadphase: pairs of shapes whose bounding boxes overlap, in 2D and 3D.

Few shapes are compared each with each.  Many are sorted along a space-filling curve, and an implicit
tree holds the boxes of runs of them (node k has the children 2k and 2k+1, as in planar/vertices.py);
each leaf then searches the tree for later leaves whose boxes overlap its own, and the pairs are
sorted.  The tree is built again in each search: the result depends on the present state alone.
Unbounded shapes are not in the tree, nor are shapes far from all awake ones.

Source of the method: T. Karras, "Maximizing parallelism in the construction of BVHs" (2012), with
the tree made implicit by cutting the curve into equal runs.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ..jit import inline_njit, njit

Array = NDArray[Any]

BRUTE_FORCE_COUNT = 160  # largest number of shapes that are compared each with each
LEAF_SHAPES = 4
RADIX = 1024  # most buckets of one pass of the sort along the curve
CURVE_BITS = 10  # bits of each axis, and of a digit of the sort
COARSE_BITS = 5  # the same for few shapes, whose sort would take most of the time
FINE_COUNT = 1024  # shapes: for more the curve is fine


class Span(NamedTuple):
    """Positions first..last-1 of the order along the curve."""

    first: int
    last: int


class Tree(NamedTuple):
    """The bounding tree of a step."""

    shapes: int  # number of shapes in it
    leaves: int


def broadphase_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the scratch of find_pairs; each field uses only as many entries as it needs."""
    return np.dtype(
        [
            ("lower", "f8", (dim,)),  # m, entry k-1: box of node k
            ("upper", "f8", (dim,)),
            ("awake", "i4"),  # entry k-1: 1 if any shape under node k is awake
            ("key", "i4"),  # position on the curve
            ("order", "i4"),  # shapes along the curve
            ("spare_key", "i4"),
            ("spare_order", "i4"),
            ("loose", "i4"),  # shapes without bounds, ascending
            ("bucket", "i4"),
        ],
        align=True,
    )


def broadphase_scratch(shape_count: int, dim: int) -> Array | None:
    """Return the scratch of find_pairs for a number of shapes; None where it needs (and compiles) no tree."""
    if shape_count <= BRUTE_FORCE_COUNT:
        return None
    leaves = 1
    while leaves * LEAF_SHAPES < shape_count:
        leaves *= 2
    return np.zeros(max(shape_count, 2 * leaves, RADIX), broadphase_dtype(dim))


def encode_exclusion(body_a: int, body_b: int) -> int:
    """Return the code of two bodies whose shapes never touch; find_pairs takes a sorted int64 array of codes."""
    return (min(int(body_a), int(body_b)) << 32) | max(int(body_a), int(body_b))


@njit
def is_excluded(exclusions: Array, body_a: int, body_b: int) -> bool:
    """Whether a pair of bodies is excluded, by binary search."""
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


@inline_njit
def may_touch(shape_a: Any, shape_b: Any, exclusions: Array | None) -> bool:
    """Whether two shapes pass the filters: body, category bits, excluded body pairs. Takes shape models.

    The loops call it directly: inside a helper that takes arrays, numba counts references to these for
    each pair, at five times the cost of the filter.
    """
    if shape_a.body == shape_b.body:
        return False
    if (shape_a.category & shape_b.mask) == 0 or (shape_b.category & shape_a.mask) == 0:
        return False
    if exclusions is not None:
        if len(exclusions) > 0:  # a call costs ten times the other filters
            return not is_excluded(exclusions, shape_a.body, shape_b.body)
    return True


@inline_njit
def boxes_meet(one: Any, other: Any) -> bool:
    """Whether the boxes of two entries with `lower` and `upper` overlap; False for NaN."""
    meet = True
    for axis in range(len(one.lower)):  # no branches: 10 times faster on piles
        meet = meet & (one.lower[axis] <= other.upper[axis]) & (other.lower[axis] <= one.upper[axis])
    return meet


@inline_njit
def is_near(one: Any, other: Any) -> bool:
    """Whether of two entries of the geometry one is awake, one is dynamic, and the boxes overlap."""
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
    """Write the pairs (shape_a < shape_b) that may touch in this step, sorted; returns their number.

    `geometry`, `shape_models` (shape,), `exclusions` sorted codes of encode_exclusion or None,
    `scratch` of broadphase_scratch or None, `pairs` of PAIR_DTYPE.  If the result exceeds
    len(pairs), the content of `pairs` is not valid: enlarge it to that size and call again.

    At least one of the two shapes is awake, at least one is dynamic, and they are on different bodies.
    """
    if scratch is not None:
        if len(geometry) > BRUTE_FORCE_COUNT:  # the kernel of all scenes has the tree for small ones, too
            return find_pairs_by_tree(geometry, shape_models, exclusions, scratch, pairs)
    count = int64(0)
    first, last = awake_range(geometry)
    for a in range(len(geometry)):
        if geometry[a].active == 0:
            continue
        low = a + 1
        high = len(geometry)
        if geometry[a].awake == 0:  # only pairs with awake shapes
            low = max(low, first)
            high = last
        for b in range(low, high):
            if is_near(geometry[a], geometry[b]):
                if may_touch(shape_models[a], shape_models[b], exclusions):
                    put_pair(pairs, count, a, b)
                    count += 1
    return count


@njit
def awake_range(geometry: Array) -> tuple[int, int]:
    """Return the first awake shape and the one after the last; (0, 0) if there is none."""
    first = int64(0)
    last = int64(0)
    for k in range(len(geometry)):
        if geometry[k].awake != 0:
            if last == 0:
                first = int64(k)
            last = int64(k + 1)
    return first, last


@inline_njit
def put_pair(pairs: Array, place: int, a: int, b: int) -> None:
    if place < len(pairs):
        pairs[place].shape_a = min(a, b)
        pairs[place].shape_b = max(a, b)


@njit
def find_pairs_by_tree(
    geometry: Array, shape_models: Array, exclusions: Array | None, scratch: Array, pairs: Array
) -> int:
    """Do the same as find_pairs for many shapes."""
    shape_count, loose_count = list_shapes(geometry, scratch)
    count = pair_loose(geometry, shape_models, exclusions, scratch, shape_count, loose_count, pairs)
    sort_along_curve(geometry, scratch, shape_count)
    tree = build_tree(geometry, scratch, shape_count)
    for leaf in range((shape_count + LEAF_SHAPES - 1) // LEAF_SHAPES):
        count = pair_leaf(geometry, shape_models, exclusions, scratch, tree, leaf, pairs, count)
    if count <= len(pairs):
        sort_pairs(pairs, count, scratch, len(geometry))
    return count


@inline_njit
def pair_with(
    geometry: Array,
    shape_models: Array,
    exclusions: Array | None,
    scratch: Array,
    a: int,
    others: Span,
    pairs: Array,
    count: int,
) -> int:
    """Add the pairs of shape a with a range of the order; returns the number of pairs so far."""
    for k in range(others.first, others.last):
        b = int64(scratch[k].order)
        if is_near(geometry[a], geometry[b]):
            if may_touch(shape_models[a], shape_models[b], exclusions):
                put_pair(pairs, count, a, b)
                count += 1
    return count


@njit
def list_shapes(geometry: Array, scratch: Array) -> tuple[int, int]:
    """Write bounded active shapes to `order` and unbounded ones to `loose`; returns both numbers.

    Shapes outside the box around all awake shapes have no partners and are left out.
    """
    around = scratch[0]
    clear_node(around)
    for k in range(len(geometry)):
        if geometry[k].awake != 0 and boxes_meet(geometry[k], geometry[k]):  # NaN must not spread
            grow_node(around, geometry[k])
    bounded = 0
    loose = 0
    for k in range(len(geometry)):
        entry = geometry[k]
        if entry.active == 0 or not boxes_meet(entry, around):
            continue
        size = 0.0
        for axis in range(len(entry.lower)):
            size += entry.upper[axis] - entry.lower[axis]
        if size < np.inf:
            scratch[bounded].order = k
            bounded += 1
        else:
            scratch[loose].loose = k
            loose += 1
    return bounded, loose


@njit
def pair_loose(
    geometry: Array,
    shape_models: Array,
    exclusions: Array | None,
    scratch: Array,
    shape_count: int,
    loose_count: int,
    pairs: Array,
) -> int:
    """Write the pairs of unbounded shapes; returns their number."""
    count = int64(0)
    everywhere = Span(count, shape_count)
    for i in range(loose_count):
        a = int64(scratch[i].loose)
        for k in range(i + 1, loose_count):
            b = int64(scratch[k].loose)
            if is_near(geometry[a], geometry[b]):
                if may_touch(shape_models[a], shape_models[b], exclusions):
                    put_pair(pairs, count, a, b)
                    count += 1
        count = pair_with(geometry, shape_models, exclusions, scratch, a, everywhere, pairs, count)
    return count


@njit
def sort_along_curve(geometry: Array, scratch: Array, count: int) -> None:
    """Sort the shapes along the Z curve of their centres, then by index.

    The cells of the curve are as high as they are wide, so a tower is sorted by height, not by its lean.
    """
    dim = len(scratch[0].lower)
    bits = CURVE_BITS if count > FINE_COUNT else COARSE_BITS
    widest = 0.0
    for axis in range(dim):
        _, width = spread(geometry, scratch, count, axis)
        widest = max(widest, width)
    scale = (1 << bits) / widest if widest > 0.0 else 0.0
    top = float((1 << bits) - 1)
    for i in range(count):
        scratch[i].key = 0
    for axis in range(dim):
        lowest, _ = spread(geometry, scratch, count, axis)
        for i in range(count):
            place = (center(geometry[scratch[i].order], axis) - lowest) * scale
            cell = int(min(max(place, 0.0), top))
            key = 0
            for bit in range(bits):
                key |= ((cell >> bit) & 1) << (bit * dim + axis)
            scratch[i].key |= key
    for axis in range(dim):
        radix_pass(scratch, count, bits * axis, 1 << bits)
        for i in range(count):
            scratch[i].order = scratch[i].spare_order
            scratch[i].key = scratch[i].spare_key


@njit
def center(entry: Any, axis: int) -> float:
    return 0.5 * (entry.lower[axis] + entry.upper[axis])


@njit
def spread(geometry: Array, scratch: Array, count: int, axis: int) -> tuple[float, float]:
    """Return start and width of the range that the curve resolves along an axis, in m.

    It is eight mean deviations around the mean, so that one body far away does not coarsen the curve.
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
def clear_buckets(scratch: Array, bucket_count: int) -> None:
    for k in range(bucket_count):
        scratch[k].bucket = 0


@njit
def start_buckets(scratch: Array, bucket_count: int) -> None:
    """Replace the sizes of the buckets by their starts."""
    start = 0
    for k in range(bucket_count):
        size = scratch[k].bucket
        scratch[k].bucket = start
        start += size


@inline_njit
def take_place(scratch: Array, bucket: int) -> int:
    place = scratch[bucket].bucket
    scratch[bucket].bucket = place + 1
    return place


@njit
def radix_pass(scratch: Array, count: int, shift: int, radix: int) -> None:
    """Sort stably by one digit of the keys, of `radix` values (a power of two)."""
    clear_buckets(scratch, radix)
    for i in range(count):
        scratch[(scratch[i].key >> shift) & (radix - 1)].bucket += 1
    start_buckets(scratch, radix)
    for i in range(count):
        place = take_place(scratch, (scratch[i].key >> shift) & (radix - 1))
        scratch[place].spare_key = scratch[i].key
        scratch[place].spare_order = scratch[i].order


@njit
def build_tree(geometry: Array, scratch: Array, count: int) -> Tree:
    """Write the boxes of all nodes of the tree."""
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
    return Tree(count, leaves)


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
def pair_leaf(
    geometry: Array,
    shape_models: Array,
    exclusions: Array | None,
    scratch: Array,
    tree: Tree,
    leaf: int,
    pairs: Array,
    count: int,
) -> int:
    """Add the pairs within a leaf and with later leaves, in any order; returns the number of pairs so far."""
    own = span_of(tree, leaf)
    for i in range(own.first, own.last):
        after = Span(i + 1, own.last)
        count = pair_with(geometry, shape_models, exclusions, scratch, int64(scratch[i].order), after, pairs, count)
    node = tree.leaves + leaf
    box = scratch[node - 1]
    while True:
        while node & 1:  # up from right children
            node >>= 1
        if node == 0:
            return count
        node += 1
        # sleeping shapes need only awake partners
        while (box.awake | scratch[node - 1].awake) != 0 and boxes_meet(box, scratch[node - 1]):
            if node >= tree.leaves:
                others = span_of(tree, node - tree.leaves)
                for i in range(own.first, own.last):
                    a = int64(scratch[i].order)
                    if boxes_meet(geometry[a], scratch[node - 1]):
                        count = pair_with(geometry, shape_models, exclusions, scratch, a, others, pairs, count)
                break
            node *= 2


@inline_njit
def span_of(tree: Tree, leaf: int) -> Span:
    """Return the range of the order that a leaf covers."""
    return Span(leaf * LEAF_SHAPES, min((leaf + 1) * LEAF_SHAPES, tree.shapes))


@njit
def sort_pairs(pairs: Array, count: int, scratch: Array, shape_count: int) -> None:
    """Sort pairs by (shape_a, shape_b) in two stable counting passes."""
    clear_buckets(scratch, shape_count)
    for i in range(count):
        scratch[pairs[i].shape_b].bucket += 1
    start_buckets(scratch, shape_count)
    for i in range(count):
        place = take_place(scratch, pairs[i].shape_b)
        pairs[place].spare_a = pairs[i].shape_a
        pairs[place].spare_b = pairs[i].shape_b
    clear_buckets(scratch, shape_count)
    for i in range(count):
        scratch[pairs[i].spare_a].bucket += 1
    start_buckets(scratch, shape_count)
    for i in range(count):
        place = take_place(scratch, pairs[i].spare_a)
        pairs[place].shape_a = pairs[i].spare_a
        pairs[place].shape_b = pairs[i].spare_b
