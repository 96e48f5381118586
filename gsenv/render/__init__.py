"""Software rendering: a world becomes a draw list, a draw list becomes a uint8 image or a video."""

from gsenv.render.camera import Camera, FollowCamera
from gsenv.render.scene_renderer import SceneRenderer
from gsenv.render.video import VideoWriter

__all__ = ["Camera", "FollowCamera", "SceneRenderer", "VideoWriter"]
