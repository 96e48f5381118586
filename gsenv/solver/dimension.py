"""What differs between the plane and space, for the modules that do not care which it is.

Each dimension is imported when a scene first needs it: nothing of the other is loaded or compiled.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

PACKAGES = {2: "planar", 3: "spatial"}


@dataclass(frozen=True)
class Dimension:
    """The modules of one dimension; both have the same names."""

    dim: int
    authored: ModuleType
    shapes: ModuleType
    mass: ModuleType
    joint_kinds: type[IntEnum]
    readings: ModuleType

    def __reduce__(self) -> tuple[Any, ...]:
        return dimension, (self.dim,)  # modules can't be pickled

    @property
    def step(self) -> Any:
        return import_module(f"{__package__}.{PACKAGES[self.dim]}.step")

    @property
    def sweep_fast(self) -> Any:
        return import_module(f"{__package__}.{PACKAGES[self.dim]}.sweep_fast")


@cache
def dimension(dim: int) -> Dimension:
    """The modules of 2 or 3 dimensions."""
    package = f"{__package__}.{PACKAGES[dim]}"
    names = ("authored", "shapes", "mass")
    modules = {name: import_module(f"{package}.{name}") for name in names}
    readings = import_module(f"{package}.joint_readings")
    kinds = import_module(f"{package}.joints").JointKind
    return Dimension(dim, joint_kinds=kinds, readings=readings, **modules)
