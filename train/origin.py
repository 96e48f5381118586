"""Where a run was made: version, commit, processor. It is written beside the policy and read by the baselines."""

from __future__ import annotations

import platform
import subprocess
from pathlib import Path

from gsenv import __version__
from gsenv.train.files import read_object, write_json

FILE = "origin.json"  # in a run's folder
_SOURCE = Path(__file__).resolve()  # in this checkout, also where gsenv/train is a link


def cpu() -> str:
    """Return the model name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def commit() -> str:
    """Return the short hash of the checked-out commit, with a "+" if files differ from it; "" outside a repository."""
    if not _git("ls-files", "--", str(_SOURCE)):  # installed below somebody else's repository
        return ""
    short, status = _git("rev-parse", "--short", "HEAD"), _git("status", "--porcelain", "--untracked-files=no")
    return short + ("+" if short and status else "")


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], cwd=_SOURCE.parent, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def write_origin(folder: Path) -> None:
    """Write what a run begins on; where another one began it, both are named."""
    now = {"gsenv": __version__, "commit": commit(), "cpu": cpu()}
    path = folder / FILE
    before = read_object(path) if path.is_file() else {}
    for name, value in now.items():
        known = [part for part in str(before.get(name, "")).split(", ") if part]
        now[name] = ", ".join(known if value in known or not value else [*known, value])
    write_json(path, now)
