"""Sets of precompiled kernels: what `gsenv pack` writes. See solver/precompiled.py."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path

from numba.core.caching import _CacheLocator

import gsenv
import gsenv.envs
from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.files import replacing
from gsenv.solver import precompiled
from gsenv.solver.jit import source_digest
from gsenv.solver.kernel_sources import kernel_sources
from gsenv.warmup import PROBLEMS, READINGS, compile_targets, warmup_targets

_ZIP_TIME = (1980, 1, 1, 0, 0, 0)  # of each entry: equal kernels make equal files


def pack_targets() -> list[str]:
    """Return the names of the targets of `gsenv.warmup` that a set is for.

    They are scenes of the user's own, which take longest, what reads and changes them, problems without bodies, and
    all environments, each alone and batched.
    """
    environments = {entry.id for entry in ENVS} | {entry.name for entry in PARALLEL_ENVS}
    others = ("any scene", READINGS, PROBLEMS)
    names = [name for name in warmup_targets() if name in environments or name.startswith(others)]
    return sorted(names, key=lambda name: name in environments)


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


def keep_current(cache: Path, folder: Path = precompiled.FOLDER) -> int:
    """Copy the kernels of the set in ``folder`` whose sources are as they were to a cache, where nothing compiles them.

    Returns how many there are; 0 without a set.
    """
    file = folder / precompiled.set_name()
    if not file.is_file():
        return 0
    sources: dict[tuple[str, str], list[Path]] = {}  # by module and digest, as in the names of entries
    for root in (Path(gsenv.__file__).parent, Path(gsenv.envs.__file__).parent):
        for source in root.rglob("*.py"):
            key = (source.stem, source_digest(kernel_sources(source))[:16])
            sources.setdefault(key, []).append(source)
    kept = set()
    with zipfile.ZipFile(file) as archive:
        for name in archive.namelist():
            for source in sources.get((name.partition(".")[0], name.split(".")[-3]), []):
                place = cache / _CacheLocator.get_suitable_cache_subpath(str(source))
                place.mkdir(exist_ok=True)
                (place / name).write_bytes(archive.read(name))
                kept.add(name)
    return len(kept)


def write_set(cache: Path, folder: Path = precompiled.FOLDER) -> Path:
    """Write the kernels of a cache that Python calls to the set in ``folder``, atomically; returns its path."""
    path = folder / precompiled.set_name()
    kernels = {file.name: file for file in cache.rglob("*.nbc")}
    with replacing(path) as partial, zipfile.ZipFile(partial, "w") as archive:
        for _, file in sorted(kernels.items()):
            archive.writestr(zipfile.ZipInfo(file.name, _ZIP_TIME), file.read_bytes(), zipfile.ZIP_LZMA)
    return path
