"""What refers to bodies and geoms by name: equality constraints, contact pairs and excludes, sensors, keyframes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .attributes import Attributes
from .defaults import Defaults
from .errors import MjcfError, check_names
from .frames import Pose
from .model import ContactPair, Equality, Keyframe, MjcfModel, Sensor
from .reader import Document, Element

# Attributes that say what a sensor reads, in order of preference, and the kind of that.
SENSOR_OBJECTS = {
    "site": "site", "joint": "joint", "tendon": "tendon", "actuator": "actuator", "body": "body", "geom1": "geom",
    "body1": "body", "geom": "geom",
}  # fmt: skip
SENSOR_UNUSED = (
    "noise", "delay", "interval", "interp", "nsample", "data", "reduce", "num", "dim", "datatype", "needstage", "mesh",
    "subtree1", "subtree2", "geom2", "body2", "enclosed",
)  # fmt: skip


def _index(names: Iterable[str], name: str, kind: str, attributes: Attributes) -> int:
    """Return the index of a name.

    Raises:
        MjcfError: there is none.
    """
    for k, other in enumerate(names):
        if other == name and name:
            return k
    raise attributes.error(f"there is no {kind} {name!r}")


def _names(model: MjcfModel, kind: str) -> list[str]:
    lists = {
        "body": model.bodies,
        "xbody": model.bodies,
        "geom": model.geoms,
        "site": model.sites,
        "joint": model.joints,
        "actuator": model.actuators,
        "camera": model.cameras,
    }
    return [thing.name for thing in lists.get(kind, [])]  # type: ignore[attr-defined]


def read_contacts(document: Document, defaults: Defaults, model: MjcfModel) -> None:
    """Add the pairs and excludes of ``contact`` to the model; raises MjcfError for one that names nothing."""
    for section in document.root.find_all("contact"):
        for element in section.children:
            if element.tag == "exclude":
                attributes = Attributes(element, element.attributes, defaults.notes)
                first, second = (attributes.needed(name) for name in ("body1", "body2"))
                names = _names(model, "body")
                pair = tuple(_index(names, name, "body", attributes) for name in (first, second))
                model.excludes.append((min(pair), max(pair)))
                attributes.finish()
            elif element.tag == "pair":
                model.pairs.append(_pair(defaults.attributes(element), model))
            else:
                raise MjcfError(f"{element.place}: {element.tag} is no element of contact.")


def _pair(attributes: Attributes, model: MjcfModel) -> ContactPair:
    first, second = (attributes.needed(name) for name in ("geom1", "geom2"))
    for name in (first, second):
        _index(_names(model, "geom"), name, "geom", attributes)
    friction = None
    if "friction" in attributes:
        usual = (1.0, 1.0, 0.005, 0.0001, 0.0001)
        friction = attributes.array("friction", usual)
    condim = attributes.whole("condim", 3) if "condim" in attributes else None
    attributes.finish()
    return ContactPair(first, second, condim, friction, attributes.element.place)


def read_equalities(document: Document, defaults: Defaults, model: MjcfModel) -> list[Equality]:
    """Return the equality constraints; those of tendons and flexes are warned of and left out.

    Raises:
        MjcfError: one that names no body, site or joint.
    """
    found = []
    for section in document.root.find_all("equality"):
        for element in section.children:
            if element.tag not in ("connect", "weld", "joint"):
                defaults.notes.add(f"the equality {element.tag} is not supported", element.title())
                continue
            attributes = defaults.attributes(element, tag="equality")
            found.append(_equality(element, attributes, model))
    check_names(found)
    return found


def _equality(element: Element, attributes: Attributes, model: MjcfModel) -> Equality:
    kind = element.tag
    of_sites = "site1" in attributes or "site2" in attributes
    noun = "site" if of_sites else "joint" if kind == "joint" else "body"
    first, second = attributes.needed(f"{noun}1"), attributes.text(f"{noun}2")
    names = _names(model, noun)
    _index(names, first, noun, attributes)
    if second or of_sites:
        _index(names, second, noun, attributes)
    if kind == "connect" and not of_sites and "anchor" not in attributes:
        raise attributes.error("anchor is missing")
    relative = attributes.array("relpose", (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    length = float(np.linalg.norm(relative[3:]))
    equality = Equality(
        name=attributes.text("name"),
        kind=kind,
        first=first,
        second=second,
        of_sites=of_sites,
        anchor=attributes.array("anchor", (0.0, 0.0, 0.0)),
        relative_pose=Pose(relative[:3], relative[3:] / length) if length > 0.0 else None,
        coefficients=attributes.array("polycoef", (0.0, 1.0, 0.0, 0.0, 0.0)),
        active=attributes.flag("active", True),
        place=element.place,
    )
    attributes.text("torquescale")
    attributes.finish()
    return equality


def read_sensors(document: Document, defaults: Defaults, model: MjcfModel) -> list[Sensor]:
    """Return the sensors; raises MjcfError for one that names nothing."""
    found = []
    for section in document.root.find_all("sensor"):
        for element in section.children:
            attributes = Attributes(element, element.attributes, defaults.notes)
            if "objtype" in attributes:
                kind, name = attributes.text("objtype"), attributes.needed("objname")
            else:
                given = [key for key in SENSOR_OBJECTS if key in attributes]
                kind = SENSOR_OBJECTS[given[0]] if given else ""
                name = attributes.text(given[0]) if given else ""
            if kind in ("body", "xbody", "geom", "site", "joint", "actuator", "camera"):
                _index(_names(model, kind), name, kind, attributes)
            reference_kind, reference = attributes.text("reftype"), attributes.text("refname")
            if reference_kind:
                _index(_names(model, reference_kind), reference, reference_kind, attributes)
            cutoff = attributes.number("cutoff", 0.0)
            own = attributes.text("name")
            found.append(Sensor(own, element.tag, kind, name, reference_kind, reference, cutoff, element.place))
            attributes.read.update((*SENSOR_UNUSED, *SENSOR_OBJECTS))
            attributes.finish()
    check_names(found)
    return found


def read_keyframes(document: Document, defaults: Defaults, model: MjcfModel) -> list[Keyframe]:
    """Return the keyframes; raises MjcfError for one with a wrong count of numbers."""
    found = []
    rest = initial_coordinates(model)
    for section in document.root.find_all("keyframe"):
        for element in section.find_all("key"):
            attributes = Attributes(element, element.attributes, defaults.notes)
            lists = {}
            for name, usual in (
                ("qpos", rest),
                ("qvel", [0.0] * model.rate_count),
                ("ctrl", [0.0] * len(model.actuators)),
            ):
                numbers = attributes.numbers(name) if name in attributes else usual
                if len(numbers) != len(usual):
                    raise attributes.error(f"{name} must be {len(usual)} numbers, got {len(numbers)}")
                lists[name] = np.array(numbers, float)
            time = attributes.number("time", 0.0)
            name = attributes.text("name")
            found.append(Keyframe(name, time, lists["qpos"], lists["qvel"], lists["ctrl"], element.place))
            attributes.finish()
    check_names(found)
    return found


def initial_coordinates(model: MjcfModel) -> list[float]:
    """Return qpos of the poses that the file gives."""
    coordinates: list[float] = []
    for joint in model.joints:
        if joint.kind == "free":
            pose = model.bodies[joint.body].world_pose
            coordinates += [*pose.position.tolist(), *pose.orientation.tolist()]
        elif joint.kind == "ball":
            coordinates += [1.0, 0.0, 0.0, 0.0]
        else:
            coordinates.append(joint.reference)
    return coordinates
