"""The kernel decorator: what reaches the cache, what leaves it, what the user is told."""

import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.caching import FunctionCache
from numba.core.registry import CPUDispatcher

from gsenv.solver import deferred_library, inner_kernels, jit
from gsenv.solver.jit import inline_njit, njit
from tests.solver.mini_package import CALLEE, CALLER, entries, make_package, run, start


@pytest.fixture
def package(tmp_path: Path) -> Path:
    return make_package(tmp_path)


def test_edit_in_a_callee_of_another_file_reaches_the_cached_caller(package: Path) -> None:
    both = "gsenv.solver.callee.callee gsenv.solver.caller.caller"
    assert run(package, "1")[:2] == ("20", both)
    first = entries(package)
    assert run(package, "1")[:2] == ("20", "gsenv.solver.caller.caller")  # loaded, its callee within
    (package / "gsenv/solver/callee.py").write_text(CALLEE.format(2))  # the same length
    assert run(package, "1")[:2] == ("30", both)
    (package / "gsenv/solver/callee.py").write_text("\n" + CALLEE.format(3))
    assert run(package, "1")[:2] == ("40", both)
    # The stale entries are gone, although the callee moved to another line.
    assert len(entries(package)) == len(first) == 2
    assert not set(entries(package)) & set(first)


def test_edit_of_a_constant_behind_the_callee_reaches_the_cached_caller(package: Path) -> None:
    assert run(package, "1")[0] == "20"
    (package / "gsenv/solver/constants.py").write_text("FACTOR = 2\n")
    assert run(package, "1")[0] == "30"


def test_edit_of_files_that_a_kernel_does_not_import_recompiles_nothing(package: Path) -> None:
    run(package, "1")
    first = entries(package)
    for name in ("scene.py", "__init__.py"):
        source = package / "gsenv/solver" / name
        source.write_text(source.read_text() + "\nEDITED = True\n")
    (package / "gsenv/solver/new.py").write_text("from .caller import caller\n")
    assert run(package, "1")[:2] == ("20", "gsenv.solver.caller.caller")  # loaded
    assert entries(package) == first


def test_edit_between_import_and_first_call_stores_no_old_code_as_new(package: Path) -> None:
    edit = f"open('gsenv/solver/callee.py', 'w').write({CALLEE.format(2)!r})"
    code = f"from gsenv.solver.caller import caller; {edit}; print(caller(1))"
    command = [sys.executable, "-c", code]
    process = subprocess.run(command, cwd=package, check=True, capture_output=True, text=True, timeout=120)
    assert process.stdout == "20\n"
    assert run(package, "1")[0] == "30"


def test_kernel_typed_at_a_prompt_runs_uncached() -> None:
    names: dict[str, Any] = {"njit": njit}
    exec(compile("@njit\ndef increment(x): return x + 1\n", "<prompt>", "exec"), names)
    assert names["increment"](1) == 2


def test_cold_start_says_so_once_and_a_warm_one_says_nothing(package: Path) -> None:
    _, _, err = run(package, "1", "2.0", quiet=0.0)  # two signatures: two compilations
    assert err.count("\n") == 1
    assert "compiling kernels" in err
    assert "gsenv warmup" in err
    assert run(package, "1", "2.0", quiet=0.0)[2] == ""


def test_short_compilations_stay_silent(package: Path) -> None:
    assert run(package, "1", quiet=60.0)[2] == ""


def test_where_no_folder_is_writable_it_says_so_once_and_goes_on(package: Path) -> None:
    # Files in the place of folders: that stops root too.
    blocked = package / "blocked"
    blocked.touch()
    (package / "gsenv/solver/__pycache__").touch()
    nowhere = str(blocked / "cache")
    result, _, err = run(package, "1", HOME=nowhere, XDG_CACHE_HOME=nowhere, LOCALAPPDATA=nowhere)
    assert result == "20"
    assert err.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in err


