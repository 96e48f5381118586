"""A small compressed-sparse-row matrix: the part of scipy.sparse that `Problem` needs, with numpy alone."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CsrMatrix:
    """Compressed sparse rows: row r holds `data[k]` in column `indices[k]`,
    `k = indptr[r] .. indptr[r + 1] - 1`. Columns ascend within a row, none occurs twice."""

    shape: tuple[int, int]
    indptr: Index  # (rows + 1,)
    indices: Index  # (nnz,)
    data: Vector  # (nnz,)

    @classmethod
    def from_entries(cls, rows: Index, columns: Index, data: Vector, shape: tuple[int, int]) -> CsrMatrix:
        """Build from (row, column, value) triples in any order; duplicates are added, zeros removed."""
        key = rows * shape[1] + columns
        order = np.argsort(key, kind="stable")
        key, data = key[order], data[order]
        first = np.flatnonzero(np.diff(key, prepend=-1))
        total = np.add.reduceat(data, first) if len(first) else data
        key = key[first][total != 0.0]
        indptr = np.zeros(shape[0] + 1, np.int64)
        row, column = np.divmod(key, max(shape[1], 1))
        np.cumsum(np.bincount(row, minlength=shape[0]), out=indptr[1:])
        return cls(shape, indptr, column, total[total != 0.0])

    @classmethod
    def from_diagonal(cls, diagonal: Vector) -> CsrMatrix:
        """The square matrix with this diagonal."""
        index = np.arange(len(diagonal), dtype=np.int64)
        return cls.from_entries(index, index, diagonal, (len(diagonal), len(diagonal)))

    @property
    def nnz(self) -> int:
        """Number of stored entries."""
        return len(self.data)

    @property
    def entry_rows(self) -> Index:
        """The row of each stored entry, shape (nnz,)."""
        return np.repeat(np.arange(self.shape[0], dtype=np.int64), np.diff(self.indptr))

    @property
    def T(self) -> CsrMatrix:
        """The transpose."""
        return CsrMatrix.from_entries(self.indices, self.entry_rows, self.data, self.shape[::-1])

    def diagonal(self) -> Vector:
        """The main diagonal, shape (min(shape),)."""
        rows = self.entry_rows
        on = rows == self.indices
        diagonal = np.zeros(min(self.shape))
        diagonal[rows[on]] = self.data[on]
        return diagonal

    def __add__(self, other: CsrMatrix) -> CsrMatrix:
        return CsrMatrix.from_entries(
            np.concatenate([self.entry_rows, other.entry_rows]),
            np.concatenate([self.indices, other.indices]),
            np.concatenate([self.data, other.data]),
            self.shape,
        )

    def multiply(self, vector: Vector) -> Vector:
        """Return matrix times vector."""
        products = self.data * vector[self.indices]
        total = np.bincount(self.entry_rows, weights=products, minlength=self.shape[0])
        return total.astype(np.float64)

    def product(self, other: CsrMatrix) -> CsrMatrix:
        """Return matrix times matrix, by listing every product of two entries."""
        length = np.diff(other.indptr)[self.indices]
        ends = np.cumsum(length)
        # k runs over the row of `other` that belongs to each entry of this matrix
        k = np.arange(int(length.sum())) + np.repeat(other.indptr[self.indices] - ends + length, length)
        return CsrMatrix.from_entries(
            np.repeat(self.entry_rows, length),
            other.indices[k],
            np.repeat(self.data, length) * other.data[k],
            (self.shape[0], other.shape[1]),
        )

    def entries_at(self, rows: Index, columns: Index) -> Vector:
        """Return the values at these rows and columns, 0 where none is stored."""
        key = self.entry_rows * self.shape[1] + self.indices  # ascends
        wanted = rows * self.shape[1] + columns
        if self.nnz == 0:
            return np.zeros(len(wanted))
        k = np.minimum(np.searchsorted(key, wanted), self.nnz - 1)
        return np.where(key[k] == wanted, self.data[k], 0.0)

    def toarray(self) -> Vector:
        """The dense matrix."""
        dense = np.zeros(self.shape)
        dense[self.entry_rows, self.indices] = self.data
        return dense

    def to_scipy(self) -> Any:
        """A `scipy.sparse.csr_array` (needs scipy)."""
        sparse = importlib.import_module("scipy.sparse")
        return sparse.csr_array((self.data, self.indices, self.indptr), shape=self.shape)


def dense_array(value: ArrayLike, name: str) -> Vector:
    """Return `value` as a new float array; ValueError naming the argument if it is no array of numbers."""
    try:
        if np.iscomplexobj(value):
            raise TypeError
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be an array of real numbers.") from None


def matrix(value: Any, name: str) -> CsrMatrix:
    """A CsrMatrix from a CsrMatrix, any scipy.sparse matrix or array, or a dense (r, c) array.

    ValueError where an entry is not finite or the value has not two dimensions.
    """
    if isinstance(value, CsrMatrix):
        rows, columns, data, shape = value.entry_rows, value.indices, value.data, value.shape
    elif hasattr(value, "tocoo"):
        entries = value.tocoo()
        rows, columns = np.asarray(entries.row, np.int64), np.asarray(entries.col, np.int64)
        data, shape = dense_array(entries.data, name), entries.shape
    else:
        dense = dense_array(value, name)
        if dense.ndim != 2:
            raise ValueError(f"{name} has shape {dense.shape}, expected two dimensions.")
        rows, columns = (np.asarray(index, np.int64) for index in np.nonzero(dense))
        data, shape = dense[rows, columns], dense.shape
    bad = np.flatnonzero(~np.isfinite(data))
    if len(bad):
        k = bad[0]
        raise ValueError(f"{name}[{rows[k]}, {columns[k]}] is {data[k]}, expected a finite number.")
    return CsrMatrix.from_entries(rows, columns, data, (int(shape[0]), int(shape[1])))


def asymmetry(value: CsrMatrix, name: str) -> tuple[float, int, int]:
    """Return the largest `|M_ij - M_ji| / max(|M_ij|, |M_ji|, sqrt(M_ii M_jj))` of a square matrix, with its i and j.

    ValueError where M isn't square or has a diagonal entry below 0.
    """
    if value.shape[0] != value.shape[1]:
        raise ValueError(f"{name} has shape {value.shape}, expected a square matrix.")
    diagonal = value.diagonal()
    negative = np.flatnonzero(diagonal < 0.0)
    if len(negative):
        k = negative[0]
        raise ValueError(f"{name}[{k}, {k}] is {diagonal[k]:g}, expected a diagonal of at least 0.")
    transpose = value.T
    minus = CsrMatrix(value.shape, transpose.indptr, transpose.indices, -transpose.data)
    skew = value + minus
    if skew.nnz == 0:
        return 0.0, 0, 0
    rows, columns = skew.entry_rows, skew.indices
    largest = np.maximum(np.abs(value.entries_at(rows, columns)), np.abs(value.entries_at(columns, rows)))
    relative = np.abs(skew.data) / np.maximum(largest, np.sqrt(diagonal[rows]) * np.sqrt(diagonal[columns]))
    worst = int(np.argmax(relative))
    return float(relative[worst]), int(rows[worst]), int(columns[worst])


def symmetric_part(value: CsrMatrix) -> CsrMatrix:
    """Return (M + M^T) / 2, M itself where it is symmetric to the bit."""
    transpose = value.T
    if np.array_equal(value.indices, transpose.indices) and np.array_equal(value.data, transpose.data):
        return value
    total = value + transpose
    return CsrMatrix(total.shape, total.indptr, total.indices, 0.5 * total.data)
