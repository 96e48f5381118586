"""Environment steps per second: single, vectorised and behind SB3's interface, beside Box2D's and EnvPool's.

Random actions drawn beforehand, resets included, kernels compiled before. All cases take turns in each round, on the
same cores; figures are medians over the rounds.
"""

from __future__ import annotations

import argparse
import gc
import statistics
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run
from benchmarks.common.stamp import version_of
from benchmarks.common.tables import Table
from benchmarks.common.timing import pin, usable_cores
from gsenv.envs import ENVS

ROUNDS, SECONDS = 7, 0.5  # of each case
QUICK_ROUNDS, QUICK_SECONDS = 2, 0.1
SIZES, QUICK_SIZES = (16, 64, 1024), (16, 64)
THREADS = (1, 2)
TASK_SIZE = 256  # worlds of the other tasks, as in training
TASKS = ("GStack3D-v0", "GCar3D-v0", "GRagdoll2D-v0", "GRagdoll2D-get-up-v0", "GRagdoll-v0", "GRagdoll-get-up-v0")
AGENTS = "tower_v0"
OWN = {entry.id for entry in ENVS}
PEERS = ("BipedalWalker-v3", "LunarLander-v3")
PEER_SIZES = (16, 64)  # of environments that are stepped one by one
SINGLE_TARGET, BATCHED_TARGET = 20_000, 40_000  # steps/s; the second per core
WARM_STEPS = 400  # of environments, before anything is measured: compilation, caches, growing buffers
WARM_CALLS = 300  # of batches of the other tasks: an episode of most, so that they are in all parts of theirs
LIBRARIES = ("gymnasium", "stable-baselines3", "Box2D", "envpool")
WORDS = 2  # columns of environment and interface


Step = Callable[[int], object]  # of the number of the call


@dataclass
class Case:
    """One way to step one environment, and what came out.

    Attributes:
        reason: why there are no figures.
        calls: in each round.
        wall: env steps per second, one for each round.
        cpu: env steps per CPU second of all threads.
    """

    env: str
    how: str
    worlds: int
    threads: int
    reason: str = ""
    calls: int = 0
    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)


@dataclass
class Job:
    """A case while it is being measured."""

    case: Case
    build: Callable[[], Step]
    step: Step | None = None


# ---------------------------------------------------------------- ways to step


def sampled(space: gym.Space[Any], count: int) -> list[Any]:
    space.seed(0)
    return [space.sample() for _ in range(count)]


def batches(space: gym.Space[Any], worlds: int) -> Any:
    """Return actions (step, world, ...) of 32 steps, each drawn for itself."""
    return np.array(sampled(space, 32 * worlds)).reshape(32, worlds, *(space.shape or ()))


def single(env_id: str) -> Step:
    env = gym.make(env_id)
    env.reset(seed=0)
    actions = sampled(env.action_space, 512)

    def step(k: int) -> None:
        _, _, terminated, truncated, _ = env.step(actions[k % 512])
        if terminated or truncated:
            env.reset()

    return step


def vector(env_id: str, worlds: int, **arguments: Any) -> Step:
    envs: Any = gym.make_vec(env_id, num_envs=worlds, **arguments)
    envs.reset(seed=0)
    if env_id in OWN:
        envs.unwrapped.stagger(np.random.default_rng(0))  # else all worlds are in the same part of their episodes
    actions = sampled(envs.action_space, 32)
    return lambda k: envs.step(actions[k % 32])


def stable_baselines(env_id: str, worlds: int, **arguments: Any) -> Step:
    """Return a BatchedVecEnv of gsenv's own environments, or a DummyVecEnv of others."""
    from stable_baselines3.common.env_util import make_vec_env

    vec_env_class: Any = None
    if env_id in OWN:
        from gsenv.adapters.sb3 import BatchedVecEnv as vec_env_class
    envs = make_vec_env(env_id, worlds, seed=0, vec_env_cls=vec_env_class, vec_env_kwargs=arguments)
    envs.reset()
    if env_id in OWN:
        envs.env_method("stagger", np.random.default_rng(0))
    actions = batches(envs.action_space, worlds)
    return lambda k: envs.step(actions[k % 32])


