"""The wheel holds what the repository tracks, and the maps in pyproject.toml and ARCHITECTURE.md are true."""

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest

import gsenv

ROOT = Path(__file__).parent.parent
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
MAPPED = SETUPTOOLS["package-dir"]
"""Package name to its folder, for the folders at the top level."""


def tracked_files() -> list[str]:
    """Files that git tracks, and new ones that it does not ignore: those are about to be."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return [name for name in listed if (ROOT / name).is_symlink() or (ROOT / name).is_file()]


def folder_of(package: str) -> Path:
    """The real folder of a package: mapped itself, or within one that is."""
    for mapped, folder in MAPPED.items():
        if package == mapped or package.startswith(f"{mapped}."):
            return ROOT / folder / package.removeprefix(mapped).lstrip(".").replace(".", "/")
    return ROOT / package.replace(".", "/")


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tracked files, and a data file in a folder of assets, with caches lying about."""
    source = tmp_path_factory.mktemp("source")
    for name in tracked_files():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, source / name, follow_symlinks=False)
    for name in ("assets/policies/probe.npz", "assets/__pycache__/probe.pyc", "gsenv/solver/__pycache__/probe.nbc"):
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).touch()
    return source


@pytest.fixture(scope="module")
def wheel(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*command, "--wheel-dir", out, source], check=True, timeout=300)
    (built,) = out.iterdir()
    return built


def test_wheel_holds_the_tracked_files_of_the_packages_and_nothing_else(wheel: Path) -> None:
    expected = {"gsenv/assets/policies/probe.npz"}
    for name in tracked_files():
        top, _, rest = name.partition("/")
        if top in MAPPED.values():
            expected.add(f"gsenv/{top}/{rest}")
        elif top == "gsenv" and not (ROOT / name).is_symlink():
            expected.add(name)
    found = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert found == expected


def test_source_distribution_holds_docs_tests_and_what_they_need(source: Path, tmp_path: Path) -> None:
    build = "import sys; from setuptools import build_meta; build_meta.build_sdist(sys.argv[1])"
    command = [sys.executable, "-c", build, str(tmp_path)]
    subprocess.run(command, cwd=source, check=True, capture_output=True, timeout=300)
    (built,) = tmp_path.iterdir()
    with tarfile.open(built) as archive:
        found = {name.partition("/")[2] for name in archive.getnames()}
    wanted = {
        name
        for name in tracked_files()
        if name.startswith(("docs/", "tests/", "benchmarks/"))
        or name in ("CHANGELOG.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "constraints.txt", "LICENSE", ".ci/run")
        or folder_is_packaged(name)
    }
    assert not wanted - found
    assert not {name for name in found if name.endswith((".pyc", ".nbc", ".nbi"))}


def folder_is_packaged(name: str) -> bool:
    return name.startswith(("gsenv/", *(f"{folder}/" for folder in MAPPED.values()))) and not (ROOT / name).is_symlink()


def test_installed_wheel_runs_from_anywhere(wheel: Path, tmp_path: Path) -> None:
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    code = (
        f"import sys; sys.path.insert(0, {str(site)!r})\n"
        "import gsenv.envs, gsenv.train, gsenv.assets, gsenv.cli\n"
        "print(gsenv.envs.__file__)\n"
        "sys.exit(gsenv.cli.main(['--version']))"
    )
    result = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    where, version = result.stdout.splitlines()
    assert Path(where).is_relative_to(site)
    assert version == f"gsenv {wheel.name.split('-')[1]}"
    assert sorted(path.name for path in site.iterdir() if not path.name.endswith(".dist-info")) == ["gsenv"]


def test_every_package_is_listed_and_every_listed_one_exists() -> None:
    existing = {"gsenv"}
    for name in tracked_files():
        path = Path(name)
        if path.name == "__init__.py" and path.parts[0] in {"gsenv", *MAPPED.values()}:
            parts = path.parent.parts if path.parts[0] == "gsenv" else ("gsenv", *path.parent.parts)
            existing.add(".".join(parts))
    assert set(SETUPTOOLS["packages"]) == existing
    assert len(SETUPTOOLS["packages"]) == len(existing)


def test_every_python_file_lies_in_a_package() -> None:
    folders = {folder_of(package) for package in SETUPTOOLS["packages"]}
    stray = [
        name
        for name in tracked_files()
        if name.endswith(".py")
        and name.split("/")[0] in {"gsenv", *MAPPED.values()}
        and (ROOT / name).parent not in folders
    ]
    assert stray == []


@pytest.mark.parametrize("package", sorted(MAPPED))
def test_link_and_map_agree(package: str) -> None:
    link = ROOT / package.replace(".", "/")
    assert link.is_symlink()
    assert link.resolve() == folder_of(package).resolve()
    assert find_spec(package) is not None


def test_constraints_pin_every_direct_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    wanted = project["dependencies"] + extras["train"] + extras["pettingzoo"] + extras["test"]
    names = {normalised(re.split(r"[\[<>=!~;, ]", requirement)[0]) for requirement in wanted} - {"gsenv"}
    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    pinned = {normalised(line.split("==")[0]) for line in lines}
    assert names <= pinned
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)


def test_citation_has_the_version_of_the_package() -> None:
    lines = (ROOT / "CITATION.cff").read_text().splitlines()
    assert f"version: {gsenv.__version__}" in lines


def normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


PATH = re.compile(r"(?:[\w.-]+/)*[\w-][\w.-]*(?:\.(?:md|py|toml|txt)|/)")
BASES = ("", "gsenv", "gsenv/solver", "gsenv/solver/planar")
"""Where the text's paths may start."""


def paths_in_trees(text: str) -> set[str]:
    """Full paths of the files and folders in the fenced trees of `text`.

    Indenting nests. A line is names, two or more blanks, a remark; names in a folder's remark lie in it.
    """
    found = set()
    for tree in re.findall(r"^```\w*\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        parents: list[tuple[int, str]] = []
        for line in tree.splitlines():
            names, _, remark = re.sub(r"[,;:]", "", line).strip().partition("  ")
            paths = [word for word in names.split() if PATH.fullmatch(word)]
            if not paths:
                continue
            indent = len(line) - len(line.lstrip())
            while parents and parents[-1][0] >= indent:
                parents.pop()
            parent = parents[-1][1] if parents else ""
            folder = parent + paths[0] if paths[0].endswith("/") else parent
            if folder != parent:
                parents.append((indent, folder))
            found |= {parent + path for path in paths}
            found |= {folder + word for word in remark.split() if PATH.fullmatch(word)}
    return found


def test_trees_are_read_with_their_nesting() -> None:
    tree = "x\n```\na/\n  b/   rules in c.py, and more\n    d.py e.py  made by g.py\n  f.py\nh.toml\n```\n`z.py`\n"
    expected = {"a/", "a/b/", "a/b/c.py", "a/b/d.py", "a/b/e.py", "a/b/g.py", "a/f.py", "h.toml"}
    assert paths_in_trees(tree) == expected


def test_architecture_names_only_paths_that_exist() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text()
    prose = {quoted for quoted in re.findall(r"`([^`\n]+)`", text) if PATH.fullmatch(quoted)}
    missing = [path for path in paths_in_trees(text) if not (ROOT / path).exists()]
    missing += [path for path in prose if not any((ROOT / base / path).exists() for base in BASES)]
    assert missing == []
    assert len(prose | paths_in_trees(text)) > 10
