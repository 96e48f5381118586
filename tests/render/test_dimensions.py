"""One call for the renderer of either dimension, and what `gsenv record` aims at scenes in space."""

from typing import Any

import numpy as np
import pytest

from gsenv.cli import _aim
from gsenv.render import SceneRenderer, make_renderer
from gsenv.render.spatial import SpatialRenderer
from gsenv.render.spatial.style import GROUND_COLOR
from gsenv.render.spatial.world_view import read_table
from gsenv.scenes import SCENES, make_world
from gsenv.solver import Scene, World
from gsenv.solver.spatial import Box, Plane


@pytest.mark.parametrize(("name", "kind"), [("stack", SceneRenderer), ("cube_stack", SpatialRenderer)])
def test_each_dimension_has_its_renderer(name: str, kind: Any) -> None:
    renderer = make_renderer(make_world(name), 64, 48)
    assert type(renderer) is kind
    assert (renderer.width, renderer.height) == (64, 48)


def test_lines_of_text_are_written_over_the_same_picture() -> None:
    renderer = make_renderer(make_world("cube_stack"), 160, 120)
    plain, written = renderer.render(0), renderer.render(0, hud=["blocks 1 / 3"])
    changed = (plain != written).any(axis=2)
    assert changed[:20, :60].any()
    assert not changed[30:].any()


def test_scenes_in_space_are_seen_from_where_they_say() -> None:
    spec = SCENES["cube_stack"]
    assert spec.camera is not None
    renderer = make_renderer(make_world("cube_stack"), 64, 48)
    _aim(renderer, spec)
    np.testing.assert_array_equal(renderer.camera.eye, spec.camera[0])
    np.testing.assert_array_equal(renderer.camera.target, spec.camera[1])


def test_a_body_without_a_colour_beside_one_with() -> None:
    scene = Scene(dim=3)
    scene.add_body("ground", "static", [Plane()])
    scene.add_body("red", shapes=[Box(half_extents=(0.5, 0.5, 0.5))], position=(0.0, 0.0, 1.0), color=(200, 10, 20))
    table = read_table(World(scene))
    np.testing.assert_array_equal(table.color, [GROUND_COLOR, (200, 10, 20)])
