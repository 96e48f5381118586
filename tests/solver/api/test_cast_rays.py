"""World.cast_rays: what is seen, worlds that differ, the state of now, bad arguments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World, spatial
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


# ---------------------------------------------------------------- in space


def cloud() -> Scene:
    """Every shape of space, at different places over a field."""
    scene = Scene(dim=3)
    heights = np.random.default_rng(1).uniform(0.0, 0.5, (7, 8))
    scene.add_body("land", "static", [spatial.Heightfield(heights=heights, size=(9, 9))])
    shapes: list[spatial.Shape] = [
        spatial.Sphere(radius=0.4), spatial.Box(half_extents=(0.3, 0.4, 0.5)),
        spatial.Capsule(half_length=0.4, radius=0.3), spatial.Cylinder(half_length=0.4, radius=0.3),
        spatial.Hull(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]), spatial.Sphere(radius=0.2, sensor=True),
    ]  # fmt: skip
    for k, shape in enumerate(shapes):
        place = (2.0 * (k % 3) - 2.0, 2.0 * (k // 3) - 1.0, 1.5)
        scene.add_body(f"b{k}", shapes=[shape], position=place, mass=1.0, inertia=(1, 1, 1))
    scene.add_body("roof", "static", [spatial.Plane(normal=(0, 0, -1), offset=-9, category=4)])
    return scene


def test_filters_in_space() -> None:
    world = World(cloud(), world_count=2)
    up, above = (0, 0, 1), (-2.0, -1.0, 3.0)
    assert world.cast_rays(above, up, 9.0).shape[0, 0] == 7
    assert world.cast_rays(above, up, 9.0).normal[0, 0].tolist() == [0, 0, -1]
    assert world.cast_rays(above, up, 9.0, mask=3).shape[0, 0] == -1
    assert world.cast_rays(above, up, 9.0, exclude="roof").shape[0, 0] == -1
    world.parameters.set("b0", enabled=False, worlds=1)
    assert world.cast_rays(above, (0, 0, -1), 9.0).shape[:, 0].tolist() == [1, 0]
    world.parameters.set("land/0", enabled=False, worlds=1)
    assert world.cast_rays(above, (0, 0, -1), 9.0).shape[:, 0].tolist() == [1, -1]
    assert world.cast_rays((2.0, 1.0, 3.0), (0, 0, -1), 9.0).shape[:, 0].tolist() == [0, -1]  # through the sensor


def test_worlds_differ_in_poses_and_sizes_in_space() -> None:
    world = World(cloud(), world_count=3)
    world.parameters.set("b0", radius=0.7, worlds=1)
    world.parameters.set("b1", half_extents=(0.3, 0.4, 1.0), worlds=1)
    world.parameters.set("b2", half_length=0.9, worlds=1)
    world.set_pose("b0", position=(-2, -1, 2), worlds=2)
    world.set_pose("b3", position=(-2, 1, 2), orientation=(1, 1, 0, 0), worlds=2)
    starts = [(-2, -1, 5), (0, -1, 5), (2, -1, 5), (-2, 1, 5)]
    hits = world.cast_rays(starts, (0, 0, -2), 9.0)
    expected = [(3.1, 3.0, 2.8, 3.1), (2.8, 2.5, 2.3, 3.1), (2.6, 3.0, 2.8, 2.7)]
    np.testing.assert_allclose(hits.distance, expected, atol=1e-12)
    np.testing.assert_allclose(hits.normal, np.tile((0, 0, 1.0), (3, 4, 1)), atol=1e-12)
    some = world.cast_rays(starts, (0, 0, -2), 9.0, worlds=[2, 0])
    np.testing.assert_array_equal(some.distance, hits.distance[[2, 0]])
    none = world.cast_rays(starts[0], (0, 0, -2), 9.0, worlds=[False] * 3)
    assert (none.distance.shape, none.normal.shape) == ((0, 1), (0, 1, 3))


@pytest.mark.parametrize("dim", [2, 3])
def test_threads_and_batches_do_not_matter_and_a_snapshot_looks_the_same(dim: int) -> None:
    """Bit for bit."""
    rng = np.random.default_rng(4)
    count, scene = 5, cloud() if dim == 3 else row()
    world, several = World(scene, count), World(scene, count, threads=3)
    for k in (1, 2, 3):
        where = rng.uniform(0, 4, (count, dim))
        world.set_pose(k, position=where)
        several.set_pose(k, position=where)
    origin = rng.uniform(-5, 5, (count, 200, dim))
    rays = origin, rng.uniform(-1, 3, (count, 200, dim)) - origin, 12.0
    seen, fresh = world.cast_rays(*rays), World(scene, count)
    fresh.restore(world.save())
    assert 50 < seen.hit.sum() < 950
    alone = [world.cast_rays(rays[0][w], rays[1][w], 12.0, worlds=w) for w in range(count)]
    for name in ("distance", "shape", "body", "normal", "point"):
        wanted = getattr(seen, name).tobytes()
        assert getattr(several.cast_rays(*rays), name).tobytes() == wanted, name
        assert getattr(fresh.cast_rays(*rays), name).tobytes() == wanted, name
        assert b"".join(getattr(one, name).tobytes() for one in alone) == wanted, name


# ---------------------------------------------------------------- refused


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "origin NaN": ({"origin": (0, NAN)}, "origin must be finite"),
    "origin 3D": ({"origin": (0, 0, 0)}, "must fit"),
    "origins of three worlds": ({"origin": np.zeros((3, 4, 2))}, "must fit"),
    "origin one number": ({"origin": 0.0}, "must fit"),
    "origin 1D": ({"origin": (0.0,)}, "must fit"),
    "direction one number": ({"direction": 1.0}, "must fit"),
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


@pytest.mark.parametrize("change", [
    {"origin": (0, 0)}, {"direction": (1, 0)}, {"direction": np.ones((3, 2))}, {"origin": (0, 0, NAN)},
    {"direction": (0, 0, 0)}, {"length": 0.0}, {"length": -1.0}, {"length": NAN}, {"direction": (0, INF, 0)},
    {"origin": np.zeros((4, 3)), "direction": np.ones((2, 3))}, {"exclude": 99}, {"worlds": 7}, {"mask": 1.5},
])  # fmt: skip
def test_refused_in_space(change: dict[str, Any]) -> None:
    arguments: dict[str, Any] = {"origin": (0, 0, 0), "direction": (1, 0, 0), "length": 1.0}
    with pytest.raises(ValueError, match=r"^cast_rays[^\n]+\.$"):
        World(cloud()).cast_rays(**(arguments | change))
