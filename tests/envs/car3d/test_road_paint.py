"""The road of GCar3D's pictures."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.envs.car3d import scene
from gsenv.envs.car3d.env import Car3DEnv
from gsenv.envs.car3d.road import HEADING, nearest
from gsenv.envs.car3d.road_paint import (
    KERB_PERIOD,
    MOST_KEPT,
    SPACING,
    X_POINTS,
    Y_POINTS,
    RoadPaint,
    find_kerbs,
    find_places,
)
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


def test_kerbs_begin_where_the_road_bends_as_much_as_they_say(env: Car3DEnv) -> None:
    path = env.task.task_state["path"][0]
    marks = find_kerbs(path)
    nodes = scene.FIRST_X + scene.STEP * np.arange(scene.NODES)
    bends = np.abs(np.gradient(path[:, HEADING], scene.STEP))
    assert (np.interp(marks, nodes, bends) > scene.KERB_BEND).all()
    for s in nodes[(bends > scene.KERB_BEND) & (nodes > 0.0) & (nodes < scene.FINISH)]:
        assert np.abs(marks - s).min() < KERB_PERIOD
    assert (marks % KERB_PERIOD == 0.5 * KERB_PERIOD).all()  # where `Stripes` has the middle of a mark


def beside(env: Car3DEnv, renderer: SpatialRenderer, s: float, aside: float) -> NDArray[np.int64]:
    """Return the mean colour of 4 x 4 cm of the ground at a length along the road and to its left, from above."""
    x, y, z, heading = env.task.task_state["path"][0][round((s - scene.FIRST_X) / scene.STEP)]
    place = np.array([x - aside * np.sin(heading), y + aside * np.cos(heading), z])
    camera = SpatialCamera(place + np.array([0.0, 0.0, 3.0]), place, (1.0, 0.0, 0.0), fov=0.5, width=60, height=60)
    color: NDArray[np.int64] = renderer.frame(camera=camera, **env.task.decor(0))[28:33, 28:33].mean((0, 1)).astype(int)
    return color


def is_red(color: NDArray[np.int64]) -> bool:
    return bool(color[0] > color[1] + 80)


def is_white(color: NDArray[np.int64]) -> bool:
    return bool(color.min() > 170)


def test_marks_are_whole_red_and_white_and_no_kerb_shows_on_straights(env: Car3DEnv) -> None:
    renderer = SpatialRenderer(env.task.world, 60, 60, quality="fast")
    reds = find_kerbs(env.task.task_state["path"][0])
    middle, far = scene.ROAD_HALF + 0.5 * scene.KERB, scene.ROAD_HALF + scene.KERB + 0.08
    for mark in reds[reds < 40.0]:
        for side in (-1.0, 1.0):
            for s in (mark - 0.25, mark + 0.25):  # nodes of the centre line
                assert is_red(beside(env, renderer, s, side * (scene.ROAD_HALF + 0.06)))
                assert is_red(beside(env, renderer, s, side * (scene.ROAD_HALF + scene.KERB - 0.06)))
                assert not is_red(beside(env, renderer, s, side * far))
                assert not is_red(beside(env, renderer, s, side * (scene.ROAD_HALF - 0.06)))
            for s in (mark - 0.75, mark + 0.75):
                assert is_white(beside(env, renderer, s, side * middle))
            for s in (mark - 2.75, mark - 2.25, mark + 2.25, mark + 2.75):  # of the next mark, or none
                expected = np.abs(reds - s).min() < 0.5 * scene.STRIP
                assert is_red(beside(env, renderer, s, side * (scene.ROAD_HALF + 0.06))) == expected
    for s in np.arange(3.0, 8.5, 0.5):
        for aside in (0.0, 1.0, scene.ROAD_HALF - 0.05, scene.ROAD_HALF + 0.08, middle + 0.05):
            assert not is_red(beside(env, renderer, s, aside))
        assert not is_white(beside(env, renderer, s, middle + 0.05))


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
