"""Periods of what swings, by its zero crossings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gsenv.solver import World


def crossing(before: float, after: float, rate_before: float, rate_after: float) -> float:
    """Where in a step, 0 to 1, the cubic through values and rates (per step) is zero."""
    cubic = np.polynomial.Polynomial(
        [before, rate_before, 3.0 * (after - before) - 2.0 * rate_before - rate_after,
         2.0 * (before - after) + rate_before + rate_after]
    )  # fmt: skip
    roots = cubic.roots()
    real = roots.real[(abs(roots.imag) < 1e-9) & (roots.real >= -1e-9) & (roots.real <= 1.0 + 1e-9)]
    return float(real[0])


def period(world: World, coordinate: Callable[[], tuple[float, float]], swings: int = 2) -> float:
    """s of one swing of a coordinate (value, rate) about zero, from its zero crossings."""
    value, rate = coordinate()
    times: list[float] = []
    while len(times) < 2 * swings + 1:
        world.step()
        new, new_rate = coordinate()
        if value * new < 0.0:
            part = crossing(value, new, world.timestep * rate, world.timestep * new_rate)
            times.append(float(world.time[0]) - world.timestep * (1.0 - part))
        value, rate = new, new_rate
        assert world.time[0] < 60.0
    return (times[-1] - times[0]) / swings
