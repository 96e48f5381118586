"""An island of random bodies and rows, for tests of the factor of joint rows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.core.joint_rows import finish_row
from gsenv.solver.core.rows import row_dtype
from gsenv.solver.jit import njit
from gsenv.solver.methods.cholesky import (
    ANY_COST,
    BLOCKS_PER_BODY,
    block_dtype,
    factor_dtype,
    graph_size,
    plan_factor,
)
from gsenv.solver.methods.joint_factor import factorise_equations, solve_equations
from gsenv.solver.records.model import NDOF, body_state_dtype
from gsenv.solver.records.plain import as_records
from gsenv.solver.records.scratch_dtypes import substep_body_dtype

Array = NDArray[Any]
Edges = list[tuple[int, int]]


# a row, whose fields share places, can't be handed to a kernel by itself


@njit
def finish(rows: Any, r: int, substep_bodies: Any) -> None:
    finish_row(rows[r], 0, 0.0, substep_bodies)


class Island:
    """Bodies with random masses, and rows with random directions between pairs of them; body 0 is static."""

    def __init__(
        self, edges: Edges, rows_per_edge: int = 2, blocks: int | None = None, seed: int = 0, dim: int = 2
    ) -> None:
        random = np.random.default_rng(seed)
        self.ndof = NDOF[dim]
        bodies = 1 + max(max(edge) for edge in edges)
        self.edges = edges
        self.substep_bodies = np.zeros(bodies, substep_body_dtype(dim))
        for b in range(1, bodies):
            mass, inertia = random.uniform(0.5, 3.0), random.uniform(0.1, 1.0, self.ndof - dim)
            diagonal = np.array([mass] * dim + list(inertia))
            self.substep_bodies["mass_matrix"][b] = np.diag(diagonal)
            self.substep_bodies["inverse"][b] = 1.0 / diagonal
        self.rows = np.zeros(rows_per_edge * len(edges), row_dtype(dim))
        for r in range(len(self.rows)):
            self.rows["body_a"][r], self.rows["body_b"][r] = edges[r // rows_per_edge]
            self.rows["jacobian_a"][r] = random.normal(size=self.ndof)
            self.rows["jacobian_b"][r] = random.normal(size=self.ndof)
        self.refresh()
        self.island_bodies = np.arange(1, bodies, dtype=np.int32)
        self.factor = np.zeros(bodies, factor_dtype(dim))
        self.factor["place"] = -1
        self.blocks = np.zeros(blocks or BLOCKS_PER_BODY * bodies, block_dtype(dim))
        self.graph = np.zeros(graph_size(len(self.rows), bodies, len(self.blocks)), np.int32)
        self.state = np.zeros(bodies, body_state_dtype(dim))
        self.state["velocity"][1:] = random.normal(size=(bodies - 1, self.ndof))

    def refresh(self) -> None:
        """Compute what follows from masses, directions and softness."""
        for r in range(len(self.rows)):
            finish(as_records(self.rows), r, as_records(self.substep_bodies))

    def plan(self, equations: bool = True, most_products: int = ANY_COST) -> int:
        size, products = plan_factor(
            as_records(self.rows), len(self.rows), equations, self.island_bodies,
            as_records(self.factor), self.graph, as_records(self.blocks), most_products,
        )  # fmt: skip
        self.products = int(products)
        return int(size)

    def factorise(self) -> int:
        """Factorise the equations; returns the size."""
        return int(
            factorise_equations(
                as_records(self.rows), len(self.rows), self.island_bodies, as_records(self.substep_bodies),
                as_records(self.factor), self.graph, as_records(self.blocks),
            )
        )  # fmt: skip

    def solve(self, size: int, enough: float = 0.0) -> float:
        """Solve the equations once; returns sum w^2 / A_rr before."""
        return float(
            solve_equations(
                as_records(self.rows), len(self.rows), as_records(self.state), size,
                as_records(self.factor), as_records(self.blocks), enough, None,
            )
        )  # fmt: skip

    def velocities(self) -> Array:
        """(body * ndof), of all but the static body."""
        return np.array(self.state["velocity"][1:]).ravel()

    def jacobian(self) -> Array:
        """(row, body * ndof), dense; the static body feels nothing."""
        dense = np.zeros((len(self.rows), len(self.substep_bodies), self.ndof))
        for r, row in enumerate(self.rows):
            dense[r, row["body_a"]] += row["jacobian_a"]
            dense[r, row["body_b"]] += row["jacobian_b"]
        return dense[:, 1:].reshape(len(self.rows), -1)

    def mass(self) -> Array:
        return np.diag(np.concatenate([np.diag(m) for m in self.substep_bodies["mass_matrix"][1:]]))
