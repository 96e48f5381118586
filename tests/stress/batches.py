"""Random scenes in batches: some with every run, the others nightly."""

from __future__ import annotations

import pytest


def batches(count: int, size: int, nightly_from: int) -> pytest.MarkDecorator:
    """Parametrises ``seeds``, ranges of ``size`` of the first ``count``; those from ``nightly_from`` on are slow.

    A case's category follows from its seed, so the first few dozen have all categories.
    """
    seeds = [range(first, min(first + size, count)) for first in range(0, count, size)]
    marks = [(pytest.mark.slow,) if each.start >= nightly_from else () for each in seeds]
    cases = [pytest.param(s, marks=m, id=f"{s.start}-{s.stop - 1}") for s, m in zip(seeds, marks, strict=True)]
    return pytest.mark.parametrize("seeds", cases)
