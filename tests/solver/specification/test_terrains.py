"""Ground that goes from right to left is told, ceilings and caves are not."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

from gsenv.solver import Scene
from gsenv.solver.planar import Circle, Terrain

GROUND = [(5.0, 0.0), (0.0, -0.5), (-5.0, 0.0)]  # from right to left


def scene(height: float, x: float = 1.0, body: dict[str, Any] | None = None, **terrain: Any) -> Scene:
    made = Scene()
    made.add_body("hills", "static", [Terrain(**({"vertices": GROUND} | terrain))], **(body or {}))
    made.add_body("ball", shapes=[Circle(radius=0.1)], position=(x, height))
    return made


def test_ground_from_right_to_left_is_told() -> None:
    for one in (scene(1.0), scene(8.0, body={"position": (0, 7), "angle": 0.1}), scene(1.0, position=(0.5, 0.5))):
        with pytest.warns(UserWarning, match=r"^body 'hills': the Terrain goes from right to left, .* reverse"):
            one.compile()


def test_ground_with_a_step_below_which_others_are_and_loops_are_told() -> None:
    step = [(5, 0), (0, 0), (0, -1), (-5, -1)]
    overhang = [(5, 0), (0, 0), (0.001, -1), (-5, -1)]
    island = [(-5, -1), (5, -1), (5, 0), (-5, 0)]
    one_below = scene(1.0)
    one_below.add_body("below", shapes=[Circle(radius=0.1)], position=(0.0, -3.0))
    cave = scene(-0.5, vertices=island[::-1], closed=True)
    for one in (scene(1.0, vertices=step), scene(1.0, vertices=overhang), one_below, cave):
        with pytest.warns(UserWarning, match=r"^body 'hills': the Terrain goes .* reverse"):
            one.compile()
    with pytest.warns(UserWarning, match=r"the wrong way"):
        scene(1.0, vertices=island, closed=True).compile()


def platform_with_bodies_on_both_sides() -> Scene:
    made = scene(1.0, vertices=GROUND[::-1])
    made.add_body("below", shapes=[Circle(radius=0.1)], position=(0.0, -3.0))
    return made


@pytest.mark.parametrize(
    "right",
    [
        scene(1.0, vertices=GROUND[::-1]),
        scene(-1.0),  # a ceiling
        scene(1.0, x=7.0),
        scene(1.0, body={"angle": 3.14159}),
        scene(1.0, vertices=[(2, 2), (-2, 2), (-2, 0), (2, 0)], closed=True),
        scene(1.0, vertices=[(-2, -1), (-2, 0), (2, 0), (2, -1)], closed=True),  # on an island
        scene(0.5, vertices=[(-5, 0), (5, 0), (5, 3), (-5, 3)]),  # under a roof of the same chain
        platform_with_bodies_on_both_sides(),
    ],
)
def test_other_terrains_are_not(right: Scene) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert right.compile().shapes.size >= 2
