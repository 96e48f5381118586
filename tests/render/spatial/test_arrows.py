"""Arrows of 3D pictures: shape, and what shows of them behind other things."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from gsenv.render.spatial.arrows import HEAD_SHARE, Arrow, with_arrows
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.primitives import HULL, make_primitives
from gsenv.render.spatial.scene_renderer import SpatialRenderer
from gsenv.render.spatial.world_view import read_primitives, read_table
from gsenv.solver import Scene, World
from gsenv.solver.spatial import Box
from gsenv.solver.spatial.vertices import vertex_dtype

RED = (206, 44, 58)
HEAD = (0.3, 0.1)
NOTHING = np.zeros(0, vertex_dtype())
ORIGIN = (0.0, 0.0, 0.0)


def arrow(tail: tuple[float, float, float], tip: tuple[float, float, float]) -> Arrow:
    return Arrow(np.array(tail), np.array(tip), RED, HEAD)


@pytest.mark.parametrize("tip", [(1.0, 2.0, 3.0), (0.0, 0.0, 1.0), (0.0, 0.0, -0.2), (0.1, 0.0, 0.0)])
def test_shaft_and_head_reach_from_tail_to_tip(tip: tuple[float, float, float]) -> None:
    none = make_primitives([], np.zeros((0, 3)))
    primitives, mesh = with_arrows(
        none, NOTHING, [arrow((0.0, 0.0, 0.0), tip), arrow((1.0, 1.0, 1.0), (2.0, 1.0, 1.0))]
    )
    assert primitives.kind.tolist()[1] == HULL
    length = float(np.linalg.norm(tip))
    along = np.array(tip) / length
    shaft, base = 2.0 * primitives.size[0, 2], mesh["position"][:16].mean(axis=0)
    head = float(np.linalg.norm(tip - base))
    assert head == pytest.approx(min(HEAD[0], HEAD_SHARE * length))
    assert shaft + head == pytest.approx(length)
    assert_allclose(primitives.position[0], 0.5 * base, atol=1e-12)
    assert_allclose(base, (length - head) * along, atol=1e-12)
    assert_allclose(mesh["position"][16], tip)
    assert_allclose(np.linalg.norm(mesh["position"][:16] - base, axis=1), HEAD[1] * head / HEAD[0])
    height = mesh["position"][:17] @ mesh["normal"][:17].T - mesh["offset"][:17]  # a hull: no corner is outside
    assert height.max() < 1e-12
    assert ((height > -1e-9).sum(axis=0) >= 3).all()
    assert primitives.vertex_first[3] == 17


@pytest.fixture
def world() -> World:
    """A wall of 1 x 1 m."""
    scene = Scene(dim=3)
    scene.add_body("wall", "static", [Box(half_extents=(0.05, 0.5, 0.5))])
    return World(scene)


CAMERA = SpatialCamera((3.0, 0.0, 0.0), (0.0, 0.0, 0.0), width=120, height=120)


def shown(world: World, *arrows: Arrow) -> NDArray[np.int64]:
    renderer = SpatialRenderer(world, 120, 120, CAMERA)
    return renderer.render(arrows=arrows).astype(np.int64)


def touched(across: Arrow) -> NDArray[np.bool_]:
    """Return the pixels (120, 120) that an arrow across the view touches, from many points in it."""
    span, form = across.tip - across.tail, np.linspace(0.0, 1.0, 400)
    length = float(np.linalg.norm(span))
    side, depth = np.cross(span / length, [1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    radii = np.where(form * length < length - HEAD[0], 0.36 * HEAD[1], HEAD[1] * (1.0 - form) * length / HEAD[0])
    turns = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    circle = np.cos(turns)[:, None] * side + np.sin(turns)[:, None] * depth
    rings = radii[:, None, None] * circle
    points = [across.tail + form[:, None, None] * span + share * rings for share in np.linspace(0.0, 1.0, 9)]
    x, y = np.floor(CAMERA.to_pixel(np.array(points)).reshape(-1, 2)).astype(int).T
    seen = np.zeros((120, 120), bool)
    seen[y, x] = True
    return seen


def grown(seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the pixels of a set and their neighbours."""
    shifts = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return np.any([np.roll(seen, shift, (0, 1)) for shift in shifts], axis=0)


def test_an_arrow_is_solid_before_a_wall_and_faint_behind_it(world: World) -> None:
    plain = shown(world)
    before = shown(world, arrow((0.5, -0.4, 0.0), (0.5, 0.4, 0.0)))
    behind = shown(world, arrow((-0.5, -0.4, 0.0), (-0.5, 0.4, 0.0)))
    strength = [(image - plain)[58:62, 50:70, 0] - (image - plain)[58:62, 50:70, 2] for image in (before, behind)]
    assert strength[0].mean() > 60  # redder
    assert 20 < strength[1].mean() < 0.8 * strength[0].mean()


