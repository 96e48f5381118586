"""Kernels of `problem.solve`: sweeps over bounded rows and Coulomb contacts of W lambda + q.

W is symmetric, in CSR arrays (indptr, indices, data); q is the right-hand side. Rows come in
blocks: a bounded row (dim 1) or a contact of dim 2 or 3, rows (normal, tangents). A contact's
own part of W is kept as its normal row and the eigenbasis of the tangents' Schur complement,
    S = W_TT - W_TN W_NT / W_NN = Q diag(stiffness) Q^T,     k = Q^T W_TN,
one record `BLOCK` per block (for a bounded row only `w_nn` is used).

Cost: one pass over the entries of W per sweep, and one per residual.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import njit

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Block = Any  # one BLOCK record
Blocks = Any  # a record array of BLOCK

PGS, NNCG, APGD = 0, 1, 2


class System(NamedTuple):
    """A problem's arrays: W in CSR, the right-hand side, bounds (row,), and blocks of rows."""

    indptr: Indices
    indices: Indices
    data: Floats
    rhs: Floats
    lower: Floats
    upper: Floats
    blocks: Blocks


class Rules(NamedTuple):
    """How long to sweep, and what errors are compared with."""

    method: int
    tolerance: float
    max_sweeps: int
    data_square: float  # |q/s|^2
    growth: float  # see GROWTH in problem.py


BLOCK = np.dtype(
    [
        ("row", np.int64),  # first row
        ("dim", np.int64),  # 1 bounded row, 2 or 3 contact
        ("friction", np.float64),
        ("scale", np.float64),  # s = sqrt(tr W_ii / dim), 1/sqrt(kg)
        ("w_nn", np.float64),  # 1/kg; 0: nothing can move the row
        ("k_1", np.float64),
        ("k_2", np.float64),
        ("stiffness_1", np.float64),  # with a lower bound, so that a direction without mass stays finite
        ("stiffness_2", np.float64),
        ("cos", np.float64),  # Q = [[cos, -sin], [sin, cos]]
        ("sin", np.float64),
    ],
    align=True,
)

# Sweeps between two residuals while the step is still far above the tolerance.
CHECK_EVERY = 8
# Sweeps without a smaller error after which contacts take short steps instead of exact solves. A single
# contact can have several solutions, and exact solves may alternate between them without end; the step of
# the natural map is continuous. Each further stall shortens it, as a fraction of 1 / tr W_ii.
STALL_SWEEPS = 300
SHORTER = 0.7
SHORTEST = 0.2
# Steps above this fraction keep the conjugate directions; below it sweeps are plain.
SHARE_FOR_NNCG = 0.4


@njit
def slide(
    h_1: float,
    h_2: float,
    block: Block,
    b_n: float,
    normal: float,
) -> tuple[float, float, float]:
    """Return the tangent impulse y (eigenbasis) and the normal impulse of a sliding contact.

    With w_T = -a lambda_T the tangents obey (S + a) y = h. The root of
    p(a) = mu lambda_N / |y| - 1 is bracketed by 0 (outside the cone) and a bound from
    |y| <= |h| / a (inside); safeguarded Newton, exact in one step in 2D.
    """
    mu, w_nn = block.friction, block.w_nn
    norm_k = np.sqrt(block.k_1 * block.k_1 + block.k_2 * block.k_2)
    norm_h = np.sqrt(h_1 * h_1 + h_2 * h_2)
    low = 0.0
    if w_nn > 0.0:
        high = norm_h * (w_nn + mu * norm_k) / (-mu * b_n)
    else:
        high = norm_h / (mu * normal)
    a = 0.0
    y_1, y_2 = 0.0, 0.0
    for _ in range(80):
        inv_1, inv_2 = 1.0 / (block.stiffness_1 + a), 1.0 / (block.stiffness_2 + a)
        y_1, y_2 = h_1 * inv_1, h_2 * inv_2
        length = np.sqrt(y_1 * y_1 + y_2 * y_2)
        slope_length = -(y_1 * y_1 * inv_1 + y_2 * y_2 * inv_2) / length
        slope_normal = 0.0
        if w_nn > 0.0:
            normal = -(b_n + block.k_1 * y_1 + block.k_2 * y_2) / w_nn
            slope_normal = (block.k_1 * y_1 * inv_1 + block.k_2 * y_2 * inv_2) / w_nn
        p = mu * normal / length - 1.0
        if abs(p) <= 4e-16:
            break
        if p < 0.0:
            low = a
        else:
            high = a
        slope = mu * (slope_normal * length - normal * slope_length) / (length * length)
        following = a - p / slope
        if not (low < following < high):
            following = 0.5 * (low + high)
        if abs(following - a) <= 1e-16 * following:
            break
        a = following
    normal = max(normal, 0.0)
    length = np.sqrt(y_1 * y_1 + y_2 * y_2)
    shrink = min(mu * normal / length, 1.0) if length > 0.0 else 0.0  # keeps round-off within the cone
    return y_1 * shrink, y_2 * shrink, normal


