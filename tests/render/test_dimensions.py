"""One call for the renderer of either dimension, and the camera that `gsenv record` sets for 3D scenes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gsenv.render
from gsenv import cli
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


def test_a_recording_has_the_camera_of_its_scene(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made = []

    def recorded_renderer(*arguments: Any) -> Any:
        made.append(make_renderer(*arguments))
        return made[-1]

    monkeypatch.setattr(gsenv.render, "make_renderer", recorded_renderer)
    monkeypatch.setattr(World, "step", lambda world, count=1: None)  # saves the kernels of a step
    out = tmp_path / "x.gif"
    assert cli.main(["record", "scene:cube_stack", "--out", str(out), "--steps", "1", "--size", "64x48"]) == 0
    eye, target = SCENES["cube_stack"].camera or (None, None)
    (renderer,) = made
    np.testing.assert_array_equal(renderer.camera.eye, eye)
    np.testing.assert_array_equal(renderer.camera.target, target)


def test_a_body_without_a_colour_beside_one_with() -> None:
    scene = Scene(dim=3)
    scene.add_body("ground", "static", [Plane()])
    scene.add_body("red", shapes=[Box(half_extents=(0.5, 0.5, 0.5))], position=(0.0, 0.0, 1.0), color=(200, 10, 20))
    table = read_table(World(scene))
    np.testing.assert_array_equal(table.color, [GROUND_COLOR, (200, 10, 20)])
