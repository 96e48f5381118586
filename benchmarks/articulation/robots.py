"""Gymnasium's robots: step times in the same states under the same controls, contacts and deepest penetration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.progress import track
from benchmarks.common.report import Part
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time

from .engines import ENGINES, INTEGRATORS, JOINTS, ROWS, Machine, Theirs, machine

Array = NDArray[np.float64]
FRAME = 5  # steps under the same controls, as in Gymnasium
ENV_STEP = 0.015  # s, of the humanoid
CUTS = (1, 2, 3, 5)  # substeps of an env step
ROBOTS = ("half_cheetah.xml", "ant.xml", "hopper.xml")
FINE = 1e-3  # m, deepest penetration that is called good
STATES = ("airborne", "lying", "falling", "random torques")


def assets() -> Path:
    """Return the folder of the XML files of the installed Gymnasium."""
    import gymnasium

    return Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"


def controls_for(source: Path, count: int, seed: int = 0) -> Array:
    """Return random controls (count, actuator) within their ranges."""
    model = Theirs(source, 0.003, "Euler").model
    lower, upper = model.actuator_ctrlrange.T
    return np.random.default_rng(seed).uniform(lower, upper, (count, model.nu))


def run_of(
    one: Machine, start: tuple[Array, Array], controls: Array, frame: int = FRAME, rounds: int = 5
) -> dict[str, Any]:
    """Return us a step, mean contacts, deepest penetration in mm and its 99th percentile over all frames.

    Times are those of runs of their own, the least of ``rounds``: reading contacts and depths runs code of gsenv
    that would push the step's out of the processor's caches.
    """
    times = []
    for _ in range(rounds):
        one.place(*start)
        spent = 0.0
        for control in controls:
            one.steer(control)
            spent += cpu_time(lambda: one.step(frame))
        times.append(spent)
    one.place(*start)
    contacts, depths = 0, []
    for control in controls:
        one.steer(control)
        one.step(frame)
        contacts += one.contacts()
        depths.append(1e3 * one.penetration())
    return {
        "us": 1e6 * min(times) / (len(controls) * frame),
        "contacts": contacts / len(controls),
        "deepest": max(depths),
        "usual": float(np.quantile(depths, 0.99)),
        "finite": bool(np.isfinite(one.state()[0]).all()),
    }


def starts(source: Path) -> dict[str, tuple[Array, Array]]:
    """Return the start (qpos, qvel) of each state; the lying one has fallen for 3 s in MuJoCo."""
    one = Theirs(source, 0.003, "Euler")
    standing = one.state()
    high = standing[0].copy()
    high[2] += 1000.0
    tilted = standing[0].copy()
    tilted[2] += 0.3
    tilted[3:7] = np.array([0.995, 0.06, 0.08, 0.0]) / np.linalg.norm([0.995, 0.06, 0.08, 0.0])
    one.place(tilted, standing[1])
    one.step(1000)
    still = np.zeros_like(standing[1])
    return {
        "airborne": (high, still),
        "lying": (one.state()[0], still),
        "falling": (tilted, still),
        "random torques": standing,
    }


def measure_humanoid(quick: bool) -> dict[str, Any]:
    """Return, of each state and engine, what ``run_of`` returns; steps of 3 ms."""
    source = assets() / "humanoid.xml"
    frames = 60 if quick else 400
    random = controls_for(source, frames)
    states = starts(source)
    found: dict[str, Any] = {state: {} for state in STATES}
    for engine in track(ENGINES, "humanoid", len(ENGINES)):
        one = machine(engine, source, ENV_STEP / FRAME)
        one.step(FRAME)  # compiles
        for state in STATES:
            torques = random if state == "random torques" else 0.0 * random
            count = 66 if state == "falling" else frames  # 1 s
            found[state][engine] = run_of(one, states[state], torques[:count])
    return found


def measure_env_step(quick: bool) -> dict[str, Any]:
    """Return us, contacts and depths of an env step of 15 ms under random torques, by engine and number of substeps."""
    source = assets() / "humanoid.xml"
    controls = controls_for(source, 100 if quick else 1000, 1)
    found: dict[str, Any] = {}
    for engine in track(ENGINES, "env step", len(ENGINES)):
        for cut in (FRAME,) if engine in INTEGRATORS else CUTS:
            one = machine(engine, source, ENV_STEP / cut)
            one.step(cut)
            entry = run_of(one, starts(source)["random torques"], controls, cut)
            entry["us"] *= cut
            found.setdefault(engine, {})[str(cut)] = entry
    return found


def measure_others(quick: bool) -> dict[str, Any]:
    """Return the other robots under random controls, at the timestep of their file."""
    found: dict[str, Any] = {}
    for name in track(ROBOTS, "robots", len(ROBOTS)):
        source = assets() / name
        timestep = file_timestep(source)
        given = Theirs(source, timestep, "Euler")
        controls = controls_for(source, 60 if quick else 500)
        found[name] = {"timestep": timestep}
        for engine in ENGINES:
            one = machine(engine, source, timestep)
            one.step(FRAME)
            found[name][engine] = run_of(one, given.state(), controls)
    return found


def file_timestep(source: Path) -> float:
    """Return the timestep in s that a file gives."""
    import mujoco

    return float(mujoco.MjModel.from_xml_path(str(source)).opt.timestep)


def best_of(entries: dict[str, Any]) -> str:
    """Return the integrator of MuJoCo with the shortest step that stayed finite."""
    return min((name for name in INTEGRATORS if entries[name]["finite"]), key=lambda name: entries[name]["us"])


def depth(entry: dict[str, Any]) -> str:
    """Return usual and deepest penetration, mm."""
    return f"{entry['usual']:.2f}, {entry['deepest']:.2f}" if entry["finite"] else "not finite"


def lines_of(title: str, entries: dict[str, Any]) -> list[list[str]]:
    """Return a line of a table for each engine; times of the fastest of MuJoCo's are bold."""
    lines = []
    best = best_of(entries)
    for engine in ENGINES:
        entry = entries[engine]
        name = engine if engine in (ROWS, JOINTS) else f"MuJoCo, {engine}"
        time = f"{entry['us']:.1f}"
        share = f"{entry['us'] / entries[best]['us']:.2f}"
        lines.append([title if engine == ROWS else "", name, f"**{time}**" if engine == best else time, share,
                      f"{entry['contacts']:.1f}", depth(entry)])  # fmt: skip
    return lines