@njit
def solve_contact(
    block: Block,
    w_n: float,
    w_1: float,
    w_2: float,
    normal: float,
    t_1: float,
    t_2: float,
) -> tuple[float, float, float]:
    """Solve Coulomb's law for one contact, all others fixed: return impulses (normal, t_1, t_2).

    w is the row velocity at the present impulses. The contact separates where it needs no impulse, sticks
    where the sticking impulse lies in the circular cone, and slides on the cone otherwise. With W_ii > 0 one of
    the three always holds. Directions without mass keep their impulse (a proximal term).
    """
    y_1 = block.cos * t_1 + block.sin * t_2
    y_2 = block.cos * t_2 - block.sin * t_1
    mu, w_nn = block.friction, block.w_nn
    b_n = w_n
    lift = 0.0
    if w_nn > 0.0:
        b_n = w_n - w_nn * normal - block.k_1 * y_1 - block.k_2 * y_2
        lift = w_n / w_nn
    if b_n > 0.0 or (w_nn > 0.0 and b_n == 0.0):
        return 0.0, 0.0, 0.0
    if mu == 0.0:
        if w_nn > 0.0:
            normal = -b_n / w_nn
        return normal, 0.0, 0.0
    # S y + h' = w_T - W_TN w_N / W_NN, so the sticking y is y_old - (that) / S
    h_1 = block.stiffness_1 * y_1 - (block.cos * w_1 + block.sin * w_2 - block.k_1 * lift)
    h_2 = block.stiffness_2 * y_2 - (block.cos * w_2 - block.sin * w_1 - block.k_2 * lift)
    y_1, y_2 = h_1 / block.stiffness_1, h_2 / block.stiffness_2
    if w_nn > 0.0:
        normal = -(b_n + block.k_1 * y_1 + block.k_2 * y_2) / w_nn
    elif normal <= 0.0:
        return 0.0, 0.0, 0.0
    if normal < 0.0 or y_1 * y_1 + y_2 * y_2 > mu * mu * normal * normal:
        y_1, y_2, normal = slide(h_1, h_2, block, b_n, normal)
    return normal, block.cos * y_1 - block.sin * y_2, block.sin * y_1 + block.cos * y_2


@njit
def project_cone(mu: float, n: float, t_1: float, t_2: float) -> tuple[float, float, float]:
    """Return the nearest point of K = {|t| <= mu n}."""
    length = np.sqrt(t_1 * t_1 + t_2 * t_2)
    if length <= mu * n:
        return n, t_1, t_2
    if mu * length <= -n:
        return 0.0, 0.0, 0.0
    n = (n + mu * length) / (1.0 + mu * mu)
    return n, mu * n * t_1 / length, mu * n * t_2 / length


