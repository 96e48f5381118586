"""Primitives to pictures, against closed forms and a slow oracle."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render.spatial import PrimitiveRenderer, Primitives, SpatialCamera, make_primitives, render_primitives
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, HEIGHTFIELD, HULL, PLANE, SPHERE
from gsenv.render.spatial.renderer import QUALITIES
from gsenv.render.spatial.style import DEFAULT_STYLE
from tests.render.spatial import oracles

WIDTH, HEIGHT = 150, 110  # no multiple of 8
CAMERA = SpatialCamera((3.0, -3.5, 2.2), (0.0, 0.0, 0.4), width=WIDTH, height=HEIGHT)
TURN = np.array([0.8, 0.3, -0.4, 0.33])
AT = np.array([0.1, -0.2, 0.5])
SIZE = np.array([0.5, 0.3, 0.7])
EDGE = 2e-4  # m; where the oracle finds rays that pass as near as this, float32 may differ


def draw(primitives: Primitives, vertices: Any = None, quality: Any = "fast") -> tuple[NDArray[Any], NDArray[Any]]:
    """Picture and ids."""
    renderer = PrimitiveRenderer(WIDTH, HEIGHT, quality)
    image = renderer.draw(CAMERA, primitives, vertices)
    return image, renderer.ids


def make_mixed_scene() -> tuple[Primitives, NDArray[np.void]]:
    """One of each kind, all in view."""
    octahedron, field = oracles.make_octahedron(0.4), oracles.make_field(9, 7, 0.2, lambda x, y: 0.1 * np.sin(3 * x))
    kinds = [PLANE, SPHERE, BOX, CAPSULE, CYLINDER, HULL, HEIGHTFIELD]
    at = [(0, 0, -0.2), (1, 0, 0.3), (0, 1, 0.4), (-1, 0, 0.5), (0, -1, 0.4), (0, 0, 1.2), (-0.2, 0.1, 0)]
    rotation = np.tile(TURN, (7, 1))
    rotation[[0, 6]] = (1.0, 0.0, 0.0, 0.0)
    size = np.tile([0.3, 0.2, 0.25], (7, 1))
    first = [0, 0, 0, 0, 0, 0, len(octahedron)]
    scene = make_primitives(kinds, at, rotation, size, np.full(7, 0.2), vertex_first=first)
    return scene, np.concatenate([octahedron, field])


SOLIDS = {
    SPHERE: oracles.capsule_distance(0.0, 0.4),
    BOX: oracles.box_distance(SIZE),
    CAPSULE: oracles.capsule_distance(0.7, 0.4),
    CYLINDER: oracles.cylinder_distance(0.7, 0.4),
    HULL: oracles.hull_distance(oracles.OCTAHEDRON, np.full(8, 0.6 / np.sqrt(3.0))),
}


@pytest.mark.parametrize("distance", [1.0, 12.0])
@pytest.mark.parametrize("kind", SOLIDS)
def test_silhouettes_are_those_of_the_shapes(kind: int, distance: float) -> None:
    camera = CAMERA._replace(eye=AT + distance * (np.array(CAMERA.eye) - AT), target=AT, fov=CAMERA.fov / distance)
    scene = make_primitives([kind], [AT], [TURN], [SIZE], [0.4])
    renderer = PrimitiveRenderer(WIDTH, HEIGHT, "fast")
    renderer.draw(camera, scene, oracles.make_octahedron(0.6))
    eye = np.array(camera.eye)
    least = oracles.least_distance(SOLIDS[kind], eye, oracles.find_rays(camera), AT, TURN, 20.0 * distance)
    sure = np.abs(least) > EDGE
    assert sure.mean() > 0.99
    assert 0.02 < (least < 0.0).mean() < 0.5
    np.testing.assert_array_equal((renderer.ids == 0)[sure], (least < 0.0)[sure])


def test_a_sphere_projects_to_its_ellipse() -> None:
    """Rows and columns of the outline from the tangent cone, in closed form."""
    at, radius = np.array([0.6, 0.3, 0.9]), 0.5
    _, ids = draw(make_primitives([SPHERE], [at], radius=[radius]))
    right, up, forward = CAMERA.axes()
    offset = at - np.array(CAMERA.eye)
    q, scale = offset @ forward, 0.5 * HEIGHT / np.tan(0.5 * CAMERA.fov)
    for axis, sign, middle in ((right, 1, WIDTH / 2), (up, -1, HEIGHT / 2)):
        p = offset @ axis
        room = radius * np.sqrt(p * p + q * q - radius**2)
        ends = np.sort(middle + sign * scale * (p * q + np.array([-room, room])) / (q * q - radius**2))
        hit = np.flatnonzero((ids == 0).any(axis=0 if sign == 1 else 1))
        assert abs(hit[0] - ends[0]) <= 1.0
        assert abs(hit[-1] + 1 - ends[1]) <= 1.0


def test_corners_of_a_box_are_where_they_project_to() -> None:
    _, ids = draw(make_primitives([BOX], [AT], [TURN], [SIZE]))
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    pixels = CAMERA.to_pixel(AT + (signs * SIZE) @ oracles.turn_matrix(TURN).T)
    rows, columns = np.nonzero(ids == 0)
    assert abs(columns.min() - pixels[:, 0].min()) <= 1.5
    assert abs(columns.max() + 1 - pixels[:, 0].max()) <= 1.5
    assert abs(rows.min() - pixels[:, 1].min()) <= 1.5
    assert abs(rows.max() + 1 - pixels[:, 1].max()) <= 1.5


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_primitive_hides_the_other(order: tuple[int, int]) -> None:
    eye, target = np.array(CAMERA.eye), np.array(CAMERA.target)
    places = np.stack([target, target + 0.4 * (eye - target)])[list(order)]
    _, ids = draw(make_primitives([SPHERE, BOX], places, size=np.full((2, 3), 0.2), radius=[0.2, 0.2]))
    assert ids[HEIGHT // 2, WIDTH // 2] == order.index(1)
    assert (ids >= 0).any()


def test_of_two_faces_in_one_place_the_first_shows_without_noise() -> None:
    """Two walls that meet in a corner and overlap there: one flat colour on their common top."""
    size = [(0.8, 0.2, 0.3), (0.2, 0.8, 0.3)]
    scene = make_primitives([BOX, BOX], [(0.6, 0, 0.3), (0, 0.6, 0.3)], size=size, color=[(150, 150, 150)] * 2)
    camera = CAMERA._replace(eye=(0.1, -0.4, 4.0), target=(0.0, 0.0, 0.6), fov=0.05)
    renderer = PrimitiveRenderer(WIDTH, HEIGHT, "high")
    image = renderer.draw(camera, scene)[10:-10, 10:-10].astype(int)
    assert (renderer.ids == 0).all()
    assert np.ptp(image, axis=(0, 1)).max() <= 6


def test_a_plane_hides_what_is_below_and_ends_at_the_horizon() -> None:
    _, ids = draw(make_primitives([PLANE, SPHERE], [(0, 0, 0), (0, 0, -0.5)], radius=[0.0, 0.4]))
    rays = oracles.find_rays(CAMERA)
    np.testing.assert_array_equal(ids == 0, rays[..., 2] < -1e-12)
    assert not (ids == 1).any()


def test_a_tilted_field_covers_what_its_rectangle_covers() -> None:
    """No holes between triangles, and the right outline: against the plane of the field."""
    field = oracles.make_field(21, 17, 0.1, lambda x, y: 0.3 * x - 0.1 * y)
    at = np.array([0.0, 0.0, 0.3])
    _, ids = draw(make_primitives([HEIGHTFIELD], [at]), field)
    rays, offset = oracles.find_rays(CAMERA), np.array(CAMERA.eye) - at
    normal = np.array([-0.3, 0.1, 1.0])
    points = offset - (offset @ normal / (rays @ normal))[..., None] * rays
    outside = np.maximum(np.abs(points[..., 0]) - 1.0, np.abs(points[..., 1]) - 0.8)
    sure = np.abs(outside) > 1e-3
    np.testing.assert_array_equal((ids == 0)[sure], (outside < 0.0)[sure])


@pytest.mark.parametrize("cells", [4, 40, 200])
def test_a_field_that_reaches_behind_the_eye_has_no_holes(cells: int) -> None:
    """From above it, near and far, looking anywhere: against where the rays meet its plane."""
    field = oracles.make_field(cells + 1, cells + 1, 40.0 / cells, lambda x, y: 0.0 * x)
    renderer = PrimitiveRenderer(WIDTH, HEIGHT, "fast")
    rng, seen = np.random.default_rng(cells), 0
    for height in (0.02, 0.5, 5.0):
        for _ in range(4):
            eye = np.array([*rng.uniform(-5.0, 5.0, 2), height])
            target = eye + np.array([*rng.normal(size=2), rng.uniform(-2.0, 0.3)])
            camera = CAMERA._replace(eye=tuple(eye), target=tuple(target))
            renderer.draw(camera, make_primitives([HEIGHTFIELD], [(0, 0, 0)]), field)
            rays = oracles.find_rays(camera)
            hit = eye[:2] - height * rays[..., :2] / rays[..., 2:]
            far = np.abs(hit).max(axis=-1)
            forward = (target - eye) / np.linalg.norm(target - eye)
            near = height / np.maximum(-rays[..., 2], 1e-9) * (rays @ forward) < 0.011  # m, nearer than what is drawn
            inside = (rays[..., 2] < 0.0) & (far < 19.9) & ~near
            seen += inside.mean() > 0.3
            assert (renderer.ids[inside] == 0).all()
            assert (renderer.ids[(rays[..., 2] >= 0.0) | (far > 20.1)] == -1).all()
    assert seen > 6  # of 12 pictures


@pytest.mark.parametrize("quality", QUALITIES)
def test_the_shadow_of_a_sphere_lies_in_the_sunlight_behind_it(quality: str) -> None:
    """On the plane it is the ellipse of points nearer than the radius to the sun's ray through the middle."""
    at, radius = np.array([-0.2, 0.1, 0.8]), 0.4
    ground, _ = draw(make_primitives([PLANE], [(0, 0, 0)]), quality=quality)
    image, ids = draw(make_primitives([PLANE, SPHERE], np.stack([0 * at, at]), radius=[0.0, radius]), quality=quality)
    sun = DEFAULT_STYLE.find_sun()
    rays, eye = oracles.find_rays(CAMERA), np.array(CAMERA.eye)
    points = eye - (eye[2] / np.minimum(rays[..., 2], -1e-9))[..., None] * rays
    aside = np.linalg.norm(np.cross(at - points, sun), axis=-1) - radius
    seen = ids == 0
    for k in (-1, 1):
        seen &= np.roll(ids, k, 0) == 0
        seen &= np.roll(ids, k, 1) == 0
    part = image.sum(axis=2) / ground.sum(axis=2)
    margin = 0.02 if quality == "fast" else 0.08
    dark, bright = seen & (aside < -margin), seen & (aside > margin + 0.35)
    assert dark.sum() > 100
    assert part[dark].max() < 0.78
    assert part[bright].min() > 0.98


