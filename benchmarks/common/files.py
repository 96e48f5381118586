"""Files of results, pages and pictures. A reader sees the old file or the new one (gsenv.files)."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gsenv.files import replacing, write_text

if TYPE_CHECKING:
    from _typeshed import DataclassInstance
    from matplotlib.figure import Figure

T = TypeVar("T", bound="DataclassInstance")

DIGITS = 7  # significant digits of a number in a file of results
DPI = 120


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write JSON with one line for each key or item of a list, and numbers with DIGITS significant digits.

    Raises:
        ValueError: a number is infinite or not a number.
    """
    write_text(path, encoded(data))


def as_stored(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return what ``read_json`` returns after ``write_json``: a page made of it agrees with the file."""
    stored: dict[str, Any] = json.loads(encoded(data))
    return stored


def write_figure(path: Path, figure: Figure) -> None:
    """Write the figure as PNG and close it."""
    from benchmarks.common.plots import plt

    with replacing(path) as draft:
        figure.savefig(draft, format="png", dpi=DPI)
    plt.close(figure)


def read_json(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def encoded(data: Mapping[str, Any]) -> str:
    return "{\n" + ",\n".join(f"{json.dumps(key)}:{_lines(_rounded(value))}" for key, value in data.items()) + "\n}\n"


def _lines(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], list | dict):
        return "[\n" + ",\n".join(_dumps(item) for item in value) + "\n]"
    return _dumps(value)


def _dumps(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, Mapping):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return value


def packed(records: Iterable[DataclassInstance]) -> list[list[Any]]:
    """Return dataclass instances of one type as rows of a table; the first row has the names of the fields."""
    rows: list[list[Any]] = []
    for record in records:
        if not rows:
            rows.append([field.name for field in dataclasses.fields(record)])
        rows.append([getattr(record, name) for name in rows[0]])
    return rows


def unpacked(kind: type[T], rows: Sequence[Sequence[Any]]) -> list[T]:
    """Return the instances that ``packed`` turned into rows."""
    return [kind(**dict(zip(rows[0], row, strict=True))) for row in rows[1:]]
