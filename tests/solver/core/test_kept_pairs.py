"""Pairs that are kept for several steps: the same ones as those of a new search, whatever happens in between."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.core.broadphase import BRUTE_FORCE_COUNT
from gsenv.solver.records.kernel_variants import ONE_KERNEL, kernel_variant_of
from gsenv.solver.records.model import Array
from gsenv.solver.records.scratch import Scratch
from tests.solver.bits import bits

COUNT = BRUTE_FORCE_COUNT + 20  # bodies: fewer have no tree
DIMS = pytest.mark.parametrize("dim", [2, 3])


def at(dim: int, x: float, z: float) -> tuple[float, ...]:
    """Return a place in the plane of the wall."""
    return (x, *(0.0,) * (dim - 2), z)


def box(*half_extents: float) -> planar.Shape | spatial.Shape:
    return planar.Box(half_extents=half_extents) if len(half_extents) == 2 else spatial.Box(half_extents=half_extents)


def wall(dim: int) -> Scene:
    """Boxes in layers on a floor, a little apart, that settle; and a ball that can be thrown at them."""
    rng = np.random.default_rng(dim)
    scene = Scene(dim=dim)
    scene.add_body("floor", "static", shapes=[box(*(40.0,) * (dim - 1), 0.5)])
    for k in range(COUNT):
        place = at(dim, 1.05 * (k % 30) - 15.0, 1.02 + 1.02 * (k // 30))
        scene.add_body(f"box_{k}", shapes=[box(*rng.uniform(0.48, 0.5, dim))], position=place)
    ball = planar.Circle(radius=0.3) if dim == 2 else spatial.Sphere(radius=0.3)
    scene.add_body("ball", shapes=[ball], position=at(dim, -20.0, 3.0), gravity_scale=0.0)
    return scene


def kept_boxes(world: World) -> list[Array]:
    """Return the kept boxes (shape,) of each thread."""
    found = [scratch.kept_boxes for scratch in world._scratches]
    known = [one for one in found if one is not None]
    assert len(known) == len(found)
    return known


def forget(world: World) -> None:
    """Make the next step search all pairs."""
    for boxes in kept_boxes(world):
        boxes["flags"] = 0


def kept(world: World) -> bool:
    """Whether pairs were kept."""
    return any(boxes["pairs"][0] > 0 for boxes in kept_boxes(world))


def both(dim: int, world_count: int = 1, **options: Any) -> tuple[World, World]:
    return tuple(World(wall(dim), world_count, options=Options(**options)) for _ in range(2))  # type: ignore[return-value]


def step_both(keeping: World, searching: World, steps: int) -> int:
    """Step both and compare all of their states; returns in how many of the steps pairs were kept."""
    count = 0
    for _ in range(steps):
        keeping.step()
        searching.step()
        count += kept(keeping)
        forget(searching)
        assert bits(keeping.state.bodies) == bits(searching.state.bodies)
        assert bits(keeping.state.worlds) == bits(searching.state.worlds)  # the number of pairs, too
    return count


@DIMS
def test_what_rests_and_what_flies_into_it(dim: int) -> None:
    keeping, searching = both(dim)
    assert step_both(keeping, searching, 60) > 25
    for world in (keeping, searching):
        world.set_velocity("ball", linear=at(dim, 25.0, 0.0))
    assert 0 < step_both(keeping, searching, 60) < 60
    assert step_both(keeping, searching, 200) > 100


@DIMS
def test_what_sleeps_and_is_woken(dim: int) -> None:
    keeping, searching = both(dim)
    step_both(keeping, searching, 200)
    assert keeping.asleep.any()
    for world in (keeping, searching):
        world.set_pose("ball", position=at(dim, 0.0, 9.0))
    step_both(keeping, searching, 120)


@DIMS
def test_bodies_that_are_put_elsewhere_switched_off_or_resized(dim: int) -> None:
    keeping, searching = both(dim, sleep=False)
    step_both(keeping, searching, 60)
    changes: list[Callable[[World], object]] = [
        lambda world: world.set_pose("box_3", position=at(dim, 2.3, 4.0)),
        lambda world: world.parameters.set("box_12", enabled=False),
        lambda world: world.reset(),
    ]
    for change in changes:
        for world in (keeping, searching):
            change(world)
        assert step_both(keeping, searching, 60) > 10


@DIMS
def test_worlds_that_share_a_thread_and_a_restored_state(dim: int) -> None:
    keeping, searching = both(dim, 2, sleep=False)
    for world in (keeping, searching):
        world.set_pose("box_7", position=at(dim, 1.2, 8.0), worlds=1)
    step_both(keeping, searching, 40)
    saved = keeping.save()
    step_both(keeping, searching, 20)
    for world in (keeping, searching):
        world.restore(saved)
    step_both(keeping, searching, 20)


@DIMS
def test_more_pairs_than_there_is_room_for(dim: int) -> None:
    keeping, searching = both(dim, sleep=False)
    step_both(keeping, searching, 40)
    for world in (keeping, searching):  # many boxes in one place
        for k in range(60):
            world.set_pose(f"box_{k}", position=at(dim, 0.01 * k, 20.0))
    step_both(keeping, searching, 3)
    assert keeping._scratches[0].pairs.shape[0] > 16 + 4 * (COUNT + 2)


@DIMS
def test_a_scene_without_shapes(dim: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernel of all scenes has the tree for each of them, and the number of kept pairs needs a place."""
    monkeypatch.setenv(ONE_KERNEL, str(dim))
    scene = Scene(dim=dim)
    scene.add_body("dot", mass=1.0, inertia=1.0 if dim == 2 else (1.0, 1.0, 1.0))
    model = scene.compile()
    scratch = Scratch(model, kernel_variant_of(model), 16)
    assert scratch.kept_boxes is not None
    assert len(scratch.kept_boxes) == 1


@DIMS
def test_where_much_moves_it_is_seldom_tried(dim: int) -> None:
    keeping, searching = both(dim, sleep=False)
    for world in (keeping, searching):
        world.set_velocity("ball", linear=at(dim, -5.0, 0.0))  # away from all, for ever
    tries = 0
    for _ in range(200):
        step_both(keeping, searching, 1)
        tries += int(kept_boxes(keeping)[0]["wait"][0] == 0)
    assert 3 <= tries < 30
    for world in (keeping, searching):
        world.set_velocity("ball", linear=at(dim, 0.0, 0.0))
    assert step_both(keeping, searching, 100) > 30
