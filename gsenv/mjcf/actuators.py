"""Actuators."""

from __future__ import annotations

from ..solver.records.model import Array
from .actuator_forms import ACTUATOR_TAGS, AFFINE_TAGS
from .attributes import Attributes
from .compiler import Compiler
from .defaults import Defaults
from .errors import MjcfError, check_names
from .model import Actuator, Joint, MjcfModel, Range
from .reader import Document, Element

TARGETS = ("joint", "jointinparent", "tendon", "site", "body", "cranksite")
# Attributes of dynamics, delays and of kinds that have no affine force.
UNUSED = (
    "dynprm", "actdim", "actearly", "actlimited", "actrange", "lengthrange", "cranklength", "slidersite", "refsite",
    "nsample", "interp", "delay", "plugin", "instance",
)  # fmt: skip


def read_actuators(document: Document, compiler: Compiler, defaults: Defaults, model: MjcfModel) -> list[Actuator]:
    """Return the actuators.

    Raises:
        MjcfError: an unknown element, joint or attribute value, or two of one name.
    """
    actuators: list[Actuator] = []
    joints = {joint.name: joint for joint in model.joints if joint.name}
    for section in document.root.find_all("actuator"):
        for element in section.children:
            if element.tag not in ACTUATOR_TAGS:
                raise MjcfError(f"{element.place}: {element.tag} is no actuator.")
            actuators.append(_actuator(element, compiler, defaults, joints))
    check_names(actuators)
    return actuators


def _actuator(element: Element, compiler: Compiler, defaults: Defaults, joints: dict[str, Joint]) -> Actuator:
    attributes = defaults.actuator(element)
    given = [name for name in TARGETS if name in attributes]
    if len(given) != 1:
        raise attributes.error(f"an actuator needs one of {', '.join(TARGETS)}, got {' and '.join(given) or 'none'}")
    target = attributes.needed(given[0])
    if given[0] in ("joint", "jointinparent") and target not in joints:
        raise attributes.error(f"there is no joint {target!r}")
    gain_kind = attributes.text("gaintype", "fixed")
    bias_kind = attributes.text("biastype", "none")
    dynamics = attributes.text("dyntype", "none")
    affine = element.tag in AFFINE_TAGS and gain_kind == "fixed" and bias_kind in ("none", "affine")
    affine = affine and dynamics == "none"
    gain, bias, damping_ratio = 1.0, attributes.array("biasprm", (0.0,) * 10)[:3], 0.0
    if affine:
        gain = attributes.vector("gainprm", (1.0,) + (0.0,) * 9)[0]
        if attributes.number("timeconst", 0.0) > 0.0:
            attributes.notes.add("timeconst of an actuator is ignored", attributes.title)
        for name in ("armature", "damping"):
            if name in attributes and any(attributes.numbers(name)):
                attributes.notes.add(f"{name} of an actuator is ignored; give it to the joint", attributes.title)
        damping_ratio = _damping_ratio(attributes, element, gain, bias)
    else:
        attributes.read.update(attributes.values)
    actuator = Actuator(
        name=attributes.text("name"),
        kind=element.tag,
        target_kind=given[0],
        target=target,
        gear=attributes.array("gear", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
        gain=gain,
        bias=bias if bias_kind == "affine" else 0.0 * bias,
        affine=affine,
        control_range=_control_range(attributes, compiler, joints.get(target), gain, bias),
        force_range=attributes.limits("forcerange", "forcelimited", compiler.autolimits),
        place=element.place,
        damping_ratio=damping_ratio,
    )
    attributes.read.update(UNUSED)
    attributes.finish()
    return actuator


def _damping_ratio(attributes: Attributes, element: Element, gain: float, bias: Array) -> float:
    """Return the damping ratio of a position actuator and take its damping out of ``bias``, where it has one.

    A positive bias[2] of a general actuator with gain = -bias[1] is a damping ratio, too.
    """
    if element.tag == "position":
        ratio = attributes.number("dampratio", 0.0)
        if ratio < 0.0:
            raise attributes.error(f"dampratio must not be negative, got {ratio:g}")
        if "kv" in element.attributes:
            if "dampratio" in element.attributes:
                raise attributes.error("kv and dampratio exclude each other")
            ratio = 0.0  # that of its class
    else:
        ratio = max(float(bias[2]), 0.0) if gain == -bias[1] != 0.0 else 0.0
    if ratio > 0.0:
        bias[2] = 0.0
    return ratio


def _control_range(attributes: Attributes, compiler: Compiler, joint: Joint | None, gain: float, bias: Array) -> Range:
    """Return the bounds of the control, where ``inheritrange`` says so from the joint's own."""
    share = attributes.number("inheritrange", 0.0)
    if share < 0.0:
        raise attributes.error(f"inheritrange must not be negative, got {share:g}")
    if share == 0.0:
        return attributes.limits("ctrlrange", "ctrllimited", compiler.autolimits)
    if "ctrlrange" in attributes:
        raise attributes.error("ctrlrange and inheritrange exclude each other")
    if joint is None or joint.limits is None or gain != -bias[1]:
        raise attributes.error("inheritrange needs a position actuator of a joint with a range")
    middle, half = 0.5 * (joint.limits[0] + joint.limits[1]), 0.5 * (joint.limits[1] - joint.limits[0])
    return middle - share * half, middle + share * half
