"""The error functions of spatial scenes, on trajectories made from closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.accuracy import errors, errors3d, geometry3d
from benchmarks.accuracy.cases3d import FAST, FIRST_FLIP, FLIP_PERIOD, SLOW, all_cases
from benchmarks.accuracy.settings3d import gsenv_settings, mujoco_settings, pybullet_settings
from benchmarks.accuracy.settings_rapier import rapier_settings
from benchmarks.accuracy.trajectory import STATE3, Trajectory
from gsenv.scenes.spatial import (
    block_on_incline,
    cube_stack,
    gyroscope,
    sphere_cradle,
    sphere_grid,
    spinning_box,
    two_rods,
)
from gsenv.scenes.spatial.turning import about
from gsenv.solver import Scene

Array = NDArray[np.float64]


def made(scene: Scene, seconds: float, rate: float = 60.0) -> Trajectory:
    """All bodies where they start, at all times."""
    model = scene.compile()
    times = np.arange(round(seconds * rate) + 1) / rate
    start = np.concatenate([model.start_bodies[name] for name in ("position", "rotation", "velocity")], 1)
    assert start.shape[1] == STATE3
    return Trajectory(times, np.repeat(start[None], len(times), 0), model)


# ----------------------------------------------------------------- geometry


def overlap(second: Array, turn: Array) -> float:
    """m, of two unit cubes, the first at the origin; -inf where even their balls are apart."""
    turns = np.array([[1.0, 0.0, 0.0, 0.0], turn])
    place = np.array([np.zeros(3), second])
    return float(geometry3d.box_overlaps(place, turns, np.full((2, 3), 0.5)).max(initial=-np.inf))


def test_overlap_of_boxes_in_closed_form() -> None:
    straight = np.array([1.0, 0.0, 0.0, 0.0])
    assert overlap(np.array([0.2, 0.1, 0.9]), straight) == pytest.approx(0.1)  # face on face
    assert overlap(np.array([0.0, 0.0, 1.01]), straight) == pytest.approx(-0.01)  # a gap
    edge = np.array(about(0, 45.0))
    assert overlap(np.array([0.1, 0.0, 0.5 + math.sqrt(0.5) - 0.03]), edge) == pytest.approx(0.03)  # edge into face


def test_overlap_is_the_shortest_way_out() -> None:
    """Oracle: the boxes part after a shift by the depth in some direction, and in none after a shorter one."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    tried = 0
    while tried < 4:
        place, turn = rng.uniform(-0.9, 0.9, 3), rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        depth = overlap(place, turn)
        if depth < 0.02:
            continue
        tried += 1
        assert not any(overlap(place + 0.98 * depth * d, turn) < 0.0 for d in directions)
        assert any(overlap(place + 1.05 * depth * d, turn) < 0.0 for d in directions)


def test_turning_by_quaternions() -> None:
    """Oracle: Rodrigues' formula."""
    rng = np.random.default_rng(1)
    axis, vector, angle = rng.normal(size=3), rng.normal(size=3), 1.3
    axis /= np.linalg.norm(axis)
    turn = np.array([math.cos(0.5 * angle), *(math.sin(0.5 * angle) * axis)])
    expected = (
        vector * math.cos(angle)
        + np.cross(axis, vector) * math.sin(angle)
        + axis * (axis @ vector) * (1.0 - math.cos(angle))
    )
    assert geometry3d.rotated(turn, vector) == pytest.approx(expected)
    assert geometry3d.matrices(turn) @ vector == pytest.approx(expected)
    twice = geometry3d.multiply(turn, turn)
    assert geometry3d.rotated(twice, vector) == pytest.approx(geometry3d.rotated(turn, expected))


# ----------------------------------------------------------------- errors


def test_exact_tower_has_no_error_and_a_sunk_one_has() -> None:
    tower = made(cube_stack(4), 1.0, 2.0)
    assert errors.standing_error(tower) == pytest.approx(0.0, abs=1e-12)
    tower.states[-1, 2:, 2] -= 0.004
    assert errors.standing_error(tower) == pytest.approx(0.004)
    tower.states[-1, 1:, 1] += 0.011  # sideways, along y
    assert errors.standing_error(tower) == math.inf


def test_block_that_goes_astray_is_wrong() -> None:
    slid = made(block_on_incline(35.0), 2.0)
    down = np.array([math.cos(math.radians(35.0)), 0.0, -math.sin(math.radians(35.0))])
    slid.states[:, 1, :3] += np.outer(0.8 * slid.times**2, down)
    assert errors3d.slope_error(slid, lambda t: 0.8 * t**2, down.tolist()) < 1e-12
    slid.states[-1, 1, 1] += 0.032
    assert errors3d.slope_error(slid, lambda t: 0.8 * t**2, down.tolist()) == pytest.approx(0.01)


