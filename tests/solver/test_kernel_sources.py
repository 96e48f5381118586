"""Which files a kernel's code can come from, in small packages and in gsenv itself."""

import os
import sys
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import pytest

import gsenv.envs
import gsenv.render
import gsenv.solver
from gsenv.solver import Contacts, Parameters, RayHits, Scene, World, kernel_sources
from tests.solver.kernels import all_kernels

FILES = {
    "__init__.py": "from gsenv.solver import World\n",
    "solver/__init__.py": "from .world import World\n",
    "solver/world.py": "from .scene import Scene\nWorld = 1\n",
    "solver/scene.py": "Scene = 1\n",
    "solver/rows.py": "push = 1\n",
    "solver/joints/__init__.py": "from .kinds import JointKind\nfrom .weld import weld\n",
    "solver/joints/kinds.py": "JointKind = 1\n",
    "solver/joints/build.py": "from ..rows import push\n",
    "solver/joints/weld.py": "weld = 1\n",
    "solver/planar/__init__.py": "",
    "solver/planar/math.py": "",
    "solver/planar/joints/__init__.py": "",
    "solver/planar/joints/build.py": "",
    "solver/spatial/__init__.py": "",
    "solver/spatial/joints/__init__.py": "",
    "solver/spatial/joints/build.py": "",
}
ENVS = {
    "__init__.py": "",
    "rules.py": "from ..solver.rows import push\nfrom .parts import PART\n",
    "parts.py": "PART = 1\n",
}


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Folder gsenv with `FILES` and this kernel_sources.py."""
    package = tmp_path.resolve() / "gsenv"
    write(package, FILES | {"solver/kernel_sources.py": Path(kernel_sources.__file__).read_text()})
    return package


def sources_of(package: Path, file: Path) -> set[str]:
    """Other sources of a kernel in `file`, relative to `package`, by the module as it lies in that package."""
    spec = spec_from_file_location("kernel_sources_of_a_test", package / "solver/kernel_sources.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    sources = module.kernel_sources(file)
    assert file.resolve() in sources
    return {Path(os.path.relpath(source, package)).as_posix() for source in sources if source != file.resolve()}


JOINTS = {"solver/joints/__init__.py", "solver/joints/kinds.py", "solver/joints/weld.py"}
WHOLE = {"solver/__init__.py", "solver/world.py", "solver/scene.py"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from .rows import push", {"solver/rows.py"}),
        ("from . import rows", {"solver/rows.py"}),
        ("from gsenv.solver import rows", {"solver/rows.py"}),
        ("import gsenv.solver.rows as r", {"solver/rows.py"}),
        ("import gsenv.solver.rows", {"solver/rows.py", "__init__.py", *WHOLE}),
        ("from gsenv.solver import World", WHOLE),
        ("from gsenv.solver.world import World", WHOLE - {"solver/__init__.py"}),
        ("from .joints import JointKind", JOINTS),
        ("from .joints import *", JOINTS),
        ("from .joints import build", {"solver/joints/build.py", "solver/rows.py"}),
        ("from .joints.build import has_limit", {"solver/joints/build.py", "solver/rows.py"}),
        ("from .joints import weld", JOINTS),  # the submodule or the function of that name
        ("from .joints import (  # the kinds (all)\n    JointKind as Kind,\n)", JOINTS),
        ("from .joints \\\n    import build", {"solver/joints/build.py", "solver/rows.py"}),
        ("def f():\n    from .rows import push", {"solver/rows.py"}),
        ("try: from .rows import push\nexcept ImportError: pass", {"solver/rows.py"}),
        ("x = 1; from .rows import push  # y", {"solver/rows.py"}),
        ("import numpy, missing\nfrom .missing import x\nfrom numpy import pi", set()),
        ('"""Prose\nfrom (here) on,\nimport duties.\nfrom there (to\n"""\nfrom .rows import push\n"""here)"""',
         {"solver/rows.py"}),
        ('f = by_dimension("joints.build", "has_limit")',
         {"solver/planar/joints/build.py", "solver/spatial/joints/build.py"}),
        ("f = by_dimension(\n    'math', 'cross'\n)", {"solver/planar/math.py"}),
    ],
)  # fmt: skip
def test_imports_are_followed(package: Path, text: str, expected: set[str]) -> None:
    kernels = package / "solver/kernels.py"
    kernels.write_text(text)
    assert sources_of(package, kernels) == expected


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_imports_for_type_checkers_alone_are_left_out(package: Path, end: str) -> None:
    lines = [
        "if TYPE_CHECKING:  # hints",
        "    from .world import World",
        "",
        "    if VERSION:",
        "        from .world import World",
        "else:",
        "    from .joints.kinds import JointKind",
        "from .rows import push",
    ]
    kernels = package / "solver/kernels.py"
    kernels.write_bytes(end.join(lines).encode())
    assert sources_of(package, kernels) == {"solver/joints/kinds.py", "solver/rows.py"}


@pytest.mark.parametrize(
    ("text", "counts"),
    [
        ("@register_model(Bundle)\nclass BundleModel: ...", True),
        ("@extending.overload_attribute(Bundle, 'rows')\ndef get(bundle): ...", True),
        ("from .rows import push\n\n@overload(push)\ndef push_in_space(rows): ...", True),
        ("def at(array): ...\n\n@overload(at)\ndef _at(array): ...", False),  # who calls it imports it
    ],
)
def test_extensions_of_types_count_for_kernels_that_do_not_import_them(package: Path, text: str, counts: bool) -> None:
    (package / "solver/extension.py").write_text(text)
    kernels = package / "solver/kernels.py"
    kernels.write_text("")
    assert ("solver/extension.py" in sources_of(package, kernels)) == counts


def test_envs_are_found_beside_gsenv_through_a_link(package: Path) -> None:
    write(package.parent / "envs", ENVS)
    try:
        (package / "envs").symlink_to("../envs", target_is_directory=True)
    except OSError:
        pytest.skip("this system makes no links")
    expected = {"../envs/parts.py", "solver/rows.py"}
    assert sources_of(package, package.parent / "envs/rules.py") == expected
    assert sources_of(package, package / "envs/rules.py") == expected


def test_envs_are_found_beside_gsenv_where_the_link_is_a_text_file(package: Path) -> None:
    write(package.parent / "envs", ENVS)
    (package / "envs").write_text("../envs")
    assert sources_of(package, package.parent / "envs/rules.py") == {"../envs/parts.py", "solver/rows.py"}


def test_envs_of_a_wheel_are_found_in_gsenv(package: Path) -> None:
    write(package / "envs", ENVS)
    write(package.parent, {"numpy/__init__.py": ""})  # site-packages holds others, too
    (package / "envs/parts.py").write_text("import numpy\nPART = 1\n")
    assert sources_of(package, package / "envs/rules.py") == {"envs/parts.py", "solver/rows.py"}


def test_kernel_of_a_users_package_has_that_package_and_gsenv(package: Path) -> None:
    project = package.parent / "elsewhere/project"
    write(
        project,
        {
            "__init__.py": "",
            "rules/__init__.py": "",
            "rules/magnet.py": "from gsenv.solver.rows import push\nfrom ..field import f\nimport project.units as u\n",
            "field.py": "import other\n",
            "units.py": "",
            "unrelated.py": "",
            "../other.py": "",
        },
    )
    found = sources_of(package, project / "rules/magnet.py")
    assert found == {"solver/rows.py", "../elsewhere/project/field.py", "../elsewhere/project/units.py"}


def test_kernel_of_a_script_has_the_modules_beside_it(package: Path) -> None:
    scripts = package.parent / "scripts"
    write(scripts, {"train.py": "import numpy\nfrom helper import f\n", "helper.py": "", "other.py": ""})
    assert sources_of(package, scripts / "train.py") == {"../scripts/helper.py"}


# ---- gsenv itself: by its modules and kernels, wherever their files lie


@pytest.fixture(scope="module")
def kernels() -> list[Any]:
    """All kernels of the solver, of render and of the environments."""
    return all_kernels(gsenv.solver, gsenv.render, gsenv.envs)


def sources(kernel: Any) -> tuple[Path, ...]:
    return kernel_sources.kernel_sources(file_of(kernel.py_func))


def file_of(function: FunctionType) -> Path:
    return Path(function.__code__.co_filename).resolve()


def home_of(item: type) -> Path:
    """File that defines a class."""
    return Path(str(sys.modules[item.__module__].__file__)).resolve()


def test_step_has_its_stages_but_neither_scene_nor_world_nor_readings(kernels: list[Any]) -> None:
    steps = [kernel for kernel in kernels if kernel.__name__ == "step_world"]
    assert steps
    for step in steps:
        found = sources(step)
        assert {home_of(item) for item in (Scene, World, RayHits, Contacts, Parameters)}.isdisjoint(found)
        assert {"rows", "islands"} <= {path.stem for path in found}
        assert "narrowphase" in {path.parent.name for path in found}


def test_an_edit_of_the_api_recompiles_no_kernel_of_an_environment(kernels: list[Any]) -> None:
    rules = [kernel for kernel in kernels if kernel.__module__.startswith("gsenv.envs.")]
    assert rules
    for rule in rules:
        found = sources(rule)
        assert {home_of(item) for item in (Scene, World, Parameters)}.isdisjoint(found), rule.__module__


def test_sources_hold_every_function_that_a_kernel_can_reach(kernels: list[Any]) -> None:
    for kernel in kernels:
        reached = {file_of(function) for function in reachable(kernel.py_func)}
        assert reached <= set(sources(kernel)), f"{kernel.__module__}.{kernel.__name__}"


def reachable(function: FunctionType) -> set[FunctionType]:
    """`function` and gsenv's functions that it names, or that those name, and so on."""
    found: set[FunctionType] = set()
    waiting = [function]
    while waiting:
        function = waiting.pop()
        if function not in found:
            found.add(function)
            waiting.extend(named_functions(function))
    return found


def named_functions(function: FunctionType) -> Iterator[FunctionType]:
    for code in codes(function.__code__):
        for name in code.co_names:
            value = function.__globals__.get(name)
            # of a module that is named, everything
            values = list(vars(value).values()) if isinstance(value, ModuleType) else [value]
            for item in values:
                item = getattr(item, "py_func", item)
                if isinstance(item, FunctionType) and item.__module__.startswith("gsenv."):
                    yield item


def codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from codes(constant)
