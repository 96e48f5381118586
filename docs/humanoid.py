"""Gymnasium's humanoid as a film: it drops, lies, is pushed; and it stands on position drives while it is pushed.

    python docs/humanoid.py humanoid.mp4

The file humanoid.xml comes from the installed Gymnasium (``pip install gymnasium``, its MuJoCo is not needed).

On two round feet no pose is stable, so the standing robot gets flat ones in their place. Its motors are replaced by
position drives, whose springs and dampers are implicit: they hold any pose at this timestep.
"""

from __future__ import annotations

import argparse
import dataclasses
import warnings
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np
from numpy.typing import NDArray

from gsenv.mjcf import MjcfModel, build_scene, parse_mjcf, set_coordinates
from gsenv.mjcf.frames import Pose
from gsenv.render.spatial import SpatialCamera, SpatialRenderer
from gsenv.render.video import VideoWriter
from gsenv.solver import Options, World

Array = NDArray[np.float64]

FILE = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "humanoid.xml"
TIMESTEP = 0.005  # s
FPS = 40
SIZE = (1280, 720)
SKIN, SHIRT = (0.90, 0.70, 0.56, 1), (0.16, 0.47, 0.58, 1)
TROUSERS, SHOES = (0.20, 0.24, 0.36, 1), (0.86, 0.36, 0.22, 1)
COLORS = {
    "torso": SHIRT, "lwaist": SHIRT, "pelvis": TROUSERS, "thigh": TROUSERS, "shin": TROUSERS, "foot": SHOES,
    "upper_arm": SHIRT, "lower_arm": SKIN,
}  # fmt: skip
# stiffness in N m/rad and damping in N m s/rad of the drives
GAINS = {
    "abdomen": (300.0, 20.0),
    "hip": (1500.0, 60.0),
    "knee": (2000.0, 60.0),
    "": (60.0, 5.0),
}
POSE = {"right_knee": -0.04, "left_knee": -0.04, "right_hip_y": -0.04, "left_hip_y": -0.04, "right_shoulder1": 0.5,
        "right_shoulder2": -0.9, "right_elbow": -0.5, "left_shoulder1": -0.5, "left_shoulder2": 0.9,
        "left_elbow": -0.5}  # fmt: skip
SOLE = (0.12, 0.05, 0.03)  # m, half extents of a flat foot
STANDING = 1.293  # m, height of the torso


def humanoid(driven: bool) -> MjcfModel:
    """Return the model of the file in colours, with a position drive for each motor where ``driven``."""
    model = parse_mjcf(FILE)
    for k, geom in enumerate(model.geoms):
        name = model.bodies[geom.body].name
        color = next((color for word, color in COLORS.items() if word in name), geom.rgba)
        color = SKIN if geom.name == "head" else color
        floor = (0.80, 0.82, 0.85, 1.0)
        model.geoms[k] = dataclasses.replace(geom, rgba=np.array(floor if geom.kind == "plane" else color, float))
    if driven:  # the drives take the place of the springs and dampers of the joints
        model.joints = [dataclasses.replace(joint, stiffness=0.0, damping=0.0) for joint in model.joints]
        for k, geom in enumerate(model.geoms):
            if geom.name.endswith("foot"):
                place = Pose(np.array([0.015, 0.0, 0.1 - 0.075 + SOLE[2]]), geom.pose.orientation)
                model.geoms[k] = dataclasses.replace(geom, kind="box", size=np.array(SOLE), pose=place)
        for k, actuator in enumerate(model.actuators):
            stiffness, damping = next(gain for word, gain in GAINS.items() if word in actuator.target)
            model.actuators[k] = dataclasses.replace(
                actuator,
                kind="position",
                gear=np.array([1.0, 0, 0, 0, 0, 0]),
                gain=stiffness,
                bias=np.array([0.0, -stiffness, -damping]),
                control_range=None,
            )
    return model


