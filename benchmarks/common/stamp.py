"""What a measurement depends on: the command, the commit, the machine and its load, versions, the date."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gsenv
from gsenv.train.origin import commit, cpu

ROOT = Path(__file__).parents[2]
BUSY = 0.5  # load average above which other processes were running


def load() -> float | None:
    """Load average of the last minute; None where the system has none."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def version_of(distribution: str) -> str:
    """Return the version of an installed distribution; "" if it is not installed."""
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return ""


def make_stamp(command: str) -> dict[str, Any]:
    """Return the stamp of a measurement that starts now; ``load`` gets its second number at its end."""
    return {
        "command": command,
        "date": datetime.date.today().isoformat(),
        "commit": commit(),
        "cpu": cpu(),
        "load": [load()],
        "versions": {
            "gsenv": gsenv.__version__,
            "Python": platform.python_version(),
            "numba": version_of("numba"),
            "NumPy": version_of("numpy"),
        },
    }


def describe(stamp: Mapping[str, Any]) -> str:
    """Return one or two sentences for the head of a page. Older results lack some of the entries."""
    where = f" on {stamp['cpu']}" if stamp.get("cpu") else ""
    commit_text = f" at commit {stamp['commit']}" if stamp.get("commit") else ""
    versions = ", ".join(f"{name} {version}" for name, version in stamp.get("versions", {}).items() if version)
    text = f"Measured on {stamp['date']}{where}{commit_text}" + (f" with {versions}." if versions else ".")
    loads = [value for value in stamp.get("load", []) if value is not None]
    if loads:
        text += f" Load average {' and '.join(f'{value:.1f}' for value in loads)} before and after."
        if loads[0] > BUSY:
            text += " **Other processes were running: times are too long.**"
    return text
