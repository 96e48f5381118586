"""`gsenv record` and wrong command lines, with small stand-ins for what they run, and once with the real thing."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import imageio.v3 as iio
import numpy as np
import pytest

from gsenv import cli, scenes
from gsenv.render import video
from tests.processes import hear_interrupts

ROOT = Path(__file__).parent.parent


class CountingEnv(gymnasium.Env[Any, Any]):
    """An env whose frames show the step count and whose episodes end after `length` steps."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 (gymnasium's own form)
    observation_space = gymnasium.spaces.Box(0, 255, (1,))
    action_space = gymnasium.spaces.Box(-1, 1, (2,))

    def __init__(self, render_mode: str = "rgb_array", width: int = 64, height: int = 48, length: int = 5) -> None:
        self.render_mode = render_mode
        self.size = (height, width)
        self.length = length
        self.log: list[Any] = []

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        super().reset(seed=seed)
        self.steps = 0
        self.log.append(("reset", seed))
        return np.zeros(1, np.float32), {}

    def step(self, action: Any) -> Any:
        self.steps += 1
        self.log.append(("step", np.asarray(action).tolist()))
        return np.full(1, self.steps, np.float32), 0.0, self.steps >= self.length, False, {}

    def render(self) -> Any:
        return np.full((*self.size, 3), self.steps, np.uint8)


class ListWriter:
    """Stands in for VideoWriter: keeps the frames, and whether it was closed."""

    made: list["ListWriter"] = []  # noqa: RUF012

    def __init__(self, path: Path, fps: float) -> None:
        if Path(path).suffix not in {".mp4", ".gif"}:
            raise ValueError(f"{path} must end in .mp4 or .gif")
        self.path = path
        self.fps = fps
        self.frames: list[Any] = []
        self.closed = False
        self.is_written = False
        self.made.append(self)

    def __enter__(self) -> "ListWriter":
        return self

    def __exit__(self, *_: object) -> None:
        if not self.closed:
            self.close()

    def close(self) -> None:
        self.closed = True
        self.finish()
        self.is_written = bool(self.frames)

    def finish(self) -> None:
        """What takes a while."""

    def write(self, frame: Any) -> None:
        self.frames.append(frame)

    @property
    def frame_count(self) -> int:
        return len(self.frames)


@pytest.fixture
def env(monkeypatch: pytest.MonkeyPatch) -> CountingEnv:
    """The env that `gymnasium.make` hands to the command, under the name GStack-v0."""
    made = CountingEnv()

    def make(env_id: str, **options: Any) -> Any:
        made.__init__(**options)  # type: ignore[misc]
        made.spec = SimpleNamespace(max_episode_steps=600)  # type: ignore[assignment]
        return made

    monkeypatch.setattr(gymnasium, "make", make)
    return made


@pytest.fixture
def writer(monkeypatch: pytest.MonkeyPatch) -> Callable[[], ListWriter]:
    """Replaces the video writer; call it for the one that the command made."""
    monkeypatch.setattr(video, "VideoWriter", ListWriter)
    ListWriter.made.clear()
    return lambda: ListWriter.made[-1]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "required: COMMAND"),
        (["recrod"], "invalid choice: 'recrod'"),
        (["record", "GStack-v0"], "required: --out"),
        (["record", "GStak-v0", "--out", "x.mp4"], "'GStak-v0'; did you mean GStack-v0?"),
        (["record", "gstack-v0", "--out", "x.mp4"], "did you mean GStack-v0?"),
        (["record", "stack", "--out", "x.mp4"], "did you mean scene:stack"),
        (["record", "qqqq", "--out", "x.mp4"], "`gsenv list` shows them all"),
        (["record", "scene:stack", "--out", "x.mp4", "--policy", "random"], "takes no --policy"),
        (["record", "GStack-v0", "--out", "x.avi"], ".gif"),
        (["record", "GStack-v0", "--out", "x.mp4", "--steps", "0"], "'0' is not a positive whole number"),
        (["record", "GStack-v0", "--out", "x.mp4", "--steps", "many"], "'many' is not a positive whole number"),
        (["record", "GStack-v0", "--out", "x.mp4", "--size", "640"], "'640' is not a size such as 640x480"),
        (["record", "GStack-v0", "--out", "x.mp4", "--size", "641x480"], "even sizes"),
        (["record", "GStack-v0", "--out", "x.mp4", "--policy", "best"], "invalid choice: 'best'"),
    ],
)
def test_wrong_command_line_gives_one_line_and_exit_code_2(
    env: CountingEnv, capsys: pytest.CaptureFixture[str], arguments: list[str], sentence: str
) -> None:
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("gsenv: ")
    assert captured.err.count("\n") == 1
    assert sentence in captured.err