@njit
def row_velocity(
    indptr: Indices,
    indices: Indices,
    data: Floats,
    rhs: Floats,
    impulse: Floats,
    r: int,
) -> float:
    """Return w_r = W_r lambda + q_r."""
    w = rhs[r]
    for k in range(indptr[r], indptr[r + 1]):
        w += data[k] * impulse[indices[k]]
    return w


@njit
def solve_row(w: float, w_rr: float, lower: float, upper: float, impulse: float) -> float:
    """Return the impulse that solves one bounded row, all others fixed."""
    if w_rr > 0.0:
        return min(max(impulse - w / w_rr, lower), upper)
    # nothing moves this row: the bound on the side of its velocity solves it, if it is finite
    if w > 0.0 and lower > -np.inf:
        return lower
    if w < 0.0 and upper < np.inf:
        return upper
    return impulse


@njit
def sweep(system: System, share: float, impulse: Floats) -> tuple[float, float]:
    """Take one Gauss-Seidel sweep in block order; returns sum (s dlambda)^2 and sum (s lambda)^2.

    ContactRows are solved exactly at share 1, below it by one step of the natural map.
    """
    indptr, indices, data, rhs, lower, upper, blocks = system
    change = 0.0
    size = 0.0
    for i in range(len(blocks)):
        block = blocks[i]
        r = block.row
        square = block.scale * block.scale
        w = row_velocity(indptr, indices, data, rhs, impulse, r)
        if block.dim == 1:
            new = solve_row(w, block.w_nn, lower[r], upper[r], impulse[r])
            if np.isfinite(new):
                change += square * (new - impulse[r]) ** 2
                impulse[r] = new
            size += square * impulse[r] * impulse[r]
            continue
        w_1 = row_velocity(indptr, indices, data, rhs, impulse, r + 1)
        w_2, t_2 = 0.0, 0.0
        if block.dim == 3:
            w_2 = row_velocity(indptr, indices, data, rhs, impulse, r + 2)
            t_2 = impulse[r + 2]
        n, t_1 = impulse[r], impulse[r + 1]
        if share == 1.0:
            new_n, new_1, new_2 = solve_contact(block, w, w_1, w_2, n, t_1, t_2)
        else:
            length = share / (block.dim * square)
            w += block.friction * np.sqrt(w_1 * w_1 + w_2 * w_2)
            new_n, new_1, new_2 = project_cone(block.friction, n - length * w, t_1 - length * w_1, t_2 - length * w_2)
        d_n, d_1, d_2 = new_n - n, new_1 - t_1, 0.0
        if block.dim == 3:
            d_2 = new_2 - t_2
        step = square * (d_n * d_n + d_1 * d_1 + d_2 * d_2)
        if np.isfinite(step):
            change += step
            impulse[r] = n + d_n
            impulse[r + 1] = t_1 + d_1
            if block.dim == 3:
                impulse[r + 2] = t_2 + d_2
        size += square * (impulse[r] ** 2 + impulse[r + 1] ** 2)
        if block.dim == 3:
            size += square * impulse[r + 2] ** 2
    return change, size


@njit
def project(lower: Floats, upper: Floats, blocks: Blocks, impulse: Floats) -> None:
    """Move every impulse to the nearest point of its bounds or cone."""
    for i in range(len(blocks)):
        block = blocks[i]
        r = block.row
        if block.dim == 1:
            impulse[r] = min(max(impulse[r], lower[r]), upper[r])
        else:
            t_2 = impulse[r + 2] if block.dim == 3 else 0.0
            n, t_1, t_2 = project_cone(block.friction, impulse[r], impulse[r + 1], t_2)
            impulse[r], impulse[r + 1] = n, t_1
            if block.dim == 3:
                impulse[r + 2] = t_2


