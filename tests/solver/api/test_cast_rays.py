"""World.cast_rays: what is seen, worlds that differ, the state of now, bad arguments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World
from gsenv.solver.planar import Box, Circle, HalfPlane, Terrain

INF, NAN = float("inf"), float("nan")


# ---------------------------------------------------------------- what is seen


def row() -> Scene:
    """Disks at x = 2, 4, 6, 8 with the categories 1, 2, 4 and the sign bit."""
    scene = Scene(gravity=(0, 0))
    for k, category in enumerate((1, 2, 4, 1 << 63)):
        scene.add_body(f"disk_{k}", shapes=[Circle(radius=0.5, category=category)], position=(2.0 * k + 2.0, 0))
    return scene


@pytest.mark.nojit
def test_masks_choose_categories() -> None:
    world = World(row())
    for mask, seen in {-1: 0, 1: 0, 2: 1, 6: 1, 4: 2, 1 << 63: 3, -(1 << 63): 3, 8: -1, 0: -1}.items():
        hits = world.cast_rays((0, 0), (1, 0), 20.0, mask=mask)
        assert hits.shape.tolist() == [[seen]]
        assert hits.distance.tolist() == [[1.5 + 2 * seen if seen >= 0 else 20.0]]


@pytest.mark.nojit
def test_unseen_are_the_excluded_the_disabled_and_sensors() -> None:
    scene = row()
    scene.add_body("zone", "static", [Box(half_extents=(30, 30), sensor=True)])
    world = World(scene, world_count=2)
    cast = [world.cast_rays((0, 0), (1, 0), 20.0, exclude=name).shape[:, 0].tolist() for name in (None, "disk_0", 1)]
    assert cast == [[0, 0], [1, 1], [0, 0]]
    world.parameters.set("disk_0", enabled=False, worlds=0)
    world.parameters.set("disk_1/0", enabled=False, worlds=0)
    assert world.cast_rays((0, 0), (1, 0), 20.0).shape[:, 0].tolist() == [2, 0]
    assert world.cast_rays((0, 0), (1, 0), 20.0, exclude="disk_2").shape[:, 0].tolist() == [3, 0]


def test_bodies_of_several_shapes() -> None:
    scene = Scene()
    scene.add_body("far", shapes=[Circle(radius=0.5)], position=(9, 0))
    scene.add_body("pair", shapes=[Circle(radius=0.5), Box(half_extents=(0.5, 0.5), position=(0, 3))])
    hits = World(scene).cast_rays([(-4, 0), (-4, 3), (5, 0)], (1, 0), 20.0)
    assert (hits.shape[0].tolist(), hits.body[0].tolist()) == ([1, 2, 0], [1, 1, 0])
    np.testing.assert_allclose(hits.distance[0], [3.5, 3.5, 3.5])


# ---------------------------------------------------------------- worlds and state


def test_worlds_differ_in_poses_sizes_and_ground() -> None:
    scene = Scene(gravity=(0, 0))
    scene.add_body("land", "static", [Terrain(vertices=[(-9, 0), (9, 0)])])
    scene.add_body("ball", shapes=[Circle(radius=0.5)], position=(4, 2))
    world = World(scene, world_count=3)
    world.parameters.set("ball", radius=1.0, worlds=1)
    world.set_pose("ball", position=(6, 2), worlds=2)
    world.parameters.set("land/0", worlds=2, vertices=[(-9, 1.5), (9, 1.5)])
    hits = world.cast_rays((0, 2), [(1, 0), (0, -1)], 20.0)
    np.testing.assert_allclose(hits.distance, [(3.5, 2.0), (3.0, 2.0), (5.5, 0.5)], atol=1e-12)
    some = world.cast_rays((0, 2), [(1, 0), (0, -1)], 20.0, worlds=[2, 0])
    np.testing.assert_array_equal(some.distance, hits.distance[[2, 0]])
    none = world.cast_rays((0, 2), (1, 0), 20.0, worlds=[False] * 3)
    assert (none.distance.shape, none.normal.shape) == ((0, 1), (0, 1, 2))


def test_a_centre_of_mass_beside_the_frame() -> None:
    """Shapes hang on the body's own frame, State keeps the centre of mass."""
    scene = Scene()
    scene.add_body("hook", shapes=[Circle(radius=0.5, position=(2, 0)), Circle(radius=0.1)], angle=np.pi / 2)
    assert World(scene).cast_rays((-3, 2), (1, 0), 9.0).distance.item() == pytest.approx(2.5, abs=1e-12)


