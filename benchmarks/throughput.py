"""Environment steps per second: single, vectorised and behind SB3's interface, beside Box2D's and EnvPool's.

    python -m benchmarks.throughput [--quick] [--env GStack-v0 ...] [--output FOLDER]

Random actions drawn beforehand, resets included, kernels compiled before. All cases take turns in each round, on the
same cores; figures are medians over the rounds. Writes throughput.md and .json to docs/; with --quick only where
--output says.
"""

from __future__ import annotations

import argparse
import gc
import importlib.metadata
import json
import os
import platform
import statistics
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from rich.console import Console
from rich.markdown import Markdown
from rich.progress import track

import gsenv
from gsenv.envs import ENVS

ROUNDS, SECONDS = 7, 0.5  # of each case
QUICK_ROUNDS, QUICK_SECONDS = 2, 0.1
SIZES, QUICK_SIZES = (16, 64, 1024), (16, 64)
THREADS = (1, 2)
PEERS = ("BipedalWalker-v3", "LunarLander-v3")
PEER_SIZES = (16, 64)  # of environments that are stepped one by one
SINGLE_TARGET, BATCHED_TARGET = 20_000, 40_000  # steps/s; the second per core
WARM_STEPS = 400  # of environments, before anything is measured: compilation, caches, growing buffers


@dataclass
class Case:
    """One way to step one environment, and what came out."""

    env: str
    how: str
    worlds: int
    threads: int
    build: Callable[[], Callable[[int], None]] = field(repr=False)
    reason: str = ""  # why there are no figures
    step: Callable[[int], None] | None = field(default=None, repr=False)
    calls: int = 0  # in each round
    wall: list[float] = field(default_factory=list)  # env steps per second, one for each round
    cpu: list[float] = field(default_factory=list)  # env steps per CPU second of all threads

    def figures(self) -> dict[str, Any]:
        return {key: value for key, value in asdict(self).items() if key not in ("build", "step")}


# ---------------------------------------------------------------- ways to step


def sampled(space: gym.Space[Any], count: int) -> list[Any]:
    space.seed(0)
    return [space.sample() for _ in range(count)]


def single(env_id: str) -> Callable[[int], None]:
    env = gym.make(env_id)
    env.reset(seed=0)
    actions = sampled(env.action_space, 512)

    def step(k: int) -> None:
        _, _, terminated, truncated, _ = env.step(actions[k % 512])
        if terminated or truncated:
            env.reset()

    return step


def vector(env_id: str, worlds: int, **arguments: Any) -> Callable[[int], None]:
    envs = gym.make_vec(env_id, num_envs=worlds, **arguments)
    envs.reset(seed=0)
    actions = sampled(envs.action_space, 32)
    return lambda k: void(envs.step(actions[k % 32]))


def stable_baselines(env_id: str, worlds: int, **arguments: Any) -> Callable[[int], None]:
    """BatchedVecEnv for our own environments, DummyVecEnv for others."""
    from stable_baselines3.common.env_util import make_vec_env

    vec_env_class: Any = None
    if env_id in [entry.id for entry in ENVS]:
        from gsenv.adapters.sb3 import BatchedVecEnv as vec_env_class
    envs = make_vec_env(env_id, worlds, seed=0, vec_env_cls=vec_env_class, vec_env_kwargs=arguments)
    envs.reset()
    actions = [np.array(sampled(envs.action_space, worlds)) for _ in range(32)]
    return lambda k: void(envs.step(actions[k % 32]))


def envpool(env_id: str, worlds: int, threads: int) -> Callable[[int], None]:
    import envpool as library

    envs = library.make_gymnasium(env_id, num_envs=worlds, num_threads=threads, seed=0)
    envs.reset()
    actions = [np.array(sampled(envs.action_space, worlds)) for _ in range(32)]
    return lambda k: void(envs.step(actions[k % 32]))


def void(_: Any) -> None:
    """Results are dropped, as a learner that copies them would."""


def cases(env_ids: Sequence[str], sizes: Sequence[int]) -> list[Case]:
    made = []
    for e in env_ids:
        made.append(Case(e, "gym.make", 1, 1, lambda e=e: single(e)))  # type: ignore[misc]
        for n in sizes:
            for t in THREADS:
                made.append(Case(e, "native vector", n, t, lambda e=e, n=n, t=t: vector(e, n, threads=t)))  # type: ignore[misc]
        for n in sizes:
            for t in THREADS:
                build = lambda e=e, n=n, t=t: stable_baselines(e, n, threads=t)  # noqa: E731
                made.append(Case(e, "SB3 BatchedVecEnv", n, t, build))
    for e in PEERS:
        made.append(Case(e, "gym.make", 1, 1, lambda e=e: single(e)))  # type: ignore[misc]
        for n in PEER_SIZES:
            made.append(Case(e, "SyncVectorEnv", n, 1, lambda e=e, n=n: vector(e, n, vectorization_mode="sync")))  # type: ignore[misc]
            made.append(Case(e, "SB3 DummyVecEnv", n, 1, lambda e=e, n=n: stable_baselines(e, n)))  # type: ignore[misc]
        for n in sizes:
            for t in THREADS:
                made.append(Case(e, "EnvPool", n, t, lambda e=e, n=n, t=t: envpool(e, n, t)))  # type: ignore[misc]
    return made


# ---------------------------------------------------------------- measuring


