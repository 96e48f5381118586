"""The elements ``compiler`` and ``option``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .attributes import Attributes
from .errors import MjcfError, Notes
from .frames import Angles
from .model import Simulation
from .reader import Document, Element

# Options of MuJoCo's solvers, viewers and files, which have no counterpart.
UNUSED_COMPILER = (
    "alignfree", "conflict", "discardvisual", "fusestatic", "usethread", "passthrough", "savecanonical", "savecompiled",
    "saveinertial", "texturedir", "strippath", "fitaabb", "convexhull", "exactmeshinertia",
)  # fmt: skip
UNUSED_OPTION = (
    "apirate", "actuatorgroupdisable", "ccd_iterations", "ccd_tolerance", "cone", "impratio", "iterations", "jacobian",
    "ls_iterations", "ls_tolerance", "noslip_iterations", "noslip_tolerance", "sdf_initpoints", "sdf_iterations",
    "sleep_tolerance", "solver", "tolerance", "mpr_iterations", "mpr_tolerance", "collision",
)  # fmt: skip


@dataclass(frozen=True)
class Compiler:
    """The element ``compiler``, with MuJoCo's defaults.

    Attributes:
        angles: how angles are written.
        autolimits: whether a range alone sets a limit.
        from_geoms: whether inertias come from geoms: "auto" (where a body has none of its own), "true" or "false".
        groups: range of the geoms' groups that count for inertias.
        total_mass: kg, to which all masses are scaled; None: they are not.
        least_mass, least_inertia: kg and kg m^2, lower bounds.
        balance: whether impossible moments of inertia are replaced by their mean.
        mesh_folder: folder of meshes and heightfields.
    """

    angles: Angles
    autolimits: bool
    from_geoms: str
    groups: tuple[int, int]
    total_mass: float | None
    least_mass: float
    least_inertia: float
    balance: bool
    mesh_folder: str


def _joined(document: Document, tag: str) -> Element:
    """Return one element with the attributes of all sections of a tag; later ones win."""
    sections = list(document.root.find_all(tag))
    place = sections[-1].place if sections else document.root.place
    joined = Element(tag, {}, place)
    for section in sections:
        joined.attributes |= section.attributes
        joined.children += section.children
    return joined


def read_compiler(document: Document, notes: Notes) -> Compiler:
    """Return the compiler options.

    Raises:
        MjcfError: an attribute out of its range, or global coordinates, which MuJoCo dropped as well.
    """
    element = _joined(document, "compiler")
    attributes = Attributes(element, element.attributes, notes)
    if attributes.choice("coordinate", ("local", "global"), "local") == "global":
        raise attributes.error("coordinate is global, of which MuJoCo 2.3.3 was the last to read it")
    order = attributes.text("eulerseq", "xyz")
    if len(order) != 3 or not set(order.lower()) <= set("xyz"):
        raise attributes.error(f"eulerseq must be three letters of x, y, z, X, Y, Z, got {order!r}")
    unit = math.radians(1.0) if attributes.choice("angle", ("degree", "radian"), "degree") == "degree" else 1.0
    first, last = attributes.vector("inertiagrouprange", (0.0, 5.0))
    total = attributes.number("settotalmass", -1.0)
    asset_folder = attributes.text("assetdir")
    compiler = Compiler(
        angles=Angles(unit, order),
        autolimits=attributes.flag("autolimits", True),
        from_geoms=attributes.choice("inertiafromgeom", ("auto", "true", "false"), "auto"),
        groups=(int(first), int(last)),
        total_mass=total if total > 0.0 else None,
        least_mass=attributes.number("boundmass", 0.0),
        least_inertia=attributes.number("boundinertia", 0.0),
        balance=attributes.flag("balanceinertia", False),
        mesh_folder=attributes.text("meshdir", asset_folder),
    )
    attributes.read.update(UNUSED_COMPILER)
    attributes.finish()
    return compiler


def read_simulation(document: Document, notes: Notes) -> Simulation:
    """Return the element ``option``.

    Raises:
        MjcfError: an attribute out of its range.
    """
    element = _joined(document, "option")
    attributes = Attributes(element, element.attributes, notes)
    usual = Simulation()
    flags = _flags(element)
    gravity = attributes.array("gravity", usual.gravity.tolist())
    simulation = Simulation(
        timestep=attributes.number("timestep", usual.timestep),
        gravity=gravity if flags.get("gravity", True) else np.zeros(3),
        density=attributes.number("density", 0.0),
        viscosity=attributes.number("viscosity", 0.0),
        wind=attributes.array("wind", (0.0, 0.0, 0.0)),
        integrator=attributes.text("integrator", usual.integrator),
        contacts=flags.get("contact", True) and flags.get("constraint", True),
        parent_filter=flags.get("filterparent", True),
        limits=flags.get("limit", True) and flags.get("constraint", True),
    )
    if not simulation.timestep > 0.0:
        raise attributes.error(f"timestep must be positive, got {simulation.timestep:g}")
    if min(simulation.density, simulation.viscosity) < 0.0:
        raise attributes.error("density and viscosity must not be negative")
    if simulation.density or simulation.viscosity:
        notes.add("fluid forces are not simulated", attributes.title)
    attributes.text("magnetic")
    attributes.read.update(UNUSED_OPTION)
    for name in attributes.values:
        if name.startswith("o_"):  # an override of the contacts' soft parameters
            attributes.read.add(name)
            notes.add("soft-contact parameters are ignored, contacts and limits are rigid", attributes.title)
    attributes.finish()
    return simulation


def _flags(option: Element) -> dict[str, bool]:
    """Return the switches of the element ``flag``.

    Raises:
        MjcfError: one that is neither enable nor disable.
    """
    flags = {}
    for element in option.find_all("flag"):
        for name, text in element.attributes.items():
            if text not in ("enable", "disable"):
                raise MjcfError(f"{element.place}: flag {name} must be enable or disable, got {text!r}.")
            flags[name] = text == "enable"
    return flags
