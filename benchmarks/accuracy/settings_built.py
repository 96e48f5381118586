"""The settings of engines that are built from sources, which share a solver: soft steps of equal length.

Their contacts and joints are springs, by default of 30 Hz (twice that on static bodies) and 60 Hz, but never stiffer
than an eighth and a quarter of the rate of substeps. "Stiff" asks for that limit, so errors fall with the substeps.
Points of a contact that have moved little are used again ("not recycled": never); towers drift without this.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain, product
from typing import Any

from .cases import Case
from .engines import Setting
from .settings import RATES

LIMIT = 1e6  # Hz, more than any limit
STIFF = {"contact": (LIMIT, 10.0, 3.0), "joint": (LIMIT, 2.0)}
LIVELY = {"contact": (LIMIT, 2.0, 1e3), "joint": (LIMIT, 0.1)}
NOT_RECYCLED = {"recycle": False}

# (steps per s, substeps)
FEW = ((60, 2), (60, 4), (60, 8), (30, 8), (120, 4))
MANY = ((30, 32), (60, 16), (60, 32), (60, 64), (120, 16), (120, 32), (240, 16))
STANDING = (*FEW, *MANY, (30, 16), (30, 64))
MOVING = tuple((rate, count) for rate in RATES for count in (1, 4) if rate * count >= 60)
JOINTED = (*MOVING, *MANY, (15, 32), (30, 16), (60, 128), (120, 64))
SPRING = tuple((rate, count) for rate in (15, 30, 60) for count in (1, 4, 16, 64, 256, 1024))
BOUNCES = (*((rate, 1) for rate in (*RATES[2:], 3840, 7680, 15360)), *((rate, 4) for rate in RATES[2:]))
BALLS = (*((rate, count) for rate in (60, 120, 240, 480) for count in (1, 2, 4)), (60, 8), (60, 16), (120, 8))
SMOOTH = (*((rate, 1) for rate in (*RATES[1:], 3840)), *((rate, 4) for rate in RATES))
QUICK = ((60, 4), (60, 16), (240, 4))

PLAIN: dict[str, Any] = {}
# ways of a kind of case: (words of the label, values, (steps per s, substeps))
Ways = tuple[tuple[str, dict[str, Any], tuple[tuple[int, int], ...]], ...]
CONTACTS: Ways = (("", PLAIN, FEW), ("stiff", STIFF, STANDING), ("lively", LIVELY, STANDING))
ROLLING: Ways = (("", PLAIN, MOVING), ("stiff", STIFF, MOVING), ("not recycled", NOT_RECYCLED, MOVING))
LINKS: Ways = (("", PLAIN, MOVING), ("stiff", STIFF, JOINTED), ("lively", LIVELY, JOINTED))
WAYS: dict[str, Ways] = {
    "standing": CONTACTS,
    "moving": ROLLING,
    "jointed": LINKS,
    "cradle": LINKS,
    "top": LINKS,
    "bounce": (("", PLAIN, BOUNCES), ("stiff", STIFF, BOUNCES)),
    "spring": (("", PLAIN, SPRING),),
    "free": (("", PLAIN, SMOOTH),),
    "balls": (("", PLAIN, BALLS), ("stiff", STIFF, BALLS)),
}
BOUNCING = ("bounces",)  # planar cases of the kind "moving" that are swept as "bounce"
SCALAR = ((60, 4), (60, 16))  # swept without vectors too


def settings_of(engine: str, case: Case, quick: bool) -> Iterator[Setting]:
    """Yield the settings of an engine, cheap ones first."""
    ways = WAYS["bounce" if case.key in BOUNCING else case.kind]
    for word, values, grid in ways:
        for rate, substeps in QUICK if quick else sorted(set(grid), key=lambda pair: (pair[0] * pair[1], pair)):
            yield setting_of(engine, case, rate, substeps, word, values)


def setting_of(engine: str, case: Case, rate: int, substeps: int, word: str, values: dict[str, Any]) -> Setting:
    label = f"{rate} Hz x {substeps}" + (f", {word}" if word else "")
    return Setting(engine, label, 1.0 / rate, {"substeps": substeps, "sleep": case.sleep, **values})


def box2d_v3_settings(case: Case, quick: bool) -> Iterable[Setting]:
    """Return all settings with vectors, and a few without."""
    engine = "Box2D v3"
    ways: dict[str, dict[str, Any]] = {"scalar": {"build": "scalar"}, "stiff, scalar": {"build": "scalar", **STIFF}}
    plain = (
        setting_of(engine, case, rate, count, word, values)
        for (word, values), (rate, count) in product(ways.items(), SCALAR)
    )
    return chain(settings_of(engine, case, quick), () if quick else plain)


def box3d_settings(case: Case, quick: bool) -> Iterable[Setting]:
    return settings_of("Box3D", case, quick)
