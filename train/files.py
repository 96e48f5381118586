"""JSON files and CSV tables of training, written whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gsenv.files import write_text


def write_json(path: Path, content: Any) -> None:
    write_text(path, json.dumps(content, indent=2) + "\n")


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a CSV table; its columns are those of the first row."""
    text = io.StringIO()
    table = csv.DictWriter(text, list(rows[0]) if rows else [], lineterminator="\n")
    table.writeheader()
    table.writerows({name: _cell(value) for name, value in row.items()} for row in rows)
    write_text(path, text.getvalue())


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