def test_record_writes_one_episode_from_its_first_frame_on(
    env: CountingEnv, writer: Callable[[], ListWriter], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["record", "GStack-v0", "--out", "x.mp4", "--seed", "7"]) == 0
    assert [int(frame[0, 0, 0]) for frame in writer().frames] == [0, 1, 2, 3, 4, 5]
    assert writer().closed
    assert writer().fps == 30
    assert env.log[0] == ("reset", 7)
    assert capsys.readouterr().out == "x.mp4: 6 frames, 0.2 s\n"


def test_record_begins_new_episodes_until_the_steps_are_done(
    env: CountingEnv, writer: Callable[[], ListWriter]
) -> None:
    assert cli.main(["record", "GStack-v0", "--out", "x.gif", "--steps", "12", "--size", "32x16"]) == 0
    assert [int(frame[0, 0, 0]) for frame in writer().frames] == [0, 1, 2, 3, 4, 5, 1, 2, 3, 4, 5, 1, 2]
    assert {frame.shape for frame in writer().frames} == {(16, 32, 3)}


def test_random_policy_follows_the_seed(env: CountingEnv, writer: Callable[[], ListWriter]) -> None:
    logs = []
    for seed in ("1", "1", "2"):
        assert cli.main(["record", "GStack-v0", "--out", "x.mp4", "--seed", seed]) == 0
        logs.append([entry for entry in env.log if entry[0] == "step"])
    assert logs[0] == logs[1] != logs[2]


@pytest.mark.parametrize("policy", ["random", "scripted"])
def test_record_takes_environments_of_several_agents(policy: str, writer: Callable[[], ListWriter]) -> None:
    pytest.importorskip("pettingzoo")
    command = ["record", "tower_v0", "--out", "x.mp4", "--steps", "20", "--size", "64x48", "--policy", policy]
    assert cli.main([*command, "--set", "blocks=2"]) == 0
    assert [frame.shape for frame in writer().frames] == [(48, 64, 3)] * 21
    assert (writer().frames[0] != writer().frames[20]).any()


def test_scripted_policy_acts(
    env: CountingEnv, writer: Callable[[], ListWriter], monkeypatch: pytest.MonkeyPatch
) -> None:
    import gsenv.envs.core.policies as policies

    def scripted(env_id: str) -> Callable[[Any], Any]:
        assert env_id == "GStack-v0"
        return lambda env: [float(env.unwrapped.steps), -1.0]

    monkeypatch.setattr(policies, "scripted_policy", scripted)
    assert cli.main(["record", "GStack-v0", "--out", "x.mp4", "--policy", "scripted"]) == 0
    assert env.log[1:] == [("step", [float(step), -1.0]) for step in range(5)]


