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
from numpy.typing import ArrayLike, NDArray

from . import kernels
from .csr import CsrMatrix, Index, Vector, dense_array, matrix, symmetric_part

METHODS = {"pgs": kernels.PGS, "nncg": kernels.NNCG, "apgd": kernels.APGD}

# Impulses may outgrow the data by this factor before `residual` stops dividing by them. Rows
# that contradict each other make impulses grow without bound; dividing by those would hide the error.
# Stacks reach 1e3 at a height of about 100, heavy boxes on light ones their mass ratio.
GROWTH = 1e5


@dataclass(frozen=True)
class ContactRows:
    """Which rows of a problem are contacts.

    friction: coefficient >= 0, a scalar or one per contact.
    rows: first row (the normal) of each contact; its tangents follow it. Default: consecutive
        contacts from row 0, as many as `friction` has entries; for a scalar friction, up to
        the last row.
    dim: rows of a contact, a scalar or one per contact: 3 = normal and two tangents in a
        circular cone, 2 = normal and one tangent, 1 = normal only.
    """

    friction: ArrayLike
    rows: ArrayLike | None = None
    dim: ArrayLike = 3


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
        inverse = _inverse_mass(inverse_mass, dof)
        free = _vector(velocity, "velocity", dof)
        half = rows.product(inverse).product(rows.T)
        mirror = half.T
        delassus = half + mirror
        delassus = CsrMatrix(delassus.shape, delassus.indptr, delassus.indices, delassus.data / 2)
        below = np.flatnonzero(delassus.diagonal() < 0.0)
        if len(below):
            raise ValueError(
                f"inverse_mass gives row {below[0]} a negative effective mass, expected a positive semidefinite matrix."
            )
        rhs = rows.multiply(free) + _vector(bias, "bias", count)
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

        A: symmetric with a diagonal >= 0, dense or scipy.sparse; a Delassus matrix is positive
            semidefinite (not checked). softness, lower, upper: as in `from_rows`.
        friction, contact_dim, contact_rows: `ContactRows(friction, contact_rows, contact_dim)`;
            friction None: no contacts.

        ValueError as `from_rows`, and where A is asymmetric or has a negative diagonal.
        """
        delassus = symmetric_part(matrix(A, "A"), "A")
        rhs = _vector(b, "b", delassus.shape[0])
        contacts = None if friction is None else ContactRows(friction, contact_rows, contact_dim)
        return cls._build(delassus, rhs, softness, lower, upper, contacts, "contact_")

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
    ) -> Problem:
        count = len(rhs)
        soft = _vector(softness, "softness", count)
        _at_least_zero(soft, "softness")
        contact_row, contact_dim, friction = _contacts(contacts, count, prefix)
        in_contact = np.zeros(count, bool)
        for offset in range(3):
            in_contact[contact_row[contact_dim > offset] + offset] = True
        low = _bounds(lower, "lower", in_contact, -np.inf, contact_row)
        high = _bounds(upper, "upper", in_contact, np.inf)
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
            jacobian, inverse_mass, velocity, system, blocks, row_scale, float(data),
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
        return self._measure(_vector(impulse, "impulse", self.row_count))[0]

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
    method: str = "pgs",
    tolerance: float = 1e-8,
    max_sweeps: int = 10_000,
    start: ArrayLike | None = None,
) -> Solution:
    """Solve a problem: sweep over the rows until `problem.residual` is at most `tolerance`.

    method: "pgs", projected Gauss-Seidel with an exact one-contact solve (circular cone);
        "nncg", the same sweep as the gradient of a nonlinear conjugate gradient method
        (Silcowitz, Niebe, Erleben 2010); "apgd", the same sweep with Nesterov momentum and
        gradient restart. Where friction stalls, contacts continue with short projected steps.
    tolerance: bound on the residual nm, >= 0. At loose tolerances the errors |e| must also fall
        to a tenth of the data (this matters only where impulses far exceed their data).
    max_sweeps: after these, the iterate of least error is returned with converged=False.
    start: (row,) first impulses [N s], projected to their bounds; default 0. A start within
        the tolerance costs 0 sweeps.

    Singular, redundant and contradictory rows are allowed: redundant rows share their impulse,
    contradictory rows end with converged=False and are among `unsolved_rows`.

    ValueError for an unknown method, a bad tolerance, max_sweeps or start.
    """
    if method not in METHODS:
        raise ValueError(f"Unknown method {method!r}, expected one of {', '.join(METHODS)}.")
    if not tolerance >= 0.0:
        raise ValueError(f"tolerance is {tolerance}, expected a number of at least 0.")
    if not isinstance(max_sweeps, int | np.integer) or max_sweeps < 0:
        raise ValueError(f"max_sweeps is {max_sweeps}, expected a whole number of at least 0.")
    impulse = _vector(0.0 if start is None else start, "start", problem.row_count)
    if problem._data_square == 0.0:
        impulse[:] = 0.0  # no row needs an impulse
    # The kernel stops by one number; the smaller growth keeps |e| below a tenth of the data.
    growth = min(GROWTH, 0.1 / tolerance) if tolerance > 0.0 else GROWTH
    rules = kernels.Rules(METHODS[method], float(tolerance), int(max_sweeps), problem._data_square, max(growth, 1.0))
    sweeps, bound = kernels.iterate(problem._kernel_system(), problem._row_scale, rules, impulse)
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
        sweeps=int(sweeps),
        converged=bool(bound <= tolerance),
        row_error=_shares(error, residual),
        tolerance=float(tolerance),
    )


def _vector(value: ArrayLike, name: str, size: int, infinite: bool = False) -> Vector:
    """Return a new (size,) array from a scalar or (size,) values, finite unless `infinite`."""
    array = dense_array(value, name)
    if array.shape not in ((), (size,)):
        raise ValueError(f"{name} has shape {array.shape}, expected a scalar or ({size},).")
    bad = np.flatnonzero(np.isnan(array) if infinite else ~np.isfinite(array))
    if len(bad):
        place = f"{name}[{bad[0]}]" if array.ndim else name
        wanted = "a number" if infinite else "a finite number"
        raise ValueError(f"{place} is {array.flat[bad[0]]}, expected {wanted}.")
    return np.broadcast_to(array, (size,)).copy()


def _shares(error: Vector, residual: float) -> Vector:
    """Return `error` scaled to the norm `residual`; where that overflowed, its infinite rows."""
    if not np.isfinite(residual):
        return np.where(np.isfinite(error), 0.0, np.inf)
    norm = np.linalg.norm(error)
    return error * (residual / norm) if norm > 0.0 else error


def _at_least_zero(array: Vector, name: str) -> None:
    bad = np.flatnonzero(array < 0.0)
    if len(bad):
        raise ValueError(f"{name}[{bad[0]}] is {array[bad[0]]:g}, expected at least 0.")


def _inverse_mass(value: Any, dof: int) -> CsrMatrix:
    if not (isinstance(value, CsrMatrix) or hasattr(value, "tocoo")):
        value = dense_array(value, "inverse_mass")
        if value.ndim < 2:
            diagonal = _vector(value, "inverse_mass", dof)
            _at_least_zero(diagonal, "inverse_mass")
            return CsrMatrix.from_diagonal(diagonal)
    inverse = matrix(value, "inverse_mass")
    if inverse.shape != (dof, dof):
        raise ValueError(f"inverse_mass has shape {inverse.shape}, expected ({dof}, {dof}).")
    return symmetric_part(inverse, "inverse_mass")


def _bounds(
    value: ArrayLike,
    name: str,
    in_contact: NDArray[np.bool_],
    unbounded: float,
    normals: Index | tuple[()] = (),
) -> Vector:
    """Return the bounds of bounded rows; contact rows have none but the cone, and others are refused.

    A lower bound of 0 on `normals` agrees with the cone and is allowed.
    """
    array = _vector(value, name, len(in_contact), infinite=True)
    wrong = np.flatnonzero(array == -unbounded)
    if len(wrong):
        raise ValueError(f"{name}[{wrong[0]}] is {array[wrong[0]]}, so no impulse is allowed.")
    if np.ndim(value):
        array[[r for r in normals if array[r] == 0.0]] = unbounded
        bound = np.flatnonzero(in_contact & np.isfinite(array))
        if len(bound):
            raise ValueError(
                f"{name}[{bound[0]}] is {array[bound[0]]:g} on a contact row, "
                f"expected {unbounded} (the cone bounds it)."
            )
    array[in_contact] = unbounded
    return array


def _contacts(contacts: ContactRows | None, count: int, prefix: str) -> tuple[Index, Index, Vector]:
    """Return first row, dim and friction of each contact, validated."""
    if contacts is None:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    friction_name = "friction" if prefix == "contact_" else prefix + "friction"
    friction = dense_array(contacts.friction, friction_name)
    dim = _whole(contacts.dim, prefix + "dim")
    rows = None if contacts.rows is None else _whole(contacts.rows, prefix + "rows")
    if rows is not None and rows.ndim != 1:
        raise ValueError(f"{prefix}rows has shape {rows.shape}, expected one dimension.")
    bad = np.flatnonzero((dim < 1) | (dim > 3))
    if len(bad):
        raise ValueError(f"{prefix}dim is {dim.flat[bad[0]]}, expected 1, 2 or 3.")
    if rows is not None:
        size = len(rows)
    elif friction.ndim or dim.ndim:
        size = friction.size if friction.ndim else dim.size
    else:
        size = count // int(dim)
        if size * int(dim) != count:
            raise ValueError(f"{prefix}dim {int(dim)} does not divide {count} rows, expected {prefix}rows.")
    friction = _vector(friction, friction_name, size)
    _at_least_zero(friction, friction_name)
    dim = _vector(dim, prefix + "dim", size).astype(np.int64)
    if rows is None:
        rows = np.cumsum(dim) - dim
    outside = np.flatnonzero((rows < 0) | (rows + dim > count))
    if len(outside):
        k = outside[0]
        raise ValueError(f"{prefix}rows[{k}] is {rows[k]}, its {dim[k]} rows don't fit into {count} rows.")
    order = np.argsort(rows, kind="stable")
    clash = np.flatnonzero(rows[order][:-1] + dim[order][:-1] > rows[order][1:])
    if len(clash):
        i, j = order[clash[0]], order[clash[0] + 1]
        raise ValueError(f"{prefix}rows[{j}] is {rows[j]}, inside the contact at row {rows[i]}.")
    return rows, dim, friction


def _whole(value: ArrayLike, name: str) -> Index:
    array = dense_array(value, name)
    if not np.all(np.isfinite(array)) or np.any(array != np.floor(array)):
        raise ValueError(f"{name} must hold whole numbers.")
    return array.astype(np.int64)
