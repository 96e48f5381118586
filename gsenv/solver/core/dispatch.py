"""Kernels of the same name in planar/ and spatial/: which one is called follows from the arguments' types.

``move_body = by_dimension("rotation", "move_body")`` is ``planar.rotation.move_body`` where it is called with
2D records and ``spatial.rotation.move_body`` with 3D ones.  The choice is made when the
caller is compiled and costs nothing at run time; the modules are imported when they are first needed.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from numba import types

from ..jit import njit
from ..records.bundle import Bundle, BundleType

_SOLVER = __package__.rpartition(".")[0]
_PACKAGES = {2: "planar", 3: "spatial"}
# fields whose length tells the dimension
_LENGTHS = {
    "velocity": {3: 2, 6: 3},
    "displacement": {3: 2, 6: 3},
    "jacobian_a": {3: 2, 6: 3},
    "m": {3: 2, 6: 3},
    "x": {3: 2, 6: 3},
    "motion": {3: 2, 6: 3},
    "point": {2: 2, 3: 3},
    "center": {2: 2, 3: 3},
    "anchor_a": {2: 2, 3: 3},
    "target_position": {2: 2, 3: 3},
    "local_position": {2: 2, 3: 3},
    "position": {2: 2, 3: 3},
    "gravity": {2: 2, 3: 3},
}


class DimensionKernel:
    """A pair of kernels, callable from Python and from kernels."""

    is_compiling = False  # numba looks for recursion

    def __init__(self, module: str, name: str, otherwise: Any = None) -> None:
        self._module = module
        self._otherwise = otherwise
        self.__name__ = name
        self._numba_type_ = types.Dispatcher(self)  # numba then asks this object as it asks its own

    def __repr__(self) -> str:
        return f"by_dimension({self._module!r}, {self.__name__!r})"

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel from Python, or without a compiler."""
        return self.kernel(_dimension_of_values(arguments))(*arguments)

    @cache  # noqa: B019, one for each name, for ever
    def kernel(self, dim: int) -> Any:
        """Return the kernel of planar/ (2) or spatial/ (3)."""
        try:
            module = import_module(f"{_SOLVER}.{_PACKAGES[dim]}.{self._module}")
        except ModuleNotFoundError:
            if self._otherwise is None:
                raise
            return self._otherwise
        if self._otherwise is None:
            return getattr(module, self.__name__)
        return getattr(module, self.__name__, self._otherwise)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        return self.kernel(dimension_of(arguments)).get_call_template(arguments, keywords)

    def get_overload(self, signature: Any) -> Any:
        return self.kernel(dimension_of(signature)).get_overload(signature)


def by_dimension(module: str, name: str, otherwise: Any = None) -> DimensionKernel:
    """Return kernel ``name`` of ``planar.module`` or ``spatial.module``; ``otherwise`` where a dimension has none."""
    return DimensionKernel(module, name, otherwise)


@njit
def nothing(world: Any, island: Any) -> None:
    """Do nothing: a stage that a dimension does not need."""


@njit
def never(world: Any, island: Any) -> Any:
    """Return False: a question that does not arise in a dimension."""
    return False


@njit
def no_nutation(world: Any, joint: Any, axes: Any) -> Any:
    """Return 0 rad/s: bodies in a plane do not nutate."""
    return 0.0


def dimension_of(arguments: Any) -> int:
    """Return 2 or 3 from numba types: of a bundle, a record of a body, row, joint or contact, or a NamedTuple.

    Raises TypeError where no argument tells the dimension.
    """
    for kind in arguments:
        if isinstance(kind, BundleType):
            return kind.dim
        if isinstance(kind, types.BaseNamedTuple):
            dim = _dimension_of_class(kind.instance_class)
            if dim:
                return dim
        record = kind.dtype if isinstance(kind, types.Array) else kind
        if isinstance(record, types.Record):
            for field, lengths in _LENGTHS.items():
                if field in record.fields:
                    shape = getattr(record.typeof(field), "shape", (0,))
                    if shape[0] in lengths:
                        return lengths[shape[0]]
    raise TypeError(f"no argument tells the dimension: {arguments}")


def _dimension_of_class(kind: type) -> int:
    """Return the dimension of a class in planar/ or spatial/, 0 for other classes."""
    for dim, package in _PACKAGES.items():
        if kind.__module__.startswith(f"{_SOLVER}.{package}."):
            return dim
    return 0


def _dimension_of_values(arguments: tuple[Any, ...]) -> int:
    for value in arguments:
        if isinstance(value, Bundle):
            return value._numba_type_.dim
        dim = _dimension_of_class(type(value))
        if dim:
            return dim
        dtype = getattr(value, "dtype", None)
        for field, lengths in _LENGTHS.items():
            if dtype is not None and field in (dtype.names or ()) and dtype[field].shape:
                return lengths[dtype[field].shape[0]]
    raise TypeError("no argument tells the dimension.")
