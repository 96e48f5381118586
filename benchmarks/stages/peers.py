"""Stages of Box2D v3 and Box3D by the clock that each of them has in its steps, in turns with steps of gsenv.

The clock runs in every step, asked for or not, and is that of the wall: time in which another process has the core
counts. Every round therefore takes the same steps in a new world, and what counts is the median over all rounds of each
stage of each step: few of them are interrupted.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.engines import Setting, Simulation
from benchmarks.accuracy.engines.peers import STAGES, WHOLE
from benchmarks.accuracy.suites import Suite
from benchmarks.common.timing import cpu_time, without_collector
from benchmarks.heaps import PLAIN, SCALAR, Phase, settings_of
from gsenv.solver import Model

Array = NDArray[np.float64]

NOWHERE = "in no stage"  # time of a step between the stages


class Profiled(Simulation, Protocol):
    """A simulation whose engine has a clock in its steps."""

    def profile(self, count: int) -> Array:
        """Take ``count`` timesteps; return (step, STAGES), the wall time in s of each stage."""


@dataclass(frozen=True)
class PeerProfile:
    """An engine on a heap in one phase.

    Attributes:
        heap, phase, engine, setting: which.
        stages: us of wall time per box and step of each stage, as the engine names it, and in none.
        outside: us of CPU time per box and step, of whole steps without a profile; the mean, as gsenv's times are.
    """

    heap: str
    phase: str
    engine: str
    setting: str
    stages: dict[str, float]
    outside: float

    @property
    def name(self) -> str:
        return f"{self.engine}, {self.setting}"

    @property
    def surplus(self) -> float:
        """The us from outside that the stages do not have."""
        return self.outside - sum(self.stages.values())


@dataclass
class Rounds:
    """Rounds of an engine in one phase of a heap.

    Attributes:
        setting: of the engine.
        build: makes a new world.
        phase: of the heap.
        spent: s of CPU time that all rounds have taken, with the making of their worlds.
        stages: s, of each round (step, STAGES).
        outside: s, of each round, of all its steps.
    """

    setting: Setting
    build: Callable[[], Profiled]
    phase: Phase
    spent: float = 0.0
    stages: list[Array] = field(default_factory=list)
    outside: list[float] = field(default_factory=list)

    def keep_up(self, seconds: float) -> None:
        """Take rounds until they have taken so many seconds, at least one."""
        while self.spent < seconds or not self.outside:
            began = time.process_time()
            timed, profiled = self.ready(), self.ready()
            self.outside.append(cpu_time(lambda timed=timed: timed.step(self.phase.steps)))  # type: ignore[misc]
            with without_collector():
                self.stages.append(profiled.profile(self.phase.steps))
            self.spent += time.process_time() - began

    def ready(self) -> Profiled:
        """Return a new world at the start of the phase."""
        out = self.build()
        out.step(self.phase.before)
        return out

    def profile(self, heap: str, boxes: int) -> PeerProfile:
        """Return what all rounds tell."""
        us = 1e6 / (self.phase.steps * boxes)
        stages = {name: us * seconds for name, seconds in typical(np.array(self.stages)).items()}
        outside = us * statistics.fmean(self.outside)
        return PeerProfile(heap, self.phase.name, self.setting.engine, self.setting.label, stages, outside)


def rounds_of(suite: Suite, model: Model, phase: Phase) -> list[Rounds]:
    """Return rounds of each engine that is built from sources, at its usual setting, of each of its builds."""
    usual = [setting for setting in settings_of(suite) if setting.label in (PLAIN, SCALAR)]
    return [Rounds(setting, lambda s=setting: built(suite, model, s), phase) for setting in usual]  # type: ignore[misc]


def built(suite: Suite, model: Model, setting: Setting) -> Profiled:
    return cast(Profiled, suite.build(setting.engine)(model, setting))


def typical(rounds: Array) -> dict[str, float]:
    """Return s of each part of a step, summed over the steps of a round, each the median over all rounds.

    Args:
        rounds: s (round, step, STAGES).
    """
    whole = STAGES.index(WHOLE)
    between = 2.0 * rounds[..., whole] - rounds.sum(axis=-1)
    parts = {name: rounds[..., k] for k, name in enumerate(STAGES) if k != whole} | {NOWHERE: between}
    return {name: float(np.median(times, axis=0).sum()) for name, times in parts.items()}
