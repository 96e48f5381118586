"""Contacts of heightfields with spheres, boxes, capsules, cylinders and hulls.

Contacts are between features whose normals can be opposite (as in a Minkowski sum): a corner of the
shape over a face of the field, an edge of the shape across a ridge, a face of the shape on a peak.
A direction counts only if the field as a whole allows it: straight up from a face, between the normals of
the two faces at a ridge, away from all neighbours at a peak, none where the ground is flat or concave.  So
nothing catches on the edges between triangles.  A corner in a valley touches both sides.

A corner below the surface is pushed only to the nearest point of it.  A shape whose centre is deeper than
its extent is behind the field and has no contacts with it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.faces import FACE_OF_A, FACE_OF_B
from ...core.geometry import PlacedShape
from ...jit import njit
from ..kinds import CAPSULE, CYLINDER, SPHERE
from ..math import Pose, Vec, add, along, cross, dot, norm, relative, rotate, scaled, sub, to_world, vec
from .field_bodies import Body, body_over_field, depth_inside, faces_ground, reach_along, slack_of
from .field_rounds import cylinder_on_face, round_on_fold, round_on_peak
from .fields import (
    FLAT,
    TILT,
    Cell,
    Fold,
    Grid,
    beyond_fold,
    beyond_peak,
    cell_top,
    closest_on_segment,
    closest_on_triangle,
    edge_end,
    fold_of,
    grid_of,
    has_edge,
    height_above,
    is_over,
    is_peak,
    is_ridge,
    normal_of,
    sample,
    span_of,
    triangle,
)
from .manifold import clear_manifold, set_normal
from .spread import CHOSEN, choose, offer, set_face

CROSSED = 1e-4  # sine: edges nearer to parallel touch at their ends
STEEPEST = 4.0  # largest ratio of a ridge's depth below an edge of the shape to that below a face not at that edge
INDICES = 256  # largest number of corners, edges or faces of a shape, in feature ids
SLOTS = 6  # features of a sample: two faces, three edges, itself


class Corner(NamedTuple):
    """A point of the shape, rounded by a radius, in the field's frame."""

    number: int
    at: Vec  # m
    radius: float  # m


@njit
def heightfield_contacts(
    shapes: Any,
    field: PlacedShape,
    shape: PlacedShape,
    margin: float,
    turn: float,
    contacts: Any,
    count: int,
    narrowphase: Any,
) -> int:
    """Find all contacts of a shape with a heightfield within a margin, m; at most sixteen.

    `turn`: largest angle in rad by which the shape may turn within the step.

    Writes point (midpoint between the surfaces), normal (out of the field), separation and feature from entry
    `count` of `contacts` on, as far as there is room, sorted by feature.  `narrowphase.manifold` gets the normal
    and separation of the deepest.

    Returns:
        `count` plus the number of contacts, also where there was no room.
    """
    manifold = narrowphase.manifold
    scratch = narrowphase.field
    vertices = shapes.vertices
    clear_manifold(manifold)
    grid = grid_of(shapes.models[field.number], vertices)
    body = placed_body(shapes, field, shape, turn, scratch)
    total = candidates(vertices, grid, body, margin, scratch)
    choose(scratch, total, body.extent)
    return write_chosen(scratch, total, field.pose, contacts, count, manifold)


@njit
def placed_body(shapes: Any, field: PlacedShape, shape: PlacedShape, turn: float, scratch: Any) -> Body:
    """Return the shape in the field's frame."""
    pose = relative(field.pose, shape.pose)
    model, parameter = shapes.models[shape.number], shapes.parameters[shape.number]
    return body_over_field(model, parameter, shapes.vertices, pose, turn, scratch)


