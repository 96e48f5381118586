"""Bodies at rest keep their contacts from step to step, take one substep, and notice whatever is changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.scenes.spatial.stacks import cube_pyramid, cube_stack
from gsenv.solver import Options, Scene, World, spatial
from gsenv.solver.core.recycling import FARTHEST
from gsenv.solver.planar import Box, Circle, Terrain
from tests.solver.bits import everything

AWAKE = Options(sleep=False)
G = 9.81
UP = {2: 1, 3: 2}


def box_on_table(dim: int) -> Scene:
    """A box of side 1 m at rest on a static table, its lower side at height 0."""
    scene = Scene(dim=dim)
    table: Box | spatial.Box = Box(half_extents=(3, 0.5))
    box: Box | spatial.Box = Box(half_extents=(0.5, 0.5), density=1.0)
    if dim == 3:
        table = spatial.Box(half_extents=(3, 3, 0.5))
        box = spatial.Box(half_extents=(0.5, 0.5, 0.5), density=1.0)
    scene.add_body("table", kind="static", shapes=[table], position=(0.0,) * (dim - 1) + (-0.5,))
    scene.add_body("box", shapes=[box], position=(0.0,) * (dim - 1) + (0.5,))
    return scene


def at_rest(dim: int) -> World:
    world = World(box_on_table(dim), options=AWAKE)
    world.step(60)
    return world


def contacts_of(world: World) -> np.ndarray:
    return world.state.contacts[0, : int(world.state.worlds["contact_count"][0])].copy()


@pytest.mark.parametrize("dim", [2, 3])
def test_contacts_of_a_box_at_rest_are_kept_and_one_sweep_confirms_them(dim: int) -> None:
    world = at_rest(dim)
    before = contacts_of(world)
    world.step(30)
    after = contacts_of(world)
    assert len(before) == 2 * (dim - 1)
    np.testing.assert_array_equal(after["travel"], before["travel"])
    np.testing.assert_array_equal(after["point"], before["point"])
    d = world.diagnostics()
    assert d.sweeps[0] == 1  # of one substep, not of two
    height = world.position[0, 1, UP[dim]] - 0.5
    assert after["separation"].mean() == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_narrowphase_looks_again_after_a_small_motion(dim: int) -> None:
    """A push of 0.1 mm/s: within seconds the path is longer than what contacts are kept for."""
    world = at_rest(dim)
    world.parameters.set("box", friction=0.0)
    world.parameters.set("table", friction=0.0)
    world.step(2)
    start = contacts_of(world)
    world.state.bodies["velocity"][0, 1, 0] = 1e-4  # unlike set_velocity, this does not wake the box
    x = world.position[0, 1, 0]
    seen = set()
    for _ in range(120):
        world.step()
        contacts = contacts_of(world)
        seen.add(float(contacts["travel"][0]))
        path = world.state.bodies["travel"][0, 1] - contacts["travel"][0]
        assert path <= 0.5 * FARTHEST + 1e-4 / 60 + 1e-9
    assert 3 <= len(seen) <= 8
    moved = world.position[0, 1, 0] - x
    assert moved == pytest.approx(2e-4, rel=1e-3)
    assert abs(contacts_of(world)["point"] - start["point"])[:, 0].max() == pytest.approx(moved, abs=1e-4)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_box_at_rest_notices_a_new_size(dim: int) -> None:
    """Also where a kernel writes it, which wakes nothing."""
    world = at_rest(dim)
    world.state.bodies["sleep_time"][:] = 1.0
    world.parameters.shapes["size"][0, 1] *= 1.02
    world.step()
    assert contacts_of(world)["separation"].min() == pytest.approx(-0.01, abs=0.004)  # a part is corrected already
    world.step(240)
    assert world.position[0, 1, UP[dim]] == pytest.approx(0.51, abs=1e-4)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_box_at_rest_notices_that_its_table_has_gone(dim: int) -> None:
    world = at_rest(dim)
    world.set_pose("table", position=(0.0,) * (dim - 1) + (-5.0,))
    height = world.position[0, 1, UP[dim]]
    world.step(30)
    assert height - world.position[0, 1, UP[dim]] == pytest.approx(0.5 * G * 0.5**2, rel=1e-3)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_force_moves_a_box_at_rest_at_once(dim: int) -> None:
    """It is written as kernels do it; ten times its weight, upwards: it leaves the table by the exact parabola."""
    world = at_rest(dim)
    height = world.position[0, 1, UP[dim]]
    for _ in range(6):
        world.state.bodies["force"][0, 1, UP[dim]] = 10.0 * G
        world.step()
    assert world.position[0, 1, UP[dim]] - height == pytest.approx(0.5 * 9.0 * G * 0.1**2, rel=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_slowly_rolling_ball_keeps_its_speed(dim: int) -> None:
    """A contact that stayed behind the ball would push it: 0.5 mm/s became 0.8 mm/s."""
    scene = Scene(dim=dim)
    ground = Box(half_extents=(3, 0.5)) if dim == 2 else spatial.Box(half_extents=(3, 3, 0.5))
    ball = Circle(radius=0.5) if dim == 2 else spatial.Sphere(radius=0.5)
    scene.add_body("ground", kind="static", shapes=[ground], position=(0.0,) * (dim - 1) + (-0.5,))
    scene.add_body("ball", shapes=[ball], position=(0.0,) * (dim - 1) + (0.5,))
    world = World(scene, options=AWAKE)
    world.step(60)
    v = 5e-4
    world.set_velocity("ball", linear=(v, 0.0, 0.0)[:dim], angular=-v / 0.5 if dim == 2 else (0.0, v / 0.5, 0.0))
    world.step(600)
    assert world.linear_velocity[0, 1, 0] == pytest.approx(v, rel=1e-4)


@pytest.mark.parametrize("build", [lambda: stack(10), lambda: cube_stack(10)], ids=["2D", "3D"])
def test_a_tower_at_rest_does_not_drift(build) -> None:  # type: ignore[no-untyped-def]
    """Slow modes hardly change the contacts, so that a check of these alone let the tower sway by 0.1 mm and more."""
    world = World(build(), options=AWAKE)
    start = world.position.copy()
    sweeps = 0
    for _ in range(20):
        world.step(60)
        sweeps += int(world.diagnostics().sweeps[0])
        assert abs(world.position - start).max() < 5e-5
    assert sweeps <= 25  # one for a step, and now and then a solve


@pytest.mark.parametrize("build", [lambda: stack(10), lambda: cube_pyramid(4)], ids=["2D", "3D"])
def test_a_restored_state_at_rest_continues_bit_for_bit(build) -> None:  # type: ignore[no-untyped-def]
    world = World(build(), options=AWAKE)
    world.step(77)
    kept = world.save()
    world.step(50)
    expected = everything(world)
    other = World(build(), options=AWAKE)
    other.restore(kept)
    other.step(50)
    assert everything(other) == expected


def test_a_body_at_rest_that_is_hit_meets_walls_beyond_its_contacts() -> None:
    """Floor and wall are one terrain, and the contacts of the last step are those with the floor.

    The oracle is a world in which nothing counts as being at rest, so that all contacts are searched.
    """
    scene = Scene()
    scene.add_body("ground", "static", [Terrain(vertices=[(-5, 0), (1, 0), (1, 2), (5, 2)])])
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5), density=1.0)], position=(0.48, 0.5))
    scene.add_body("ball", shapes=[Circle(radius=0.2, density=1e3)], position=(-0.28, 0.5), gravity_scale=0.0)
    options = replace(AWAKE, halvings=0)
    world, restless = World(scene, options=options), World(scene, options=replace(options, sleep_speed=0.0))
    for one in (world, restless):
        one.step(60)
        one.set_velocity("ball", linear=(6.0, 0.0))
        one.step()
    assert world.linear_velocity[0, 1, 0] > 1.0  # it was hit
    np.testing.assert_allclose(world.position[0, 1], restless.position[0, 1], atol=1e-5)


def test_a_state_of_the_past_that_is_written_over_the_present_is_searched() -> None:
    world = at_rest(2)
    bodies = world.state.bodies.copy()
    world.set_velocity("box", linear=(1.0, 0.0))
    world.step(90)
    assert world.position[0, 1, 0] > 0.05
    world.state.bodies[:] = bodies
    world.step()
    np.testing.assert_allclose(contacts_of(world)["point"][:, 0], [-0.5, 0.5], atol=1e-3)


def test_damping_of_slow_bodies_is_as_accurate_as_the_substeps() -> None:
    """A frictionless box at 1 mm/s with a damping of 2/s, 1 s long; implicit Euler with a step of h."""
    scene = Scene()
    scene.add_body("table", "static", [Box(half_extents=(3, 0.5), friction=0.0)], position=(0, -0.5))
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5), friction=0.0)], position=(0, 0.5), linear_damping=2.0)
    world = World(scene, options=replace(AWAKE, substeps=8))
    world.step(30)
    world.set_velocity("box", linear=(1e-3, 0.0))
    world.step(60)
    assert world.linear_velocity[0, 1, 0] == pytest.approx(1e-3 * (1.0 + 2.0 / 480.0) ** -480, rel=1e-6)
