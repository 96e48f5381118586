"""Command line options of the engines that are built from a folder of their sources."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from benchmarks.common.run import UsageError


@dataclass(frozen=True)
class Built:
    """Such an engine.

    Attributes:
        name: of the engine, as in a suite.
        dim: that it has.
        option: for the folder, without dashes.
    """

    name: str
    dim: int
    option: str

    @property
    def flag(self) -> str:
        return f"--{self.option}"


BUILT = {engine.name: engine for engine in (Built("Box2D v3", 2, "box2d-source"), Built("Box3D", 3, "box3d-source"))}


def add_source_options(parser: argparse.ArgumentParser) -> None:
    for engine in BUILT.values():
        parser.add_argument(
            engine.flag, type=Path, metavar="FOLDER",
            help=f"sources of {engine.name} (--dim {engine.dim}), which are built by cmake",
        )  # fmt: skip


def given_sources(options: argparse.Namespace, dim: int) -> dict[str, Path]:
    """Return the folders that were given, by the engine's name.

    Raises:
        UsageError: one is of an engine of the other dimension.
    """
    out = {}
    for engine in BUILT.values():
        folder: Path | None = getattr(options, engine.option.replace("-", "_"))
        if folder is None:
            continue
        if engine.dim != dim:
            raise UsageError(f"{engine.flag}: {engine.name} is measured with --dim {engine.dim}.")
        out[engine.name] = folder
    return out
