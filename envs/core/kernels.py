"""Kernels that tasks share; `world` is a Task's `kernel_world`, of which one world is selected."""

from __future__ import annotations

import math

from gsenv.solver.jit import njit


@njit
def between(low, high, draw):  # type: ignore[no-untyped-def]
    """Return a draw from [0, 1) scaled to [low, high)."""
    return low + (high - low) * draw


@njit
def smooth(x):  # type: ignore[no-untyped-def]
    """Return a smooth step: 0 below 0, 1 above 1, and a cubic with level ends in between."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@njit
def within(x, high):  # type: ignore[no-untyped-def]
    """Return x, but at least 0 and at most `high`; 0 for NaN, which would be any index."""
    return min(x, high) if x > 0.0 else 0.0


@njit
def clip(out, low, high):  # type: ignore[no-untyped-def]
    """Clip numbers (entry,) to their bounds, in place."""
    for i in range(len(out)):
        out[i] = min(max(out[i], low[i]), high[i])


@njit
def first_not_finite(actions):  # type: ignore[no-untyped-def]
    """Return the first world whose actions (world, ...) are not all finite, or -1."""
    for w in range(len(actions)):
        for value in actions[w].flat:
            if not math.isfinite(value):
                return w
    return -1


@njit
def active_contacts(world):  # type: ignore[no-untyped-def]
    """Return the contacts (contact,) of the last step."""
    return world.state.contacts[: world.state.world.contact_count]
