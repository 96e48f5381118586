"""Every shape dropped on every other comes to rest, or rolls without getting faster, and makes no energy."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import World
from gsenv.solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Sphere
from tests.solver.spatial.one_kernel import full_world, on_plane

G = 9.81
DROP = 0.6  # m, from the middle of a dropped body to what it falls on
EXTENT = 0.2  # m, the least smallest half-width of those dropped
PRISM = [(x, y, z) for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (-0.25, 0.25)]

SMALL: dict[str, Callable[[], Any]] = {
    "sphere": lambda: Sphere(radius=0.3),
    "box": lambda: Box(half_extents=(0.3, 0.25, 0.2)),
    "capsule": lambda: Capsule(half_length=0.3, radius=0.2),
    "cylinder": lambda: Cylinder(half_length=0.3, radius=0.25),
    "hull": lambda: Hull(vertices=[*PRISM, (0, 0, 0.4)]),
}
ROLLS = ("sphere", "capsule", "cylinder")
BIG: dict[str, tuple[Callable[[], Any], float]] = {  # and how high it reaches above its origin
    "sphere": (lambda: Sphere(radius=1.0), 1.0),
    "box": (lambda: Box(half_extents=(1, 1, 0.5)), 0.5),
    "capsule": (lambda: Capsule(half_length=1.0, radius=0.5, orientation=(1, 0, 1, 0)), 0.5),
    "cylinder": (lambda: Cylinder(half_length=0.5, radius=1.0), 0.5),
    "lying cylinder": (lambda: Cylinder(half_length=1.0, radius=0.5, orientation=(1, 0, 1, 0)), 0.5),
    "hull": (lambda: Hull(vertices=[(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-0.5, 0.5)]), 0.5),
    "plane": (Plane, 0.0),
    "field": (lambda: Heightfield(heights=np.zeros((9, 9)), size=(4, 4)), 0.05),
    "hills": (lambda: Heightfield(heights=0.1 * np.random.default_rng(4).uniform(size=(13, 13)), size=(4, 4)), 0.2),
}
TURNS = {"level": (1.0, 0.02, 0.01, 0.0), "tilted": (1.0, 0.3, -0.4, 0.2)}


def dropped(small: str, big: str, turn: str, kind: str = "static") -> World:
    """Body 1 is what it falls on, body 2 falls."""
    scene = on_plane()
    shape, reach = BIG[big]
    flat = big in ("plane", "field", "hills")
    place = (0.0, 0.0, 0.0 if flat else reach)
    scene.add_body("big", "static" if flat else kind, shapes=[shape()], position=place)
    top = reach if flat else 2.0 * reach
    scene.add_body("small", shapes=[SMALL[small]()], position=(0.02, 0.01, top + DROP), orientation=TURNS[turn])
    return full_world(scene)


def watch(world: World, seconds: float, start: float) -> None:
    """Step; the energy never grows above that of the start, nor by much above its least, and nothing overlaps."""
    mass = np.where(world.model.bodies["kind"] == 2, world.parameters.mass[0], 0.0)
    scale = float(mass.sum()) * G * 2.0
    least = start
    for _ in range(round(seconds * 60)):
        world.step()
        d = world.diagnostics()
        assert np.isfinite(world.state.bodies["velocity"]).all()
        assert d.energy[0] <= start + 1e-3 * scale
        assert d.energy[0] <= least + 5e-3 * scale  # rocking on a ball turns it to and fro between two forms
        least = min(least, float(d.energy[0]))
    assert world.diagnostics().penetration[0] < 0.05 * EXTENT


def energy(world: World) -> float:
    return float(world.diagnostics().energy[0])


ROUND = ("sphere", "capsule", "lying cylinder")  # flat things rock on them
CASES = [
    (small, big, turn)
    for small, big, turn in itertools.product(SMALL, BIG, TURNS)
    if (turn == "tilted" or big in ROUND)
]


@pytest.mark.parametrize(("small", "big", "turn"), CASES)
def test_everything_dropped_on_everything_comes_to_rest(small: str, big: str, turn: str) -> None:
    world = dropped(small, big, turn)
    start = energy(world)
    watch(world, 5.0, start)
    speed = np.hypot.reduce(world.linear_velocity[0, 2])
    watch(world, 1.0, start)
    later = np.hypot.reduce(world.linear_velocity[0, 2])
    assert 0.0 < world.position[0, 2, 2] < 4.0
    if small in ROLLS and big == "hills":
        assert later < 1.0  # down one and up the next
    elif small in ROLLS:
        assert later <= max(speed, 0.01) * 1.001 or big in ROUND
    elif big in ROUND:
        assert later < 0.3  # it may rock, without loss
    else:
        assert later < 0.01
        assert np.hypot.reduce(world.angular_velocity[0, 2]) < 0.05


@pytest.mark.parametrize(("small", "seed"), [("box", 2), ("box", 8), ("hull", 9), ("capsule", 7), ("cylinder", 6)])
def test_what_rocks_and_rolls_on_hills_never_falls_into_them(small: str, seed: int) -> None:
    """Its weight passes from one ridge or peak to the next, each of which must be a contact before it is reached.

    An overlap would be corrected later, by lifting the body with a gain of energy.
    """
    rng = np.random.default_rng(seed)
    hills = Heightfield(heights=0.1 * rng.uniform(size=(13, 13)), size=(4, 4))
    turn = tuple((lambda q: q / np.linalg.norm(q))(rng.normal(size=4)))
    scene = on_plane()
    scene.add_body("hills", "static", shapes=[hills])
    place = (*rng.uniform(-1, 1, 2), 0.8)
    scene.add_body("small", shapes=[SMALL[small]()], position=place, orientation=turn)
    world = full_world(scene)
    world.step(60)
    weight = G * float(world.parameters.mass[0, 2])
    least = energy(world)
    for _ in range(420):
        world.step()
        assert world.diagnostics().penetration[0] < 1e-3 * EXTENT
        assert energy(world) < least + 2e-4 * weight
        least = min(least, energy(world))


@pytest.mark.parametrize("big", ["sphere", "box", "capsule", "cylinder", "lying cylinder", "hull"])
@pytest.mark.parametrize("small", SMALL)
def test_dropped_on_something_that_can_move(small: str, big: str) -> None:
    world = dropped(small, big, "tilted", kind="dynamic")
    watch(world, 4.0, energy(world))
    assert (world.position[0, 1:3, 2] > 0.15).all()


@pytest.mark.parametrize("big", ["plane", "field", "box", "hull", "cylinder"])
@pytest.mark.parametrize("small", SMALL)
def test_rests_at_its_height_on_level_ground(small: str, big: str) -> None:
    """As flat as it can lie, by its lowest point."""
    world = dropped(small, big, "level")
    world.step(240)
    top = 0.0 if big in ("plane", "field") else 2.0 * BIG[big][1]
    height = {"sphere": 0.3, "box": 0.2, "capsule": 0.2, "cylinder": 0.3, "hull": 0.25}[small]
    if small == "capsule":  # it topples
        assert world.position[0, 2, 2] < top + 0.5 + 1e-3
        return
    assert world.position[0, 2, 2] == pytest.approx(top + height, abs=2e-3)
