"""Models in MuJoCo's format MJCF, read into scenes; docs/mjcf.md says what is honoured."""

from .build import build_scene, load_mjcf
from .cameras import CameraView, camera_view
from .errors import MjcfError, MjcfWarning
from .kinematics import motions
from .model import MjcfModel
from .parse import parse_mjcf
from .sensor_data import sensor_data
from .state import coordinates, set_coordinates, set_keyframe
from .urdf import load_urdf, parse_urdf

__all__ = [
    "CameraView",
    "MjcfError",
    "MjcfModel",
    "MjcfWarning",
    "build_scene",
    "camera_view",
    "coordinates",
    "load_mjcf",
    "load_urdf",
    "motions",
    "parse_mjcf",
    "parse_urdf",
    "sensor_data",
    "set_coordinates",
    "set_keyframe",
]