def test_what_is_seen_is_the_state_of_now() -> None:
    """Not the geometry of the last step; and a restored snapshot looks the same, bit for bit."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    for k in range(4):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.3, 0.2))], position=(0.1 * k, 1.0 + k), angle=0.4 * k)
    world = World(scene, world_count=2)
    world.step(20)
    rng = np.random.default_rng(2)
    rays = rng.uniform(-3, 3, (2, 40, 2)), rng.normal(size=(2, 40, 2)), 9.0
    saved, seen = world.save(), world.cast_rays(*rays)
    assert seen.hit.any()
    world.step(30)
    assert not np.array_equal(world.cast_rays(*rays).distance, seen.distance)
    world.restore(saved)
    fresh = World(world.model, world_count=2)
    fresh.restore(saved)
    for other in (world, fresh):
        again = other.cast_rays(*rays)
        for name in ("distance", "shape", "body", "normal", "point"):
            assert getattr(again, name).tobytes() == getattr(seen, name).tobytes(), name
    world.set_pose("box_3", position=(20.0, 5.0), angle=0.0)
    assert world.cast_rays((20.0, 9.0), (0, -1), 9.0).distance[:, 0] == pytest.approx(9.0 - 5.2, abs=1e-12)


def test_casting_changes_nothing() -> None:
    world = World(row(), world_count=2)
    before = [array.tobytes() for array in (world.state.bodies, world.state.worlds, world.parameters.shapes)]
    origin, direction, length = np.zeros((3, 2)), np.ones((3, 2)), np.ones(3)
    world.cast_rays(origin, direction, length)
    assert [array.tobytes() for array in (world.state.bodies, world.state.worlds, world.parameters.shapes)] == before
    assert not origin.any()
    assert (direction == 1.0).all()
    assert (length == 1.0).all()


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "origin NaN": ({"origin": (0, NAN)}, "origin must be finite"),
    "origin 3D": ({"origin": (0, 0, 0)}, "must fit"),
    "origins of three worlds": ({"origin": np.zeros((3, 4, 2))}, "must fit"),
    "origin ragged": ({"origin": [[1], [1, 2]]}, "origin must be numbers"),
    "direction zero": ({"direction": [(1, 0), (0, 0)]}, "direction must not be zero"),
    "direction inf": ({"direction": (INF, 0)}, "direction must be finite"),
    "directions of another count": ({"origin": np.zeros((3, 2)), "direction": np.ones((4, 2))}, "must fit"),
    "directions too deep": ({"direction": np.ones((1, 2, 4, 2))}, "must fit"),
    "length zero": ({"length": 0.0}, "length must be positive, got"),
    "length inf": ({"length": INF}, "length must be finite"),
    "length text": ({"length": "far"}, "length must be numbers"),
    "lengths of another count": ({"direction": np.ones((4, 2)), "length": np.ones(3)}, "must fit"),
    "world unknown": ({"worlds": 2}, "worlds must be from 0 to 1"),
    "mask a fraction": ({"mask": 0.5}, "mask must be an integer"),
    "mask of 65 bits": ({"mask": 2**64}, "mask must be an integer"),
    "body unknown": ({"exclude": "disc_0"}, "did you mean 'disk_0'"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_sentence(case: str) -> None:
    change, words = REFUSED[case]
    world = World(row(), world_count=2)
    arguments: dict[str, Any] = {"origin": (0, 0), "direction": (1, 0), "length": 1.0}
    with pytest.raises(ValueError, match=r"^cast_rays[^\n]+\.$") as error:
        world.cast_rays(**(arguments | change))
    assert words in str(error.value)
