"""What a benchmark is run with."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any


class UsageError(Exception):
    """A wrong command line, in one sentence."""


class Unable(Exception):
    """What a benchmark needs is not here or does not work, in one sentence."""


@dataclass
class Run:
    """One run of a benchmark.

    Attributes:
        options: the parsed command line, with the benchmark's own options.
        quick: whether a small run is asked for, of about a minute.
        dim: 2 or 3.
        stamp: of this run; see stamp.py.
        results_file: where the results will be written; None: nowhere. A benchmark that writes it as it goes can
            continue an interrupted run.
        page: where the page will be written; None: nowhere. Files that it links to belong into its folder.
        interrupted: set by a benchmark that returned what it had when the user pressed Ctrl-C.
    """

    options: argparse.Namespace
    quick: bool
    dim: int
    stamp: dict[str, Any]
    results_file: Path | None = None
    page: Path | None = None
    interrupted: bool = False
