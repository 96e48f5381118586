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


def read_object(path: Path) -> dict[str, Any]:
    """Read a JSON file that holds an object; raises ValueError where it does not."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is no JSON file: {error}.") from error
    if not isinstance(content, dict):
        raise ValueError(f"{path} must hold a JSON object, got {str(content)[:60]}.")
    return content


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


def read_rows(path: Path, needed: Sequence[str] = ()) -> list[dict[str, float]]:
    """Read a CSV table of numbers; an empty cell is NaN.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no such table, or it lacks one of the columns `needed`.
    """
    with path.open(newline="", encoding="utf-8") as file:
        table = csv.DictReader(file, strict=True)
        try:
            names = table.fieldnames or ()
            rows = list(table)
        except (csv.Error, UnicodeDecodeError) as error:
            raise ValueError(f"{path} is no CSV table: {error}.") from error
    if missing := [name for name in needed if name not in names]:
        raise ValueError(f"{path} lacks the column {missing[0]}.")
    return [{name: _number(path, k, cell) for name, cell in row.items()} for k, row in enumerate(rows, 2)]


def _number(path: Path, line: int, cell: Any) -> float:
    """Return the number of a cell; where a row is too long or too short, DictReader gives a list or None."""
    try:
        return math.nan if cell == "" else float(cell)
    except (TypeError, ValueError):
        what = repr(cell) if isinstance(cell, str) else "not as many cells as there are columns"
        raise ValueError(f"{path}: line {line} must hold numbers, got {what}.") from None


def reason(error: Exception) -> str:
    """Return what went wrong in one sentence: of an OSError, the file and the system's words for it."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)
