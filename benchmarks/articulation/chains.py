"""Error against time of chains and a double pendulum that swing freely, beside MuJoCo's integrators on the same file.

The reference is MuJoCo's RK4 at 19,200 steps per second; the error is the largest distance of any link's origin to it
over all recorded times.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from benchmarks.common.progress import track
from benchmarks.common.report import Part
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time

from .engines import ENGINES, INTEGRATORS, Machine, Ours, Theirs, machine

Array = NDArray[np.float64]
REFERENCE = 19_200  # steps per second, a multiple of RECORDS
RATES = (30, 60, 120, 240, 480, 960, 1920)
RECORDS = 30  # recorded times per second
DURATION = 2.0  # s
LEVELS = (1e-2, 1e-3)  # m
CHAINS = {"chain of 20, 100x end": (20, 100.0), "chain of 5": (5, 1.0), "double pendulum": (2, 1.0)}
START = 0.5  # rad, of the first hinge


def chain_file(count: int, last: float) -> str:
    """Return the MJCF text of a chain of equal rods of 0.25 m on hinges, whose last one is ``last`` times as heavy."""
    inner = ""
    for k in reversed(range(count)):
        place = "0 0 0" if k == 0 else "0 0 -.25"
        density = 1000.0 * (last if k == count - 1 else 1.0)
        inner = (
            f'<body pos="{place}"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 -.03 0 0 -.22" size=".03" '
            f'density="{density:g}"/>{inner}</body>'
        )
    flags = '<option><flag contact="disable" limit="disable"/></option>'
    return f"<mujoco>{flags}<worldbody>{inner}</worldbody></mujoco>"


def start_of(count: int) -> tuple[Array, Array]:
    qpos = np.zeros(count)
    qpos[0] = START
    if count == 2:
        qpos[:] = (2.0, 0.5)  # a large swing
    return qpos, np.zeros(count)


def places(qpos: Array) -> Array:
    """Return the ends (link, 2) in m of all links from their angles."""
    angles = np.cumsum(qpos)
    return np.cumsum(0.25 * np.stack([-np.sin(angles), -np.cos(angles)], axis=1), axis=0)


def reference(text: str, count: int) -> Array:
    """Return the ends (record, link, 2) by fine steps of MuJoCo's RK4."""
    one = Theirs(text, 1.0 / REFERENCE, "RK4")
    one.place(*start_of(count))
    found = []
    for _ in range(round(DURATION * RECORDS)):
        one.step(REFERENCE // RECORDS)
        found.append(places(one.state()[0]))
    return np.array(found)


def swing(one: Machine, count: int, rate: int, wanted: Array, rounds: int = 5) -> dict[str, float]:
    """Return us a simulated second, the largest error in m and the share of the energy that was lost.

    Times are those of runs of their own, as in ``run_of``, the least of ``rounds``.
    """
    each, times = rate // RECORDS, []
    for _ in range(rounds):
        one.place(*start_of(count))
        times.append(sum(cpu_time(lambda: one.step(each)) for _ in wanted))
    one.place(*start_of(count))
    before = energy_of(one)
    error = 0.0
    for record in wanted:
        one.step(each)
        qpos = one.state()[0]
        error = max(error, float(np.linalg.norm(places(qpos) - record, axis=1).max()) if finite(qpos) else 1e3)
    us = 1e6 * min(times) / DURATION
    return {"us": us, "error": min(error, 1e3), "lost": before - energy_of(one)}


def finite(values: Array) -> bool:
    return bool(np.isfinite(values).all())


def energy_of(one: Machine) -> float:
    """Return the energy in J; 0 where it is not finite."""
    if isinstance(one, Ours):
        energy = float(one.world.diagnostics().energy[0])
    else:
        assert isinstance(one, Theirs)
        mujoco.mj_energyPos(one.model, one.data)
        mujoco.mj_energyVel(one.model, one.data)
        energy = float(one.data.energy.sum())
    return energy if np.isfinite(energy) else 0.0


def measure_chains(quick: bool) -> dict[str, Any]:
    """Return, of each chain, engine and rate, what ``swing`` returns."""
    rates = RATES[:4] if quick else RATES
    found: dict[str, Any] = {}
    for name, (count, last) in track(CHAINS.items(), "chains", len(CHAINS)):
        text = chain_file(count, last)
        wanted = reference(text, count)
        found[name] = {}
        for engine in ENGINES:
            runs = {}
            for rate in rates:
                one = machine(engine, text, 1.0 / rate, max_substeps=8)
                one.step(1)
                runs[str(rate)] = swing(one, count, rate, wanted)
            found[name][engine] = runs
    return found


def least(runs: dict[str, Any], level: float) -> tuple[float, str] | None:
    """Return us a simulated second and rate of the cheapest run with at most this error in m."""
    good = [(entry["us"], rate) for rate, entry in runs.items() if entry["error"] <= level]
    return min(good) if good else None


def report_chains(results: dict[str, Any]) -> list[Part]:
    """Return a table of the cheapest run at each level of error."""
    lines = []
    for name, engines in results.items():
        for engine in ENGINES:
            cells = [name if engine == ENGINES[0] else "", engine if engine not in INTEGRATORS else f"MuJoCo, {engine}"]
            for level in LEVELS:
                found = least(engines[engine], level)
                best = min((one[0] for one in (least(engines[i], level) for i in INTEGRATORS) if one), default=None)
                if found is None:
                    cells += ["not reached", ""]
                else:
                    us = f"{found[0]:.0f}"
                    share = f"{found[0] / best:.2f}" if best else ""
                    cells += [f"**{us}** at {found[1]}" if found[0] == best else f"{us} at {found[1]}", share]
            lines.append(cells)
    header = ["", "engine"]
    for level in LEVELS:
        header += [f"us a simulated s at {1e3 * level:g} mm", "of MuJoCo's best"]
    text = (
        f"Rods of 0.25 m on hinges, let go at rest, {DURATION:g} s; the double pendulum starts at 2 and 0.5 rad. The "
        f"error is the largest distance of the end of a link to MuJoCo's RK4 at {REFERENCE:,} steps per second. "
        "Steps per second follow after the times; gsenv takes the substeps that its rule for taut joints asks for."
    )
    return ["## Chains: error against time", text, Table(header, lines, words=2)]
