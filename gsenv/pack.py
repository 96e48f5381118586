"""Sets of precompiled kernels: what `gsenv pack` writes. See solver/precompiled.py."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.files import replacing
from gsenv.solver import precompiled
from gsenv.warmup import compile_targets, warmup_targets

_ZIP_TIME = (1980, 1, 1, 0, 0, 0)  # of each entry: equal kernels make equal files


def pack_targets() -> list[str]:
    """Return the names of the targets of `gsenv.warmup` that a set is for.

    They are all environments, each alone and batched, and scenes of the user's own.
    """
    environments = {entry.id for entry in ENVS} | {entry.name for entry in PARALLEL_ENVS}
    return [name for name in warmup_targets() if name in environments or name.startswith("any scene")]


def compile_for_baseline(names: list[str], processes: int, cache: Path) -> Iterator[str]:
    """Run targets of `gsenv.warmup` in processes that compile for the baseline CPU into the folder ``cache``.

    Yields the name of each target when it is done.

    Raises:
        KeyError: there is no baseline for this machine.
    """
    environment = {
        "NUMBA_CACHE_DIR": str(cache),
        "NUMBA_CPU_NAME": precompiled.BASELINES[precompiled.machine()].name,
        "NUMBA_CPU_FEATURES": "",
    }
    yield from compile_targets(names, processes, environment)


def write_set(cache: Path, folder: Path = precompiled.FOLDER) -> Path:
    """Write the kernels of a cache that Python calls to the set in ``folder``, atomically; returns its path."""
    path = folder / precompiled.set_name()
    kernels = sorted(cache.rglob("*.nbc"), key=lambda file: file.name)
    with replacing(path) as partial, zipfile.ZipFile(partial, "w") as archive:
        for file in kernels:
            archive.writestr(zipfile.ZipInfo(file.name, _ZIP_TIME), file.read_bytes(), zipfile.ZIP_LZMA)
    return path
