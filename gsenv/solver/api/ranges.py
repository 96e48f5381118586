"""The ranges of masses, sizes and timesteps that the solver is made for (docs/method.md, "Known limits")."""

from __future__ import annotations

import warnings

from ..records.model import Model

MASS_RATIO = 1e6  # of the heaviest to the lightest dynamic body
HALF_WIDTH = 5e-4  # m, smallest of a dynamic body
TIMESTEP = 1.0 / 20.0  # s, largest


def warn_of_ranges(model: Model, timestep: float) -> None:
    """Warn in one sentence each of what exceeds the ranges; Python shows a warning of one place only once."""
    bodies = model.nominal_bodies[model.bodies["kind"] == 2]
    masses = bodies["mass"][bodies["mass"] > 0.0]
    if len(masses) and masses.max() > MASS_RATIO * masses.min() * (1.0 + 1e-9):
        _warn(
            f"the mass ratio of its bodies is {masses.max() / masses.min():.1g}; contacts hold up to {MASS_RATIO:.0e}"
        )
    extents = bodies["extent"][bodies["extent"] > 0.0]
    if len(extents) and extents.min() < HALF_WIDTH:
        _warn(f"a body has a half-width of {extents.min():.1g} m; contacts hold from {HALF_WIDTH:.0e} m")
    if timestep > TIMESTEP * (1.0 + 1e-9):
        _warn(f"the timestep is {timestep:.2g} s; results are tested up to {TIMESTEP:g} s")


def _warn(text: str) -> None:
    warnings.warn(f"World: {text}. Watch diagnostics().penetration and unconverged.", stacklevel=4)
