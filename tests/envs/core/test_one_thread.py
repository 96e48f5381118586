"""An environment that two threads use at once raises an error instead of mixing their episodes."""

from __future__ import annotations

import threading
from typing import Any

import gymnasium
import numpy as np
import pytest

from gsenv.envs.tower.env import TowerVectorEnv


def single() -> Any:
    return gymnasium.make("gsenv:GStack-v0").unwrapped


def vector() -> Any:
    return gymnasium.make_vec("gsenv:GStack-v0", num_envs=3)


@pytest.mark.parametrize("make", [single, vector, lambda: TowerVectorEnv(2)], ids=["single", "vector", "agents"])
def test_a_second_thread_is_refused(make: Any) -> None:
    env, same = make(), make()
    actions = np.zeros_like(env.action_space.sample())
    for one in (env, same):
        one.reset(seed=3)
    taken, refused = [0, 0], [0, 0]
    barrier = threading.Barrier(2)

    def run(k: int) -> None:
        barrier.wait()
        while (taken[k] < 60 or not sum(refused)) and taken[k] < 20_000 and refused[k] < 200_000:
            try:
                env.step(actions)
                taken[k] += 1
            except RuntimeError as error:
                refused[k] += "step: another thread is using this environment" in str(error)

    threads = [threading.Thread(target=run, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(refused) > 0
    for _ in range(sum(taken)):
        same.step(actions)
    observed, expected = (one.task.observation for one in (env, same))
    assert observed.tobytes() == expected.tobytes()
