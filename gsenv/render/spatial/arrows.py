"""Arrows of 3D pictures, such as that of a push: a shaft and a cone, which shine faintly through what hides them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.camera import SpatialCamera, cross, unit
from gsenv.render.spatial.links import rotations_along
from gsenv.render.spatial.primitives import CYLINDER, HULL, PLAIN, Primitives
from gsenv.render.theme import Rgb
from gsenv.solver.spatial.vertices import vertex_dtype

FloatArray = NDArray[np.float64]

SIDES = 16  # of the cone
HEAD_SHARE = 0.6  # largest length of the head over that of the arrow
SHAFT_SHARE = 0.36  # radius of the shaft over that of the head
GHOST = 0.42  # how much of its colour an arrow has where something hides it
UP = np.array([0.0, 0.0, 1.0])  # m
PARTS = 2  # shaft and head, in this order


class Arrow(NamedTuple):
    """An arrow from `tail` to `tip`, (3,) m each; the head of a short one is smaller than `head` (length, radius).

    One without length is not drawn; but kernels that draw arrows are compiled where it is first given.
    """

    tail: FloatArray
    tip: FloatArray
    color: Rgb
    head: tuple[float, float]


class _Form(NamedTuple):
    """Sizes of an arrow, m, and where its parts meet."""

    neck: FloatArray
    head: float
    radius: float


def with_arrows(
    primitives: Primitives, vertices: NDArray[np.void], arrows: Sequence[Arrow]
) -> tuple[Primitives, NDArray[np.void]]:
    """Return the primitives of a world and their vertices with arrows appended, of each its shaft and its head."""
    parts = [primitives]
    meshes = [vertices if len(vertices) else np.zeros(0, vertex_dtype())]
    for arrow in arrows:
        drawn = arrow if has_length(arrow) else arrow._replace(tip=arrow.tail + UP)
        form = _form(drawn)
        parts.append(_primitives(drawn, form, sum(map(len, meshes)), has_length(arrow)))
        meshes.append(_cone(drawn, form))
    columns: list[tuple[Any, ...]] = list(zip(*parts, strict=True))
    return Primitives(*(np.concatenate(column) for column in columns)), np.concatenate(meshes)


def has_length(arrow: Arrow) -> bool:
    """Whether an arrow is drawn."""
    return bool((arrow.tip != arrow.tail).any())


def _primitives(arrow: Arrow, form: _Form, first: int, enabled: bool) -> Primitives:
    """Return the shaft and the head, whose hull begins at the vertex `first`."""
    span = form.neck - arrow.tail
    long = float(np.sqrt((span**2).sum()))
    shaft = SHAFT_SHARE * form.radius
    return Primitives(
        kind=np.array([CYLINDER, HULL], np.int32),
        position=np.stack([0.5 * (arrow.tail + form.neck), np.zeros(3)]),
        rotation=np.stack([rotations_along(span[None], np.array([long]))[0], np.array([1.0, 0.0, 0.0, 0.0])]),
        size=np.array([[shaft, shaft, 0.5 * long], [0.0, 0.0, 0.0]]),
        radius=np.array([shaft, 0.0]),
        color=np.array([arrow.color, arrow.color], np.uint8),
        enabled=np.full(PARTS, enabled),
        vertex_first=np.array([0, first], np.int32),
        mark=np.full(PARTS, PLAIN, np.int32),
    )


def shine_through(image: NDArray[np.uint8], hidden: NDArray[np.bool_], camera: SpatialCamera, arrow: Arrow) -> None:
    """Blend an arrow faintly over the pixels `hidden` (height, width) in which something is before it, in place.

    camera: of the picture's size; an arrow that reaches behind the eye is left out
    """
    form = _form(arrow)
    ring = _ring(arrow, form)
    thin = SHAFT_SHARE * (ring - form.neck)
    cover = np.zeros(hidden.shape, np.float32)
    for points in (np.concatenate([ring, arrow.tip[None]]), np.concatenate([arrow.tail + thin, form.neck + thin])):
        pixels = camera.to_pixel(points)
        if not np.isfinite(pixels).all():
            return
        np.maximum(cover, _coverage(pixels, *hidden.shape), out=cover)
    share = (GHOST * np.where(hidden, cover, 0.0))[..., None]
    image[...] = np.rint(image + share * (np.array(arrow.color, np.float32) - image))


def _form(arrow: Arrow) -> _Form:
    span = arrow.tip - arrow.tail
    length = float(np.sqrt((span**2).sum()))
    scale = min(1.0, HEAD_SHARE * length / arrow.head[0])
    head = scale * arrow.head[0]
    return _Form(arrow.tip - head / length * span, head, scale * arrow.head[1])


def _ring(arrow: Arrow, form: _Form) -> FloatArray:
    """Return the corners (side, 3) of the head's base in m, counter-clockwise seen from the tip."""
    x, y, z = unit((*(arrow.tip - arrow.tail),))
    across = unit(cross((x, y, z), (0.0, 0.0, 1.0) if abs(z) < 0.9 else (1.0, 0.0, 0.0)))
    other = cross((x, y, z), across)
    angle = 2.0 * np.pi / SIDES * np.arange(SIDES)[:, None]
    return np.asarray(form.neck + form.radius * (np.cos(angle) * np.array(across) + np.sin(angle) * np.array(other)))


def _cone(arrow: Arrow, form: _Form) -> NDArray[np.void]:
    """Return the head as a hull: its base, then its sides."""
    ring = _ring(arrow, form)
    mesh = np.zeros(SIDES + 1, vertex_dtype())
    mesh["position"] = np.concatenate([ring, arrow.tip[None]])
    sides = np.cross(np.roll(ring, -1, axis=0) - ring, arrow.tip - ring)
    mesh["normal"] = np.concatenate([(arrow.tail - arrow.tip)[None], sides])
    mesh["normal"] /= np.sqrt((mesh["normal"] ** 2).sum(axis=-1, keepdims=True))
    mesh["offset"] = (mesh["normal"] * np.concatenate([ring[:1], ring])).sum(axis=-1)
    mesh["vertex_count"][0] = mesh["face_count"][0] = SIDES + 1
    return mesh


def _coverage(points: FloatArray, height: int, width: int) -> NDArray[np.float32]:
    """Return the share (height, width) of each pixel that the convex hull of points (k, 2) in px covers."""
    cover = np.zeros((height, width), np.float32)
    left, top = np.clip(np.floor(points.min(axis=0)).astype(int) - 1, 0, (width, height))
    right, bottom = np.clip(np.ceil(points.max(axis=0)).astype(int) + 1, 0, (width, height))
    if left >= right or top >= bottom:
        return cover
    x, y = np.meshgrid(np.arange(left, right) + 0.5, np.arange(top, bottom) + 0.5)
    outside = np.full(x.shape, -np.inf)
    for angle in np.pi / 24.0 * np.arange(48):  # between tangents in 48 directions lies the hull, to a hundredth of it
        c, s = np.cos(angle), np.sin(angle)
        np.maximum(outside, c * x + s * y - (points @ (c, s)).max(), out=outside)
    cover[top:bottom, left:right] = np.clip(0.5 - outside, 0.0, 1.0)
    return cover
