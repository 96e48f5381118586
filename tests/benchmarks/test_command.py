"""``python -m benchmarks``: the list, the command line of each benchmark, and where files go."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from benchmarks import command, registry
from benchmarks.common.files import read_json, write_json
from benchmarks.common.plots import Figure, plt
from benchmarks.common.report import Outputs, Picture, Report, page_text
from benchmarks.common.run import Run, UsageError
from benchmarks.common.stamp import ROOT
from benchmarks.common.tables import Table
from benchmarks.registry import BENCHMARKS, Benchmark

RESULTS = sorted(path.stem for path in (ROOT / "benchmarks" / "results").glob("*.json"))


class Small:
    """A benchmark that costs nothing."""

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--fail", choices=("usage", "interrupt", "partly"))

    def measure(self, run: Run) -> dict[str, Any]:
        if run.options.fail == "usage":
            raise UsageError("--fail usage: as asked.")
        if run.options.fail == "interrupt":
            raise KeyboardInterrupt
        run.interrupted = run.options.fail == "partly"
        return {"quick": run.quick, "values": [["a", 1.5]], "third": 1.0 / 3.0}

    def report(self, results: Mapping[str, Any]) -> Report:
        def draw() -> Figure:
            figure, axes = plt.subplots()
            axes.plot([0, 1])
            return figure

        return Report(
            "Small",
            [f"A third is {results['third']}.", Table(["name", "value"], [["a", "1.5"]]), Picture("a line", draw)],
        )


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The benchmark "small", whose files go to a temporary folder unless --out is given; that folder."""
    monkeypatch.setitem(registry.BENCHMARKS, "small", Benchmark("small", "costs nothing", page=True))
    monkeypatch.setattr(Benchmark, "load", lambda self: Small())
    monkeypatch.setattr(command, "DOCS", tmp_path / "docs")
    monkeypatch.setattr(command, "RESULTS", tmp_path / "results")
    return tmp_path


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


# ---------------------------------------------------------------- the list


def test_list_shows_all_names_and_summaries() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks"], cwd=ROOT, capture_output=True, text=True, timeout=60, check=True
    )
    for name, benchmark in BENCHMARKS.items():
        assert benchmark.name == name
        assert benchmark.summary
        assert f"  {name} " in done.stdout
        assert benchmark.summary in done.stdout


def test_every_module_in_the_folder_is_listed() -> None:
    shared = {"__init__", "__main__", "__pycache__", "command", "common", "registry", "results"}
    assert {path.stem for path in (ROOT / "benchmarks").iterdir()} - shared == set(BENCHMARKS)


def test_unknown_name_gets_a_sentence_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["acuracy"]) == 2
    assert capsys.readouterr().err == "benchmarks: there is no benchmark 'acuracy'; the nearest name is 'accuracy'.\n"


# ---------------------------------------------------------------- each benchmark


