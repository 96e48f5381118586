"""Windows, on SDL's dummy display: what they show, and the events that they report."""

from __future__ import annotations

import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gsenv.view
from gsenv.cli import main
from gsenv.envs.core.window import Window as HumanWindow
from gsenv.scenes import make_world
from gsenv.view import loop
from gsenv.view.events import (
    ButtonPressed,
    ButtonReleased,
    Closed,
    Event,
    Exposed,
    FocusLost,
    KeyPressed,
    KeyReleased,
    MouseMoved,
    PadMoved,
    PadPressed,
    PadReleased,
    Scrolled,
)
from gsenv.view.pacing import Pacer
from gsenv.view.session import Session
from gsenv.view.window import NO_DISPLAY, NO_PYGAME, Window, default_size, fit
from tests.envs.registered import make, make_vector
from tests.view.sessions import pixel_of, scene_session

pygame = pytest.importorskip("pygame")
ROOT = Path(__file__).parents[2]
SIZE = (320, 240)
TAKE_EVENTS, SHOW = Window.take_events, loop.show  # tests replace them


@pytest.fixture(autouse=True)
def _display(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A display that nobody sees; no window outlives its test."""
    from gsenv.view import window

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    yield
    for opened in list(window._SCREEN.windows.values()):
        opened.close()
    assert not pygame.display.get_init()


def post(window: Window, kind: int, **fields: Any) -> None:
    pygame.event.post(pygame.event.Event(kind, window=window._window, **fields))


def press(window: Window, name: str) -> None:
    post(window, pygame.KEYDOWN, key=pygame.key.key_code(name), unicode=name if len(name) == 1 else "", mod=0)


def noise(seed: int, size: tuple[int, int] = SIZE) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (size[1], size[0], 3), np.uint8)


# ---------------------------------------------------------------- windows


def test_a_window_shows_the_frame() -> None:
    with Window("one", SIZE) as window:
        frame = noise(0)
        window.show(frame)
        np.testing.assert_array_equal(window.read(), frame)
        assert window.size == SIZE
        assert window.title == "one"
        window.title = "two"
        assert window.title == "two"
    assert not window.is_open
    window.close()


def test_a_frame_of_another_shape_is_scaled_and_centred() -> None:
    with Window("one", (200, 100)) as window:
        window.show(np.full((50, 50, 3), 200, np.uint8))
        shown = window.read()
    assert (shown[:, 55:145] == 200).all()
    assert (shown[:, :45] == 0).all()
    assert (shown[:, 155:] == 0).all()
    assert fit((640, 480), (100, 1000)) == (100, 75)
    assert fit((640, 480), (1, 1)) == (1, 1)


def test_events_have_the_meaning_of_the_keys_and_buttons() -> None:
    with Window("one", SIZE) as window:
        window.take_events()
        press(window, "space")
        post(window, pygame.KEYDOWN, key=pygame.K_EQUALS, unicode="+", mod=0)
        post(window, pygame.KEYUP, key=pygame.K_SPACE, mod=0)
        post(window, pygame.MOUSEMOTION, pos=(10, 20), rel=(0, 0), buttons=(0, 0, 0))
        post(window, pygame.MOUSEBUTTONDOWN, pos=(3, 4), button=1)
        post(window, pygame.MOUSEBUTTONUP, pos=(3, 4), button=3)
        post(window, pygame.MOUSEWHEEL, x=0, y=2, precise_y=1.5)
        post(window, pygame.WINDOWFOCUSLOST)
        post(window, pygame.WINDOWEXPOSED)
        post(window, pygame.WINDOWCLOSE)
        post(window, pygame.MOUSEBUTTONDOWN, pos=(3, 4), button=7)  # of no interest
        expected: list[Event] = [
            KeyPressed("space"), KeyPressed("=", "+"), KeyReleased("space"), MouseMoved(10.0, 20.0),
            ButtonPressed("left", 3.0, 4.0), ButtonReleased("right"), Scrolled(1.5, 10.0, 20.0),
            FocusLost(), Exposed(), Closed(),
        ]  # fmt: skip
        assert window.take_events() == expected
        assert window.take_events() == []


def test_events_of_a_gamepad() -> None:
    with Window("one", SIZE) as window:
        window.take_events()
        for axis, value in ((0, 32767), (1, 32767), (5, 16384), (4, 32767)):
            pygame.event.post(pygame.event.Event(pygame.CONTROLLERAXISMOTION, axis=axis, value=value, instance_id=0))
        pygame.event.post(pygame.event.Event(pygame.CONTROLLERBUTTONDOWN, button=0, instance_id=0))
        pygame.event.post(pygame.event.Event(pygame.CONTROLLERBUTTONUP, button=6, instance_id=0))
        half = 16384 / 32767
        expected: list[Event] = [
            PadMoved("left_x", 1.0), PadMoved("left_y", -1.0), PadMoved("triggers", half),
            PadMoved("triggers", half - 1.0), PadPressed("a"), PadReleased("start"),
        ]  # fmt: skip
        assert window.take_events() == expected


def test_two_windows_have_their_own_frames_and_events() -> None:
    with Window("one", SIZE) as one, Window("two", (64, 48)) as two:
        frames = noise(1), noise(2, (64, 48))
        one.show(frames[0])
        two.show(frames[1])
        np.testing.assert_array_equal(one.read(), frames[0])
        np.testing.assert_array_equal(two.read(), frames[1])
        for window in (one, two):
            window.take_events()
        press(two, "a")
        press(one, "b")
        assert one.take_events() == [KeyPressed("b", "b")]
        assert two.take_events() == [KeyPressed("a", "a")]
        one.close()
        two.show(frames[1])
        press(two, "c")
        assert KeyPressed("c", "c") in two.take_events()


def test_the_window_is_larger_on_a_large_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    with Window("one", SIZE):
        for height, expected in ((768, (640, 480)), (1080, (640, 480)), (2160, (1280, 960))):
            monkeypatch.setattr(pygame.display, "get_desktop_sizes", lambda height=height: [(2 * height, height)])
            assert default_size() == expected


def test_frames_are_paced(monkeypatch: pytest.MonkeyPatch) -> None:
    now, slept = [0.0], []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds

    monkeypatch.setattr("gsenv.view.pacing.time.perf_counter", lambda: now[0])
    monkeypatch.setattr("gsenv.view.pacing.time.sleep", sleep)
    pacer = Pacer(10.0)
    for busy in (0.0, 0.04, 0.04, 0.5, 0.04):
        now[0] += busy
        pacer.wait()
    np.testing.assert_allclose(slept, [0.06, 0.06, 0.06])  # not after the frame that was late


# ---------------------------------------------------------------- the loop


def run_with(monkeypatch: pytest.MonkeyPatch, session: Session, script: dict[int, Callable[[Window], None]]) -> Window:
    """Show a session, and call `script[k]` before frame k; the last call must quit."""
    count = iter(range(10_000))

    def take(window: Window) -> list[Event]:
        number = next(count)
        assert number <= max(script) + 5, "the window should have closed"
        script.get(number, lambda window: None)(window)
        return TAKE_EVENTS(window)

    monkeypatch.setattr(Window, "take_events", take)
    monkeypatch.setattr(Pacer, "wait", lambda self: None)
    with Window("test", SIZE) as window:
        SHOW(session, window)
        window.shown = window.read()  # type: ignore[attr-defined]
    return window


def test_keys_and_mouse_of_a_real_window_reach_the_session(monkeypatch: pytest.MonkeyPatch) -> None:
    session = scene_session("stack")
    world = session.simulation.world
    x, y = (int(part) for part in pixel_of(session, "box_5"))
    script: dict[int, Callable[[Window], None]] = {
        1: lambda window: press(window, "space"),
        2: lambda window: post(window, pygame.MOUSEBUTTONDOWN, pos=(x, y), button=1),
        3: lambda window: post(window, pygame.MOUSEMOTION, pos=(x + 60, y), rel=(60, 0), buttons=(1, 0, 0)),
        **{k: lambda window: press(window, ".") for k in range(4, 24)},
        30: lambda window: press(window, "q"),
    }
    window = run_with(monkeypatch, session, script)
    assert session.paused
    body = world.model.body_names.index("box_5")
    assert session.shown.selected == body
    assert world.position[0, body, 0] > 0.05
    np.testing.assert_array_equal(window.shown, session.picture())  # type: ignore[attr-defined]


def test_the_close_button_ends_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    session = scene_session("stack")
    run_with(monkeypatch, session, {3: lambda window: post(window, pygame.WINDOWCLOSE)})
    assert not session.running


def test_the_picture_follows_the_size_of_the_window(monkeypatch: pytest.MonkeyPatch) -> None:
    session = scene_session("cube_stack")

    def resize(window: Window) -> None:
        window._window.size = (400, 200)

    window = run_with(monkeypatch, session, {2: resize, 6: lambda window: press(window, "escape")})
    assert session.screen.size == (400, 200)
    assert window.shown.shape == (200, 400, 3)  # type: ignore[attr-defined]


# ---------------------------------------------------------------- the command line


@pytest.fixture
def quits(monkeypatch: pytest.MonkeyPatch) -> list[Session]:
    """Sessions of windows that are closed at the tenth frame."""
    sessions: list[Session] = []

    def show(session: Session, window: Window) -> None:
        sessions.append(session)
        run_with(monkeypatch, session, {10: lambda window: press(window, "escape")})

    monkeypatch.setattr(loop, "show", show)
    return sessions


def test_view_and_play_open_windows(quits: list[Session]) -> None:
    assert main(["view", "scene:stack", "--size", "200x150", "--worlds", "2", "--paused"]) == 0
    assert quits[-1].simulation.world.world_count == 2
    assert quits[-1].paused
    assert main(["view", "GStack-v0", "--policy", "scripted", "--seed", "3", "--set", "blocks=2"]) == 0
    assert quits[-1].simulation.seeds == [3]
    assert main(["view", str(ROOT / "assets" / "ragdoll.xml"), "--size", "200x150"]) == 0
    assert "torso" in quits[-1].simulation.world.model.body_names
    assert main(["play", "tower_v0"]) == 0
    assert quits[-1].simulation.steering is not None


def test_ctrl_c_closes_the_window(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt(window: Window) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Window, "take_events", interrupt)
    assert main(["view", "scene:stack"]) == 130
    assert not opened()
    assert capsys.readouterr().err == "gsenv: interrupted\n"


def test_show_opens_a_window_on_a_world(quits: list[Session]) -> None:
    world = make_world("stack")
    gsenv.view.show(world, "mine")
    assert quits[-1].simulation.world is world
    assert quits[-1].simulation.title == "mine"


def test_a_file_that_cannot_be_read_is_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["view", str(tmp_path / "robot.xml")]) == 1
    error = capsys.readouterr().err
    assert "robot.xml" in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["view", "scene:stak"], "no environment or scene is called 'scene:stak'; did you mean scene:stack?"),
        (["view", "scene:stack", "--policy", "random"], "scene:stack is a scene and takes no --policy"),
        (["view", "scene:stack", "--set", "a=1"], "scene:stack is a scene and takes no --set"),
        (["play", "scene:stack"], "scene:stack is a scene, and this needs an environment"),
        (["play", "GStack-v0", "--policy", "random"], "GStack-v0 has one agent, so --policy has nobody to act for"),
        (["view", "GStack-v0", "--set", "blocks=99"], "blocks must be"),
        (["view", "scene:stack", "--size", "100000x100000"], "width and height must be 1 to 8192 px"),
        (["view", "scene:stack", "--worlds", "100000000000"], "world_count must not exceed"),
        (["view", str(ROOT / "assets" / "ragdoll.xml"), "--worlds", "100000000000"], "world_count must not exceed"),
        (["view", "GStack-v0", "--policy", "clever"], "argument --policy: invalid choice: 'clever'"),
    ],
)
def test_a_wrong_command_line_is_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "code", "sentence"),
    [
        (MemoryError("Unable to allocate 11.6 TiB"), 1, "7 worlds of GStack-v0 do not fit into memory"),
        (ValueError("reset: a seed must be below 7."), 2, "reset: a seed must be below 7."),
    ],
)
def test_worlds_that_cannot_be_made_are_one_sentence(
    error: Exception, code: int, sentence: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("gsenv.envs.core.interactive.TaskSimulation", fail)
    assert main(["view", "GStack-v0", "--worlds", "7"]) == code
    assert capsys.readouterr().err == f"gsenv: {sentence}\n"


def python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    variables = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    variables.pop("SDL_VIDEODRIVER", None)
    command = [sys.executable, "-c", code]
    return subprocess.run(command, cwd=ROOT, env=variables | environment, capture_output=True, text=True, timeout=120)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a display")
def test_without_a_display_there_is_one_sentence() -> None:
    result = python("import sys; from gsenv.cli import main; sys.exit(main(['view', 'scene:stack']))")
    assert result.returncode == 1
    assert result.stderr == f"gsenv: {NO_DISPLAY}\n"


def test_a_display_that_does_not_answer_is_one_sentence() -> None:
    code = "import sys; from gsenv.cli import main; sys.exit(main(['view', 'scene:stack']))"
    result = python(code, SDL_VIDEODRIVER="x11", DISPLAY=":4711")
    assert result.returncode == 1
    assert f"gsenv: {NO_DISPLAY} (" in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("command", ["['view', 'scene:stack']", "['play', 'GCar-v0']"])
@pytest.mark.parametrize("missing", ["sys.modules['pygame'] = None", "sys.modules['pygame'] = type(sys)('pygame')"])
def test_without_pygame_ce_there_is_one_sentence(command: str, missing: str) -> None:
    result = python(f"import sys; {missing}; from gsenv.cli import main; sys.exit(main({command}))")
    assert result.returncode == 1
    assert result.stderr == f"gsenv: {NO_PYGAME}\n"


# ---------------------------------------------------------------- render_mode="human"


def opened() -> list[Window]:
    from gsenv.view import window

    return list(window._SCREEN.windows.values())


def test_the_mode_human_opens_a_window_and_close_closes_it() -> None:
    env = make("GStack-v0", render_mode="human", width=96, height=64)
    assert not opened()
    env.reset(seed=0)
    (window,) = opened()
    assert window.title == "StackEnv"
    twin = make("GStack-v0", render_mode="rgb_array", width=96, height=64)
    twin.reset(seed=0)
    np.testing.assert_array_equal(window.read(), twin.render())
    for either in (env, twin):
        either.step(np.ones(4, np.float32))
    np.testing.assert_array_equal(window.read(), twin.render())
    env.close()
    assert not opened()
    env.close()
    env.reset()  # opens it again
    assert len(opened()) == 1


def test_frames_come_at_the_rate_of_the_metadata(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []
    monkeypatch.setattr(Pacer, "wait", lambda self: waits.append(self.interval))
    env = make("GStack-v0", render_mode="human", width=96, height=64)
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.zeros(4, np.float32))
    assert env.metadata["render_fps"] == 30
    assert waits == [pytest.approx(1 / 30)] * 4


def test_environments_have_windows_of_their_own() -> None:
    single = make("GStack-v0", render_mode="human", width=96, height=64)
    vector = make_vector("GStack-v0", 4, render_mode="human", width=192, height=96)
    single.reset(seed=0)
    vector.reset(seed=0)
    first, second = opened()
    assert (first.size, second.size) == ((96, 64), (192, 96))
    before = first.read()
    vector.step(np.ones((4, 4), np.float32))
    np.testing.assert_array_equal(first.read(), before)
    single.close()
    vector.step(np.ones((4, 4), np.float32))
    assert opened() == [second]
    vector.close()
    assert not opened()


def test_an_environment_goes_on_when_the_user_closes_its_window() -> None:
    env = make("GStack-v0", render_mode="human", width=96, height=64)
    env.reset(seed=0)
    post(opened()[0], pygame.WINDOWCLOSE)
    for _ in range(3):
        env.step(np.zeros(4, np.float32))
        assert not opened()
    env.reset()
    assert not opened()
    env.close()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a display")
def test_an_environment_without_a_display_says_so() -> None:
    code = (
        "import gymnasium as gym\n"
        "from gsenv.view.window import WindowError\n"
        "env = gym.make('gsenv:GStack-v0', render_mode='human')\n"
        "try:\n    env.reset(seed=0)\nexcept WindowError as error:\n    print(error)\n"
    )
    assert python(code).stdout == NO_DISPLAY + "\n"


def test_the_way_out_that_the_sentence_names_works_for_the_checker() -> None:
    (way,) = re.findall(r"SDL_VIDEODRIVER=(\w+)", NO_DISPLAY)
    code = (
        "import gymnasium as gym\n"
        "from gymnasium.utils.env_checker import check_env\n"
        "check_env(gym.make('gsenv:GStack-v0', render_mode='rgb_array', width=64, height=48).unwrapped)\n"
    )
    assert python(code, SDL_VIDEODRIVER=way).returncode == 0


def test_an_environment_with_a_window_can_be_pickled() -> None:
    env = make("GStack-v0", render_mode="human", width=96, height=64).unwrapped
    env.reset(seed=0)
    env.step(np.ones(4, np.float32))
    twin = pickle.loads(pickle.dumps(env))
    assert len(opened()) == 1
    env.step(np.ones(4, np.float32))
    twin.step(np.ones(4, np.float32))
    first, second = opened()
    np.testing.assert_array_equal(first.read(), second.read())
    env.close()
    twin.close()
    assert pickle.loads(pickle.dumps(HumanWindow("a", 30.0))).fps == 30.0


def test_agents_have_one_window() -> None:
    pytest.importorskip("pettingzoo")
    from gsenv.envs import tower_v0

    env = tower_v0.parallel_env(render_mode="human", width=96, height=64)
    env.reset(seed=0)
    assert [window.size for window in opened()] == [(96, 64)]
    env.step({agent: np.zeros(4, np.float32) for agent in env.agents})
    env.close()
    assert not opened()
