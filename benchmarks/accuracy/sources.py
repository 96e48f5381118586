"""What a point depends on: versions, source files and the machine."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import gsenv
from gsenv.solver.jit import source_digest
from gsenv.train.origin import cpu

from .suites import Suite

HERE, PACKAGE = Path(__file__).parent, Path(gsenv.__file__).parent


def source_stamps(suite: Suite, engines: Iterable[str]) -> dict[str, str]:
    """Return one text for each engine; a point with another one is out of date."""
    shared = digest(PACKAGE / "scenes", *(HERE / name for name in suite.judging))
    stamps = {}
    for name in engines:
        stamps[name] = "; ".join((suite.version(name), digest(*suite.files(name)), shared, cpu()))
    return stamps


def digest(*sources: Path) -> str:
    """Return a digest of the contents of files and folders."""
    return source_digest(sources)[:12]
