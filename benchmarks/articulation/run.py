"""Measures all parts and reports them."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from benchmarks.common.report import Picture, Report
from benchmarks.common.run import Run
from benchmarks.common.stamp import version_of

from .chains import measure_chains, report_chains
from .crowds import measure_car, measure_heap, report_crowds
from .plot import draw
from .ragdoll import measure_ragdolls, report_ragdolls
from .robots import measure_env_step, measure_humanoid, measure_others, report_robots


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seconds", type=float, default=10.0, help="simulated time of the free chain")


def measure(run: Run) -> dict[str, Any]:
    run.stamp["versions"] |= {"MuJoCo": version_of("mujoco"), "Gymnasium": version_of("gymnasium")}
    return {
        "humanoid": measure_humanoid(run.quick),
        "env_step": measure_env_step(run.quick),
        "robots": measure_others(run.quick),
        "chains": measure_chains(run.quick),
        "heap": measure_heap(run.quick),
        "car": measure_car(run.quick),
        "ragdolls": measure_ragdolls(run.quick, run.options.seconds),
    }


def report(results: Mapping[str, Any]) -> Report:
    text = (
        "CPU time of one core. `rows` solves joints as rows beside contacts, `joint coordinates` is "
        "`Options(articulated=True)`; islands that it cannot solve take rows. MuJoCo runs the same file with the "
        "options of the file but for timestep and integrator. Its fastest integrator is bold, and the times are also "
        "given as shares of it. A step of gsenv makes contacts and limits hold to its tolerance and keeps overlaps "
        "small, those of MuJoCo are soft; the columns of contacts and penetration belong to the time."
    )
    picture = Picture("Errors of chains against CPU time, in gsenv and MuJoCo", lambda: draw(results["chains"]))
    return Report(
        "Bodies on joints: rows, joint coordinates, MuJoCo",
        [
            text,
            *report_robots(dict(results)),
            *report_chains(results["chains"]),
            picture,
            *report_crowds(dict(results)),
            *report_ragdolls(results["ragdolls"]),
        ],
    )
