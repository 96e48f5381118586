"""Steps divided where an overlap has grown: overlaps, momentum, sums over the step, bits, buffers."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.core.contact_cache import pair_order
from gsenv.solver.core.division import accepted_depth, find_overlaps
from gsenv.solver.core.status import OK
from gsenv.solver.records.bundle import select_world
from tests.solver.bits import bits, everything

BOTH = pytest.mark.parametrize("dim", [2, 3])


def add_walls(scene: Scene, **material: Any) -> None:
    """The walls of a room of 6 m, 2 m thick."""
    for axis in range(scene.dim):
        for side, middle in (("low", -1.0), ("high", 7.0)):
            at, half = [3.0] * scene.dim, [5.0] * scene.dim
            at[axis], half[axis] = middle, 1.0
            shape: Any = planar.Box if scene.dim == 2 else spatial.Box
            scene.add_body(f"{side}_{axis}", "static", shapes=[shape(half_extents=half, **material)], position=at)


def crowded_room(dim: int, restitution: float, seed: int = 1, friction: float = 0.0, sensors: bool = False) -> Scene:
    """Boxes of 0.4 to 0.8 m that fly about at some 7 m/s (3D)."""
    rng = np.random.default_rng(seed)
    scene = Scene(dim=dim)
    material: dict[str, Any] = {"restitution": restitution, "friction": friction}
    add_walls(scene, **material)
    for k in range(36 if dim == 3 else 12):
        half = float(rng.uniform(0.2, 0.4))
        at: tuple[float, ...] = (0.9 + 1.4 * (k % 4), 0.9 + 1.4 * ((k // 4) % 3))
        shape: Any = planar.Box(half_extents=(half, half), **material)
        if dim == 3:
            at = (*at, 0.9 + 1.4 * (k // 12))
            shape = spatial.Box(half_extents=(half, half, half), **material)
        velocity = rng.normal(0.0, 4.0, dim).tolist()
        scene.add_body(f"box_{k}", shapes=[shape], position=at, linear_velocity=velocity)
        if sensors:
            scene.add_sensor(f"load_{k}", (planar if dim == 2 else spatial).ContactForceSensor(f"box_{k}"))
    return scene


@BOTH
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_boxes_that_fly_about_do_not_overlap(dim: int, restitution: float, seed: int) -> None:
    """Without division: 20 to 280 mm."""
    world = World(crowded_room(dim, restitution, seed=seed))
    worst = 0.0
    for _ in range(120):
        world.step()
        worst = max(worst, float(world.diagnostics().penetration[0]))
    assert worst < 0.01  # 1.2 to 2.5 % of their sizes; each pair may gain 1 % of a half-width in a step


@pytest.mark.parametrize("seed", [4, 5])
def test_boxes_that_spin_fast_do_not_overlap(seed: int) -> None:
    """Predicted contacts are no overlaps at the start of the step; as such they would hide those at its end."""
    world = World(crowded_room(2, 0.5, seed=seed, friction=0.3))
    moves = world.parameters.mass[0] > 0.0
    velocity = world.state.bodies["velocity"]
    velocity[0, :, 2] = np.random.default_rng(seed).normal(0.0, 60.0, len(moves)) * moves
    velocity[0, 4:, :2] *= 2.0
    for _ in range(25):
        world.step()
        assert world.diagnostics().penetration[0] < 0.005


def test_the_accepted_overlap_grows_with_the_number_of_bodies() -> None:
    depths = [float(accepted_depth(count)) for count in (0, 1, 128, 256, 1024, 1280, 10**6)]
    np.testing.assert_allclose(depths, [0.01, 0.01, 0.01, 0.02, 0.08, 0.1, 0.1], rtol=1e-15)


def overlap_of_a_pile_that_falls(halvings: int, seed: int) -> float:
    """Return the largest overlap in m of 256 boxes of 0.4 to 0.8 m."""
    rng = np.random.default_rng(seed)
    scene = Scene()
    scene.add_body("ground", "static", shapes=[planar.HalfPlane()])
    for x in (-1.0, 17.0):
        scene.add_body(f"wall_{x}", "static", shapes=[planar.Box(half_extents=(0.5, 40.0))], position=(x, 40.0))
    for k in range(256):
        box = planar.Box(half_extents=rng.uniform(0.2, 0.4, 2).tolist())
        at, angle = (0.5 + k % 16, 0.7 + k // 16), rng.uniform(0.0, 0.3)
        motion: dict[str, Any] = {"linear_velocity": rng.normal(0.0, 3.0, 2), "angular_velocity": rng.normal(0.0, 3.0)}
        scene.add_body(f"box_{k}", shapes=[box], position=at, angle=angle, **motion)
    world = World(scene, options=Options(halvings=halvings))
    worst = 0.0
    for _ in range(120):
        world.step()
        worst = max(worst, float(world.diagnostics().penetration[0]))
    assert world.diagnostics().finite.all()
    return worst


@pytest.mark.parametrize(("halvings", "least", "most"), [(4, 0.0045, 0.012), (0, 0.025, 0.1)])
def test_overlaps_of_a_pile_that_falls(halvings: int, least: float, most: float) -> None:
    """A pair may gain 2 % of a half-width in a step; with 1 % they overlap by 4 mm. Undivided piles vary by three."""
    overlaps = [overlap_of_a_pile_that_falls(halvings, seed) for seed in range(5)]
    assert min(overlaps) > 0.0045
    assert least < max(overlaps) < most


@BOTH
def test_without_halvings_steps_are_whole(dim: int) -> None:
    world = World(crowded_room(dim, 1.0), options=Options(halvings=0))
    worst = 0.0
    for _ in range(120):
        world.step()
        worst = max(worst, float(world.diagnostics().penetration[0]))
    assert worst > 0.008


@BOTH
def test_energy_of_elastic_boxes(dim: int) -> None:
    """None is made; in 3D one room in twelve loses 0.1 % of it in a single step, in which a fast corner hits twice."""
    gains = []
    for seed in range(1, 7):
        world = World(crowded_room(dim, 1.0, seed))
        start = world.diagnostics()
        first = start.kinetic_energy[0] + start.potential_energy[0]
        world.step(120)
        end = world.diagnostics()
        gains.append((end.kinetic_energy[0] + end.potential_energy[0]) / first - 1.0)
    assert max(gains) < 1e-6
    assert np.mean(gains) > -1e-3


@BOTH
@pytest.mark.parametrize(("restitution", "friction"), [(0.0, 0.0), (1.0, 0.0), (0.0, 0.5), (0.5, 0.5)])
def test_contact_forces_are_the_changes_of_momentum(dim: int, restitution: float, friction: float) -> None:
    """Newton's second law over each step, divided or not; contacts that end within the step count too."""
    world = World(crowded_room(dim, restitution, friction=friction, sensors=True))
    mass = world.parameters.mass[0]
    moving = [i for i, name in enumerate(world.model.body_names) if name.startswith("box")]
    weight = np.zeros(dim)
    weight[-1] = -9.81
    for _ in range(60):
        before = world.state.bodies["velocity"][0, moving, :dim].copy()
        world.step()
        change = world.state.bodies["velocity"][0, moving, :dim] - before
        for k, i in enumerate(moving):
            force = world.sensor(f"load_{k}")[0, :dim]
            expected = mass[i] * (change[k] / world.timestep - weight)
            np.testing.assert_allclose(force, expected, atol=1e-6 * mass[i] / world.timestep)


