"""VideoWriter: streams frames to an MP4 or GIF file in constant memory.

Frames go to a temporary file in a hidden folder beside the target, which replaces the target when the
writer is closed. Leaving the `with` block early, also by Ctrl-C, keeps the frames written so far.
"""

import os
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import imageio.v2 as imageio
import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

SUFFIXES = (".mp4", ".gif")
GIF_MAX_FPS = 50.0  # viewers show a frame for at least 0.02 s

# A GIF's palette depends on all frames; they are kept in a lossless file, not in memory.
_LOSSLESS = ("-c:v", "libx264rgb", "-qp", "0", "-preset", "ultrafast")
_PALETTE = "palettegen=stats_mode=diff"
_USE_PALETTE = "paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle"


class VideoWriter:
    """Context manager; `write` takes (height, width, 3) uint8 frames of one size.

    path: ends in .mp4 (even sizes only) or .gif; `close` replaces an existing file
    fps: frames per second, at most 50 in a GIF

    Raises ValueError for a wrong file name extension, rate or frame, and OSError if the folder is missing
    or not writable; nothing has been written then.
    """

    def __init__(self, path: str | os.PathLike[str], fps: float) -> None:
        self.path = Path(path)
        self.fps = float(fps)
        self.frame_count = 0
        self._suffix = self.path.suffix.lower()
        self._shape: tuple[int, ...] | None = None
        self._sink: Any = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._closed = False
        self._check_target()

    def write(self, frame: NDArray[np.uint8]) -> None:
        """Append one frame."""
        if self._closed:
            raise ValueError(f"The video {self.path} is closed.")
        self._check_frame(frame)
        self._shape = frame.shape
        if self._sink is None:
            with _interrupts_blocked():
                self._open(frame.shape[1], frame.shape[0])
                self._append(frame)
        else:
            self._append(frame)
        self.frame_count += 1

    def close(self) -> None:
        """Finish the file; no file is made if no frame was written. A second call does nothing."""
        if self._closed:
            return
        self._closed = True
        if self._sink is None or self._folder is None:
            return
        try:
            self._sink.close()
            if self.frame_count:
                os.replace(self._finish(Path(self._folder.name)), self.path)
        finally:
            self._folder.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _append(self, frame: NDArray[np.uint8]) -> None:
        try:
            self._sink.append_data(np.ascontiguousarray(frame))
        except (OSError, RuntimeError) as error:
            raise OSError(f"Writing the video {self.path} failed: {error}") from error

    def _check_target(self) -> None:
        if self._suffix not in SUFFIXES:
            raise ValueError(f"A video must end in .mp4 or .gif, got {self.path.name!r}.")
        if not (np.isfinite(self.fps) and self.fps > 0.0):
            raise ValueError(f"fps must be positive, got {self.fps}.")
        if self._suffix == ".gif" and self.fps > GIF_MAX_FPS:
            raise ValueError(f"A GIF shows at most {GIF_MAX_FPS:g} fps, got {self.fps:g}.")
        folder = self.path.parent
        if not folder.is_dir():
            raise FileNotFoundError(f"The folder {folder} of the video does not exist.")
        if self.path.is_dir():
            raise IsADirectoryError(f"The video's path {self.path} is a folder.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(f"The folder {folder} of the video cannot be written to.")

    def _check_frame(self, frame: NDArray[np.uint8]) -> None:
        array = np.asanyarray(frame)
        if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] != 3 or not array.size:
            raise ValueError(f"A frame must be a uint8 array (height, width, 3), got {array.dtype} {array.shape}.")
        if self._shape is not None and array.shape != self._shape:
            raise ValueError(f"Frames must keep their shape {self._shape}, got {array.shape}.")
        if self._suffix == ".mp4" and (array.shape[0] % 2 or array.shape[1] % 2):
            raise ValueError(f"MP4 needs even sizes, got {array.shape[1]} x {array.shape[0]} pixels.")

    def _open(self, width: int, height: int) -> None:
        prefix = f".{self.path.stem}-"
        self._folder = tempfile.TemporaryDirectory(prefix=prefix, dir=self.path.parent)
        if self._suffix == ".mp4":
            self._sink = imageio.get_writer(
                Path(self._folder.name) / "frames.mp4",
                format="FFMPEG",
                mode="I",
                fps=self.fps,
                codec="libx264",
                quality=None,
                pixelformat="yuv420p",
                macro_block_size=2,  # the default of 16 silently resizes 84 x 84
                output_params=["-crf", "20", "-preset", "veryfast", "-movflags", "+faststart"],
            )
        else:
            target = Path(self._folder.name) / "frames.mkv"
            self._sink = _LosslessSink(target, width, height, self.fps)

    def _finish(self, folder: Path) -> Path:
        """Encode the final file and return its path."""
        if self._suffix == ".mp4":
            return folder / "frames.mp4"
        frames, palette, result = (folder / name for name in ("frames.mkv", "p.png", "o.gif"))
        _run_ffmpeg("-i", frames, "-vf", _PALETTE, "-update", "1", palette)
        _run_ffmpeg("-i", frames, "-i", palette, "-lavfi", _USE_PALETTE, "-loop", "0", result)
        return result


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block SIGINT until the block is left, also for encoders that are started inside.

    Child processes inherit the signal mask. Without it, Ctrl-C would kill an encoder that has just
    started (imageio also runs one to find it), and its frames would be lost.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _LosslessSink:
    """An ffmpeg process that reads raw frames from its standard input."""

    def __init__(self, target: Path, width: int, height: int, fps: float) -> None:
        raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps}")
        self._process = subprocess.Popen(
            _ffmpeg_command(*raw, "-i", "-", *_LOSSLESS, target),
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C in the terminal must not end it before the last frame
        )

    def append_data(self, frame: NDArray[np.uint8]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(frame.data)

    def close(self) -> None:
        _, message = self._process.communicate()
        if self._process.returncode:
            raise OSError(f"ffmpeg failed: {message.decode(errors='replace').strip()}")


def _ffmpeg_command(*arguments: object) -> list[str]:
    words = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", *arguments]
    return [str(word) for word in words]


def _run_ffmpeg(*arguments: object) -> None:
    command = _ffmpeg_command("-nostdin", *arguments)
    done = subprocess.run(command, capture_output=True, start_new_session=True, check=False)
    if done.returncode:
        raise OSError(f"ffmpeg failed: {done.stderr.decode(errors='replace').strip()}")