ENDS = [((-0.42, -0.05), (0.42, 0.0)), ((-0.4, -0.3), (0.38, 0.3)), ((0.4, 0.1), (-0.4, -0.15))]  # y and z, m


@pytest.mark.parametrize(("tail", "tip"), ENDS)
@pytest.mark.parametrize("x", [0.5, -0.5])  # m, before and behind the wall
def test_no_pixel_off_an_oblique_arrow_changes(
    world: World, tail: tuple[float, float], tip: tuple[float, float], x: float
) -> None:
    """Its shadow would, but neither the sky gets one nor the wall from an arrow behind it."""
    oblique = arrow((x, *tail), (x, *tip))
    if x > 0.0:
        world.state.bodies[0]["position"][0] = (-50.0, 0.0, -50.0)  # an empty background
    changed = (shown(world, oblique) != shown(world)).any(axis=-1)
    shape = touched(oblique)
    assert not changed[~grown(shape)].any()
    assert changed[~grown(~shape)].all()


def test_what_is_behind_an_arrow_stays_as_it_is_beside_the_arrow(world: World) -> None:
    """Nothing shines through: the picture is that of the solid arrow, to its antialiased edges."""
    across = arrow((0.5, -0.4, -0.1), (0.5, 0.4, 0.1))
    renderer = SpatialRenderer(world, 120, 120, CAMERA)
    primitives = read_primitives(world, 0, read_table(world))
    solid = renderer._renderer.draw(CAMERA, *with_arrows(primitives, NOTHING, [across]))
    np.testing.assert_array_equal(shown(world, across), solid)


def test_a_hidden_arrow_has_a_darker_outline(world: World) -> None:
    renderer = SpatialRenderer(world, 480, 480, CAMERA)
    behind = renderer.render(arrows=[arrow((-0.5, -0.4, 0.0), (-0.5, 0.4, 0.0))]).astype(int)
    column = (behind - renderer.render())[:, 276].sum(axis=-1)  # through the head
    (rows,) = np.nonzero(column < -20)
    fill = column[rows[0] + 3 : rows[-1] - 2]
    assert len(fill) > 3
    assert column[rows[0] : rows[0] + 2].min() < fill.min() - 30
    assert column[rows[-1] - 1 : rows[-1] + 1].min() < fill.min() - 30


GOOD = arrow((0.5, -0.4, 0.0), (0.5, 0.4, 0.0))


@pytest.mark.parametrize(
    ("arrows", "said"),
    [
        (GOOD, "a sequence of Arrow"),
        (3, "a sequence of Arrow"),
        ([GOOD, "left"], "one entry 'left'"),
        ([GOOD._replace(tail=np.zeros(2))], "the tail of an arrow must be three finite numbers"),
        ([GOOD._replace(tip=np.array([0.0, np.nan, 0.0]))], "the tip of an arrow must be three finite numbers"),
        ([GOOD._replace(color=(300, 0, 0))], "from 0 to 255"),
        ([GOOD._replace(color="red")], "from 0 to 255"),  # type: ignore[arg-type]
        ([GOOD._replace(head=(0.0, 0.1))], "a length and a radius above 0 m"),
        ([GOOD._replace(head=(0.3, np.inf))], "a length and a radius above 0 m"),
    ],
)
def test_what_is_no_arrow_is_refused(world: World, arrows: Any, said: str) -> None:
    renderer = SpatialRenderer(world, 120, 120, CAMERA)
    with pytest.raises(ValueError, match=said):
        renderer.render(arrows=arrows)
    with pytest.raises(ValueError, match=said):
        renderer.frame(arrows=arrows)


def test_places_may_be_any_sequence(world: World) -> None:
    listed = GOOD._replace(tail=[0.5, -0.4, 0.0], tip=(0.5, 0.4, 0))  # type: ignore[arg-type]
    np.testing.assert_array_equal(shown(world, listed), shown(world, GOOD))


def test_an_arrow_behind_the_eye_does_not_fail(world: World) -> None:
    image = shown(world, arrow((2.5, 0.0, 0.0), (4.0, 0.1, 0.0)))
    assert image.shape == (120, 120, 3)


def test_an_arrow_without_length_is_not_drawn(world: World) -> None:
    none, other = arrow(ORIGIN, ORIGIN), arrow((0.5, -0.4, 0.0), (0.5, 0.4, 0.0))
    np.testing.assert_array_equal(shown(world), shown(world, none))
    np.testing.assert_array_equal(shown(world, other), shown(world, none, other))
