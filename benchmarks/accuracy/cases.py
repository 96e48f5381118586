"""The scenes with known answers that engines are judged on, and for how long each runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from gsenv.scenes import (
    bouncing_balls,
    box_on_incline,
    chain,
    cradle,
    disk_on_incline,
    double_pendulum,
    hanging_chain,
    hanging_mode,
    mass_ratio_stack,
    pendulum,
    pyramid,
    sliding_disk,
    spring_mass,
    stack,
)
from gsenv.solver import Scene

from .errors import (
    G,
    apex_error,
    chain_error,
    cradle_error,
    distance_error,
    energy_error,
    period_error,
    slide_to_roll_error,
    spring_error,
    standing_error,
)
from .trajectory import Trajectory

SMOOTH_RATE = 60.0  # samples per s where the motion matters
STANDING_RATE = 2.0  # where only what is left of it does


@dataclass(frozen=True)
class Case:
    """One scene and its answer.

    Attributes:
        key: its family and, where that has more than one, which case of it: "tower:10".
        title: for people, with the error's unit if it has one.
        scene: builds it.
        seconds: simulated.
        error: of a trajectory.
        rate: samples per simulated s.
        sleep: whether bodies may sleep.
        kind: what the settings are chosen by: "moving" (one body on the ground), "spring", "jointed" (linkages),
            "standing" (many bodies at rest); in 3D also "free", "top", "bounce", "cradle" and "balls".
        quick: whether the quick run has it.
    """

    key: str
    title: str
    scene: Callable[[], Scene]
    seconds: float
    error: Callable[[Trajectory], float]
    rate: float = SMOOTH_RATE
    sleep: bool = False
    kind: str = "moving"
    quick: bool = True

    @property
    def family(self) -> str:
        """First part of the key."""
        return self.key.partition(":")[0]


def tower(
    key: str, title: str, scene: Callable[[], Scene], seconds: float, sleep: bool = False, quick: bool = True
) -> Case:
    title += ", may sleep (m)" if sleep else " (m)"
    return Case(key, title, scene, seconds, standing_error, STANDING_RATE, sleep, "standing", quick)


def slopes() -> list[Case]:
    steep, gentle = math.radians(35.0), math.radians(20.0)
    slide = G * (math.sin(steep) - 0.5 * math.cos(steep))
    roll = 2.0 / 3.0 * G * math.sin(gentle)
    return [
        Case("slide_to_roll", "sliding disk starts to roll", sliding_disk, 2.0,
             partial(slide_to_roll_error, speed=3.0, friction=0.3)),
        Case("rolling", "disk rolls down 20°", partial(disk_on_incline, 20.0), 2.0,
             partial(distance_error, law=lambda t: 0.5 * roll * t**2)),
        Case("incline:slide", "block slides down 35°", partial(box_on_incline, 35.0), 2.0,
             partial(distance_error, law=lambda t: 0.5 * slide * t**2)),
        Case("incline:stay", "block stays on 20° (m)", partial(box_on_incline, 20.0), 5.0,
             partial(distance_error, law=lambda t: 0.0 * t)),
    ]  # fmt: skip


def towers() -> list[Case]:
    return [
        tower("tower:10", "tower of 10", partial(stack, 10), 10.0),
        tower("tower:20", "tower of 20", partial(stack, 20), 10.0),
        tower("tower:50", "tower of 50", partial(stack, 50), 10.0, quick=False),
        tower("mass_ratio:10", "10 kg on 1 kg", partial(mass_ratio_stack, 10.0), 5.0),
        tower("mass_ratio:100", "100 kg on 1 kg", partial(mass_ratio_stack, 100.0), 5.0),
        tower("mass_ratio:1000", "1000 kg on 1 kg", partial(mass_ratio_stack, 1000.0), 5.0),
        tower("pyramid:10", "pyramid, base 10", partial(pyramid, 10), 10.0),
        tower("pyramid:20", "pyramid, base 20", partial(pyramid, 20), 10.0, quick=False),
        tower("tower:10-sleep", "tower of 10", partial(stack, 10), 10.0, sleep=True),
        tower("pyramid:10-sleep", "pyramid, base 10", partial(pyramid, 10), 10.0, sleep=True),
        tower("pyramid:20-sleep", "pyramid, base 20", partial(pyramid, 20), 10.0, sleep=True, quick=False),
    ]


def pendulums() -> list[Case]:
    """Periods over 2 pi sqrt(I / (m g d)) are 2 K(sin(angle / 2)) / pi, K the complete elliptic integral."""
    small = 2.0 * math.pi * math.sqrt(1.0 / (1.5 * G))  # of a thin rod of 1 m
    return [
        Case(f"pendulum:{degrees}", f"pendulum's period, {degrees}°", partial(pendulum, degrees), 10.0,
             partial(period_error, expected=ratio * small), kind="jointed")
        for degrees, ratio in ((90, 1.1803406), (150, 1.7622037))
    ]  # fmt: skip


def linkages() -> list[Case]:
    slowest = 2.0 * math.pi / (hanging_mode(10)[0] * math.sqrt(G))  # of a chain of 1 m
    return [
        Case("chain_period", "period of a chain of 10", hanging_chain, 10.0,
             partial(period_error, expected=slowest), kind="jointed"),
        *(Case(f"cradle:{k}", f"cradle of 5, {k} raised", partial(cradle, k), 1.5,
               partial(cradle_error, raised=k), kind="jointed") for k in (1, 2)),
        Case("heavy_chain", "chain of 20, end 100 times heavier", partial(chain, last_mass=100.0), 10.0,
             partial(chain_error, link=0.25), kind="jointed"),
        Case("double_pendulum", "energy of a double pendulum", double_pendulum, 10.0,
             partial(energy_error, link=1.0), kind="jointed"),
    ]  # fmt: skip


def springs() -> list[Case]:
    return [
        Case(f"spring:{z:g}", f"spring of 2 Hz, damping ratio {z:g}", partial(spring_mass, 2.0, z), 2.5,
             partial(spring_error, frequency=2.0, damping_ratio=z), kind="spring")
        for z in (0.0, 0.2, 1.0)
    ]  # fmt: skip


def all_cases() -> list[Case]:
    """In the order of the tables."""
    bounce = Case("bounces", "three bounces, e = .8", partial(bouncing_balls, [0.8]), 2.2,
                  partial(apex_error, restitution=0.8))  # fmt: skip
    return [*pendulums(), *linkages(), *slopes(), bounce, *towers(), *springs()]
