"""Files read back, atomic replacement, interrupts and errors."""

import functools
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render import video as video_module
from gsenv.render.video import FPS_RANGE, VideoWriter
from tests.processes import hear_interrupts


def frame(k: int, width: int = 84, height: int = 84) -> NDArray[np.uint8]:
    """A white square that moves to the right by 4 px a frame over a gradient."""
    image = np.empty((height, width, 3), np.uint8)
    image[...] = np.linspace(40, 120, height).astype(np.uint8)[:, None, None]
    image[10:30, 4 * k : 4 * k + 20] = 255
    return image


def read(path: Path) -> list[NDArray[np.uint8]]:
    return [np.asarray(image)[..., :3] for image in imageio.mimread(path, memtest=False)]


def entries(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["a.mp4", "a.gif", "A.MP4"])
@pytest.mark.parametrize("size", [(84, 84), (130, 66)])
def test_frames_come_back(tmp_path: Path, name: str, size: tuple[int, int]) -> None:
    path = tmp_path / name
    with VideoWriter(path, 25) as video:
        for k in range(12):
            video.write(frame(k, *size))
        assert not path.exists()
    assert entries(tmp_path) == {name}
    images = read(path)
    assert len(images) == 12
    for k, image in enumerate(images):
        assert image.shape == (size[1], size[0], 3)
        assert np.abs(image.astype(float) - frame(k, *size)).mean() < 8.0


def test_the_gif_repeats_forever_at_its_rate(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    with VideoWriter(path, 20) as video:
        for k in range(5):
            video.write(frame(k))
    data = path.read_bytes()
    assert b"NETSCAPE2.0\x03\x01\x00\x00" in data
    assert imageio.get_reader(path).get_meta_data()["duration"] == pytest.approx(50.0)


def test_the_old_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(b"old")
    with VideoWriter(path, 25) as video:
        video.write(frame(0))
        assert path.read_bytes() == b"old"
    assert len(read(path)) == 1


def write_then_fail(video: VideoWriter, error: type[BaseException]) -> None:
    for k in range(7):
        video.write(frame(k))
    raise error


@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_an_exception_keeps_the_frames_so_far(tmp_path: Path, name: str, error: type[BaseException]) -> None:
    path = tmp_path / name
    with pytest.raises(error), VideoWriter(path, 25) as video:
        write_then_fail(video, error)
    assert len(read(path)) == 7
    assert entries(tmp_path) == {name}


INTERRUPTED = """
import sys, time
import numpy as np
from gsenv.render.video import VideoWriter
with VideoWriter(sys.argv[1], 25) as video:
    for k in range(10**6):
        video.write(np.full((64, 64, 3), k % 250, np.uint8))
        if k == 30:
            print("ready", flush=True)
        time.sleep(0.002)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals to a process group")
@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
def test_ctrl_c_in_a_terminal_leaves_a_usable_file(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    command = [sys.executable, "-c", INTERRUPTED, str(path)]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=hear_interrupts,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all children as well
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert b"KeyboardInterrupt" in errors
    assert process.returncode != 0
    assert len(read(path)) > 30
    assert entries(tmp_path) == {name}


OLD = b"old"


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("ending", ["SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
def test_a_signal_leaves_the_old_file_and_nothing_else(tmp_path: Path, name: str, ending: str) -> None:
    number = getattr(signal, ending)
    path = tmp_path / name
    path.write_bytes(OLD)
    command = [sys.executable, "-c", INTERRUPTED, str(path)]
    heard = functools.partial(signal.signal, number, signal.SIG_DFL)  # nohup ignores SIGHUP
    process = subprocess.Popen(command, stdout=subprocess.PIPE, preexec_fn=heard)
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    assert len(entries(tmp_path)) == 2
    process.send_signal(number)
    process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert path.read_bytes() == OLD
    assert entries(tmp_path) == {name}


NOISE = """
import resource, sys
import numpy as np
from gsenv.render.video import VideoWriter
generator = np.random.default_rng(0)
frames = generator.integers(0, 255, (int(sys.argv[2]), 96, 96, 3), np.uint8)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]),) * 2)
try:
    with VideoWriter(sys.argv[1], 25) as video:
        for frame in frames:
            video.write(frame)
except OSError as error:
    print(error)