@pytest.mark.parametrize("kind", [k for k in SOLIDS if k != SPHERE])
def test_shadows_are_those_of_the_shapes(kind: int) -> None:
    """Sharp shadows on the plane against the oracle's least distance along the way to the sun."""
    at, vertices = np.array([-0.3, 0.2, 1.1]), oracles.make_octahedron(0.6)
    ground, _ = draw(make_primitives([PLANE], [(0, 0, 0)]))
    rotation = np.stack([np.eye(4)[0], TURN])
    scene = make_primitives([PLANE, kind], np.stack([0 * at, at]), rotation, [SIZE, SIZE], [0.0, 0.4])
    image, ids = draw(scene, vertices)
    rays, eye = oracles.find_rays(CAMERA), np.array(CAMERA.eye)
    points = eye - (eye[2] / np.minimum(rays[..., 2], -1e-9))[..., None] * rays
    suns = np.broadcast_to(DEFAULT_STYLE.find_sun(), points.shape)
    least = oracles.least_distance(SOLIDS[kind], points, suns, at, TURN, 10.0)
    part = image.sum(axis=2) / ground.sum(axis=2)
    near = (ids == 0) & (np.linalg.norm(points, axis=-1) < 6.0)
    assert (near & (least < -0.05)).sum() > 150
    assert part[near & (least < -0.05)].max() < 0.85
    assert part[near & (least > 0.05)].min() > 0.98


