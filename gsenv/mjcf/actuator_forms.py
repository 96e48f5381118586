"""The shortcuts for actuators, written as the element ``general``.

An actuator's force is gain * control + bias; gain is ``gainprm[0]``, bias is ``biasprm[0] + biasprm[1] * length +
biasprm[2] * speed``, where length and speed are those of its joint times the gear.
"""

from __future__ import annotations

from collections.abc import Mapping

from .attributes import PARTIAL, number_list
from .errors import MjcfError
from .reader import Element

ACTUATOR_TAGS = (
    "general", "motor", "position", "velocity", "intvelocity", "orientation", "pid", "damper", "cylinder", "muscle",
    "adhesion", "dcmotor", "plugin",
)  # fmt: skip
AFFINE_TAGS = ("general", "motor", "position", "velocity")


def general_form(element: Element, base: Mapping[str, str]) -> dict[str, str]:
    """Return an actuator's attributes over those of its class, with gainprm and biasprm for kp and kv.

    Raises:
        MjcfError: kp or kv that are no numbers, or negative.
    """
    values = dict(base)
    own = dict(element.attributes)
    gain = number_list(values.get("gainprm", "1"), f"{element.title()}: gainprm")
    bias = (number_list(values.get("biasprm", ""), f"{element.title()}: biasprm") + [0.0] * 3)[:3]
    if element.tag == "motor":
        values |= {"gaintype": "fixed", "gainprm": "1", "biastype": "none", "biasprm": "0"}
    elif element.tag == "position":
        stiffness = _coefficient(element, own, "kp", gain[0])
        rate = _coefficient(element, own, "kv", -bias[2])
        values |= _affine(stiffness, -stiffness, -rate)
    elif element.tag == "velocity":
        rate = _coefficient(element, own, "kv", gain[0])
        values |= _affine(rate, 0.0, -rate)
    for name in ("kp", "kv") if element.tag in AFFINE_TAGS else ():
        own.pop(name, None)
    for name, text in own.items():
        if name in PARTIAL and name in values:
            text = " ".join(text.split() + values[name].split()[len(text.split()) :])
        values[name] = text
    return values


def _affine(gain: float, of_length: float, of_speed: float) -> dict[str, str]:
    return {
        "gaintype": "fixed",
        "gainprm": repr(gain),
        "biastype": "affine",
        "biasprm": f"0 {of_length!r} {of_speed!r}",
    }


def _coefficient(element: Element, own: Mapping[str, str], name: str, default: float) -> float:
    """Return kp or kv."""
    if name not in own:
        return default
    numbers = number_list(own[name], f"{element.title()}: {name}")
    if len(numbers) != 1 or numbers[0] < 0.0:
        raise MjcfError(f"{element.title()}: {name} must be one number that is not negative, got {own[name]!r}.")
    return numbers[0]
