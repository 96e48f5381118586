"""Progress bars on stderr. They are redrawn only when they advance: a thread that draws would disturb what is timed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

T = TypeVar("T")


class Bar:
    """A progress bar that is being shown."""

    def __init__(self, progress: Progress, task: TaskID) -> None:
        self._progress, self._task = progress, task

    def describe(self, text: str) -> None:
        """Show what is being done, as a separate line if stderr is not a terminal."""
        if not self._progress.console.is_terminal and text != self._progress.tasks[self._task].description:
            self._progress.console.print(text, markup=False)
        self._progress.update(self._task, description=text, refresh=True)

    def advance(self, amount: float = 1.0) -> None:
        self._progress.update(self._task, advance=amount, refresh=True)


@contextmanager
def progress_bar(description: str, total: float) -> Iterator[Bar]:
    """Yield a progress bar that is full at ``total``."""
    columns = (
        TextColumn("{task.description:32}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True, emoji=False), auto_refresh=False) as progress:
        yield Bar(progress, progress.add_task(description, total=total))


def track(items: Iterable[T], description: str, total: int) -> Iterator[T]:
    """Yield the items, with a bar that advances by one for each."""
    with progress_bar(description, total) as bar:
        for item in items:
            yield item
            bar.advance()
