"""Runs a method of `solve`, and chooses one for `method="auto"`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from . import kernels
from .cones import convex_starts
from .direct import FIRST_EPSILON, direct_solve
from .kernels import Floats, Rules
from .lemke_problem import MOST_LEMKE_ROWS, lemke_rows, solve_lemke
from .sparse_lu import MOST_BLOCKS, Factor, plan_factor

if TYPE_CHECKING:
    from .problem import Problem

SWEEPS = {"pgs": kernels.PGS, "nncg": kernels.NNCG, "apgd": kernels.APGD}
METHODS = ("auto", *SWEEPS, "direct", "lemke")

TRIAL_SWEEPS = 60  # of auto before it decides
LONGER_TRIAL = 240  # where the trial reduced the error by TRIAL_GAIN
TRIAL_GAIN = 1e-3
# Where the scaled impulses exceed the data by this factor, a small residual says little about the impulses, and auto
# goes on from sweeps that have converged to the direct method.
ILL_CONDITIONED = 100.0
AUTO_LEMKE_ROWS = 600
MOST_OPERATIONS = 1e10  # of one factor, about 10 s: above, auto tries all sweeps first


@dataclass(frozen=True)
class Run:
    """What a method did: the impulses are changed in place."""

    method: str
    sweeps: int
    pivots: int
    residual: float  # by the growth of `Rules`
    reason: str  # why it is not solved


def run_method(problem: Problem, method: str, rules: Rules, impulse: Floats) -> Run:
    """Solve from `impulse`, in place. ValueError where the method can't solve problems of this kind."""
    if method == "auto":
        return choose(problem, rules, impulse)
    if method in SWEEPS:
        if not problem.symmetric:
            raise ValueError(
                f"A is not symmetric and method {method!r} needs symmetry, expected method 'auto', 'direct' or 'lemke'."
            )
        return run_sweeps(problem, method, rules, impulse)
    if method == "lemke":
        rows = lemke_rows(problem)
        if rows > MOST_LEMKE_ROWS:
            raise ValueError(f"The problem has {rows} rows for method 'lemke', expected at most {MOST_LEMKE_ROWS}.")
        return run_lemke(problem, rules, impulse)
    if len(problem._blocks) > MOST_BLOCKS:
        count = len(problem._blocks)
        raise ValueError(f"The problem has {count} blocks for method 'direct', expected at most {MOST_BLOCKS}.")
    return run_direct(problem, rules, impulse)


def run_sweeps(problem: Problem, method: str, rules: Rules, impulse: Floats) -> Run:
    """Sweep from `impulse`."""
    rules = rules._replace(method=SWEEPS[method])
    sweeps, residual = kernels.iterate(problem._kernel_system(), problem._row_scale, rules, impulse)
    reason = "" if residual <= rules.tolerance else f"{sweeps} sweeps have left a residual above the tolerance."
    return Run(method, int(sweeps), 0, float(residual), reason)


def run_direct(problem: Problem, rules: Rules, impulse: Floats, factor: Factor | None = None) -> Run:
    """Solve directly from `impulse`; contacts by Newton steps from it and, where these fail, from convex problems."""
    solver = direct_solve(problem, rules, impulse, factor)
    if solver.has_contacts:
        solver.proximal_steps(FIRST_EPSILON, impulse, rules.max_sweeps)
        left = rules._replace(max_sweeps=rules.max_sweeps - solver.used)
        for start, used in convex_starts(problem, left, solver.impulse) if not solver.solved else ():
            solver.used += used
            solver.proximal_steps(FIRST_EPSILON, start, rules.max_sweeps)
            if solver.solved or solver.used >= rules.max_sweeps:
                break
    if not solver.solved:
        solver.run()
    impulse[:] = solver.impulse
    reason = ""
    if not solver.solved:
        reason = "The direct method has found no states of all rows that agree: rows may contradict each other."
        if solver.used >= rules.max_sweeps:
            reason = f"The direct method has solved max_sweeps = {rules.max_sweeps} systems and not ended."
    return Run("direct", 0, solver.used, solver.residual, reason)


def run_lemke(problem: Problem, rules: Rules, impulse: Floats) -> Run:
    """Solve by Lemke's method; `impulse` is only a fallback."""
    before, _ = measured(problem, rules, impulse)
    candidate, pivots, reason = solve_lemke(problem, rules.max_sweeps)
    error_square, residual = measured(problem, rules, candidate)
    if residual <= rules.tolerance or error_square < before:
        impulse[:] = candidate
    else:
        residual = measured(problem, rules, impulse)[1]
    if residual <= rules.tolerance:
        reason = ""
    elif not reason:
        reason = "Lemke's method has lost its accuracy to rounding."
    return Run("lemke", 0, pivots, residual, reason)


