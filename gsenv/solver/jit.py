"""The only kernel decorator of the project: compile options, on-disk cache, cold-start notice.

Kernels are compiled without parallelism, the GIL and fastmath: results must be bit-equal, and numba's
thread pool does not survive a fork.

Cache. numba keeps compiled code on disk, but it checks only the caller's own file: after an edit in a
callee of another file the cached caller runs the OLD code. So the name of a cache entry holds a digest
of the files that the kernel's file imports, directly or through others (`kernel_sources`), and the
signature, the CPU and numba's version: one entry, one file, written to a temporary name and then
renamed. An edit of a file that a kernel cannot reach leaves its entry valid. What is not there may be
in the set of precompiled kernels (`precompiled`). There is no index to update, so concurrent cold starts
cannot mix up entries; they only compile the same kernel twice. (numba's own index numbers the data files,
and two processes that compile different signatures of one kernel can both take number 1.) Files lie where
numba would put them: `$NUMBA_CACHE_DIR`, `__pycache__` beside the source, or the user's cache folder.

`NUMBA_DISABLE_JIT=1` leaves plain Python functions (for coverage and debuggers).
"""

import hashlib
import os
import pickle
import re
import sys
import threading
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar, overload

import numba
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.options import DefaultOptions
from numba.core.serialize import dumps

from . import precompiled
from .deferred_library import StaleEntryError
from .inner_kernels import KernelDispatcher, symbol_ids
from .kernel_sources import kernel_sources

_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])

_SOLVER = Path(__file__).parent

QUIET_SECONDS = 0.5
"""Compile time in s after which a process prints one line about compilation.
With a lower value a single small helper is announced, with a higher one a cold start looks like a hang."""

UNCOUNTED = {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}
"""Options of a kernel that counts no references; empty if numba's internals have changed: slower, same bits."""

_kernels: list[Any] = []
_notices_given: set[str] = set()


@overload
def njit(function: _Kernel) -> _Kernel: ...
@overload
def njit(*, forceinline: bool = False, makes_arrays: bool = False) -> Callable[[_Kernel], _Kernel]: ...
def njit(function: Any = None, *, forceinline: bool = False, makes_arrays: bool = False) -> Any:
    """Compile `function` on its first call, or load it from the cache.

    `forceinline` makes LLVM inline it into its callers; the cost of numba's front end stays the same
    (its own `inline="always"` was 10 to 70 times slower to compile). Returns numba's dispatcher
    itself: calls have no further cost, and kernels can call one another.

    The solver's kernels count no references to their array arguments, since these atomic operations took
    up to half of the time of a small world. So they cannot return arrays, and create some only with
    `makes_arrays`.
    """
    if function is None:
        return partial(njit, forceinline=forceinline, makes_arrays=makes_arrays)
    # no kernel is called through a C pointer: without that wrapper, compiling takes a sixth less time
    options = {"nogil": True, "error_model": "numpy", "forceinline": forceinline, "no_cfunc_wrapper": True}
    if _SOLVER in Path(function.__code__.co_filename).parents and not makes_arrays:
        options |= UNCOUNTED
    if numba.config.DISABLE_JIT:
        return function
    kernel = _with_cache(_dispatcher(function, options), function, options)
    _kernels.append(kernel)
    return kernel


def _dispatcher(function: Any, options: dict[str, Any]) -> Any:
    try:
        return KernelDispatcher(function, options)
    except (AttributeError, TypeError):  # numba's private parts have moved
        return numba.njit(**options)(function)


def inline_njit(function: _Kernel) -> _Kernel:
    """Compile a small helper like `njit`; LLVM inlines it into its callers."""
    return njit(forceinline=True)(function)


def entry(kernel: Any, *arguments: Any) -> Callable[..., Any]:
    """Return the compiled code of a kernel for arguments of these types.

    Calling it skips numba's check of the type of each argument, which takes 0.3 us each. Later arguments
    are not checked: they must have exactly the same types.
    """
    if not hasattr(kernel, "typeof_pyval"):  # plain Python, or a numba with other internals
        return kernel
    signature = tuple(kernel.typeof_pyval(argument) for argument in arguments)
    kernel.compile(signature)
    return kernel.overloads[signature].entry_point


