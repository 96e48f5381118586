"""Files are written whole or not at all: full disks, signals, links, permissions."""

from __future__ import annotations

import errno
import functools
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gsenv.envs.core.mlp import MlpPolicy
from gsenv.files import check_writable, replacing, replacing_all, terminable, write_bytes, write_text
from gsenv.train.files import write_json, write_rows

posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals, limits and links")


def policy(value: float = 0.0) -> MlpPolicy:
    one = np.full(1, value, np.float32)
    return MlpPolicy(one, one + 1.0, ((np.full((1, 1), value, np.float32), one),))


WRITERS: dict[str, Callable[[Path], None]] = {
    "text": lambda path: write_text(path, "new" * 999),
    "bytes": lambda path: write_bytes(path, b"new" * 999),
    "json": lambda path: write_json(path, list(range(999))),
    "csv": lambda path: write_rows(path, [{"steps": k} for k in range(999)]),
    "npz": lambda path: policy().save(path),
}


def entries(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("writer", WRITERS)
def test_a_full_disk_leaves_the_old_file(writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")

    def full(number: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left on device") as error:
        WRITERS[writer](path)
    assert error.value.filename == str(path)
    assert path.read_text() == "old"
    assert entries(tmp_path) == ["file.txt"]


LIMITED = """
import resource, sys
from gsenv.files import write_text
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
try:
    write_text(sys.argv[1], "new" * 9999)
except OSError as error:
    print(error)
"""


@posix
def test_a_write_that_stops_in_the_middle_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")
    done = subprocess.run([sys.executable, "-c", LIMITED, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout == f"[Errno {errno.EFBIG}] File too large: {str(path)!r}\n"
    assert path.read_text() == "old"
    assert entries(tmp_path) == ["file.txt"]


TERMINATED = """
import sys, time
from gsenv.files import replacing
with replacing(sys.argv[1]) as partial:
    partial.write_text("half")
    print("ready", flush=True)
    time.sleep(60)
"""


@posix
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_signal_in_the_middle_leaves_the_old_file_and_nothing_else(name: str, tmp_path: Path) -> None:
    number = getattr(signal, name)
    path = tmp_path / "file.txt"
    path.write_text("old")
    heard = functools.partial(signal.signal, number, signal.SIG_DFL)  # nohup, which runs the tests perhaps, ignores one
    process = subprocess.Popen([sys.executable, "-c", TERMINATED, str(path)], stdout=subprocess.PIPE, preexec_fn=heard)
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    assert len(entries(tmp_path)) == 2
    process.send_signal(number)
    process.communicate(timeout=30)
    assert process.returncode == 128 + number
    assert path.read_text() == "old"
    assert entries(tmp_path) == ["file.txt"]


BETWEEN = """
import os, signal, sys
from gsenv.files import replacing_all
replace = os.replace
def replace_and_end(*paths):
    replace(*paths)
    os.kill(os.getpid(), int(sys.argv[3]))
os.replace = replace_and_end
with replacing_all(sys.argv[1:3]) as partials:
    for partial in partials:
        partial.write_text("new")
"""


@posix
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_files_that_are_replaced_together_are_of_one_time(name: str, tmp_path: Path) -> None:
    """A signal between the first and the last waits; if it did not, the second file would be the old one."""
    number = getattr(signal, name)
    paths = [tmp_path / "weights.txt", tmp_path / "statistics.txt"]
    for path in paths:
        path.write_text("old")
    heard = functools.partial(signal.signal, number, signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL)
    command = [sys.executable, "-c", BETWEEN, *map(str, paths), str(int(number))]
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=heard, timeout=60)
    assert done.returncode in (128 + number, -number)
    assert [path.read_text() for path in paths] == ["new", "new"]
    assert entries(tmp_path) == ["statistics.txt", "weights.txt"]


def test_the_file_that_a_full_disk_ends_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = [tmp_path / "first.txt", tmp_path / "second.txt"]
    left = [0, errno.ENOSPC]

    def full(number: int) -> None:
        if error := left.pop(0):
            raise OSError(error, os.strerror(error))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left") as error, replacing_all(paths) as (first, second):
        _ = first.write_text("new"), second.write_text("new")
    assert error.value.filename == str(paths[1])
    assert entries(tmp_path) == []


@posix
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_programs_own_handler_of_a_signal_stays(name: str) -> None:
    number, heard = getattr(signal, name), []
    before = signal.signal(number, lambda number, frame: heard.append(number))
    try:
        with terminable():
            os.kill(os.getpid(), number)
        signal.signal(number, signal.SIG_DFL)
        with terminable():
            assert signal.getsignal(number) is not signal.SIG_DFL
        assert signal.getsignal(number) is signal.SIG_DFL
    finally:
        signal.signal(number, before)
    assert heard == [number]


@posix
def test_links_and_permissions_stay(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "file.txt", tmp_path / "link.txt"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert target.stat().st_mode & 0o777 == 0o640


def test_missing_folders_are_made(tmp_path: Path) -> None:
    write_text(tmp_path / "a" / "b.txt", "ä\n")
    assert (tmp_path / "a" / "b.txt").read_bytes() == "ä\n".encode()


@posix
def test_a_device_or_a_folder_is_never_replaced(tmp_path: Path) -> None:
    fifo = tmp_path / "pipe.txt"
    os.mkfifo(fifo)
    with pytest.raises(OSError, match="is not a regular file"):
        write_text(fifo, "new")
    with pytest.raises(IsADirectoryError, match="is a folder"):
        write_text(tmp_path, "new")
    assert fifo.is_fifo()
    assert entries(tmp_path) == ["pipe.txt"]


def test_what_cannot_be_written_is_known_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file.txt").write_text("old")
    assert check_writable(tmp_path / "a" / "b" / "new.txt") == (tmp_path / "a" / "b" / "new.txt").resolve()
    check_writable(tmp_path / "file.txt")
    with pytest.raises(NotADirectoryError, match=r"file\.txt is no folder"):
        check_writable(tmp_path / "file.txt" / "a" / "new.txt")
    with pytest.raises(IsADirectoryError, match="is a folder"):
        check_writable(tmp_path)
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere
    with pytest.raises(PermissionError, match="cannot be written to"):
        check_writable(tmp_path / "a" / "new.txt")
    assert entries(tmp_path) == ["file.txt"]


def test_a_block_that_writes_nothing_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    path.write_text("old")

    def write_nothing() -> None:
        with replacing(path):
            pass

    with pytest.raises(FileNotFoundError, match=r"file\.txt"):
        write_nothing()
    assert path.read_text() == "old"


def test_nested_writers_of_one_file_do_not_meet(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    with replacing(path) as outer:
        outer.write_text("outer")
        write_text(path, "inner")
        assert path.read_text() == "inner"
    assert path.read_text() == "outer"
    assert entries(tmp_path) == ["file.txt"]
