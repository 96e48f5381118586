"""The best settings among measured points."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from .points import Point

OURS = "gsenv"
ENGINES = (OURS, "Box2D", "Box2D v3", "pymunk", "MuJoCo", "PyBullet", "Rapier", "Box3D")  # in the order of columns
Judge = Callable[[Point], float | None]


def strict(point: Point) -> float | None:
    return point.error


def lenient(point: Point) -> float | None:
    return point.lenient


@dataclass(frozen=True)
class Points:
    """All points of a report."""

    all: list[Point]

    @property
    def engines(self) -> list[str]:
        """gsenv, and the peers that were measured."""
        present = {point.engine for point in self.all}
        return [name for name in ENGINES if name in present or name == OURS]

    def of(self, case: str, engine: str | None = None) -> list[Point]:
        """Return the points of a case, and of one engine if it is given."""
        return [point for point in self.all if point.case == case and engine in (point.engine, None)]


def front(points: Iterable[Point], judge: Judge = strict) -> list[Point]:
    """Return the points that no other beats in both time and error, cheapest first."""
    out: list[Point] = []
    best = float("inf")
    for point in sorted(points, key=lambda p: (p.us, judge(p) or 0.0)):
        error = judge(point)
        if error is not None and error < best:
            out.append(point)
            best = error
    return out


def cheapest(points: Iterable[Point], limit: float, judge: Judge = strict) -> Point | None:
    """Return the first of the front whose error is at most ``limit``."""
    return next((point for point in front(points, judge) if (judge(point) or 0.0) <= limit), None)


def best_peer(points: Points, case: str, limit: float, judge: Judge = strict) -> Point | None:
    """Return the cheapest point of all other engines whose error is at most ``limit``."""

    def found() -> Iterator[Point]:
        for peer in points.engines[1:]:
            point = cheapest(points.of(case, peer), limit, judge)
            if point is not None:
                yield point

    return min(found(), key=lambda point: point.us, default=None)


def ratio_to_best_peer(points: Points, case: str, limit: float, judge: Judge = strict) -> str:
    """Return gsenv's time divided by that of the best other engine, where gsenv was measured."""
    mine = points.of(case, OURS)
    return time_ratio(cheapest(mine, limit, judge), best_peer(points, case, limit, judge)) if mine else "-"


def time_ratio(mine: Point | None, peer: Point | None) -> str:
    """Return gsenv's time divided by the other engine's."""
    if mine is None:
        return "-" if peer is None else "not reached"
    return "alone" if peer is None else f"{mine.us / peer.us:.2f}"
