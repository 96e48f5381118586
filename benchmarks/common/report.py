"""A benchmark's report: text, tables and a picture, shown on the terminal and written as a markdown page."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markdown import Markdown

from benchmarks.common.files import write_figure, write_json
from benchmarks.common.stamp import describe
from benchmarks.common.tables import Table
from gsenv.files import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A figure that is drawn only when it is written.

    Attributes:
        text: what it shows, for readers who do not see it.
        draw: makes it.
    """

    text: str
    draw: Callable[[], Figure]


Part = str | Table | Picture


@dataclass(frozen=True)
class Report:
    """The report of a benchmark.

    Attributes:
        title: of the page.
        parts: markdown text, tables, and at most one picture.
        overview: shown on the terminal in place of the parts, where these are too wide or too many.
    """

    title: str
    parts: Sequence[Part]
    overview: Sequence[Part] = ()

    @property
    def picture(self) -> Picture | None:
        return next((part for part in self.parts if isinstance(part, Picture)), None)


@dataclass(frozen=True)
class Outputs:
    """Files of one benchmark; None: not written."""

    results: Path | None = None
    page: Path | None = None
    picture: Path | None = None


def show(report: Report, console: Console) -> None:
    """Print the overview, or everything but the picture."""
    console.print(report.title, style="bold")
    for part in report.overview or report.parts:
        if isinstance(part, Table):
            console.print(part.rich())
        elif isinstance(part, str):
            console.print(Markdown(part))


def page_text(report: Report, results: Mapping[str, Any], outputs: Outputs) -> str:
    """Return the markdown page, whose head names the command that writes it.

    After the head come the ``notes`` of the results, if there are any: paragraphs about this measurement that someone
    added to the file of results by hand. The next measurement drops them.
    """
    assert outputs.page is not None
    stamp = results["stamp"]
    head = f"`{stamp['command']}` writes this page. {describe(stamp)}"
    if outputs.results is not None:
        head += f" All numbers are in [{outputs.results.name}]({link(outputs.page, outputs.results)})."
    parts = [f"# {report.title}", head, *results.get("notes", [])]
    for part in report.parts:
        if isinstance(part, Table):
            parts.append(part.markdown())
        elif isinstance(part, str):
            parts.append(part)
        elif outputs.picture is not None:
            parts.append(f"![{part.text}]({link(outputs.page, outputs.picture)})")
    return "\n\n".join(parts) + "\n"


def link(page: Path, target: Path) -> str:
    """Return the path of ``target`` from the folder of ``page``."""
    return Path(os.path.relpath(target, page.parent)).as_posix()


def write(report: Report, results: Mapping[str, Any], outputs: Outputs) -> list[Path]:
    """Write all files; return their paths."""
    written = []
    if outputs.results is not None:
        write_json(outputs.results, results)
        written.append(outputs.results)
    if outputs.page is not None:
        write_text(outputs.page, page_text(report, results, outputs))
        written.append(outputs.page)
    if outputs.picture is not None and report.picture is not None:
        write_figure(outputs.picture, report.picture.draw())
        written.append(outputs.picture)
    return written