@njit
def candidates(vertices: Any, grid: Grid, body: Body, margin: float, scratch: Any) -> int:
    """Write all candidates of contacts to scratch; returns their number."""
    room = (margin, margin, margin)
    low, high = sub(body.low, room), add(body.high, room)
    span = span_of(grid, low, high)
    total = span.row - span.row  # zero of the same type
    if span.column_end <= span.column:
        return total
    middle = height_above(vertices, grid, body.pose.at)
    behind = middle < 0.0 and nearest(vertices, grid, body.pose.at, -middle, body, -1, scratch)[4] > body.extent
    if behind:
        return total
    for index in range(body.points):
        total = corner(vertices, grid, body, index, margin, scratch, total)
    if body.kind == SPHERE:
        return total
    for row in range(span.row, span.row_end + 1):
        for column in range(span.column, span.column_end + 1):
            if row < grid.rows - 1 and column < grid.columns - 1 and body.kind == CYLINDER:
                if cell_top(vertices, grid, row, column) >= low[2]:
                    total = cylinder_on_cell(vertices, grid, body, row, column, margin, scratch, total)
            for k in range(3):
                if has_edge(grid, row, column, k) and is_ridge(vertices, grid, row, column, k):
                    total = ridge(vertices, grid, body, (row, column), k, margin, scratch, total)
            p = sample(vertices, grid, row, column)
            if is_within(p, low, high) and is_peak(vertices, grid, row, column):
                total = peak(vertices, grid, body, (row, column), margin, scratch, total)
    return total


@njit
def is_within(p: Vec, low: Vec, high: Vec) -> bool:
    return low[0] <= p[0] <= high[0] and low[1] <= p[1] <= high[1] and low[2] <= p[2] <= high[2]


@njit
def number(grid: Grid, row: int, column: int, slot: int, index: int) -> int:
    """Return the feature id of a contact, from the parts of the field and of the shape."""
    return ((row * grid.columns + column) * SLOTS + slot) * INDICES + index


# ---------------------------------------------------------------- corners of the shape


@njit
def corner(vertices: Any, grid: Grid, body: Body, index: int, margin: float, scratch: Any, total: int) -> int:
    """Add the contacts of a rounded point of the shape with faces below it and ridges and peaks beside it."""
    p = vec(scratch[index].point)
    height = height_above(vertices, grid, p)
    radius = 0.0 if body.kind == CYLINDER else body.radius
    grown = Corner(index, p, radius)
    if height < 0.0:
        return corner_inside(vertices, grid, body, grown, -height, scratch, total)
    reach = radius + margin
    span = span_of(grid, sub(p, (reach, reach, reach)), add(p, (reach, reach, reach)))
    near = False
    for row in range(span.row, span.row_end):
        for column in range(span.column, span.column_end):
            if p[2] - reach > cell_top(vertices, grid, row, column):
                continue
            near = True
            for which in range(2):
                a, b, c = triangle(vertices, grid, row, column, which)
                n = normal_of(a, b, c)
                gap = dot(n, sub(p, a))
                if gap >= 0.0 and gap <= reach and faces_ground(body, scratch, index, n) and is_over(p, a, b, c, n):
                    feature = number(grid, row, column, which, index)
                    before = total
                    total = offer_corner(scratch, before, p, n, gap, radius, feature)
                    if body.kind != CYLINDER:
                        set_face(scratch, before, total, FACE_OF_A, radius)
    if not near:
        return total
    for row in range(span.row, span.row_end + 1):
        for column in range(span.column, span.column_end + 1):
            total = corner_beside(vertices, grid, body, grown, (row, column), reach, scratch, total)
    return total


@njit
def offer_corner(scratch: Any, total: int, p: Vec, n: Vec, distance: float, radius: float, feature: int) -> int:
    """Add a contact at the point of a rounded corner nearest to the ground."""
    gap = distance - radius
    return offer(scratch, total, along(p, -radius - 0.5 * gap, n), n, gap, feature)


