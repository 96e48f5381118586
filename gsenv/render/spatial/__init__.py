"""Software rendering in 3D: ray casting of primitives to a uint8 image."""

from gsenv.render.spatial.camera import SpatialCamera
from gsenv.render.spatial.primitives import Primitives, make_primitives
from gsenv.render.spatial.renderer import PrimitiveRenderer, render_primitives
from gsenv.render.spatial.scene_renderer import SpatialRenderer

__all__ = [
    "PrimitiveRenderer",
    "Primitives",
    "SpatialCamera",
    "SpatialRenderer",
    "make_primitives",
    "render_primitives",
]
