"""A dropped ball against closed forms, at default and accurate settings."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from gsenv.scenes import bouncing_balls
from gsenv.scenes.spatial import bouncing_spheres
from gsenv.solver import Scene, World
from tests.validation.reference import BOTH, IMPACT, PLANE_AND_SPACE, REST, G, awake_world, world_of

RADIUS = 0.1


def dropped(dim: int, restitution: float) -> Scene:
    """Body 1 is a ball with its lowest point 1 m above the ground."""
    build = bouncing_balls if dim == 2 else bouncing_spheres
    return build([restitution], height=1.0, radius=RADIUS)


def apexes(world: World, seconds: float) -> list[float]:
    """m, heights of the lowest point at the tops of the flight parabolas."""
    tops = []
    y, v = world.position[0, 1, -1], world.linear_velocity[0, 1, -1]
    for _ in range(round(seconds / world.timestep)):
        world.step()
        y2, v2 = world.position[0, 1, -1], world.linear_velocity[0, 1, -1]
        # free flight through the top: the parabola's apex from this state
        if v > 0.0 >= v2 and v - v2 == pytest.approx(G * world.timestep, rel=1e-9):
            tops.append(float(y + v * v / (2 * G) - RADIUS))
        y, v = y2, v2
    return tops


@BOTH
@PLANE_AND_SPACE
def test_bounces_keep_their_ratio(fidelity: str, dim: int) -> None:
    tops = apexes(world_of(dropped(dim, 0.8), fidelity), 4.0)
    assert len(tops) >= 8
    for k, top in enumerate(tops[:8], start=1):
        assert top == pytest.approx(0.8 ** (2 * k), rel=IMPACT.at(fidelity))
    assert all(a > b for a, b in pairwise(tops))


@BOTH
@PLANE_AND_SPACE
def test_bouncing_stops_in_time(fidelity: str, dim: int) -> None:
    end = math.sqrt(2.0 / G) * (1 + 0.8) / (1 - 0.8)
    assert end == pytest.approx(4.0637128, abs=1e-6)
    world = awake_world(dropped(dim, 0.8), fidelity)
    last = 0.0
    for _ in range(300):
        world.step()
        moves = abs(world.linear_velocity[0, 1, -1]) > 1e-6  # m/s, a bounce of less than 1e-13 m
        if moves or world.position[0, 1, -1] > RADIUS + REST.balanced:
            last = float(world.time[0])
    assert last == pytest.approx(end, abs=world.timestep + IMPACT.at(fidelity) * end)
    assert world.position[0, 1, -1] == pytest.approx(RADIUS, abs=REST.at(fidelity))


@BOTH
@PLANE_AND_SPACE
def test_elastic_ball_keeps_its_height_for_100_bounces(fidelity: str, dim: int) -> None:
    world = world_of(dropped(dim, 1.0), fidelity)
    tops = apexes(world, 100 * 2 * math.sqrt(2.0 / G) + 0.5)
    assert len(tops) >= 100
    np.testing.assert_allclose(tops[:100], 1.0, rtol=IMPACT.at(fidelity))
    assert max(tops) <= 1.0 + 1e-9  # round-off of 100 bounces: no height is ever gained


@BOTH
@PLANE_AND_SPACE
def test_ball_without_restitution_stays_down(fidelity: str, dim: int) -> None:
    world = awake_world(dropped(dim, 0.0), fidelity)
    top = 0.0
    for _ in range(120):
        world.step()
        if world.time[0] > 0.5:
            top = max(top, float(world.position[0, 1, -1]) - RADIUS)
    assert top < IMPACT.at(fidelity)
    assert world.position[0, 1, -1] == pytest.approx(RADIUS, abs=IMPACT.at(fidelity))
