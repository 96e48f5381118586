"""Models in MuJoCo's format MJCF, read into scenes; docs/mjcf.md says what is honoured."""

from .errors import MjcfError, MjcfWarning
from .model import MjcfModel
from .parse import parse_mjcf

__all__ = ["MjcfError", "MjcfModel", "MjcfWarning", "parse_mjcf"]
