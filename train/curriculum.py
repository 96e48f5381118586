"""A curriculum: easier arguments of an environment first, harder ones once the policy has learned them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass
class Curriculum:
    """The lessons of a training run, and where it is.

    Args:
        lessons: arguments that differ from `arguments`, easiest first; with none of them left, training is on
            `arguments` themselves.
        arguments: of the environment.
        pass_mark: share of the latest episodes that must succeed before the next lesson begins.
        lesson: number of lessons that are done.
    """

    lessons: Sequence[Mapping[str, Any]]
    arguments: Mapping[str, Any]
    pass_mark: float
    lesson: int = 0
    ended: int = 0  # episodes since the lesson began

    def current(self) -> dict[str, Any]:
        """Return the arguments that any lesson sets, as they are in this one."""
        named = {name for lesson in self.lessons for name in lesson}
        changed = self.lessons[self.lesson] if self.lesson < len(self.lessons) else {}
        return {name: self.arguments[name] for name in named} | dict(changed)

    def advance(self, success: float, environments: int) -> bool:
        """Begin the next lesson if this one is passed.

        Args:
            success: share of the latest episodes, as many as there are environments.
            environments: twice as many episodes must have ended since the lesson began, because the first of each
                began in the lesson before.
        """
        enough = self.ended >= 2 * environments
        passed = self.lesson < len(self.lessons) and enough and success >= self.pass_mark
        if passed:
            self.lesson += 1
            self.ended = 0
        return passed