def test_cold_starts_side_by_side_do_not_mix_up_entries(package: Path) -> None:
    processes = [start(package, argument) for argument in ("1", "2.0", "1j", "1")]
    results = [process.communicate(timeout=120)[0].splitlines()[0] for process in processes]
    assert results == ["20", "30.0", "(10+10j)", "20"]
    result, kernels, _ = run(package, "1", "2.0", "1j")
    assert result == "20 30.0 (10+10j)"
    assert kernels == "gsenv.solver.caller.caller"  # all three were loaded


def test_damaged_entry_is_compiled_again(package: Path) -> None:
    run(package, "1")
    for name in entries(package):
        (package / "gsenv/solver/__pycache__" / name).write_bytes(b"\x80\x05half an entry")
    assert run(package, "1")[0] == "20"
    assert run(package, "1")[1] == "gsenv.solver.caller.caller"


def test_disabled_jit_leaves_plain_functions(package: Path) -> None:
    assert run(package, "1", NUMBA_DISABLE_JIT="1") == ("20", "", "")
    assert entries(package) == []


def test_other_numba_falls_back_to_a_folder_for_each_digest(package: Path) -> None:
    # A FunctionCache without the private part, as a later numba might have it.
    without = (
        "from numba.core import caching\n"
        "class Other(caching.FunctionCache):\n"
        "    def __init__(self, function):\n"
        "        super().__init__(function)\n"
        "        del self._cache_file\n"
    )
    source = package / "gsenv/solver/jit.py"
    text = source.read_text()
    source.write_text(text.replace("from numba.core.caching import FunctionCache", without + "FunctionCache = Other"))
    assert source.read_text() != text
    cache = package / "cache"
    assert run(package, "1", NUMBA_CACHE_DIR=str(cache))[0] == "20"
    assert run(package, "1", NUMBA_CACHE_DIR=str(cache))[:2] == ("20", "gsenv.solver.caller.caller")
    (package / "gsenv/solver/callee.py").write_text(CALLEE.format(2))
    assert run(package, "1", NUMBA_CACHE_DIR=str(cache))[0] == "30"
    digests = [folder.name for folder in cache.iterdir() if re.fullmatch("[0-9a-f]{16}", folder.name)]
    assert len(digests) == 4  # of two files, each before and after


def test_numba_still_has_the_private_parts_that_the_cache_uses() -> None:
    def function(x: float) -> float:
        return x

    dispatcher = numba.njit(cache=True)(function)
    assert type(dispatcher._cache) is FunctionCache
    stock = FunctionCache(function)
    assert stock._impl.filename_base.split(".")[-1].startswith("py3")
    assert Path(stock._cache_path).is_dir()
    assert {"load", "save", "flush"} <= set(dir(stock._cache_file))
    kernel: Any = njit(function)
    assert type(kernel._cache._cache_file).__module__ == jit.__name__
    engine = kernel.targetctx.codegen()._engine
    assert isinstance(engine._defined_symbols, set)
    assert engine.is_symbol_defined(next(iter(engine._defined_symbols)))


def test_failing_save_is_reported_and_the_call_goes_on(package: Path) -> None:
    code = (
        "from pathlib import Path\n"
        "def fail(path, data):\n"
        "    raise OSError(28, 'No space left on device')\n"
        "Path.write_bytes = fail\n"
        "from gsenv.solver.caller import caller\n"
        "print(caller(1))\n"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=package, check=True, capture_output=True, text=True, timeout=120)
    assert done.stdout == "20\n"
    assert done.stderr.count("No space left on device") == 1
    assert entries(package) == []


def test_kernel_is_the_raw_dispatcher_so_calls_cost_nothing_extra() -> None:
    @njit
    def kernel(x: float) -> float:
        return x

    assert type(kernel) is inner_kernels.KernelDispatcher
    assert type(kernel).__call__ is CPUDispatcher.__call__  # numba's, in C


def test_recompile_drops_the_entries(package: Path) -> None:
    code = "from gsenv.solver.caller import caller; caller(1); caller._cache.flush()"
    subprocess.run([sys.executable, "-c", code], cwd=package, check=True, timeout=120)
    assert [name.split("-")[0] for name in entries(package)] == ["callee.callee"]


