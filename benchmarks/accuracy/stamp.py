"""What a figure depends on: versions, sources and the machine."""

from __future__ import annotations

import datetime
import platform
from pathlib import Path
from typing import Any

import numpy as np

import gsenv
from gsenv.solver.jit import source_digest

from .suites import Suite

HERE, PACKAGE = Path(__file__).parent, Path(gsenv.__file__).parent


def cpu() -> str:
    """Model name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def stamps(suite: Suite) -> dict[str, str]:
    """Of each engine; a point with another stamp is out of date."""
    shared = digest(PACKAGE / "scenes", *(HERE / f"{name}.py" for name in suite.judging))
    return {
        name: "; ".join((module.version(), digest(Path(str(module.__file__))), shared, cpu()))
        for name, module in suite.engines.items()
    }


def digest(*sources: Path) -> str:
    """Of the contents of files and folders."""
    return source_digest(sources)[:12]


def about(suite: Suite) -> dict[str, Any]:
    """What a reader of the figures should know of the run."""
    return {
        "date": datetime.date.today().isoformat(),
        "cpu": cpu(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        **{name: module.version() for name, module in suite.engines.items()},
        "gsenv": gsenv.__version__,
    }