"""


@pytest.mark.skipif(os.name != "posix", reason="limits of file sizes")
@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
@pytest.mark.parametrize(("count", "limit"), [(4, 3_000), (200, 30_000), (200, 400_000)])
def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path: Path, name: str, count: int, limit: int) -> None:
    """While frames are written, or at the end: a limit on the size of files stands in for it."""
    path = tmp_path / name
    path.write_bytes(OLD)
    command = [sys.executable, "-c", NOISE, str(path), str(count), str(limit)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout.startswith(("ffmpeg failed: ", "[Errno")), done
    assert done.stdout.count("\n") == 1
    assert not done.stderr
    assert path.read_bytes() == OLD
    assert entries(tmp_path) == {name}


def test_a_video_that_cannot_be_read_back_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the encoder has reported success."""
    path = tmp_path / "a.mp4"
    path.write_bytes(OLD)
    finish = video_module._Encoder.finish

    def truncate(encoder: video_module._Encoder) -> None:
        finish(encoder)
        (file,) = tmp_path.glob(".a-*/frames.mp4")
        os.truncate(file, file.stat().st_size // 2)

    monkeypatch.setattr(video_module._Encoder, "finish", truncate)
    video = VideoWriter(path, 25)
    for k in range(7):
        video.write(frame(k))
    with pytest.raises(OSError, match="ffmpeg failed"):
        video.close()
    assert path.read_bytes() == OLD
    assert entries(tmp_path) == {"a.mp4"}


def test_no_frames_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.gif", 25):
        pass
    assert entries(tmp_path) == set()


def test_a_closed_writer_stays_closed(tmp_path: Path) -> None:
    video = VideoWriter(tmp_path / "a.mp4", 25)
    video.write(frame(0))
    video.close()
    video.close()
    with pytest.raises(ValueError, match="closed"):
        video.write(frame(1))
    assert len(read(tmp_path / "a.mp4")) == 1


@pytest.mark.parametrize(
    ("name", "fps", "error", "text"),
    [
        ("a.avi", 25, ValueError, "must end in .mp4 or .gif"),
        ("a", 25, ValueError, "must end in .mp4 or .gif"),
        ("a.mp4", 0, ValueError, "fps must be a number from 0.01 to 1000, got 0"),
        ("a.mp4", float("nan"), ValueError, "fps must be a number"),
        ("a.mp4", 1e30, ValueError, "fps must be a number"),
        ("a.mp4", 1e-30, ValueError, "fps must be a number"),
        ("a.mp4", True, ValueError, "fps must be a number"),
        ("a.mp4", "x", ValueError, "fps must be a number"),
        ("a.mp4", None, ValueError, "fps must be a number"),
        ("a.gif", 60, ValueError, "at most 50 fps"),
        ("file/a.mp4", 25, NotADirectoryError, "is no folder"),
        ("folder.mp4", 25, IsADirectoryError, "is a folder"),
    ],
)
def test_bad_targets(tmp_path: Path, name: str, fps: Any, error: type[Exception], text: str) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.mp4").mkdir()
    before = entries(tmp_path)
    with pytest.raises(error, match=text):
        VideoWriter(tmp_path / name, fps)
    assert entries(tmp_path) == before


@pytest.mark.parametrize("fps", [*FPS_RANGE, np.float32(12.5)])
def test_the_range_of_rates(tmp_path: Path, fps: float) -> None:
    path = tmp_path / "new" / "a.mp4"
    with VideoWriter(path, fps) as video:
        for k in range(3):
            video.write(frame(k))
        assert not video.is_written
    assert video.is_written
    assert len(read(path)) == 3


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_an_encoder_that_a_signal_has_ended_is_explained() -> None:
    with pytest.raises(OSError, match="File too large"):
        video_module._check(-signal.SIGXFSZ, b"")
    with pytest.raises(OSError, match="ended by SIGKILL"):
        video_module._check(-signal.SIGKILL, b"")


def test_a_folder_without_write_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere
    with pytest.raises(PermissionError, match="cannot be written"):
        VideoWriter(tmp_path / "a.mp4", 25)


@pytest.mark.parametrize(
    ("bad", "text"),
    [
        (np.zeros((84, 84, 3), np.float32), "uint8"),
        (np.zeros((84, 84), np.uint8), "uint8"),
        (np.zeros((84, 84, 4), np.uint8), "uint8"),
        (np.zeros((0, 84, 3), np.uint8), "uint8"),
        (np.zeros((83, 84, 3), np.uint8), "even"),
        (np.zeros((84, 85, 3), np.uint8), "even"),
    ],
)
def test_bad_frames(tmp_path: Path, bad: NDArray[np.uint8], text: str) -> None:
    with VideoWriter(tmp_path / "a.mp4", 25) as video, pytest.raises(ValueError, match=text):
        video.write(bad)
    assert entries(tmp_path) == set()


def test_a_changing_size_is_refused_and_the_rest_survives(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    with VideoWriter(path, 25) as video:
        video.write(frame(0, 85, 83))
        with pytest.raises(ValueError, match="keep their shape"):
            video.write(frame(1, 84, 84))
        video.write(frame(1, 85, 83))
    assert len(read(path)) == 2
