"""`gsenv warmup` and `gsenv pack`."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterable
from pathlib import Path
from time import perf_counter

from gsenv.files import terminable

from .errors import FAILED, OK, WRONG_USAGE, CliError
from .names import suggestion
from .progress import make_progress


def run_warmup(options: argparse.Namespace) -> int:
    from gsenv import warmup
    from gsenv.solver import jit

    jit.mute_compile_notice()  # the progress bar replaces it
    names = list(warmup.warmup_targets())
    for name in options.names:
        if name not in names:
            raise CliError(f"there is nothing to compile called {name!r}; {suggestion(name, names)}", WRONG_USAGE)
    names = options.names or names
    began = perf_counter()
    _follow(warmup.compile_targets(names, options.processes or warmup.core_count()), len(names))
    print(f"all kernels are ready ({perf_counter() - began:.1f} s)")
    return OK


def run_pack(options: argparse.Namespace) -> int:
    from gsenv import pack, warmup
    from gsenv.solver import precompiled

    if precompiled.machine() not in precompiled.BASELINES:
        raise CliError(f"there is no baseline CPU for {precompiled.machine()}, so kernels cannot be shared", FAILED)
    names = pack.pack_targets()
    folder = options.out or precompiled.FOLDER
    try:
        with terminable(), tempfile.TemporaryDirectory() as cache:
            processes = options.processes or warmup.core_count()
            if not options.fresh:
                print(f"{pack.keep_current(Path(cache), folder)} kernels are kept")
            _follow(pack.compile_for_baseline(names, processes, Path(cache)), len(names))
            path = pack.write_set(Path(cache), folder)
    except OSError as error:
        raise CliError(f"cannot write the set: {error.strerror or error}", FAILED) from error
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")
    return OK


def _follow(done: Iterable[str], count: int) -> None:
    """Show a progress bar of targets that are compiled side by side."""
    with make_progress() as progress:
        task = progress.add_task("compiling", total=count)
        for name in done:
            progress.update(task, advance=1, description=f"compiled for {name}")