def measured(problem: Problem, rules: Rules, impulse: Floats) -> tuple[float, float]:
    """Project the impulses; return |e|^2 and the residual by the growth of `rules`."""
    system = problem._kernel_system()
    kernels.project(system.lower, system.upper, system.blocks, impulse)
    error = impulse.copy()
    error_square, size = kernels.natural_map(system, impulse, error)
    return float(error_square), float(kernels.measure(error_square, size, rules.data_square, rules.growth))


def choose(problem: Problem, rules: Rules, impulse: Floats) -> Run:
    """Sweep a little, then solve directly where sweeps are slow; the best of all methods stays in `impulse`."""
    if not problem.symmetric:
        return choose_without_symmetry(problem, rules, impulse)
    trial = try_sweeps(problem, rules, impulse)
    size = float(((problem._row_scale * impulse) ** 2).sum())
    solved = trial.residual <= rules.tolerance
    if trial.sweeps == 0 or (solved and size <= ILL_CONDITIONED**2 * rules.data_square):
        return trial
    sweeps, pivots = trial.sweeps, 0
    factor = plan_factor(problem._kernel_system()) if len(problem._blocks) <= MOST_BLOCKS else None
    if factor is not None and factor.operations > MOST_OPERATIONS and not solved:
        longer = run_sweeps(problem, "nncg", rules._replace(max_sweeps=max(rules.max_sweeps - sweeps, 0)), impulse)
        sweeps, solved = sweeps + longer.sweeps, longer.residual <= rules.tolerance
        if solved:
            return Run("nncg", sweeps, 0, longer.residual, "")
    if factor is not None:
        direct = improve(problem, rules, impulse, factor)
        pivots = direct.pivots
        if direct.residual <= rules.tolerance:
            return Run("nncg" if direct.reason else "direct", sweeps, pivots, direct.residual, "")
    if problem.contact_dim.max(initial=1) == 2 and lemke_rows(problem) <= AUTO_LEMKE_ROWS:
        lemke = improve(problem, rules, impulse, None)
        pivots += lemke.pivots
        if lemke.residual <= rules.tolerance:
            return Run("lemke", sweeps, pivots, lemke.residual, "")
    last = run_sweeps(problem, "nncg", rules._replace(max_sweeps=max(rules.max_sweeps - sweeps, 0)), impulse)
    if last.residual > rules.tolerance and factor is not None:
        direct = improve(problem, rules, impulse, factor)
        pivots += direct.pivots
        if direct.residual <= rules.tolerance:
            return Run("direct", sweeps + last.sweeps, pivots, direct.residual, "")
    reason = "" if last.residual <= rules.tolerance else "Neither sweeps nor direct methods have solved all rows."
    return Run("nncg", sweeps + last.sweeps, pivots, last.residual, reason)


def try_sweeps(problem: Problem, rules: Rules, impulse: Floats) -> Run:
    """Take few sweeps, and some more where these do well."""
    before, _ = measured(problem, rules, impulse)
    few = rules._replace(max_sweeps=min(rules.max_sweeps, TRIAL_SWEEPS))
    trial = run_sweeps(problem, "nncg", few, impulse)
    after, _ = measured(problem, rules, impulse)
    if trial.residual <= rules.tolerance or after > TRIAL_GAIN**2 * before:
        return trial
    more = rules._replace(max_sweeps=min(rules.max_sweeps - trial.sweeps, LONGER_TRIAL))
    longer = run_sweeps(problem, "nncg", more, impulse)
    return Run("nncg", trial.sweeps + longer.sweeps, 0, longer.residual, longer.reason)


def improve(problem: Problem, rules: Rules, impulse: Floats, factor: Factor | None) -> Run:
    """Run the direct method, or Lemke's without a factor; `impulse` changes only where the error falls."""
    candidate = impulse.copy()
    run = run_lemke(problem, rules, candidate) if factor is None else run_direct(problem, rules, candidate, factor)
    before, residual = measured(problem, rules, impulse)
    after, _ = measured(problem, rules, candidate)
    if after < 0.5 * before:
        impulse[:] = candidate
        return run
    return Run(run.method, 0, run.pivots, residual, "The error has not fallen.")


def choose_without_symmetry(problem: Problem, rules: Rules, impulse: Floats) -> Run:
    """Solve directly, and by Lemke's method where that fails."""
    if rules.max_sweeps == 0:
        return Run("direct", 0, 0, measured(problem, rules, impulse)[1], "max_sweeps is 0.")
    direct = Run("direct", 0, 0, float("inf"), "The problem is too large for the direct method.")
    if len(problem._blocks) <= MOST_BLOCKS:
        few = rules._replace(max_sweeps=min(rules.max_sweeps, 100 + problem.row_count // 2))
        direct = run_direct(problem, few, impulse)
    if direct.residual <= rules.tolerance:
        return direct
    if problem.contact_dim.max(initial=1) > 2 or lemke_rows(problem) > MOST_LEMKE_ROWS:
        return direct
    lemke = run_lemke(problem, rules, impulse)
    return Run("lemke", 0, direct.pivots + lemke.pivots, lemke.residual, lemke.reason)
