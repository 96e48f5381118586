"""A bundle: many named arrays that a kernel takes as one argument.

Each array argument costs numba time in its front end and in LLVM, in every function that passes it on: six
nested functions with forty arrays compile in 2.7 s, with one bundle in 0.4 s, and a call from Python takes
0.3 us instead of 2.2.  A bundle is one pointer to a table with the address and the shape of each array;
reading an attribute loads its array.  A stage should load each array once and pass it to its helpers: a load
inside an inner loop costs more than the loop.

An attribute is another bundle, an array, a record or None.  None has the type ``none``: where it is passed
on as an argument, ``if part is None`` is decided when the kernel is compiled.

``per_world`` arrays have a leading world axis, and kernels see the part of the world that ``select_world``
selected last.  A bundle belongs to one thread.  It keeps references to its arrays; an array that grows needs
a new bundle.  With NUMBA_DISABLE_JIT=1 plain Python sees the same attributes.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cache
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    overload,
    register_model,
    typeof_impl,
    unbox,
)
from numba.np import arrayobj
from numpy.typing import NDArray

from ..jit import UNCOUNTED
from .plain import as_records

Array = NDArray[Any]

# fields of a table entry, int64 each
ADDRESS, BASE, WORLD_STRIDE, SIZE = 0, 1, 2, 3
SHAPE = 4  # the first of two axes
WORDS = 6
_TABLE = types.Array(types.int64, 2, "C")


@dataclass(frozen=True)
class PerWorld:
    """An array (world, ...) of which kernels see the part of one world."""

    array: Array


def per_world(array: Array | None) -> PerWorld | None:
    """Mark an array as one with a world axis; None stays None."""
    return None if array is None else PerWorld(array)


class BundleType(types.Type):
    """numba's type of a bundle: names, types and table entries of its fields."""

    def __init__(self, name: str, dim: int, fields: tuple[tuple[str, int, Any], ...], entry_count: int) -> None:
        self.dim = dim
        self.entry_count = entry_count
        self.kinds = {field: kind for field, _, kind in fields}
        self.slots = {field: slot for field, slot, _ in fields}
        digest = hashlib.sha256(repr((name, dim, [(f, s, str(k)) for f, s, k in fields])).encode()).hexdigest()
        # the name is part of every signature and every cache key: short, and the same in every process
        super().__init__(name=f"{name}{dim}D.{digest[:12]}")

    @property
    def mangling_args(self) -> tuple[str, tuple[Any, ...]]:
        return self.name, ()


@cache
def _record_type(dtype: np.dtype[Any]) -> Any:
    return numba.from_dtype(dtype)  # 0.2 ms for a record


class Bundle:
    """Fields by name: an array, ``per_world(array)``, another Bundle, or None for a part that a scene lacks.

    Args:
        name: of the type, for error messages.
        dim: 2 or 3.
        fields: arrays must be C-contiguous with at most two axes that kernels see; a structured array
            without axes (or with the world axis alone) is a record.
    """

    def __init__(self, name: str, dim: int, **fields: Any) -> None:
        self._entries: list[tuple[Bundle, str, Array, bool]] = []
        described = []
        for field, value in fields.items():
            slot = len(self._entries)
            described.append((field, slot, self._add(field, value)))
        self._numba_type_ = BundleType(name, dim, tuple(described), len(self._entries))

    @property
    def numba_type(self) -> BundleType:
        """The type; bundles with equal types use the same compiled code."""
        return self._numba_type_

    def _add(self, field: str, value: Any) -> Any:
        """Set the attribute for plain Python, add the entries of the table, and return numba's type."""
        if value is None:
            setattr(self, field, None)
            return types.none
        if isinstance(value, Bundle):
            self._entries += value._entries
            setattr(self, field, value)
            return value._numba_type_
        moving = isinstance(value, PerWorld)
        array = value.array if isinstance(value, PerWorld) else value
        if not array.flags.c_contiguous:
            raise ValueError(f"bundle: {field} must be C-contiguous.")
        self._entries.append((self, field, array, moving))
        setattr(self, field, _seen(array, 0 if moving else None))
        seen = array.ndim - moving
        if seen == 0:
            return _record_type(array.dtype)
        return types.Array(_record_type(array.dtype), seen, "C", readonly=not array.flags.writeable)

    def seal(self) -> Bundle:
        """Make the table; to be called on the outermost bundle, which kernels get as their argument."""
        self.table = np.zeros((len(self._entries), WORDS), np.int64)
        for row, (_, _, array, moving) in zip(self.table, self._entries, strict=True):
            shape = array.shape[moving:]
            row[ADDRESS] = row[BASE] = array.ctypes.data
            row[WORLD_STRIDE] = array.strides[0] if moving else 0
            row[SIZE] = np.prod(shape, dtype=np.int64)
            row[SHAPE : SHAPE + len(shape)] = shape
        self.address = self.table.ctypes.data
        return self

    def select(self, world: int) -> None:
        """Select the world that per-world attributes show, in plain Python."""
        for owner, field, array, moving in self._entries:
            if moving:
                setattr(owner, field, _seen(array, world))


