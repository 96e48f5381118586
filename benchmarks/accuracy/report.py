"""Fronts and tables from measured points."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rich.table import Table

from gsenv.solver.options import FIDELITIES

from .cases import Case
from .measure import Point, Results
from .method3d import METHOD3D
from .suites import Suite

LIMITS = (1e-2, 1e-3, 1e-4)
LOOSE = 3e-2  # m: what row 19 asks for at default settings
OURS = "gsenv"
ENGINES = (OURS, "Box2D", "pymunk", "MuJoCo", "PyBullet")  # in the order of columns
Judge = Callable[[Point], float | None]


def strict(point: Point) -> float | None:
    return point.error


def lenient(point: Point) -> float | None:
    return point.lenient


def engines_of(results: Results) -> list[str]:
    """Ours, and the peers that were measured."""
    present = {point.engine for point in results.points.values()}
    return [name for name in ENGINES if name in present or name == OURS]


def front(points: Iterable[Point], judge: Judge = strict) -> list[Point]:
    """Points that no other beats in both time and error, cheapest first."""
    out: list[Point] = []
    best = float("inf")
    for point in sorted(points, key=lambda p: (p.us, judge(p) or 0.0)):
        error = judge(point)
        if error is not None and error < best:
            out.append(point)
            best = error
    return out


def cheapest(points: Iterable[Point], limit: float, judge: Judge = strict) -> Point | None:
    """The first of the front that is as good as asked."""
    for point in front(points, judge):
        if (judge(point) or 0.0) <= limit:
            return point
    return None


def best_peer(case: Case, results: Results, limit: float, judge: Judge = strict) -> Point | None:
    found = [cheapest(results.of(case.key, peer), limit, judge) for peer in engines_of(results)[1:]]
    return min((point for point in found if point is not None), key=lambda p: p.us, default=None)


def ratio(mine: Point | None, peer: Point | None) -> str:
    """Time of ours over the peer's."""
    if mine is None:
        return "-" if peer is None else "not reached"
    return "alone" if peer is None else f"{mine.us / peer.us:.2f}"


def cell(point: Point | None) -> str:
    return "-" if point is None else f"{point.us:.0f}"


def overview(cases: list[Case], results: Results) -> Table:
    """For the terminal: times and ratios at the first two limits."""
    title = "CPU us per simulated s of the cheapest setting with an error of at most 1e-2 and 1e-3"
    table = Table("case", title=title)
    engines = engines_of(results)
    for head in (*engines, "ratio") * 2:
        table.add_column(head, justify="right")
    for case in cases:
        row = [case.key]
        for limit in LIMITS[:2]:
            points = [cheapest(results.of(case.key, engine), limit) for engine in engines]
            row += [*map(cell, points), ratio(points[0], best_peer(case, results, limit))]
        table.add_row(*row)
    return table


def lines(head: list[str], rows: Iterable[list[str]]) -> str:
    """A markdown table; the first two columns are words."""
    rule = ["---"] * 2 + ["---:"] * (len(head) - 2)
    return "\n".join("| " + " | ".join(row) + " |" for row in (head, rule, *rows))


def limit_table(cases: list[Case], results: Results, limit: float, judge: Judge = strict) -> str:
    rows = []
    engines = engines_of(results)
    for case in cases:
        found = [cheapest(results.of(case.key, engine), limit, judge) for engine in engines]
        peer = best_peer(case, results, limit, judge)
        labels = [point.label if point else "-" for point in (found[0], peer)]
        rows.append([case.key, case.title, *map(cell, found), ratio(found[0], peer), *labels])
    head = ["case", "scene", *engines, "gsenv / best peer", "gsenv's setting", "best peer's setting"]
    return lines(head, rows)


def fidelity_table(cases: list[Case], results: Results) -> str:
    rows = []
    for case in cases:
        row = [case.key, case.title]
        for mark in FIDELITIES:
            point = next((p for p in results.of(case.key, OURS) if p.mark == mark), None)
            error = "-" if point is None else "fails" if point.error is None else f"{point.error:.1e}"
            row += [error, cell(point)]
        rows.append(row)
    return lines(["case", "scene", *(f"{m}: {w}" for m in FIDELITIES for w in ("error", "us"))], rows)