@pytest.mark.parametrize("name", BENCHMARKS)
def test_command_line_of_each(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main([name, "--quick", "--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    for option in ("--quick", "--out", "--from-results"):
        assert option in text
    assert ("--dim" in text) == (len(BENCHMARKS[name].dims) > 1)
    assert ("--core" in text) == BENCHMARKS[name].single_core


def test_pages_do_not_tell_where_things_lay(small: Path) -> None:
    out = small / "out"
    assert command.main(["small", "--out", str(out)]) == command.OK
    assert read_json(out / "small.json")["stamp"]["command"] == "python -m benchmarks small --out FOLDER"


@pytest.mark.parametrize("stem", RESULTS)
def test_page_and_stored_results_agree(stem: str) -> None:
    """docs/ has what the report makes of benchmarks/results/: `--from-results` writes the pages anew."""
    name = stem.removesuffix("3d")
    page = ROOT / "docs" / f"{stem}.md"
    results = read_json(ROOT / "benchmarks" / "results" / f"{stem}.json")
    outputs = Outputs(ROOT / "benchmarks" / "results" / f"{stem}.json", page, page.with_suffix(".png"))
    assert page_text(BENCHMARKS[name].load().report(results), results, outputs) == page.read_text()


# ---------------------------------------------------------------- files


def test_full_run_writes_results_page_and_picture(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["small"]) == 0
    assert files(small) == {"docs/small.md", "docs/small.png", "results/small.json"}
    page = (small / "docs" / "small.md").read_text()
    assert page.startswith("# Small\n\n`python -m benchmarks small` writes this page. Measured on ")
    assert "[small.json](../results/small.json)" in page
    assert page.endswith(
        "A third is 0.3333333.\n\n| name | value |\n| --- | ---: |\n| a | 1.5 |\n\n![a line](small.png)\n"
    )
    results = read_json(small / "results" / "small.json")
    assert results["stamp"]["command"] == "python -m benchmarks small"
    assert len(results["stamp"]["load"]) == 2
    assert results["values"] == [["a", 1.5]]
    assert results["third"] == 0.3333333
    assert "A third is 0.3333333." in capsys.readouterr().out


def test_quick_run_writes_nothing_unless_asked(small: Path) -> None:
    assert command.main(["small", "--quick"]) == 0
    assert files(small) == set()
    assert command.main(["small", "--quick", "--out", str(small / "here")]) == 0
    assert files(small) == {"here/small.md", "here/small.png", "here/small.json"}
    assert read_json(small / "here" / "small.json")["quick"] is True


def test_page_from_stored_results_keeps_their_stamp_and_notes(small: Path) -> None:
    assert command.main(["small", "--quick", "--out", str(small / "a")]) == 0
    stored = small / "a" / "small.json"
    write_json(stored, read_json(stored) | {"notes": ["The window was open."]})
    assert command.main(["small", "--from-results", str(stored), "--out", str(small / "b")]) == 0
    assert read_json(small / "b" / "small.json") == read_json(stored)
    page = (small / "b" / "small.md").read_text()
    assert "`python -m benchmarks small --quick --out FOLDER` writes this page." in page
    assert "\n\nThe window was open.\n\nA third is 0.3333333." in page


def test_page_from_results_that_are_not_there(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["small", "--from-results"]) == 2
    assert "there is no file" in capsys.readouterr().err
    (small / "broken.json").write_text("{")
    assert command.main(["small", "--from-results", str(small / "broken.json")]) == 2
    assert "broken.json cannot be read as results" in capsys.readouterr().err


def test_what_cannot_be_written_is_known_before_the_work(
    small: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Small, "measure", lambda *_: pytest.fail("it has begun"))
    (small / "file").write_text("old")
    (small / "out" / "small.png").mkdir(parents=True)
    for name, sentence in (("file", "file is no folder."), ("out", "small.png is a folder.")):
        assert command.main(["small", "--out", str(small / name)]) == 1
        error = capsys.readouterr().err
        assert error.startswith("benchmarks: cannot write: ")
        assert error.endswith(f"{sentence}\n")
        assert error.count("\n") == 1
    assert (small / "file").read_text() == "old"


def test_a_full_disk_is_one_sentence(
    small: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "small.json")

    monkeypatch.setattr(command, "write", full)
    assert command.main(["small"]) == 1
    assert capsys.readouterr().err == "benchmarks: cannot write small.json: No space left on device\n"


NUMBERS = {
    "stress": ("--scenes", "--first", "--processes"),
    "stability": ("--random", "--processes"),
    "heaps": ("--runs",),
    "baselines": ("--seeds",),
}


@pytest.mark.parametrize(
    ("name", "option"), [(name, option) for name, options in NUMBERS.items() for option in options]
)
def test_numbers_are_checked(name: str, option: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main([name, option, "-1"])
    assert "'-1' is not a" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["tiers", "baselines", "throughput", "devices"])
def test_unknown_environments_are_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main([name, "--env", "GStack-v9"])
    assert "invalid choice: 'GStack-v9'" in capsys.readouterr().err


def test_wrong_option_and_interrupt(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["small", "--fail", "usage"]) == 2
    assert capsys.readouterr().err == "benchmarks: --fail usage: as asked.\n"
    assert command.main(["small", "--fail", "interrupt"]) == 130
    assert files(small) == set()
    assert command.main(["small", "--fail", "partly"]) == 130
    assert "results/small.json" in files(small)