@njit
def corner_beside(
    vertices: Any, grid: Grid, body: Body, corner: Corner, cell: Cell, reach: float, scratch: Any, total: int
) -> int:
    """Add contacts of a corner with a sample and its ridges, where the corner is between the faces' normals."""
    index, p, radius = corner
    row, column = cell
    start = sample(vertices, grid, row, column)
    room = (reach, reach, reach)
    low, high = sub(p, room), add(p, room)
    for k in range(3):
        if not has_edge(grid, row, column, k) or not is_ridge(vertices, grid, row, column, k):
            continue
        end = edge_end(vertices, grid, row, column, k)
        if beside(start, end, low, high):
            continue
        way = sub(end, start)
        t = dot(sub(p, start), way)
        if not (t > 0.0 and t < dot(way, way)):
            continue
        d = sub(p, closest_on_segment(p, start, end))
        distance = norm(d)
        if not (distance <= reach and distance > 0.0):
            continue
        d = scaled(d, 1.0 / distance)
        if d[2] >= 0.0 and faces_ground(body, scratch, index, d):
            fold = fold_of(vertices, grid, row, column, k)
            if fold.turn > FLAT and beyond_fold(fold, d) <= 0.0:
                total = offer_corner(scratch, total, p, d, distance, radius, number(grid, row, column, 2 + k, index))
    d = sub(p, start)
    distance = norm(d)
    if distance <= reach and distance > 0.0 and is_peak(vertices, grid, row, column):
        d = scaled(d, 1.0 / distance)
        if faces_ground(body, scratch, index, d) and beyond_peak(vertices, grid, row, column, d) <= 0.0:
            total = offer_corner(scratch, total, p, d, distance, radius, number(grid, row, column, 5, index))
    return total


@njit
def corner_inside(vertices: Any, grid: Grid, body: Body, corner: Corner, depth: float, scratch: Any, total: int) -> int:
    """Add the contact of a corner in the solid, towards the nearest point of the surface."""
    index, p, radius = corner
    row, column, which, n, distance = nearest(vertices, grid, p, depth, body, -1, scratch)
    if not faces_ground(body, scratch, index, n):
        if body.faces == 0:
            return total
        row, column, which, n, distance = nearest(vertices, grid, p, depth, body, index, scratch)
    if row < 0:
        return total
    before = total
    total = offer_corner(scratch, before, p, n, -distance, radius, number(grid, row, column, which, index))
    if body.kind != CYLINDER:
        set_face(scratch, before, total, FACE_OF_A, radius)
    return total


@njit
def nearest(
    vertices: Any, grid: Grid, p: Vec, within: float, body: Body, index: int, scratch: Any
) -> tuple[int, int, int, Vec, float]:
    """Return (row, column, triangle, direction out, distance m) of the surface from a point below it; row -1: none.

    For a corner (else `index` is -1) only normals of faces that it can face count, not across a thin ridge.
    """
    span = span_of(grid, sub(p, (within, within, within)), add(p, (within, within, within)))
    best_row = span.row - span.row - 1
    best_column = best_which = best_row
    out, least = (0.0, 0.0, 1.0), np.inf
    for row in range(span.row, span.row_end):
        for column in range(span.column, span.column_end):
            for which in range(2):
                a, b, c = triangle(vertices, grid, row, column, which)
                n = normal_of(a, b, c)
                if abs(dot(n, sub(a, p))) >= least:
                    continue
                d = sub(closest_on_triangle(p, a, b, c, n), p)
                distance = norm(d)
                if not distance < least:
                    continue
                over = is_over(p, a, b, c, n)
                if index < 0 or (over and faces_ground(body, scratch, index, n)):
                    best_row, best_column, best_which, least = row, column, which, distance
                    out = n if over or not distance > 0.0 else scaled(d, 1.0 / distance)
    return best_row, best_column, best_which, out, least


# ---------------------------------------------------------------- ridges and peaks of the field


@njit
def ridge(vertices: Any, grid: Grid, body: Body, cell: Cell, k: int, margin: float, scratch: Any, total: int) -> int:
    """Add the contacts of an edge of the field with the edges and the round side of the shape."""
    row, column = cell
    start, end = sample(vertices, grid, row, column), edge_end(vertices, grid, row, column, k)
    room = (margin, margin, margin)
    if beside(start, end, sub(body.low, room), add(body.high, room)):
        return total
    fold = fold_of(vertices, grid, row, column, k)
    if fold.turn <= FLAT:
        return total
    feature = number(grid, row, column, 2 + k, 0)
    if body.kind == CAPSULE or body.kind == CYLINDER:
        return round_on_fold(fold, body, margin, feature, scratch, total)
    for edge in range(body.edges):
        total = edge_on_fold(fold, body, edge, margin, feature + edge, scratch, total)
    return total


