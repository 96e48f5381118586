"""VideoWriter: streams frames to an MP4 or GIF file in constant memory.

Frames go to a temporary file in a hidden folder beside the target. When the writer is closed, the video is read back,
and replaces the target if it is whole. Leaving the `with` block early, also by Ctrl-C, keeps the frames written so
far; after a full disk, SIGTERM or SIGHUP, or where Ctrl-C interrupts the closing, the target is as it was.
"""

import errno
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from numbers import Real
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from gsenv.files import check_writable, checked_target, replace, terminable

SUFFIXES = (".mp4", ".gif")
GIF_MAX_FPS = 50.0  # viewers show a frame for at least 0.02 s
FPS_RANGE = (0.01, 1000.0)  # ffmpeg cannot write all others

_MP4 = (
    "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-preset", "veryfast", "-movflags", "+faststart",
)  # fmt: skip
# A GIF's palette depends on all frames; they are kept in a lossless file, not in memory.
_LOSSLESS = ("-c:v", "libx264rgb", "-qp", "0", "-preset", "ultrafast")
_PALETTE = "palettegen=stats_mode=diff"
_USE_PALETTE = "paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle"


class VideoWriter:
    """Context manager; `write` takes (height, width, 3) uint8 frames of one size.

    path: ends in .mp4 (even sizes only) or .gif; `close` replaces an existing file
    fps: frames per second, 0.01 to 1000, at most 50 in a GIF
    is_written: whether the file is complete and in its place

    A missing folder is made with the first frame. Raises ValueError for a wrong file name extension, rate or frame,
    and OSError if the folder is not writable, the disk is full or the encoder fails; the target is then as it was.
    """

    def __init__(self, path: str | os.PathLike[str], fps: float) -> None:
        self.path = Path(path)
        self.fps = _checked_fps(fps)
        self.frame_count = 0
        self.is_written = False
        self._suffix = self.path.suffix.lower()
        self._shape: tuple[int, ...] | None = None
        self._encoder: _Encoder | None = None
        self._folder = Path()  # of temporary files, while there is an encoder
        self._cleanup = ExitStack()
        self._closed = False
        self._check_target()

    def write(self, frame: NDArray[np.uint8]) -> None:
        """Append one frame."""
        if self._closed:
            raise ValueError(f"The video {self.path} is closed.")
        self._check_frame(frame)
        self._shape = frame.shape
        if self._encoder is None:
            with _interrupts_blocked():
                self._encoder = self._open(frame.shape[1], frame.shape[0])
                self._append(self._encoder, frame)
        else:
            self._append(self._encoder, frame)
        self.frame_count += 1

    def close(self) -> None:
        """Finish the file; no file is made if no frame was written. A second call does nothing.

        Raises:
            OSError: the video could not be written; an old file is as it was.
        """
        if self._closed:
            return
        self._closed = True
        with self._cleanup:
            if self._encoder is not None and self.frame_count:
                self._encoder.finish()
                result = self._finished(self._folder)
                _run_ffmpeg("-xerror", "-i", result, "-f", "null", "-")  # reads all of it
                replace(result, checked_target(self.path))
                self.is_written = True

    def discard(self) -> None:
        """Close the writer without a file; an old one is as it was."""
        self._closed = True
        self._cleanup.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if isinstance(error, SystemExit):
            self.discard()
        else:
            self.close()

    def _append(self, encoder: "_Encoder", frame: NDArray[np.uint8]) -> None:
        try:
            encoder.append(np.ascontiguousarray(frame))
        except OSError:
            self.discard()
            raise

    def _check_target(self) -> None:
        if self._suffix not in SUFFIXES:
            raise ValueError(f"A video must end in .mp4 or .gif, got {self.path.name!r}.")
        if self._suffix == ".gif" and self.fps > GIF_MAX_FPS:
            raise ValueError(f"A GIF shows at most {GIF_MAX_FPS:g} fps, got {self.fps:g}.")
        check_writable(self.path)

    def _check_frame(self, frame: NDArray[np.uint8]) -> None:
        array = np.asanyarray(frame)
        if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] != 3 or not array.size:
            raise ValueError(f"A frame must be a uint8 array (height, width, 3), got {array.dtype} {array.shape}.")
        if self._shape is not None and array.shape != self._shape:
            raise ValueError(f"Frames must keep their shape {self._shape}, got {array.shape}.")
        if self._suffix == ".mp4" and (array.shape[0] % 2 or array.shape[1] % 2):
            raise ValueError(f"MP4 needs even sizes, got {array.shape[1]} x {array.shape[0]} pixels.")

    def _open(self, width: int, height: int) -> "_Encoder":
        self._cleanup.enter_context(terminable())
        target = checked_target(self.path)
        target.parent.mkdir(parents=True, exist_ok=True)
        self._folder = Path(tempfile.mkdtemp(prefix=f".{target.stem[:100]}-", dir=target.parent))
        self._cleanup.callback(shutil.rmtree, self._folder, ignore_errors=True)
        name, codec = ("frames.mp4", _MP4) if self._suffix == ".mp4" else ("frames.mkv", _LOSSLESS)
        encoder = _Encoder(self._folder / name, width, height, self.fps, codec)
        self._cleanup.callback(encoder.stop)  # before the folder is removed
        return encoder

    def _finished(self, folder: Path) -> Path:
        """Return the path of the final file, which for a GIF is made from the lossless one."""
        if self._suffix == ".mp4":
            return folder / "frames.mp4"
        frames, palette, result = (folder / name for name in ("frames.mkv", "p.png", "o.gif"))
        _run_ffmpeg("-i", frames, "-vf", _PALETTE, "-update", "1", palette)
        _run_ffmpeg("-i", frames, "-i", palette, "-lavfi", _USE_PALETTE, "-loop", "0", result)
        return result


