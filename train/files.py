"""Files that are written whole or not at all."""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Let `write` make a file beside `path`, of the same suffix, then put it in its place."""
    partial = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        write(partial)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def write_json(path: Path, content: Any) -> None:
    write_whole(path, lambda partial: partial.write_text(json.dumps(content, indent=2) + "\n"))


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """A CSV table; its columns are the first row's."""

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
    """A CSV table of numbers; nan where a cell is empty."""
    with path.open(newline="") as file:
        return [
            {name: float(cell) if cell else float("nan") for name, cell in row.items()} for row in csv.DictReader(file)
        ]
