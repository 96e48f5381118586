"""The modules of 2D and 3D, for Python code that serves both; kernels use core/dispatch.py.

A dimension is imported when a scene first needs it: nothing of the other is loaded or compiled.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

PACKAGES = {2: "planar", 3: "spatial"}


@dataclass(frozen=True)
class Dimension:
    """The modules of one dimension; both have the same names."""

    dim: int
    initial_state: ModuleType
    kinds: ModuleType
    shapes: ModuleType
    vertices: ModuleType
    mass: ModuleType
    joint_readings: ModuleType

    def __reduce__(self) -> tuple[Any, ...]:
        return dimension, (self.dim,)  # modules cannot be pickled

    @property
    def scratch(self) -> Any:
        return import_module(f"{__package__}.{PACKAGES[self.dim]}.scratch")

    @property
    def sensor_readings(self) -> Any:
        return import_module(f"{__package__}.{PACKAGES[self.dim]}.sensor_readings")


@cache
def dimension(dim: int) -> Dimension:
    """Return the modules of 2 or 3 dimensions."""
    package = f"{__package__}.{PACKAGES[dim]}"
    names = ("initial_state", "kinds", "mass", "shapes", "vertices")
    modules = {name: import_module(f"{package}.{name}") for name in names}
    readings = import_module(f"{package}.joint_readings")
    return Dimension(dim, joint_readings=readings, **modules)
