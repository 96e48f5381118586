"""Environments that keys and a gamepad steer."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.envs.core.interactive import LONGEST_RESULT, SHOWN_RESULT, make_steering
from gsenv.envs.core.steering import RISE, Key, Steering, Stick, default_controls
from gsenv.envs.core.task import Task
from gsenv.view.events import (
    ButtonPressed,
    ButtonReleased,
    FocusLost,
    KeyPressed,
    KeyReleased,
    MouseMoved,
    PadMoved,
    PadPressed,
    PadReleased,
)
from gsenv.view.screen import help_rows
from gsenv.view.session import Session
from tests.view.sessions import FRAME, pass_time, pixel_of, play_session, send, view_session

VECTOR_ENVS = {entry.id: entry.vector_env for entry in ENVS} | {entry.name: entry.vector_env for entry in PARALLEL_ENVS}


def task_class(name: str) -> type[Task]:
    module, _, cls = VECTOR_ENVS[name].partition(":")
    found: type[Task] = getattr(import_module(f"gsenv.envs.{module}"), cls).task_class
    return found


def car_x(session: Session) -> float:
    world = session.simulation.world
    return float(world.position[0, world.model.body_names.index("chassis"), 0])


@pytest.mark.parametrize("name", VECTOR_ENVS)
def test_the_keys_of_each_task_name_entries_of_its_action(name: str) -> None:
    task = task_class(name)
    names = [entry.name for entry in task.actions]
    assert len(task.controls) == max(len(task.agents), 1)
    keys = [control.key for of_agent in task.controls for control in of_agent if isinstance(control, Key)]
    assert len(keys) == len(set(keys))
    assert not {"space", "escape", "tab", "home", *".+-=hrncjif"} & set(keys)  # they act on the window
    for of_agent in task.controls:
        assert all(set(control.values) <= set(names) for control in of_agent)
        assert all(abs(value) <= 1.0 for control in of_agent for value in control.values.values())
        if len(names) <= 5:
            assert set(names) == {entry for control in of_agent for entry in control.values}


def test_right_drives_the_car_to_the_right_and_left_back() -> None:
    ends = []
    for key in (None, "right", "left"):
        session = play_session("GCar-v0")
        start = car_x(session)
        if key is not None:
            send(session, KeyPressed(key))
        pass_time(session, 2.0)
        ends.append(car_x(session) - start)
    assert abs(ends[0]) < 1.0
    assert ends[1] > 5.0
    assert ends[2] < -0.5


def test_a_released_key_and_a_lost_focus_stop() -> None:
    session = play_session("GCar-v0")
    steering = session.simulation.steering
    assert isinstance(steering, Steering)
    send(session, KeyPressed("right"))
    pass_time(session, 0.5)
    np.testing.assert_array_equal(steering.advance(0.0), [[1.0, 1.0]])
    for event in (KeyReleased("right"), FocusLost()):
        send(session, KeyPressed("right"))
        pass_time(session, 0.5)
        send(session, event)
        pass_time(session, 0.5)
        np.testing.assert_array_equal(steering.advance(0.0), [[0.0, 0.0]])


def test_a_gamepad_steers_and_its_start_button_pauses() -> None:
    session = play_session("GCar-v0")
    start = car_x(session)
    send(session, PadMoved("triggers", 1.0))
    pass_time(session, 2.0)
    assert car_x(session) > start + 5.0
    send(session, PadPressed("start"), PadReleased("start"))
    assert session.paused
    send(session, PadPressed("back"))
    assert car_x(session) == pytest.approx(start)


def test_actions_rise_within_a_moment_and_add_up() -> None:
    steering = Steering(
        ["x", "y"], [[Key("a", "left", {"x": -1.0}), Key("d", "right", {"x": 1.0}), Stick("left_y", {"y": -0.5})]]
    )
    assert steering.takes("a")
    assert not steering.takes("b")
    steering.press("d")
    np.testing.assert_allclose(steering.advance(0.5 * RISE), [[0.5, 0.0]])
    np.testing.assert_allclose(steering.advance(RISE), [[1.0, 0.0]])
    steering.press("a")  # both: neither
    np.testing.assert_allclose(steering.advance(RISE), [[0.0, 0.0]])
    steering.move_axis("left_y", 0.05)  # within the dead zone
    np.testing.assert_allclose(steering.advance(RISE), [[0.0, 0.0]])
    steering.move_axis("left_y", -1.0)
    np.testing.assert_allclose(steering.advance(RISE), [[0.0, 0.5]])
    steering.release_all()
    np.testing.assert_allclose(steering.advance(RISE), [[0.0, 0.0]])


def test_a_task_without_a_table_has_two_keys_for_each_entry() -> None:
    steering = Steering(["lift", "turn"], [default_controls(["lift", "turn"])])
    for key, action in (("q", (1.0, 0.0)), ("a", (-1.0, 0.0)), ("w", (0.0, 1.0)), ("s", (0.0, -1.0))):
        steering.press(key)
        np.testing.assert_array_equal(steering.advance(1.0), [action])
        steering.release(key)
    assert ("a  q", "lift") in steering.help()


def test_the_gripper_lets_go_at_a_key() -> None:
    session = play_session("GStack-v0")
    task = session.simulation.task  # type: ignore[attr-defined]
    pass_time(session, 0.3)
    assert task.task_state["held"][0] >= 0
    send(session, KeyPressed("return"))
    pass_time(session, 0.3)
    assert task.task_state["held"][0] < 0


def test_two_agents_have_a_set_of_keys_each() -> None:
    session = play_session("tower_v0")
    world = session.simulation.world
    grippers = [k for k, name in enumerate(world.model.body_names) if name.startswith("gripper")]
    before = world.position[0, grippers]
    send(session, KeyPressed("d"), KeyPressed("up"))
    pass_time(session, 0.7)
    moved = world.position[0, grippers] - before
    assert moved[0, 0] > 0.2
    assert abs(moved[0, 1]) < 0.1
    assert moved[1, 1] > 0.2
    assert abs(moved[1, 0]) < 0.1
    rows = dict(help_rows(session.simulation))
    assert rows["a  d"] == "left gripper: move"
    assert rows["x"] == "left gripper: let go"
    assert rows["right  left"] == "right gripper: move"
    assert len(session.simulation.score(0)[0][1].split()) == 2  # a return for each


def test_a_policy_acts_for_the_other_agent() -> None:
    session = play_session("tower_v0", policy="scripted")
    steering = session.simulation.steering
    assert steering is not None
    assert steering.takes("d")
    assert not steering.takes("up")
    before = session.simulation.world.position[0]
    pass_time(session, 1.0)
    names = session.simulation.world.model.body_names
    moved = np.abs(session.simulation.world.position[0] - before).max(axis=1)
    grippers = [k for k, name in enumerate(names) if name.startswith("gripper")]
    assert moved[grippers[0]] < 0.1
    assert moved[grippers[1]] > 0.1


def test_an_episode_ends_with_its_result_and_the_next_one_begins() -> None:
    session = play_session("GStack-v0", blocks=2, crack_speed=0.05)
    send(session, KeyPressed("return"))  # drops the block
    for _ in range(200):
        session.tick(FRAME)
        if session.simulation.result(0):
            break
    assert session.simulation.result(0).startswith("cracked: return")
    before = session.picture()
    send(session, KeyReleased("return"))
    pass_time(session, SHOWN_RESULT + 0.2)
    assert session.simulation.result(0) == ""
    assert session.simulation.seeds == [1]
    assert (session.picture() != before).any()


def test_without_a_policy_the_physics_go_on_after_the_end() -> None:
    session = view_session("GRagdoll2D-v0")
    pass_time(session, 6.0)
    assert session.simulation.result(0).startswith("fell: return")
    assert session.simulation.seeds == [0]
    before = float(session.simulation.world.time[0])
    pass_time(session, 2.5)
    assert session.simulation.world.time[0] > before + 2.0
    pass_time(session, LONGEST_RESULT)
    assert session.simulation.result(0) == ""
    assert session.simulation.seeds == [0]


def test_a_policy_succeeds_as_it_does_outside_of_the_window() -> None:
    session = view_session("GStack-v0", policy="scripted", blocks=2)
    for _ in range(2000):
        session.tick(FRAME)
        if session.simulation.result(0):
            break
    assert session.simulation.result(0).startswith("success: return")
    name, value = session.simulation.score(0)[0]
    assert name == "return"
    assert float(value) > 3.0


def test_the_episode_of_a_seed_is_that_of_the_environment() -> None:
    from tests.envs.registered import make

    session = view_session("GCar-v0", worlds=2)
    env = make("GCar-v0", difficulty=0.5)
    for seed in (0, 1):
        observation, _ = env.reset(seed=seed)
        np.testing.assert_array_equal(session.simulation.task.observation[seed], observation)  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["GCar-v0", "GStack-v0"])
def test_a_spring_pulls_at_each_step_of_the_engine(name: str) -> None:
    session = view_session(name)
    calls: list[float] = []
    world = session.simulation.world
    session.simulation.advance(lambda: calls.append(float(world.time[0])))
    np.testing.assert_allclose(calls, [0.0, world.timestep])
    session.simulation.advance()
    assert len(calls) == 2
    alone = view_session(name)
    alone.simulation.advance()
    alone.simulation.advance()
    np.testing.assert_array_equal(world.state.bodies, alone.simulation.world.state.bodies)


def test_the_mouse_lifts_the_car() -> None:
    session = view_session("GCar-v0")
    pixel = pixel_of(session, "chassis")
    send(session, ButtonPressed("left", *pixel), MouseMoved(pixel[0], pixel[1] - 60.0))
    pass_time(session, 1.5)
    lifted = pixel_of(session, "chassis")  # the view, which follows the car, stands still
    assert abs(lifted[1] - (pixel[1] - 60.0)) < 12.0
    send(session, KeyPressed("space"), ButtonReleased("left"))
    places = [pixel_of(session, "chassis")[1]]
    for _ in range(60):
        session.tick(FRAME)
        if session.needs_picture:
            places.append(pixel_of(session, "chassis")[1])
    assert places[-1] > lifted[1] + 10.0  # it is back at the car
    assert np.abs(np.diff(places)).max() < 10.0  # without a jump


def test_steering_of_fewer_agents_than_there_are() -> None:
    session = play_session("tower_v0")
    task = session.simulation.task  # type: ignore[attr-defined]
    assert make_steering(task, 1).advance(0.0).shape == (1, 4)
    assert make_steering(task, 2).advance(0.0).shape == (2, 4)
