"""Checks of what users give to `Problem`: one clear sentence for bad input."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .csr import CsrMatrix, Index, Vector, asymmetry, dense_array, matrix, symmetric_part

ROUND_OFF = 1e-6  # asymmetry, relative to max(|M_ij|, sqrt(M_ii M_jj)), that is removed without a word
SLIGHT = 1e-3  # asymmetry up to which a matrix is symmetrised with a warning


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


def vector(value: ArrayLike, name: str, size: int, infinite: bool = False) -> Vector:
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


def at_least_zero(array: Vector, name: str) -> None:
    bad = np.flatnonzero(array < 0.0)
    if len(bad):
        raise ValueError(f"{name}[{bad[0]}] is {array[bad[0]]:g}, expected at least 0.")


def inverse_mass_matrix(value: Any, dof: int) -> CsrMatrix:
    if not (isinstance(value, CsrMatrix) or hasattr(value, "tocoo")):
        value = dense_array(value, "inverse_mass")
        if value.ndim < 2:
            diagonal = vector(value, "inverse_mass", dof)
            at_least_zero(diagonal, "inverse_mass")
            return CsrMatrix.from_diagonal(diagonal)
    inverse = matrix(value, "inverse_mass")
    if inverse.shape != (dof, dof):
        raise ValueError(f"inverse_mass has shape {inverse.shape}, expected ({dof}, {dof}).")
    inverse, symmetric = symmetrised(inverse, "inverse_mass", 4)
    if not symmetric:
        _, i, j = asymmetry(inverse, "inverse_mass")
        raise ValueError(f"inverse_mass[{i}, {j}] differs from inverse_mass[{j}, {i}], expected symmetry.")
    return inverse


def symmetrised(value: CsrMatrix, name: str, stacklevel: int = 3) -> tuple[CsrMatrix, bool]:
    """Return the symmetric part of a matrix and True; the matrix itself and False where its asymmetry exceeds SLIGHT.

    Warns of an asymmetry above ROUND_OFF. ValueError where the matrix isn't square or has a diagonal entry below 0.
    """
    relative, i, j = asymmetry(value, name)
    if relative > SLIGHT:
        return value, False
    if relative > ROUND_OFF:
        difference = f"{name}[{i}, {j}] differs from {name}[{j}, {i}] by {relative:.1e} of its size"
        warnings.warn(f"{difference}; ({name} + {name}^T) / 2 is used.", UserWarning, stacklevel)
    return symmetric_part(value), True


def bounds(
    value: ArrayLike,
    name: str,
    in_contact: NDArray[np.bool_],
    unbounded: float,
    normals: Index | tuple[()] = (),
) -> Vector:
    """Return the bounds of bounded rows; contact rows have none but the cone, and others are refused.

    A lower bound of 0 on `normals` agrees with the cone and is allowed.
    """
    array = vector(value, name, len(in_contact), infinite=True)
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


def contacts_of(contacts: ContactRows | None, count: int, prefix: str) -> tuple[Index, Index, Vector]:
    """Return first row, dim and friction of each contact, validated."""
    if contacts is None:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    friction_name = "friction" if prefix == "contact_" else prefix + "friction"
    friction = dense_array(contacts.friction, friction_name)
    dim = whole(contacts.dim, prefix + "dim")
    rows = None if contacts.rows is None else whole(contacts.rows, prefix + "rows")
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
    friction = vector(friction, friction_name, size)
    at_least_zero(friction, friction_name)
    dim = vector(dim, prefix + "dim", size).astype(np.int64)
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


def whole(value: ArrayLike, name: str) -> Index:
    array = dense_array(value, name)
    if not np.all(np.isfinite(array)) or np.any(array != np.floor(array)):
        raise ValueError(f"{name} must hold whole numbers.")
    return array.astype(np.int64)
