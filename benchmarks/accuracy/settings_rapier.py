"""The settings of Rapier that are measured on a spatial case, cheap ones first.

Its contacts are springs, by default of 30 Hz and 60 Hz on static bodies. "Stiff" ones have an eighth and a quarter of
the rate of substeps, beyond which towers fly apart; "half" ones half of that, at a lower damping ratio.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .cases import Case
from .engines import Setting
from .settings import RATES
from .settings_built import BALLS, BOUNCES, FEW, JOINTED, MANY, MOVING, QUICK, SMOOTH, STANDING

ENGINE = "Rapier"
STIFF, HALF = (1.0 / 8.0, 10.0), (1.0 / 16.0, 3.0)  # of the rate of substeps; damping ratio
REDUCED = tuple((rate, count) for rate in RATES[1:7] for count in (1, 4))
# ways of a kind of case: (words of the label, values, (steps per s, substeps))
Ways = tuple[tuple[str, dict[str, Any], tuple[tuple[int, int], ...]], ...]
PLAIN: dict[str, Any] = {}
CONE = {"cone": True}
LINKS: Ways = (("", PLAIN, JOINTED), ("joint coordinates", {"reduced": True}, REDUCED))
WAYS: dict[str, Ways] = {
    "standing": (("", PLAIN, FEW), ("stiff", {"spring": STIFF}, STANDING), ("half", {"spring": HALF}, (*FEW, *MANY))),
    "moving": (("", PLAIN, MOVING), ("stiff", {"spring": STIFF}, MOVING), ("cone", CONE, MOVING)),
    "jointed": LINKS,
    "cradle": LINKS,
    "top": (("", PLAIN, SMOOTH),),
    "bounce": (("", PLAIN, BOUNCES), ("stiff", {"spring": STIFF}, BOUNCES)),
    "free": (("", PLAIN, SMOOTH),),
    "balls": (("", PLAIN, BALLS), ("stiff", {"spring": STIFF}, BALLS)),
}


def rapier_settings(case: Case, quick: bool) -> Iterator[Setting]:
    """Yield all settings of a case."""
    for word, values, grid in WAYS[case.kind]:
        for rate, substeps in QUICK if quick else sorted(set(grid), key=lambda pair: (pair[0] * pair[1], pair)):
            yield setting_of(rate, substeps, word, values)


def setting_of(rate: int, substeps: int, word: str, values: dict[str, Any]) -> Setting:
    given = {name: value for name, value in values.items() if name != "spring"}
    if "spring" in values:
        share, damping = values["spring"]
        frequency = share * rate * substeps
        given |= {"contact_softness": (frequency, damping), "static_contact_softness": (2.0 * frequency, damping)}
    label = f"{rate} Hz x {substeps}" + (f", {word}" if word else "")
    return Setting(ENGINE, label, 1.0 / rate, {"substeps": substeps, **given})