@njit
def natural_map(system: System, impulse: Floats, error: Floats) -> tuple[float, float]:
    """Fill `error` (row,) with e = s lambda - P(s lambda - u/s); return |e|^2, |s lambda|^2.

    Formula and source in the docstring of `Problem.residual`.
    """
    indptr, indices, data, rhs, lower, upper, blocks = system
    total = 0.0
    size = 0.0
    for i in range(len(blocks)):
        block = blocks[i]
        r, s = block.row, block.scale
        u_n = row_velocity(indptr, indices, data, rhs, impulse, r) / s
        n = s * impulse[r]
        if block.dim == 1:
            error[r] = n - min(max(n - u_n, s * lower[r]), s * upper[r])
            total += error[r] * error[r]
            size += n * n
            continue
        u_1 = row_velocity(indptr, indices, data, rhs, impulse, r + 1) / s
        t_1 = s * impulse[r + 1]
        u_2, t_2 = 0.0, 0.0
        if block.dim == 3:
            u_2 = row_velocity(indptr, indices, data, rhs, impulse, r + 2) / s
            t_2 = s * impulse[r + 2]
        u_n += block.friction * np.sqrt(u_1 * u_1 + u_2 * u_2)
        p_n, p_1, p_2 = project_cone(block.friction, n - u_n, t_1 - u_1, t_2 - u_2)
        error[r], error[r + 1] = n - p_n, t_1 - p_1
        total += (n - p_n) ** 2 + (t_1 - p_1) ** 2
        size += n * n + t_1 * t_1
        if block.dim == 3:
            error[r + 2] = t_2 - p_2
            total += (t_2 - p_2) ** 2
            size += t_2 * t_2
    return total, size


@njit
def measure(error_square: float, size_square: float, data_square: float, growth: float) -> float:
    """Return nm from |e|^2, |s lambda|^2 and the data's square; inf where any of them overflowed."""
    if error_square == 0.0:
        return 0.0
    scale = max(data_square, min(size_square, growth * growth * data_square))
    if data_square == 0.0:
        scale = size_square
    nm = np.sqrt(error_square / scale)
    return nm if nm < np.inf else np.inf


@njit(makes_arrays=True)
def iterate(system: System, row_scale: Floats, rules: Rules, impulse: Floats) -> tuple[int, float]:
    """Sweep `impulse` in place until nm <= tolerance; returns (sweeps, nm).

    Where no sweep reaches it, `impulse` is that of the smallest |e|.
    """
    method, tolerance, max_sweeps, data_square, growth = rules
    lower, upper, blocks = system.lower, system.upper, system.blocks
    rows = len(impulse)
    error = np.empty(rows)
    project(lower, upper, blocks, impulse)
    e_square, size = natural_map(system, impulse, error)
    nm = measure(e_square, size, data_square, growth)
    if nm <= tolerance:
        return 0, nm
    best, best_nm = impulse.copy(), nm
    best_error = e_square if e_square < np.inf else np.inf
    start = impulse.copy()  # impulses before the present sweep
    last = impulse.copy()  # apgd: result of the last sweep
    direction = np.zeros(rows)  # nncg
    last_step = 0.0
    momentum = 1.0
    share = 1.0
    improved_at = 0
    has_friction = False
    for i in range(len(blocks)):
        has_friction = has_friction or (blocks[i].dim > 1 and blocks[i].friction > 0.0)
    for count in range(1, max_sweeps + 1):
        change, size = sweep(system, share, impulse)
        near = change <= 100.0 * tolerance * tolerance * max(data_square, size)
        if near or count % CHECK_EVERY == 0 or count == max_sweeps:
            e_square, size = natural_map(system, impulse, error)
            nm = measure(e_square, size, data_square, growth)
            if nm <= tolerance:
                return count, nm
            if e_square < 0.998 * best_error:
                best[:] = impulse
                best_nm, best_error, improved_at = nm, e_square, count
            elif has_friction and count - improved_at >= STALL_SWEEPS:
                method = NNCG if method != PGS and share > SHARE_FOR_NNCG else PGS
                share = max(SHORTEST, SHORTER * share)
                improved_at = count
                last_step, momentum = 0.0, 1.0
        if method == NNCG:
            # Silcowitz, Niebe, Erleben 2010: Fletcher-Reeves with d = -gradient = the sweep's step
            step = 0.0
            for r in range(rows):
                step += (row_scale[r] * (impulse[r] - start[r])) ** 2
            if 0.0 < step <= last_step:
                beta = step / last_step
                for r in range(rows):
                    d = impulse[r] - start[r]
                    impulse[r] += beta * direction[r]
                    direction[r] = beta * direction[r] + d
            else:
                direction[:] = 0.0
            last_step = step
        elif method == APGD:
            # Nesterov 1983 with O'Donoghue and Candes' gradient restart 2015
            uphill = 0.0
            for r in range(rows):
                uphill += row_scale[r] ** 2 * (start[r] - impulse[r]) * (impulse[r] - last[r])
            if uphill > 0.0:
                momentum = 1.0
            following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
            ahead = (momentum - 1.0) / following
            momentum = following
            for r in range(rows):
                forward = impulse[r] + ahead * (impulse[r] - last[r])
                last[r] = impulse[r]
                impulse[r] = forward
            project(lower, upper, blocks, impulse)
        start[:] = impulse
    impulse[:] = best
    return max_sweeps, best_nm


