"""CPU time of each stage of a step, of heaps that settle and that rest, by sampling with Linux's ``perf``.

Samples are taken of the kernel as it always runs: no code is added to it. A sample belongs to the stage of the function
that it hits; a small function that the compiler has put into its callers belongs to theirs.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time
from benchmarks.heaps import HEAPS, REST, STEPS, TIMESTEP
from benchmarks.stages.sampling import Symbols, sampled
from gsenv.solver import Options, Scene, World
from gsenv.solver.records.model import BodyKind

AWAKE = Options(timestep=TIMESTEP, sleep=False)
SECONDS, QUICK_SECONDS = 5.0, 0.5  # of CPU time in which a phase is sampled
OTHER = "the rest"
STAGES: dict[str, tuple[str, ...]] = {  # by modules, or functions of modules; the first that fits
    "collision": ("broadphase", "narrowphase", "detection", "recycling", "geometry", "secondary"),
    "matching with the last step": ("contact_cache",),
    "islands and sleep": ("islands", "sleep", "step"),
    "rows of contacts": ("contact_rows", "substep"),
    "warm start": ("energy.apply_warm_start",),
    "residual": ("energy", "friction_cone.cone_residual", "friction_cone._nearest", "rows"),
    "sweeps": ("pgs", "nncg", "disc", "friction_cone"),
    "subspace steps": ("subspace", "cholesky"),
    "impacts and landings": ("impacts", "landings"),
    "position pass": ("position_pass",),
    "integration": ("integrate", "rotation", "free_rotation"),
}


@dataclass(frozen=True)
class Profile:
    """A heap in one phase: us per box and step of each stage, and sweeps per step."""

    heap: str
    phase: str
    stages: dict[str, float]
    sweeps: float


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add no options of its own."""


def stage_of(function: Sequence[str]) -> str:
    """Return the stage of a function by its path: packages, module, name."""
    for stage, places in STAGES.items():
        for place in places:
            module, _, name = place.partition(".")
            if module in function[:-1] and name in ("", function[-1]):
                return stage
    return OTHER


def profile(world: World, symbols: Symbols, advance: Callable[[], int], seconds: float) -> tuple[dict[str, float], int]:
    """Return the CPU time in us of each stage and the number of steps; ``advance`` takes some and returns how many."""
    steps = 0
    spent = 0.0

    def work() -> None:
        nonlocal steps, spent
        while spent < seconds:
            spent += cpu_time(lambda: count_steps(advance()))

    def count_steps(taken: int) -> None:
        nonlocal steps
        steps += taken

    hits = Counter(stage_of(symbols.function_at(place)) for place in sampled(work))
    total = sum(hits.values())
    return {stage: 1e6 * spent * hits[stage] / total for stage in (*STAGES, OTHER)}, steps


def profiles_of(heap: str, scene: Scene, symbols: Symbols, seconds: float) -> list[Profile]:
    """Sample the first steps of a heap, again and again from its start, and then steps at rest."""
    world = World(scene, options=AWAKE)
    boxes = int((world.model.bodies["kind"] == BodyKind.DYNAMIC).sum())

    def settle() -> int:
        world.reset()
        world.step(STEPS)
        return STEPS

    def rest() -> int:
        world.step(STEPS)
        return STEPS

    out = []
    for phase, advance in (("settling", settle), ("at rest", rest)):
        world.reset()
        if phase == "at rest":
            world.step(REST - STEPS)
        times, steps = profile(world, symbols, advance, seconds)
        sweeps = sweeps_of(world, advance is settle)
        stages = {stage: us / (boxes * steps) for stage, us in times.items()}
        out.append(Profile(heap, phase, stages, sum(sweeps) / len(sweeps)))
    return out


def sweeps_of(world: World, from_start: bool) -> list[float]:
    """Return the numbers of sweeps in steps that are taken one by one."""
    if from_start:
        world.reset()
    out = []
    for _ in range(STEPS):
        world.step()
        out.append(float(world.diagnostics().sweeps[0]))
    return out


def measure(run: Run) -> dict[str, Any]:
    seconds = QUICK_SECONDS if run.quick else SECONDS
    scenes = {heap: build() for heap, build in HEAPS[run.dim].items()}  # with the same features, so the same kernel
    found: list[Profile] = []
    with progress_bar("loading", len(scenes)) as bar:
        symbols = Symbols.of_steps_in(World(next(iter(scenes.values())), options=AWAKE).step)
        for heap, scene in scenes.items():
            bar.describe(heap)
            found += profiles_of(heap, scene, symbols, seconds)
            bar.advance()
    return {"dim": run.dim, "profiles": packed(found)}


def report(results: Mapping[str, Any]) -> Report:
    text = (
        f"CPU us per box and step with default options and without sleep, by samples of the running kernel. Settling:"
        f" the first {STEPS} steps from boxes that just touch; at rest: steps after {(REST - STEPS) * TIMESTEP:g} s."
        " 'Rows of contacts' writes them once in a step, refreshes them for each substep and stores their impulses."
    )
    return Report(f"Stages of a step in {results['dim']}D", [text, table(unpacked(Profile, results["profiles"]))])


def table(profiles: Sequence[Profile]) -> Table:
    rows = [[stage, *(f"{p.stages[stage]:.3f}" for p in profiles)] for stage in (*STAGES, OTHER)]
    rows.append(["**sum**", *(f"**{sum(p.stages.values()):.3f}**" for p in profiles)])
    rows.append(["sweeps per step", *(f"{p.sweeps:.2f}" for p in profiles)])
    return Table(["stage", *(f"{p.heap}, {p.phase}" for p in profiles)], rows)
