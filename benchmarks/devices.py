"""Where PPO's time goes on a CPU and on a GPU, and what more threads of worlds bring.

Stable-Baselines3's PPO learns from the state and from pixels; each rollout is split into the time in which the worlds
step and the network acts, and the time in which it learns. Nothing here judges what is learned.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run, Unable
from benchmarks.common.stamp import version_of
from benchmarks.common.tables import Table
from benchmarks.throughput import vector
from gsenv.envs import ENVS

ROLLOUTS, QUICK_ROLLOUTS = 5, 1  # measured, after the first, in which libraries start and kernels compile
SECONDS, QUICK_SECONDS = 2.0, 0.2  # of stepping alone
WORLDS = 1024  # of stepping alone
LIBRARIES = ("gymnasium", "stable-baselines3", "torch")


@dataclass(frozen=True)
class Learner:
    """What PPO observes and how it learns: sizes of a rollout and of the network's steps."""

    observation: str  # of gsenv's environments: state or pixels
    policy: str  # of Stable-Baselines3
    network: str
    worlds: int
    steps: int  # of each world in a rollout
    batch: int
    epochs: int

    def __str__(self) -> str:
        return f"{self.observation}, {self.network}"


LEARNERS = (
    Learner("state", "MlpPolicy", "two layers of 64", 256, 32, 1024, 5),
    Learner("pixels", "CnnPolicy", "NatureCNN, 84 x 84", 64, 32, 512, 3),
)


@dataclass(frozen=True)
class Place:
    """Where the network runs: a device of torch, and the number of torch's threads on the CPU."""

    device: str
    threads: int

    def __str__(self) -> str:
        return "GPU" if self.device == "cuda" else f"CPU, {self.threads} thread{'s' if self.threads > 1 else ''}"


@dataclass(frozen=True)
class Learned:
    """Median seconds of a rollout's two halves; ``steps`` of all worlds in it; ``reason``: why there are none."""

    env: str
    learner: str
    place: str
    steps: int
    acting: float
    learning: float
    reason: str

    @property
    def rate(self) -> float:
        """Steps of all worlds per second of wall time."""
        return self.steps / (self.acting + self.learning)


@dataclass(frozen=True)
class Stepped:
    """Steps per second of wall time of WORLDS worlds that share so many threads."""

    env: str
    threads: int
    rate: float