def markdown(made: Suite, cases: list[Case], results: Results, stamp: dict[str, str]) -> str:
    """The whole document."""
    about = results.about
    standing = [case for case in cases if case.kind == "standing"]
    stale = sorted({p.case for p in results.points.values() if p.stamp != stamp.get(p.engine)})
    versions = ", ".join(f"{name} {about[name]}" for name in made.engines)
    planar = made.dim == 2
    parts = [
        "# Run time against error" + ("" if planar else " in space"),
        f"`python -m benchmarks.accuracy{'' if planar else ' --dim 3'}` measured all engines in one run, on one core: "
        f"{versions}; {about['cpu']}, {about['date']}. All points are in [{made.name}.json]({made.name}.json).",
        f"![fronts]({made.name}.png)",
        METHOD if planar else METHOD3D,
    ]
    if stale:
        parts.append(f"Measured before the last change of a source: {', '.join(stale)}.")
    for limit in LIMITS:
        parts += [f"## Cheapest setting with an error of at most {limit:.0e}", limit_table(cases, results, limit)]
    crowds = [case for case in cases if case.kind == "balls"]
    if crowds:
        parts += [f"## Balls that fall apart, at {LOOSE:.0e} m", limit_table(crowds, results, LOOSE)]
    parts += [
        "## gsenv's presets", "Error, and CPU us per simulated second.", fidelity_table(cases, results),
        "## Standing scenes by heights and overlaps alone", LENIENT,
    ]  # fmt: skip
    for limit in LIMITS[:2]:
        parts += [f"Error at most {limit:.0e}:", limit_table(standing, results, limit, lenient)]
    return "\n\n".join(parts) + "\n"


METHOD = """\
Times are CPU us of the step calls per simulated second, median of repeated runs; building, compiling and
reading are kept out, garbage collection is off. A peer's step is one call of its C function from a bare
loop (for an empty world 0.3 us in pymunk, 0.6 us in Box2D); gsenv takes all steps in one call. Each engine
gets the same bodies, masses, friction, restitution and start; shapes that can touch nothing are left out for
the peers. The error is the same function of the trajectory for each (`benchmarks/accuracy/errors.py`): what
an engine says of itself does not enter it. Numbers are relative, or in m where the title says so.

- 2, 3: relative error of the period, over all whole periods of 10 s; of the lowest rod in 3.
- 6, 7, 8: largest deviation from the law of motion at any time, over the final distance; creep in m.
- 10: largest relative error of the first three apexes.
- 11: worst error of the highest angle of the balls that should swing out, or angle of a ball that should
  rest, over the starting angle.
- 14, 15, 16: deepest overlap at any time (exact, from the poses) or mean height error of a layer per
  layer, whichever is larger. A tower that drifts sideways by 1 cm or still moves at 1 cm/s at the end
  has failed. Sleeping is off except where the title says "may sleep".
- 17: worst of hinge gap over link length and energy error; 18: energy error; at any time, over m g L of the
  whole chain.
- 21: largest distance from the damped oscillator's closed form over five periods, over the amplitude.

Settings. gsenv: solver, steps per second x substeps, tolerance; or a preset. Box2D: steps per second,
velocity/position iterations. Its polygons have a skin of 1 cm and overlap by up to 5 mm by design: shapes
are made smaller by the skin, or ("slop taken off") by the skin less half the overlap, so that the true
shapes just touch in the state that Box2D aims at; "lengths x 10" gives it a larger world, which makes its fixed
lengths and speeds smaller. Warm starting is on, continuous physics off. pymunk: steps per second,
iterations, collision_slop in m, and the part of an overlap or joint gap that is left after 1/60 s."""
LENIENT = (
    "The same without the demand on drift and final speed: what counts is the deepest overlap and the mean "
    "heights of the layers."
)