HEADER = ["", "engine", "us a step", "of MuJoCo's best", "contacts", "penetration 99 %, deepest, mm"]


def report_robots(results: dict[str, Any]) -> list[Part]:
    """Return the tables of the three measurements."""
    humanoid = [line for state in STATES for line in lines_of(state, results["humanoid"][state])]
    others = [
        line for name in ROBOTS for line in lines_of(f"{name}, {1e3 * results['robots'][name]['timestep']:g} ms",
                                                     results["robots"][name])
    ]  # fmt: skip
    return [
        "## Gymnasium's humanoid, steps of 3 ms",
        "The same start states and controls in all engines, one substep a step. The lying state is one that MuJoCo "
        "reached. Penetration is measured from the poses after every fifth step.",
        Table(HEADER, humanoid, words=2),
        f"## An env step of {1e3 * ENV_STEP:g} ms of the humanoid under random torques",
        f"MuJoCo takes {FRAME} steps of 3 ms. Marked: the longest substep whose penetration stays below 1 mm in 99 % "
        "of the steps.",
        Table(["engine", "substeps", "us an env step", "contacts", "penetration 99 %, deepest, mm"],
              env_lines(results["env_step"]), words=2),
        "## Other robots under random controls, at the timestep of their file",
        Table(HEADER, others, words=2),
    ]  # fmt: skip


def env_lines(found: dict[str, Any]) -> list[list[str]]:
    """Return the lines of the env step."""
    lines = []
    for engine, cuts in found.items():
        good = [cut for cut, entry in cuts.items() if entry["finite"] and entry["usual"] < 1e3 * FINE]
        for cut, entry in cuts.items():
            time = f"{entry['us']:.0f}"
            chosen = engine not in INTEGRATORS and good and cut == good[0]
            name = engine if engine in (ROWS, JOINTS) else f"MuJoCo, {engine}"
            lines.append([name, cut, f"**{time}**" if chosen else time, f"{entry['contacts']:.1f}", depth(entry)])
    return lines