@BOTH
def test_reactions_are_the_changes_of_momentum(dim: int) -> None:
    """The same for boxes on pins, whose substeps follow from their tension."""
    scene = crowded_room(dim, 0.0, sensors=True)
    pin = planar.Revolute if dim == 2 else spatial.Ball
    middle = [1.6, 0.9] if dim == 2 else [1.6, 0.9, 0.9]
    scene.add_joint("pin", pin("box_0", "box_1", anchor=middle))
    world = World(scene)
    one, other = (world.model.body_names.index(name) for name in ("box_0", "box_1"))
    mass = world.parameters.mass[0]
    weight = np.zeros(dim)
    weight[-1] = -9.81
    largest = 0.0
    for _ in range(120):
        before = world.state.bodies["velocity"][0, :, :dim].copy()
        world.step()
        change = world.state.bodies["velocity"][0, :, :dim] - before
        reaction = world.joint_reaction("pin")[0, :dim]
        largest = max(largest, float(np.abs(reaction).max()))
        for k, i, sign in ((0, one, -1.0), (1, other, 1.0)):
            force = world.sensor(f"load_{k}")[0, :dim] + sign * reaction
            expected = mass[i] * (change[i] / world.timestep - weight)
            np.testing.assert_allclose(force, expected, atol=1e-6 * mass[i] / world.timestep)
    assert largest > 1.0