@njit
def beside(a: Vec, b: Vec, low: Vec, high: Vec) -> bool:
    """Whether a segment lies beyond one of the sides of a box."""
    for d in range(3):
        if max(a[d], b[d]) < low[d] or min(a[d], b[d]) > high[d]:
            return True
    return False


@njit
def edge_on_fold(fold: Fold, body: Body, edge: int, margin: float, feature: int, scratch: Any, total: int) -> int:
    """Add the contact of two crossing edges, whose common normal must be between the faces' normals of both."""
    entry = scratch[edge]
    a, b = vec(scratch[entry.start].point), vec(scratch[entry.end].point)
    u, w = sub(fold.end, fold.start), sub(b, a)
    d = cross(u, w)
    length = norm(d)
    uu, ww, uw = dot(u, u), dot(w, w), dot(u, w)
    if length * length <= CROSSED * CROSSED * uu * ww:
        return total
    d = scaled(d, 1.0 / length)
    if dot(d, add(fold.normal_a, fold.normal_b)) < 0.0:
        d = scaled(d, -1.0)
    apart = sub(a, fold.start)
    gap = dot(d, apart)
    slack = slack_of(body, gap)
    if beyond_fold(fold, d) > slack:
        return total
    m, o = vec(scratch[entry.left].normal), vec(scratch[entry.right].normal)
    if not is_between(scaled(d, -1.0), m, o, w, slack):
        return total
    across = uu * ww - uw * uw
    t = (dot(apart, u) * ww - dot(apart, w) * uw) / across  # position along the ridge
    s = (dot(apart, u) * uw - dot(apart, w) * uu) / across  # position along the shape's edge
    if not (gap <= margin and gap >= -body.extent and t >= 0.0 and t <= 1.0 and s >= 0.0 and s <= 1.0):
        return total
    on_ridge = along(fold.start, t, u)
    if (
        gap < 0.0
        and -gap > STEEPEST * depth_inside(body, scratch, on_ridge, entry.left, entry.right) + 1e-3 * body.extent
    ):
        return total  # the shape is left on another side
    return offer(scratch, total, along(on_ridge, 0.5 * gap, d), d, gap, feature)


@njit
def is_between(x: Vec, m: Vec, o: Vec, w: Vec, slack: float) -> bool:
    """Whether x = alpha m + beta o with no factor below -slack, about; all are unit vectors normal to w."""
    turn = dot(cross(m, o), w)
    sign = 1.0 if turn > 0.0 else -1.0
    least = -slack * norm(w)
    return sign * dot(cross(m, x), w) >= least and sign * dot(cross(x, o), w) >= least


@njit
def peak(vertices: Any, grid: Grid, body: Body, cell: Cell, margin: float, scratch: Any, total: int) -> int:
    """Add the contact of a sample with the face that it penetrates least, of those that its neighbours allow."""
    row, column = cell
    feature = number(grid, row, column, 5, 0)
    if body.kind == CAPSULE or body.kind == CYLINDER:
        return round_on_peak(vertices, grid, body, cell, margin, feature, scratch, total)
    p = sample(vertices, grid, row, column)
    best, highest = -np.inf, -np.inf
    face = -1
    for f in range(body.faces):
        m = vec(scratch[f].normal)
        height = dot(m, p) - scratch[f].offset
        highest = max(highest, height)
        if height > best and beyond_peak(vertices, grid, row, column, scaled(m, -1.0)) <= TILT:
            best = height
            face = f
    if face < 0 or not (best <= margin and best >= -body.extent):
        return total
    m = vec(scratch[face].normal)
    if highest > 0.0:
        foot = along(p, -best, m)
        for f in range(body.faces):
            if dot(vec(scratch[f].normal), foot) - scratch[f].offset > 1e-6 * body.extent:
                return total  # not under that face
    elif best < STEEPEST * highest - 1e-3 * body.extent:
        return total  # the shape is left on another side
    before = total
    total = offer(scratch, before, along(p, -0.5 * best, m), scaled(m, -1.0), best, feature + face)
    set_face(scratch, before, total, FACE_OF_B, 0.0)
    return total


