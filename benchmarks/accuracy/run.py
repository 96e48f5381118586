"""Which cases and settings are measured, and in which order."""

from __future__ import annotations

import argparse
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, zip_longest
from typing import Any

from benchmarks.common.progress import progress_bar
from benchmarks.common.run import Run, UsageError

from .built import BUILT, add_source_options, given_sources
from .cases import Case
from .engines import Setting
from .points import Results, measure_point
from .sources import source_stamps
from .suites import Suite, suite_of


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--only", nargs="+", metavar="CASE", help="cases (tower:10) or families of cases (tower)")
    parser.add_argument("--engine", nargs="+", metavar="NAME", help="default: all that are installed")
    parser.add_argument("--fresh", action="store_true", help="forget what was measured before")
    add_source_options(parser)


def chosen_cases(cases: Sequence[Case], names: Sequence[str] | None, quick: bool) -> list[Case]:
    """Return the cases with a key ("tower:10") or family ("tower"); all, or all of a quick run, if none is named.

    Raises:
        UsageError: a name fits no case.
    """
    if not names:
        return [case for case in cases if case.quick or not quick]
    known = {case.key for case in cases} | {case.family for case in cases}
    for name in names:
        if name not in known:
            raise UsageError(f"--only {name}: no such case; there are {', '.join(case.key for case in cases)}.")
    return [case for case in cases if case.key in names or case.family in names]


def chosen_engines(suite: Suite, names: Sequence[str] | None) -> list[str]:
    """Return the engines that were asked for, or all that are installed or whose sources are given.

    Raises:
        UsageError: an engine is unknown, not installed or without sources.
    """
    installed = suite.installed
    for name in names or ():
        if name not in suite.engines:
            raise UsageError(f"--engine {name}: unknown; there are {', '.join(suite.engines)}.")
        if name not in installed and name in BUILT:
            raise UsageError(f"--engine {name!r}: it is built from its sources; give {BUILT[name].flag} FOLDER.")
        if name not in installed:
            raise UsageError(f"--engine {name}: not installed; pip install 'gsenv[bench]'.")
    return list(names or installed)


def plan(suite: Suite, cases: Sequence[Case], engines: Sequence[str], quick: bool) -> list[tuple[Case, Setting]]:
    """Return the jobs case by case, the engines by turns, so that a slow minute of the machine hits all of them."""
    jobs: list[tuple[Case, Setting]] = []
    for case in cases:
        turns = zip_longest(*(suite.settings[engine](case, quick) for engine in engines))
        jobs += [(case, setting) for setting in chain.from_iterable(turns) if setting is not None]
    return jobs


@contextmanager
def remembered_interrupts() -> Iterator[list[int]]:
    """Yield a list that is not empty after Ctrl-C, since callbacks of an engine may swallow the exception."""
    heard: list[int] = []

    def hear(number: int, _: object) -> None:
        heard.append(number)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, hear)
    try:
        yield heard
    finally:
        signal.signal(signal.SIGINT, before)


def measure_jobs(suite: Suite, jobs: Sequence[tuple[Case, Setting]], results: Results) -> bool:
    """Measure what is not known yet; False if the user pressed Ctrl-C."""
    with progress_bar("", len(jobs)) as bar, remembered_interrupts() as heard:
        try:
            for case, setting in jobs:
                bar.describe(case.key)
                if not results.known(case, setting):
                    others = results.of(case.key, setting.engine)
                    sources = results.sources[setting.engine]
                    results.add(measure_point(suite.build(setting.engine), case, setting, sources, others))
                if heard:
                    return False
                bar.advance()
        except KeyboardInterrupt:
            return False
    return True


def measure(run: Run) -> dict[str, Any]:
    """Measure missing and outdated points; return all points known after this run.

    Raises:
        KeyboardInterrupt: before there was any point.
    """
    suite = suite_of(run.dim, given_sources(run.options, run.dim))
    engines = chosen_engines(suite, run.options.engine)
    cases = chosen_cases(suite.cases, run.options.only, run.quick)
    results = Results(run.dim, run.stamp, source_stamps(suite, engines), run.results_file, run.options.fresh)
    peers = {name: suite.version(name) for name in engines if name != "gsenv"}
    run.stamp["versions"] = results.versions | run.stamp["versions"] | peers
    run.interrupted = not measure_jobs(suite, plan(suite, cases, engines, run.quick), results)
    if not results.points:
        raise KeyboardInterrupt
    return results.data()
