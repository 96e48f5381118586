"""The order of elimination against the elimination graph itself, written out edge by edge."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.methods.cholesky import ANY_COST, forget_factor
from gsenv.solver.methods.ordering import link_bodies, order_bodies
from gsenv.solver.records.plain import as_records
from tests.solver.methods.random_island import Edges, Island
from tests.solver.methods.test_cholesky import SHAPES, grid

pytestmark = pytest.mark.nojit


def random_graph(bodies: int, edges: int, seed: int) -> Edges:
    pairs = np.random.default_rng(seed).integers(0, bodies + 1, (edges, 2))
    return [(1, 2), *((int(a), int(b)) for a, b in pairs if a != b)]


def tray(boxes: int) -> Edges:
    """Body 1 carries all others, which stand side by side."""
    return [(1, k) for k in range(2, boxes + 2)] + [(k, k + 1) for k in range(2, boxes + 1)]


GRAPHS = SHAPES | {f"random {k}": random_graph(20, 15 + 10 * k, k) for k in range(6)} | {"wide grid": grid(9, 6)}


def graph_of(edges: Edges) -> dict[int, set[int]]:
    graph: dict[int, set[int]] = {body: set() for edge in edges for body in edge if body > 0}
    for a, b in edges:
        if a > 0 and b > 0:
            graph[a].add(b)
            graph[b].add(a)
    return graph


@pytest.mark.parametrize("name", GRAPHS)
def test_a_body_with_the_fewest_neighbours_is_next_and_joins_them(name: str) -> None:
    island = Island(GRAPHS[name])
    n = island.plan()
    order = island.factor["order"][:n].tolist()
    graph = graph_of(GRAPHS[name])
    assert sorted(order) == sorted(graph)
    for p, body in enumerate(order):
        neighbours = graph.pop(body)
        assert len(neighbours) <= min(map(len, graph.values()), default=0) or not graph
        first, count = island.factor["first"][p], island.factor["count"][p]
        below = [order[row] for row in island.blocks["row"][first + 1 : first + 1 + count]]
        assert set(below) == neighbours
        assert len(below) == len(neighbours)
        for other in neighbours:
            graph[other] |= neighbours - {other}
            graph[other].discard(body)


def test_a_tray_is_last_and_its_boxes_have_no_fill() -> None:
    island = Island(tray(300))
    n = island.plan()
    assert island.factor["order"][n - 1] == 1
    assert island.factor["count"][:n].max() == 2  # the next box and the tray


def test_a_second_plan_is_the_first_one() -> None:
    island, again = Island(grid(7, 7)), Island(grid(7, 7))
    island.plan()
    island.factor["place"] = -1  # what is left of the first plan does not matter
    n = island.plan()
    assert again.plan() == n
    np.testing.assert_array_equal(island.factor["order"][:n], again.factor["order"][:n])


def test_an_order_that_takes_too_long_is_given_up() -> None:
    island = Island(grid(7, 7))
    n = island.plan()
    forget_factor(island.island_bodies, as_records(island.factor))

    def order(most_visits: int) -> tuple[int, int]:
        rows, factor = as_records(island.rows), as_records(island.factor)
        link_bodies(rows, len(rows), True, island.island_bodies, factor, island.graph)
        size, products = order_bodies(
            island.island_bodies, factor, island.graph, len(island.blocks), ANY_COST, most_visits
        )
        forget_factor(island.island_bodies, factor)
        return int(size), int(products)

    assert order(ANY_COST) == (n, island.products)
    assert order(0) == (0, 0)
    assert island.plan() == n  # what is left of it does not matter
