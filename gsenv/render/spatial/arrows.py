"""Arrows of 3D pictures, such as that of a push: a shaft and a cone, which shine faintly through what hides them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.camera import SpatialCamera, cross, unit
from gsenv.render.spatial.links import rotations_along
from gsenv.render.spatial.primitives import CYLINDER, HULL, PLAIN, Primitives
from gsenv.render.spatial.silhouette import coverage, measure
from gsenv.render.theme import Rgb
from gsenv.solver.spatial.vertices import vertex_dtype

FloatArray = NDArray[np.float64]

SIDES = 16  # of the cone
HEAD_SHARE = 0.6  # largest length of the head over that of the arrow
SHAFT_SHARE = 0.36  # radius of the shaft over that of the head
GHOST = 0.42  # how much of its colour an arrow has where something hides it
LINE_GHOST, LINE_SHADE = 0.7, 0.4  # the same of its outline there, and the outline's brightness over the arrow's
OUTLINE = 1.0 / 300.0  # of the picture's height, thickness of the outline
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


def shine_through(
    image: NDArray[np.uint8],
    other: NDArray[np.bool_],
    depths: NDArray[np.float32],
    camera: SpatialCamera,
    arrow: Arrow,
) -> None:
    """Blend an arrow faintly, with a darker outline, over what is before it, in place.

    other: (height, width), where the picture shows something else than the arrow
    depths: (height, width) of what it shows, m along the camera's view
    camera: of the picture's size; an arrow that reaches behind the eye is left out
    """
    form = _form(arrow)
    ring = _ring(arrow, form)
    thin = SHAFT_SHARE * (ring - form.neck)
    shaft, head = (
        camera.to_pixel(points)
        for points in (np.concatenate([arrow.tail + thin, form.neck + thin]), np.concatenate([ring, arrow.tip[None]]))
    )
    window = _window(np.concatenate([shaft, head]), *other.shape)
    if window is None:
        return
    y, x = (at + 0.5 for at in np.ogrid[window])
    hidden = other[window] & (depths[window] < _find_depths(camera, arrow, x, y))
    if not hidden.any():
        return
    towards_eye = float((arrow.tip - arrow.tail) @ (np.asarray(camera.eye, float) - form.neck)) > 0.0
    cover, line = _draw_parts((shaft, head) if towards_eye else (head, shaft), x, y, OUTLINE * camera.height)
    for share, shade in ((GHOST * cover, 1.0), (LINE_GHOST * line, LINE_SHADE)):
        part = np.where(hidden, share, 0.0)[..., None]
        color = shade * np.array(arrow.color, float)
        image[window] = np.rint(image[window] + part * (color - image[window]))


def _window(pixels: FloatArray, height: int, width: int) -> tuple[slice, slice] | None:
    """Return the rows and columns around places (k, 2) in px, or None where there is nothing to see."""
    if not np.isfinite(pixels).all():
        return None
    left, top = np.clip(np.floor(pixels.min(axis=0)) - 1.0, 0, (width, height)).astype(int).tolist()
    right, bottom = np.clip(np.ceil(pixels.max(axis=0)) + 1.0, 0, (width, height)).astype(int).tolist()
    return (slice(top, bottom), slice(left, right)) if left < right and top < bottom else None


def _draw_parts(
    parts: Sequence[FloatArray], x: FloatArray, y: FloatArray, thickness: float
) -> tuple[FloatArray, FloatArray]:
    """Return the shares of the pixels x, y that parts cover, each before those before it, and that outlines cover."""
    cover = line = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    for points in parts:
        outside, width = measure(points, x, y)
        whole, inner = coverage(outside, width), coverage(outside + thickness, max(width - 2.0 * thickness, 0.0))
        cover = np.maximum(cover, whole)
        line = (1.0 - whole) * line + whole - inner
    return cover, line


def _find_depths(camera: SpatialCamera, arrow: Arrow, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return how deep in the picture, in m, the place of an arrow's axis is that the ray of each pixel passes closest.

    With the ray r, of depth 1, and the axis a + u d from the eye: the least distance is at the u returned by setting
    the derivative of |a + u d|^2 - (r . (a + u d))^2 / r^2 to zero.
    """
    right, up, forward = camera.axes()
    step = 2.0 * np.tan(0.5 * camera.fov) / camera.height
    ray_x, ray_y = step * (x - 0.5 * camera.width), step * (0.5 * camera.height - y)
    axes = np.array([right, up, forward])
    a, d = axes @ (arrow.tail - np.asarray(camera.eye, float)), axes @ (arrow.tip - arrow.tail)
    square = ray_x**2 + ray_y**2 + 1.0
    along_a, along_d = (ray_x * v[0] + ray_y * v[1] + v[2] for v in (a, d))
    across = np.maximum(d @ d - along_d**2 / square, 1e-12)
    u = np.clip((along_a * along_d / square - a @ d) / across, 0.0, 1.0)
    return np.asarray(a[2] + u * d[2])


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
