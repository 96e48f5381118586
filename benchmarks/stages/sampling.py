"""Samples of compiled kernels, and the names of the functions that they hit."""

from __future__ import annotations

import bisect
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.common.run import Unable
from gsenv.solver.core.step import step_worlds
from gsenv.solver.deferred_library import DeferredLibrary

FREQUENCY = 4000  # Hz
START, END = 0.5, 10.0  # s: until perf samples, and until it has written
NAMES = re.compile(r"(\d+)")
OUTSIDE = ("", "")  # the name of code that is not the kernel's


@dataclass(frozen=True)
class Symbols:
    """The functions of a compiled kernel in this process's memory.

    Attributes:
        starts: addresses of their first bytes, ascending.
        ends: addresses after their last bytes.
        names: of each: packages, module, name.
    """

    starts: list[int]
    ends: list[int]
    names: list[tuple[str, ...]]

    @classmethod
    def of_steps(cls, loaded: Mapping[int, bytes]) -> Symbols:
        """Return those of all kernels of steps; ``loaded``: see ``machine_code_kept``.

        Raises:
            Unable: nm is missing, which lists the symbols.
        """
        kernel: Any = step_worlds
        found: list[tuple[int, int, tuple[str, ...]]] = []
        for compiled in kernel.overloads.values():
            entry, library = compiled.fndesc.llvm_cpython_wrapper_name, compiled.library
            symbols = symbols_of(loaded.get(id(library)) or library._get_compiled_object())
            offset = library.get_pointer_to_function(entry) - next(start for start, _, name in symbols if name == entry)
            found += [(offset + start, offset + start + size, demangled(name)) for start, size, name in symbols]
        starts, ends, names = map(list, zip(*sorted(found), strict=True))
        return cls(starts, ends, names)

    def function_at(self, place: int) -> tuple[str, ...]:
        """Return packages, module and name of the function at an address, or ``OUTSIDE``."""
        k = bisect.bisect_right(self.starts, place) - 1
        return self.names[k] if k >= 0 and place < self.ends[k] else OUTSIDE


@contextmanager
def machine_code_kept() -> Iterator[dict[int, bytes]]:
    """Keep the object files of kernels that are loaded from a cache, by the id of their library, which drops them."""
    loaded: dict[int, bytes] = {}
    load = DeferredLibrary._set_compiled_object

    def keep(library: Any, code: bytes) -> None:
        loaded[id(library)] = code
        load(library, code)

    with mock.patch.object(DeferredLibrary, "_set_compiled_object", keep):
        yield loaded


def symbols_of(code: bytes) -> list[tuple[int, int, str]]:
    """Return (offset, size, name) of each function of an object file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "kernel.o"
        file.write_bytes(code)
        lines = output_of(["nm", "--print-size", "--defined-only", str(file)]).splitlines()
    words = [line.split() for line in lines]
    return [(int(w[0], 16), int(w[1], 16), w[3]) for w in words if len(w) == 4 and w[2].lower() in "tw"]


def demangled(symbol: str) -> tuple[str, ...]:
    """Return the parts of a name of numba's: _ZN5gsenv4core5stepB.. is ("gsenv", "core", "step")."""
    if not symbol.startswith("_ZN"):
        return ("", symbol)
    parts: list[str] = []
    rest = symbol[3:]
    while (match := NAMES.match(rest)) is not None:
        size = int(match[1])
        start = len(match[1])
        parts.append(rest[start : start + size])
        rest = rest[start + size :]
    return tuple(parts) if len(parts) > 1 else ("", symbol)


def sampled(work: Callable[[], None]) -> list[int]:
    """Return the addresses of the code that ran while ``work`` did.

    Raises:
        Unable: perf is missing or may not be used.
    """
    with tempfile.TemporaryDirectory() as folder:
        data = str(Path(folder) / "perf.data")
        command = ["perf", "record", "--quiet", "-F", str(FREQUENCY), "-o", data, "-p", str(os.getpid())]
        recorder = subprocess.Popen([found(command[0]), *command[1:]], stderr=subprocess.PIPE, text=True)
        time.sleep(START)
        try:
            work()
        finally:
            recorder.send_signal(signal.SIGINT)
            problem = end_of(recorder)
        if not Path(data).exists():
            raise Unable(f"perf can take no samples here: {' '.join(problem.split())}")
        lines = output_of(["perf", "script", "-i", data, "-F", "ip"]).split()
    if not lines:
        raise Unable("perf has taken no samples.")
    return [int(line, 16) for line in lines]


def end_of(recorder: subprocess.Popen[str]) -> str:
    """Wait until a process ends, which then is killed; return what it said."""
    try:
        return recorder.communicate(timeout=END)[1]
    except subprocess.TimeoutExpired:
        recorder.kill()
        return recorder.communicate()[1]


def found(program: str) -> str:
    """Return the path of a program."""
    path = shutil.which(program)
    if path is None:
        raise Unable(f"the stages of a step need {program}, which is not installed (Linux: linux-perf, binutils).")
    return path


def output_of(command: list[str]) -> str:
    return subprocess.run([found(command[0]), *command[1:]], capture_output=True, text=True, check=True).stdout
