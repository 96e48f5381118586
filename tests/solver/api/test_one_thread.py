"""One thread at a time: a second one gets an error, and what the first one does stays as it is."""

from __future__ import annotations

import copy
import pickle
import threading
from collections.abc import Callable
from typing import Any

import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import AccelerationSensor, Box, HalfPlane, Revolute
from tests.solver.api.mixed import mixed
from tests.solver.bits import everything

AWAKE = Options(sleep=False)


def swing() -> Scene:
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("bar", shapes=[Box(half_extents=(0.5, 0.1))], position=(0.5, 2))
    scene.add_joint("pin", Revolute("ground", "bar", anchor=(0, 2)))
    scene.add_sensor("felt", AccelerationSensor("bar"))
    return scene


USES: dict[str, Callable[[World], Any]] = {
    "step": lambda world: world.step(),
    "reset": lambda world: world.reset(),
    "save": lambda world: world.save(),
    "restore": lambda world: world.restore(SAVED[0]),
    "position": lambda world: world.position,
    "time": lambda world: world.time,
    "contacts": lambda world: world.contacts(),
    "diagnostics": lambda world: world.diagnostics(),
    "sensors": lambda world: world.sensors(),
    "cast_rays": lambda world: world.cast_rays((0, 5), (0, -1), 9.0),
    "apply_force": lambda world: world.apply_force("bar", force=(1, 0)),
    "set_pose": lambda world: world.set_pose("bar", position=(0, 9)),
    "set_velocity": lambda world: world.set_velocity("bar", linear=(0, 9)),
    "set_joint": lambda world: world.set_joint("pin", coordinate=1.0),
    "joint_coordinate": lambda world: world.joint_coordinate("pin"),
    "set": lambda world: world.parameters.set("bar", mass=7.0),
    "options": lambda world: setattr(world, "options", Options(timestep=0.01)),
}
SAVED: list[Any] = []


def test_all_uses_are_refused_while_another_thread_steps() -> None:
    world = World(swing(), options=AWAKE)
    SAVED[:] = [world.save()]
    same = World(world.model, options=AWAKE)
    count = 30_000
    stepping = threading.Thread(target=world.step, args=(count,))
    refused: set[str] = set()
    stepping.start()
    while world._use.owner == 0 and stepping.is_alive():
        pass
    while stepping.is_alive() and refused != set(USES):
        for use in USES.values():
            try:
                if stepping.is_alive() and world._use.owner == stepping.ident:
                    use(world)
            except RuntimeError as error:
                refused.add(str(error).partition(": another thread is using this World")[0])
    stepping.join()
    assert refused == set(USES)
    same.step(count)
    assert everything(same) == everything(world)
    for use in USES.values():
        use(world)  # and are allowed again


@pytest.mark.parametrize("trial", range(3))
def test_two_threads_never_mix_their_steps(trial: int) -> None:
    """Both insist; each call counts or raises, and the state is that of the calls that counted."""
    world = World(mixed(2), 2)
    world.step()
    taken, refused = [0, 0], [0, 0]
    barrier = threading.Barrier(2)

    def run(k: int) -> None:
        barrier.wait()
        while taken[k] + refused[k] < 400:
            try:
                world.step(3)
                taken[k] += 1
            except RuntimeError:
                refused[k] += 1

    threads = [threading.Thread(target=run, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(refused) > 0
    same = World(world.model, 2)
    same.step(1 + 3 * sum(taken))
    assert everything(same) == everything(world)


def test_a_method_may_use_others_of_its_own_world() -> None:
    """As an update function does, which runs within a step."""
    seen = []

    def update(world: World) -> dict[str, Any]:
        seen.append(world.position[0, 1, 1])
        world.parameters.set("bar", friction=0.3)
        return {}

    scene = swing()
    scene.add_constraint("watch", ["bar"], [[1, 0, 0]], lower=0, upper=0, update=update)
    world = World(scene)
    world.step(3)
    assert len(seen) == 3
    assert world._use.free == [True]


def test_a_method_that_raises_frees_the_world() -> None:
    world = World(swing())
    for bad in (lambda: world.step(-1), lambda: world.apply_force("bar"), lambda: world.parameters.set("nobody")):
        with pytest.raises(ValueError, match=r"must|missing|needs|unknown"):
            bad()
        assert world._use.free == [True]


def test_copies_are_free_and_apart() -> None:
    world = World(swing())
    world._use.free.pop()
    for other in (copy.deepcopy(world), pickle.loads(pickle.dumps(world))):
        assert other._use is other.parameters._use
        other.step()
        other.parameters.set("bar", mass=3.0)


def test_warnings_still_name_the_line_of_the_user() -> None:
    world = World(swing())
    with pytest.warns(UserWarning, match="the timestep is 0.5 s") as told:
        world.options = Options(timestep=0.5)
    assert told[0].filename == __file__
    with pytest.warns(UserWarning, match="half-width") as told:
        world.parameters.set("bar", half_extents=(1e-5, 1e-5))
    assert told[0].filename == __file__
