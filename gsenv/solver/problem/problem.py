"""Constraint rows and their solver, without bodies or shapes.

A row r has an impulse lambda_r [N s] inside [lower_r, upper_r] and a velocity w = A lambda + b
[m/s], with A = J M^-1 J^T [1/kg] and b = J v + bias. With softness c, u = w + c lambda:

    u_r = 0 where lower < lambda < upper,   u_r >= 0 at the lower,   u_r <= 0 at the upper bound.

So lower = 0 makes a contact, a rope or a one-way clutch, no bounds a lock or a joint, finite
bounds a motor or a brake; -bias is the velocity asked for, softness is a compliance. A contact
is a block of rows (normal, then tangents) under Coulomb's law with the circular cone:

    0 <= lambda_N  perpendicular to  u_N >= 0,    |lambda_T| <= mu lambda_N,
    where u_T != 0:  lambda_T = -mu lambda_N u_T / |u_T|.

    >>> problem = Problem.from_rows(1.0, [[1, 0], [-1, 1]], velocity=[-10, -10], lower=0)
    >>> solve(problem).impulse.round(6)          # two boxes on the ground, g dt = 10
    array([20., 10.])
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import kernels
from .checks import ContactRows, at_least_zero, bounds, contacts_of, inverse_mass_matrix, symmetrised, vector
from .choose import METHODS, run_method
from .csr import CsrMatrix, Index, Vector, matrix

__all__ = ["GROWTH", "ContactRows", "Problem", "Solution", "solve"]

# Impulses may outgrow the data by this factor before `residual` stops dividing by them. Rows
# that contradict each other make impulses grow without bound; dividing by those would hide the error.
# Stacks reach 1e3 at a height of about 100, heavy boxes on light ones their mass ratio.
GROWTH = 1e5


@dataclass(frozen=True, eq=False)
class Problem:
    """Rows and contacts to solve; build with `from_rows` or `from_delassus`, leave unchanged."""

    delassus: CsrMatrix  # A (row, row), 1/kg
    rhs: Vector  # b (row,), m/s
    softness: Vector  # (row,), 1/kg
    lower: Vector  # (row,), N s; contact rows: -inf
    upper: Vector  # (row,), N s; contact rows: inf
    contact_row: Index  # (contact,) row of the normal
    contact_dim: Index  # (contact,) 1, 2 or 3
    friction: Vector  # (contact,)
    jacobian: CsrMatrix | None  # J (row, dof); None from a Delassus matrix
    inverse_mass: CsrMatrix | None  # (dof, dof)
    velocity: Vector | None  # v (dof,), free velocity
    symmetric: bool  # whether A is symmetric
    _system: CsrMatrix  # A + diag(softness)
    _blocks: np.recarray[Any, Any]  # kernels.BLOCK
    _row_scale: Vector  # s (row,)
    _data_square: float

    @classmethod
    def from_rows(
        cls,
        inverse_mass: Any,
        jacobian: Any,
        velocity: ArrayLike,
        bias: ArrayLike = 0,
        softness: ArrayLike = 0,
        lower: ArrayLike = -np.inf,
        upper: ArrayLike = np.inf,
        contacts: ContactRows | None = None,
    ) -> Problem:
        """Return the problem of rows J on coordinates with mass matrix M.

        inverse_mass: M^-1 [1/kg, 1/(kg m^2)], >= 0: a scalar, its diagonal (dof,), or a
            symmetric matrix (dof, dof), dense or scipy.sparse. 0 fixes a coordinate.
        jacobian: J (row, dof), dense or scipy.sparse.
        velocity: (dof,) [m/s, rad/s], the free velocity: after forces, without these rows.
        bias: (row,) [m/s], added to J v; beta C / dt corrects an error C.
        softness: (row,) [1/kg], >= 0; 1 / (dt (dt k + c)) is a spring k with damper c.
        lower, upper: (row,) [N s]; a scalar applies to all rows that are not contacts.
        contacts: which rows are contacts; these take their bounds from the cone.

        ValueError, in one sentence that names the argument and the index, for shapes that
        do not fit, NaN or inf (bounds may be infinite), lower > upper, softness, friction or
        inverse mass below 0, or an asymmetric inverse mass.
        """
        rows = matrix(jacobian, "jacobian")
        count, dof = rows.shape
        inverse = inverse_mass_matrix(inverse_mass, dof)
        free = vector(velocity, "velocity", dof)
        half = rows.product(inverse).product(rows.T)
        mirror = half.T
        delassus = half + mirror
        delassus = CsrMatrix(delassus.shape, delassus.indptr, delassus.indices, delassus.data / 2)
        below = np.flatnonzero(delassus.diagonal() < 0.0)
        if len(below):
            raise ValueError(
                f"inverse_mass gives row {below[0]} a negative effective mass, expected a positive semidefinite matrix."
            )
        rhs = rows.multiply(free) + vector(bias, "bias", count)
        return cls._build(delassus, rhs, softness, lower, upper, contacts, "contacts.", rows, inverse, free)

    @classmethod
    def from_delassus(
        cls,
        A: Any,
        b: ArrayLike,
        softness: ArrayLike = 0,
        lower: ArrayLike = -np.inf,
        upper: ArrayLike = np.inf,
        friction: ArrayLike | None = None,
        contact_dim: ArrayLike = 3,
        contact_rows: ArrayLike | None = None,
    ) -> Problem:
        """Return the problem of an assembled A (row, row) [1/kg] and b (row,) [m/s].

        A: square with a diagonal >= 0, dense or scipy.sparse. A Delassus matrix is symmetric and positive
            semidefinite (the latter is not checked). An asymmetry of up to 1e-3 of max(|A_ij|, |A_ji|,
            sqrt(A_ii A_jj)) is removed, above 1e-6 with a warning; with more the problem is solved as it is,
            by the methods that can (see `solve`): a linear complementarity problem, or one with boxes.
        softness, lower, upper: as in `from_rows`.
        friction, contact_dim, contact_rows: `ContactRows(friction, contact_rows, contact_dim)`;
            friction None: no contacts.

        ValueError as `from_rows`, and where A is not square or has a negative diagonal.
        """
        delassus, symmetric = symmetrised(matrix(A, "A"), "A")
        rhs = vector(b, "b", delassus.shape[0])
        contacts = None if friction is None else ContactRows(friction, contact_rows, contact_dim)
        return cls._build(delassus, rhs, softness, lower, upper, contacts, "contact_", symmetric=symmetric)

    @classmethod
    def _build(
        cls,
        delassus: CsrMatrix,
        rhs: Vector,
        softness: ArrayLike,
        lower: ArrayLike,
        upper: ArrayLike,
        contacts: ContactRows | None,
        prefix: str,
        jacobian: CsrMatrix | None = None,
        inverse_mass: CsrMatrix | None = None,
        velocity: Vector | None = None,
        symmetric: bool = True,
    ) -> Problem:
        count = len(rhs)
        soft = vector(softness, "softness", count)
        at_least_zero(soft, "softness")
        contact_row, contact_dim, friction = contacts_of(contacts, count, prefix)
        in_contact = np.zeros(count, bool)
        for offset in range(3):
            in_contact[contact_row[contact_dim > offset] + offset] = True
        low = bounds(lower, "lower", in_contact, -np.inf, contact_row)
        high = bounds(upper, "upper", in_contact, np.inf)
        crossed = np.flatnonzero(low > high)
        if len(crossed):
            r = crossed[0]
            raise ValueError(f"lower[{r}] is {low[r]:g}, above upper[{r}], which is {high[r]:g}.")

        # for kernels, a contact without tangents is a row with lower bound 0
        normal_only = contact_row[contact_dim == 1]
        blocked = in_contact.copy()
        blocked[normal_only] = False
        real = contact_dim > 1
        free_rows = np.flatnonzero(~blocked)
        block_row = np.concatenate([free_rows, contact_row[real]])
        block_dim = np.concatenate([np.ones_like(free_rows), contact_dim[real]])
        block_friction = np.concatenate([np.zeros(len(free_rows)), friction[real]])
        order = np.argsort(block_row)
        block_row, block_dim = block_row[order], block_dim[order]
        system = delassus + CsrMatrix.from_diagonal(soft)
        own = np.zeros((len(block_row), 3, 3))
        for i in range(3):
            for j in range(3):
                part = np.flatnonzero(block_dim > max(i, j))
                own[part, i, j] = system.entries_at(block_row[part] + i, block_row[part] + j)
        blocks = kernels.make_blocks(block_row, block_dim, block_friction[order], own)
        row_scale = np.repeat(blocks["scale"], block_dim)
        kernel_low = low.copy()
        kernel_low[normal_only] = 0.0
        forced = np.where(blocked, 0.0, np.clip(0.0, kernel_low, high))
        data = max(np.sum((rhs / row_scale) ** 2), np.sum((row_scale * forced) ** 2))
        problem = cls(
            delassus, rhs, soft, kernel_low, high, contact_row, contact_dim, friction,
            jacobian, inverse_mass, velocity, symmetric, system, blocks, row_scale, float(data),
        )  # fmt: skip
        for array in (rhs, soft, kernel_low, high, contact_row, contact_dim, friction):
            array.setflags(write=False)
        return problem

    @property
    def row_count(self) -> int:
        """Number of rows."""
        return len(self.rhs)

    def residual(self, impulse: ArrayLike) -> float:
        """Return the natural-map residual `nm` of any impulses (row,), 0 for a solution.

        With u = (A + diag(softness)) lambda + b, block by block:
            s_i = sqrt(tr(A + softness)_ii / d),  d = 1 for a bounded row, 2 or 3 for a contact;
            e_i = s_i lambda_i - P(s_i lambda_i - u^_i / s_i);
        bounded row: P clips to [s lower, s upper], u^ = u. Contact: P is the Euclidean
        projection on K = {|t| <= mu n}, and u^ = u + mu |u_T| e_N (De Saxce and Feng 1998), so
        that e_i = 0 is Coulomb's law exactly.
            nm = |e| / max(|b / s|, min(|s lambda|, 1e5 g)),
            g = max(|b / s|, |s lambda_0|),  lambda_0 = the impulse nearest 0 within bounds.
        The cap 1e5 g acts where impulses exceed their data by that factor: impulses of contradictory
        rows grow without bound, and must not count as solved. Scaling all masses, the unit of
        length or of time, or the Jacobian of a bounded row does not change nm. A row that
        nothing can move (A_rr = 0) uses the root mean square of the other s.
        """
        return self._measure(vector(impulse, "impulse", self.row_count))[0]

    def _measure(self, impulse: Vector) -> tuple[float, Vector]:
        error = np.zeros(self.row_count)
        e_square, size = kernels.natural_map(self._kernel_system(), impulse, error)
        nm = float(kernels.measure(e_square, size, self._data_square, GROWTH))
        return nm, error

    def _kernel_system(self) -> kernels.System:
        w = self._system
        return kernels.System(w.indptr, w.indices, w.data, self.rhs, self.lower, self.upper, self._blocks)


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of `solve`; where `converged` is False, `unsolved_rows` are the rows with large errors."""

    impulse: Vector  # lambda (row,), N s; always finite and within bounds
    row_velocity: Vector  # A lambda + b (row,), m/s, without the softness term
    body_velocity: Vector | None  # v + M^-1 J^T lambda (dof,); None from a Delassus matrix
    residual: float  # nm, see Problem.residual
    sweeps: int
    converged: bool
    row_error: Vector  # (row,) the row's share of the residual: |row_error| = residual
    tolerance: float
    method: str  # the method that produced `impulse`
    pivots: int  # linear systems solved by the direct method, and pivots of Lemke's
    reason: str  # one sentence on why it has not converged, else ""

    @property
    def unsolved_rows(self) -> Index:
        """Rows whose own share exceeds the tolerance, largest first: mostly contradictory rows.

        Empty if converged. With softness such rows have a compromise as their solution.
        """
        if self.converged:
            return np.zeros(0, np.int64)
        worst = np.argsort(-np.abs(self.row_error), kind="stable")
        share = min(self.tolerance, self.residual) / np.sqrt(max(len(worst), 1))
        return worst[np.abs(self.row_error[worst]) >= share]


