"""Problems with known answers or known difficulties, for tests and the benchmark `solve`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.problem.problem import ContactRows, Problem

Array = NDArray[np.float64]
Body = tuple[int, float, float]  # index, x, y

G = 9.81  # m/s^2
STEP = 1.0 / 60.0  # s


def tower(count: int, ratio: float = 1.0) -> tuple[Problem, Array]:
    """Boxes of 1 kg on each other, the top one `ratio` times heavier; and the impulses: the weight from each box up."""
    mass = np.ones(count)
    mass[-1] = ratio
    jacobian = np.eye(count) - np.eye(count, k=-1)
    problem = Problem.from_rows(1.0 / mass, jacobian, np.full(count, -G * STEP), lower=0)
    return problem, G * STEP * np.cumsum(mass[::-1])[::-1]


def pyramid(layers: int, friction: float, ratio: float = 1.0, push: float = 0.3) -> Problem:
    """2D: unit boxes in a pyramid, the top one `ratio` times heavier, under gravity and `push` times as much sideways.

    Two contacts at each interface, so there are more rows than coordinates. Coordinates of a box: x, y, angle.
    """
    gap = 1.02
    place: dict[tuple[int, int], Body] = {}
    for layer in range(layers):
        for k in range(layers - layer):
            place[layer, k] = (len(place), (k + 0.5 * layer) * gap, layer + 0.5)
    coordinates = 3 * len(place)
    rows = []

    def add_contact(below: Body | None, above: Body, x: float, y: float) -> None:
        normal, tangent = np.zeros(coordinates), np.zeros(coordinates)
        for body, sign in ((below, -1.0), (above, 1.0)):
            if body is not None:
                index, body_x, body_y = body
                normal[3 * index : 3 * index + 3] = [0.0, sign, sign * (x - body_x)]
                tangent[3 * index : 3 * index + 3] = [sign, 0.0, -sign * (y - body_y)]
        rows.extend([normal, tangent])

    for (layer, k), body in place.items():
        _, x, y = body
        if layer == 0:
            for side in (-0.5, 0.5):
                add_contact(None, body, x + side, 0.0)
            continue
        for below in (place[layer - 1, k], place[layer - 1, k + 1]):
            left, right = max(x, below[1]) - 0.5, min(x, below[1]) + 0.5
            add_contact(below, body, left, y - 0.5)
            add_contact(below, body, right, y - 0.5)
    mass = np.ones(len(place))
    mass[-1] = ratio
    inverse = np.repeat(1.0 / mass, 3)
    inverse[2::3] *= 6.0
    velocity = np.tile([push * G * STEP, -G * STEP, 0.0], len(place))
    return Problem.from_rows(inverse, np.array(rows), velocity, contacts=ContactRows(friction, dim=2))


def spatial_tower(count: int, friction: float, ratio: float = 1.0, push: float = 0.0) -> tuple[Problem, Array]:
    """3D: cubes of 1 m and 1 kg on each other with contacts at all corners, the top one `ratio` times heavier.

    Also the sum of the four normal impulses of each interface where nothing slides or tips: the weight above.
    """
    rows = []
    corners = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    for k in range(count):
        for x, y in corners:
            block = np.zeros((3, 6 * count))
            for body, sign, z in ((k - 1, -1.0, 0.5), (k, 1.0, -0.5)):
                if body < 0:
                    continue
                arm = np.array([x, y, z])
                for i, direction in enumerate(([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])):
                    block[i, 6 * body : 6 * body + 3] = sign * np.array(direction)
                    block[i, 6 * body + 3 : 6 * body + 6] = sign * np.cross(arm, direction)
            rows.append(block)
    mass = np.ones(count)
    mass[-1] = ratio
    inverse = np.repeat(1.0 / mass, 6)
    inverse.reshape(-1, 6)[:, 3:] *= 6.0
    velocity = np.tile([push * G * STEP, 0.0, -G * STEP, 0.0, 0.0, 0.0], count)
    problem = Problem.from_rows(inverse, np.vstack(rows), velocity, contacts=ContactRows(friction))
    return problem, G * STEP * np.cumsum(mass[::-1])[::-1]


def p_matrix(rng: np.random.Generator, count: int) -> Array:
    """A positive definite matrix without symmetry: its skew part exceeds its symmetric part."""
    factor, skew = rng.normal(size=(2, count, count))
    return factor @ factor.T + 3.0 * (skew - skew.T) + 0.1 * np.eye(count)


def p_problem(rng: np.random.Generator, count: int, boxed: bool = False) -> Problem:
    """A linear complementarity problem with a P-matrix; `boxed`: random bounds instead."""
    b = 5.0 * rng.normal(size=count)
    lower, upper = np.zeros(count), np.full(count, np.inf)
    if boxed:
        lower = np.where(rng.random(count) < 0.2, -np.inf, -rng.random(count))
        upper = np.where(rng.random(count) < 0.2, np.inf, rng.random(count))
    return Problem.from_delassus(p_matrix(rng, count), b, 0, lower, upper)


def degenerate_problem(rng: np.random.Generator, count: int, symmetric: bool = True) -> Problem:
    """Integer data of rank count / 2, and a solution at which many rows have neither impulse nor velocity.

    Symmetric: positive semidefinite. Else a linear program: A is skew, its diagonal zero.
    """
    half = max(count // 2, 1)
    if symmetric:
        factor = rng.integers(-1, 2, size=(count, half)).astype(float)
        A = factor @ factor.T
    else:
        block = rng.integers(-3, 4, size=(count - half, half)).astype(float)
        A = np.zeros((count, count))
        A[half:, :half] = block
        A[:half, half:] = -block.T
    impulse = np.maximum(rng.integers(-2, 3, size=count), 0).astype(float)
    velocity = np.where(impulse > 0.0, 0, np.maximum(rng.integers(-2, 3, size=count), 0))
    return Problem.from_delassus(A, velocity - A @ impulse, lower=0)


def murty_problem(count: int) -> Problem:
    """Murty's example (1978): Lemke's method takes 2^count - 1 pivots. Solution: (1, 0, 0, ...)."""
    return Problem.from_delassus(np.eye(count) + 2.0 * np.tri(count, k=-1), -np.ones(count), lower=0)
