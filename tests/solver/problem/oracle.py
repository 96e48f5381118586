"""Dense reference solutions of small problems, in numpy alone and by other means than sweeps."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

SLACK = 1e-9


def random_delassus(rng: np.random.Generator, rows: int, columns: int | None = None) -> tuple[Array, Array]:
    """A = G G^T and b in the image of G; positive definite where columns >= rows."""
    factor = rng.normal(size=(rows, columns or rows + 2))
    return factor @ factor.T, factor @ rng.normal(size=factor.shape[1])


def box_solutions(A: Array, b: Array, lower: Array, upper: Array) -> list[Array]:
    """Every solution of the box LCP with a regular system, by all 3^n active sets at once."""
    n = len(b)
    sets = np.array(list(itertools.product((-1, 0, 1), repeat=n)))
    sets = sets[~np.any((sets < 0) & np.isinf(lower) | (sets > 0) & np.isinf(upper), axis=1)]
    free = sets == 0
    systems = np.where(free[:, :, None], A, np.eye(n))
    bound = np.where(sets < 0, np.nan_to_num(lower), np.nan_to_num(upper))
    right = np.where(free, -b, bound)
    impulses = np.linalg.solve(systems, right[:, :, None])[:, :, 0]
    w = impulses @ A + b
    inside = (impulses >= lower - SLACK) & (impulses <= upper + SLACK)
    sign = np.where(sets < 0, w >= -SLACK, np.where(sets > 0, w <= SLACK, True))
    return list(impulses[np.all(inside & sign, axis=1)])


def planar_solutions(A: Array, b: Array, friction: Array, lower: Array, upper: Array) -> list[Array]:
    """Every solution with 2D contacts in the first rows and bounded rows behind them.

    Modes of a contact: separate, stick, slip to either side; of a row: lower, free, upper.
    """
    contacts = len(friction)
    rows = range(2 * contacts, len(b))
    choices = ["0s+-"] * contacts
    for r in rows:
        choices.append("f" + "l" * bool(np.isfinite(lower[r])) + "u" * bool(np.isfinite(upper[r])))
    found = []
    for modes in itertools.product(*choices):
        system, right = A.copy(), -b
        for c, mu in enumerate(friction):
            n, t = 2 * c, 2 * c + 1
            if modes[c] == "0":
                system[[n, t]] = np.eye(len(b))[[n, t]]
                right[[n, t]] = 0.0
            elif modes[c] in "+-":  # w_T > 0 or < 0
                system[t] = 0.0
                system[t, t] = 1.0
                system[t, n] = mu if modes[c] == "+" else -mu
                right[t] = 0.0
        for k, r in enumerate(rows):
            if modes[contacts + k] in "lu":
                system[r] = np.eye(len(b))[r]
                right[r] = lower[r] if modes[contacts + k] == "l" else upper[r]
        try:
            impulse = np.linalg.solve(system, right)
        except np.linalg.LinAlgError:
            continue
        dims = np.full(contacts, 2)
        if violation(A, b, impulse, 2 * np.arange(contacts), dims, friction, lower, upper) < 1e-8:
            found.append(impulse)
    return found


def violation(
    A: Array,
    b: Array,
    impulse: Array,
    contact_row: NDArray[np.int64],
    contact_dim: NDArray[np.int64],
    friction: Array,
    lower: Array,
    upper: Array,
) -> float:
    """Largest breach of the conditions themselves, in the problem's own units.

    Bounds, signs, u_N >= 0, lambda_N u_N = 0, |lambda_T| <= mu lambda_N, and where it slides,
    friction opposite to u_T at the cone: mu lambda_N u_T + |u_T| lambda_T = 0.
    """
    w = A @ impulse + b
    worst = [0.0]
    rest = np.ones(len(b), bool)
    for r, dim, mu in zip(contact_row, contact_dim, friction, strict=True):
        rest[r : r + dim] = False
        normal, tangent = impulse[r], impulse[r + 1 : r + dim]
        w_n, w_t = w[r], w[r + 1 : r + dim]
        speed = np.linalg.norm(w_t)
        worst += [-normal, -w_n, abs(normal * w_n), np.linalg.norm(tangent) - mu * normal]
        worst += list(np.abs(mu * normal * w_t + speed * tangent))
    for r in np.flatnonzero(rest):
        worst += [lower[r] - impulse[r], impulse[r] - upper[r]]
        if w[r] > 0.0:
            worst.append(min(w[r], impulse[r] - lower[r]))
        else:
            worst.append(min(-w[r], upper[r] - impulse[r]))
    return float(max(worst))


def one_contact_solutions(W: Array, b: Array, mu: float) -> list[Array]:
    """Every solution of one 3D contact: separate, stick, and a scan over the slip angle."""
    found = []
    if b[0] >= 0.0:
        found.append(np.zeros(3))
    stick = np.linalg.solve(W, -b)
    if np.hypot(stick[1], stick[2]) <= mu * stick[0]:
        found.append(stick)

    def slip(angle: float) -> tuple[float, float, Array]:
        """Cross and dot product of u_T with the assumed slip direction, and the impulse."""
        along = np.array([np.cos(angle), np.sin(angle)])
        unit = np.array([1.0, *(-mu * along)])
        impulse = -b[0] / (W[0] @ unit) * unit
        w = W @ impulse + b
        return along[0] * w[2] - along[1] * w[1], along @ w[1:], impulse

    angles = np.linspace(0.0, 2.0 * np.pi, 1441)
    cross = np.array([slip(angle)[0] for angle in angles])
    for k in np.flatnonzero(cross[:-1] * cross[1:] <= 0.0):
        low, high = angles[k], angles[k + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if slip(middle)[0] * slip(low)[0] > 0.0:
                low = middle
            else:
                high = middle
        value, dot, impulse = slip(0.5 * (low + high))
        if abs(value) < 1e-8 and dot >= 0.0 and impulse[0] >= 0.0:
            found.append(impulse)
    return found


def de_saxce_impulse(A: Array, b: Array, mu: Array, steps: int = 20_000) -> Array:
    """3D contacts by a plain fixed point on all at once: r <- P_K(r - rho (u + mu |u_T| e_N))."""
    rho = 1.0 / np.linalg.eigvalsh(A)[-1]
    r = np.zeros((len(mu), 3))
    for _ in range(steps):
        u = (A @ r.ravel() + b).reshape(-1, 3)
        u[:, 0] += mu * np.hypot(u[:, 1], u[:, 2])
        r = r - rho * u
        length = np.hypot(r[:, 1], r[:, 2])
        n = (r[:, 0] + mu * length) / (1.0 + mu * mu)
        edge = np.column_stack([n, (mu * n / np.maximum(length, 1e-300))[:, None] * r[:, 1:]])
        inside = length <= mu * r[:, 0]
        apex = mu * length <= -r[:, 0]
        r = np.where(inside[:, None], r, np.where(apex[:, None], 0.0, edge))
    return r.ravel()
