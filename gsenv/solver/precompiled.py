"""Kernels compiled ahead of time: cache entries for a baseline CPU, whose code every newer CPU runs.

A set is a zip file in assets/kernels/, one for each platform, Python and numba; `gsenv pack` writes it.  It holds the
kernels that Python calls, whose machine code contains their callees.  Entries have the names of the cache's files
(jit.py), and these hold a digest of the sources, so code of other sources is never found.  A process looks into its
cache first, then into the set, and compiles what is in neither.
"""

from __future__ import annotations

import os
import platform
import sys
import zipfile
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import numba
from llvmlite import binding

SWITCH = "GSENV_PRECOMPILED"  # environment variable: "0" for no precompiled kernels
FOLDER = Path(__file__).resolve().parents[1] / "assets" / "kernels"


class Baseline(NamedTuple):
    """A CPU that others can run the code of."""

    name: str  # LLVM's
    features: tuple[str, ...]  # that a CPU must have for that


BASELINES = {
    "x86_64": Baseline(
        "x86-64-v3",
        tuple("sse3 ssse3 sse4.1 sse4.2 popcnt cx16 sahf avx avx2 bmi bmi2 f16c fma lzcnt movbe xsave".split()),
    )
}
"""By machine; the x86-64 psABI defines x86-64-v3. Most x86-64 CPUs since 2013 have it."""


class KernelSet:
    """An opened set.

    Args:
        file: the zip file.

    Raises:
        OSError, zipfile.BadZipFile: it is missing or broken.
    """

    def __init__(self, file: Path) -> None:
        self._zip = zipfile.ZipFile(file)
        self._names = set(self._zip.namelist())
        self._functions = {function_of(name) for name in self._names}

    def read(self, name: str) -> bytes | None:
        """Return the entry of this name, or None."""
        return self._zip.read(name) if name in self._names else None

    def has(self, name: str) -> bool:
        """Whether there is an entry of this name."""
        return name in self._names

    def has_other_version(self, name: str) -> bool:
        """Whether the set has this kernel, for other sources or arguments."""
        return function_of(name) in self._functions


def machine() -> str:
    """Return the name of the processor's architecture, the same on every system."""
    name = platform.machine().lower()
    return {"amd64": "x86_64", "arm64": "aarch64"}.get(name, name)


def set_name() -> str:
    """Return the file name of the set for this system, Python and numba."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{sys.platform}-{machine()}-{python}-numba{numba.__version__}-llvmlite{llvmlite.__version__}.zip"


def function_of(name: str) -> str:
    """Return "module.function" of the name of a cache file, "module.function-LINE.pyXY.DIGEST.KEY.nbc"."""
    return name.rsplit(".", 4)[0].rpartition("-")[0]


@cache
def open_set() -> KernelSet | str:
    """Return this process's set, or why it has none."""
    if os.environ.get(SWITCH) == "0":
        return f"{SWITCH} is 0"
    if numba.config.CPU_NAME is not None or numba.config.CPU_FEATURES is not None:
        return "NUMBA_CPU_NAME or NUMBA_CPU_FEATURES is set"
    file = FOLDER / set_name()
    baseline = BASELINES.get(machine())
    if baseline is None or not file.is_file():
        python = f"{sys.version_info.major}.{sys.version_info.minor}"
        return (
            f"there are no precompiled kernels for {platform.system()} on {machine()} with Python {python} and "
            f"numba {numba.__version__}"
        )
    host = binding.get_host_cpu_features()
    missing = [feature for feature in baseline.features if not host.get(feature)]
    if missing:
        return f"this CPU lacks {missing[0]}, which the precompiled kernels use"
    try:
        return KernelSet(file)
    except (OSError, zipfile.BadZipFile) as error:
        return f"the precompiled kernels cannot be read ({error})"


def baseline_target(target: Any) -> Any:
    """Return numba's description (triple, CPU, features) of the baseline, from that of the host."""
    return (target[0], BASELINES[machine()].name, "")


_stale: list[str] = []


def find(name: str) -> bytes | None:
    """Return the entry of this name from the set, or None."""
    found = open_set()
    if isinstance(found, str):
        return None
    data = found.read(name)
    if data is None and found.has_other_version(name):
        _stale.append(name)
    return data


def has(name: str) -> bool:
    """Whether the set has an entry of this name."""
    found = open_set()
    return not isinstance(found, str) and found.has(name)


def why_not() -> str:
    """Return why this process compiles although there may be a set."""
    found = open_set()
    if isinstance(found, str):
        return found
    if _stale:
        return f"the precompiled {function_of(_stale[0])} is for other sources or another set of features"
    return "those of this scene are not among the precompiled ones"
