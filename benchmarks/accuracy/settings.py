"""The settings of each engine that are measured on a planar case, cheap ones first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gsenv.solver.api.options import FIDELITIES
from gsenv.solver.records.options import SOLVERS

from .cases import Case
from .engines import Setting

RATES = (15, 30, 60, 120, 240, 480, 960, 1920)  # steps per s

# (solver, steps per s, substeps, tolerance)
GSENV_STANDING = (
    *((solver, 60, n, tol) for solver in SOLVERS for n in (1, 2, 4) for tol in (1e-3, 1e-4, 1e-5)),
    *(("subspace", 30, n, tol) for n in (1, 2, 4) for tol in (1e-3, 1e-4)),
    ("subspace", 120, 1, 1e-4),
    ("subspace", 120, 2, 1e-5),
    ("subspace", 240, 1, 1e-5),
)
GSENV_MOVING = tuple(("subspace", rate, n, 1e-4) for rate in RATES[:5] for n in (1, 2, 4, 8))
GSENV_JOINTED = (
    *GSENV_MOVING,
    *((solver, 60, n, tol) for solver in SOLVERS if solver != "subspace" for n in (2, 4, 8) for tol in (1e-3, 1e-5)),
)
GSENV = {"standing": GSENV_STANDING, "moving": GSENV_MOVING, "spring": GSENV_MOVING, "jointed": GSENV_JOINTED}
LINKAGES = ("jointed", "cradle")
GSENV_QUICK = (("subspace", 30, 1, 1e-4), ("subspace", 60, 1, 1e-4))
SWEEPS = {1e-3: 20, 1e-4: 30, 1e-5: 60}  # most sweeps, by tolerance

# (steps per s, velocity iterations, position iterations)
BOX2D_STANDING = (
    (60, 4, 2), (60, 8, 3), (60, 20, 10), (60, 50, 20), (60, 100, 40),
    (120, 4, 2), (120, 8, 3), (120, 20, 10), (120, 50, 20),
    (240, 4, 2), (240, 8, 3), (240, 20, 10), (480, 4, 2), (480, 8, 3), (960, 4, 2),
)  # fmt: skip
BOX2D_MOVING = tuple((rate, *counts) for rate in RATES for counts in ((2, 1), (8, 3)))
BOX2D_JOINTED = tuple(
    (rate, velocity, position)
    for rate in RATES
    for velocity, position in ((4, 2), (8, 3), (20, 10), (50, 20))
    if rate * velocity <= 12000
)
BOX2D = {"standing": BOX2D_STANDING, "moving": BOX2D_MOVING, "spring": BOX2D_MOVING, "jointed": BOX2D_JOINTED}
# (skin, scale); see box2d.py
BOX2D_SHAPES = {
    "standing": ((0.75, 1.0), (1.0, 1.0), (0.75, 10.0)),
    "moving": ((0.75, 1.0), (1.0, 1.0)),
    "spring": ((1.0, 1.0),),
    "jointed": ((1.0, 1.0),),
}
BOX2D_QUICK = ((60, 8, 3), (120, 8, 3), (240, 8, 3), (960, 4, 2))

# (steps per s, iterations)
PYMUNK_STANDING = (
    (60, 10), (60, 30), (60, 100), (120, 10), (120, 30), (120, 100),
    (240, 10), (240, 30), (240, 60), (480, 10), (480, 20), (960, 10), (1920, 10),
)  # fmt: skip
PYMUNK_MOVING = tuple((rate, count) for rate in RATES for count in (1, 2, 10))
PYMUNK_JOINTED = tuple((rate, count) for rate in RATES for count in (4, 10, 30, 100) if rate * count <= 24000)
PYMUNK = {"standing": PYMUNK_STANDING, "moving": PYMUNK_MOVING, "spring": PYMUNK_MOVING, "jointed": PYMUNK_JOINTED}
PYMUNK_QUICK = ((60, 10), (120, 10), (240, 10), (960, 10))
# (slop, part of an overlap left after 1/60 s)
PYMUNK_CONTACTS = {
    "standing": ((1e-3, 0.5), (1e-2, 0.9), (1e-4, 0.9), (1e-4, 0.5)),
    "moving": ((1e-3, 0.9), (1e-4, 0.5)),
    "jointed": ((1e-3, 0.9), (1e-4, 0.5)),
    "spring": ((1e-3, 0.9),),
}


def gsenv_settings(case: Case, quick: bool) -> Iterable[Setting]:
    return gsenv_sweep(case, GSENV_QUICK if quick else GSENV[case.kind])


def gsenv_sweep(case: Case, grid: Iterable[tuple[str, int, int, float]]) -> Iterator[Setting]:
    """Yield the fidelities, then settings of (solver, steps per s, substeps, tolerance) by rows.

    Linkages are also measured in joint coordinates, with the solver "subspace".
    """
    for mark, values in FIDELITIES.items():
        yield Setting("gsenv", mark, 1.0 / 60.0, {**values, "sleep": case.sleep}, mark)
    for solver, rate, substeps, tolerance in grid:
        label = f"{solver}, {rate} Hz x {substeps}, {tolerance:.0e}"
        values = {
            "solver": solver, "substeps": substeps, "tolerance": tolerance, "sweeps": SWEEPS[tolerance],
            "sleep": case.sleep, "articulated": False,
        }  # fmt: skip
        yield Setting("gsenv", label, 1.0 / rate, values)
        if case.kind in LINKAGES and solver == "subspace":
            yield Setting("gsenv", f"{label}, joint coordinates", 1.0 / rate, {**values, "articulated": True})


def box2d_settings(case: Case, quick: bool) -> Iterable[Setting]:
    grid = BOX2D_QUICK if quick else BOX2D[case.kind]
    shapes = BOX2D_SHAPES[case.kind]
    for skin, scale in shapes[:1] if quick else shapes:
        for rate, velocity, position in grid:
            label = f"{rate} Hz, {velocity}/{position}"
            label += ("" if skin == 1.0 else ", slop taken off") + ("" if scale == 1.0 else f", lengths x {scale:g}")
            values = {"velocity": velocity, "position": position, "skin": skin, "scale": scale, "sleep": case.sleep}
            yield Setting("Box2D", label, 1.0 / rate, values)


def pymunk_settings(case: Case, quick: bool) -> Iterable[Setting]:
    grid = PYMUNK_QUICK if quick else PYMUNK[case.kind]
    contacts = PYMUNK_CONTACTS[case.kind]
    for slop, bias in contacts[:1] if quick else contacts:
        for rate, iterations in grid:
            label = f"{rate} Hz, {iterations}, slop {slop:g}, bias {bias:g}"
            values = {"iterations": iterations, "slop": slop, "bias": bias, "sleep": case.sleep}
            yield Setting("pymunk", label, 1.0 / rate, values)