def pin(cores: Sequence[int], threads: int) -> None:
    """The calling thread, and those that it starts, to the first cores."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, cores[:threads])


def prepare(case: Case, cores: Sequence[int], seconds: float) -> None:
    """Build, compile, and find how many calls fill a round."""
    if case.threads > len(cores):
        case.reason = f"only {len(cores)} core to use"
        return
    pin(cores, case.threads)
    try:
        case.step = case.build()
    except Exception as error:
        case.reason = f"{type(error).__name__}: {error}".splitlines()[0]
        return
    for k in range(max(2, WARM_STEPS // case.worlds)):
        case.step(k)
    began, calls = time.perf_counter(), 0
    while calls < 2 or time.perf_counter() - began < seconds / 4:
        case.step(calls)
        calls += 1
    case.calls = max(2, round(calls * seconds / (time.perf_counter() - began)))


def measure(case: Case, cores: Sequence[int]) -> None:
    assert case.step is not None
    pin(cores, case.threads)
    step = case.step
    wall, cpu = time.perf_counter(), time.process_time()
    for k in range(case.calls):
        step(k)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    case.wall.append(case.worlds * case.calls / wall)
    case.cpu.append(case.worlds * case.calls / cpu)


def run(chosen: list[Case], rounds: int, seconds: float, cores: Sequence[int], console: Console) -> None:
    for case in track(chosen, "building", console=console):
        prepare(case, cores, seconds)
    ready = [case for case in chosen if case.step is not None]
    gc.collect()
    gc.freeze()  # what the other cases keep alive is not searched again and again
    for case in track(ready * rounds, "measuring", console=console):
        measure(case, cores)


# ---------------------------------------------------------------- report


def header(cores: Sequence[int], rounds: int, loads: tuple[float, float]) -> dict[str, Any]:
    names = ("gymnasium", "numba", "numpy", "stable-baselines3", "Box2D", "envpool")
    versions = {"gsenv": gsenv.__version__, "python": platform.python_version()}
    for name in names:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = "-"
    return {
        "machine": processor(), "cores": list(cores), "rounds": rounds, "versions": versions,
        "load_before": loads[0], "load_after": loads[1],
    }  # fmt: skip


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.partition(": ")[2] for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def table(chosen: list[Case]) -> str:
    lines = [
        "| environment | how | worlds | threads | steps/s | lowest | highest | steps/CPU s |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for case in chosen:
        start = f"| {case.env} | {case.how} | {case.worlds} | {case.threads} | "
        if case.wall:
            values = (statistics.median(case.wall), min(case.wall), max(case.wall), statistics.median(case.cpu))
            lines.append(start + " | ".join(f"{value:,.0f}" for value in values) + " |")
        else:
            lines.append(f"{start}- | - | - | - |")
    return "\n".join(lines)


def targets(chosen: list[Case]) -> str:
    lines = [
        "| environment | gym.make | target | best native vector on one core | target |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    for env_id in dict.fromkeys(case.env for case in chosen if case.how == "native vector"):
        own = [case for case in chosen if case.env == env_id and case.wall and case.threads == 1]
        one = [statistics.median(case.wall) for case in own if case.how == "gym.make"]
        batch = [statistics.median(case.wall) for case in own if case.how == "native vector"]
        values = [max(one), SINGLE_TARGET, max(batch), BATCHED_TARGET]
        lines.append(f"| {env_id} | " + " | ".join(f"{value:,.0f}" for value in values) + " |")
    return "\n".join(lines)


def report(chosen: list[Case], facts: dict[str, Any]) -> str:
    missing = dict.fromkeys(f"{case.how} of {case.env}: {case.reason}" for case in chosen if case.reason)
    load = facts["load_before"]
    parts = [
        "# Environment steps per second",
        f"`python -m benchmarks.throughput` on cores {facts['cores']} of {facts['machine']}: random actions, resets "
        f"included, kernels compiled before; median of {facts['rounds']} rounds in which all cases take turns. "
        f"Load before: {load:.1f}, after: {facts['load_after']:.1f}. "
        + ", ".join(f"{name} {version}" for name, version in facts["versions"].items()) + ".",
        table(chosen),
        "\"steps/CPU s\" counts the time of all threads. Tasks differ: a step of ours is 1/30 s with an exact solver, "
        "one of Box2D's environments 1/50 s; so the rows compare what a learner waits for, not solvers.",
        "## Targets",
        targets(chosen),
    ]  # fmt: skip
    if load > 0.5:
        parts.insert(2, "**Other processes were running: wall figures are too low.**")
    if missing:
        parts += ["## Not measured", "\n".join(f"- {line}" for line in missing)]
    return "\n\n".join(parts) + "\n"


def write(path: Path, text: str) -> None:
    """The whole file or none of it."""
    draft = path.with_name(path.name + ".tmp")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small batches, two short rounds")
    parser.add_argument("--env", nargs="+", choices=[e.id for e in ENVS], default=["GStack-v0", "GCar-v0"])
    parser.add_argument("--output", type=Path)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    gym.logger.min_level = gym.logger.ERROR
    console = Console()
    cores = sorted(os.sched_getaffinity(0))[: max(THREADS)] if hasattr(os, "sched_getaffinity") else [0, 1]
    rounds, seconds = (QUICK_ROUNDS, QUICK_SECONDS) if arguments.quick else (ROUNDS, SECONDS)
    chosen = cases(arguments.env, QUICK_SIZES if arguments.quick else SIZES)
    load = os.getloadavg()[0]
    run(chosen, rounds, seconds, cores, console)
    facts = header(cores, rounds, (load, os.getloadavg()[0]))
    text = report(chosen, facts)
    console.print(Markdown(text))
    folder = arguments.output or (None if arguments.quick else Path(__file__).parents[1] / "docs")
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        write(folder / "throughput.json", json.dumps(facts | {"cases": [c.figures() for c in chosen]}, indent=1) + "\n")
        write(folder / "throughput.md", text)
        console.print(f"wrote {folder}/throughput.md and .json")


if __name__ == "__main__":
    main()
