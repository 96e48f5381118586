"""Coefficients of friction of shapes.

MuJoCo takes the larger coefficient of two geoms, or none where both have condim 1; a Scene takes the geometric mean.
The shapes' coefficients are chosen so that contacts of moving geoms with fixed ones get MuJoCo's coefficient.
"""

from __future__ import annotations

from collections.abc import Sequence

from .errors import Notes
from .model import Geom, MjcfModel

TOPIC = "friction is the geometric mean of two coefficients, which here differs from MuJoCo's, the larger one"
OWN_FRICTION = "the friction of a contact pair is ignored, that of its geoms counts"


def shape_frictions(
    model: MjcfModel, fixed: Sequence[bool], bits: Sequence[tuple[int, int]], notes: Notes
) -> list[float]:
    """Return the coefficient of each geom's shape.

    Args:
        fixed: whether each geom is on a body that does not move.
        bits: category and mask of each geom.
    """
    for pair in model.pairs:
        if pair.friction is not None or pair.condim is not None:
            notes.add(OWN_FRICTION, f"{pair.place}: pair")
    touching = [mask != 0 for _, mask in bits]
    grounds = {(geom.friction[0], geom.condim) for geom, still, on in zip(model.geoms, fixed, touching, strict=True)
               if still and on}  # fmt: skip
    if len(grounds) == 1:
        ground, condim = next(iter(grounds))
        base = ground if ground > 0.0 else 1.0
        values = [_together(geom, float(ground), condim) ** 2 / base for geom in model.geoms]
        values = [base if still else value for still, value in zip(fixed, values, strict=True)]
    else:
        values = [float(geom.friction[0]) if geom.condim > 1 else 0.0 for geom in model.geoms]
    _tell(model, fixed, bits, values, notes)
    return [float(value) for value in values]


def _together(geom: Geom, friction: float, condim: int) -> float:
    """Return MuJoCo's coefficient of a contact of a geom with one of given friction and condim."""
    return max(float(geom.friction[0]), friction) if max(geom.condim, condim) > 1 else 0.0


def _tell(
    model: MjcfModel, fixed: Sequence[bool], bits: Sequence[tuple[int, int]], values: Sequence[float], notes: Notes
) -> None:
    """Note where a contact has another coefficient than in MuJoCo, once for each material."""
    materials: dict[tuple[float, int, float, bool, tuple[int, int]], Geom] = {}
    for k, geom in enumerate(model.geoms):
        materials.setdefault((float(geom.friction[0]), geom.condim, values[k], fixed[k], bits[k]), geom)
    keys = list(materials)
    for one in keys:
        for other in keys:
            apart = not (one[4][0] & other[4][1] and other[4][0] & one[4][1]) or (one[3] and other[3])
            wanted = _together(materials[one], other[0], other[1])
            if not apart and abs((one[2] * other[2]) ** 0.5 - wanted) > 1e-9 * (1.0 + wanted):
                geom = materials[one]
                notes.add(TOPIC, f"{geom.place}: geom" + (f" {geom.name!r}" if geom.name else ""))
                break
