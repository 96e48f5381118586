"""The planar and the spatial benchmark: engines, cases and settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from . import cases, cases3d, settings, settings3d
from .cases import Case
from .engines import Setting
from .points import Build

Settings = Callable[[Case, bool], Iterable[Setting]]
JUDGING = ("cases.py", "engines/__init__.py", "errors.py", "geometry.py", "points.py", "trajectory.py")


@dataclass(frozen=True)
class Suite:
    """What runs in one dimension.

    Attributes:
        dim: 2 or 3.
        cases: all, in the order of the tables.
        engines: by name, the library that each needs; gsenv first. Its module in engines/ has the library's name in
            small letters.
        settings: of each engine.
        judging: files that all points depend on.
    """

    dim: int
    cases: list[Case]
    engines: dict[str, str]
    settings: dict[str, Settings]
    judging: tuple[str, ...]

    @property
    def installed(self) -> list[str]:
        """Names of the engines whose libraries are installed."""
        return [name for name, library in self.engines.items() if find_spec(library) is not None]

    def module(self, engine: str) -> ModuleType:
        """Return the engine's module, which is imported when it is first needed."""
        return import_module(f"{__package__}.engines.{engine.lower()}")

    def build(self, engine: str) -> Build:
        module = self.module(engine)
        build: Build = module.Simulation3D if self.dim == 3 and engine == "gsenv" else module.Simulation
        return build


def suite_of(dim: int) -> Suite:
    """Return the suite of 2 or 3 dimensions."""
    if dim == 2:
        return Suite(
            dim=2,
            cases=cases.all_cases(),
            engines={"gsenv": "gsenv", "Box2D": "Box2D", "pymunk": "pymunk"},
            settings={
                "gsenv": settings.gsenv_settings,
                "Box2D": settings.box2d_settings,
                "pymunk": settings.pymunk_settings,
            },
            judging=JUDGING,
        )
    return Suite(
        dim=3,
        cases=cases3d.all_cases(),
        engines={"gsenv": "gsenv", "MuJoCo": "mujoco", "PyBullet": "pybullet"},
        settings={
            "gsenv": settings3d.gsenv_settings,
            "MuJoCo": settings3d.mujoco_settings,
            "PyBullet": settings3d.pybullet_settings,
        },
        judging=(*JUDGING, "cases3d.py", "errors3d.py", "geometry3d.py"),
    )
