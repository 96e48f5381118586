"""Atomic writing of files, and CSV tables."""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Replace `path` atomically: `write` makes a temporary file with the same suffix, which is then renamed."""
    partial = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        write(partial)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def write_json(path: Path, content: Any) -> None:
    write_whole(path, lambda partial: partial.write_text(json.dumps(content, indent=2) + "\n"))


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a CSV table atomically; its columns are those of the first row."""

    def write(partial: Path) -> None:
        with partial.open("w", newline="") as file:
            table = csv.DictWriter(file, list(rows[0]) if rows else [], lineterminator="\n")
            table.writeheader()
            table.writerows({name: _cell(value) for name, value in row.items()} for row in rows)

    write_whole(path, write)


def _cell(value: float | str) -> str:
    if isinstance(value, str) or math.isnan(value):
        return value if isinstance(value, str) else ""
    return f"{value:.10g}"


def read_rows(path: Path) -> list[dict[str, float]]:
    """Read a CSV table of numbers; an empty cell is NaN."""
    with path.open(newline="") as file:
        return [
            {name: float(cell) if cell else float("nan") for name, cell in row.items()} for row in csv.DictReader(file)
        ]
