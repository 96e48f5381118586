"""Software rendering: a world becomes a draw list, a draw list becomes a uint8 image or a video."""

from typing import Any

from gsenv.render.camera import Camera, FollowCamera
from gsenv.render.scene_renderer import SceneRenderer
from gsenv.render.video import VideoWriter

__all__ = ["Camera", "FollowCamera", "SceneRenderer", "VideoWriter", "make_renderer"]


def make_renderer(world: Any, width: int = 640, height: int = 480, *, small: bool = False) -> Any:
    """The renderer of a World's dimension, with a `camera` and `render(world_index, hud)`.

    width, height: px
    small: for pixel observations; in 3D it spares what shows only in large pictures
    """
    if world.model.dim == 2:
        return SceneRenderer(world, width, height)
    from gsenv.render.spatial import SpatialRenderer

    return SpatialRenderer(world, width, height, quality="fast" if small else "high")
