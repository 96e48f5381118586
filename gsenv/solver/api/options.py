"""Options of the simulation, and the named sets of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..records.model import JointKind, Model
from ..records.options import OPTIONS_DTYPE, SOLVERS
from ..specification import check

MOST = {"substeps": 1000, "max_substeps": 1000, "sweeps": 100_000, "halvings": 16, "position_sweeps": 100_000}


@dataclass(frozen=True)
class Options:
    """Options of the simulation. The defaults suit stacks, ropes and mass ratios up to 1000.

    Attributes:
        timestep: s, duration of one ``World.step``.
        substeps: number of solves per step; contacts are found at its start. Islands of bodies that rest on each other
            without joints take one.
        max_substeps: largest number of substeps of an island whose taut joints need more than ``substeps``.
        halvings: largest number of times that a step is halved where an overlap has grown in it, as fast impacts may
            cause; 0: steps are never divided.
        solver: the method that solves the rows.

            - ``"pgs"``: plain projected Gauss-Seidel sweeps;
            - ``"nncg"``: the same sweeps, accelerated as a nonlinear conjugate gradient method (Silcowitz, Niebe,
              Erleben 2010);
            - ``"subspace"``: nncg with direct solutions of all active rows between sweeps;
            - ``"newton"``: 2D only, a guarded Newton method for islands of up to 30 bodies, nncg for larger ones;
            - ``"soft"``: sweeps with soft rows before positions move and with rigid ones after, made for
              ``substeps=4, sweeps=1``: it is cheap, but light bodies sag under heavy ones.
        sweeps: largest number of sweeps per island and substep; for soft, in each of its two solves.
        tolerance: an island's sweeps stop when the change by a sweep, a velocity relative to the speeds before the
            solve, is below this number; docs/method.md has the formula.
        position_sweeps: number of sweeps of the position pass; soft has no position pass.
        warm_start: whether a solve starts from the impulses of the last substep.
        sleep: whether islands at rest are put to sleep.
        sleep_speed: m/s, largest speed of a body's fastest point that counts as rest.
        sleep_time: s, time at rest after which an island falls asleep.
        slop: overlap that is not corrected, as a fraction of the bodies' extent (smallest half-width).
        push_speed: extents per second, largest speed at which an overlap is corrected.
        correction_rate: fraction of a position error that is corrected per substep, 0 to 1.
        articulated: solve islands with rigid joints that form trees in joint coordinates, where these joints cost no
            rows and hold to rounding; docs/articulation.md has times and errors. False: by rows, as all other
            constraints, which compiles faster. Ignored by soft.

    Raises:
        ValueError: an option that is out of its range.
    """

    timestep: float = 1.0 / 60.0
    substeps: int = 2
    max_substeps: int = 8
    halvings: int = 5
    solver: str = "subspace"
    sweeps: int = 30
    tolerance: float = 1e-4
    position_sweeps: int = 2
    warm_start: bool = True
    sleep: bool = True
    sleep_speed: float = 0.003
    sleep_time: float = 0.5
    slop: float = 1e-4
    push_speed: float = 3.0
    correction_rate: float = 0.2
    articulated: bool = True

    def __post_init__(self) -> None:
        check.positive(self.timestep, "Options: timestep")
        for name in ("tolerance", "sleep_speed", "sleep_time", "slop", "push_speed", "correction_rate"):
            check.not_negative(getattr(self, name), f"Options: {name}")
        if self.correction_rate > 1.0:
            raise ValueError(f"Options: correction_rate must not exceed 1, got {self.correction_rate!r}.")
        for name, most in MOST.items():
            least = 0 if name in ("halvings", "position_sweeps") else 1
            check.whole(getattr(self, name), least, f"Options: {name}", most)
        for name in ("warm_start", "sleep", "articulated"):
            check.flag(getattr(self, name), f"Options: {name}")
        if not isinstance(self.solver, str) or self.solver not in SOLVERS:
            names = ", ".join(SOLVERS)
            raise ValueError(f"Options: unknown solver {self.solver!r}; known are {names}.")

    @classmethod
    def preset(cls, fidelity: str, **changes: Any) -> Options:
        """Return the options of a named fidelity, with changes.

        Args:
            fidelity: "fast" (fewer sweeps: errors of up to 1e-3, mass ratios up to 30; piles that fall take half to
                two thirds of the time with ``halvings=0``, too, and overlap by centimetres), "balanced" (the
                defaults) or "accurate" (twice the cost, errors of about 1e-6).
            changes: options by name that replace those of the fidelity.

        Raises:
            ValueError: an unknown fidelity, or a bad option.
        """
        check.choice(fidelity, FIDELITIES, "Options: fidelity")
        return cls(**{**FIDELITIES[fidelity], **changes})

    def record(self) -> NDArray[Any]:
        """Return the options as a record () of OPTIONS_DTYPE for kernels."""
        record = np.zeros((), OPTIONS_DTYPE)
        for name in OPTIONS_DTYPE.names or ():
            value = getattr(self, name)
            record[name] = int(SOLVERS[value]) if name == "solver" else value or 0
        return record


def refuse_solver(solver: str, model: Model) -> None:
    """Refuse a solver that a scene's dimension or joints do not have.

    Raises:
        ValueError: newton in 3D, or newton or soft with a gear whose row acts on the bodies of two joints.
    """
    if solver == "newton" and model.dim == 3:
        raise ValueError("World: the solver newton exists in 2D only; 3D has pgs, nncg, subspace and soft.")
    halves = (model.joints["kind"] == JointKind.GEAR) & (model.joints["row_count"] == 2)
    if solver in ("newton", "soft") and halves.any():
        name = model.joint_names[int(np.flatnonzero(halves)[0])]
        raise ValueError(
            f"World: the solver {solver} has no gears like joint {name!r}, whose joints are on moving bodies; "
            "pgs, nncg and subspace have."
        )


FIDELITIES: dict[str, dict[str, Any]] = {
    "fast": {"substeps": 2, "sweeps": 12, "position_sweeps": 1},  # a looser tolerance makes what rests dearer
    "balanced": {},
    "accurate": {"substeps": 8, "sweeps": 40, "tolerance": 1e-6, "position_sweeps": 4},
}
