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


@pytest.mark.parametrize(
    "right",
    [
        scene(1.0, vertices=GROUND[::-1]),
        scene(-1.0),  # a ceiling
        scene(1.0, x=7.0),
        scene(1.0, body={"angle": 3.14159}),
        scene(1.0, vertices=[(2, 2), (-2, 2), (-2, 0), (2, 0)], closed=True),
    ],
)
def test_other_terrains_are_not(right: Scene) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert right.compile().shapes.size == 2
