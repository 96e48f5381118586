"""From a file to an MjcfModel."""

from __future__ import annotations

import os

from .actuators import read_actuators
from .bodies import BodyTree
from .compiler import read_compiler, read_simulation
from .defaults import Defaults
from .errors import MjcfError, Notes
from .model import MjcfModel
from .reader import read_document
from .relations import read_contacts, read_equalities, read_keyframes, read_sensors

READ = (
    "compiler", "option", "default", "asset", "worldbody", "contact", "equality", "actuator", "sensor", "keyframe",
)  # fmt: skip
SILENT = ("size", "visual", "statistic", "custom", "extension")
LEFT_OUT = {"tendon": "tendons are not supported", "deformable": "deformable bodies are not supported"}


def parse_mjcf(source: str | os.PathLike[str]) -> MjcfModel:
    """Return what an MJCF file says, with MuJoCo's rules for defaults, frames, inertias and ranges.

    Args:
        source: a path, or XML text that starts with ``<``.

    Raises:
        MjcfError: a file that MuJoCo would not read either, or one with global coordinates or a hinge beside a ball
            on one body; the message names file, line and element.
    """
    notes = Notes()
    document = read_document(source)
    for section in document.root.children:
        if section.tag in LEFT_OUT:
            notes.add(LEFT_OUT[section.tag], section.title())
        elif section.tag not in READ + SILENT:
            raise MjcfError(f"{section.place}: {section.tag} is no section of an MJCF file.")
    compiler = read_compiler(document, notes)
    simulation = read_simulation(document, notes)
    defaults = Defaults(document.root, notes)
    try:
        model = BodyTree(document, compiler, defaults, simulation).read(document)
    except RecursionError:  # frames within frames
        raise MjcfError(f"{document.root.place}: its frames are nested too deeply.") from None
    model.actuators = read_actuators(document, compiler, defaults, model)
    model.equalities = read_equalities(document, defaults, model)
    read_contacts(document, defaults, model)
    model.sensors = read_sensors(document, defaults, model)
    model.keyframes = read_keyframes(document, defaults, model)
    model.warnings = notes.sentences()
    return model
