"""Run time against error of gsenv beside other engines, on scenes with known answers.

    python -m benchmarks.accuracy                   all cases and settings, half an hour at most
    python -m benchmarks.accuracy --dim 3           in space, beside MuJoCo and PyBullet
    python -m benchmarks.accuracy --quick           two minutes
    python -m benchmarks.accuracy --only 14 16:10   rows or cases
    python -m benchmarks.accuracy --engine gsenv    this engine's points only

Every point is kept as soon as it is measured: after Ctrl-C the next call goes on from there. Points are
measured again where the solver, an engine's version, the benchmark or the machine has changed.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import tempfile
from itertools import chain, zip_longest
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from gsenv.solver.jit import mute_compile_notice

from .cases import Case
from .engines import Setting
from .measure import Results, measure
from .plot import draw
from .report import markdown, overview
from .stamp import about, stamps
from .suites import Suite, suite

DOCS = Path(__file__).parents[2] / "docs"


def plan(made: Suite, cases: list[Case], engines: list[str], quick: bool) -> list[tuple[Case, Setting]]:
    """Case by case, the engines by turns: a noisy minute hits all of them."""
    out: list[tuple[Case, Setting]] = []
    for case in cases:
        turns = zip_longest(*(made.settings[engine](case, quick) for engine in engines))
        out += [(case, setting) for setting in chain.from_iterable(turns) if setting is not None]
    return out


def chosen_cases(cases: list[Case], patterns: list[str] | None, quick: bool) -> list[Case]:
    """Cases by key ("14:10") or row ("14").

    Raises:
        SystemExit: a pattern fits no case.
    """
    if not patterns:
        return [case for case in cases if case.quick or not quick]
    known = {case.key for case in cases} | {case.row for case in cases}
    for pattern in patterns:
        if pattern not in known:
            raise SystemExit(f"--only {pattern} is unknown; known are {', '.join(case.key for case in cases)}.")
    return [case for case in cases if case.key in patterns or case.row in patterns]


def pin(core: int | None) -> None:
    """Stay on one core, where the system lets us."""
    if hasattr(os, "sched_setaffinity"):
        allowed = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {max(allowed) if core is None else core})


class Interrupts:
    """Remembers Ctrl-C: an engine's callbacks may swallow the exception."""

    def __init__(self) -> None:
        self.heard = False
        signal.signal(signal.SIGINT, self._hear)

    def _hear(self, *_: object) -> None:
        self.heard = True
        raise KeyboardInterrupt


def run(
    made: Suite, work: list[tuple[Case, Setting]], results: Results, stamp: dict[str, str], console: Console
) -> bool:
    """Measure what is not known yet; False if the user broke it off."""
    interrupts = Interrupts()
    columns = (TextColumn("{task.description:32}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # refreshed by hand: a thread that draws would disturb what is timed
    with Progress(*columns, console=console, auto_refresh=False) as progress:
        task = progress.add_task("", total=len(work))
        shown = ""
        try:
            for case, setting in work:
                if case.key != shown and not console.is_terminal:  # a file gets a line a case
                    console.print(f"{case.key}: {case.title}")
                shown = case.key
                if not results.known(case, setting, stamp[setting.engine]):
                    progress.update(task, description=f"{case.key} {setting.engine}", refresh=True)
                    rivals = results.of(case.key, setting.engine)
                    results.add(measure(made.build(setting.engine), case, setting, stamp[setting.engine], rivals))
                if interrupts.heard:
                    return False
                progress.advance(task)
        except KeyboardInterrupt:
            return False
        progress.update(task, description="done", refresh=True)
    return True


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.accuracy", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    parser.add_argument("--quick", action="store_true", help="fewer cases and settings, in a folder of its own")
    parser.add_argument("--only", nargs="+", metavar="CASE", help="rows (14) or cases (14:10)")
    parser.add_argument("--engine", nargs="+", metavar="NAME", help="default: all")
    parser.add_argument("--fresh", action="store_true", help="forget what was measured before")
    parser.add_argument("--output", type=Path, help="folder of the figures; default: docs")
    parser.add_argument("--core", type=int, help="run on this core; default: the last one")
    return parser.parse_args()


def main() -> int:
    arguments = parse()
    made = suite(arguments.dim)
    engines = arguments.engine or list(made.engines)
    for engine in engines:
        if engine not in made.engines:
            raise SystemExit(f"--engine {engine} is unknown; known are {', '.join(made.engines)}.")
    folder = arguments.output or (Path(tempfile.gettempdir()) / "gsenv-accuracy" if arguments.quick else DOCS)
    cases = chosen_cases(made.cases, arguments.only, arguments.quick)
    pin(arguments.core)
    mute_compile_notice()
    console = Console(emoji=False)  # 15:100: is no pictogram
    stamp = stamps(made)
    path = folder / f"{made.name}.json"
    results = Results(path, about(made), fresh=arguments.fresh)
    work = plan(made, cases, engines, arguments.quick)
    finished = run(made, work, results, stamp, console)
    if not results.points:
        return 130
    results.write()
    shown = [case for case in made.cases if results.of(case.key)]
    path.with_suffix(".md").write_text(markdown(made, shown, results, stamp))
    draw(shown, results, path.with_suffix(".png"))
    asked = {case.key for case in cases}
    console.print(overview([case for case in shown if case.key in asked], results))
    console.print(f"wrote {path}, .md and .png")
    if not finished:
        console.print("broken off; the same command goes on from here")
    return 0 if finished else 130


if __name__ == "__main__":
    sys.exit(main())