@BOTH
def test_sleeping_bodies_keep_their_load(dim: int) -> None:
    """Boxes that come to rest on a shelf, beside others whose steps are divided."""
    module: Any = planar if dim == 2 else spatial
    scene = crowded_room(dim, 1.0)
    shelf = module.Box(half_extents=(2.0, 0.5) if dim == 2 else (2.0, 2.0, 0.5))
    far = [20.0] * dim
    scene.add_body("shelf", "static", shapes=[shelf], position=far)
    for k in range(2):
        place = far.copy()
        place[-1] += 0.5 + 0.25 + 0.5 * k
        scene.add_body(f"rests_{k}", shapes=[module.Box(half_extents=(0.25,) * dim)], position=place)
    scene.add_sensor("load", module.ContactForceSensor("rests_0"))
    world = World(scene)
    names = world.model.body_names
    one, other = names.index("rests_0"), names.index("rests_1")
    weight = 9.81 * world.parameters.mass[0, one]
    world.step(10)
    asleep = 0
    for _ in range(110):
        world.step()
        assert world.sensor("load")[0, dim - 1] == pytest.approx(weight, rel=1e-3)
        asleep += int(world.state.bodies["asleep"][0, other])
    assert asleep > 50


@BOTH
def test_contacts_of_parts_are_listed_once(dim: int) -> None:
    """Normals differ in their last bits from part to part; by bits there were 50 entries too many, in 3D 709."""
    world = World(crowded_room(dim, 0.0))
    for _ in range(120):
        world.step()
        contacts = world.state.contacts[0, : world.state.worlds["contact_count"][0]]
        listed = list(zip(contacts["shape_a"], contacts["shape_b"], contacts["feature"], strict=True))
        assert len(listed) == len(set(listed))


@BOTH
def test_contacts_stay_sorted(dim: int) -> None:
    world = World(crowded_room(dim, 0.5))
    for _ in range(60):
        world.step()
        contacts = world.state.contacts[0, : world.state.worlds["contact_count"][0]]
        assert all(pair_order(a, b) <= 0 for a, b in pairwise(contacts))


@BOTH
def test_same_bits_in_a_batch_on_threads_and_after_a_restore(dim: int) -> None:
    scene = crowded_room(dim, 0.5)
    alone, batch = World(scene), World(scene, world_count=3, threads=2)
    batch.set_pose("box_3", position=[1.0] * dim, worlds=1)
    alone.step(20)
    batch.step(20)
    assert bits(alone.state.bodies[0]) == bits(batch.state.bodies[0]) == bits(batch.state.bodies[2])
    snapshot = alone.save()
    alone.step(20)
    other = World(scene)
    other.restore(snapshot)
    other.step(20)
    assert everything(alone) == everything(other)


@BOTH
def test_buffers_that_grow_leave_no_trace(dim: int) -> None:
    scene = crowded_room(dim, 0.0)
    small, large = World(scene), World(scene)
    large.state.grow_contacts(4096)
    small._scratches.clear()
    for world, capacity in ((small, 1), (large, 4096)):
        world._prepare_calls()
        world._scratches[0].grow_contacts(capacity)
        world._scratches[0].grow_pairs(capacity)
        world._calls = []
    small.state.contacts = small.state.contacts[:, :1].copy()
    for world in (small, large):
        world.apply_force("box_3", force=[5.0] * dim)
        world.step(40)
    assert 1 < small.state.contacts.shape[1] < 4096
    assert everything(small) == everything(large)


@BOTH
def test_what_is_driven_moves_at_its_speed(dim: int) -> None:
    """A kinematic slab and a dragged ball, beside boxes whose steps are divided."""
    scene = crowded_room(dim, 1.0)
    far = [20.0] * dim
    joints: Any = planar if dim == 2 else spatial
    slab: Any = planar.Box(half_extents=(1.0, 0.1)) if dim == 2 else spatial.Box(half_extents=(1.0, 1.0, 0.1))
    ball: Any = planar.Circle(radius=0.1) if dim == 2 else spatial.Sphere(radius=0.1)
    scene.add_body("slab", "kinematic", shapes=[slab], position=far, linear_velocity=[0.3] + [0.0] * (dim - 1))
    start = [30.0] * dim
    scene.add_body("ball", shapes=[ball], position=start, gravity_scale=0.0)
    scene.add_joint("hand", joints.Target("ball"))
    scene.add_actuator("drag", "hand", mode="velocity", axis="x")
    world = World(scene)
    world.control[0, 0] = 0.5
    world.step(120)
    names = world.model.body_names
    slab_at, ball_at = (world.position[0, names.index(name)] for name in ("slab", "ball"))
    np.testing.assert_allclose(slab_at, [20.6] + [20.0] * (dim - 1), atol=1e-9)
    assert ball_at[0] == pytest.approx(31.0, abs=0.02)


