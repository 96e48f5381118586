"""The files that a kernel's machine code can come from: its own file and what this file imports, transitively.

The cache of compiled kernels (jit.py) is keyed by a digest of these files. With a file missing here the
cache would run old code after an edit; a needless file costs a needless compilation. So where a text is
ambiguous, the file is included:

- Imports are read from the text, at module level and inside functions, those under `if TYPE_CHECKING:`
  excepted. A line of a docstring that reads like an import counts, too.
- The `__init__.py` of a package counts where a name that it binds is imported: `from .joints import
  JointKind`, but not `from .joints.build import has_limit`, nor `from . import joints`.
- `by_dimension("package.module", "function")` counts as an import of that module in planar/ and in spatial/.
- Files of the solver that extend numba's types count for every kernel, because their code is compiled
  into kernels that never import them.
"""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

_SOLVER = Path(__file__).resolve().parent
_PACKAGE = _SOLVER.parent

# Parsing all files in full would take 0.3 s at every start; this and a parse of each match take 0.02 s.
_REST = r"(?:[^\n()\\#;]|\\\r?\n)+"  # the rest of a statement that is continued by backslashes only
_IMPORT = re.compile(
    rf"(?:^|[;:])[ \t]*(import\b{_REST}|from(?:[.\w \t]|\\\r?\n)+?\bimport\b[ \t]*(?:\((?:[^()#]|#[^\n]*)*\)|{_REST}))",
    re.MULTILINE,
)
_TYPE_CHECKING = re.compile(
    r"^([ \t]*)if (?:typing\.)?TYPE_CHECKING:[ \t]*(?:#[^\n]*)?\r?\n(?:\1[ \t]+[^\n]*(?:\n|\Z)|[ \t]*\r?\n)+",
    re.MULTILINE,
)
_BY_DIMENSION = re.compile(r"""by_dimension\(\s*["']([\w.]+)["']""")
_TYPE_EXTENSION = re.compile(
    r"^@[\w.]*\b(?:register_model|infer_getattr|lower_[gs]etattr\w*|lower_cast|overload_attribute|overload_method)\b",
    re.MULTILINE,
)
_OVERLOADED = re.compile(r"^@overload\(\s*(\w+)", re.MULTILINE)


class _Place(NamedTuple):
    """The position of a module in the import system."""

    package: tuple[str, ...]  # ("gsenv", "solver") for gsenv/solver/jit.py; empty for a script
    home: Path  # folder that contains the package or the script


def kernel_sources(file: Path) -> tuple[Path, ...]:
    """Return the files whose code a kernel in `file` can run, `file` included; sorted, links resolved.

    Imports of gsenv, of the file's own package and of modules beside a script are followed.
    """
    found: set[Path] = set()
    waiting = [file.resolve(), *_type_extensions()]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting.extend(_imported_files(path))
    return tuple(sorted(found))


@cache
def _type_extensions() -> tuple[Path, ...]:
    return tuple(path for path in sorted(_SOLVER.rglob("*.py")) if _reaches_without_import(_read(path)))


def _reaches_without_import(text: str) -> bool:
    """Whether a file's code is compiled into kernels that do not import it.

    This is so where the file defines attributes of a type, or overloads a function of another file.
    """
    if _TYPE_EXTENSION.search(text):
        return True
    overloaded = set(_OVERLOADED.findall(text))
    return bool(overloaded) and any(
        overloaded & {alias.asname or alias.name.partition(".")[0] for alias in statement.names}
        for statement in _import_statements(text)
    )


@cache
def _imported_files(file: Path) -> frozenset[Path]:
    """Return the files that `file` imports directly."""
    place = _place(file)
    text = _TYPE_CHECKING.sub("", _read(file))
    found: set[Path] = set()
    for statement in _import_statements(text):
        if isinstance(statement, ast.Import):
            for alias in statement.names:
                found |= _of_import(alias, place)
        else:
            found |= _of_import_from(statement, place)
    for name in _BY_DIMENSION.findall(text):
        for dimension in ("planar", "spatial"):
            module = _module_file((_PACKAGE.name, _SOLVER.name, dimension, *name.split(".")), place)
            if module is not None:
                found.add(module)
    return frozenset(found)


def _import_statements(text: str) -> Iterator[ast.Import | ast.ImportFrom]:
    for match in _IMPORT.finditer(text):
        try:
            statement = ast.parse(match[1].strip()).body[0]
        except SyntaxError:  # prose that begins with "from" or "import"
            continue
        assert isinstance(statement, ast.Import | ast.ImportFrom)
        yield statement


def _of_import(alias: ast.alias, place: _Place) -> set[Path]:
    parts = tuple(alias.name.split("."))
    # `import a.b` binds a, so the names of a/__init__.py can be used; `import a.b as c` binds the module alone.
    names = [parts] if alias.asname else [parts[: i + 1] for i in range(len(parts))]
    files = (_module_file(name, place) for name in names)
    return {file for file in files if file is not None}


def _of_import_from(statement: ast.ImportFrom, place: _Place) -> set[Path]:
    package = place.package[: len(place.package) - statement.level + 1] if statement.level else ()
    base = (*package, *(statement.module.split(".") if statement.module else ()))
    module = _module_file(base, place)
    found: set[Path] = set()
    for alias in statement.names:
        submodule = _module_file((*base, alias.name), place)
        if submodule is not None:
            found.add(submodule)
        if module is not None and (submodule is None or alias.name in _bound_names(module)):
            found.add(module)
    return found


def _module_file(name: tuple[str, ...], place: _Place) -> Path | None:
    """Return the file of a module; None for modules that are not followed or do not exist."""
    if not name:  # `from . import x` in a script's folder
        return None
    if name[0] == _PACKAGE.name:
        top = _linked_packages().get(name[1]) if len(name) > 1 else None
        path = top.joinpath(*name[2:]) if top else _PACKAGE.joinpath(*name[1:])
    elif name[0] in place.package[:1] or not place.package:
        path = place.home.joinpath(*name)
    else:
        return None
    candidates = (path / "__init__.py", path.with_name(f"{path.name}.py"))
    return next((file for file in candidates if file.is_file()), None)


@cache
def _linked_packages() -> dict[str, Path]:
    """Return the folders of packages such as gsenv.envs that a checkout has beside gsenv/, by their last names."""
    found = {}
    for child in _PACKAGE.iterdir():
        # where the system has no links, git writes a text file in place of one
        folder = child.resolve() if child.is_dir() else _PACKAGE.parent / child.name
        if folder.parent != _PACKAGE and (folder / "__init__.py").is_file():
            found[child.name] = folder
    return found


@cache
def _place(file: Path) -> _Place:
    for name, folder in _linked_packages().items():
        if file.is_relative_to(folder):
            return _Place((_PACKAGE.name, name, *file.parent.relative_to(folder).parts), _PACKAGE.parent)
    home = file.parent
    while (home / "__init__.py").is_file():
        home = home.parent
    return _Place(file.parent.relative_to(home).parts, home)


@cache
def _bound_names(package_file: Path) -> frozenset[str]:
    """Return the names that an `__init__.py` may bind; an import of such a name may also mean a module."""
    names = set()
    for node in ast.walk(ast.parse(_read(package_file))):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.alias):
            names.add(node.asname or node.name)
    return frozenset(names)


@cache
def _read(file: Path) -> str:
    return file.read_text(encoding="utf-8", errors="replace")
