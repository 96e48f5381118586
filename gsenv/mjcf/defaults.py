"""Default classes: the attributes that elements have unless they give their own."""

from __future__ import annotations

from collections.abc import Mapping

from .actuator_forms import ACTUATOR_TAGS, general_form
from .attributes import PARTIAL, Attributes
from .errors import MjcfError, Notes
from .reader import Element

MAIN = "main"
ROTATIONS = frozenset(("quat", "axisangle", "euler", "xyaxes", "zaxis"))
EQUALITY_TAGS = frozenset(("connect", "weld", "joint", "tendon", "flex", "flexstrain"))

Values = dict[str, str]


def merged(base: Mapping[str, str], own: Mapping[str, str]) -> Values:
    """Return the attributes of an element or class over those of its class.

    The own rotation replaces that of the class, in whichever notation; of a partial list the class gives the rest.
    """
    values = dict(base)
    if not ROTATIONS.isdisjoint(own):
        values = {name: text for name, text in values.items() if name not in ROTATIONS}
    for name, text in own.items():
        if name in PARTIAL and name in values:
            text = " ".join(text.split() + values[name].split()[len(text.split()) :])
        values[name] = text
    return values


class Defaults:
    """The tree of default classes of a model.

    Raises:
        MjcfError: a class without a name, or two of one name.
    """

    def __init__(self, root: Element, notes: Notes) -> None:
        self.notes = notes
        self.classes: dict[str, dict[str, Values]] = {MAIN: {}}
        for top in root.find_all("default"):
            self._read(top)

    def _read(self, top: Element) -> None:
        waiting: list[tuple[Element, str | None]] = [(top, None)]
        while waiting:
            element, parent = waiting.pop()
            name = element.attributes.get("class", MAIN if parent is None else "")
            if not name:
                raise MjcfError(f"{element.place}: a default inside another needs a class.")
            if name in self.classes and not (parent is None and name == MAIN):
                raise MjcfError(f"{element.place}: the default class {name!r} is defined twice.")
            base = self.classes[parent] if parent is not None else self.classes[MAIN]
            values = {tag: dict(attributes) for tag, attributes in base.items()}
            for child in element.children:
                if child.tag != "default":
                    _add(values, child)
            self.classes[name] = values
            waiting.extend((child, name) for child in reversed(list(element.find_all("default"))))

    def attributes(self, element: Element, class_name: str | None = None, tag: str | None = None) -> Attributes:
        """Return an element's attributes over those of its class, of ``class_name`` or of the main class.

        Args:
            class_name: of the enclosing body, where the element names none.
            tag: under which the defaults are; that of the element itself if None.

        Raises:
            MjcfError: a class that does not exist.
        """
        name = element.attributes.get("class") or class_name or MAIN
        if name not in self.classes:
            raise MjcfError(f"{element.title()}: there is no default class {name!r}.")
        base = self.classes[name].get(tag or element.tag, {})
        return Attributes(element, merged(base, element.attributes), self.notes)

    def actuator(self, element: Element) -> Attributes:
        """Return an actuator's attributes as those of the element ``general``."""
        found = self.attributes(element, tag="actuator")
        base = self.classes[element.attributes.get("class") or MAIN].get("actuator", {})
        return Attributes(element, general_form(element, base), found.notes)


def _add(values: dict[str, Values], child: Element) -> None:
    """Add one element of a default class to its values."""
    tag = child.tag
    if tag in ACTUATOR_TAGS:
        values["actuator"] = general_form(child, values.get("actuator", {}))
        return
    values[tag] = merged(values.get(tag, {}), child.attributes)