def test_both_qualities_show_the_same_things() -> None:
    scene, vertices = make_mixed_scene()
    fast, high = draw(scene, vertices, "fast"), draw(scene, vertices, "high")
    np.testing.assert_array_equal(fast[1], high[1])
    assert set(np.unique(high[1])) >= {0, 1, 2, 3, 4, 5, 6}
    assert (fast[0] != high[0]).any()


@pytest.mark.parametrize("quality", QUALITIES)
def test_pictures_repeat_bit_by_bit(quality: Any) -> None:
    scene, vertices = make_mixed_scene()
    camera = CAMERA
    renderer = PrimitiveRenderer(WIDTH, HEIGHT, quality)
    first = renderer.draw(camera, scene, vertices)
    renderer.draw(camera.following((5.0, 5.0, 1.0)), scene, vertices)  # leaves other scratch behind
    again = renderer.draw(camera, scene, vertices)
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(first, render_primitives(camera, scene, vertices, quality))
    assert first.dtype == np.uint8
    assert first.shape == (HEIGHT, WIDTH, 3)
    assert not np.shares_memory(first, again)


def test_edges_are_smooth_only_at_high_quality() -> None:
    """A bright box before the sky: the outline's pixels are mixtures."""
    scene = make_primitives([BOX], [(0, 0, 0.4)], [TURN], [SIZE], color=[(0, 0, 0)])
    camera = CAMERA._replace(target=(0.0, 0.0, 0.4))
    both: tuple[Any, ...] = QUALITIES
    steps = [np.abs(np.diff(render_primitives(camera, scene, None, q).sum(2).astype(int), axis=1)) for q in both]
    assert (steps[1] > 450).sum() > 1.5 * (steps[0] > 450).sum() > 0


