"""A stack under plain sweeps: one sweep lets it sink, more sweeps hold it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.scenes import stack
from gsenv.solver import Options, Scene, World, spatial
from gsenv.solver.planar import Circle, HalfPlane

G = 9.81
COUNT = 10
Loads = NDArray[np.float64]


def cold(sweeps: int) -> Options:
    """Plain sweeps that start from zero in each step, nothing else: no warm start, no position pass."""
    return Options(
        solver="pgs", sweeps=sweeps, substeps=1, warm_start=False, tolerance=0.0, position_sweeps=0, sleep=False
    )


def column() -> Scene:
    """Balls of 1 kg on top of one another: one contact each, so the sweeps can be done by hand."""
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane(friction=0)])
    for k in range(COUNT):
        ball = Circle(radius=0.5, friction=0)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0, 0.5 + k), mass=1.0)
    return scene


def loads(world: World) -> Loads:
    """N s under each body, from below."""
    contacts = world.contacts()
    return np.array([contacts.impulse[contacts.body_b == b, 0].sum() for b in range(1, COUNT + 1)])


def sweeps_by_hand(sweeps: int, h: float) -> Loads:
    """Projected Gauss-Seidel on A = J J^T of the column, J v = speed between neighbours."""
    a = 2.0 * np.eye(COUNT) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1)
    a[0, 0] = 1.0  # the ground has no mass to share
    b = np.zeros(COUNT)
    b[0] = -G * h  # all fall alike: only the lowest approaches anything
    impulse = np.zeros(COUNT)
    for _ in range(sweeps):
        for k in range(COUNT):
            impulse[k] = max(0.0, impulse[k] - (a[k] @ impulse + b[k]) / a[k, k])
    return impulse


@pytest.mark.parametrize("sweeps", [1, 2, 3, 10, 50, 300])
def test_sweeps_by_hand(sweeps: int) -> None:
    world = World(column(), options=cold(sweeps))
    world.step()
    np.testing.assert_allclose(loads(world), sweeps_by_hand(sweeps, world.timestep), rtol=1e-9, atol=1e-15)


def test_one_sweep_halves_the_load_from_ball_to_ball() -> None:
    # each contact stops the ball above it against one that was stopped already: m g h, m g h / 2, ...
    world = World(column(), options=cold(1))
    world.step()
    np.testing.assert_allclose(loads(world), G * world.timestep * 0.5 ** np.arange(COUNT), rtol=1e-9)


@pytest.mark.parametrize("scene", [column(), stack(COUNT)], ids=["balls", "boxes"])
def test_more_sweeps_carry_more_of_the_weight(scene: Scene) -> None:
    world = World(scene)
    exact = np.arange(COUNT, 0, -1) * G * world.timestep
    before = np.zeros(COUNT)
    for sweeps in (1, 2, 4, 8, 16, 32, 64, 128, 256, 512):
        world.reset()
        world.options = cold(sweeps)
        world.step()
        now = loads(world)
        assert (now >= before - 1e-3 * exact).all(), "the load under every body grows with the sweeps"
        assert (now <= 1.001 * exact).all()
        before = now
    np.testing.assert_allclose(before, exact, rtol=2e-2)


def height_after(seconds: float, options: Options) -> float:
    """How far the top of ten boxes is from where it belongs, m; positive is sunk."""
    world = World(stack(COUNT), options=options)
    world.step(round(seconds / world.timestep))
    return float(COUNT - 0.5 - world.position[0, COUNT, 1])


def test_one_sweep_sinks_and_many_hold() -> None:
    sunk = [height_after(1.0, cold(sweeps)) for sweeps in (1, 4, 16, 64, 256)]
    assert sunk[0] > 1.0
    assert all(a > b for a, b in itertools.pairwise(sunk))
    assert sunk[-1] < 0.02


def test_the_default_holds() -> None:
    assert abs(height_after(5.0, Options(sleep=False))) < 1e-3
    warm = Options(solver="pgs", substeps=1, position_sweeps=0, sleep=False, sweeps=30)
    assert abs(height_after(5.0, warm)) < 2e-2


def cubes(count: int) -> Scene:
    """Cubes above one another, 1 cm apart."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", [spatial.Plane()])
    for k in range(count):
        scene.add_body(f"box {k}", shapes=[spatial.Box((0.05, 0.05, 0.05))], position=(0, 0, 0.06 + 0.11 * k))
    return scene


@pytest.mark.parametrize("count", [20, 48, 70])
def test_a_column_that_lands_box_on_box_stands(count: int) -> None:
    world = World(cubes(count), 8)
    noise = np.random.default_rng(0)  # whether it falls must not depend on how sums are rounded
    for k in range(count):
        place = world.position[:, k + 1]
        world.set_pose(f"box {k}", position=place + 1e-10 * noise.standard_normal(place.shape))
    unsettled = np.zeros(8, int)
    for _ in range(300):
        world.step()
        unsettled += world.diagnostics().unconverged
    position = world.position[:, 1:]
    # 500 before direct steps went on without the corners that they lift, and in 5 of 16 worlds before they shared loads
    assert unsettled.max() <= 3
    assert abs(position[..., :2]).max() < 1e-3
    assert position[:, -1, 2] == pytest.approx(0.1 * count - 0.05, abs=1e-3)
    assert world.asleep[:, -1].all()


def test_corners_share_the_load_of_a_column_that_landed() -> None:
    world = World(cubes(10))
    world.step(120)
    contacts = world.contacts()
    load = contacts.impulse[contacts.body_a == 0, 0]
    np.testing.assert_allclose(load, load.mean(), rtol=1e-2)  # by symmetry; two of them carried all before
    assert len(load) == 4