def _seen(array: Array, world: int | None) -> Any:
    """Return what plain Python sees: an array or a record."""
    records = as_records(array)
    if world is not None:
        return records[world]
    return records if array.ndim else records[()]


def select_world(bundle: Any, world: Any) -> None:
    """Select the world that per-world fields of the outermost bundle show from now on."""
    bundle.select(world)


@overload(select_world, jit_options=dict(UNCOUNTED))
def _select_world(bundle, world):  # type: ignore[no-untyped-def]
    def implementation(bundle, world):  # type: ignore[no-untyped-def]
        table = bundle.table
        for i in range(len(table)):
            table[i, ADDRESS] = table[i, BASE] + world * table[i, WORLD_STRIDE]

    return implementation


# ---------------------------------------------------------------- numba types and code generation


@typeof_impl.register(Bundle)
def _type_of(value: Bundle, context: Any) -> Any:
    return value._numba_type_


@register_model(BundleType)
class _BundleModel(models.OpaqueModel):
    pass


@infer_getattr
class _BundleAttribute(AttributeTemplate):
    key = BundleType

    def generic_resolve(self, bundle: BundleType, field: str) -> Any:
        if field == "table":
            return _TABLE
        return bundle.kinds.get(field)


@lower_getattr_generic(BundleType)
def _load_field(context: Any, builder: Any, bundle: Any, pointer: Any, field: str) -> Any:
    word = ir.IntType(64)
    if field == "table":
        shape = [ir.Constant(word, bundle.entry_count), ir.Constant(word, WORDS)]
        return _array(context, builder, _TABLE, builder.ptrtoint(pointer, word), shape)
    kind = bundle.kinds[field]
    if kind is types.none:
        return context.get_dummy_value()
    first = builder.gep(builder.bitcast(pointer, word.as_pointer()), [ir.Constant(word, WORDS * bundle.slots[field])])
    if isinstance(kind, BundleType):
        return builder.bitcast(first, context.get_value_type(kind))
    load = _loader(builder, first)
    if isinstance(kind, types.Record):
        return builder.inttoptr(load(ADDRESS), context.get_value_type(kind))
    shape = [load(SIZE)] if kind.ndim == 1 else [load(SHAPE + axis) for axis in range(kind.ndim)]
    return _array(context, builder, kind, load(ADDRESS), shape)


def _loader(builder: Any, first: Any) -> Any:
    word = ir.IntType(64)
    return lambda k: builder.load(builder.gep(first, [ir.Constant(word, k)]))


def _array(context: Any, builder: Any, kind: Any, address: Any, shape: list[Any]) -> Any:
    """Return a C-contiguous array without an owner."""
    word = ir.IntType(64)
    item = kind.dtype
    itemsize = item.size if isinstance(item, types.Record) else context.get_abi_sizeof(context.get_data_type(item))
    array = context.make_array(kind)(context, builder)
    strides: list[Any] = []
    stride: Any = ir.Constant(word, itemsize)
    for extent in reversed(shape):
        strides.insert(0, stride)
        if len(strides) < len(shape):
            stride = builder.mul(stride, extent)
    arrayobj.populate_array(
        array,
        data=builder.inttoptr(address, array.data.type),
        shape=shape,
        strides=strides,
        itemsize=ir.Constant(word, itemsize),
        meminfo=None,
    )
    return array._getvalue()


@unbox(BundleType)
def _unbox(bundle: Any, value: Any, c: Any) -> Any:
    address = c.pyapi.object_getattr_string(value, "address")
    pointer = c.pyapi.long_as_voidptr(address)
    c.pyapi.decref(address)
    return NativeValue(pointer)