def envpool(env_id: str, worlds: int, threads: int) -> Step:
    import envpool as library

    envs = library.make_gymnasium(env_id, num_envs=worlds, num_threads=threads, seed=0)
    envs.reset()
    actions = batches(envs.action_space, worlds)
    return lambda k: envs.step(actions[k % 32])


def own_jobs(env_id: str, sizes: Sequence[int]) -> Iterator[Job]:
    yield Job(Case(env_id, "gym.make", 1, 1), partial(single, env_id))
    for how, build in (("native vector", vector), ("SB3 BatchedVecEnv", stable_baselines)):
        for worlds, threads in product(sizes, THREADS):
            yield Job(Case(env_id, how, worlds, threads), partial(build, env_id, worlds, threads=threads))


def task_jobs(env_id: str) -> Iterator[Job]:
    """Yield how a learner steps a task on one core."""
    yield Job(Case(env_id, "gym.make", 1, 1), partial(single, env_id))
    for how, build in (("native vector", vector), ("SB3 BatchedVecEnv", stable_baselines)):
        yield Job(Case(env_id, how, TASK_SIZE, 1), partial(build, env_id, TASK_SIZE))


def agents(name: str, worlds: int) -> Step:
    """Return an AgentVecEnv, in which each agent of each world is an environment."""
    from gsenv.adapters.sb3_agents import AgentVecEnv

    envs = AgentVecEnv(name, worlds)
    envs.reset()
    envs.env_method("stagger", np.random.default_rng(0))
    actions = batches(envs.action_space, envs.num_envs)
    return lambda k: envs.step(actions[k % 32])


def peer_jobs(env_id: str, sizes: Sequence[int]) -> Iterator[Job]:
    yield Job(Case(env_id, "gym.make", 1, 1), partial(single, env_id))
    for worlds in PEER_SIZES:
        sync = partial(vector, env_id, worlds, vectorization_mode="sync")
        yield Job(Case(env_id, "SyncVectorEnv", worlds, 1), sync)
        yield Job(Case(env_id, "SB3 DummyVecEnv", worlds, 1), partial(stable_baselines, env_id, worlds))
    for worlds, threads in product(sizes, THREADS):
        yield Job(Case(env_id, "EnvPool", worlds, threads), partial(envpool, env_id, worlds, threads))


# ---------------------------------------------------------------- measuring


