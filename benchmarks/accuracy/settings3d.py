"""The settings of each engine that are measured on a spatial case, cheap ones first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any

from .cases import Case
from .engines import Setting
from .settings import GSENV_QUICK, RATES, gsenv_sweep

# (solver, steps per s, substeps, tolerance)
GSENV_MOVING = tuple(("subspace", rate, n, 1e-4) for rate in RATES[:5] for n in (1, 2, 4))
GSENV_STANDING = (
    *((solver, 60, n, tol) for solver in ("subspace", "nncg", "soft") for n in (1, 2, 4) for tol in (1e-3, 1e-4)),
    *(("subspace", 30, n, tol) for n in (1, 2) for tol in (1e-3, 1e-4)),
    *(("subspace", 120, n, 1e-5) for n in (1, 2)),
)
GSENV_JOINTED = (*GSENV_MOVING, *(("subspace", rate, 8, 1e-4) for rate in RATES[:5]))
GSENV_BALLS = tuple((s, rate, n, 1e-3) for s in ("subspace", "nncg") for rate in (30, 60, 120, 240) for n in (1, 2, 4))
GSENV = {
    "free": GSENV_JOINTED,
    "top": GSENV_JOINTED,
    "moving": GSENV_MOVING,
    "bounce": GSENV_MOVING,
    "cradle": GSENV_MOVING,
    "jointed": GSENV_JOINTED,
    "standing": GSENV_STANDING,
    "balls": GSENV_BALLS,
}


def gsenv_settings(case: Case, quick: bool) -> Iterable[Setting]:
    return gsenv_sweep(case, GSENV_QUICK if quick else GSENV[case.kind])


def mujoco_setting(rate: int, integrator: str = "Euler", **values: Any) -> Setting:
    """Return a setting whose label names what differs from MuJoCo's defaults."""
    label = ", ".join(
        [f"{rate} Hz", integrator, *(v if isinstance(v, str) else f"{k} {v:g}" for k, v in values.items())]
    )
    return Setting("MuJoCo", label, 1.0 / rate, {"integrator": integrator, **values})


def mujoco_moving() -> Iterator[Setting]:
    for rate in RATES:
        for cone, timeconst in product(("elliptic", "pyramidal"), (2.0, 3.0, 8.0)):
            yield mujoco_setting(rate, cone=cone, timeconst=timeconst)
        yield mujoco_setting(rate, "RK4", cone="elliptic", timeconst=3.0)
        yield mujoco_setting(rate, cone="elliptic", timeconst=8.0, dmin=0.999, dmax=0.999)
        yield mujoco_setting(rate, cone="elliptic", timeconst=2.0, noslip=3)
        yield mujoco_setting(rate, cone="elliptic", timeconst=3.0, impratio=100.0)


def mujoco_standing() -> Iterator[Setting]:
    for rate, cone in product((30, 60, 90, 120, 240, 480), ("elliptic", "pyramidal")):
        for dmax in (0.95, 0.99, 0.999):
            yield mujoco_setting(rate, "implicitfast", cone=cone, dmax=dmax, dmin=dmax)
    for rate in (30, 60, 120, 240):
        yield mujoco_setting(rate, "implicitfast", cone="elliptic", solver="CG", iterations=50, dmax=0.99, dmin=0.99)
        yield mujoco_setting(rate, "implicitfast", cone="elliptic", iterations=4, dmax=0.99, dmin=0.99)


def mujoco_big() -> Iterator[Setting]:
    for rate, cone in product((60, 120, 240), ("elliptic", "pyramidal")):
        yield mujoco_setting(rate, "implicitfast", cone=cone, dmax=0.99, dmin=0.99)
    for rate in (120, 240):
        yield mujoco_setting(rate, "implicitfast", cone="pyramidal", solver="CG", iterations=50, dmax=0.99, dmin=0.99)


def mujoco_bounces() -> Iterator[Setting]:
    for rate, steps, integrator in product((60, 120, 240, 480, 960, 1920, 3840), (4, 8, 16, 32), ("Euler", "RK4")):
        yield mujoco_setting(rate, integrator, contact_steps=float(steps))


def mujoco_smooth() -> Iterator[Setting]:
    for rate, integrator in product(RATES, ("Euler", "implicitfast", "RK4")):
        yield mujoco_setting(rate, integrator)