def make_blocks(
    block_row: Indices,
    block_dim: Indices,
    friction: Floats,
    own: Floats,
) -> np.recarray[Any, Any]:
    """Return the BLOCK records; `own` (block, 3, 3) is each block's diagonal part of W, zero-padded."""
    blocks = np.zeros(len(block_row), BLOCK).view(np.recarray)  # fields are attributes without jit, too
    blocks["row"], blocks["dim"], blocks["friction"] = block_row, block_dim, friction
    trace = np.trace(own, axis1=1, axis2=2)
    mean = np.maximum(trace, 0.0) / np.maximum(block_dim, 1)
    # a row that nothing moves is measured by the mean scale of the problem
    typical = mean[mean > 0.0].mean() if np.any(mean > 0.0) else 1.0
    blocks["scale"] = np.sqrt(np.where(mean > 0.0, mean, typical))
    w_nn = own[:, 0, 0]
    w_nn = np.where(w_nn > 1e-14 * trace, w_nn, 0.0)
    coupling = np.where(w_nn[:, None] > 0.0, own[:, 1:, 0], 0.0)
    safe = np.where(w_nn > 0.0, w_nn, 1.0)[:, None, None]
    schur = own[:, 1:, 1:] - coupling[:, :, None] * coupling[:, None, :] / safe
    half_difference = 0.5 * (schur[:, 0, 0] - schur[:, 1, 1])
    radius = np.hypot(half_difference, schur[:, 0, 1])
    angle = 0.5 * np.arctan2(schur[:, 0, 1], half_difference)
    # in 2D there is no second tangent; its entry stays the second axis
    spatial = block_dim == 3
    cos, sin = np.where(spatial, [np.cos(angle), np.sin(angle)], [[1.0], [0.0]])
    middle = 0.5 * (schur[:, 0, 0] + schur[:, 1, 1])
    floor = 1e-12 * np.where(trace > 0.0, trace, 1.0)
    blocks["w_nn"], blocks["cos"], blocks["sin"] = w_nn, cos, sin
    blocks["stiffness_1"] = np.maximum(np.where(spatial, middle + radius, schur[:, 0, 0]), floor)
    blocks["stiffness_2"] = np.maximum(np.where(spatial, middle - radius, 0.0), floor)
    blocks["k_1"] = cos * coupling[:, 0] + sin * coupling[:, 1]
    blocks["k_2"] = cos * coupling[:, 1] - sin * coupling[:, 0]
    return blocks
