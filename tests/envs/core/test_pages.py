"""The pages in docs/envs are what the code says."""

from __future__ import annotations

import re
from pathlib import Path

import imageio.v3 as imageio
import pytest

pytest.importorskip("pettingzoo")

from gsenv.envs import ENVS, PARALLEL_ENVS, pages

FOLDER = Path(__file__).parents[3] / "docs" / "envs"
NAMES = [*(entry.id for entry in ENVS), *(entry.name for entry in PARALLEL_ENVS)]


@pytest.mark.parametrize("name", NAMES)
def test_page_is_current(name: str) -> None:
    path = FOLDER / f"{name}.md"
    assert path.is_file(), "run `python -m gsenv.envs.pages`"
    assert path.read_text(encoding="utf-8") == pages.pages()[path.name], "run `python -m gsenv.envs.pages`"


def test_there_are_no_other_pages_and_the_index_has_them() -> None:
    assert sorted(path.name for path in FOLDER.glob("*.md")) == sorted(f"{name}.md" for name in NAMES)
    index = (FOLDER.parent / "README.md").read_text(encoding="utf-8")
    assert all(f"(envs/{name}.md)" in index for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_page_has_the_sections_of_gymnasium_and_says_what_holds(name: str) -> None:
    text = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    headings = [line.removeprefix("## ") for line in text.splitlines() if line.startswith("## ")]
    assert headings == [
        "Description", "Action Space", "Observation Space", "Observation Scaling", "Rewards", "Starting State",
        "Episode End", "Arguments", "Version History",
    ]  # fmt: skip
    assert 'info["reward_terms"]' not in text
    assert "`reward_<term>`" in text
    assert '`split`: "train" (default) or "test"' in text


@pytest.mark.parametrize("name", NAMES)
def test_what_a_page_links_to_is_there(name: str) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", (FOLDER / f"{name}.md").read_text(encoding="utf-8"))
    assert all((FOLDER / link).is_file() for link in links)
    assert (f"../training/{name}.mp4" in links) == (FOLDER.parent / "training" / f"{name}.mp4").is_file()


def test_the_command_writes_frames_of_the_films(tmp_path: Path) -> None:
    pages.write_frames(FOLDER.parent / "training" / "GStack-v0.mp4", tmp_path / "frames.jpg")
    frames = imageio.imread(tmp_path / "frames.jpg")
    assert frames.shape == imageio.imread(FOLDER / "GStack-v0.jpg").shape
    assert frames.std() > 10.0


def test_the_command_writes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert pages.main([str(tmp_path / "new")]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(NAMES)
    for path in FOLDER.glob("*.md"):
        assert (tmp_path / "new" / path.name).read_bytes() == path.read_bytes()