def mujoco_top() -> Iterator[Setting]:
    """Yield settings for a fast top, which blows up with Euler and implicitfast at lower rates."""
    for rate in RATES:
        yield mujoco_setting(rate, "RK4")
    for rate, integrator in product((3840, 7680, 15360), ("Euler", "implicitfast")):
        yield mujoco_setting(rate, integrator)


def mujoco_balls() -> Iterator[Setting]:
    for rate, dmax in product((30, 60, 90, 120, 240, 480), (0.95, 0.99, 0.999)):
        yield mujoco_setting(rate, "implicitfast", dmax=dmax, dmin=dmax)
        yield mujoco_setting(rate, "implicitfast", solver="CG", iterations=20, dmax=dmax, dmin=dmax)


MUJOCO = {
    "free": mujoco_smooth,
    "top": mujoco_top,
    "moving": mujoco_moving,
    "bounce": mujoco_bounces,
    "cradle": mujoco_bounces,
    "jointed": mujoco_smooth,
    "standing": mujoco_standing,
    "balls": mujoco_balls,
}
BIG = ("tower:50", "pyramid:20")  # cases where only a few settings are swept
MUJOCO_QUICK = ((60, "elliptic"), (240, "elliptic"), (60, "pyramidal"))


def mujoco_settings(case: Case, quick: bool) -> Iterable[Setting]:
    if quick and case.kind == "top":
        return [mujoco_setting(rate, "RK4") for rate in (60, 240)]
    if quick and case.kind in ("free", "jointed"):
        return [mujoco_setting(rate, integrator) for rate in (60, 240) for integrator in ("implicitfast", "RK4")]
    if quick and case.kind in ("bounce", "cradle"):
        return [mujoco_setting(rate, "Euler", contact_steps=8.0) for rate in (240, 960)]
    if quick:
        return [mujoco_setting(rate, "implicitfast", cone=cone) for rate, cone in MUJOCO_QUICK]
    return mujoco_big() if case.key in BIG else MUJOCO[case.kind]()


# (steps per s, iterations)
PYBULLET_STANDING = (
    (60, 10), (60, 50), (60, 200), (120, 10), (120, 50), (240, 10), (240, 50), (480, 10), (960, 10),
)  # fmt: skip
PYBULLET_MOVING = tuple((rate, count) for rate in RATES for count in (2, 10))
PYBULLET_SMOOTH = tuple((rate, 1) for rate in (*RATES, 3840))
PYBULLET_BOUNCES = tuple((rate, 10) for rate in (*RATES[2:], 3840))
PYBULLET = {
    "free": PYBULLET_SMOOTH,
    "moving": PYBULLET_MOVING,
    "bounce": PYBULLET_BOUNCES,
    "cradle": PYBULLET_BOUNCES,
    "jointed": PYBULLET_SMOOTH,
    "standing": PYBULLET_STANDING,
    "balls": PYBULLET_STANDING,
}
PYBULLET_QUICK = ((60, 10), (240, 10), (960, 10))
# (plain rigid bodies, part of an overlap taken back per step)
PYBULLET_BODIES = {
    "standing": ((True, 0.2), (False, 0.2)),
    "moving": ((True, 0.2), (False, 0.2)),
    "balls": ((True, 0.2), (False, 0.2)),
    "free": ((True, 0.2), (False, 0.2)),
    "bounce": ((True, 0.2), (False, 0.2)),
    "cradle": ((False, 0.2),),
    "jointed": ((False, 0.2),),
}


def pybullet_settings(case: Case, quick: bool) -> Iterable[Setting]:
    if case.kind == "top":
        return  # the benchmark's links start at rest there
    grid = PYBULLET_QUICK if quick else PYBULLET[case.kind]
    if case.key in BIG:
        grid = PYBULLET_STANDING[1:7]
    bodies = PYBULLET_BODIES[case.kind][: 1 if case.key in BIG else None]
    for maximal, erp in bodies[:1] if quick else bodies:
        for rate, iterations in grid:
            label = f"{rate} Hz, {iterations}, erp {erp:g}" + (", maximal" if maximal else "")
            yield Setting("PyBullet", label, 1.0 / rate, {"iterations": iterations, "maximal": maximal, "erp": erp})