@njit
def cylinder_on_cell(
    vertices: Any, grid: Grid, body: Body, row: int, column: int, margin: float, scratch: Any, total: int
) -> int:
    """Add the contacts of the rims' lowest points over the two faces of a cell."""
    for which in range(2):
        a, b, c = triangle(vertices, grid, row, column, which)
        n = normal_of(a, b, c)
        for end in range(2):
            found, p = cylinder_on_face(body, n, end)
            if not found or not is_over(p, a, b, c, n):
                continue
            height = height_above(vertices, grid, p)
            gap = dot(n, sub(p, a))
            if height < 0.0:  # like any corner that is inside
                at_row, at_column, at_which, out, distance = nearest(vertices, grid, p, -height, body, -1, scratch)
                if at_row >= 0:
                    feature = number(grid, at_row, at_column, at_which, 16 + end)
                    total = offer_corner(scratch, total, p, out, -distance, 0.0, feature)
            elif gap >= 0.0 and gap <= margin:
                feature = number(grid, row, column, which, 16 + end)
                total = offer_corner(scratch, total, p, n, gap, 0.0, feature)
    return total


# ---------------------------------------------------------------- results


@njit
def write_chosen(scratch: Any, total: int, field_pose: Pose, contacts: Any, count: int, manifold: Any) -> int:
    """Write the chosen candidates as contacts in the world, sorted by feature id."""
    last = -1
    while True:
        following = -1
        for i in range(total):
            if scratch[i].state == CHOSEN and (following < 0 or scratch[i].feature < scratch[following].feature):
                following = i
        if following < 0:
            return count
        entry = scratch[following]
        entry.state = CHOSEN + 1
        if entry.feature == last:  # the same contact from both sides of an edge
            continue
        last = entry.feature
        n = rotate(field_pose, vec(entry.push))
        if entry.gap < manifold.separation:
            manifold.separation = entry.gap
            set_normal(manifold, n)
        if count < len(contacts):
            contact = contacts[count]
            p = to_world(field_pose, vec(entry.spot))
            for i in range(3):
                contact.point[i] = p[i]
                contact.normal[i] = n[i]
            contact.separation = entry.gap
            contact.feature = entry.feature
            contact.face = entry.face
            contact.core_distance = entry.rounding + 0.5 * entry.gap
        count += 1


@njit
def heightfield_gap(shapes: Any, field: PlacedShape, shape: PlacedShape, margin: float, scratch: Any) -> float:
    """Return a lower bound of the distance, m, for conservative advancement.

    It is the distance of the nearest triangle, infinite if none is within the margin: a shape whose points
    all move by less touches nothing, in any direction.  It is zero or less where the shape may touch.
    """
    vertices = shapes.vertices
    grid = grid_of(shapes.models[field.number], vertices)
    body = placed_body(shapes, field, shape, 0.0, scratch)
    room = (margin, margin, margin)
    span = span_of(grid, sub(body.low, room), add(body.high, room))
    least = np.inf
    ball = furthest_from_middle(body, scratch)
    for row in range(span.row, span.row_end):
        for column in range(span.column, span.column_end):
            for which in range(2):
                a, b, c = triangle(vertices, grid, row, column, which)
                n = normal_of(a, b, c)
                gap = -reach_along(body, scratch, scaled(n, -1.0)) - dot(n, a)
                apart = sub(body.pose.at, closest_on_triangle(body.pose.at, a, b, c, n))
                if gap > 0.0:
                    gap = max(gap, norm(apart) - ball)
                if gap <= margin:
                    least = min(least, gap)
    return least


@njit
def furthest_from_middle(body: Body, scratch: Any) -> float:
    """Return the radius of the ball about the shape's origin that contains it."""
    if body.kind == CYLINDER:
        return np.sqrt(body.half_length * body.half_length + body.radius * body.radius)
    most = 0.0
    for i in range(body.points):
        most = max(most, norm(sub(vec(scratch[i].point), body.pose.at)))
    return most + body.radius
