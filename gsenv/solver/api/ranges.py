"""The ranges of masses, sizes and timesteps that the solver is made for (docs/method.md, "Known limits")."""

from __future__ import annotations

import warnings

import numpy as np

from ..records.model import Array, BodyKind, Model

MASS_RATIO = 1e6  # of the heaviest to the lightest dynamic body
HALF_WIDTH = 5e-4  # m, smallest of a dynamic body
TIMESTEP = 1.0 / 20.0  # s, largest


class RangeWarnings:
    """Warns of what exceeds the ranges, once for each of them."""

    def __init__(self) -> None:
        self._told: set[str] = set()

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

    def _warn(self, topic: str, text: str, level: int) -> None:
        if topic not in self._told:
            self._told.add(topic)
            message = f"World: {text}. Watch diagnostics().penetration and unconverged."
            warnings.warn(message, stacklevel=level + 3)