def _checked_fps(fps: Any) -> float:
    least, most = FPS_RANGE
    if isinstance(fps, bool) or not isinstance(fps, Real) or not least <= float(fps) <= most:
        raise ValueError(f"fps must be a number from {least:g} to {most:g}, got {fps!r}.")
    return float(fps)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block SIGINT until the block is left, also for encoders that are started inside.

    Child processes inherit the signal mask. Without it, Ctrl-C would kill an encoder that has just
    started (imageio_ffmpeg also runs one to find it), and its frames would be lost.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Encoder:
    """An ffmpeg process that reads raw frames from its standard input."""

    def __init__(self, target: Path, width: int, height: int, fps: float, codec: tuple[str, ...]) -> None:
        raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps}")
        self._process = subprocess.Popen(
            _ffmpeg_command(*raw, "-i", "-", *codec, target),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C in the terminal must not end it before the last frame
        )

    def append(self, frame: NDArray[np.uint8]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(frame.data)
        except OSError as error:  # it has ended
            self.finish()
            raise OSError("ffmpeg ended early") from error

    def finish(self) -> None:
        """Wait until the file is complete; raises OSError where it is not."""
        try:
            _, message = self._process.communicate()
        except BrokenPipeError:
            message = self._process.stderr.read() if self._process.stderr else b""
            self._process.wait()
        _check(self._process.returncode, message)

    def stop(self) -> None:
        """End the process if it still runs."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stderr):
            if pipe is not None:
                with suppress(OSError):  # frames that it has not read
                    pipe.close()


def _ffmpeg_command(*arguments: object) -> list[str]:
    words = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", *arguments]
    return [str(word) for word in words]


def _run_ffmpeg(*arguments: object) -> None:
    command = _ffmpeg_command("-nostdin", *arguments)
    done = subprocess.run(command, capture_output=True, start_new_session=True, check=False)
    _check(done.returncode, done.stderr)


def _check(code: int, message: bytes) -> None:
    """Raise OSError with the cause if ffmpeg has failed or has complained."""
    lines = message.decode(errors="replace").split("\n")
    for number in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        if any(os.strerror(number) in line for line in lines):
            raise OSError(number, os.strerror(number))
    if code and -code == getattr(signal, "SIGXFSZ", None):  # a limit of this process on the sizes of files
        raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
    if code:
        told = [line.strip() for line in lines if line.strip()]
        ended = f"it was ended by {_signal_name(-code)}" if code < 0 else f"exit code {code}"
        raise OSError(f"ffmpeg failed: {told[-1] if told else ended}")


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # one that this system does not name
        return f"signal {number}"
