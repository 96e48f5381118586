"""Areas against closed forms, outlines, shadows, grounds, clipping and determinism."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gsenv.render.canvas as canvas_module
from gsenv.render.camera import Camera
from gsenv.render.canvas import Canvas
from gsenv.render.draw_list import NO_VERTICES, DrawFlag, DrawKind, DrawList, Layer, draw_item, join
from gsenv.render.theme import DEFAULT_THEME, Theme

BLACK, WHITE = (0.0, 0.0, 0.0), (255.0, 255.0, 255.0)
DARK = Theme(sky_top=BLACK, sky_bottom=BLACK, band_contrast=0.0)
SIZE = 120
PIXEL_CAMERA = Camera((0.0, 0.0), float(SIZE))  # 1 px per m
PENTAGON = np.array([(-30.0, -18.0), (27.0, -22.0), (35.0, 9.0), (4.0, 31.0), (-33.0, 14.0)])
STAPLE = np.array([(-20.0, -15.0), (20.0, -15.0), (20.0, 15.0), (-20.0, 15.0)])
VERTICES = np.concatenate([PENTAGON, STAPLE, np.zeros((2, 2))])


def coverage(draw_list: DrawList, camera: Camera = PIXEL_CAMERA) -> NDArray[np.float64]:
    """(SIZE, SIZE) coverage by white items over black."""
    return Canvas(SIZE, SIZE, DARK).draw(draw_list, camera)[:, :, 0] / 255.0


def one(item: NDArray[np.void], vertices: NDArray[np.float64] = NO_VERTICES) -> DrawList:
    return DrawList(item, vertices)


def terrain(points: Any, flags: DrawFlag = DrawFlag.NONE) -> DrawList:
    chain = np.array(points, np.float64)
    item = draw_item(DrawKind.TERRAIN, fill=WHITE, flags=flags, layer=Layer.GROUND, vertices=(0, len(chain)))
    return DrawList(item, chain)


def shoelace(points: NDArray[np.float64]) -> float:
    x, y = points.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


SHAPES = {
    "circle": (draw_item(DrawKind.CAPSULE, radius=20.3, fill=WHITE), np.pi * 20.3**2),
    "small circle": (draw_item(DrawKind.CAPSULE, radius=3.2, fill=WHITE), np.pi * 3.2**2),
    "capsule": (
        draw_item(DrawKind.CAPSULE, angle=0.6, size=(24.0, 0.0), radius=7.4, fill=WHITE),
        np.pi * 7.4**2 + 4.0 * 24.0 * 7.4,
    ),
    "box": (draw_item(DrawKind.BOX, angle=0.4, size=(31.0, 12.5), fill=WHITE), 4.0 * 31.0 * 12.5),
    "polygon": (
        draw_item(DrawKind.POLYGON, angle=-0.7, vertices=(0, 5), fill=WHITE),
        shoelace(PENTAGON),
    ),
    "polyline": (
        draw_item(DrawKind.POLYLINE, angle=0.2, radius=5.2, vertices=(5, 4), fill=WHITE),
        np.pi * 5.2**2 + 2.0 * 5.2 * (40.0 + 30.0 + 40.0) - 2.0 * (1.0 - 0.25 * np.pi) * 5.2**2,
    ),
    "dot": (draw_item(DrawKind.POLYLINE, radius=6.3, vertices=(9, 2), fill=WHITE), np.pi * 6.3**2),
    "thin rod": (
        draw_item(DrawKind.CAPSULE, angle=0.3, size=(40.0, 0.0), radius=0.2, fill=WHITE),
        4.0 * 40.0 * 0.2,
    ),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.37, -0.81)])
def test_area_is_the_closed_form(name: str, offset: tuple[float, float]) -> None:
    item, area = SHAPES[name]
    item = item.copy()
    item["position"] = offset
    tolerance = 0.03 if name == "thin rod" else 0.01
    assert coverage(one(item, VERTICES)).sum() == pytest.approx(area, rel=tolerance)


def test_clockwise_polygons_are_the_same_polygons() -> None:
    item, _ = SHAPES["polygon"]
    np.testing.assert_array_equal(coverage(one(item, PENTAGON)), coverage(one(item, PENTAGON[::-1])))


@pytest.mark.parametrize("name", ["circle", "capsule", "box", "polygon", "polyline", "dot"])
def test_subpixel_shifts_move_the_centroid_by_as_much(name: str) -> None:
    def centroid(shift: float) -> float:
        item = SHAPES[name][0].copy()
        item["position"] = (shift, 0.0)
        image = coverage(one(item, VERTICES))
        return float((image.sum(axis=0) * np.arange(SIZE)).sum() / image.sum())

    start = centroid(0.0)
    for shift in (0.125, 0.25, 0.5, 0.75, 1.0):
        assert centroid(shift) - start == pytest.approx(shift, abs=0.015)


@pytest.mark.parametrize("name", ["circle", "capsule", "box", "polygon"])
def test_the_outline_is_inside_the_silhouette(name: str) -> None:
    plain = SHAPES[name][0].copy()
    outlined = plain.copy()
    outlined["flags"] = DrawFlag.OUTLINE
    outlined["line"] = (0.0, 255.0, 0.0)
    theme = DARK._replace(outline=2.0 / SIZE)
    plain_image, image = (Canvas(SIZE, SIZE, theme).draw(one(i, VERTICES), PIXEL_CAMERA) for i in (plain, outlined))
    np.testing.assert_array_equal(plain_image[..., 1], image[..., 1])  # green: fill and line alike
    whole, red = plain_image[..., 0] / 255.0, image[..., 0] / 255.0
    assert red[SIZE // 2, SIZE // 2] == 1.0
    perimeter = np.hypot(*np.gradient(whole)).sum()
    assert (whole - red).sum() == pytest.approx(2.0 * perimeter, rel=0.12)


def test_grounds_cover_exactly_their_half_plane() -> None:
    for angle in (0.0, 0.3, -1.2, 2.5):
        item = draw_item(DrawKind.HALF_PLANE, (5.0, -3.0), angle, fill=WHITE, layer=Layer.GROUND)
        image = coverage(one(item))
        y, x = np.mgrid[:SIZE, :SIZE] + 0.5 - SIZE / 2
        height = -np.sin(angle) * (x - 5.0) + np.cos(angle) * (-y + 3.0)
        np.testing.assert_array_equal(image[height > 1.0], 0.0)
        np.testing.assert_array_equal(image[height < -1.0], 1.0)
        assert image.sum() == pytest.approx((height < 0.0).sum(), rel=0.01)


def test_terrain_fills_below_and_leaves_the_sky_above() -> None:
    x = np.linspace(-90.0, 90.0, 40)
    chain = np.stack([x, 20.0 * np.sin(0.06 * x)], axis=1)
    image = coverage(terrain(chain))
    columns = np.arange(SIZE) + 0.5 - SIZE / 2
    surface = SIZE / 2 - np.interp(columns, *chain.T)
    rows = np.arange(SIZE)[:, None] + 0.5
    np.testing.assert_array_equal(image[rows > surface + 2.0], 1.0)
    np.testing.assert_array_equal(image[rows < surface - 2.0], 0.0)
    assert image.sum() == pytest.approx((SIZE - surface).sum(), rel=0.005)


def test_cliffs_overhangs_and_ends_have_the_right_area() -> None:
    stairs = [
        (-40.3, -10.0),
        (-10.2, -10.0),
        (-10.2, 15.5),
        (20.7, 15.5),
        (20.7, -30.0),
        (45.4, -30.0),
    ]
    steps = [(-40.3, -10.2, -10.0), (-10.2, 20.7, 15.5), (20.7, 45.4, -30.0)]
    area = sum((right - left) * (60.0 + top) for left, right, top in steps)
    assert coverage(terrain(stairs)).sum() == pytest.approx(area, rel=0.01)
    overhang = [(-60.0, -20.0), (0.0, -20.0), (-15.0, 10.0), (60.0, 10.0)]
    area = 60.0 * 40.0 + 60.0 * 70.0 + 0.5 * 15.0 * 30.0
    assert coverage(terrain(overhang)).sum() == pytest.approx(area, rel=0.01)


def test_the_ground_is_on_the_right_hand() -> None:
    ceiling = coverage(terrain([(80.0, 10.0), (-80.0, 10.0)]))
    assert ceiling[:49].min() == 1.0
    assert ceiling[51:].max() == 0.0
    island = np.array([(-30.0, -20.0), (-30.0, 20.0), (30.0, 20.0), (30.0, -20.0)])  # clockwise
    inside = coverage(terrain(island, DrawFlag.CLOSED)).sum()
    assert inside == pytest.approx(60.0 * 40.0, rel=0.01)
    outside = coverage(terrain(island[::-1], DrawFlag.CLOSED)).sum()
    assert outside == pytest.approx(SIZE**2 - 60.0 * 40.0, rel=0.01)


def test_shadows_fall_on_sky_and_ground_but_not_on_shapes() -> None:
    caster = draw_item(DrawKind.BOX, size=(15.0, 15.0), fill=WHITE, flags=DrawFlag.SHADOW)
    neighbour = draw_item(DrawKind.BOX, (31.0, 0.0), size=(15.0, 15.0), fill=WHITE)
    theme = DEFAULT_THEME._replace(shadow_offset=(8.0 / SIZE, 8.0 / SIZE))
    canvas = Canvas(SIZE, SIZE, theme)
    empty = canvas.draw(one(caster[:0]), PIXEL_CAMERA).astype(int)
    lone = canvas.draw(one(caster), PIXEL_CAMERA).astype(int)
    both = canvas.draw(one(np.concatenate([caster, neighbour])), PIXEL_CAMERA).astype(int)
    below = (80, 62)  # row, column: under the shifted box
    assert empty[below][0] - lone[below][0] > 30
    assert (lone[60, 80] < empty[60, 80]).all()  # beside it
    np.testing.assert_array_equal(both[60, 80], 255)


def test_touching_shapes_cast_one_shadow_without_a_seam() -> None:
    def shadow(*boxes: NDArray[np.void]) -> NDArray[np.int64]:
        theme = Theme(sky_top=WHITE, sky_bottom=WHITE, shadow_softness=12.0 / SIZE, shadow_offset=(0.0, 0.4))
        image = Canvas(SIZE, SIZE, theme).draw(one(np.concatenate(boxes)), PIXEL_CAMERA)
        return image[80:, :, 0].astype(int)

    def box(x: float, half: float) -> NDArray[np.void]:
        return draw_item(DrawKind.BOX, (x, 10.0), size=(half, 20.0), fill=WHITE, flags=DrawFlag.SHADOW)

    whole = shadow(box(0.0, 30.0))
    assert whole.min() < 200
    np.testing.assert_allclose(shadow(box(-15.0, 15.0), box(15.0, 15.0)), whole, atol=1)
    overlapping = shadow(box(-10.0, 20.0), box(10.0, 20.0))
    assert overlapping.min() >= whole.min() - 1


def test_what_is_out_of_sight_is_never_painted(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    here = draw_item(DrawKind.BOX, size=(10.0, 10.0), fill=WHITE, flags=DrawFlag.SHADOW)
    angles = rng.uniform(0.0, 2.0 * np.pi, 2000)
    away = np.repeat(draw_item(DrawKind.BOX, size=(9.0, 9.0), fill=WHITE), 2000)
    away["position"] = rng.uniform(120.0, 1e6, (2000, 1)) * np.stack([np.cos(angles), np.sin(angles)], 1)
    painted = []
    original = canvas_module.paint

    def spy(*arguments: Any) -> None:
        painted.append(arguments[2])
        original(*arguments)

    monkeypatch.setattr(canvas_module, "paint", spy)
    alone = coverage(one(here))
    crowded = coverage(one(np.concatenate([away, here])))
    np.testing.assert_array_equal(alone, crowded)
    assert painted == [1, 1]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e30])
def test_broken_poses_disappear(bad: float) -> None:
    here = draw_item(DrawKind.CAPSULE, radius=10.0, fill=WHITE)
    broken = [
        draw_item(DrawKind.BOX, (bad, 0.0), size=(9.0, 9.0), fill=WHITE, flags=DrawFlag.SHADOW),
        draw_item(DrawKind.CAPSULE, (0.0, bad), size=(3.0, 0.0), radius=9.0, fill=WHITE),
        draw_item(DrawKind.POLYGON, (bad, bad), vertices=(0, 5), fill=WHITE),
        draw_item(DrawKind.POLYLINE, (0.0, bad), radius=9.0, vertices=(5, 4), fill=WHITE, flags=DrawFlag.SHADOW),
    ]
    crowded = coverage(one(np.concatenate([here, *broken]), VERTICES))
    np.testing.assert_array_equal(crowded, coverage(one(here)))


def crooked_lines() -> list[NDArray[np.float64]]:
    """Polylines with level segments, some of them far out on either side."""
    rng = np.random.default_rng(3)
    hook = np.array([(0.0, 1.0), (400.0, 1.0), (400.0, 40.0), (500.0, 40.0)])
    lines = [hook, hook[::-1], hook * (-1.0, 1.0), hook[::-1] * (-1.0, 1.0)]
    for spread in (10.0, 40.0, 300.0, 20000.0):
        for count in (2, 3, 12):
            points = rng.normal(0.0, spread, (count, 2))
            points[1] = points[0] + (spread, 0.0)
            lines.append(points)
    return lines


@pytest.mark.parametrize("points", crooked_lines())
def test_polylines_are_where_their_nearest_segment_is(points: NDArray[np.float64]) -> None:
    y, x = (np.mgrid[:SIZE, :SIZE] + 0.5 - SIZE / 2) * np.array([-1.0, 1.0])[:, None, None]
    pixels = np.stack([x, y], axis=-1)[:, :, None]
    a, span = points[:-1], np.diff(points, axis=0)
    t = ((pixels - a) * span).sum(axis=-1) / (span * span).sum(axis=-1)
    nearest = a + np.clip(t, 0.0, 1.0)[..., None] * span
    distance = np.hypot(*np.moveaxis(pixels - nearest, -1, 0)).min(axis=-1)
    item = draw_item(DrawKind.POLYLINE, radius=3.7, vertices=(0, len(points)), fill=WHITE)
    tolerance = 0.012 + 1e-6 * np.abs(points).max()  # of coordinates in single precision
    np.testing.assert_allclose(coverage(one(item, points)), np.clip(4.2 - distance, 0.0, 1.0), atol=tolerance)


def test_thin_lines_cast_narrow_shadows() -> None:
    white = Theme(sky_top=WHITE, sky_bottom=WHITE, shadow_softness=0.25, shadow_offset=(0.0, 0.3))
    canvas = Canvas(SIZE, SIZE, white)
    widths, darkest = [], []
    for radius in (1.0, 3.0):
        item = draw_item(DrawKind.POLYLINE, radius=radius, vertices=(0, 2), fill=WHITE, flags=DrawFlag.SHADOW)
        line = np.array([(-40.0, 20.0), (40.0, 20.0)])
        column = canvas.draw(one(item, line), PIXEL_CAMERA)[:, SIZE // 2, 0].astype(int)
        assert np.flatnonzero(column < 254).mean() == pytest.approx(40.0 + 0.3 * SIZE - 0.5, abs=0.6)
        widths.append(int((column < 254).sum()))
        darkest.append(int(column.min()))
    assert widths[0] < 8 < widths[1] < 20
    assert max(darkest) < 215


def test_shapes_across_the_border_are_cut() -> None:
    item = draw_item(DrawKind.BOX, (60.0, 60.0), size=(20.0, 20.0), fill=WHITE, flags=DrawFlag.OUTLINE)
    item["line"] = WHITE
    assert coverage(one(item)).sum() == pytest.approx(400.0, rel=0.01)


def test_layers_beat_list_order() -> None:
    over = draw_item(DrawKind.BOX, size=(9.0, 9.0), fill=(255.0, 0.0, 0.0), layer=Layer.OVERLAY)
    body = draw_item(DrawKind.BOX, size=(9.0, 9.0), fill=(0.0, 255.0, 0.0))
    image = Canvas(SIZE, SIZE, DARK).draw(one(np.concatenate([over, body])), PIXEL_CAMERA)
    np.testing.assert_array_equal(image[60, 60], (255, 0, 0))
    image = Canvas(SIZE, SIZE, DARK).draw(one(np.concatenate([body, body, over])), PIXEL_CAMERA)
    np.testing.assert_array_equal(image[60, 60], (255, 0, 0))


def test_hidden_items_leave_no_trace() -> None:
    item = draw_item(DrawKind.BOX, size=(9.0, 9.0), fill=WHITE, flags=DrawFlag.SHADOW)
    item["alpha"] = 0.0
    assert coverage(one(item)).max() == 0.0


def test_the_same_list_gives_the_same_bits() -> None:
    parts = [one(item, VERTICES) for item, _ in SHAPES.values()]
    draw_list = join(terrain([(-80.0, -30.0), (80.0, -20.0)]), *parts)
    canvas = Canvas(SIZE, SIZE)
    first = canvas.draw(draw_list, PIXEL_CAMERA)
    canvas.draw(draw_list, Camera((3.0, 4.0), 50.0))
    again = canvas.draw(draw_list, PIXEL_CAMERA)
    np.testing.assert_array_equal(first, again)
    assert not np.shares_memory(first, again)
    np.testing.assert_array_equal(first, Canvas(SIZE, SIZE).draw(draw_list, PIXEL_CAMERA))


def test_joined_lists_keep_their_vertices() -> None:
    square = np.array([(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)])
    small = one(draw_item(DrawKind.POLYGON, (-45.0, -45.0), vertices=(0, 4), fill=WHITE), square)
    large = one(draw_item(DrawKind.POLYGON, (10.0, 10.0), vertices=(0, 5), fill=WHITE), PENTAGON)
    area = coverage(join(large, small)).sum()
    assert area == pytest.approx(shoelace(PENTAGON) + 100.0, rel=0.01)


def test_slow_gradients_are_dithered_not_banded() -> None:
    image = Canvas(64, 512, DEFAULT_THEME).draw(one(draw_item(DrawKind.BOX)[:0]), Camera())
    blocks = image[:400, :, 0].astype(float).reshape(50, 8, 64).mean(axis=(1, 2))
    line = np.polyval(np.polyfit(np.arange(50), blocks, 1), np.arange(50))
    assert np.abs(blocks - line).max() < 0.1  # rounding alone would be 0.4 off


def test_a_moving_camera_moves_the_ground() -> None:
    ground = one(draw_item(DrawKind.HALF_PLANE, fill=(140.0, 140.0, 140.0), layer=Layer.GROUND))
    canvas = Canvas(SIZE, SIZE)
    here, there, turn = (canvas.draw(ground, Camera((x, 0.0), 10.0)) for x in (0.0, 1.0, 4.0))
    assert (here[80:] != there[80:]).mean() > 0.2
    np.testing.assert_array_equal(here, turn)
