"""Energy gained and speeds reached in random scenes, by category, and the worst seeds.

The scenes are those of tests/stress, where measure.py says what counts as broken.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.common.files import packed, unpacked
from benchmarks.common.processes import in_processes
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run, UsageError
from benchmarks.common.tables import Table
from gsenv.train.arguments import not_negative, positive
from tests.stress import generator, spatial
from tests.stress.generator import random_case
from tests.stress.measure import LIMIT, Outcome, problems, run_case
from tests.stress.spatial import random_spatial_case

WORST = 3  # seeds named in each row
CATEGORIES = {2: generator.CATEGORIES, 3: spatial.CATEGORIES}
STEPS = {2: 200, 3: 300}
SCENES, QUICK_SCENES = 2000, 100
Job = tuple[int, int, str | None]  # dimension, seed, category


@dataclass(frozen=True)
class Summary:
    """Outcomes of a category; energies over each scene's scale.

    Attributes:
        excess: largest energy above the start and the work of overlaps; None where something drives the scenes.
        rise, rise_99: largest gain above the least energy so far, and its 99th percentile.
        over_limit: scenes whose gain is above LIMIT.
        speed: largest speed over the scene's scale of speeds.
        worst: seeds with the largest gain, or the largest speed in driven scenes.
    """

    category: str
    scenes: int
    errors: int
    not_finite: int
    excess: float | None
    rise: float
    rise_99: float
    over_limit: int
    speed: float
    escaped: int
    worst: str


def run_seed(job: Job) -> Outcome:
    dim, seed, category = job
    case = random_case(seed, category) if dim == 2 else random_spatial_case(seed, category)
    return run_case(case, STEPS[dim])


def summary(category: str, group: Sequence[Outcome]) -> Summary:
    excess = np.array([o.excess for o in group])
    passive = not np.isnan(excess).all()
    rise, speed = np.array([o.rise for o in group]), np.array([o.speed for o in group])
    judged = rise if passive else speed
    worst = ", ".join(f"{group[k].seed} ({judged[k]:.0e})" for k in np.argsort(-judged)[:WORST])
    return Summary(
        category=category,
        scenes=len(group),
        errors=sum(bool(o.error) for o in group),
        not_finite=sum(not o.finite for o in group),
        excess=float(np.nanmax(excess)) if passive else None,
        rise=float(rise.max()),
        rise_99=float(np.quantile(rise, 0.99)),
        over_limit=int((rise > LIMIT).sum()),
        speed=float(speed.max()),
        escaped=sum(o.escaped for o in group),
        worst=worst,
    )


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scenes", type=positive, metavar="N", help=f"how many; default: {SCENES}")
    parser.add_argument("--first", type=not_negative, default=0, metavar="SEED", help="seed of the first scene")
    parser.add_argument("--category", choices=sorted({*generator.CATEGORIES, *spatial.CATEGORIES}))
    parser.add_argument("--processes", type=positive, default=1)


def measure(run: Run) -> dict[str, Any]:
    options, known = run.options, CATEGORIES[run.dim]
    if options.category and options.category not in known:
        raise UsageError(f"--category {options.category}: {run.dim}D scenes have {', '.join(known)}.")
    count = options.scenes or (QUICK_SCENES if run.quick else SCENES)
    jobs = [(run.dim, seed, options.category) for seed in range(options.first, options.first + count)]
    outcomes = in_processes(run_seed, jobs, options.processes, "random scenes")
    groups = {category: [o for o in outcomes if o.category == category] for category in known}
    return {
        "dim": run.dim,
        "steps": STEPS[run.dim],
        "summaries": packed(summary(category, group) for category, group in groups.items() if group),
        "broken": [
            f"{line}: `{repeat(run.dim, outcome.seed, options.category)}`"
            for outcome in outcomes
            if (line := problems(outcome))
        ],
    }


def repeat(dim: int, seed: int, category: str | None) -> str:
    """Return the command that runs one scene again; without a category it follows from the seed."""
    chosen = f" --category {category}" if category else ""
    return f"python -m benchmarks stress --dim {dim} --scenes 1 --first {seed}{chosen}"


def report(results: Mapping[str, Any]) -> Report:
    rows = []
    for s in unpacked(Summary, results["summaries"]):
        gains = ["driven", "-", "-", "-"]
        if s.excess is not None:
            gains = [f"{s.excess:.1e}", f"{s.rise:.1e}", f"{s.rise_99:.1e}", str(s.over_limit)]
        counts = [str(s.scenes), str(s.errors), str(s.not_finite)]
        rows.append([s.category, *counts, *gains, f"{s.speed:.2f}", str(s.escaped), s.worst])
    header = [
        "category", "scenes", "errors", "not finite", "excess", "rise", "rise, 99 %", f"rise > {LIMIT:g}", "speed",
        "escaped", "worst seeds",
    ]  # fmt: skip
    parts: list[Part] = [
        Table(header, rows),
        "excess: largest energy above that of the start and of its overlaps; rise: above the least energy so far, "
        "which soft welds and overlaps may cause; both over the scene's scale of energy. In driven scenes speeds "
        "count instead.",
        *(f"**{line}**" for line in results["broken"]),
    ]
    return Report(f"Random {results['dim']}D scenes of {results['steps']} steps", parts)
