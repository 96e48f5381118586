"""Models in MuJoCo's format MJCF, read into scenes; docs/mjcf.md says what is honoured."""

from .build import build_scene, load_mjcf
from .errors import MjcfError, MjcfWarning
from .kinematics import motions
from .model import MjcfModel
from .parse import parse_mjcf
from .state import coordinates, set_coordinates

__all__ = [
    "MjcfError",
    "MjcfModel",
    "MjcfWarning",
    "build_scene",
    "coordinates",
    "load_mjcf",
    "motions",
    "parse_mjcf",
    "set_coordinates",
]
