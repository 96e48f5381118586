"""The documentation is true: its code runs, its links lead somewhere, and the glossary's names are in the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILE_PATH = re.compile(r"`(?:python )?((?:[\w.-]+/)+[\w.-]+\.(?:py|md|yml|toml|json))`")
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
LINK = re.compile(r"\]\(([^)\s#]+)[^)]*\)")
GLOSSARY_ENTRY = re.compile(r"- \*\*(.+?)\*\*(.*)")
CODE_NAME = re.compile(r"`([A-Za-z_][\w.]*)`")
PAGES = (
    "docs/constraints.md",
    "docs/joints.md",
    "docs/mjcf.md",
    "docs/sensors.md",
    "docs/your_own_env.md",
    "README.md",
)
DOCS = sorted((ROOT / "docs").glob("*.md"))


@pytest.mark.parametrize("page", PAGES)
def test_code_of_a_page_runs(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    blocks = BLOCK.findall((ROOT / page).read_text())
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    assert "world" in names


CLIENTS = BLOCK.findall((ROOT / "docs/clients.md").read_text())
LIBRARIES = ("stable_baselines3", "torchrl", "skrl", "supersuit")


@pytest.mark.parametrize("block", CLIENTS, ids=lambda block: next((n for n in LIBRARIES if n in block), "gymnasium"))
@pytest.mark.filterwarnings("ignore")  # the libraries' own, of deprecations
def test_code_for_another_library_runs(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where it writes files
    for name in LIBRARIES:
        if name in block:
            pytest.importorskip(name)
    names: dict[str, object] = {}
    exec(compile(block, "docs/clients.md", "exec"), names)
    assert {"env", "envs"} & set(names)


@pytest.mark.parametrize("page", [*sorted(ROOT.glob("*.md")), *DOCS], ids=lambda page: str(page.relative_to(ROOT)))
def test_links_of_a_page_lead_to_files(page: Path) -> None:
    links = [link for link in LINK.findall(page.read_text()) if "://" not in link]
    missing = [link for link in links if not (page.parent / link).exists()]
    assert not missing, f"{page.relative_to(ROOT)} links to missing files: {', '.join(missing)}"


@pytest.mark.parametrize("page", [*sorted(ROOT.glob("*.md")), *DOCS], ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_a_page_names_exist(page: Path) -> None:
    """Paths are relative to the repository, or as in ARCHITECTURE.md to gsenv/solver."""
    paths = [path for path in FILE_PATH.findall(page.read_text()) if not path.startswith("runs/")]
    missing = [path for path in paths if not any((folder / path).exists() for folder in (ROOT, ROOT / "gsenv/solver"))]
    assert not missing, f"{page.relative_to(ROOT)} names missing files: {', '.join(missing)}"


def test_the_index_links_to_every_page() -> None:
    linked = set(LINK.findall((ROOT / "docs/README.md").read_text()))
    assert {page.name for page in DOCS} - {"README.md"} <= linked


def test_glossary_is_alphabetical_and_names_what_the_code_has() -> None:
    entries = GLOSSARY_ENTRY.findall((ROOT / "docs/glossary.md").read_text())
    terms = [term for term, _ in entries]
    assert terms
    assert terms == sorted(set(terms), key=str.lower)
    files = [path for folder in ("gsenv/solver", "envs") for path in (ROOT / folder).rglob("*.py")]
    known = {path.name for path in files}.union(*(re.findall(r"\w+", path.read_text()) for path in files))
    for term, text in entries:
        for name in CODE_NAME.findall(text):
            parts = [name] if name.endswith(".py") else name.split(".")
            assert known.issuperset(parts), (
                f"the glossary's entry {term!r} names {name!r}, which the code does not have"
            )