def solve(
    problem: Problem,
    method: str = "auto",
    tolerance: float = 1e-8,
    max_sweeps: int = 10_000,
    start: ArrayLike | None = None,
) -> Solution:
    """Solve a problem until `problem.residual` is at most `tolerance`.

    | method | matrix A | bounds | contacts | use it for |
    |---|---|---|---|---|
    | "auto" | any | yes | 2D, 3D | everything; `Solution.method` names the one it chose |
    | "pgs" | symmetric | yes | 2D, 3D | few rows of similar mass |
    | "nncg", "apgd" | symmetric | yes | 2D, 3D | many rows, mass ratios up to 1e3 |
    | "direct" | any | yes | 2D, 3D | tall towers, mass ratios up to 1e9, redundant rows, P-matrices |
    | "lemke" | any | yes | 2D | up to 2000 rows without symmetry |

    auto: a few sweeps of "nncg"; then "direct", if these are slow or impulses exceed their data a hundred times; then
        "lemke", if that fails and contacts are 2D; then sweeps. Without symmetry "direct", then "lemke".
    Guarantees, in exact arithmetic and within max_sweeps: without contacts "direct" solves symmetric positive
        semidefinite and P-matrices, "lemke" P-matrices. With contacts "lemke" solves positive definite matrices;
        "direct" has no guarantee there.
    method: "pgs", projected Gauss-Seidel with an exact one-contact solve (circular cone); "nncg", the same sweep as the
        gradient of a nonlinear conjugate gradient method (Silcowitz, Niebe, Erleben 2010); "apgd", the same sweep with
        Nesterov momentum and gradient restart. Where friction stalls, contacts continue with short projected steps.
        "direct", the states of all rows by block principal pivoting (Judice and Pires 1994; Murty 1974), those of
        contacts by semismooth Newton steps (Alart and Curnier 1991), within proximal steps (Rockafellar 1976) that
        make redundant rows regular. "lemke", the path of Lemke 1965 with bounds and lexicographic ties; 2D contacts as
        in Stewart and Trinkle 1996.
    tolerance: bound on the residual nm, >= 0. At loose tolerances the errors |e| must also fall
        to a tenth of the data (this matters only where impulses far exceed their data). "direct" and "lemke" don't stop
        at the tolerance, but at rounding errors.
    max_sweeps: after these, the iterate of least error is returned with converged=False. It also limits the
        linear systems that "direct" solves and the pivots of "lemke", each by itself.
    start: (row,) first impulses [N s], projected to their bounds; default 0. A start within
        the tolerance costs 0 sweeps. "lemke" does not use it.

    Singular, redundant and contradictory rows are allowed: redundant rows share their impulse,
    contradictory rows end with converged=False and are among `unsolved_rows`. `Solution.reason` says why.
    Problems with friction may have several solutions or none; each method returns one.

    TypeError for anything but a Problem; ValueError for an unknown method, one that can't solve a problem of this kind,
    a bad tolerance, max_sweeps or start.
    """
    if not isinstance(problem, Problem):
        raise TypeError(f"solve takes a Problem, not {type(problem).__name__}: Problem.from_rows makes one.")
    if method not in METHODS:
        raise ValueError(f"Unknown method {method!r}, expected one of {', '.join(METHODS)}.")
    if not tolerance >= 0.0:
        raise ValueError(f"tolerance is {tolerance}, expected a number of at least 0.")
    if not isinstance(max_sweeps, int | np.integer) or max_sweeps < 0:
        raise ValueError(f"max_sweeps is {max_sweeps}, expected a whole number of at least 0.")
    impulse = vector(0.0 if start is None else start, "start", problem.row_count)
    if problem._data_square == 0.0:
        impulse[:] = 0.0  # no row needs an impulse
    # The kernel stops by one number; the smaller growth keeps |e| below a tenth of the data.
    growth = min(GROWTH, 0.1 / tolerance) if tolerance > 0.0 else GROWTH
    rules = kernels.Rules(kernels.PGS, float(tolerance), int(max_sweeps), problem._data_square, max(growth, 1.0))
    run = run_method(problem, method, rules, impulse)
    residual, error = problem._measure(impulse)
    body_velocity = None
    if problem.jacobian is not None:
        assert problem.inverse_mass is not None
        assert problem.velocity is not None
        push = problem.jacobian.T.multiply(impulse)
        body_velocity = problem.velocity + problem.inverse_mass.multiply(push)
    return Solution(
        impulse=impulse,
        row_velocity=problem.delassus.multiply(impulse) + problem.rhs,
        body_velocity=body_velocity,
        residual=residual,
        sweeps=run.sweeps,
        converged=bool(run.residual <= tolerance),
        row_error=_shares(error, residual),
        tolerance=float(tolerance),
        method=run.method,
        pivots=run.pivots,
        reason="" if run.residual <= tolerance else run.reason,
    )


def _shares(error: Vector, residual: float) -> Vector:
    """Return `error` scaled to the norm `residual`; where that overflowed, its infinite rows."""
    if not np.isfinite(residual):
        return np.where(np.isfinite(error), 0.0, np.inf)
    norm = np.linalg.norm(error)
    return error * (residual / norm) if norm > 0.0 else error
