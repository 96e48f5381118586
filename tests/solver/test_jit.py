"""The kernel decorator: what reaches the cache, what leaves it, what the user is told."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numba
import pytest
from numba.core.caching import FunctionCache
from numba.core.registry import CPUDispatcher

from gsenv.solver import jit
from gsenv.solver.jit import inline_njit, njit

CALLEE = "from gsenv.solver.jit import inline_njit\n\n@inline_njit\ndef callee(x):\n    return x + {}\n"
CALLER = """
from gsenv.solver.callee import callee
from gsenv.solver.jit import njit

@njit
def caller(x):
    return 10 * callee(x)
"""
RUN = """
import sys
from gsenv.solver import jit
jit.QUIET_SECONDS = {quiet}
from gsenv.solver.caller import caller
print(*[caller(eval(argument)) for argument in sys.argv[1:]])
print(*jit.compiled_kernels())
"""

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package gsenv with this jit.py, a caller and its callee in another file; returns its folder."""
    solver = tmp_path / "gsenv" / "solver"
    solver.mkdir(parents=True)
    (solver.parent / "__init__.py").touch()
    (solver / "__init__.py").touch()
    (solver / "jit.py").write_bytes(Path(jit.__file__).read_bytes())
    (solver / "callee.py").write_text(CALLEE.format(1))
    (solver / "caller.py").write_text(CALLER)
    return tmp_path


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
    return sorted(path.name for path in (package / "gsenv/solver/__pycache__").glob("*.nbc"))


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
    assert len(digests) == 2


def test_numba_still_has_the_private_parts_that_the_cache_uses() -> None:
    def function(x: float) -> float:
        return x

    dispatcher = numba.njit(cache=True)(function)
    assert type(dispatcher._cache) is FunctionCache
    stock = FunctionCache(function)
    assert stock._impl.filename_base.split(".")[-1].startswith("py3")
    assert Path(stock._cache_path).is_dir()
    assert {"load", "save", "flush"} <= set(dir(stock._cache_file))
    kernel = njit(function)
    assert isinstance(kernel._cache._cache_file, jit._EntryFiles)  # type: ignore[attr-defined]


def test_failing_save_is_reported_and_the_call_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(self: object, key: object, data: object) -> None:
        raise OSError(28, "No space left on device")

    @njit
    def increment(x: int) -> int:
        return x + 1

    monkeypatch.setattr(jit, "_notices_given", {"compile"})
    monkeypatch.setattr(jit._EntryFiles, "load", lambda self, key: None)
    monkeypatch.setattr(jit._EntryFiles, "save", fail)
    assert increment(1) == 2
    assert "No space left on device" in capsys.readouterr().err


def test_kernel_is_the_raw_dispatcher_so_calls_cost_nothing_extra() -> None:
    @njit
    def kernel(x: float) -> float:
        return x

    assert type(kernel) is CPUDispatcher


def test_recompile_drops_the_entries(package: Path) -> None:
    code = "from gsenv.solver.caller import caller; caller(1); caller._cache.flush()"
    subprocess.run([sys.executable, "-c", code], cwd=package, check=True, timeout=120)
    assert [name.split("-")[0] for name in entries(package)] == ["callee.callee"]


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("solver/planar/step.py", ["solver"]),
        ("render/canvas.py", ["solver", "scenes", "render"]),
        ("envs/stack.py", ["solver", "scenes", "render", "envs"]),
    ],
)
def test_sources_of_a_kernel_are_all_that_it_can_call(file: str, expected: list[str]) -> None:
    package = Path(jit.__file__).parent.parent
    sources = jit.kernel_sources(package / file)
    assert sorted(path.name for path in sources) == sorted(expected)


def test_sources_of_a_users_kernel_hold_its_own_file(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    assert jit.kernel_sources(script)[-1] == script
    module = tmp_path / "project" / "rules" / "magnet.py"
    module.parent.mkdir(parents=True)
    (module.parent / "__init__.py").touch()
    (module.parent.parent / "__init__.py").touch()
    assert jit.kernel_sources(module)[-1] == tmp_path / "project"


def test_digest_sees_contents_and_names(tmp_path: Path) -> None:
    def digest() -> str:
        return jit.source_digest((tmp_path,))

    (tmp_path / "a.py").write_text("x = 1")
    first = digest()
    (tmp_path / "notes.txt").write_text("not a source")
    assert digest() == first
    (tmp_path / "a.py").write_text("x = 2")
    assert digest() != first
    (tmp_path / "a.py").write_text("x = 1")
    (tmp_path / "a.py").rename(tmp_path / "b.py")
    assert digest() != first


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
