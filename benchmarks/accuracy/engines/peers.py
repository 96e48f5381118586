"""Engines in C that are built here from a folder of their sources, each behind the shim of its name in native/.

cmake compiles the engine and the shim, optimised, into one library in the user's cache. Its folder is named after the
contents of the sources and of native/, so an edit or another commit makes another library. An engine runs on one
thread. The library has the five functions of ``FUNCTIONS``; worlds, bodies, shapes and joints go in as rows of
doubles, whose meaning the shim says.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import re
import shutil
import subprocess
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.run import Unable

Array = NDArray[np.float64]

NATIVE = Path(__file__).parent / "native"
DOUBLES, INTS = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int)
FUNCTIONS = {
    "peer_create": (ctypes.c_void_p, (DOUBLES, INTS, DOUBLES, DOUBLES, DOUBLES)),
    "peer_step": (None, (ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_int)),
    "peer_profile": (None, (ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_int, DOUBLES)),
    "peer_read": (None, (ctypes.c_void_p, DOUBLES)),
    "peer_destroy": (None, (ctypes.c_void_p,)),
}
# What an engine's own clock tells of a step, as it names it: the whole, and parts that do not overlap.
WHOLE = "step"
STAGES = (
    WHOLE, "pairs", "collide", "solverSetup", "prepareConstraints", "integrateVelocities", "warmStart", "solveImpulses",
    "integratePositions", "relaxImpulses", "applyRestitution", "storeImpulses", "transforms", "jointEvents",
    "hitEvents", "refit", "bullets", "sensorHits", "sleepIslands", "sensors",
)  # fmt: skip
PROJECT_VERSION = r"project\([^)]*VERSION\s+(\d[\w.]*)"
LINES_OF_ERROR = 3  # of a compiler's message that go into the sentence


@dataclass(frozen=True, eq=False)
class Peer:
    """An engine that is built from its sources.

    Attributes:
        name: for people: "Box2D v3".
        target: of its CMakeLists.txt, and of its folder of headers: "box2d".
        shim: file in native/.
        variants: options of cmake, by the name of a way to build it.
    """

    name: str
    target: str
    shim: str
    variants: dict[str, tuple[str, ...]]

    @property
    def option(self) -> str:
        """Return the command line's option for its folder."""
        return f"--{self.target}-source"

    def version(self, source: Path) -> str:
        """Return its version, commit and digest; build all variants first.

        Raises:
            Unable: the folder is not the engine's, a tool is missing, or the build failed.
        """
        for variant in self.variants:
            self.library(source, variant)
        found = re.search(PROJECT_VERSION, (source / "CMakeLists.txt").read_text(encoding="utf-8-sig"))
        words = (found[1] if found else "", commit(source), digest_of(self, source)[:8])
        return " ".join(word for word in words if word)

    def library(self, source: Path, variant: str) -> ctypes.CDLL:
        """Return the library, built when there is none yet.

        Raises:
            Unable: as ``version``.
        """
        self.check(source)
        return loaded(library_path(self, source.resolve(), variant))

    def check(self, source: Path) -> None:
        """Raise Unable unless the folder has the engine's sources."""
        header = Path("include") / self.target / f"{self.target}.h"
        if not (source / "CMakeLists.txt").is_file() or not (source / header).is_file():
            raise Unable(f"{self.option} {source}: this is no source folder of {self.name}, it has no {header}.")


