"""A world whose numbers overflow is told of once, and leaves the others alone."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from gsenv.solver import Scene, World, planar, spatial
from tests.solver.bits import bits


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
    with pytest.warns(RuntimeWarning, match="after step 6 the position or velocity of body 'rod' in world 1 is"):
        world.step()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(14):
            world.step()
    alone.step(20)
    state = world.diagnostics()
    np.testing.assert_array_equal(state.finite, [True, False, True])
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
    with pytest.warns(RuntimeWarning, match="in world 1 and bodies in 2 other worlds is"):
        world.step(3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.reset([1, 2, 3])
        world.step(10)
        assert world.diagnostics().finite.all()
        world.restore(snapshot)
        world.step(10)
    assert np.isfinite(world.position).all()
    spoil(world, 1)
    with pytest.warns(RuntimeWarning, match="in world 1 is"):  # again: it was cured
        world.step()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("exponent", range(6, 36, 3))
def test_forces_beyond_all_proportion_end_the_step(dim: int, exponent: int) -> None:
    """The steps of a swing under such a force would become shorter for ever."""
    world = World(pendulum(dim))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        for _ in range(5):
            world.apply_force("rod", force=np.full(dim, 0.7 * 10.0**exponent))
            world.step()
    assert world.state.worlds["step"][0] == 5
