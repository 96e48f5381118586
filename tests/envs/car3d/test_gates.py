"""GCar3D's gates, judged from poses and touches alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.envs.car3d import course, road, rules, scene
from gsenv.envs.car3d.env import Car3DEnv, Car3DVectorEnv
from gsenv.envs.car3d.policy import HABITS, pursue
from gsenv.envs.core.task import Task
from tests.envs.car3d.level_road import CAR, drive_for, level_env, move_car


class Umpire:
    """Counts gates and their cost of one world from poses and touches alone."""

    def __init__(self, task: Task, world: int) -> None:
        self.task, self.world = task, world
        state = task.task_state[world]
        slots = np.flatnonzero(state["kinds"] >= 0)
        self.gates = [course.gate_place(state, int(slot)) for slot in slots]
        self.down, self.flies = [False, False], False
        self.passed, self.missed, self.cost, self.place = 0, 0, 0.0, float(state["place"])
        self.misses_of = [0, 0]  # by the rear and by the front axle

    def watch(self) -> None:
        """Judge the last step."""
        state = self.task.task_state[self.world]
        forwards = max(float(state["place"]) - self.place, 0.0)
        self.place = float(state["place"])
        if self.passed + self.missed == len(self.gates) and not self.flies:
            return
        gate = self.gates[self.passed + self.missed - self.flies]
        x, y = np.swapaxes(self.task.world.state.bodies["position"][self.world, :, :2], 0, 1)
        heading = road.path_at(state["path"], self.place, road.HEADING)
        for axle in (0, 1):
            wheels = scene.FIRST_WHEEL + 2 * axle + np.arange(2)
            off = x[wheels].mean() - x[scene.CHASSIS_BODY], y[wheels].mean() - y[scene.CHASSIS_BODY]
            beyond = self.place + off[0] * math.cos(heading) + off[1] * math.sin(heading) - gate
            if beyond > scene.GATE_HALF and not self.down[axle] and not self.flies:
                self.flies = True
                self.missed += 1
                self.misses_of[axle] += 1
                self.cost += rules.MISS_REWARD
            inside = abs(beyond) <= scene.GATE_HALF and abs(state["aside"]) <= scene.GATE_WIDTH
            if state["touch"][2 * axle : 2 * axle + 2].any() and (inside or beyond > scene.GATE_HALF):
                self.down[axle] = True
        if all(self.down):
            self.passed += not self.flies
            self.down, self.flies = [False, False], False
        elif self.flies:
            self.cost += rules.JUMP_WEIGHT * forwards


def ride_over_ramps(speed: float) -> tuple[list[Umpire], list[float], int]:
    """Drive at `speed` in m/s over ramps; return the umpires, the cost of gates by the task, and successes."""
    vector = Car3DVectorEnv(24, autoreset_mode="Disabled", split="test")
    vector.reset(seed=0)
    task = vector.task
    umpires = [Umpire(task, w) for w in range(24)]
    alive, cost, successes = np.ones(24, bool), np.zeros(24), 0
    for _ in range(700):
        task.step(pursue(task.observation, HABITS._replace(ramp=speed)))
        for w in np.flatnonzero(alive):
            umpires[w].watch()
            cost[w] += task.terms["gates"][w]
            info = task.infos[w]
            assert (info["gates"], info["missed_gates"]) == (umpires[w].passed, umpires[w].missed)
            if task.terminated[w]:
                finished = not info["rolled_over"] and not info["strayed"]
                assert task.terms["finish"][w] == finished * rules.FINISH_REWARD
                assert info["success"] == (finished and umpires[w].missed == 0 and info["off_road_time"] == 0.0)
                successes += int(info["success"])
                enabled = task.world.parameters.bodies["enabled"][w]
                assert enabled[scene.FIRST_GREEN : scene.FIRST_GREEN + scene.SLOTS].sum() == umpires[w].passed
        alive &= ~task.terminated
    for w in np.flatnonzero(alive):  # the script cannot drive backwards, out of a hill beside the road
        assert task.infos[w]["off_road_time"] > 0.0
    return umpires, cost.tolist(), successes


def test_missed_gates_cost_more_the_farther_the_jump_and_prevent_success() -> None:
    """At 7 m/s ramps throw the car 1 to 4 m."""
    means, won = [], []
    for speed in (5.0, 7.0, 9.0):
        umpires, cost, successes = ride_over_ramps(speed)
        np.testing.assert_allclose(cost, [umpire.cost for umpire in umpires], atol=1e-9)
        means.append(-np.mean(cost))
        won.append(successes)
    assert means[0] < 0.5
    assert means[0] + 1.0 < means[1] < means[2] - 0.5
    assert won[0] > 20 > 10 > won[1] >= won[2]


def gate_on_a_level_road(behind: float) -> tuple[Car3DEnv, Any, float]:
    """Return the car at rest on a level road in front of a gate without an obstacle, its task state and the gate."""
    env = level_env()
    state = env.task.task_state
    state["kinds"][0, 0], state["places"][0, 0], state["slot"][0] = scene.RAMPS, scene.FIRST_SLOT, 0
    gate = course.gate_place(state[0], 0)
    move_car(env, 0, gate + behind)
    drive_for(env, 20, (0.0, 0.0))
    return env, state, gate


def drive_until(env: Car3DEnv, place: float, throttle: float = 0.3) -> tuple[float, dict[str, Any]]:
    """Return the sum of the rewards for gates, and the last info."""
    total, info = 0.0, dict[str, Any]()
    while env.task.task_state["place"][0] < place:
        _, _, terminated, _, info = env.step(np.array([throttle, 0.0], np.float32))
        total += info["reward_gates"]
        assert not terminated or place >= scene.FINISH
    return total, info


def test_a_gate_that_is_passed_on_its_side_is_missed() -> None:
    """The finish is paid then, but is no success."""
    env, _, gate = gate_on_a_level_road(-5.0)
    move_car(env, 1, scene.GATE_WIDTH + 0.05)
    total, info = drive_until(env, gate + 2.0)
    assert (info["missed_gates"], info["gates"]) == (1, 0)
    driven = 2.0 * scene.AXLES  # m, until the rear axle is there
    assert total == pytest.approx(rules.MISS_REWARD + rules.JUMP_WEIGHT * driven, abs=0.3)
    assert "1 gate missed" in env.task.captions(0)
    move_car(env, 1, -scene.GATE_WIDTH)
    _, info = drive_until(env, scene.FINISH)
    assert info["reward_finish"] == rules.FINISH_REWARD
    assert not info["success"]


def test_a_car_whose_rear_axle_flies_past_a_gate_has_missed_it() -> None:
    env, state, gate = gate_on_a_level_road(-3.0)
    drive_until(env, gate - scene.AXLES)  # the front axle is at the gate
    assert state["down"][0].tolist() == [0, 1]
    move_car(env, 2, 1.0)
    env.task.world.state.bodies["velocity"][0, CAR, 0] = 8.0  # m/s
    umpire = Umpire(env.task, 0)
    umpire.down = [False, True]
    total = 0.0
    while state["slot"][0] == 0:
        total += env.step(np.array([0.0, 0.0], np.float32))[4]["reward_gates"]
        umpire.watch()
    assert umpire.misses_of == [1, 0]
    assert total == pytest.approx(umpire.cost)
    assert total < rules.MISS_REWARD + rules.JUMP_WEIGHT


def test_a_miss_costs_nothing_on_the_way_back_and_ends_with_the_episode() -> None:
    env, state, gate = gate_on_a_level_road(-3.0)
    drive_until(env, gate - scene.AXLES - scene.GATE_HALF - 0.3)
    move_car(env, 2, 0.8)
    move_car(env, 0, 1.0)
    _, _, _, _, info = env.step(np.zeros(2, np.float32))
    assert state["jumping"][0] == 1
    env.task.world.state.bodies["velocity"][0, :, 0] = -6.0
    _, _, _, _, info = env.step(np.zeros(2, np.float32))
    assert info["reward_progress"] < 0.0
    assert info["reward_gates"] == 0.0
    _, info = env.reset(seed=1)
    assert info["missed_gates"] == 0
    assert state["jumping"][0] == state["missed"][0] == state["down"][0].max() == 0
