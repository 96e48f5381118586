"""CPU time of each stage of a step, of heaps that settle and that rest, by sampling with Linux's ``perf``.

Samples are taken of the kernel as it always runs: no code is added to it. A sample belongs to the stage of the function
that it hits; a small function that the compiler has put into its callers belongs to theirs. Samples outside of the
kernel, such as of the reset between rounds, do not count.

    python -m benchmarks stages --box2d-source FOLDER
    python -m benchmarks stages --dim 3 --box3d-source FOLDER

also show the stages of Box2D v3 or Box3D, built from the folder of its sources, by its own clock (peers.py), and both
engines side by side.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.accuracy.built import add_source_options, given_sources
from benchmarks.accuracy.suites import Suite, suite_of
from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run, Unable
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time
from benchmarks.heaps import HEAPS, REST, STEPS, TIMESTEP, Phase, phases_of
from benchmarks.stages.beside import parts_of_page
from benchmarks.stages.peers import PeerProfile, Rounds, rounds_of
from benchmarks.stages.sampling import OUTSIDE, Symbols, machine_code_kept, sampled
from gsenv.solver import Options, World
from gsenv.solver.records.model import BodyKind

AWAKE = Options(timestep=TIMESTEP, sleep=False)
SECONDS, QUICK_SECONDS = 5.0, 0.5  # of CPU time in which a phase is sampled
OTHER = "the rest"
STAGES: dict[str, tuple[str, ...]] = {  # by modules, or functions of modules; the first that fits
    "collision": ("broadphase", "kept_pairs", "narrowphase", "detection", "recycling", "geometry", "secondary"),
    "matching with the last step": ("contact_cache",),
    "islands and sleep": ("islands", "sleep", "step"),
    "rows of contacts": ("contact_rows", "substep"),
    "warm start": ("energy.apply_warm_start",),
    "residual": ("energy", "friction_cone.cone_residual", "friction_cone._nearest", "rows"),
    "sweeps": ("pgs", "nncg", "disc", "friction_cone"),
    "subspace steps": ("subspace", "cholesky", "ordering", "blocks"),
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
    add_source_options(parser)


def stage_of(function: Sequence[str]) -> str:
    """Return the stage of a function by its path: packages, module, name."""
    for stage, places in STAGES.items():
        for place in places:
            module, _, name = place.partition(".")
            if module in function[:-1] and name in ("", function[-1]):
                return stage
    return OTHER


def profile(world: World, symbols: Symbols, phase: Phase, seconds: float, turns: Sequence[Rounds]) -> dict[str, float]:
    """Step for so many seconds of CPU time, in turns with other engines; return us of CPU time of our stages."""
    times: list[float] = []

    def work() -> None:
        while sum(times) < seconds:
            if phase.before == 0:
                world.reset()
            times.append(cpu_time(lambda: world.step(phase.steps)))
            for rounds in turns:
                rounds.keep_up(sum(times))

    functions = [symbols.function_at(place) for place in sampled(work)]
    hits = Counter(stage_of(function) for function in functions if function != OUTSIDE)
    if not hits:
        raise Unable("no sample hit the kernel of steps.")
    us = 1e6 * sum(times) / (phase.steps * len(times) * sum(hits.values()))
    return {stage: us * hits[stage] for stage in (*STAGES, OTHER)}


def profiles_of(
    suite: Suite, heap: str, loaded: Mapping[int, bytes], seconds: float
) -> tuple[list[Profile], list[PeerProfile]]:
    """Sample the first steps of a heap, again and again from its start, and then steps at rest; of gsenv and peers."""
    world = World(HEAPS[suite.dim][heap].build(), options=AWAKE)
    boxes = int((world.model.bodies["kind"] == BodyKind.DYNAMIC).sum())
    world.step()
    symbols = Symbols.of_steps(loaded)
    out: list[Profile] = []
    peers: list[PeerProfile] = []
    for phase in phases_of(HEAPS[suite.dim][heap]):
        turns = rounds_of(suite, world.model, phase)
        world.reset()
        world.step(phase.before)
        stages = {stage: us / boxes for stage, us in profile(world, symbols, phase, seconds, turns).items()}
        sweeps = sweeps_of(world, phase)
        out.append(Profile(heap, phase.name, stages, sum(sweeps) / len(sweeps)))
        peers += [rounds.profile(heap, boxes) for rounds in turns]
    return out, peers


def sweeps_of(world: World, phase: Phase) -> list[float]:
    """Return the numbers of sweeps in steps that are taken one by one."""
    if phase.before == 0:
        world.reset()
    out = []
    for _ in range(phase.steps):
        world.step()
        out.append(float(world.diagnostics().sweeps[0]))
    return out


def measure(run: Run) -> dict[str, Any]:
    seconds = QUICK_SECONDS if run.quick else SECONDS
    sources = given_sources(run.options, run.dim)
    suite = suite_of(run.dim, sources)
    run.stamp["versions"] = run.stamp["versions"] | {engine: suite.version(engine) for engine in sources}
    found: list[Profile] = []
    peers: list[PeerProfile] = []
    heaps = list(HEAPS[run.dim])
    with progress_bar("", len(heaps)) as bar, machine_code_kept() as loaded:
        for heap in heaps:
            bar.describe(heap)
            ours, theirs = profiles_of(suite, heap, loaded, seconds)
            found += ours
            peers += theirs
            bar.advance()
    results = {"dim": run.dim, "profiles": packed(found)}
    return results | {"peers": packed(peers)} if peers else results


def report(results: Mapping[str, Any]) -> Report:
    text = (
        f"CPU us per box and step with default options and without sleep, by samples of the running kernel. Settling:"
        f" the first {STEPS} steps from boxes that just touch, those in which a pile falls together; at rest: steps"
        f" after {(REST - STEPS) * TIMESTEP:g} s, when some boxes of a pile still move."
        " 'Rows of contacts' writes them once in a step, refreshes them for each substep and stores their impulses."
    )
    profiles = unpacked(Profile, results["profiles"])
    parts: list[Part] = [text, table(profiles)]
    if "peers" in results:
        ours = {(p.heap, p.phase): p.stages for p in profiles}
        parts += parts_of_page(ours, unpacked(PeerProfile, results["peers"]))
    return Report(f"Stages of a step in {results['dim']}D", parts)


def table(profiles: Sequence[Profile]) -> Table:
    rows = [[stage, *(f"{p.stages[stage]:.3f}" for p in profiles)] for stage in (*STAGES, OTHER)]
    rows.append(["**sum**", *(f"**{sum(p.stages.values()):.3f}**" for p in profiles)])
    rows.append(["sweeps per step", *(f"{p.sweeps:.2f}" for p in profiles)])
    return Table(["stage", *(f"{p.heap}, {p.phase}" for p in profiles)], rows)
