"""Reading of XML: elements with their file and line, and the files that they include.

A document type declaration is refused, so there are no entities that expand without bound.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from .errors import MjcfError, Place


@dataclass
class Element:
    """An XML element.

    Attributes:
        text: what stands between its tags, without that of its children.
    """

    tag: str
    attributes: dict[str, str]
    place: Place
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def find_all(self, tag: str) -> Iterator[Element]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def title(self) -> str:
        """Return place, tag and name for a message."""
        name = self.attributes.get("name")
        return f"{self.place}: {self.tag}" + (f" {name!r}" if name else "")


@dataclass(frozen=True)
class Document:
    """The root element of a model, includes resolved, and the folder that its paths are relative to."""

    root: Element
    folder: Path


def read_document(source: str | os.PathLike[str], outermost: str = "mujoco") -> Document:
    """Return the document of a path, or of a string that starts with ``<``.

    Raises:
        MjcfError: no such file, no well-formed XML, a document type declaration, another root than
            ``outermost``, or a file that is included twice or includes itself.
    """
    if not isinstance(source, (str, os.PathLike)) or (isinstance(source, str) and not source.strip()):
        raise MjcfError(f"a path or the text of a file is needed, got {source!r}.")
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        document = Document(_parse(source.lstrip("\ufeff \t\r\n").encode(), "string"), Path())
        seen: set[Path] = set()
    elif isinstance(source, str) and ("<" in source or "\n" in source):
        raise MjcfError("string, line 1: not well-formed XML: it must start with '<'.")
    else:
        path = Path(source)
        document = Document(_parse(_file_bytes(path, f"{path}"), path.name), path.parent)
        seen = {path.resolve()}
    if document.root.tag != outermost:
        place, kind = document.root.place, "an MJCF" if outermost == "mujoco" else "a URDF"
        raise MjcfError(f"{place}: the outermost element of {kind} file is {outermost}, not {document.root.tag}.")
    _include(document, seen)
    return document


def _file_bytes(path: Path, what: str) -> bytes:
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise MjcfError(f"{what}: the file {str(path)!r} cannot be read: {reason}.") from None


def _parse(data: bytes, name: str) -> Element:
    """Return the root element of XML text; ``name`` is that of the file in messages."""
    parser = expat.ParserCreate()
    open_elements: list[Element] = []
    roots: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, Place(name, parser.CurrentLineNumber))
        (open_elements[-1].children if open_elements else roots).append(element)
        open_elements.append(element)

    def end(_: str) -> None:
        open_elements.pop()

    def characters(text: str) -> None:
        if open_elements:
            open_elements[-1].text += text

    def doctype(*_: object) -> None:
        raise MjcfError(f"{name}, line {parser.CurrentLineNumber}: a document type declaration is not allowed.")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = characters
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise MjcfError(f"{name}, line {error.lineno}: not well-formed XML: {reason}.") from None
    return roots[0]


def _include(document: Document, seen: set[Path]) -> None:
    """Replace each ``include`` by the children of its file's root."""
    waiting: list[tuple[Element, tuple[Path, ...]]] = [(document.root, tuple(seen))]
    while waiting:
        parent, chain = waiting.pop()
        chains = [chain] * len(parent.children)  # of each child, the files that it stands in
        index = 0
        while index < len(parent.children):
            child, chain = parent.children[index], chains[index]
            if child.tag != "include":
                waiting.append((child, chain))
                index += 1
                continue
            path = _included_path(child, document.folder, chain)
            real = path.resolve()
            if real in chain:
                raise MjcfError(f"{child.place}: the file {str(path)!r} includes itself.")
            if real in seen:
                raise MjcfError(f"{child.place}: the file {str(path)!r} is included twice.")
            seen.add(real)
            root = _parse(_file_bytes(path, str(child.place)), path.name)
            parent.children[index : index + 1] = root.children
            chains[index : index + 1] = [(*chain, real)] * len(root.children)


def _included_path(element: Element, folder: Path, chain: tuple[Path, ...]) -> Path:
    """Return the path of an include, relative to the model's folder or else to that of the including file."""
    name = element.attributes.get("file")
    if not name:
        raise MjcfError(f"{element.place}: include needs a file.")
    path = folder / name
    if not path.exists() and chain and (chain[-1].parent / name).exists():
        path = chain[-1].parent / name
    return path
