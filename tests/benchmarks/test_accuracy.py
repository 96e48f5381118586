"""The error functions of the benchmark accuracy, on trajectories made from closed forms, and its stored points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.accuracy import errors, geometry
from benchmarks.accuracy.cases import Case, all_cases
from benchmarks.accuracy.engines import Setting
from benchmarks.accuracy.fronts import Points, best_peer, cheapest, front, time_ratio
from benchmarks.accuracy.page import limit_table
from benchmarks.accuracy.points import Point, Results, measure_point
from benchmarks.accuracy.trajectory import STATE, Trajectory
from gsenv.scenes import (
    bouncing_balls,
    box_on_incline,
    chain,
    cradle,
    double_pendulum,
    pendulum,
    pyramid,
    sliding_disk,
    spring_mass,
    stack,
)
from gsenv.solver import Model, Scene

Array = NDArray[np.float64]
G = 9.81


def made(scene: Scene, seconds: float, rate: float = 60.0) -> Trajectory:
    """All bodies where they start, at all times."""
    model = scene.compile()
    times = np.arange(round(seconds * rate) + 1) / rate
    start = np.concatenate(
        [model.start_bodies["position"], model.start_bodies["angle"][:, None], model.start_bodies["velocity"]], 1
    )
    return Trajectory(times, np.repeat(start[None], len(times), 0), model)


# ----------------------------------------------------------------- geometry


def overlap(second: Sequence[float] | Array, angle: float) -> float:
    """m, of two unit boxes, the first at the origin; -inf where even their circles are apart."""
    position = np.array([(0.0, 0.0), second])
    return float(geometry.box_overlaps(position, np.array([0.0, angle]), np.full((2, 2), 0.5)).max(initial=-np.inf))


def test_overlap_of_boxes_in_closed_form() -> None:
    assert overlap((0.2, 0.9), 0.0) == pytest.approx(0.1)  # face on face
    corner = math.sqrt(0.5)
    assert overlap((0.1, 0.5 + corner - 0.03), math.pi / 4) == pytest.approx(0.03)  # corner into face
    assert overlap((0.0, 1.01), 0.0) == pytest.approx(-0.01)  # a gap
    assert overlap((0.2, 0.0), 0.0) == pytest.approx(0.8)  # the shorter way out


def test_overlap_is_the_shortest_way_out() -> None:
    """Oracle: the boxes part after a shift by the depth in some direction, and in none after a shorter one."""
    rng = np.random.default_rng(0)
    directions = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    tried = 0
    while tried < 10:
        place, angle = rng.uniform(-0.9, 0.9, 2), rng.uniform(-np.pi, np.pi)
        depth = overlap(place, angle)
        if depth < 0.01:
            continue
        tried += 1
        for factor, parts in ((1.001, True), (0.98, False)):
            shifted = place + factor * depth * np.stack([np.cos(directions), np.sin(directions)], -1)
            assert any(overlap(point, angle) < 0.0 for point in shifted) is parts


def test_deepest_overlap_counts_the_ground_and_no_gap() -> None:
    half = np.full((2, 2), 0.5)
    position = np.array([(0.0, 0.48), (0.0, 1.5)])
    assert geometry.deepest_overlap(position, np.zeros(2), half) == pytest.approx(0.02)
    assert geometry.deepest_overlap(position + np.array([0.0, 0.1]), np.zeros(2), half) == 0.0


# ------------------------------------------------------------ standing scenes


def test_exact_tower_has_no_error() -> None:
    assert errors.standing_error(made(stack(10), 1.0, 2.0)) == pytest.approx(0.0, abs=1e-12)


def test_sunk_tower_counts_overlap_and_gaps() -> None:
    sunk = made(stack(3), 1.0, 2.0)
    sunk.states[-1, 2:, 1] -= 0.004  # box 2 into box 1
    assert errors.standing_error(sunk) == pytest.approx(0.004)
    gaps = made(stack(3), 1.0, 2.0)
    gaps.states[-1, 1:, 1] += [0.01, 0.02, 0.03]  # the same gap under each
    assert errors.standing_error(gaps) == pytest.approx(0.01)


def test_overlap_in_passing_counts() -> None:
    tower = made(stack(2), 2.0, 2.0)
    tower.states[1, 2, 1] -= 0.006
    assert errors.standing_error(tower) == pytest.approx(0.006)


def test_layers_of_a_pyramid_are_means() -> None:
    tower = made(pyramid(3), 1.0, 2.0)
    tower.states[-1, 1:4, 1] += [0.003, 0.0, 0.0]
    assert errors.layer_error(tower.states[0, 1:, 1], tower.states[-1, 1:, 1]) == pytest.approx(0.001)


def test_wandering_or_moving_towers_fail() -> None:
    drifted = made(stack(2), 1.0, 2.0)
    drifted.states[-1, 1:, 0] += 0.011
    moving = made(stack(2), 1.0, 2.0)
    moving.states[-1, 2, 3] = 0.011
    for trajectory in (drifted, moving):
        assert errors.standing_error(trajectory) == math.inf
        assert errors.lenient_standing_error(trajectory) == pytest.approx(0.0, abs=1e-12)


# -------------------------------------------------------------- moving scenes


def test_distance_error_is_the_worst_over_time() -> None:
    slid = made(box_on_incline(35.0), 2.0)
    down = np.array([math.cos(math.radians(35.0)), -math.sin(math.radians(35.0))])
    law: Callable[[Array], Array] = lambda t: 0.5 * 1.6 * t**2  # noqa: E731
    wrong = np.where((slid.times > 0.9) & (slid.times < 1.1), 0.02, 0.0)  # right again at the end
    slid.states[:, 1, :2] += np.outer(law(slid.times) + wrong, down)
    assert errors.distance_error(slid, law) == pytest.approx(0.02 / 3.2)
    assert errors.distance_error(slid, lambda t: 0.0 * t) == pytest.approx(3.2)  # m where it should stay


def test_slide_to_roll_law() -> None:
    rolled = made(sliding_disk(3.0, 0.3), 2.0)
    grip = 3.0 / (3.0 * 0.3 * G)
    for k, t in enumerate(rolled.times):  # integrated in fine steps
        fine = np.linspace(0.0, t, 20001)
        speed = np.maximum(3.0 - 0.3 * G * fine, 2.0)
        rolled.states[k, 1, 0] = np.trapezoid(speed, fine)
        rolled.states[k, 1, 3] = speed[-1]
    assert grip < 2.0
    assert errors.slide_to_roll_error(rolled, 3.0, 0.3) < 1e-7
    rolled.states[-1, 1, 3] *= 1.05
    assert errors.slide_to_roll_error(rolled, 3.0, 0.3) == pytest.approx(0.05)


def bounces(restitution: float) -> Trajectory:
    """A ball dropped from 1 m, by parabolas between its impacts."""
    trajectory = made(bouncing_balls([restitution]), 2.2)
    speed = math.sqrt(2.0 * G)
    starts = [speed / G]
    while starts[-1] < 2.2:
        starts.append(starts[-1] + 2.0 * speed * restitution ** len(starts) / G)
    for k, t in enumerate(trajectory.times):
        hop = int(np.searchsorted(starts, t))
        since = t - starts[hop - 1] if hop else t
        rise = speed * restitution**hop if hop else 0.0
        trajectory.states[k, 1, 1] = 0.1 + (0.0 if hop else 1.0) + rise * since - 0.5 * G * since**2
    return trajectory


def test_apexes_of_exact_bounces() -> None:
    assert errors.apex_error(bounces(0.8), 0.8) < 1e-12
    expected = max(abs((0.81 / 0.8) ** (2 * k) - 1.0) for k in (1, 2, 3))
    assert errors.apex_error(bounces(0.81), 0.8) == pytest.approx(expected)
    assert errors.apex_error(made(bouncing_balls([0.8]), 2.2), 0.8) == math.inf  # never bounced


# ------------------------------------------------------------------- linkages


def test_swings_start_where_the_scenes_say() -> None:
    assert errors.swings(made(pendulum(150.0), 0.1))[0] == pytest.approx([math.radians(150.0)])
    assert errors.swings(made(chain(3), 0.1))[0] == pytest.approx([math.radians(30.0)] * 3)
    assert errors.swings(made(cradle(2), 0.1))[0] == pytest.approx([math.radians(-30.0)] * 2 + [0.0] * 3)


def test_period_of_a_sine() -> None:
    swung = made(pendulum(90.0), 10.0)
    swung.states[:, 1, 2] = -0.5 * np.pi + 0.7 * np.sin(2.0 * np.pi * swung.times / 1.93 + 0.4)
    assert errors.period_error(swung, 1.93) < 1e-6
    assert errors.period_error(swung, 1.95) == pytest.approx(0.02 / 1.95, rel=1e-3)
    assert errors.period_error(made(pendulum(90.0), 10.0), 1.93) == math.inf


def test_cradle_judges_angles_and_rest() -> None:
    hit = made(cradle(1), 1.5)
    swing = np.sin(np.pi * (hit.times - 0.5115) / 1.023)
    hit.states[:, 5, 2] = np.radians(30.0) * np.clip(swing, 0.0, None)
    hit.states[:, 1, 2] = np.where(hit.times < 0.5115, hit.states[:, 1, 2], 0.0)
    assert errors.cradle_error(hit, 1) < 1e-4
    hit.states[:, 3, 2] = np.radians(-1.5)  # a ball that should rest
    assert errors.cradle_error(hit, 1) == pytest.approx(0.05)
    hit.states[:, 5, 2] *= 0.8
    assert errors.cradle_error(hit, 1) == pytest.approx(0.2, abs=1e-4)


def test_chain_error_sees_gaps_and_energy() -> None:
    still = made(chain(), 1.0)
    assert errors.chain_error(still, 0.25) < 1e-12
    still.states[-1, 7, 0] += 0.01  # 4 % of a link, no energy
    assert errors.chain_error(still, 0.25) == pytest.approx(0.04)
    falling = made(double_pendulum(), 1.0)
    falling.states[-1, 1:, 1] -= 0.5  # a quarter of the chain
    assert errors.energy_error(falling, 1.0) == pytest.approx(0.25)
    falling.states[-1, 1:, 4] = math.sqrt(2.0 * G * 0.5)  # the same as motion
    assert errors.energy_error(falling, 1.0) < 1e-12
    falling.states[-1, 1:, 5] = 1.0  # 2 x I w^2 / 2
    assert errors.energy_error(falling, 1.0) == pytest.approx(1.0 / 12.0 / (2.0 * G * 2.0))


@pytest.mark.parametrize("damping_ratio", [0.0, 0.2, 1.0])
def test_spring_law_solves_its_equation(damping_ratio: float) -> None:
    """Oracle: fine Runge-Kutta steps of x'' = g - w^2 x - 2 z w x'."""
    w = 4.0 * math.pi
    hung = made(spring_mass(2.0, damping_ratio), 2.5)
    state, h = np.array([0.1, 0.0]), 1.0 / 6000.0  # m below the end of the relaxed spring, and m/s

    def rate(s: Array) -> Array:
        return np.array([s[1], G - w * w * s[0] - 2.0 * damping_ratio * w * s[1]])

    for k in range(1, len(hung.times)):
        for _ in range(100):
            a = rate(state)
            b = rate(state + 0.5 * h * a)
            c = rate(state + 0.5 * h * b)
            state = state + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(state + h * c))
        hung.states[k, 1, 1] = -1.0 - state[0]
    assert errors.spring_error(hung, 2.0, damping_ratio) < 1e-8
    hung.states[1:, 1, 1] -= 0.003
    assert errors.spring_error(hung, 2.0, damping_ratio) == pytest.approx(0.003 / (0.1 - G / w**2), rel=1e-3)


