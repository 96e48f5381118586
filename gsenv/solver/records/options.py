"""Options as a record for kernels; the fields, with their units, are those of ``api.options.Options``."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


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
        ("halvings", "i4"),
        ("solver", "i4"),
        ("sweeps", "i4"),
        ("position_sweeps", "i4"),
        ("warm_start", "i4"),
        ("sleep", "i4"),
    ],
    align=True,
)