def learn(env_id: str, learner: Learner, place: Place, rollouts: int) -> Learned:
    """Measure ``rollouts`` rollouts of PPO."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.env_util import make_vec_env

    from gsenv.adapters.sb3 import BatchedVecEnv

    class Clock(BaseCallback):
        """Notes when a rollout begins and when it ends."""

        def __init__(self) -> None:
            super().__init__()
            self.times: list[float] = []

        def _note(self) -> None:
            if place.device == "cuda":
                torch.cuda.synchronize()
            self.times.append(time.perf_counter())

        _on_rollout_start = _on_rollout_end = _on_training_end = _note

        def _on_step(self) -> bool:
            return True

    torch.set_num_threads(place.threads)
    arguments = {"observation": learner.observation, "render_mode": None}
    envs = make_vec_env(f"gsenv:{env_id}", learner.worlds, 0, env_kwargs=arguments, vec_env_cls=BatchedVecEnv)  # type: ignore[arg-type]
    sizes = {"n_steps": learner.steps, "batch_size": learner.batch, "n_epochs": learner.epochs}
    clock = Clock()
    model = PPO(learner.policy, envs, learning_rate=1e-3, seed=0, device=place.device, **sizes)  # type: ignore[arg-type]
    model.learn((rollouts + 1) * learner.worlds * learner.steps, callback=clock)
    envs.close()
    times = clock.times[2:]  # the first rollout is left out
    acting = [end - begin for begin, end in zip(times[:-1:2], times[1::2], strict=True)]
    learning = [end - begin for begin, end in zip(times[1::2], times[2::2], strict=True)]
    return named(env_id, learner, place, statistics.median(acting), statistics.median(learning))


def named(env_id: str, learner: Learner, place: Place, acting: float, learning: float, reason: str = "") -> Learned:
    return Learned(env_id, str(learner), str(place), learner.worlds * learner.steps, acting, learning, reason)


def step(env_id: str, threads: int, seconds: float) -> Stepped:
    """Step WORLDS worlds for so many seconds."""
    take = vector(env_id, WORLDS, threads=threads)
    take(0)
    calls, began = 0, time.perf_counter()
    while time.perf_counter() - began < seconds:
        take(calls)
        calls += 1
    return Stepped(env_id, threads, WORLDS * calls / (time.perf_counter() - began))


def places() -> list[Place]:
    """Return where a network can run here: the CPU with one and with all threads, and the GPU.

    Raises:
        Unable: torch is not installed.
    """
    try:
        import torch
    except ImportError:
        raise Unable("this needs torch and stable-baselines3; pip install 'gsenv[train]' brings them.") from None
    cores = len(os.sched_getaffinity(0))
    found = [Place("cpu", threads) for threads in sorted({1, cores})]
    return [*found, Place("cuda", 1)] if torch.cuda.is_available() else found


def thread_counts() -> list[int]:
    """Return 1, 2, 4, ... up to the number of cores."""
    cores = len(os.sched_getaffinity(0))
    return [count for k in range(cores.bit_length()) if (count := 2**k) <= cores]


def add_options(parser: argparse.ArgumentParser) -> None:
    known = [entry.id for entry in ENVS]
    parser.add_argument("--env", nargs="+", choices=known, default=["GStack-v0", "GCar-v0"], metavar="ID")


def measure(run: Run) -> dict[str, Any]:
    rollouts, seconds = (QUICK_ROLLOUTS, QUICK_SECONDS) if run.quick else (ROLLOUTS, SECONDS)
    jobs = [(env_id, one, place) for env_id in run.options.env for one in LEARNERS for place in places()]
    learned = []
    for env_id, learner, place in track(jobs, "learning", len(jobs)):
        try:
            learned.append(learn(env_id, learner, place, rollouts))
        except Exception as error:  # a broken driver: the other places are measured
            reason = f"{type(error).__name__}: {error}".splitlines()[0]
            learned.append(named(env_id, learner, place, 0.0, 0.0, reason))
    counts = [(env_id, threads) for env_id in run.options.env for threads in thread_counts()]
    stepped = [step(env_id, threads, seconds) for env_id, threads in track(counts, "stepping", len(counts))]
    run.stamp["versions"].update({name: version_of(name) for name in LIBRARIES})
    machine = {"gpu": gpu(), "system": platform.machine(), "cores": len(os.sched_getaffinity(0))}
    how = {"rollouts": rollouts, "learners": packed(LEARNERS)}
    return machine | how | {"learned": packed(learned), "stepped": packed(stepped)}


def gpu() -> str:
    """Return the name of the GPU that torch uses, or an empty text."""
    import torch

    return torch.cuda.get_device_name(0) if torch.cuda.is_available() else ""


def report(results: Mapping[str, Any]) -> Report:
    learned, stepped = unpacked(Learned, results["learned"]), unpacked(Stepped, results["stepped"])
    parts: list[Part] = [
        f"Wall time. {machine_text(results)} The worlds always step on the CPU, in one thread. Acting: the worlds step "
        f"and the network chooses their actions; learning: PPO's passes over the rollout. {rollouts_text(results)}",
        learned_table(learned),
        f"{WORLDS} worlds that step with random actions, without a network:",
        stepped_table(stepped),
        *(f"{one.env}, {one.learner}, {one.place}: {one.reason}" for one in learned if one.reason),
    ]
    return Report("Learning on a CPU and on a GPU", parts)


def machine_text(results: Mapping[str, Any]) -> str:
    """Return sentences on the machine; older results lack the number of cores."""
    cores = f"Cores: {results['cores']}. " if "cores" in results else ""
    return f"{cores}GPU: {results['gpu'] or 'none'}. The load average after the run counts its own threads, too."


def rollouts_text(results: Mapping[str, Any]) -> str:
    """Return sentences on what is measured; older results lack the sizes, which were the present ones."""
    learners = unpacked(Learner, results["learners"]) if "learners" in results else LEARNERS
    rollouts = results.get("rollouts", ROLLOUTS)
    of = f"the median of {rollouts} rollouts" if rollouts > 1 else "of one rollout"
    sizes = "; ".join(
        f"from the {one.observation}, {one.worlds} worlds take {one.steps} steps each, and PPO learns from"
        f" them in batches of {one.batch} for {one.epochs} epochs"
        for one in learners
    ).replace("from the pixels", "from pixels")
    return f"Each time is {of} after a first that does not count. In a rollout {sizes}."


def learned_table(learned: Sequence[Learned]) -> Table:
    rows = []
    for one in learned:
        cells = ["-"] * 3
        if not one.reason:
            per = 1e5 / one.steps
            cells = [f"{per * one.acting:.2f}", f"{per * one.learning:.2f}", f"{one.rate:,.0f}"]
        rows.append([one.env, one.learner, one.place, *cells])
    times = ["acting, s / 100,000 steps", "learning, s / 100,000 steps"]
    return Table(["environment", "observation, network", "network on", *times, "steps/s"], rows, 3)


def stepped_table(stepped: Sequence[Stepped]) -> Table:
    first = {one.env: one.rate for one in reversed(stepped)}
    rows = [[one.env, str(one.threads), f"{one.rate:,.0f}", f"{one.rate / first[one.env]:.1f}"] for one in stepped]
    return Table(["environment", "threads", "steps/s", "of one thread's"], rows)