# ------------------------------------------------- measuring, stored points


class Still:
    """An engine in which nothing moves."""

    def __init__(self, model: Model, setting: Setting) -> None:
        self.start = made_states(model)
        self.steps = 0

    def step(self, count: int) -> None:
        self.steps += count

    def read(self) -> Array:
        return self.start


class Exploding(Still):
    """An engine whose bodies get lost."""

    def read(self) -> Array:
        return self.start if self.steps < 100 else np.full_like(self.start, np.nan)


def made_states(model: Model) -> Array:
    out = np.zeros((len(model.bodies), STATE))
    out[:, :2] = model.start_bodies["position"]
    return out


def tower() -> Case:
    return next(case for case in all_cases() if case.key == "tower:10")


def test_measures_error_and_time() -> None:
    setting = Setting("gsenv", "still", 1.0 / 60.0)
    point = measure_point(Still, tower(), setting, "sources", [])
    assert point.error == pytest.approx(0.0, abs=1e-12)
    assert point.us >= point.fastest >= 0.0
    lost = measure_point(Exploding, tower(), setting, "sources", [])
    assert lost.error is None
    assert lost.runs == 1


def test_cases_have_different_names() -> None:
    keys = [case.key for case in all_cases()]
    assert len(set(keys)) == len(keys) > 20


