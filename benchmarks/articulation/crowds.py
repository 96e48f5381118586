"""A heap of 20 ragdolls, and the car of GCar-v0."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.common.progress import track
from benchmarks.common.report import Part
from benchmarks.common.tables import Table
from benchmarks.common.timing import step_time

from .engines import ENGINES, machine
from .ragdoll import ALONG_Y, FRICTION, PARTS, TIMESTEP, joints
from .robots import HEADER, lines_of, run_of

COUNT = 20


def heap_file() -> str:
    """Return the MJCF text of 20 ragdolls above each other in four columns."""
    worlds = []
    for k in range(COUNT):
        column, storey = k % 4, k // 4
        place = (1.2 * (column % 2), 2.0 * (column // 2) + 0.3 * storey, 1.4 + 2.2 * storey)
        worlds.append(_ragdoll(f"{k}", place))
    ground = f'<geom type="plane" size="9 9 1" friction="{FRICTION} 0 0"/>'
    return f"<mujoco><worldbody>{ground}{''.join(worlds)}</worldbody></mujoco>"


def _ragdoll(number: str, place: tuple[float, float, float]) -> str:
    children: dict[str, list[tuple[str, Any]]] = {}
    for parent, child, at in joints():
        children.setdefault(parent, []).append((child, at))
    return _body("pelvis", np.zeros(3) - place, None, number, children)


def _body(name: str, origin: Any, anchor: Any, number: str, children: dict[str, list[tuple[str, Any]]]) -> str:
    """Return the text of a body at ``PARTS``' place relative to ``origin``, and of those that hang on it."""
    spot, half, radius, lies = PARTS[name]
    place = np.array(spot)
    joint = "<freejoint/>" if anchor is None else f'<joint type="ball" pos="{_text(np.array(anchor) - place)}"/>'
    turn = f' quat="{_text(ALONG_Y)}"' if lies else ""
    geom = f'<geom type="capsule" size="{radius} {half}" density="1000" friction="{FRICTION} 0 0"{turn}/>'
    inside = "".join(_body(child, place, at, number, children) for child, at in children.get(name, []))
    return f'<body name="{name} {number}" pos="{_text(place - origin)}">{joint}{geom}{inside}</body>'


def _text(numbers: Any) -> str:
    return " ".join(f"{number:.9g}" for number in numbers)


def measure_heap(quick: bool) -> dict[str, Any]:
    """Return what ``run_of`` returns for the heap: it falls for 3 s, then lies for 1 s."""
    text = heap_file()
    found: dict[str, Any] = {"falling": {}, "lying": {}}
    for engine in track(ENGINES, "heap", len(ENGINES)):
        one = machine(engine, text, TIMESTEP)
        start = one.state()
        one.step(5)
        idle = np.zeros((20 if quick else 200, 0))
        found["falling"][engine] = run_of(one, start, idle)
        found["lying"][engine] = run_of(one, one.state(), idle[: len(idle) // 3])
    return found


def measure_car(quick: bool) -> dict[str, float]:
    """Return us of a solver step of GCar-v0 at rest on flat ground and at full throttle, with rows and joints."""
    import dataclasses

    from gsenv.envs.car.env import CarVectorEnv

    found = {}
    for on in (False, True):
        env = CarVectorEnv(1)
        env.reset(seed=0)
        world = env.task.world
        world.options = dataclasses.replace(world.options, articulated=on, sleep=False)
        world.step(100)
        found["joint coordinates" if on else "rows"] = 1e6 * step_time(world, 100 if quick else 500)
        env.close()
    return found


def report_crowds(results: dict[str, Any]) -> list[Part]:
    """Return the tables of heap and car."""
    heap = [line for state in ("falling", "lying") for line in lines_of(state, results["heap"][state])]
    car = [[name, f"{us:.1f}"] for name, us in results["car"].items()]
    return [
        f"## A heap of {COUNT} ragdolls, steps of 3 ms",
        "All bodies collide but those that share a joint.",
        Table(HEADER, heap, words=2),
        "## GCar-v0's car on its course, one solver step",
        Table(["", "us a step"], car),
    ]
