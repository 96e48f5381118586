"""Software rendering of worlds to uint8 images and videos: through a draw list in 2D, by ray casting in 3D."""

from typing import Any

from gsenv.render.camera import Camera, FollowCamera
from gsenv.render.scene_renderer import SceneRenderer
from gsenv.render.video import VideoWriter

__all__ = ["Camera", "FollowCamera", "SceneRenderer", "VideoWriter", "make_renderer"]


def make_renderer(world: Any, width: int = 640, height: int = 480, *, small: bool = False) -> Any:
    """Return a 2D or 3D renderer for the world; both have a `camera` and `render(world_index, hud)`.

    width, height: px
    small: in 3D, render at "fast" quality, for pixel observations
    """
    if world.model.dim == 2:
        return SceneRenderer(world, width, height)
    from gsenv.render.spatial import SpatialRenderer

    return SpatialRenderer(world, width, height, quality="fast" if small else "high")
