"""The command ``python -m benchmarks``: lists the benchmarks, or runs one.

python -m benchmarks                            all names, with a line on each
python -m benchmarks NAME                       a full run: results to benchmarks/results/, pages and pictures to docs/
python -m benchmarks NAME --quick               about a minute with compiled kernels; writes nothing
python -m benchmarks NAME [--quick] --out DIR   writes everything to DIR
python -m benchmarks NAME --from-results        measures nothing: writes page and picture of the stored results
python -m benchmarks NAME --help                the benchmark's own options

Exit codes: 0 done, 1 failed, 2 wrong command line, 130 interrupted.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks.common.files import as_stored, read_json
from benchmarks.common.report import Outputs, show, write
from benchmarks.common.run import Run, Unable, UsageError
from benchmarks.common.stamp import ROOT, load, make_stamp
from benchmarks.registry import BENCHMARKS, Benchmark, Implementation
from gsenv.files import check_writable

DOCS, RESULTS = ROOT / "docs", ROOT / "benchmarks" / "results"
OK, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or words[0] in ("-h", "--help"):
        print(f"{listing()}\n\n{(__doc__ or '').partition(chr(10))[2].strip()}" if words else listing())
        return OK
    benchmark = BENCHMARKS.get(words[0])
    if benchmark is None:
        nearest = get_close_matches(words[0], BENCHMARKS, 1, cutoff=0.0)[0]
        return failed(f"there is no benchmark {words[0]!r}; the nearest name is {nearest!r}.", WRONG_USAGE)
    try:
        return run(benchmark, words)
    except UsageError as error:
        return failed(str(error), WRONG_USAGE)
    except Unable as error:
        return failed(str(error), FAILED)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] in ("benchmarks", "gsenv"):
            raise
        return failed(f"{benchmark.name} needs {error.name}: pip install 'gsenv[bench,test]'.", FAILED)
    except KeyboardInterrupt:
        return failed("interrupted; nothing was written.", INTERRUPTED)


def without_place(word: str) -> str:
    """Return a word of a command line, FOLDER in place of an absolute path: pages do not tell where things lay."""
    return "FOLDER" if Path(word).is_absolute() else word


def failed(sentence: str, code: int) -> int:
    print(f"benchmarks: {sentence}", file=sys.stderr)
    return code


def listing() -> str:
    """Return the list of names and summaries."""
    width = max(map(len, BENCHMARKS))
    lines = (f"  {name:{width}}  {benchmark.summary}" for name, benchmark in BENCHMARKS.items())
    return "usage: python -m benchmarks NAME [--quick] [--out DIR] [--help]\n\n" + "\n".join(lines)


def parser_of(benchmark: Benchmark, module: Implementation) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks {benchmark.name}",
        description=module.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    effort = parser.add_mutually_exclusive_group()
    effort.add_argument("--quick", action="store_true", help="a small run; writes nothing unless --out is given")
    effort.add_argument(
        "--from-results", nargs="?", const=RESULTS, type=Path, metavar="FILE",
        help="measure nothing: write page and picture of stored results; default: those in benchmarks/results/",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="write all files to this folder")
    if len(benchmark.dims) > 1:
        parser.add_argument("--dim", type=int, choices=benchmark.dims, default=benchmark.dims[0])
    if benchmark.single_core:
        parser.add_argument("--core", type=int, help="run on this core; default: the last one")
    module.add_options(parser)
    return parser


def outputs_of(benchmark: Benchmark, stem: str, quick: bool, folder: Path | None) -> Outputs:
    """Return the paths of the files of a run."""
    if folder is not None:
        return Outputs(folder / f"{stem}.json", folder / f"{stem}.md", folder / f"{stem}.png")
    if quick:
        return Outputs()
    page = DOCS / f"{stem}.md" if benchmark.page else None
    return Outputs(RESULTS / f"{stem}.json", page, DOCS / f"{stem}.png")


def run(benchmark: Benchmark, words: list[str]) -> int:
    """Measure, show and write what the command line ``words`` asks for."""
    module = benchmark.load()
    options = parser_of(benchmark, module).parse_args(words[1:])
    dim = getattr(options, "dim", benchmark.dims[0])
    stem = benchmark.stem(dim)
    outputs = outputs_of(benchmark, stem, options.quick, options.out)
    with writing():
        for path in filter(None, (outputs.results, outputs.page, outputs.picture)):
            check_writable(path)  # before the work
    interrupted = False
    if options.from_results:
        results = stored_results(options.from_results, stem)
    else:
        command = shlex.join(["python", "-m", "benchmarks", *map(without_place, words)])
        job = Run(options, options.quick, dim, make_stamp(command), outputs.results, outputs.page)
        results = as_stored(measured(benchmark, module, job))
        interrupted = job.interrupted
    report = module.report(results)
    console = Console(emoji=False)  # "15:100:" is no pictogram
    show(report, console)
    with writing():
        written = write(report, results, outputs)
    for path in written:
        print(f"wrote {path}")
    if interrupted:
        kept = "the same command continues from here" if outputs.results else "this is what was measured until then"
        return failed(f"interrupted; {kept}.", INTERRUPTED)
    return OK


@contextmanager
def writing() -> Iterator[None]:
    """Turn an error of writing files into a sentence."""
    try:
        yield
    except OSError as error:
        where = f" {error.filename}" if error.filename else ""
        raise Unable(f"cannot write{where}: {error.strerror or error}") from error


def stored_results(place: Path, stem: str) -> dict[str, Any]:
    """Return the results in a file, or in the file of that name in a folder.

    Raises:
        UsageError: there is no such file, or it cannot be read.
    """
    path = place / f"{stem}.json" if place.is_dir() else place
    if not path.is_file():
        raise UsageError(f"--from-results: there is no file {path}; measure first, without this option.")
    try:
        return read_json(path)
    except (OSError, ValueError) as error:
        raise UsageError(f"--from-results: {path} cannot be read as results: {error}") from error


def measured(benchmark: Benchmark, module: Implementation, job: Run) -> dict[str, Any]:
    """Measure; return the results with their stamp."""
    from benchmarks.common.timing import pin, usable_cores
    from gsenv.solver.jit import mute_compile_notice

    mute_compile_notice()  # the progress bar says what is being done
    if benchmark.single_core:
        allowed = usable_cores()
        core = allowed[-1] if job.options.core is None else job.options.core
        if core not in allowed:
            raise UsageError(f"--core {core}: this process may use the cores {', '.join(map(str, allowed))}.")
        pin(core)
    data = module.measure(job)
    job.stamp["load"].append(load())
    return {"stamp": job.stamp, **data}