def is_compiled(kernel: Any, *arguments: Any) -> bool:
    """Whether the code of a kernel for arguments of these types is loaded, in the cache or among the precompiled."""
    if not hasattr(kernel, "typeof_pyval"):  # plain Python, or a numba with other internals
        return True
    signature = tuple(kernel.typeof_pyval(argument) for argument in arguments)
    if signature in kernel.overloads:
        return True
    stored = getattr(kernel, "_cache", None)
    return isinstance(stored, _KernelCache) and stored.has(signature, kernel.targetctx.codegen())


def compiled_kernels() -> list[str]:
    """Return the names ("module.function") of the kernels that this process has compiled or loaded, sorted.

    A kernel from the cache contains its callees as machine code, and these are not listed. To compare
    what two scenes need, run each in a process with an empty `NUMBA_CACHE_DIR`.
    """
    return sorted(f"{kernel.__module__}.{kernel.__qualname__}" for kernel in _kernels if kernel.overloads)


def source_digest(sources: tuple[Path, ...]) -> str:
    """Return the hex digest of names and contents of all Python files in `sources`, files or folders.

    The content of a file is that at the time when this process first took its digest.
    """
    digest = hashlib.sha256()
    for source in sources:
        for path in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(f"{path.relative_to(source.parent).as_posix()}\0{_content_digest(path)}\0".encode())
    return digest.hexdigest()


@cache
def _content_digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


@cache
def _file_digest(file: str) -> str:
    # Taken when the kernel is imported, not at its first call: an edit in between would store old code as new.
    return source_digest(kernel_sources(Path(file)))


class _EntryFiles:
    """One file for each cache entry; stands in for numba's index with numbered data files."""

    def __init__(self, folder: str, base: str, digest: str) -> None:
        # base: "module.function-LINE.pyXY"
        self._folder = folder
        self._base = base
        self._digest = digest[:16]

    def load(self, key: Any) -> Any:
        """Return the entry stored under `key`, or that of the set of precompiled kernels, or None."""
        try:
            return _entry(self._path(key).read_bytes(), key)
        except Exception:  # missing or unreadable for any reason
            return self._load_precompiled(key)

    def has(self, key: Any) -> bool:
        """Whether there is a file of `key`, here or in the set of precompiled kernels."""
        if self._path(key).is_file():
            return True
        baseline = _baseline_key(key)
        return baseline is not None and precompiled.has(self._path(baseline).name)

    def _load_precompiled(self, key: Any) -> Any:
        key = _baseline_key(key)
        if key is None:
            return None
        try:
            data = precompiled.find(self._path(key).name)
            return None if data is None else _entry(data, key)
        except Exception:  # unreadable, or a Python without lzma: compile again
            return None

    def save(self, key: Any, data: Any) -> None:
        """Store `data` under `key`, atomically."""
        path = self._path(key)
        partial_path = path.with_name(f"{path.name}.{os.getpid()}-{threading.get_ident()}.tmp")
        try:
            partial_path.write_bytes(dumps((key, data)))
            os.replace(partial_path, path)
        finally:
            partial_path.unlink(missing_ok=True)
        self._remove_stale()

    def flush(self) -> None:
        """Drop all entries of this kernel (numba's `recompile`)."""
        for path in self._siblings():
            path.unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        config = numba.config
        code_settings = (config.OPT, config.BOUNDSCHECK, config.LOOP_VECTORIZE, config.SLP_VECTORIZE)
        name = hashlib.sha256(repr((numba.__version__, code_settings, key)).encode()).hexdigest()
        kind = "nbi" if key[-1] else "nbc"  # inner kernels, and those that Python calls
        return Path(self._folder) / f"{self._base}.{self._digest}.{name[:24]}.{kind}"

    def _siblings(self) -> list[Path]:
        # A kernel's line changes with edits above it, so its stale files are found by any line.
        name, _, python = self._base.rpartition(".")
        function = name.rpartition("-")[0]
        pattern = re.compile(rf"{re.escape(function)}-\d+\.{re.escape(python)}\.[0-9a-f]{{16}}\.[0-9a-f]{{24}}\.nb[ci]")
        return [path for path in Path(self._folder).iterdir() if pattern.fullmatch(path.name)]

    def _remove_stale(self) -> None:
        for path in self._siblings():
            if f".{self._digest}." not in path.name:
                path.unlink(missing_ok=True)


def _baseline_key(key: Any) -> Any:
    """Return the key of the same kernel, for the baseline CPU; None if it cannot be precompiled."""
    signature, target, codes, inner = key
    if inner or precompiled.machine() not in precompiled.BASELINES:
        return None
    return (signature, precompiled.baseline_target(target), codes, inner)