class Take:
    """One simulation that is filmed."""

    def __init__(self, driven: bool) -> None:
        self.model = humanoid(driven)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene, self.names = build_scene(self.model)
        self.world = World(scene, options=Options(timestep=TIMESTEP, sleep=False))
        self.paint()
        self.start = np.array([0.0, 0.0, 1.4, 1.0, 0.0, 0.0, 0.0, *[0.0] * 17])

    def paint(self) -> None:
        """Give each shape its own colour; a scene has one for each body."""
        model = self.world.model
        assert model.shape_colors is not None
        for geom in self.model.geoms:
            if geom.name in model.shape_names:
                model.shape_colors[model.shape_names.index(geom.name)] = (255.0 * geom.rgba[:3]).round()

    def coordinate(self, joint: str) -> int:
        """Return the index in qpos of a joint."""
        return next(one.coordinate for one in self.model.joints if one.name == joint)

    def body(self, name: str) -> int:
        return self.world.model.body_names.index(name)

    def push(self, body: str, force: tuple[float, float, float]) -> None:
        self.world.apply_force(body, force=force)


def film(out: VideoWriter, take: Take, camera: SpatialCamera, seconds: float, act: Callable[[float], str]) -> None:
    """Film a take; ``act`` gets the time before each step and returns the caption."""
    renderer = SpatialRenderer(take.world, *SIZE, camera=camera)
    every = round(1.0 / (FPS * TIMESTEP))
    seen = np.asarray(camera.target, float)
    lag = np.array([1.5, 1.5, 0.7]) / FPS  # the camera follows within a second
    for step in range(round(seconds / TIMESTEP)):
        caption = act(step * TIMESTEP)
        take.world.step()
        if step % every == 0:
            pelvis = take.world.center_of_mass[0, take.body("pelvis")]
            seen = seen + lag * (np.clip(pelvis, (-np.inf, -np.inf, 0.4), (np.inf, np.inf, 0.76)) - seen)
            renderer.camera = camera.following(seen)
            out.write(renderer.render(0, [caption] if caption else []))


def fall(out: VideoWriter) -> None:
    """Drop the humanoid without drives; push it twice when it lies."""
    take = Take(False)
    start = take.start.copy()
    start[2] = 1.75
    start[3:7] = np.array([0.985, 0.10, 0.14, 0.0]) / np.linalg.norm([0.985, 0.10, 0.14, 0.0])
    set_coordinates(take.world, take.model, take.names, start)

    def act(time: float) -> str:
        if 3.0 <= time < 3.25:
            take.push("torso", (0.0, 420.0, 250.0))
            return "pushed: 420 N sideways, 250 N up"
        if 5.0 <= time < 5.25:
            take.push("pelvis", (-500.0, 0.0, 330.0))
            return "pushed: 500 N along, 330 N up"
        return "Gymnasium's humanoid.xml, no drives"

    camera = SpatialCamera((2.9, -2.7, 1.75), (0.1, 0.0, 0.95), fov=np.radians(36.0), width=SIZE[0], height=SIZE[1])
    film(out, take, camera, 7.0, act)


def stand(out: VideoWriter) -> None:
    """Stand on position drives under pushes from three sides."""
    take = Take(True)
    start = take.start.copy()
    for name, angle in POSE.items():
        start[take.coordinate(name)] = angle
        take.world.control[0, take.world.model.actuator_names.index(name)] = angle
    start[2] = STANDING
    set_coordinates(take.world, take.model, take.names, start)
    pushes = {1.5: ((60.0, 0.0, 0.0), "from behind"), 3.5: ((-55.0, 0.0, 0.0), "from the front"),
              5.5: ((0.0, 80.0, 0.0), "from its right")}  # fmt: skip

    def act(time: float) -> str:
        for begin, (force, side) in pushes.items():
            if begin <= time < begin + 0.2:
                take.push("torso", force)
                return f"pushed {side}: {max(map(abs, force)):g} N for 0.2 s"
        return "standing on position drives"

    camera = SpatialCamera((2.7, -2.1, 1.35), (0.0, 0.0, 0.76), fov=np.radians(36.0), width=SIZE[0], height=SIZE[1])
    film(out, take, camera, 8.0, act)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("out", type=Path, help="video file, .mp4")
    with VideoWriter(parser.parse_args().out, FPS) as out:
        fall(out)
        stand(out)


if __name__ == "__main__":
    main()
