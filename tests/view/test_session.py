"""What keys and mouse do in an interactive window."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.view.camera_control import OrbitControl
from gsenv.view.events import (
    ButtonPressed,
    ButtonReleased,
    Closed,
    Exposed,
    FocusLost,
    KeyPressed,
    MouseMoved,
    Scrolled,
)
from gsenv.view.session import SPEEDS, Session, written
from tests.view.sessions import FRAME, SIZE, pass_time, pixel_of, scene_session, send, time_of, view_session

SCENES = ("stack", "cube_stack")  # 2D and 3D


def press(session: Session, *keys: str) -> None:
    send(session, *(KeyPressed(key, key if len(key) == 1 else "") for key in keys))


def body_x(session: Session, body: str) -> float:
    world = session.simulation.world
    return float(world.position[session.shown.world, world.model.body_names.index(body), 0])


def some_body(session: Session) -> str:
    """The lowest body that moves."""
    movable = np.flatnonzero(session._picker.movable)
    return str(session.simulation.world.model.body_names[movable[len(movable) // 2]])


def test_real_time_passes_at_the_speed_that_is_asked_for() -> None:
    session = scene_session("stack")
    pass_time(session, 1.0)
    assert time_of(session) == pytest.approx(1.0, abs=0.02)
    press(session, "-", "-")
    assert session.speed == 0.25
    pass_time(session, 1.0)
    assert time_of(session) == pytest.approx(1.25, abs=0.02)
    press(session, "+", "+", "=")
    assert session.speed == 2.0
    pass_time(session, 0.5)
    assert time_of(session) == pytest.approx(2.25, abs=0.04)
    press(session, *"+" * 20)
    assert session.speed == SPEEDS[-1]
    press(session, *"-" * 20)
    assert session.speed == SPEEDS[0]


def test_pause_and_single_steps() -> None:
    session = scene_session("stack")
    press(session, "space")
    pass_time(session, 0.5)
    assert session.paused
    assert time_of(session) == 0.0
    press(session, ".", "right")
    assert time_of(session) == pytest.approx(2 * session.simulation.world.timestep)
    press(session, "space")
    press(session, ".")  # pauses again
    assert session.paused
    assert "paused" in session._status()[0]


def test_a_simulation_that_is_too_slow_drops_time_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    session = scene_session("stack")
    clock = iter(range(10**6))
    monkeypatch.setattr("gsenv.view.session.time.perf_counter", lambda: float(next(clock)))  # each step takes 1 s
    for _ in range(60):
        session.tick(0.1)
    assert time_of(session) == pytest.approx(60 * session.simulation.period)
    assert "reached" in session._status()[0]


@pytest.mark.parametrize("name", SCENES)
def test_a_restart_begins_anew(name: str) -> None:
    session = scene_session(name)
    start = session.simulation.world.position
    pixel = pixel_of(session, some_body(session))
    send(session, ButtonPressed("left", *pixel), MouseMoved(pixel[0] + 30, pixel[1]))
    pass_time(session, 0.3)
    assert not np.array_equal(session.simulation.world.position, start)
    press(session, "r")
    assert session.spring is None
    np.testing.assert_array_equal(session.simulation.world.position, start)


@pytest.mark.parametrize("name", SCENES)
def test_the_mouse_drags_a_body(name: str) -> None:
    session = scene_session(name)
    press(session, "c")
    body = some_body(session)
    before = pixel_of(session, body)
    send(session, ButtonPressed("left", *before))
    assert session.simulation.world.model.body_names[session.shown.selected or 0] == body
    assert body in session._status()[1]
    goal = before + np.array([60.0, -30.0])
    send(session, MouseMoved(*goal))
    pass_time(session, 1.0)
    assert np.abs(pixel_of(session, body) - goal).max() < 25.0
    send(session, ButtonReleased("left"))
    assert session.spring is None
    assert session.shown.selected is not None  # stays selected


def test_a_body_is_dragged_in_the_shown_world_alone() -> None:
    session, alone = scene_session("stack", 3), scene_session("stack", 3)
    press(session, "tab")
    assert session.shown.world == 1
    pixel = pixel_of(session, some_body(session))
    send(session, ButtonPressed("left", *pixel), MouseMoved(pixel[0] + 60.0, pixel[1]))
    pass_time(session, 0.5)
    pass_time(alone, 0.5)
    ours, theirs = (s.simulation.world.position for s in (session, alone))
    np.testing.assert_array_equal(ours[[0, 2]], theirs[[0, 2]])
    assert np.abs(ours[1] - theirs[1]).max() > 0.1
    press(session, "tab")
    assert session.spring is None
    press(session, "tab")
    assert session.shown.world == 0


@pytest.mark.parametrize("name", SCENES)
def test_the_right_mouse_moves_the_view(name: str) -> None:
    session = scene_session(name)
    before = session.picture()
    control = session.screen.control
    if isinstance(control, OrbitControl):
        target, eye = np.asarray(control._camera.target), np.asarray(control._camera.eye)
        front = target + 0.2 * (eye - target)
    else:
        front = control.on_plane((160.0, 120.0), np.zeros(2))
    send(session, ButtonPressed("right", 100, 100), MouseMoved(160, 120))
    assert (session.picture() != before).any()
    moved = control.project(front)
    assert moved[0] > 162.0  # what is in front follows the mouse
    assert moved[1] > 115.0
    send(session, ButtonReleased("right"), MouseMoved(10, 10))
    np.testing.assert_array_equal(control.project(front), moved)
    if name == "stack":
        np.testing.assert_allclose(moved, (220.0, 140.0))
    press(session, "home")
    np.testing.assert_array_equal(session.picture(), before)


def test_shift_and_the_middle_button_pan_in_3d() -> None:
    session = scene_session("cube_stack")
    body = some_body(session)
    pixel = pixel_of(session, body)
    send(session, ButtonPressed("right", 100, 100, shift=True), MouseMoved(120, 90), ButtonReleased("right"))
    np.testing.assert_allclose(pixel_of(session, body) - pixel, (20.0, -10.0), atol=2.0)
    send(session, ButtonPressed("middle", 100, 100), MouseMoved(80, 110), ButtonReleased("middle"))
    np.testing.assert_allclose(pixel_of(session, body), pixel, atol=0.5)


@pytest.mark.parametrize("name", SCENES)
def test_the_wheel_zooms_towards_the_mouse(name: str) -> None:
    session = scene_session(name)
    session.picture()
    control = session.screen.control
    pixel = (100.0, 80.0)
    height = control.view_height
    target = np.zeros(2) if name == "stack" else np.asarray(session.screen.base_camera(session.shown).target)
    point = control.on_plane(pixel, target)
    send(session, Scrolled(1.0, *pixel), Scrolled(2.0, *pixel))
    session.picture()
    assert control.view_height == pytest.approx(height * 0.85**3)
    np.testing.assert_allclose(control.project(point), pixel, atol=3.0)
    for _ in range(200):
        send(session, Scrolled(-5.0, *pixel))
    assert np.isfinite(control.view_height)
    assert session.picture().shape == (SIZE[1], SIZE[0], 3)


@pytest.mark.parametrize("name", SCENES)
def test_the_view_follows_the_selected_body_without_a_jump(name: str) -> None:
    session = scene_session(name)
    body = some_body(session)
    pixel = pixel_of(session, body)
    send(session, ButtonPressed("left", *pixel), ButtonReleased("left"))
    press(session, "f")
    np.testing.assert_allclose(pixel_of(session, body), pixel, atol=1e-6)
    session.simulation.world.set_pose(body, position=session.simulation.world.position[0, session.shown.selected] + 0.5)
    np.testing.assert_allclose(pixel_of(session, body), pixel, atol=1e-6)
    press(session, "f")
    np.testing.assert_allclose(pixel_of(session, body), pixel, atol=1e-6)
    session.simulation.world.set_pose(body, position=session.simulation.world.position[0, session.shown.selected] + 0.5)
    assert np.abs(pixel_of(session, body) - pixel).max() > 5.0


def test_the_view_cannot_turn_over() -> None:
    session = scene_session("cube_stack")
    session.picture()
    for dy in (10_000.0, -10_000.0):
        send(session, ButtonPressed("right", 0, 0), MouseMoved(0, dy), ButtonReleased("right"))
        session.picture()
        control = session.screen.control
        assert isinstance(control, OrbitControl)
        forward = control._camera.axes()[2]
        assert abs(forward[2]) < np.sin(np.radians(89.5))


@pytest.mark.parametrize(("name", "key"), [("stack", "c"), ("cube_stack", "c"), ("cradle", "j"), ("swing_door", "j")])
def test_keys_show_contacts_and_joints(name: str, key: str) -> None:
    session = scene_session(name)
    pass_time(session, 0.1)
    session.picture()
    plain = session.screen.draw(session.shown, None, lambda: ("", "", ""), still=True)
    press(session, key)
    marked = session.screen.draw(session.shown, None, lambda: ("", "", ""), still=True)
    assert (plain != marked).any(axis=-1).sum() > 50
    press(session, key)
    again = session.screen.draw(session.shown, None, lambda: ("", "", ""), still=True)
    np.testing.assert_array_equal(plain, again)


def test_the_longest_arrow_is_the_largest_contact_force() -> None:
    session = scene_session("stack")
    pass_time(session, 1.0)
    press(session, "c")
    session.picture()
    world = session.simulation.world
    contacts = world.contacts(0)
    largest = np.sqrt((contacts.force_vector(world.timestep) ** 2).sum(-1)).max()
    assert session.screen.largest_force == pytest.approx(largest)
    assert f"{written(largest)} N" in session._status()[1]


def test_help_lists_what_the_keys_do() -> None:
    from gsenv.view.screen import help_rows

    planar, spatial = (dict(help_rows(scene_session(name).simulation)) for name in SCENES)
    assert planar["right mouse"] == "move the view"
    assert spatial["right mouse"] == "turn the view"
    assert "tab" not in planar  # one world
    assert "n" not in planar  # no seeds
    session = scene_session("stack")
    before = session.picture()
    press(session, "h")
    assert (session.picture() != before).any()


def test_pictures_are_drawn_when_something_has_changed() -> None:
    session = scene_session("stack")
    assert session.needs_picture
    press(session, "space")
    session.picture()
    session.tick(FRAME)
    assert not session.needs_picture
    send(session, Exposed())
    assert session.needs_picture
    session.picture()
    pass_time(session, 0.4)
    assert session.needs_picture  # a finer one, once
    session.picture()
    pass_time(session, 0.4)
    assert not session.needs_picture


def test_the_window_may_have_any_size() -> None:
    session = scene_session("cube_stack")
    press(session, "h", "c")
    for size in ((641, 333), (40, 30), (16, 300), (1, 1)):
        session.screen.size = size
        assert session.picture().shape == (size[1], size[0], 3)


def test_slow_3d_pictures_become_simpler_and_still_ones_fine(monkeypatch: pytest.MonkeyPatch) -> None:
    session = scene_session("cube_stack")
    clock = iter(range(10**6))
    monkeypatch.setattr("gsenv.view.screen.time.perf_counter", lambda: float(next(clock)))
    for _ in range(5):
        assert session.picture().shape == (SIZE[1], SIZE[0], 3)
    assert session.screen._quality == 2
    coarse = session.picture()
    press(session, "space")
    pass_time(session, 0.4)
    assert (session.picture() != coarse).any()


def test_quitting() -> None:
    for event in (Closed(), KeyPressed("q", "q"), KeyPressed("escape")):
        session = scene_session("stack")
        send(session, event)
        assert not session.running


def test_a_lost_focus_lets_go() -> None:
    session = scene_session("stack")
    send(session, ButtonPressed("left", *pixel_of(session, some_body(session))))
    assert session.spring is not None
    send(session, FocusLost())
    assert session.spring is None


def test_a_window_on_an_environment_shows_the_next_episode() -> None:
    session = view_session("GStack-v0", worlds=2, policy="random")
    assert session.simulation.seeds == [0, 1]
    first = session.simulation.world.position
    press(session, "n")
    assert session.simulation.seeds == [2, 1]
    assert (session.simulation.world.position[0] != first[0]).any()
    np.testing.assert_array_equal(session.simulation.world.position[1], first[1])
    session.restart(anew=False)
    assert session.simulation.seeds == [2, 1]
