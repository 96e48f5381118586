"""Ctrl-C in World.step: soon, after a whole number of steps, and as if the call had been for that number."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.api.interrupts import Interrupts, Pace
from gsenv.solver.planar import AccelerationSensor, Box, HalfPlane, Revolute, Target
from tests.solver.api.mixed import mixed, randomised
from tests.solver.bits import everything

ENDLESS = 10**9
AWAKE = Options(sleep=False)

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals to the own process")


@pytest.fixture(autouse=True)
def ctrl_c() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt, also where the tests run in the background of a shell, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt(call: Callable[[], Any], delay: float, times: int = 1) -> float:
    """Return how many seconds after Ctrl-C the call raised KeyboardInterrupt."""
    sent: list[float] = []

    def press() -> None:
        for _ in range(times):
            time.sleep(delay)
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)

    presser = threading.Thread(target=press)
    presser.start()
    try:
        call()
    except KeyboardInterrupt:
        ended = time.perf_counter()
        presser.join()
        return ended - sent[0]
    raise AssertionError("Ctrl-C did not end the call")


def crate() -> Scene:
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("crate", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 2), angle=0.3)
    return scene


@pytest.mark.parametrize(("dim", "worlds", "threads"), [(2, 1, 1), (2, 6, 1), (2, 6, 2), (3, 3, 1)])
def test_ctrl_c_ends_a_long_call_after_a_whole_number_of_steps(dim: int, worlds: int, threads: int) -> None:
    world = randomised(World(mixed(dim), worlds, threads, AWAKE), range(worlds))
    world.step()  # compiles
    start = world.save()
    latencies = []
    for delay in (0.2, 0.05, 0.11):
        latencies.append(interrupt(lambda: world.step(ENDLESS), delay))
    taken = world.state.worlds["step"]
    assert taken[0] > 10
    assert (taken == taken[0]).all()
    assert min(latencies) < 0.2
    fresh = World(world.model, worlds, options=AWAKE)
    fresh.restore(start)
    fresh.step(int(taken[0]) - 1)
    assert everything(fresh) == everything(world)
    for one in (fresh, world):
        one.step(7)
    assert everything(fresh) == everything(world)


def test_an_impatient_user_presses_it_more_than_once() -> None:
    world = World(mixed(2), 4, 2, AWAKE)
    world.step()
    for _ in range(5):
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            interrupt(lambda: world.step(ENDLESS), 0.001, 2)
            # another thread may receive the second one, and tell the main one late
            signal.signal(signal.SIGINT, lambda number, frame: None)
        except KeyboardInterrupt:  # the second one came after the call
            pass
        taken = world.state.worlds["step"]
        assert (taken == taken[0]).all()


@pytest.mark.parametrize("seed", range(3))
def test_the_length_of_blocks_changes_nothing(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = randomised(World(mixed(2), 3), range(3))
    in_blocks = World(whole.model, 3)
    in_blocks.restore(whole.save())
    monkeypatch.setattr(Pace, "measured", lambda self, steps, seconds: setattr(self, "steps", 10**9))
    whole.step(300)  # in two blocks
    generator = np.random.default_rng(seed)
    monkeypatch.setattr(
        Pace, "measured", lambda self, steps, seconds: setattr(self, "steps", int(generator.integers(1, 9)))
    )
    in_blocks.step(300)
    assert everything(in_blocks) == everything(whole)


def test_readings_are_of_the_last_step_that_was_taken() -> None:
    """An accelerometer needs the motion over it."""
    scene = crate()
    scene.add_joint("pin", Revolute("ground", "crate", anchor=(2, 2)))
    scene.add_sensor("felt", AccelerationSensor("crate"))
    world = World(scene, 2, options=AWAKE)
    world.step()  # compiles
    interrupt(lambda: world.step(ENDLESS), 0.1)
    same = World(world.model, 2, options=AWAKE)
    for _ in range(int(world.state.worlds["step"][0])):
        same.step()
    assert same.sensors().any()
    assert same.sensors().tobytes() == world.sensors().tobytes()


def test_update_functions_of_constraints_are_interrupted_between_steps() -> None:
    scene = crate()
    scene.add_constraint(
        "drag", ["crate"], [[1, 0, 0]], lower=-1, upper=1, update=lambda world: {"bias": world.time[:, None]}
    )
    world = World(scene, options=AWAKE)
    world.step()  # compiles
    assert interrupt(lambda: world.step(ENDLESS), 0.1) < 0.2
    same = World(world.model, options=AWAKE)
    same.step(int(world.state.worlds["step"][0]))
    assert everything(same) == everything(world)


def test_a_handler_of_the_program_that_raises_nothing_is_called_and_the_steps_go_on() -> None:
    heard = []
    world = World(crate(), options=AWAKE)
    world.step()
    signal.signal(signal.SIGINT, lambda number, frame: heard.append(int(world.state.worlds["step"][0])))
    presser = threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGINT))
    presser.start()
    world.step(300_000)
    presser.join()
    assert 1 < heard[0] < 300_001
    assert world.state.worlds["step"][0] == 300_001
    assert signal.getsignal(signal.SIGINT).__name__ == "<lambda>"  # type: ignore[union-attr]


def test_threads_other_than_the_main_one_leave_the_handler_alone() -> None:
    handlers = []

    def run() -> None:
        with Interrupts():
            handlers.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert handlers == [signal.default_int_handler]


def test_a_block_is_short_and_bounded_by_the_number_of_bodies() -> None:
    pace = Pace(10)
    pace.measured(1, 0.001)
    assert pace.steps == 30
    pace.measured(30, 30 * 1e-9)  # all asleep
    assert pace.steps == 800
    pace.measured(500, 100.0)
    assert pace.steps == 1
    assert Pace(10**9).steps == 1
    Pace(0).measured(1, 0.0)


@pytest.mark.parametrize("count", [10**30, 2**63, -1, 1.0, True, "1", None, float("inf")])
def test_bad_counts_are_one_sentence(count: Any) -> None:
    world = World(crate())
    with pytest.raises(ValueError, match=r"^step: count must "):
        world.step(count)
    assert world.time[0] == 0.0


def test_no_step_still_checks_the_control() -> None:
    scene = crate()
    scene.add_joint("pull", Target("crate"))
    scene.add_actuator("x", "pull", "x")
    world = World(scene)
    world.control[0] = np.nan
    with pytest.raises(ValueError, match="control of actuator 'x'"):
        world.step(0)
