"""What the benchmarks share: files, tables, stamps, timing, processes."""

from __future__ import annotations

import gc
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from rich.console import Console

from benchmarks.common.files import packed, read_json, unpacked, write_figure, write_json
from benchmarks.common.plots import plt
from benchmarks.common.processes import run_python
from benchmarks.common.stamp import describe, make_stamp
from benchmarks.common.tables import Table
from benchmarks.common.timing import call_time, cpu_time, median_ratio
from gsenv.files import replacing, write_text


def write_a_figure(path: Path) -> None:
    figure, axes = plt.subplots(figsize=(1.0, 1.0))
    axes.plot([0, 1])
    write_figure(path, figure)


WRITERS: list[Callable[[Path], None]] = [
    lambda path: write_text(path, "new"),
    lambda path: write_json(path, {"key": "new"}),
    write_a_figure,
]


@pytest.mark.parametrize("write", WRITERS, ids=["text", "json", "figure"])
def test_writers_replace_the_file_at_once(
    write: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "folder" / "file"
    write(path)
    first = path.read_bytes()
    path.write_text("old")
    seen: list[tuple[str, bytes]] = []

    def broken(source: Path, target: Path) -> None:
        seen.append((target.read_text(), source.read_bytes()))
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", broken)
    with pytest.raises(KeyboardInterrupt):
        write(path)
    assert seen == [("old", first)]  # the new file was complete before the old one was touched
    assert path.read_text() == "old"
    assert [item.name for item in path.parent.iterdir()] == ["file"]


def test_error_while_writing_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("old")

    def write_half() -> None:
        with replacing(path) as draft:
            draft.write_text("half")
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        write_half()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@dataclass(frozen=True)
class Sample:
    name: str
    value: float | None


def test_json_is_compact_and_read_back(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    samples = [Sample("a", 1.0 / 3.0), Sample("b", None)]
    write_json(path, {"rounds": 3, "samples": packed(samples)})
    assert path.read_text() == '{\n"rounds":3,\n"samples":[\n["name","value"],\n["a",0.3333333],\n["b",null]\n]\n}\n'
    assert unpacked(Sample, read_json(path)["samples"]) == [Sample("a", 0.3333333), Sample("b", None)]


def test_json_refuses_infinity(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="range"):
        write_json(tmp_path / "results.json", {"error": float("inf")})
    assert list(tmp_path.iterdir()) == []


def test_table_in_markdown_and_on_the_terminal() -> None:
    table = Table(["scene", "kind", "us"], [["stack", "2D", "12"], ["car", "2D", "7"]], words=2)
    assert table.markdown().splitlines() == [
        "| scene | kind | us |", "| --- | --- | ---: |", "| stack | 2D | 12 |", "| car | 2D | 7 |",
    ]  # fmt: skip
    assert [column.justify for column in table.rich().columns] == ["left", "left", "right"]
    assert table.rich().row_count == 2


def test_narrow_terminal_wraps_words_and_no_numbers() -> None:
    table = Table(["scene", "us per simulated second"], [["**a long chain** [of 20]", "1.25e-03"]])
    console = Console(width=24, record=True, file=io.StringIO())
    console.print(table.rich())
    text = console.export_text()
    assert "1.25e-03" in text
    assert "[of" in text
    assert "*" not in text


def test_stamp_says_what_was_run_where_and_when() -> None:
    stamp = make_stamp("python -m benchmarks small")
    assert stamp["cpu"]
    assert stamp["versions"]["NumPy"]
    text = describe(stamp | {"load": [0.1, 0.2]})
    assert text.startswith(f"Measured on {stamp['date']} on {stamp['cpu']}")
    assert "Load average 0.1 and 0.2" in text
    assert "Other processes" not in text
    assert "Other processes were running" in describe(stamp | {"load": [2.0, 2.0]})
    assert "Other processes" not in describe(stamp | {"load": [0.1, 16.0]})  # these are the benchmark's own threads
    assert describe({"date": "2026-01-02"}) == "Measured on 2026-01-02."


def test_times_are_those_of_the_calls_without_the_collector() -> None:
    enabled: list[bool] = []

    def work() -> None:
        enabled.append(gc.isenabled())
        sum(range(200_000))

    once = cpu_time(work)
    assert once > 0.0
    assert enabled == [False]
    assert gc.isenabled()
    mean = call_time(work, 0.01, rounds=3)
    assert len(enabled) >= 1 + 1 + 3  # the first call of call_time is not counted
    assert 0.1 * once < mean < 10.0 * once


def test_paired_ratio_ignores_a_slow_minute() -> None:
    assert median_ratio([1.0, 10.0, 1.0], [2.0, 20.0, 2.0]) == 0.5
    assert median_ratio([1.0, 9.0, 1.0], [2.0, 2.0, 2.0]) == 0.5
    with pytest.raises(ValueError, match="longer"):
        median_ratio([1.0], [1.0, 2.0])


def test_process_is_measured_as_a_whole(tmp_path: Path) -> None:
    done = run_python("import os; print(os.environ['NUMBA_CACHE_DIR']); sum(range(3_000_000))", tmp_path)
    assert done.output.strip() == str(tmp_path)
    assert done.wall_seconds > 0.0
    assert done.cpu_seconds > 0.0