def test_flips_are_those_of_the_table() -> None:
    flips = errors3d.flip_times(*SLOW, 60.0, 5e-3)
    assert flips == pytest.approx([FIRST_FLIP + k * FLIP_PERIOD for k in range(3)], rel=1e-7)


def test_tumbling_by_fine_steps_has_no_error() -> None:
    """Oracle: midpoint steps of attitude and momentum, fine enough."""
    inertia, spin = np.array(FAST[0]), np.array(FAST[1])
    tumbled = made(spinning_box(*FAST), 10.0)
    turn, momentum, fine = np.array([1.0, 0.0, 0.0, 0.0]), inertia * spin, 8
    h = 1.0 / 60.0 / fine

    def world_spin(q: Array) -> Array:
        return geometry3d.rotated(q, geometry3d.rotated(geometry3d.conjugate(q), momentum) / inertia)

    def moved(q: Array, w: Array, t: float) -> Array:
        angle = float(np.linalg.norm(w)) * t
        step = np.array([math.cos(0.5 * angle), *(math.sin(0.5 * angle) * w / np.linalg.norm(w))])
        return geometry3d.multiply(step, q)

    for k in range(1, len(tumbled.times)):
        for _ in range(fine):
            turn = moved(turn, world_spin(moved(turn, world_spin(turn), 0.5 * h)), h)
        tumbled.states[k, 0, 3:7], tumbled.states[k, 0, 10:13] = turn, world_spin(turn)
    flips = errors3d.flip_times(*FAST, 10.0)
    assert len(flips) == 1
    assert errors3d.tumbling_error(tumbled, flips) < 2e-4
    tumbled.states[-1, 0, 10:13] *= 1.01
    assert errors3d.tumbling_error(tumbled, flips) == pytest.approx(0.0201, rel=1e-2)  # energy
    assert errors3d.tumbling_error(tumbled, flips[:0]) == math.inf


def test_swings_energies_and_gaps_in_space() -> None:
    assert errors.swings(made(sphere_cradle(2), 0.1))[0] == pytest.approx([math.radians(-30.0)] * 2 + [0.0] * 3)
    falling = made(two_rods(), 1.0)
    assert errors.joint_gaps(falling).max() < 1e-12
    falling.states[-1, 1:, 2] -= 0.5  # a quarter of the chain
    assert errors.energy_error(falling, 1.0) == pytest.approx(0.25)
    assert errors.joint_gaps(falling)[-1] == pytest.approx([0.5, 0.0])
    falling.states[-1, 1:, 9] = math.sqrt(2.0 * 9.81 * 0.5)  # the same as motion
    assert errors.energy_error(falling, 1.0) < 1e-12
    falling.states[-1, 1:, 11] = 1.0  # 2 x I w^2 / 2 about y
    assert errors.energy_error(falling, 1.0) == pytest.approx(1.0 / 12.0 / (2.0 * 9.81 * 2.0))


def test_overlap_of_balls() -> None:
    balls = made(sphere_grid(2), 0.1)
    assert errors3d.ball_overlap(balls) == 0.0
    balls.states[2, 1, :3], balls.states[2, 2, :3] = (0.0, 0.0, 9.0), (0.0, 0.0, 9.97)
    assert errors3d.ball_overlap(balls) == pytest.approx(0.03)
    balls.states[3, 4, 2] = 0.45
    assert errors3d.ball_overlap(balls) == pytest.approx(0.05)


# ----------------------------------------------------------------- what is run


def test_precession_by_the_mean_speed() -> None:
    still = made(gyroscope(), 5.0)
    arm = 0.1 * np.stack([np.cos(still.times), np.sin(still.times), 0.0 * still.times], -1)  # at 1 rad/s
    still.states[:, 1, :3] = arm
    assert errors3d.precession_error(still, 1.0) == pytest.approx(0.0, abs=1e-12)
    assert errors3d.precession_error(still, 0.8) == pytest.approx(0.25)


def test_cases_and_settings_have_different_names() -> None:
    cases = all_cases()
    assert len({case.key for case in cases}) == len(cases) > 20
    for case in cases:
        for quick in (False, True):
            for settings in (gsenv_settings, mujoco_settings, pybullet_settings, rapier_settings):
                labels = [setting.label for setting in settings(case, quick)]
                assert len(set(labels)) == len(labels)
                assert labels or (case.kind == "top" and settings is pybullet_settings)


def test_principal_axes_are_the_bodies_own() -> None:
    """The error functions and the other engines assume that a body's inertia is diagonal in its own frame."""
    for case in all_cases():
        model = case.scene().compile()
        dynamic = model.bodies["kind"] == 2
        assert (model.nominal_bodies["axes"][dynamic] == [1.0, 0.0, 0.0, 0.0]).all(), case.key
