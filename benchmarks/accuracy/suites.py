"""The planar and the spatial benchmark: engines, cases and settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from . import cases, cases3d, settings, settings3d, settings_built, settings_rapier
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
        engines: by name, the library that each needs, "" where it is built from its sources; gsenv first. Its module in
            engines/ has the engine's name in small letters.
        settings: of each engine.
        judging: files that all points depend on.
        sources: folders of the engines that are built, by name.
    """

    dim: int
    cases: list[Case]
    engines: dict[str, str]
    settings: dict[str, Settings]
    judging: tuple[str, ...]
    sources: Mapping[str, Path] = field(default_factory=dict)

    @property
    def installed(self) -> list[str]:
        """Names of the engines whose libraries are installed or whose sources are given."""
        return [
            name for name, library in self.engines.items()
            if (find_spec(library) is not None if library else name in self.sources)
        ]  # fmt: skip

    def module(self, engine: str) -> ModuleType:
        """Return the engine's module, which is imported when it is first needed."""
        return import_module(f"{__package__}.engines.{engine.lower().replace(' ', '_')}")

    def build(self, engine: str) -> Build:
        module = self.module(engine)
        if engine in self.sources:
            return partial(module.Simulation, source=self.sources[engine])
        build: Build = module.Simulation3D if self.dim == 3 and engine == "gsenv" else module.Simulation
        return build

    def version(self, engine: str) -> str:
        """Return the version of an engine, which is built first where it is built from sources.

        Raises:
            Unable: this failed.
        """
        module = self.module(engine)
        return str(module.version(self.sources[engine]) if engine in self.sources else module.version())

    def files(self, engine: str) -> tuple[Path, ...]:
        """Return the files that make an engine fit the interface."""
        module = self.module(engine)
        return Path(str(module.__file__)), *getattr(module, "FILES", ())


def suite_of(dim: int, sources: Mapping[str, Path] | None = None) -> Suite:
    """Return the suite of 2 or 3 dimensions.

    Args:
        sources: folders of engines that are built from them, by name.
    """
    if dim == 2:
        return Suite(
            dim=2,
            cases=cases.all_cases(),
            engines={"gsenv": "gsenv", "Box2D": "Box2D", "Box2D v3": "", "pymunk": "pymunk"},
            settings={
                "gsenv": settings.gsenv_settings,
                "Box2D": settings.box2d_settings,
                "Box2D v3": settings_built.box2d_v3_settings,
                "pymunk": settings.pymunk_settings,
            },
            judging=JUDGING,
            sources=sources or {},
        )
    return Suite(
        dim=3,
        cases=cases3d.all_cases(),
        engines={"gsenv": "gsenv", "MuJoCo": "mujoco", "PyBullet": "pybullet", "Rapier": "rapier3d", "Box3D": ""},
        settings={
            "gsenv": settings3d.gsenv_settings,
            "MuJoCo": settings3d.mujoco_settings,
            "PyBullet": settings3d.pybullet_settings,
            "Rapier": settings_rapier.rapier_settings,
            "Box3D": settings_built.box3d_settings,
        },
        judging=(*JUDGING, "cases3d.py", "errors3d.py", "geometry3d.py"),
        sources=sources or {},
    )