@BOTH
@pytest.mark.parametrize("gap", [0.01, 0.05, 0.2])
def test_a_row_on_the_ground_that_is_hit_does_not_overlap(dim: int, gap: float) -> None:
    """Eight boxes, the first at 30 m/s; with gaps of 5 cm two overlapped by 46 mm."""
    module: Any = planar if dim == 2 else spatial
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[planar.HalfPlane() if dim == 2 else spatial.Plane()])
    for k in range(8):
        x = k * (1.0 + gap) - (1.0 if k == 0 else 0.0)
        place = (x, 0.5) if dim == 2 else (x, 0.0, 0.5)
        velocity = [30.0 if k == 0 else 0.0] + [0.0] * (dim - 1)
        box = module.Box(half_extents=(0.5,) * dim)
        scene.add_body(f"box_{k}", shapes=[box], position=place, linear_velocity=velocity)
    world = World(scene)
    for _ in range(60):
        world.step()
        assert world.diagnostics().penetration[0] < 1e-3


@BOTH
def test_user_constraints_act_as_in_whole_steps(dim: int) -> None:
    """An error is given once a step, and a damper's softness for the usual substep."""
    ball: Any = planar.Circle(radius=0.1) if dim == 2 else spatial.Sphere(radius=0.1)
    paths = []
    for halvings in (0, 5):
        scene = crowded_room(dim, 1.0)
        for k, name in enumerate(("nudged", "damped")):
            at = [20.0 + 5.0 * k] * dim
            start = [1.0 if name == "damped" else 0.0] + [0.0] * (dim - 1)
            scene.add_body(name, shapes=[ball], mass=1.0, position=at, linear_velocity=start, gravity_scale=0.0)
        row = [1] + [0] * (2 if dim == 2 else 5)
        scene.add_constraint("nudge", ["nudged"], row, update=lambda world: {"error": -1e-3})
        scene.add_constraint("damper", ["damped"], row, softness=120.0 / 2.0)  # c = 2 N s/m at h = 1/120 s
        world = World(scene, options=Options(halvings=halvings))
        world.step(60)
        paths.append(world.position[0, -2:, 0] - [20.0, 25.0])
    whole, divided = paths
    assert whole[0] > 0.005
    np.testing.assert_allclose(divided, whole, rtol=0.02)


def test_halvings_are_checked() -> None:
    for bad in (-1, 17, 1.5):
        with pytest.raises(ValueError, match="halvings"):
            Options(halvings=bad)  # type: ignore[arg-type]


def heap_of_overlaps(dim: int) -> Scene:
    """Boxes of all sizes and turns that overlap by up to a fifth of their sizes, over a floor."""
    rng = np.random.default_rng(7)
    scene = Scene(dim=dim)
    scene.add_body("floor", "static", shapes=[planar.HalfPlane() if dim == 2 else spatial.Plane()])
    for k in range(120):
        half = rng.uniform(0.1, 0.3, dim)
        at = 0.45 * np.array([k % 11, k // 11, 0.0]) if dim == 2 else 0.45 * np.array([k % 5, k // 5 % 5, k // 25])
        place = (at + rng.normal(0.0, 0.06, 3))[:dim] + 0.2
        turn: Any = {"angle": float(rng.uniform(0.0, 7.0))} if dim == 2 else {"orientation": rng.normal(size=4)}
        shape: Any = planar.Box if dim == 2 else spatial.Box
        scene.add_body(f"box_{k}", shapes=[shape(half_extents=half)], position=place, **turn)
    return scene


@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.slow)])  # it compiles the narrowphase anew
@pytest.mark.parametrize("depth", [0.01, 0.1])
def test_overlaps_that_are_looked_for_from_a_depth_on_are_those_of_all(dim: int, depth: float) -> None:
    world = World(heap_of_overlaps(dim))
    world.step()  # makes the buffers large enough
    kernel_world: Any = world._calls[0][1]
    select_world(kernel_world, 0)

    def deep(least: float) -> tuple[int, Any]:
        status, _, count = find_overlaps(kernel_world, True, least)
        assert status == OK
        found = kernel_world.scratch.found[:count]
        return count, found[found["separation"] < -depth * found["extent"]].copy()

    count, wanted = deep(0.0)
    fewer, found = deep(depth)
    np.testing.assert_array_equal(found, wanted)
    assert len(wanted) > 10
    assert fewer < count