def test_the_far_checker_is_a_flat_grey() -> None:
    """No moire: the rows below the horizon hardly vary, while the near ones show squares."""
    camera = SpatialCamera((0.3, 0.2, 1.5), (5.3, 1.2, 0.9), width=160, height=120)
    image = render_primitives(camera, make_primitives([PLANE], [(0, 0, 0)]), None, "fast").astype(float)
    horizon = int(np.flatnonzero(oracles.find_rays(camera)[:, 80, 2] < 0.0)[0])
    spread = image[horizon:, :, 1].std(axis=1)
    assert spread[:3].max() < 2.5
    assert spread[-20:].max() > 6.0


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize("size", [(1, 1), (3, 2), (9, 1), (1, 17)])
def test_tiny_pictures(size: tuple[int, int], quality: Any) -> None:
    scene, vertices = make_mixed_scene()
    camera = CAMERA._replace(width=size[0], height=size[1])
    image = render_primitives(camera, scene, vertices, quality)
    assert image.shape == (size[1], size[0], 3)
    assert image.max() > 0


@pytest.mark.nojit
def test_kernels_run_as_plain_python() -> None:
    scene, vertices = make_mixed_scene()
    with np.errstate(all="raise", under="ignore"):
        image = render_primitives(CAMERA._replace(width=6, height=5), scene, vertices)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 5


