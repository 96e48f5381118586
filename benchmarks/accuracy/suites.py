"""The planar and the spatial benchmark: which engines, cases and settings, and where the figures go."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from . import ours
from .cases import Case, all_cases
from .engines import Setting
from .measure import Build
from .settings import box2d_settings, gsenv_settings, pymunk_settings

Settings = Callable[[Case, bool], Iterable[Setting]]


@dataclass(frozen=True)
class Suite:
    """What runs in one dimension.

    Attributes:
        dim: 2 or 3.
        name: of the files of figures.
        cases: all, in the order of the table.
        engines: module of each, by name; ours first.
        settings: of each, by name.
        judging: modules that all figures depend on.
    """

    dim: int
    name: str
    cases: list[Case]
    engines: dict[str, ModuleType]
    settings: dict[str, Settings]
    judging: tuple[str, ...]

    def build(self, engine: str) -> Build:
        module = self.engines[engine]
        return module.Simulation3D if self.dim == 3 and module is ours else module.Simulation


JUDGING = ("cases", "engines", "errors", "geometry", "measure", "trajectory")


def suite(dim: int) -> Suite:
    """The peers are imported only where they are wanted; PyBullet only where it is installed."""
    if dim == 2:
        modules = {"gsenv": ours, "Box2D": engine("box2d"), "pymunk": engine("pymunk")}
        settings: dict[str, Settings] = {
            "gsenv": gsenv_settings, "Box2D": box2d_settings, "pymunk": pymunk_settings,
        }  # fmt: skip
        return Suite(2, "accuracy", all_cases(), modules, settings, JUDGING)
    from . import cases3d, settings3d

    modules = {"gsenv": ours, "MuJoCo": engine("mujoco")}
    if find_spec("pybullet") is not None:
        modules["PyBullet"] = engine("pybullet")
    settings = {
        "gsenv": settings3d.gsenv_settings,
        "MuJoCo": settings3d.mujoco_settings,
        "PyBullet": settings3d.pybullet_settings,
    }
    spatial = (*JUDGING, "cases3d", "errors3d", "geometry3d")
    return Suite(3, "accuracy3d", cases3d.all_cases(), modules, settings, spatial)


def engine(name: str) -> ModuleType:
    return import_module(f"{__package__}.{name}")
