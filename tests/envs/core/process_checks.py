"""Run as a program by test_processes: steps in this process, then environments in child processes.

    python -m tests.envs.core.process_checks gymnasium|sb3|pool METHOD

A program of its own, as spawned children import the main module, and pytest's process has threads
of other libraries that a fork would not survive.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import warnings
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

from tests.envs.registered import IDS, TASK_IDS, digest, make, make_vector, play, random_actions

STEPS = 12
LIMIT = 8
CHILDREN = {"fork": 2, "spawn": 1, "forkserver": 1}  # those that start afresh take seconds,
FRESH = ("GStack-v0", "GRagdoll-v0")  # and are few: the pool's child makes all environments


def check_gymnasium(env_id: str, method: str) -> None:
    count = CHILDREN[method]
    native = native_log(env_id, count)
    makers = [partial(make, env_id, max_episode_steps=LIMIT)] * count
    envs = gymnasium.vector.AsyncVectorEnv(makers, context=method, autoreset_mode=AutoresetMode.SAME_STEP)
    try:
        log = [envs.reset(seed=5)[0].copy()]
        for actions in random_actions(env_id, 1, STEPS, count):
            result = envs.step(actions)
            log.append([array.copy() for array in result[:4]])
    finally:
        envs.close()
    assert digest(log) == digest(native)


def check_sb3(env_id: str, method: str) -> None:
    from stable_baselines3.common.vec_env import SubprocVecEnv

    count = CHILDREN[method]
    native = native_log(env_id, count)
    makers: Any = [partial(make, env_id, max_episode_steps=LIMIT)] * count
    envs = SubprocVecEnv(makers, start_method=method)
    try:
        envs.seed(5)
        np.testing.assert_array_equal(envs.reset(), native[0])
        for actions, expected in zip(random_actions(env_id, 1, STEPS, count), native[1:], strict=True):
            observations, rewards, dones, _ = envs.step(actions)
            np.testing.assert_array_equal(observations, expected[0])
            np.testing.assert_array_equal(rewards, expected[1])
            np.testing.assert_array_equal(dones, expected[2] | expected[3])
    finally:
        envs.close()


def check_pool(method: str) -> None:
    """Worlds on two threads, in children of a parent that has such threads, and in the parent again."""
    batches = []
    for env_id in IDS:
        envs = make_vector(env_id, 4, threads=2)
        envs.reset(seed=5)
        play(envs, random_actions(env_id, 2, 5, 4))
        batches.append((env_id, envs))
    context: Any = multiprocessing.get_context(method)
    queue = context.Queue()
    children = [context.Process(target=_report, args=(queue, batches)) for _ in range(CHILDREN[method])]
    for child in children:
        child.start()
    digests = [queue.get(timeout=240) for _ in children]
    for child in children:
        child.join(60)
        assert child.exitcode == 0, child.exitcode
    assert digests == [_carry_on(batches)] * len(children)
    if method == "fork":
        _check_grandchild(batches)


def _carry_on(batches: list[Any]) -> str:
    return digest([play(envs, random_actions(env_id, 1, STEPS, 4)) for env_id, envs in batches])


def _report(queue: Any, batches: list[Any]) -> None:
    queue.put(_carry_on(batches))


def _check_grandchild(batches: list[Any]) -> None:
    """A bare fork, twice: each process gets a pool of its own."""
    child = os.fork()
    if child == 0:
        _carry_on(batches)
        grandchild = os.fork()
        _carry_on(batches)
        os._exit(0 if grandchild == 0 else os.waitstatus_to_exitcode(os.waitpid(grandchild, 0)[1]))
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def native_log(env_id: str, count: int) -> list[Any]:
    """What the native vector environment says; the thread that it starts stays."""
    mode = AutoresetMode.SAME_STEP
    envs = make_vector(env_id, 2, autoreset_mode=mode, max_episode_steps=LIMIT, threads=2)
    actions = random_actions(env_id, 1, STEPS, count)
    both = np.concatenate([actions, actions], axis=1)[:, :2]
    log: list[Any] = [envs.reset(seed=5)[0][:count]]
    return log + [[array[:count] for array in envs.step(a)[:4]] for a in both]


def main() -> None:
    check, method = sys.argv[1:]
    warnings.filterwarnings("ignore", category=DeprecationWarning)  # Python 3.12: forks of threaded processes
    if check == "pool":
        check_pool(method)
    else:
        for env_id in TASK_IDS if method == "fork" else FRESH:
            {"gymnasium": check_gymnasium, "sb3": check_sb3}[check](env_id, method)
    print("same")


if __name__ == "__main__":
    main()