def _entry(data: bytes, key: Any) -> Any:
    """Return what a file holds under `key`.

    Raises:
        LookupError: it holds something else; others where the file is broken.
    """
    stored_key, entry = pickle.loads(data)
    if stored_key != key:
        raise LookupError(key)
    return entry


class _KernelCache(FunctionCache):
    """numba's cache of a function, stored in `_EntryFiles`.

    Raises RuntimeError (from numba) where no folder is writable, AttributeError where numba's
    internals have changed.
    """

    def __init__(self, kernel: Any, function: Callable[..., Any], digest: str) -> None:
        super().__init__(function)
        self._kernel = kernel
        if not hasattr(self, "_cache_file"):
            raise AttributeError("numba's FunctionCache has no _cache_file")
        self._cache_file = _EntryFiles(self._cache_path, self._impl.filename_base, digest)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """Return numba's key, and whether the entry has no wrapper for Python."""
        return (*super()._index_key(sig, codegen), getattr(self._kernel, "inner", False))

    def has(self, sig: Any, codegen: Any) -> bool:
        """Whether the code for a signature is stored; where it is stale, it is compiled all the same."""
        return self._cache_file.has(self._index_key(sig, codegen))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except StaleEntryError:  # compile again
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:  # a full disk, or a folder that is gone: the compiled code is valid
            _say_uncached(str(error))


def _with_cache(kernel: Any, function: Callable[..., Any], options: dict[str, Any]) -> Any:
    file = function.__code__.co_filename
    if not os.path.isfile(file):  # typed into a prompt or a notebook: no source to take a digest of
        return kernel
    digest = _file_digest(file)
    if "<" not in function.__qualname__:  # not in another function: the name and the line tell it from all others
        symbol_ids[function] = int(f"{digest[:12]}{function.__code__.co_firstlineno:06x}", 16)
    try:
        kernel._cache = _KernelCache(kernel, function, digest)  # what numba's own cache=True does
    except AttributeError:
        return _with_cache_folder(function, options, digest)
    except RuntimeError:
        _say_uncached("no folder is writable")
    return kernel


def _with_cache_folder(function: Callable[..., Any], options: dict[str, Any], digest: str) -> Any:
    """Use numba's own cache, one folder for each digest, where numba's internals have changed."""
    given = numba.config.CACHE_DIR
    folder = Path(given or Path.home() / ".cache" / "gsenv") / digest[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _say_uncached(str(error))
        return numba.njit(**options)(function)
    numba.config.CACHE_DIR = str(folder)
    try:
        return numba.njit(cache=True, **options)(function)
    finally:
        numba.config.CACHE_DIR = given


def _say_uncached(reason: str) -> None:
    say_once(
        "uncached",
        f"gsenv: compiled kernels cannot be kept ({reason}), so every process compiles them anew; "
        "set NUMBA_CACHE_DIR to a writable folder",
    )


def say_once(topic: str, line: str) -> None:
    """Print a line to stderr, the first of its topic in this process."""
    if topic not in _notices_given:
        _notices_given.add(topic)
        if sys.stderr is not None:  # None in a windowed process
            print(line, file=sys.stderr, flush=True)


def mute_compile_notice() -> None:
    """Print no cold-start line in this process from now on, for callers that show progress themselves."""
    _notices_given.add("compile")


class _CompileNotice(event.Listener):
    """Prints one line when compiling this project's kernels takes long.

    It receives events of compilations only, not of calls or loads from the cache, so it costs a warm process
    nothing. The compilation of a kernel contains that of its callees; the time of the outermost counts.
    Events arrive under numba's compiler lock, one thread at a time.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._began = 0.0
        self._spent = 0.0

    def on_start(self, event: Any) -> None:
        if self._depth == 0:
            if not any(kernel is event.data["dispatcher"] for kernel in _kernels):
                return  # a kernel of the user
            self._began = perf_counter()
        self._depth += 1
        self._say_when_slow(perf_counter() - self._began)

    def on_end(self, event: Any) -> None:
        if self._depth == 0:
            return
        elapsed = perf_counter() - self._began
        self._say_when_slow(elapsed)
        self._depth -= 1
        if self._depth == 0:
            self._spent += elapsed

    def _say_when_slow(self, elapsed: float) -> None:
        if self._spent + elapsed >= QUIET_SECONDS:
            say_once(
                "compile",
                f"gsenv: compiling kernels, a minute or more, once: {precompiled.why_not()} "
                "(run `gsenv warmup` to do it ahead of time)",
            )


event.register("numba:compile", _CompileNotice())
