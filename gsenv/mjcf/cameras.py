"""Cameras of a model as views of a World."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..solver.records.model import Array
from .build import Names
from .frames import Pose
from .model import Camera, MjcfModel
from .state import body_motion

if TYPE_CHECKING:
    from ..solver.api.world import World


class CameraView(NamedTuple):
    """What a camera sees; ``SpatialCamera(*view, width=..., height=...)`` of gsenv.render.spatial renders it.

    eye, target, up: (3,) in the world, m; the target is 1 m ahead of the eye
    fov: rad, full vertical field of view
    """

    eye: Array
    target: Array
    up: Array
    fov: float


def camera_view(world: World, model: MjcfModel, names: Names, camera: str | int = 0, index: int = 0) -> CameraView:
    """Return the present view of a camera of the model.

    Args:
        names: from ``build_scene(model)``, whose scene the world has.
        camera: its name or index; it is fixed to its body, follows it, or looks at another, as its mode says.
        index: of the world.

    Raises:
        ValueError: there is no such camera.
    """
    known = [one.name or k for k, one in enumerate(model.cameras)]
    number = known.index(camera) if camera in known else camera
    if isinstance(number, str) or not 0 <= number < len(known):
        raise ValueError(f"camera_view: there is no camera {camera!r}, the file has {known}.")
    chosen = model.cameras[number]
    eye, axes = _place(chosen, model, _poses(world, names, index))
    return CameraView(eye, eye - axes[:, 2], axes[:, 1], chosen.fovy)


def _poses(world: World, names: Names, index: int) -> list[Pose]:
    """Return the poses of all bodies of the model in one world."""
    motions = (body_motion(world, names, k) for k in range(len(names.bodies)))
    return [Pose(motion.position[index], motion.orientation[index]) for motion in motions]


def _place(camera: Camera, model: MjcfModel, poses: list[Pose]) -> tuple[Array, Array]:
    """Return position and axes (3, 3) of a camera, which looks along -z."""
    own = poses[camera.body]
    if camera.mode in ("track", "trackcom"):
        start = [body.world_pose for body in model.bodies]
        place = start[camera.body].then(camera.pose)
        middle = _middle(camera.body, model, start) if camera.mode == "trackcom" else start[camera.body].position
        now = _middle(camera.body, model, poses) if camera.mode == "trackcom" else own.position
        return now + place.position - middle, place.axes
    place = own.then(camera.pose)
    if camera.mode == "fixed":
        return place.position, place.axes
    index = next(k for k, body in enumerate(model.bodies) if body.name == camera.target)
    target = poses[index].position if camera.mode == "targetbody" else _middle(index, model, poses)
    back = place.position - target
    back = back / np.linalg.norm(back)
    right = np.cross((0.0, 0.0, 1.0), back)
    right = right / np.linalg.norm(right)
    return place.position, np.stack([right, np.cross(back, right), back], axis=1)


def _middle(body: int, model: MjcfModel, poses: list[Pose]) -> Array:
    """Return the centre of mass of a body and all that hangs on it."""
    inside = {body}
    moment, mass = np.zeros(3), 0.0
    for k, one in enumerate(model.bodies):
        if k == body or (k > 0 and one.parent in inside):
            inside.add(k)
            moment = moment + one.inertia.mass * poses[k].point(one.inertia.center)
            mass += one.inertia.mass
    return moment / mass if mass > 0.0 else poses[body].position