def point(engine: str, label: str, us: float, error: float | None) -> Point:
    return Point("tower:10", engine, label, 1.0 / 60.0, "", error, error, us, us, 3, "a")


def results_at(path: Path, sources: str = "a", fresh: bool = False) -> Results:
    return Results(2, {"versions": {"gsenv": "1"}}, {"gsenv": sources, "Box2D": sources}, path, fresh)


def test_results_resume_and_know_what_is_outdated(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "accuracy.json"
    results = results_at(path)
    results.add(point("gsenv", "one", 100.0, 1e-3))
    results.add(point("Box2D", "two", 200.0, None))
    again = results_at(path)
    assert [replace(p, timestep=1.0 / 60.0) for p in again.points.values()] == list(results.points.values())
    one = Setting("gsenv", "one", 1.0 / 60.0)
    assert again.known(tower(), one)
    assert again.versions == {"gsenv": "1"}
    assert not again.known(tower(), replace(one, label="three"))
    assert not results_at(path, "b").known(tower(), one)
    assert not results_at(path, fresh=True).points
    assert [p.label for p in again.of("tower:10", "Box2D")] == ["two"]


def test_interrupt_while_writing_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "accuracy.json"
    results = results_at(path)
    results.add(point("gsenv", "one", 100.0, 1e-3))

    def broken(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", broken)
    with pytest.raises(KeyboardInterrupt):
        results.add(point("gsenv", "two", 90.0, 1e-3))
    assert [p.label for p in results_at(path).points.values()] == ["one"]


def test_fronts_and_cheapest() -> None:
    points = Points(
        [
            point("gsenv", "a", 100.0, 5e-3), point("gsenv", "b", 300.0, 1e-5), point("gsenv", "c", 200.0, 6e-3),
            point("gsenv", "d", 50.0, None), point("Box2D", "e", 80.0, 9e-3), point("pymunk", "f", 400.0, 9e-4),
        ]
    )  # fmt: skip
    mine = points.of("tower:10", "gsenv")
    assert [p.label for p in front(mine)] == ["a", "b"]
    for limit, own, peer, quotient in ((1e-2, "a", "e", "1.25"), (1e-3, "b", "f", "0.75"), (1e-4, "b", None, "alone")):
        best, other = cheapest(mine, limit), best_peer(points, "tower:10", limit)
        assert best is not None
        assert best.label == own
        assert (other.label if other else None) == peer
        assert time_ratio(best, other) == quotient
    (row,) = limit_table([tower()], points, 1e-2).rows
    assert row == ["tower:10", "tower of 10 (m)", "100", "80", "400", "1.25", "a", "e"]
