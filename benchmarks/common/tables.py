"""Tables of text, written once for the terminal and for markdown pages."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from rich.markup import escape
from rich.table import Table as RichTable

BOLD = re.compile(r"\*\*(.+?)\*\*")


@dataclass(frozen=True)
class Table:
    """A header and rows of cells.

    Attributes:
        header: a name for each column.
        rows: cells, as many in each row as there are columns; **bold** as in markdown.
        words: how many leading columns are words, aligned left; the others are numbers, aligned right.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1

    def markdown(self) -> str:
        rule = ["---" if k < self.words else "---:" for k in range(len(self.header))]
        return "\n".join("| " + " | ".join(line) + " |" for line in (self.header, rule, *self.rows))

    def rich(self) -> RichTable:
        """Return the table for the terminal; if it is narrow, headers and words are wrapped, numbers are not."""
        table = RichTable()
        for k, name in enumerate(self.header):
            if k < self.words:
                table.add_column(escape(name))
            else:
                width = max((len(row[k].replace("**", "")) for row in self.rows), default=0)
                table.add_column(escape(name), justify="right", min_width=width)
        for row in self.rows:
            table.add_row(*(BOLD.sub(r"[bold]\1[/]", escape(cell)) for cell in row))
        return table
