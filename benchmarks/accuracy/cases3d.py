"""The spatial scenes with known answers that engines are judged on."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from gsenv.scenes.spatial import (
    ball_chain,
    block_on_incline,
    bouncing_spheres,
    cube_mass_ratio,
    cube_pyramid,
    cube_stack,
    gyroscope,
    precession,
    roller_on_incline,
    sliding_roller,
    sphere_cradle,
    sphere_grid,
    spinning_box,
    two_rods,
)

from .cases import Case, tower
from .errors import G, apex_error, chain_error, cradle_error, distance_error, energy_error, slide_to_roll_error
from .errors3d import ball_overlap, flip_times, precession_error, slope_error, tumbling_error

SLOW, FAST = ((1.0, 2.0, 3.0), (0.01, 1.0, 0.01)), ((0.4, 0.9, 1.1), (0.02, 5.0, 0.02))  # inertia, spin
FIRST_FLIP, FLIP_PERIOD = 10.9169135, 19.5528671  # s, of SLOW


def turning() -> list[Case]:
    flips = np.array([FIRST_FLIP + k * FLIP_PERIOD for k in range(3)])  # s, until 60
    return [
        Case("tumbling:slow", "tumbling wing nut, 60 s", partial(spinning_box, *SLOW), 60.0,
             partial(tumbling_error, expected=flips), kind="free"),
        Case("tumbling:fast", "tumbling at 5 rad/s, 10 s", partial(spinning_box, *FAST), 10.0,
             partial(tumbling_error, expected=flip_times(*FAST, 10.0)), kind="free"),
        Case("gyroscope", "gyroscope's precession", gyroscope, 5.0,
             partial(precession_error, rate=precession()), kind="top"),
    ]  # fmt: skip


def _fallen(acceleration: float, t: Any) -> Any:
    return 0.5 * acceleration * t**2


def slopes() -> list[Case]:
    steep, gentle = math.radians(35.0), math.radians(20.0)
    slide = G * (math.sin(steep) - 0.5 * math.cos(steep))
    roll = G * math.sin(gentle)
    cases = []
    for kind, inertia in (("sphere", 0.4), ("cylinder", 0.5)):
        down = roll / (1.0 + inertia)
        cases += [
            Case(f"slide_to_roll:{kind}", f"sliding {kind} starts to roll", partial(sliding_roller, kind), 2.0,
                 partial(slide_to_roll_error, speed=3.0, friction=0.3, inertia=inertia), quick=kind == "sphere"),
            Case(f"rolling:{kind}", f"{kind} rolls down 20°", partial(roller_on_incline, kind), 2.0,
                 partial(distance_error, law=partial(_fallen, down)), quick=kind == "sphere"),
        ]  # fmt: skip
    for heading in (0, 30, 45):
        a, h = steep, math.radians(heading)
        down_slope = (math.cos(a) * math.cos(h), math.cos(a) * math.sin(h), -math.sin(a))
        cases.append(
            Case(f"incline:slide{heading}", f"block slides, slope to {heading}°",
                 partial(block_on_incline, 35.0, heading), 2.0,
                 partial(slope_error, law=lambda t: 0.5 * slide * t**2, direction=down_slope), quick=heading == 30)
        )  # fmt: skip
    for heading, turn in ((0, 0), (45, 0), (30, 20)):
        title = f"stays, {heading}°, turned {turn}° (m)"
        cases.append(
            Case(f"incline:stay{heading}", title, partial(block_on_incline, 20.0, heading, turn), 5.0,
                 partial(distance_error, law=lambda t: 0.0 * t), quick=heading == 30)
        )  # fmt: skip
    return cases


def towers() -> list[Case]:
    return [
        tower("tower:10", "tower of 10", partial(cube_stack, 10), 10.0),
        tower("tower:20", "tower of 20", partial(cube_stack, 20), 10.0, quick=False),
        tower("tower:50", "tower of 50", partial(cube_stack, 50), 10.0, quick=False),
        tower("mass_ratio:10", "10 kg on 1 kg", partial(cube_mass_ratio, 10.0), 5.0, quick=False),
        tower("mass_ratio:100", "100 kg on 1 kg", partial(cube_mass_ratio, 100.0), 5.0),
        tower("mass_ratio:1000", "1000 kg on 1 kg", partial(cube_mass_ratio, 1000.0), 5.0),
        tower("pyramid:10", "pyramid, base 10", partial(cube_pyramid, 10), 10.0, quick=False),
    ]


def linkages() -> list[Case]:
    return [
        *(Case(f"cradle:{k}", f"cradle of 5, {k} raised", partial(sphere_cradle, k), 1.5,
               partial(cradle_error, raised=k), kind="cradle", quick=k == 1) for k in (1, 2)),
        Case("heavy_chain", "chain of 20, heavy end", ball_chain, 10.0,
             partial(chain_error, link=0.25), kind="jointed"),
        Case("two_rods", "energy of two rods", two_rods, 10.0, partial(energy_error, link=1.0), kind="jointed"),
    ]  # fmt: skip


def all_cases() -> list[Case]:
    """In the order of the tables."""
    bounce = Case("bounces", "three bounces, e = .8", partial(bouncing_spheres, [0.8]), 2.2,
                  partial(apex_error, restitution=0.8), kind="bounce")  # fmt: skip
    balls = Case("balls", "216 balls fall apart (m)", sphere_grid, 3.0, ball_overlap, kind="balls", quick=False)
    return [*turning(), *linkages(), *slopes(), bounce, *towers(), balls]
