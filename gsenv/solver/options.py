"""How a world is stepped: Options, and the named sets of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import check


class SolverKind(IntEnum):
    PGS = 0
    NNCG = 1
    SUBSPACE = 2
    SOFT = 3
    NEWTON = 4


SOLVERS = {kind.name.lower(): kind for kind in SolverKind}

OPTIONS_DTYPE = np.dtype(
    [
        ("timestep", "f8"),
        ("tolerance", "f8"),
        ("slop", "f8"),
        ("push_speed", "f8"),
        ("correction_rate", "f8"),
        ("sleep_speed", "f8"),
        ("sleep_time", "f8"),
        ("substeps", "i4"),
        ("max_substeps", "i4"),
        ("solver", "i4"),
        ("sweeps", "i4"),
        ("position_sweeps", "i4"),
        ("warm_start", "i4"),
        ("sleep", "i4"),
    ],
    align=True,
)


@dataclass(frozen=True)
class Options:
    """How a world is stepped. The defaults hold for stacks, ropes of rows and mass ratios to 1000.

    Attributes:
        timestep: s, one ``World.step``.
        substeps: solves per step; contacts are found once per step.
        max_substeps: an island whose joints are too taut for ``substeps`` takes up to this many.
        solver: ``"pgs"`` (plain projected Gauss-Seidel) or ``"nncg"`` (the same sweeps,
            accelerated as a conjugate gradient method) or ``"subspace"`` (these with direct
            steps on the active rows, where an island is a tower or chain) or ``"newton"``
            (a guarded Newton method for islands of up to 30 bodies, nncg for larger ones) or
            ``"soft"`` (sweeps with soft rows before positions move and with rigid ones after;
            made for ``substeps=4, sweeps=1``: cheap, but light bodies sag under heavy ones).
        sweeps: most sweeps per island and substep; of soft, in each of its two solves.
        tolerance: natural-map residual at which an island's sweeps stop.
        position_sweeps: sweeps of the position pass, which soft has none of.
        warm_start: start from the last impulses.
        sleep: let islands at rest stop.
        sleep_speed: m/s, fastest point of a body that counts as at rest.
        sleep_time: s at rest before an island sleeps.
        slop: overlap that is left alone, as a part of the bodies' extent.
        push_speed: extents per second, fastest separation of an overlap.
        correction_rate: part of a position error corrected per substep, 0 to 1.
    """

    timestep: float = 1.0 / 60.0
    substeps: int = 2
    max_substeps: int = 8
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

    def __post_init__(self) -> None:
        check.positive(self.timestep, "Options: timestep")
        for name in ("tolerance", "sleep_speed", "sleep_time", "slop", "push_speed", "correction_rate"):
            check.not_negative(getattr(self, name), f"Options: {name}")
        if self.correction_rate > 1.0:
            raise ValueError(f"Options: correction_rate must not exceed 1, got {self.correction_rate!r}.")
        for name, least in (("substeps", 1), ("max_substeps", 1), ("sweeps", 1), ("position_sweeps", 0)):
            check.whole(getattr(self, name), least, f"Options: {name}")
        for name in ("warm_start", "sleep"):
            if not isinstance(getattr(self, name), (bool, np.bool_)):
                raise ValueError(f"Options: {name} must be True or False, got {getattr(self, name)!r}.")
        if self.solver not in SOLVERS:
            names = ", ".join(SOLVERS)
            raise ValueError(f"Options: unknown solver {self.solver!r}; known are {names}.")

    @classmethod
    def preset(cls, fidelity: str, **changes: Any) -> Options:
        """The options of a named fidelity, with changes on top.

        Args:
            fidelity: "fast" (half the cost, errors of some 1e-3; no mass ratios above 30), "balanced"
                (the default) or "accurate" (twice the cost, errors of some 1e-6).

        Raises:
            ValueError: an unknown fidelity, or a bad option.
        """
        check.choice(fidelity, FIDELITIES, "Options: fidelity")
        return cls(**{**FIDELITIES[fidelity], **changes})

    def record(self) -> NDArray[Any]:
        """The options as a one-element structured array for the kernels."""
        record = np.zeros(1, OPTIONS_DTYPE)
        for name in OPTIONS_DTYPE.names or ():
            value = getattr(self, name)
            record[name] = int(SOLVERS[value]) if name == "solver" else value
        return record


FIDELITIES: dict[str, dict[str, Any]] = {
    "fast": {"substeps": 2, "sweeps": 8, "tolerance": 1e-3, "position_sweeps": 1},
    "balanced": {},
    "accurate": {"substeps": 8, "sweeps": 40, "tolerance": 1e-6, "position_sweeps": 4},
}
