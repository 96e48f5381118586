"""Warnings of what exceeds the ranges that the solver is made for (docs/method.md, "Known limits")."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np

from ..readings.diagnostics import finite_bodies
from ..records.model import Array, BodyKind, Model
from ..records.state import State

MASS_RATIO = 1e6  # of the heaviest to the lightest dynamic body
HALF_WIDTH = 5e-4  # m, smallest of a dynamic body
TIMESTEP = 1.0 / 20.0  # s, largest
HERE = Path(__file__).parent


class RangeWarnings:
    """Warns once of each range that is exceeded, and of each world whose numbers are not finite any more.

    Attributes:
        lost: (world,) bool, the worlds whose numbers are not finite; None where there is none.
    """

    def __init__(self) -> None:
        self._told: set[str] = set()
        self.lost: Array | None = None
        self._told_lost: Array | None = None  # (world,) bool, the lost ones of which it has warned

    def check_timestep(self, timestep: float, level: int) -> None:
        """Warn of a long timestep, s; ``level``: number of calls between the user's line and this one."""
        if timestep > TIMESTEP * (1.0 + 1e-9):
            text = f"the timestep is {timestep:.2g} s; results are tested up to {TIMESTEP:g} s"
            self._warn("timestep", text, level)

    def check_bodies(self, model: Model, bodies: Array, level: int) -> None:
        """Warn of masses and sizes of ``bodies`` (world, body), parameters; ``level`` as above."""
        dynamic = bodies[:, model.bodies["kind"] == BodyKind.DYNAMIC]
        masses, extents = dynamic["mass"], dynamic["extent"]
        if masses.size:
            ratio = float((masses.max(1) / masses.min(1, initial=np.inf, where=masses > 0.0)).max())
            if ratio > MASS_RATIO * (1.0 + 1e-9):
                text = f"the mass ratio of its bodies is {ratio:.1g}; contacts hold up to {MASS_RATIO:.0e}"
                self._warn("mass", text, level)
        least = float(extents.min(initial=np.inf, where=extents > 0.0))
        if least < HALF_WIDTH:
            text = f"a body has a half-width of {least:.1g} m; contacts hold from {HALF_WIDTH:.0e} m"
            self._warn("size", text, level)

    def check_finite(self, model: Model, state: State) -> None:
        """Warn of worlds with a body whose position or velocity has become NaN or infinite."""
        self.look(state, np.arange(len(state.bodies)))
        told = self._told_lost
        self._told_lost = None if self.lost is None else self.lost.copy()
        if self.lost is None:
            return
        new = self.lost if told is None else self.lost & ~told
        if not new.any():
            return
        world = int(np.argmax(new))
        name = model.body_names[int(np.argmin(finite_bodies(state.bodies[world])))]
        others = int(new.sum()) - 1
        more = f" and bodies in {others} other world{'s' if others > 1 else ''}" if others else ""
        warnings.warn(
            f"World: by step {state.worlds['step'][world]} the pose or velocity of body {name!r} in world "
            f"{world}{more} has become NaN or infinite: a force, speed, mass or size is too extreme. Reset the world "
            "or restore a snapshot; diagnostics().finite tells which worlds are affected.",
            RuntimeWarning,
            stacklevel=_level_of_user(),
        )

    def look(self, state: State, chosen: Array) -> None:
        """Set ``lost`` of the chosen worlds, indices, without a warning."""
        now: Array = ~np.all(finite_bodies(state.bodies[chosen]), axis=1)
        if self.lost is None and not now.any():
            return
        lost: Array = np.zeros(len(state.bodies), np.bool_) if self.lost is None else self.lost
        lost[chosen] = now
        self.lost = lost if lost.any() else None

    def forget(self, chosen: Array) -> None:
        """Take these worlds as not lost, and warn of them again: they are reset."""
        if self._told_lost is not None:
            self._told_lost[chosen] = False
        if self.lost is not None:
            self.lost[chosen] = False
            if not self.lost.any():
                self.lost = None

    def _warn(self, topic: str, text: str, level: int) -> None:
        if topic not in self._told:
            self._told.add(topic)
            message = f"World: {text}. Watch diagnostics().penetration and unconverged."
            warnings.warn(message, stacklevel=level + 3)


def _level_of_user() -> int:
    """Return the number of calls between the caller and the first function outside this folder, for ``stacklevel``."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and Path(frame.f_code.co_filename).parent == HERE:
        level, frame = level + 1, frame.f_back
    return level
