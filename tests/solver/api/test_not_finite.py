"""A world whose numbers overflow is told of once, and leaves the others alone."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from tests.solver.bits import bits

ROOT = Path(__file__).parents[3]


def pendulum(dim: int) -> Scene:
    """A rod that hangs on a pin, and a box that falls."""
    scene = Scene(dim=dim)
    level = (0.0,) * (dim - 2)
    box = planar.Box(half_extents=(0.1, 0.5)) if dim == 2 else spatial.Box(half_extents=(0.1, 0.1, 0.5))
    scene.add_body("rod", shapes=[box], position=(0.0, *level, 2.0))
    scene.add_body("box", shapes=[box], position=(3.0, *level, 2.0))
    scene.add_body("hook", "static", position=(0.0, *level, 2.5))
    if dim == 2:
        scene.add_joint("pin", planar.Revolute("hook", "rod", anchor=(0.0, 2.5)))
    else:
        scene.add_joint("pin", spatial.Hinge("hook", "rod", anchor=(0.0, 0.0, 2.5), axis=(0.0, 1.0, 0.0)))
    return scene


def spoil(world: World, number: int) -> None:
    """Give the rod of a world a velocity that overflowed."""
    world.state.bodies["velocity"][number, world.model.body_names.index("rod"), 0] = np.inf


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("threads", [1, 2])
def test_the_world_is_named_and_the_others_go_on(dim: int, threads: int) -> None:
    world, alone = World(pendulum(dim), 3, threads=threads), World(pendulum(dim), 3)
    assert world.diagnostics().finite.all()
    world.step(5)
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="by step 6 the pose or velocity of body 'rod' in world 1 has") as told:
        world.step()
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(14):
            world.step()
    alone.step(20)
    state = world.diagnostics()
    np.testing.assert_array_equal(state.finite, [True, False, True])
    np.testing.assert_array_equal(state.unconverged > 0, ~state.finite)
    for values in (state.penetration, state.residual, state.joint_error, state.relative_joint_error):
        np.testing.assert_array_equal(np.isnan(values), ~state.finite)
    assert bits(world.state.bodies[[0, 2]]) == bits(alone.state.bodies[[0, 2]])
    np.testing.assert_array_equal(world.state.worlds["step"], 20)


@pytest.mark.parametrize("dim", [2, 3])
def test_all_that_are_lost_are_counted_and_a_reset_cures_them(dim: int) -> None:
    world = World(pendulum(dim), 4)
    snapshot = world.save()
    for number in (1, 2, 3):
        spoil(world, number)
    with pytest.warns(RuntimeWarning, match="in world 1 and bodies in 2 other worlds has") as told:
        world.step(3)
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.reset([1, 2, 3])
        world.step(10)
        assert world.diagnostics().finite.all()
        world.restore(snapshot)
        world.step(10)
    assert np.isfinite(world.position).all()
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="in world 1 has"):  # again: it was cured
        world.step()


@pytest.mark.parametrize("dim", [2, 3])
def test_a_rotation_counts(dim: int) -> None:
    world = World(pendulum(dim), 2)
    rod = world.model.body_names.index("rod")
    world.state.bodies["rotation"][1, rod] = np.nan if dim == 3 else 0.0
    np.testing.assert_array_equal(world.diagnostics().finite, [True, False])
    with pytest.warns(RuntimeWarning, match="body 'rod' in world 1 has"):  # the kernel sees it, too
        world.step()


@pytest.mark.parametrize("dim", [2, 3])
def test_a_lost_world_has_no_contacts_and_counts_no_work(dim: int) -> None:
    scene = pendulum(dim)
    level = (0.0,) * (dim - 2)
    shape = planar.Box(half_extents=(5.0, 0.5)) if dim == 2 else spatial.Box(half_extents=(5.0, 5.0, 0.5))
    scene.add_body("floor", "static", shapes=[shape], position=(0.0, *level, 0.0))
    world = World(scene, 2)
    world.step(40)
    touching = world.diagnostics().contacts
    assert touching[1] > 0
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="in world 1 has"):
        world.step()
    np.testing.assert_array_equal(world.diagnostics().contacts, [touching[0], 0])


@pytest.mark.parametrize("dim", [2, 3])
def test_a_world_that_a_pose_and_a_velocity_cured_is_told_of_again(dim: int) -> None:
    world = World(pendulum(dim), 2)
    assert world.lost is None
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="in world 1 has"):
        world.step()
    np.testing.assert_array_equal(world.lost, [False, True])
    world.set_velocity("rod", linear=np.zeros(dim))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.step()
    assert world.lost is None
    assert world.diagnostics().finite.all()
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="in world 1 has"):
        world.step()


@pytest.mark.parametrize("dim", [2, 3])
def test_the_step_in_which_a_world_is_lost_is_not_converged(dim: int) -> None:
    world = World(pendulum(dim), 2, options=Options(articulated=False))  # rows have a residual, a swing none
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        for _ in range(100):
            world.apply_force("rod", force=np.full(dim, 1e36), worlds=1)
            world.step()
            if world.lost is not None:
                break
    np.testing.assert_array_equal(world.lost, [False, True])
    np.testing.assert_array_equal(world.state.worlds["unconverged"] > 0, [False, True])


@pytest.mark.parametrize("dim", [2, 3])
def test_one_thread_loses_a_world_while_the_buffers_of_another_grow(dim: int) -> None:
    scene = pendulum(dim)
    shape = planar.Box(half_extents=(0.5,) * 2) if dim == 2 else spatial.Box(half_extents=(0.5,) * 3)
    level = (0.0,) * (dim - 2)
    for k in range(40):  # they start far apart, and are then put onto each other
        scene.add_body(f"box_{k}", shapes=[shape], position=(5.0 + 3.0 * k, *level, 0.0), gravity_scale=0.0)
    worlds = [World(scene, 2, threads=threads) for threads in (1, 2)]
    for world in worlds:
        world.step()
        for k in range(40):
            world.set_pose(f"box_{k}", position=(5.0 + 0.99 * (k % 7), *level, 0.99 * (k // 7)), worlds=0)
        spoil(world, 1)
        with pytest.warns(RuntimeWarning, match="by step [2-4] the pose or velocity of body 'rod' in world 1 has"):
            world.step(3)
        np.testing.assert_array_equal(world.state.worlds["step"], 4)
        assert world.diagnostics().contacts[0] > 40
    assert bits(worlds[0].state.bodies[:1]) == bits(worlds[1].state.bodies[:1])


@pytest.mark.parametrize("dim", [2, 3])
def test_a_scene_with_sensors_of_motion(dim: int) -> None:
    scene = pendulum(dim)
    scene.add_sensor("feel", (planar if dim == 2 else spatial).AccelerationSensor("box"))
    world = World(scene, 2)
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="in world 1 has") as told:
        world.step(2)
    assert told[0].filename == __file__
    assert np.isfinite(world.sensor("feel")[0]).all()


PUSH = """
import sys, warnings
import numpy as np
from gsenv.solver import World
from tests.solver.api.test_not_finite import pendulum

dim = int(sys.argv[1])
for exponent in range(6, 36, 3):
    world = World(pendulum(dim))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", RuntimeWarning)
        for _ in range(5):
            world.apply_force("rod", force=np.full(dim, 0.7 * 10.0**exponent))
            world.step()
    assert any("NaN" in str(one.message) for one in told) == (not world.diagnostics().finite[0])
print("done")
"""


@pytest.mark.parametrize("dim", [2, 3])
def test_forces_beyond_all_proportion_end_the_step(dim: int) -> None:
    """The steps of a swing under such a force became shorter for ever; within a kernel, where nothing interrupts."""
    done = subprocess.run(
        [sys.executable, "-c", PUSH, str(dim)], cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.stdout == "done\n", done.stderr
