"""What a figure depends on: versions, sources and the machine."""

from __future__ import annotations

import datetime
import platform
from pathlib import Path
from typing import Any

import numpy as np

import gsenv
from gsenv.solver.jit import source_digest

from . import box2d, ours, pymunk

HERE, PACKAGE = Path(__file__).parent, Path(gsenv.__file__).parent
# modules that all figures depend on
JUDGING = ("cases", "engines", "errors", "geometry", "measure", "trajectory")


def cpu() -> str:
    """Model name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def stamps() -> dict[str, str]:
    """Of each engine; a point with another stamp is out of date."""
    shared = digest(PACKAGE / "scenes", *(HERE / f"{name}.py" for name in JUDGING))
    return {
        "gsenv": "; ".join((ours.version(), digest(HERE / "ours.py"), shared, cpu())),
        "Box2D": "; ".join((box2d.version(), digest(HERE / "box2d.py"), shared, cpu())),
        "pymunk": "; ".join((pymunk.version(), digest(HERE / "pymunk.py"), shared, cpu())),
    }


def digest(*sources: Path) -> str:
    """Of the contents of files and folders."""
    return source_digest(sources)[:12]


def about() -> dict[str, Any]:
    """What a reader of the figures should know of the run."""
    return {
        "date": datetime.date.today().isoformat(),
        "cpu": cpu(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "gsenv": gsenv.__version__,
        "Box2D": box2d.version(),
        "pymunk": pymunk.version(),
    }