def test_digest_sees_contents_and_names(tmp_path: Path) -> None:
    def digest(folder: str, **files: str) -> str:
        (tmp_path / folder / "source").mkdir(parents=True)
        for name, text in files.items():
            (tmp_path / folder / "source" / name.replace("_", ".")).write_text(text)
        return jit.source_digest((tmp_path / folder / "source",))

    first = digest("first", a_py="x = 1")
    assert digest("with notes", a_py="x = 1", notes_txt="not a source") == first
    assert digest("edited", a_py="x = 2") != first
    assert digest("renamed", b_py="x = 1") != first


@pytest.mark.nojit
def test_kernels_call_one_another_with_and_without_compiler() -> None:
    @inline_njit
    def double(x: int) -> int:
        return 2 * x

    @njit
    def double_twice(x: int) -> int:
        return double(double(x))

    assert double_twice(3) == 12
    assert callable(getattr(double_twice, "py_func", double_twice))


def test_only_what_python_calls_becomes_machine_code() -> None:
    @njit
    def callee(x: float) -> float:
        return x * 2.0

    @njit
    def caller(x: float) -> float:
        return callee(x) + 1.0

    assert caller(1.0) == 3.0
    inner: Any = callee
    ((_, callee_code),) = inner.overloads.items()
    assert not callee_code.library._finalized
    assert callee_code.library.get_pointer_to_function(callee_code.fndesc.llvm_func_name + "x") == 0
    assert callee(1.0) == 2.0
    assert inner.overloads[inner.signatures[0]].library._finalized


def test_callers_are_linked_before_their_callees() -> None:
    """The linker drops what nothing linked so far calls."""

    def library(*callees: Any) -> Any:
        made = object.__new__(deferred_library.DeferredLibrary)
        made._finalized, made._linking_libraries = False, list(callees)
        return made

    leaf = library()
    middle = library(leaf)
    outer = library(leaf, middle)
    assert library(leaf, outer, middle)._callees() == [outer, middle, leaf]


def test_code_of_a_callee_is_reused_by_an_edited_caller(package: Path) -> None:
    assert run(package, "1")[0] == "20"
    before = {name: (package / "gsenv/solver/__pycache__" / name).stat().st_mtime_ns for name in entries(package)}
    caller = package / "gsenv/solver/caller.py"
    caller.write_text(caller.read_text().replace("10 *", "100 *"))
    assert run(package, "1")[0] == "200"
    (kept,) = [name for name in entries(package) if before.get(name) is not None]
    assert kept.startswith("callee.callee")
    assert (package / "gsenv/solver/__pycache__" / kept).stat().st_mtime_ns == before[kept]


TOP = """
from .caller import caller
from .jit import njit

@njit
def top(x):
    return caller(x) + {}
"""


