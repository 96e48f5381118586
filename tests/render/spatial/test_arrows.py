"""Arrows of 3D pictures: shape, and what shows of them behind other things."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from gsenv.render.spatial.arrows import HEAD_SHARE, Arrow, with_arrows
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.primitives import HULL, make_primitives
from gsenv.render.spatial.scene_renderer import SpatialRenderer
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


def shown(world: World, *arrows: Arrow) -> NDArray[np.int64]:
    renderer = SpatialRenderer(world, 120, 120, SpatialCamera((3.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    return renderer.render(arrows=arrows).astype(np.int64)


def test_an_arrow_is_solid_before_a_wall_and_faint_behind_it(world: World) -> None:
    plain = shown(world)
    before = shown(world, arrow((0.5, -0.4, 0.0), (0.5, 0.4, 0.0)))
    behind = shown(world, arrow((-0.5, -0.4, 0.0), (-0.5, 0.4, 0.0)))
    strength = [(image - plain)[58:62, 50:70, 0] - (image - plain)[58:62, 50:70, 2] for image in (before, behind)]
    assert strength[0].mean() > 60  # redder
    assert 20 < strength[1].mean() < 0.8 * strength[0].mean()


def test_an_arrow_behind_the_eye_does_not_fail(world: World) -> None:
    image = shown(world, arrow((2.5, 0.0, 0.0), (4.0, 0.1, 0.0)))
    assert image.shape == (120, 120, 3)


def test_an_arrow_without_length_is_not_drawn(world: World) -> None:
    none, other = arrow(ORIGIN, ORIGIN), arrow((0.5, -0.4, 0.0), (0.5, 0.4, 0.0))
    np.testing.assert_array_equal(shown(world), shown(world, none))
    np.testing.assert_array_equal(shown(world, other), shown(world, none, other))
