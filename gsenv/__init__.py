"""Gymnasium environments built on the package's own rigid-body constraint solver.

Importing gsenv registers the environments by name and loads neither numba nor torch. Afterwards
`gymnasium.make("GStack-v0")` works; `gymnasium.make("gsenv:GStack-v0")` imports gsenv itself.
`gsenv.load_mjcf` reads a MuJoCo XML file to a scene, `gsenv.load_urdf` a URDF file.
"""

import sys
from pathlib import PurePath
from typing import TYPE_CHECKING, Any


def _is_command() -> bool:
    """Whether this process is the `gsenv` command, or `python -m gsenv`."""
    return PurePath(sys.argv[0]).stem == "gsenv" or sys.orig_argv[-len(sys.argv) - 1 :][:2] == ["-m", "gsenv"]


try:
    from gsenv.envs import register_envs
except KeyboardInterrupt:  # Ctrl-C while gymnasium loads, before the command can catch it
    if not _is_command():
        raise
    print("gsenv: interrupted", file=sys.stderr)
    raise SystemExit(130) from None

if TYPE_CHECKING:
    from gsenv.mjcf import load_mjcf as load_mjcf
    from gsenv.mjcf import load_urdf as load_urdf

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Return ``load_mjcf`` or ``load_urdf``, which load numba and so are imported when they are first used."""
    if name in ("load_mjcf", "load_urdf"):
        import gsenv.mjcf

        return getattr(gsenv.mjcf, name)
    raise AttributeError(f"module 'gsenv' has no attribute {name!r}")


register_envs()