class World:
    """A world inside an engine's library.

    Args:
        settings: the row of the world.
        bodies, shapes, joints: rows.
        width: numbers that are read of each body.
    """

    def __init__(
        self, library: ctypes.CDLL, settings: Sequence[float], bodies: Array, shapes: Array, joints: Array, width: int
    ) -> None:
        counts = np.array([len(bodies), len(shapes), len(joints)], dtype=np.intc)
        rows = [np.ascontiguousarray(part, dtype=np.float64) for part in (np.array(settings), bodies, shapes, joints)]
        world, *things = (part.ctypes.data_as(DOUBLES) for part in rows)
        self.handle = library.peer_create(world, counts.ctypes.data_as(INTS), *things)
        self.shape = (len(bodies), width)
        self.library = library
        weakref.finalize(self, library.peer_destroy, self.handle)

    def step(self, timestep: float, substeps: int, count: int) -> None:
        """Take ``count`` timesteps in one call."""
        self.library.peer_step(self.handle, timestep, substeps, count)

    def profile(self, timestep: float, substeps: int, count: int) -> Array:
        """Take ``count`` timesteps; return (step, STAGES), the wall time in s of each stage."""
        out = np.empty((count, len(STAGES)))
        self.library.peer_profile(self.handle, timestep, substeps, count, out.ctypes.data_as(DOUBLES))
        return 1e-3 * out

    def read(self) -> Array:
        """Return a row for each body."""
        out = np.empty(self.shape)
        self.library.peer_read(self.handle, out.ctypes.data_as(DOUBLES))
        return out


# ---------------------------------------------------------------- building


def commit(source: Path) -> str:
    """Return the short hash of the folder's commit; "" outside a repository."""
    try:
        command = ["git", "-C", str(source), "rev-parse", "--short", "HEAD"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


@cache
def digest_of(peer: Peer, source: Path) -> str:
    """Return the hex digest of the contents of the engine's sources and of native/, the options and the system."""
    digest = hashlib.sha256(f"{platform.platform()} {peer.variants}".encode())
    files = [path for part in ("include", "src") for path in sorted((source / part).rglob("*")) if path.is_file()]
    for path in (source / "CMakeLists.txt", *files, NATIVE / "CMakeLists.txt", NATIVE / peer.shim):
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def cache_folder() -> Path:
    """Return the folder of all libraries."""
    place = os.environ.get("XDG_CACHE_HOME")
    return (Path(place) if place else Path.home() / ".cache") / "gsenv-peers"


@cache
def library_path(peer: Peer, source: Path, variant: str) -> Path:
    """Return the path of the built library.

    Raises:
        Unable: a tool is missing, or the build failed.
    """
    path = cache_folder() / f"{peer.target}-{variant}-{digest_of(peer, source)[:16]}.so"
    if path.exists():
        return path
    for tool in ("cmake", "cc", "c++"):
        if shutil.which(tool) is None:
            raise Unable(f"{peer.option}: building {peer.name} needs the program {tool}, which is not installed.")
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        build = Path(folder)
        given = {"PEER_SOURCE": source, "PEER_SHIM": NATIVE / peer.shim, "PEER_TARGET": peer.target}
        words = [f"-D{name}={value}" for name, value in given.items()]
        words += ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_C_FLAGS_RELEASE=-O3 -DNDEBUG", *peer.variants[variant]]
        run_tool(peer, ["cmake", "-S", str(NATIVE), "-B", folder, *words])
        run_tool(peer, ["cmake", "--build", folder, "--target", "peer"])
        made = next((file for file in build.glob("*peer.*") if file.suffix in (".so", ".dylib")), None)
        if made is None:
            raise Unable(f"{peer.option}: building {peer.name} made no shared library that is known here.")
        draft = path.with_suffix(f".{os.getpid()}")
        shutil.copy(made, draft)
        draft.replace(path)
    return path


def run_tool(peer: Peer, command: Sequence[str]) -> None:
    """Run a step of a build.

    Raises:
        Unable: it failed.
    """
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        lines = [line.strip() for line in (done.stderr + done.stdout).splitlines() if line.strip()]
        first = next((k for k, line in enumerate(lines) if "error" in line.lower()), 0)
        said = " ".join(lines[first : first + LINES_OF_ERROR])
        raise Unable(f"{peer.option}: building {peer.name} failed: {said}")


@cache
def loaded(path: Path) -> ctypes.CDLL:
    """Return the library with the types of its functions."""
    library = ctypes.CDLL(str(path))
    for name, (result, arguments) in FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def has_avx2() -> bool:
    """Whether the processor has AVX2, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    return info.exists() and " avx2" in info.read_text()