def test_missing_policy_is_one_sentence_and_exit_code_1(
    env: CountingEnv, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    import gsenv.envs.core.policies as policies

    def missing(env_id: str) -> Callable[[Any], Any]:
        raise LookupError(f"there is no trained policy for {env_id}")

    monkeypatch.setattr(policies, "trained_policy", missing)
    out = tmp_path / "x.mp4"
    assert cli.main(["record", "GStack-v0", "--out", str(out), "--policy", "trained"]) == 1
    assert capsys.readouterr().err == "gsenv: there is no trained policy for GStack-v0\n"
    assert not out.exists()


def test_interrupt_keeps_the_frames_so_far(
    env: CountingEnv,
    writer: Callable[[], ListWriter],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def step(action: Any) -> Any:
        env.steps += 1
        if env.steps == 3:
            raise KeyboardInterrupt
        return np.zeros(1), 0.0, False, False, {}

    monkeypatch.setattr(env, "step", step)
    assert cli.main(["record", "GStack-v0", "--out", "x.mp4"]) == 130
    assert len(writer().frames) == 3
    assert writer().closed
    assert capsys.readouterr().err == "gsenv: interrupted; x.mp4 has the 3 frames so far\n"


def press_ctrl_c(monkeypatch: pytest.MonkeyPatch, times: int) -> None:
    """Let Ctrl-C be pressed while a video is completed."""

    def finish(writer: ListWriter) -> None:
        for _ in range(times):
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(ListWriter, "finish", finish)


def test_completing_a_video_is_shown(
    env: CountingEnv, writer: Callable[[], ListWriter], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a bar of its own: that of the frames is full by then."""
    shown: list[str] = []
    seen_at_the_end: list[str] = []

    class Progress(contextlib.nullcontext[Any]):
        def __enter__(self) -> Any:
            return self

        def add_task(self, text: str, total: int | None) -> int:
            shown.append(f"{text} {total}")
            return 0

        def advance(self, task: int) -> None: ...

        def update(self, task: int, **changes: Any) -> None: ...

    monkeypatch.setattr("gsenv.cli.recording.make_progress", Progress)
    monkeypatch.setattr(ListWriter, "finish", lambda self: seen_at_the_end.extend(shown))
    assert cli.main(["record", "GStack-v0", "--out", "x.gif"]) == 0
    assert seen_at_the_end == ["GStack-v0 601", "writing x.gif None"]


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize(("times", "kept"), [(1, "x.gif has the 6 frames so far"), (2, "nothing was written")])
def test_the_first_ctrl_c_while_a_video_is_completed_keeps_it(
    env: CountingEnv,
    writer: Callable[[], ListWriter],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    times: int,
    kept: str,
) -> None:
    press_ctrl_c(monkeypatch, times)
    assert cli.main(["record", "GStack-v0", "--out", "x.gif"]) == 130
    assert writer().is_written == (times == 1)
    assert capsys.readouterr().err == f"gsenv: interrupted; {kept}\n"


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_second_ctrl_c_gives_a_video_up(
    env: CountingEnv,
    writer: Callable[[], ListWriter],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def step(action: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(env, "step", step)
    press_ctrl_c(monkeypatch, 1)
    assert cli.main(["record", "GStack-v0", "--out", "x.gif"]) == 130
    assert capsys.readouterr().err == "gsenv: interrupted; nothing was written\n"


@pytest.mark.parametrize("name", ["file.txt/x.mp4", "folder.mp4", "folder.npz", "file.txt/x.npz"])
def test_unwritable_output_is_one_sentence_and_exit_code_1_before_the_work(
    env: CountingEnv,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    name: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("gsenv.replay.record", lambda *_: pytest.fail("it has begun"))
    (tmp_path / "file.txt").write_text("")
    for folder in ("folder.mp4", "folder.npz"):
        (tmp_path / folder).mkdir()
    out = tmp_path / name
    assert cli.main(["record", "GStack-v0", "--out", str(out)]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"gsenv: cannot write {out}: ")
    assert error.count("\n") == 1
    assert env.log == []


@pytest.mark.parametrize("options", [["--out", "x.gif", "--size", "32x16"], ["--out", "x.npz"]])
def test_record_makes_missing_folders(tmp_path: Path, options: list[str]) -> None:
    out = tmp_path / "new" / "folder" / options[1]
    assert cli.main(["record", "scene:stack", "--steps", "2", "--out", str(out), *options[2:]]) == 0
    assert out.is_file()


def test_a_seed_that_is_refused_is_a_wrong_command_line(
    env: CountingEnv,
    writer: Callable[[], ListWriter],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def reset(seed: int) -> Any:
        raise ValueError("reset: a seed must be below 7.")

    monkeypatch.setattr(env, "reset", reset)
    assert cli.main(["record", "GStack-v0", "--out", "x.mp4", "--seed", "7"]) == 2
    assert capsys.readouterr().err == "gsenv: reset: a seed must be below 7.\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_a_result_that_cannot_be_printed_is_one_sentence(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "gsenv", "record", "scene:stack", "--steps", "2", "--out", str(tmp_path / "a.npz")]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, timeout=300)
    assert done.returncode == 1
    assert done.stderr == "gsenv: cannot print the result: No space left on device\n"


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_record_makes_a_video_that_other_programs_read(env: CountingEnv, tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"x{suffix}"
    assert cli.main(["record", "GStack-v0", "--out", str(out)]) == 0
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    assert iio.imread(out).shape == (6, 48, 64, 3)


@pytest.mark.parametrize(
    ("timestep", "out", "shown", "fps"),
    [
        (1 / 240, "x.mp4", [0, 4, 8, 12], 60.0),
        (1 / 60, "x.mp4", list(range(13)), 60.0),
        (1 / 60, "x.gif", [0, 2, 4, 6, 8, 10, 12], 30.0),  # GIF viewers slow down above 50
        (1 / 100, "x.mp4", [0, 2, 4, 6, 8, 10, 12], 50.0),
    ],
)
def test_scene_is_recorded_at_its_own_pace(
    writer: Callable[[], ListWriter],
    monkeypatch: pytest.MonkeyPatch,
    timestep: float,
    out: str,
    shown: list[int],
    fps: float,
) -> None:
    import gsenv.render

    class World:
        steps = 0

        def __init__(self) -> None:
            self.timestep = timestep

        def step(self) -> None:
            self.steps += 1

    class Renderer:
        def __init__(self, world: World, width: int = 640, height: int = 480) -> None:
            self.world, self.shape = world, (height, width, 3)

        def render(self, world_index: int = 0) -> Any:
            return np.full(self.shape, self.world.steps, np.uint8)

    monkeypatch.setattr(scenes, "make_world", lambda name: World())
    monkeypatch.setattr(gsenv.render, "make_renderer", Renderer)
    assert cli.main(["record", "scene:stack", "--out", out, "--steps", "12", "--size", "64x48"]) == 0
    assert [int(frame[0, 0, 0]) for frame in writer().frames] == shown
    assert writer().fps == pytest.approx(fps)
    assert writer().frames[0].shape == (48, 64, 3)


@pytest.mark.skipif(os.name != "posix", reason="signals to a process group")
def test_the_real_thing_stops_at_ctrl_c_with_a_valid_file(tmp_path: Path) -> None:
    out = tmp_path / "x.mp4"
    command = [sys.executable, "-m", "gsenv", "record", "scene:stack", "--steps", "1000000", "--size", "64x48"]
    process = subprocess.Popen(
        [*command, "--out", str(out)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=hear_interrupts,
    )
    deadline = time.monotonic() + 300
    while not any(path.stat().st_size for path in tmp_path.iterdir()):  # until the first bytes of the video
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.2)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the encoder too
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    assert [path.name for path in tmp_path.iterdir()] == ["x.mp4"]
    frames = int(re.search(rb"has the (\d+) frames", error)[1])  # type: ignore[index]
    assert len(iio.imread(out)) == frames
    assert frames > 0


def test_record_takes_arguments_and_policy_files(
    tmp_path: Path, writer: Callable[[], ListWriter], capsys: pytest.CaptureFixture[str]
) -> None:
    from tests.train.test_evaluate import still

    still().save(tmp_path / "policy.npz")
    command = ["record", "GStack-v0", "--out", "x.mp4", "--steps", "2", "--policy", str(tmp_path / "policy.npz")]
    assert cli.main([*command, "--set", "blocks=2"]) == 0
    assert len(writer().frames) == 3
    assert cli.main(["record", "scene:stack", "--out", "x.mp4", "--set", "blocks=2"]) == 2
    assert "takes no --set" in capsys.readouterr().err
