"""A small package gsenv with the kernel decorator of this one, whose kernels tests edit and run in processes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from gsenv.solver import deferred_library, inner_kernels, jit, kernel_sources, precompiled

CALLEE = """
from .constants import FACTOR
from .jit import inline_njit

@inline_njit
def callee(x):
    return FACTOR * x + {}
"""
CALLER = """
from gsenv.solver.callee import callee
from gsenv.solver.jit import njit

@njit
def caller(x):
    return 10 * callee(x)
"""
RUN = """
import sys
import warnings
from gsenv.solver import jit
jit.QUIET_SECONDS = {quiet}
from gsenv.solver.caller import caller
print(*[caller(eval(argument)) for argument in sys.argv[1:]])
print(*jit.compiled_kernels())
"""

Run = Callable[..., subprocess.CompletedProcess[str]]


def make_package(folder: Path) -> Path:
    """Make a package gsenv with this jit.py, a caller, its callee in another file, and a scene that uses them.

    Returns the folder in which the package lies.
    """
    solver = folder / "gsenv" / "solver"
    solver.mkdir(parents=True)
    (solver.parent / "__init__.py").touch()
    (solver / "__init__.py").write_text("from .scene import scene\n")
    for source in (jit, inner_kernels, deferred_library, kernel_sources, precompiled):
        file = Path(str(source.__file__))
        (solver / file.name).write_bytes(file.read_bytes())
    (solver / "constants.py").write_text("FACTOR = 1\n")
    (solver / "callee.py").write_text(CALLEE.format(1))
    (solver / "caller.py").write_text(CALLER)
    (solver / "scene.py").write_text("from .caller import caller\n\nscene = caller\n")
    return folder


def start(package: Path, *arguments: str, quiet: float = 1e9, **environment: str) -> subprocess.Popen[str]:
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    return subprocess.Popen(
        [sys.executable, "-c", RUN.format(quiet=quiet), *arguments],
        cwd=package,
        env=inherited | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(package: Path, *arguments: str, quiet: float = 1e9, **environment: str) -> tuple[str, str, str]:
    """Result line, line of compiled kernels, and stderr of a fresh process that calls `caller`."""
    process = start(package, *arguments, quiet=quiet, **environment)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    result, kernels = out.splitlines()
    return result, kernels, err


def entries(package: Path) -> list[str]:
    return sorted(path.name for path in (package / "gsenv/solver/__pycache__").glob("*.nb[ci]"))