def test_nothing_at_all_is_a_sky() -> None:
    empty = make_primitives(np.zeros(0), np.zeros((0, 3)))
    image, ids = draw(empty, quality="high")
    assert (ids == -1).all()
    assert image.min() > 100


def test_disabled_and_broken_primitives_are_left_out() -> None:
    at = np.array([(0.0, 0.0, 0.4), (np.nan, 0.0, 0.4), (np.inf, 0.0, 0.0), (0.5, 0.0, 0.4)])
    rotation = np.array([(1.0, 0, 0, 0), (1.0, 0, 0, 0), (1.0, 0, 0, 0), (0.0, 0, 0, 0)])
    alone, _ = draw(make_primitives([PLANE], [(0, 0, 0)]))
    kinds, radius = [PLANE, SPHERE, SPHERE, SPHERE, SPHERE], [0.0, 0.3, 0.3, 0.3, 0.3]
    scene = make_primitives(
        kinds, [(0, 0, 0), *at], [(1, 0, 0, 0), *rotation], None, radius, None, [True, False, True, True, True]
    )
    image, _ = draw(scene._replace(color=np.broadcast_to(scene.color[0], (5, 3)).copy()))
    np.testing.assert_array_equal(image, alone)


def test_the_eye_inside_a_shape_or_below_the_ground_is_no_error() -> None:
    scene, vertices = make_mixed_scene()
    for eye in ((1.0, 0.0, 0.3), (0.0, 1.0, 0.4), (0.0, 0.0, -1.0), (0.0, 0.0, 1.2)):
        for quality in QUALITIES:
            image = render_primitives(CAMERA._replace(eye=eye), scene, vertices, quality)  # type: ignore[arg-type]
            assert image.shape == (HEIGHT, WIDTH, 3)


def test_many_primitives_outgrow_the_scratch() -> None:
    """Pairs are counted first where their array is too short: same picture as from a roomy renderer."""
    rng = np.random.default_rng(0)
    at = rng.uniform((-1, -1, 0.1), (1, 1, 1.5), (60, 3))
    scene = make_primitives([PLANE, *[BOX] * 60], [(0, 0, 0), *at], size=np.full((61, 3), 0.12))
    renderer = PrimitiveRenderer(WIDTH, HEIGHT)
    first = renderer.draw(CAMERA, scene)
    np.testing.assert_array_equal(first, renderer.draw(CAMERA, scene))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": [9]}, "kind must be 0..6, got 9"),
        ({"position": [(0, 0)]}, r"position of 1 primitives must have shape \(1, 3\)"),
        ({"size": [(-1, 0, 0)]}, "size must not be negative"),
        ({"radius": [np.nan]}, "radius must be finite"),
        ({"rotation": [(1, 0, 0)]}, r"rotation of 1 primitives must have shape \(1, 4\)"),
    ],
)
def test_bad_primitives_get_one_sentence(change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"kind": [BOX], "position": [(0, 0, 0)]}
    with pytest.raises(ValueError, match=message):
        make_primitives(**(arguments | change))


def test_bad_arguments_get_one_sentence() -> None:
    hull = make_primitives([HULL], [(0, 0, 0)], vertex_first=[8])
    with pytest.raises(ValueError, match="vertex_first must lie in the 8 vertices"):
        render_primitives(CAMERA, hull, oracles.make_octahedron(0.4))
    with pytest.raises(ValueError, match="quality must be among"):
        render_primitives(CAMERA, hull, oracles.make_octahedron(0.4), "best")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="at least 1 px"):
        PrimitiveRenderer(0, 5)
