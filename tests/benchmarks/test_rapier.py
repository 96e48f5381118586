"""Rapier behind the benchmark's interface, against closed forms; needs its package."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from benchmarks.accuracy.cases3d import all_cases
from benchmarks.accuracy.points import finite_error, record
from benchmarks.accuracy.settings_rapier import setting_of
from benchmarks.common.timing import cpu_time
from gsenv.scenes.spatial import bouncing_spheres, cube_stack, two_rods

pytest.importorskip("rapier3d", reason="the extra `bench` has it")
CASES = {case.key: case for case in all_cases()}


@pytest.mark.parametrize(
    ("key", "most"), [("rolling:cylinder", 2e-3), ("rolling:sphere", 2e-3), ("slide_to_roll:sphere", 1e-2),
                      ("incline:slide45", 2e-3), ("tumbling:slow", 6e-2), ("gyroscope", 5e-2)],
)  # fmt: skip
def test_it_is_close_to_the_closed_form(key: str, most: float) -> None:
    from benchmarks.accuracy.engines.rapier import Simulation

    case, setting = CASES[key], setting_of(120, 4, "", {})
    model = case.scene().compile()
    error = finite_error(case.error, record(Simulation(model, setting), case, model, setting.timestep))
    assert error is not None
    assert 0.0 < error < most


def test_poses_and_velocities_are_the_scenes() -> None:
    from benchmarks.accuracy.engines.rapier import Simulation

    for scene in (cube_stack(3), two_rods(), bouncing_spheres([0.5])):
        model = scene.compile()
        state = Simulation(model, setting_of(60, 4, "", {})).read()
        start = model.start_bodies
        np.testing.assert_allclose(state[:, :3], start["position"], atol=1e-6)
        turns = np.abs((state[:, 3:7] * start["rotation"]).sum(1))
        np.testing.assert_allclose(turns, 1.0, atol=1e-6)
        np.testing.assert_allclose(state[:, 7:], start["velocity"], atol=1e-6)


@pytest.mark.parametrize("reduced", [False, True])
def test_joints_hold_while_a_pendulum_falls_through_the_vertical(reduced: bool) -> None:
    """A pendulum of two rods that starts level falls through the vertical; its lower ends stay at their lengths."""
    from benchmarks.accuracy.engines.rapier import Simulation

    model = two_rods().compile()
    simulation = Simulation(model, setting_of(480, 4, "", {"reduced": reduced}))
    places = []
    for _ in range(240):
        simulation.step(2)
        places.append(simulation.read()[:, :3])
    reach = np.linalg.norm(np.array(places)[:, 1] - places[0][0], axis=1)
    assert np.abs(reach - 0.5).max() < 5e-3
    assert np.array(places)[:, 1, 2].min() < -0.4


def test_stiffer_contacts_overlap_less() -> None:
    from benchmarks.accuracy.engines.rapier import Simulation

    model = cube_stack(5).compile()
    heights = []
    for word, values in (("", {}), ("stiff", {"spring": (1.0 / 8.0, 10.0)})):
        simulation = Simulation(model, setting_of(120, 8, word, values))
        simulation.step(240)
        heights.append(simulation.read()[-1, 2])
    assert heights[0] < heights[1] - 1e-4
    assert math.isclose(heights[1], 4.5, abs_tol=2e-3)


def test_its_time_is_counted_though_a_thread_of_its_own_spends_it() -> None:
    """More substeps cost more: the calling thread alone, which only waits, would show nothing of it."""
    from benchmarks.accuracy.engines.rapier import Simulation

    model = cube_stack(20).compile()
    few, many = (
        min(cpu_time(partial(Simulation(model, setting_of(60, count, "", {})).step, 60)) for _ in range(3))
        for count in (4, 64)
    )
    assert many > 3.0 * few
