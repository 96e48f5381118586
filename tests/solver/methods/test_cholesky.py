"""The sparse block factor of joint rows against dense linear algebra."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver.core.rows import BOUNDED, EQUATION
from gsenv.solver.jit import njit
from gsenv.solver.methods.cholesky import (
    BLOCKS_PER_BODY,
    add_force,
    add_stiffness,
    change_of,
    factorise,
    forget_factor,
    load_masses,
    substitute,
)
from gsenv.solver.records.plain import as_records
from tests.solver.methods.random_island import Edges, Island

pytestmark = pytest.mark.nojit
DIMS = pytest.mark.parametrize("dim", [2, 3])


@njit
def stiffen(rows: Any, r: int, factor: Any, blocks: Any, stiffness: float) -> None:
    add_stiffness(rows[r], factor, blocks, stiffness)


@njit
def push(rows: Any, r: int, factor: Any, force: float) -> None:
    add_force(rows[r], factor, force)


@njit
def change(rows: Any, r: int, factor: Any) -> Any:
    return change_of(rows[r], factor)


def tree(bodies: int, seed: int) -> Edges:
    """Every body on an earlier one, in random order of the numbers; some on the static body."""
    random = np.random.default_rng(seed)
    number = 1 + random.permutation(bodies)
    edges = [(0, int(number[0]))]
    for k in range(1, bodies):
        edges.append((int(number[random.integers(k)]), int(number[k])))
    return edges


def ring(bodies: int) -> Edges:
    return [(1 + k, 1 + (k + 1) % bodies) for k in range(bodies)]


def grid(width: int, height: int) -> Edges:
    across = [(1 + k + width * j, 2 + k + width * j) for j in range(height) for k in range(width - 1)]
    return across + [(1 + k + width * j, 1 + k + width * (j + 1)) for j in range(height - 1) for k in range(width)]


SHAPES: dict[str, Edges] = {
    "one body": [(0, 1)],
    "pair": [(1, 2)],
    "chain": [(k, k + 1) for k in range(12)],
    "star": [(1, k) for k in range(2, 14)],
    "random tree": tree(20, 1),
    "another tree": tree(31, 2),
    "ring": ring(8),
    "ring held twice": [*ring(9), (0, 1), (0, 5)],
    "two islands": [(1, 2), (2, 3), (4, 5), (5, 6), (6, 4)],
    "grid": grid(4, 5),
    "all with all": [(j, k) for k in range(1, 7) for j in range(k)],
    "given twice": [(1, 2), (1, 2), (2, 1), (2, 3)],
}


@DIMS
@pytest.mark.parametrize("name", SHAPES)
def test_solution_is_that_of_the_dense_system(name: str, dim: int) -> None:
    island = Island(SHAPES[name], dim=dim)
    n = island.plan()
    bodies = len(island.island_bodies)
    assert n == bodies
    assert sorted(island.factor["order"][:n]) == sorted(island.island_bodies)
    random = np.random.default_rng(7)
    stiffness = random.uniform(0.1, 30.0, len(island.rows))
    forces = random.normal(size=len(island.rows))
    factor, blocks, rows = as_records(island.factor), as_records(island.blocks), as_records(island.rows)
    load_masses(n, factor, blocks, as_records(island.substep_bodies))
    for r in range(len(rows)):
        stiffen(rows, r, factor, blocks, stiffness[r])
        push(rows, r, factor, forces[r])
    assert factorise(n, factor, blocks)
    substitute(n, factor, blocks)
    jacobian = island.jacobian()
    dense = island.mass() + jacobian.T @ (stiffness[:, None] * jacobian)
    expected = np.linalg.solve(dense, jacobian.T @ forces)
    found = np.zeros((bodies, island.ndof))
    found[island.factor["order"][:n] - 1] = island.factor["x"][:n]
    np.testing.assert_allclose(found.ravel(), expected, rtol=1e-9, atol=1e-11)
    changes = [change(rows, r, factor) for r in range(len(rows))]
    np.testing.assert_allclose(changes, jacobian @ expected, rtol=1e-9, atol=1e-10)
    forget_factor(island.island_bodies, factor)
    assert (island.factor["place"] == -1).all()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("bodies", [2, 17, 64])
def test_trees_fill_in_nothing(bodies: int, seed: int) -> None:
    # a block for each body and one for each joint between two of them: linear time
    edges = tree(bodies, seed)
    island = Island(edges)
    n = island.plan()
    moving = sum(a > 0 for a, _ in edges)
    assert n == bodies
    assert int(island.factor["count"][:n].sum()) == moving
    last = island.factor["first"][n - 1] + island.factor["count"][n - 1] + 1
    assert last == bodies + moving


@pytest.mark.parametrize("bodies", [5, 40])
def test_a_ring_fills_in_one_block_a_body(bodies: int) -> None:
    island = Island(ring(bodies))
    n = island.plan()
    assert int(island.factor["count"][:n].sum()) <= 2 * bodies


@pytest.mark.parametrize("shape", SHAPES)
def test_blocks_are_listed_by_columns_and_by_rows(shape: str) -> None:
    island = Island(SHAPES[shape])
    n = island.plan()
    by_column = []
    for p in range(n):
        first, count = island.factor["first"][p], island.factor["count"][p]
        rows = island.blocks["row"][first : first + 1 + count]
        assert rows[0] == p
        assert (np.diff(rows) > 0).all()
        assert (island.blocks["column"][first : first + 1 + count] == p).all()
        by_column += [(int(row), p) for row in rows[1:]]
    by_row = []
    for p in range(n):
        k = island.factor["row_first"][p]
        while k >= 0:
            by_row.append((int(island.blocks["row"][k]), int(island.blocks["column"][k])))
            k = island.blocks["next"][k]
    assert by_row == sorted(by_column)


def test_what_does_not_fit_is_refused() -> None:
    island = Island(SHAPES["all with all"], blocks=10)
    assert island.plan() == 0
    forget_factor(island.island_bodies, as_records(island.factor))
    crowd = Island([(j, k) for k in range(1, 2 * BLOCKS_PER_BODY + 10) for j in range(k)])
    assert crowd.plan() == 0  # more than BLOCKS_PER_BODY blocks a body


@pytest.mark.parametrize("shape", SHAPES)
def test_products_of_blocks_are_counted_and_bounded(shape: str) -> None:
    island = Island(SHAPES[shape])
    n = island.plan()
    # below the diagonal block of a column, each pair of blocks makes a product for the block of its two rows
    assert island.products == sum(int(c) * (int(c) + 1) // 2 for c in island.factor["count"][:n])
    forget_factor(island.island_bodies, as_records(island.factor))
    assert island.plan(most_products=island.products) == n
    if island.products > 0:
        forget_factor(island.island_bodies, as_records(island.factor))
        assert island.plan(most_products=island.products - 1) == 0


def test_only_equations_count() -> None:
    island = Island([(1, 2), (2, 3), (3, 4)])
    island.rows["kind"][2:4] = BOUNDED
    assert island.plan(equations=True) == 4
    forget_factor(island.island_bodies, as_records(island.factor))
    island.rows["kind"][:] = BOUNDED
    assert island.plan(equations=True) == 0
    assert island.plan(equations=False) == 4


def test_no_factor_of_what_is_not_positive_definite() -> None:
    island = Island([(0, 1), (1, 2)])
    n = island.plan()
    load_masses(n, as_records(island.factor), as_records(island.blocks), as_records(island.substep_bodies))
    stiffen(as_records(island.rows), 0, as_records(island.factor), as_records(island.blocks), -1e3)
    assert not factorise(n, as_records(island.factor), as_records(island.blocks))


@DIMS
@pytest.mark.parametrize("name", SHAPES)
def test_equations_become_true(name: str, dim: int) -> None:
    # impulses of E v + b = 0 as least squares in the metric of mass: redundant and contradictory rows too
    island = Island(SHAPES[name], rows_per_edge=2, dim=dim)
    random = np.random.default_rng(3)
    jacobian, mass = island.jacobian(), island.mass()
    target = random.normal(size=jacobian.shape[1])
    island.rows["bias"] = -jacobian @ target  # some velocity obeys all of them
    free = island.velocities()
    n = island.factorise()
    assert n == len(island.island_bodies)
    for _ in range(3):
        island.solve(n)
    found = island.velocities()
    np.testing.assert_allclose(jacobian @ found, jacobian @ target, atol=1e-6)
    np.testing.assert_allclose(mass @ (found - free), jacobian.T @ island.rows["impulse"], atol=1e-6)
    # of all velocities that obey, the one nearest to the free one
    root = np.sqrt(np.diag(mass))
    nearest = free + (np.linalg.pinv(jacobian / root) @ (jacobian @ (target - free))) / root
    np.testing.assert_allclose(found, nearest, atol=1e-5)


def test_nothing_is_done_about_equations_that_are_true_enough() -> None:
    island = Island([(0, 1), (1, 2)])
    assert island.rows["kind"][0] == EQUATION
    n = island.factorise()
    before = island.state.copy()
    violation = island.solve(n, enough=1e9)
    w = island.jacobian() @ island.velocities()
    assert violation == pytest.approx((w**2 / island.rows["diagonal"]).sum(), rel=1e-12)
    np.testing.assert_array_equal(island.state["velocity"], before["velocity"])
