"""Tables of the stages of Box2D v3 and Box3D, and of gsenv beside them in common groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.common.report import Part
from benchmarks.common.tables import Table
from benchmarks.stages.peers import NOWHERE, PeerProfile

GROUPS: dict[str, tuple[str, ...]] = {  # of the stages that the engines name
    "pairs": ("pairs", "refit"),
    "collide": ("collide",),
    "solver setup": ("solverSetup",),
    "prepare": ("prepareConstraints",),
    "warm start": ("warmStart",),
    "solve": ("solveImpulses",),
    "relax": ("relaxImpulses",),
    "restitution": ("applyRestitution",),
    "store": ("storeImpulses",),
    "integrate": ("integrateVelocities", "integratePositions"),
    "transforms": ("transforms",),
    "sleep": ("sleepIslands",),
    "events": ("jointEvents", "hitEvents", "bullets", "sensorHits", "sensors"),
    "the rest": (NOWHERE,),
}
SURPLUS = "outside its clock"  # the row of an engine's CPU time that its stages do not have
COMMON: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {  # stages of gsenv; groups of the engines
    "detection": (("collision", "matching with the last step"), ("pairs", "collide")),
    "preparing rows": (("rows of contacts",), ("solver setup", "prepare", "store")),
    "solving": (
        ("warm start", "residual", "sweeps", "subspace steps", "impacts and landings"),
        ("warm start", "solve", "relax", "restitution"),
    ),
    "positions and integration": (("position pass", "integration"), ("integrate", "transforms")),
    "islands and sleep": (("islands and sleep",), ("sleep",)),
    "the rest": (("the rest",), ("events", "the rest")),
}
EXPLAINED = (
    "'Pairs' finds pairs whose bounds overlap and refits the tree of bounds. 'Collide' makes the contacts of all pairs,"
    " or keeps those of pairs that moved little, and joins islands of boxes that begin to touch. 'Solver setup' lays"
    " out the constraints by colours, 'prepare' writes them once in a step, 'store' keeps their impulses for the next."
    " 'Warm start', 'solve' and 'relax' go over all constraints once in each substep, 'restitution' once in a step."
    " 'Integrate' moves velocities and positions on in each substep; 'transforms' writes poses and bounds at the end of"
    " the step. 'Sleep' puts islands to sleep, 'events' are those of joints, hits, bullets and sensors, and 'the rest'"
    " lies between the stages. The sum is a step's time by the same clock; the last row is the CPU time of whole steps,"
    " as a mean, measured from outside in rounds without a profile."
)


def sums(parts: Mapping[str, float], groups: Mapping[str, Sequence[str]]) -> dict[str, float]:
    """Return the sum of the parts of each group."""
    return {group: sum(parts[name] for name in names) for group, names in groups.items()}


def common_of_ours(stages: Mapping[str, float]) -> dict[str, float]:
    """Return the common groups of stages of gsenv."""
    return sums(stages, {group: ours for group, (ours, _) in COMMON.items()})


def common_of_theirs(stages: Mapping[str, float]) -> dict[str, float]:
    """Return the common groups of stages of an engine, as it names them."""
    return sums(sums(stages, GROUPS), {group: theirs for group, (_, theirs) in COMMON.items()})


def parts_of_page(ours: Mapping[tuple[str, str], Mapping[str, float]], theirs: Sequence[PeerProfile]) -> list[Part]:
    """Return what the page says of the engine.

    Args:
        ours: us per box and step of gsenv's stages, by heap and phase.
        theirs: the profiles of all builds of one engine.
    """
    engine = theirs[0].engine
    head = (
        f"## Stages of {engine}\n\nus per box and step by the engine's own clock, which it reads in every step whether"
        f" or not anyone asks. This is the clock of the wall; all rounds take the same steps in new worlds, and each"
        " stage of each of these steps counts with its median over the rounds. Rounds of gsenv and of"
        f" {engine} took turns. It has its usual setting of the page on heaps: 60 steps per second with 4 substeps,"
        f" without sleep, on one thread. {EXPLAINED}"
    )
    between = (
        f"## gsenv beside {engine}\n\nCPU us per box and step in common groups; ratios are those of the sums, gsenv"
        f" over {engine}. Sums are CPU time from outside, of calls of all steps of a phase, while perf samples. gsenv's"
        " groups are its time in proportion to the samples that hit the kernel, so they contain all of it. Those of"
        f" {engine} are the medians above, and '{SURPLUS}' is what its CPU time has beyond them: the cost of the"
        " calls, and what holds up single steps, such as samples and other processes. Groups differ in part: gsenv"
        f" computes bounds of boxes within detection and finds islands anew in each step; {engine} computes bounds"
        " within positions and joins islands within detection."
    )
    names = list(dict.fromkeys(p.name for p in theirs))
    tables = [stage_table([p for p in theirs if p.name == name]) for name in names]
    beside = [
        beside_table(", ".join(place), stages, [p for p in theirs if (p.heap, p.phase) == place])
        for place, stages in ours.items()
    ]
    return [head, *tables, between, *beside]


def stage_table(profiles: Sequence[PeerProfile]) -> Table:
    """Return the groups of one build in all phases."""
    grouped = [sums(p.stages, GROUPS) for p in profiles]
    rows = [[group, *(f"{found[group]:.3f}" for found in grouped)] for group in GROUPS]
    rows.append(["**sum**", *(f"**{sum(found.values()):.3f}**" for found in grouped)])
    rows.append(["from outside", *(f"{p.outside:.3f}" for p in profiles)])
    return Table([profiles[0].name, *(f"{p.heap}, {p.phase}" for p in profiles)], rows)


def beside_table(place: str, stages: Mapping[str, float], theirs: Sequence[PeerProfile]) -> Table:
    """Return gsenv and all builds of an engine in one phase of a heap."""
    ours, others = common_of_ours(stages), [common_of_theirs(p.stages) for p in theirs]
    rows = [[group, *cells(ours[group], [other[group] for other in others], "{:.3f}")] for group in COMMON]
    rows.append([SURPLUS, "", *(f"{us:.3f}" for p in theirs for us in (p.surplus, -p.surplus))])
    total, totals = sum(ours.values()), [p.outside for p in theirs]
    rows.append(["**sum**", *cells(total, totals, "**{:.3f}**")])
    rows.append(["ratio", "", *(cell for other in totals for cell in (f"{total / other:.2f}", ""))])
    return Table([place, "gsenv", *(word for p in theirs for word in (p.name, "difference"))], rows)


def cells(ours: float, theirs: Sequence[float], form: str) -> list[str]:
    """Return the cells of our time, and of each other time with the difference."""
    return [form.format(value) for value in (ours, *(each for other in theirs for each in (other, ours - other)))]
