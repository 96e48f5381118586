"""The road of GCar3D's pictures."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

from gsenv.envs.car3d import scene
from gsenv.envs.car3d.env import Car3DEnv
from gsenv.envs.car3d.road import nearest
from gsenv.envs.car3d.road_paint import MOST_KEPT, SPACING, X_POINTS, Y_POINTS, RoadPaint, find_places
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.scene_renderer import SpatialRenderer


@pytest.fixture
def env() -> Car3DEnv:
    env = Car3DEnv(difficulty=1.0)
    env.reset(seed=3)
    return env


def test_places_are_those_of_the_rules(env: Car3DEnv) -> None:
    path = env.task.task_state["path"][0]
    places = find_places(path)
    shown = (places[..., 1] > scene.FIRST_STRIP) & (places[..., 1] < scene.FINISH + 8.0)
    rows, columns = np.nonzero((np.abs(places[..., 0]) < 2.6) & shown)
    assert len(rows) > 2.0 * 2.5 * 120.0 / SPACING**2
    for j, i in list(zip(rows.tolist(), columns.tolist(), strict=True))[::40]:
        s, aside = nearest(path, float(places[j, i, 1]), X_POINTS[i], Y_POINTS[j])
        assert abs(s - places[j, i, 1]) < 0.05
        assert abs(aside - places[j, i, 0]) < 0.02


def test_the_road_has_one_even_colour_from_edge_to_edge(env: Car3DEnv) -> None:
    """Looked at from above in bends that climb: boxes had dark steps of some cm there."""
    path = env.task.task_state["path"][0]
    renderer = SpatialRenderer(env.task.world, 200, 200, quality="fast")
    for s in (18.0, 22.0, 26.0, 56.0, 60.0):
        x, y, z, heading = path[round((s - scene.FIRST_X) / scene.STEP)]
        ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
        eye, target = np.array([x, y, z + 6.0]), np.array([x, y, z])
        renderer.camera = SpatialCamera(eye, target, ahead, fov=0.5, width=200, height=200)
        image: Any = renderer.render(**env.task.decor(0)).astype(int)
        half = round(50.0 / (6.0 * np.tan(0.25)))  # px, half a metre
        strips = image[:, 100 - half], image[:, 100 + half]
        for strip in strips:  # to either side of the dashes
            assert np.abs(np.diff(strip, axis=0)).max() < 8
            assert np.ptp(strip, axis=1).max() < 30  # grey


def test_roads_are_computed_once_an_episode_and_few_are_kept(env: Car3DEnv) -> None:
    paint = RoadPaint()
    path = env.task.task_state["path"][0]
    first = paint.stripes(0, path)
    assert paint.stripes(0, path) is first
    env.reset(seed=4)
    assert paint.stripes(0, env.task.task_state["path"][0]) is not first
    for world in range(MOST_KEPT + 5):
        paint.stripes(world, path)
    assert len(paint._kept) == MOST_KEPT
    assert pickle.loads(pickle.dumps(paint))._kept == {}
    assert copy.deepcopy(paint)._kept == {}