def prepare(job: Job, cores: Sequence[int], seconds: float) -> None:
    """Build, compile, and find how many calls fill a round."""
    case = job.case
    if case.threads > len(cores):
        case.reason = f"only {len(cores)} core to use"
        return
    pin(*cores[: case.threads])
    try:
        step = job.build()
    except Exception as error:  # a library is missing or broken: the other cases are measured
        case.reason = f"{type(error).__name__}: {error}".splitlines()[0]
        return
    for k in range(WARM_CALLS if case.worlds == TASK_SIZE else max(2, WARM_STEPS // case.worlds)):
        step(k)
    began, calls = time.perf_counter(), 0
    while calls < 2 or time.perf_counter() - began < seconds / 4:
        step(calls)
        calls += 1
    case.calls = max(2, round(calls * seconds / (time.perf_counter() - began)))
    job.step = step


def measure_round(job: Job, cores: Sequence[int]) -> None:
    case, step = job.case, job.step
    if step is None:
        return
    pin(*cores[: case.threads])
    wall, cpu = time.perf_counter(), time.process_time()
    for k in range(case.calls):
        step(k)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    case.wall.append(case.worlds * case.calls / wall)
    case.cpu.append(case.worlds * case.calls / cpu)


def add_options(parser: argparse.ArgumentParser) -> None:
    known = [entry.id for entry in ENVS]
    parser.add_argument("--env", nargs="+", choices=known, default=["GStack-v0", "GCar-v0"], metavar="ID")


def measure(run: Run) -> dict[str, Any]:
    warnings.simplefilter("ignore")
    gym.logger.min_level = gym.logger.ERROR
    cores = usable_cores()[: max(THREADS)]
    rounds, seconds = (QUICK_ROUNDS, QUICK_SECONDS) if run.quick else (ROUNDS, SECONDS)
    sizes = QUICK_SIZES if run.quick else SIZES
    jobs = [job for env_id in run.options.env for job in own_jobs(env_id, sizes)]
    jobs += [job for env_id in TASKS for job in task_jobs(env_id)]
    jobs.append(Job(Case(AGENTS, "SB3 AgentVecEnv", TASK_SIZE, 1), partial(agents, AGENTS, TASK_SIZE)))
    jobs += [job for env_id in PEERS for job in peer_jobs(env_id, sizes)]
    run.stamp["versions"].update({name: version_of(name) for name in LIBRARIES})
    for job in track(jobs, "building", len(jobs)):
        prepare(job, cores, seconds)
    gc.collect()
    gc.freeze()  # what the other cases keep alive is not searched again and again
    for job in track(jobs * rounds, "measuring", len(jobs) * rounds):
        measure_round(job, cores)
    return {"cores": cores, "rounds": rounds, "cases": packed(job.case for job in jobs)}


# ---------------------------------------------------------------- report


def steps_table(chosen: Sequence[Case]) -> Table:
    rows = []
    for case in chosen:
        cells = ["-"] * 4
        if case.wall:
            values = (statistics.median(case.wall), min(case.wall), max(case.wall), statistics.median(case.cpu))
            cells = [f"{value:,.0f}" for value in values]
        rows.append([case.env, case.how, str(case.worlds), str(case.threads), *cells])
    header = ["environment", "how", "worlds", "threads", "steps/s", "lowest", "highest", "steps/CPU s"]
    return Table(header, rows, WORDS)


def targets_table(chosen: Sequence[Case]) -> Table:
    rows = []
    for env_id in dict.fromkeys(case.env for case in chosen if case.how == "native vector"):
        if env_id in TASKS:
            continue  # the targets are those of the two planar tasks
        own = [case for case in chosen if case.env == env_id and case.wall and case.threads == 1]
        one = [statistics.median(case.wall) for case in own if case.how == "gym.make"]
        batch = [statistics.median(case.wall) for case in own if case.how == "native vector"]
        values = [max(one), SINGLE_TARGET, max(batch), BATCHED_TARGET]
        rows.append([env_id, *(f"{value:,.0f}" for value in values)])
    header = ["environment", "gym.make", "target", "best native vector on one core", "target"]
    return Table(header, rows)


def report(results: Mapping[str, Any]) -> Report:
    chosen = unpacked(Case, results["cases"])
    missing = dict.fromkeys(f"{case.how} of {case.env}: {case.reason}" for case in chosen if case.reason)
    parts: list[Part] = [
        f"The environments ran on cores {results['cores']} with random actions and with kernels compiled beforehand. "
        f"The figures include resets, and are medians of {results['rounds']} rounds in which all cases take turns. "
        "Steps of tower_v0 are those of its worlds; each has two agents.",
        steps_table(chosen),
        '"steps/CPU s" counts the time of all threads. The tasks differ: a step of gsenv\'s environments is 1/30 s '
        "long, one of Box2D's environments 1/50 s. The table compares the time that a learner waits, not the solvers.",
        "## Targets",
        targets_table(chosen),
    ]
    if missing:
        parts += ["## Not measured", "\n".join(f"- {line}" for line in missing)]
    return Report("Environment steps per second", parts)