def run_top(package: Path, added: int, code: str = "pass") -> str:
    """Return what a process prints that runs ``code`` and calls `top`, whose source is new for each ``added``."""
    (package / "gsenv/solver/top.py").write_text(TOP.format(added))
    command = [sys.executable, "-c", f"{code}; from gsenv.solver.top import top; print(top(1))"]
    done = subprocess.run(command, cwd=package, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()[-1]


def test_cached_callers_find_their_callees_whoever_compiled_these(package: Path) -> None:
    """A callee that one process compiled for Python and another one for kernels has one symbol."""
    assert run_top(package, 0) == "20"
    caller = package / "gsenv/solver/caller.py"
    caller.write_text(CALLER.replace("10 *", "100 *"))
    # Other functions, compiled first, take numbers that numba would give to kernels.
    others = "import numba; [numba.njit(lambda x: x)(k) for k in range(3)]"
    assert run_top(package, 1, f"{others}; from gsenv.solver.callee import callee; callee(1)") == "201"
    assert run_top(package, 2) == "202"
    assert run_top(package, 3, "from gsenv.solver.caller import caller; caller(1)") == "203"


def test_entry_that_calls_a_missing_symbol_is_compiled_again(package: Path) -> None:
    assert run_top(package, 0) == "20"
    (entry,) = [name for name in entries(package) if name.startswith("callee.callee")]
    path = package / "gsenv/solver/__pycache__" / entry
    code = path.read_bytes()
    assert code.count(b"6callee") > 1  # in the code and in its description
    path.write_bytes(code.replace(b"6callee", b"6collee"))  # as if numba made symbols in another way
    assert run_top(package, 1) == "21"


MIXED = """
import numba
from gsenv.solver.caller import caller
print(caller(1))  # machine code from the cache

@numba.njit
def function(x):
    return caller(x) + 1

print(function(1))
from gsenv.solver.top import top
print(top(1), caller(1))
from gsenv.solver.jit import entry
print(entry(caller, 1)(1))
"""


def test_cached_machine_code_is_compiled_again_for_callers_only(package: Path) -> None:
    """The entry of a kernel that Python called has no code to link into others."""
    assert run(package, "1")[0] == "20"
    (package / "gsenv/solver/top.py").write_text(TOP.format(5))
    for _ in range(2):
        command = [sys.executable, "-c", MIXED]
        done = subprocess.run(command, cwd=package, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        assert done.stdout.split() == ["20", "21", "25", "20", "20"]


def test_entry_for_python_holds_no_code_for_callers(package: Path) -> None:
    run(package, "1")
    (name,) = [name for name in entries(package) if name.endswith(".nbc")]
    data = (package / "gsenv/solver/__pycache__" / name).read_bytes()
    assert b"ELF" in data[:2000] or sys.platform != "linux"
    assert b"BC\xc0\xde" not in data  # how bitcode begins


HELPERS = """
import math

from gsenv.solver.jit import njit

def scaled_by(factor):
    @njit
    def scaled(x):
        return factor * math.gcd(x, 12)
    return scaled

twice = scaled_by(2)

@njit
def callee(x):
    if x > 100:
        raise ValueError("more than 100")
    return twice(x)
"""


def test_cached_callee_keeps_its_helpers_and_errors(package: Path) -> None:
    """A helper without an importable name, one of numba's, and an exception, loaded for a caller that was edited."""
    (package / "gsenv/solver/callee.py").write_text(HELPERS)
    caller = package / "gsenv/solver/caller.py"
    assert run(package, "8")[0] == "80"
    for factor in (20, 30):
        caller.write_text(CALLER.replace("10 *", f"{factor} *"))
        assert run(package, "8")[0] == f"{8 * factor}"
    for _ in range(2):  # compiled; from the cache
        process = start(package, "101")
        assert "ValueError: more than 100" in process.communicate(timeout=120)[1]


def test_what_a_kernel_compiled_serves_functions_of_the_user() -> None:
    @njit(makes_arrays=True)
    def total(x: Any) -> Any:
        return np.sum(x)

    @njit(makes_arrays=True)
    def kernel(x: Any) -> Any:
        return total(x) + 1.0

    @numba.njit
    def function(x: Any) -> Any:
        return np.sum(x) + total(x) + kernel(x)

    assert kernel(np.ones(3)) == 4.0
    assert function(np.ones(3)) == 10.0
    assert total(np.ones(4)) == 4.0


def test_record_does_not_stand_for_one_with_more_fields() -> None:
    """numba takes a record for any other one with the same first fields, and warns."""

    @njit
    def total(record: Any) -> Any:
        return record.x + record.y

    @njit
    def of_first(records: Any) -> Any:
        return total(records[0])

    pair = np.dtype([("x", "f8"), ("y", "f8")])
    triple = np.dtype([("x", "f8"), ("y", "f8"), ("z", "f8")])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert of_first(np.array([(1.0, 2.0)], pair)) == 3.0
        assert of_first(np.array([(3.0, 4.0, 5.0)], triple)) == 7.0
    kernel: Any = total
    assert len(kernel.overloads) == 2
