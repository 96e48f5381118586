"""The kernels that gsenv has."""

from __future__ import annotations

import pkgutil
import sys
from importlib import import_module
from typing import Any

from numba.core.registry import CPUDispatcher


def all_kernels(*packages: Any) -> list[Any]:
    """Kernels that are defined in packages of gsenv, or imported there."""
    for package in packages:
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            import_module(module.name)
    modules = [module for name, module in sys.modules.items() if name.startswith("gsenv.")]
    found = [value for module in modules for value in vars(module).values() if isinstance(value, CPUDispatcher)]
    return list({id(kernel): kernel for kernel in found}.values())


def name_of(kernel: Any) -> str:
    """As in ``compiled_kernels()``."""
    return f"{kernel.__module__}.{kernel.__qualname__}"
