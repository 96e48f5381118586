"""How much energy the solver makes in random scenes, by category, and the worst seeds.

python -m benchmarks.stress [--dim 3] [--cases 2000] [--first 0] [--category ratio] [--processes 2]
"""

import argparse
from collections import defaultdict
from multiprocessing import get_context
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from tests.stress import generator, spatial
from tests.stress.generator import random_case
from tests.stress.measure import LIMIT, Outcome, problems, run_case
from tests.stress.spatial import random_spatial_case

WORST = 3  # seeds named in each row
CATEGORIES = {2: generator.CATEGORIES, 3: spatial.CATEGORIES}
STEPS = {2: 200, 3: 300}
Job = tuple[int, int, str | None]  # dimension, seed, category


def run_seed(job: Job) -> Outcome:
    dim, seed, category = job
    case = random_case(seed, category) if dim == 2 else random_spatial_case(seed, category)
    return run_case(case, STEPS[dim])


def run_all(jobs: list[Job], processes: int) -> list[Outcome]:
    if processes == 1:
        return [run_seed(job) for job in track(jobs, "scenes")]
    with get_context("spawn").Pool(processes) as pool:
        results = pool.imap(run_seed, jobs, chunksize=10)
        return list(track(results, "scenes", total=len(jobs)))


def table_of(outcomes: list[Outcome], dim: int = 2) -> Table:
    """One row a category; excess and rise over the energy scale, speed over the speed scale."""
    table = Table(title=f"{len(outcomes)} scenes of {STEPS[dim]} steps; limit of the excess {LIMIT:g}")
    columns = ("category", "scenes", "errors", "NaN", "excess", "rise", "rise 99 %", "rises > limit", "speed")
    for name in (*columns, "behind a plane", "worst seeds (rise)"):
        table.add_column(name, justify="left" if name in ("category", "worst seeds (rise)") else "right")
    rows = defaultdict(list)
    for outcome in outcomes:
        rows[outcome.category].append(outcome)
    for category in sorted(rows, key=CATEGORIES[dim].index):
        group = rows[category]
        excess = np.array([o.excess for o in group])
        passive = not np.isnan(excess).all()
        rise = np.array([o.rise for o in group])
        speed = np.array([o.speed for o in group])
        order = np.argsort(-(rise if passive else speed))[:WORST]
        worst = ", ".join(f"{group[k].seed} ({rise[k] if passive else speed[k]:.0e})" for k in order)
        table.add_row(
            category,
            str(len(group)),
            str(sum(bool(o.error) for o in group)),
            str(sum(not o.finite for o in group)),
            f"{np.nanmax(excess):.1e}" if passive else "driven",
            f"{rise.max():.1e}" if passive else "-",
            f"{np.quantile(rise, 0.99):.1e}" if passive else "-",
            str(int((rise > LIMIT).sum())) if passive else "-",
            f"{speed.max():.2f}",
            str(sum(o.escaped for o in group)),
            worst,
        )
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    parser.add_argument("--cases", "--scenes", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--category", choices=sorted({*generator.CATEGORIES, *spatial.CATEGORIES}))
    parser.add_argument("--processes", type=int, default=1)
    arguments = parser.parse_args()
    dim = arguments.dim
    if arguments.category and arguments.category not in CATEGORIES[dim]:
        parser.error(f"{dim}D has the categories {', '.join(CATEGORIES[dim])}")
    jobs = [(dim, seed, arguments.category) for seed in range(arguments.first, arguments.first + arguments.cases)]
    start = perf_counter()
    outcomes = run_all(jobs, arguments.processes)
    console = Console()
    console.print(table_of(outcomes, dim))
    console.print(
        "excess: largest energy above the start (and its overlap); rise: above the least so far, which soft "
        "welds and overlaps may cause; driven scenes count speeds instead"
    )
    for line in filter(None, map(problems, outcomes)):
        console.print(f"[red]{line}")
    console.print(f"{perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
