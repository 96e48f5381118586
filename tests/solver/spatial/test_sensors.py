"""Sensors of frames, rays and contacts in space, against the World's other readings."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import (
    Ball,
    Box,
    ContactForceSensor,
    ContactSensor,
    FrameSensor,
    Heightfield,
    JointSensor,
    Plane,
    PoseSensor,
    RaySensor,
    Sphere,
    VelocitySensor,
)
from tests.solver.spatial.test_rays import rotation

ROOT = Path(__file__).parents[3]
TURN = (0.8, 0.1, -0.5, 0.3)


def hammer(gravity: tuple[float, float, float] = (0, 0, 0)) -> Scene:
    """A body whose centre of mass is beside its own frame, spinning past a wall and a ball."""
    scene = Scene(dim=3, gravity=gravity)
    head, handle = Sphere(radius=0.3, position=(1.0, 0.0, 0.2)), Box(half_extents=(0.6, 0.1, 0.2))
    scene.add_body("hammer", shapes=[handle, head], position=(1, 2, 3), orientation=TURN,
                   linear_velocity=(0.5, -1, 0.3), angular_velocity=(3.0, 1.0, -2.0))  # fmt: skip
    scene.add_body("ball", shapes=[Sphere(radius=0.5, category=2)], position=(5, 2, 3))
    scene.add_body("wall", "static", [Plane(normal=(-1, 0, 0), offset=-8)])
    return scene


@pytest.mark.nojit
def test_frame_is_the_site_and_its_velocities_along_the_bodys_axes() -> None:
    scene = hammer()
    site = np.array([0.4, -0.7, 0.2])
    scene.add_sensor("site", FrameSensor("hammer", position=site))
    scene.add_sensor("middle", FrameSensor("hammer"))
    scene.add_sensor("pose", PoseSensor("hammer"))
    world = World(scene, world_count=2)
    world.set_pose("hammer", position=[(1, 2, 3), (-3, 5, 0)], orientation=[TURN, (0, 1, 2, -1)])
    world.set_velocity("hammer", linear=[(0.5, -1, 0), (2, 2, 1)], angular=[(3, 0, 1), (-1, -4, 2)])
    for name, place in (("site", site), ("middle", np.zeros(3))):
        reading = world.sensor(name)
        for w in range(2):
            turn = rotation(world.orientation[w, 0])
            spin = world.angular_velocity[w, 0]
            where = world.position[w, 0] + turn.apply(place)
            speed = world.linear_velocity[w, 0] + np.cross(spin, where - world.center_of_mass[w, 0])
            expected = [*where, *world.orientation[w, 0], *turn.inv().apply(speed), *turn.inv().apply(spin)]
            np.testing.assert_allclose(reading[w], expected, atol=1e-13)
    np.testing.assert_allclose(world.sensor("pose"), world.sensor("middle")[:, :7], atol=1e-15)


def test_frame_velocities_are_the_rates_of_place_and_orientation() -> None:
    scene = hammer()
    scene.add_sensor("site", FrameSensor("hammer", position=(0.4, -0.7, 0.1)))
    world = World(scene, options=Options(timestep=1e-6))
    before = world.sensor("site")[0]
    world.step()
    after = world.sensor("site")[0]
    turn = rotation(before[3:7])
    rate = (after[:3] - before[:3]) / world.timestep
    np.testing.assert_allclose(before[7:10], turn.inv().apply(rate), atol=1e-4)
    spin = (turn.inv() * rotation(after[3:7])).as_rotvec() / world.timestep
    np.testing.assert_allclose(before[10:], spin, atol=1e-4)


@pytest.mark.nojit
def test_rays_turn_with_the_body_and_do_not_see_it() -> None:
    scene = hammer()
    ways = np.array([(1, 0, 0), (1, 0.3, -0.1), (-2, 0, 0), (0, 0, 0.5), (0.8, -0.1, 0.2)])
    scene.add_sensor("other", RaySensor("ball", directions=[(0, 1, 0)], length=1.0))
    scene.add_sensor("eye", RaySensor("hammer", position=(0.2, 0.1, 0.0), directions=ways, length=6.0))
    world = World(scene, world_count=3)
    turns = [(1, 0, 0, 0), (1, 0.1, 0.05, 0.1), (0, 1, 0, 0.2)]
    world.set_pose("hammer", position=[(1, 2, 3), (2, 2.2, 3.1), (-9, 0, 0)], orientation=turns)
    for w in range(3):
        turn = rotation(world.orientation[w, 0])
        origin = world.position[w, 0] + turn.apply((0.2, 0.1, 0.0))
        hits = world.cast_rays(origin, turn.apply(ways), 6.0, worlds=w, exclude="hammer")
        np.testing.assert_allclose(world.sensor("eye")[w], hits.distance[0], atol=1e-12)
    # the first world, by hand: the ball from (1.2, 2.1, 3) straight ahead
    assert world.sensor("eye")[0, 0] == pytest.approx(3.8 - np.sqrt(0.25 - 0.01), abs=1e-12)
    assert world.sensor("eye").min() < 6.0
    assert (world.sensor("eye")[2] == 6.0).all()


def test_rays_see_their_mask_only() -> None:
    scene = hammer()
    for name, mask in {"all": -1, "balls": 2, "walls": 1, "none": 4}.items():
        scene.add_sensor(name, RaySensor("hammer", directions=[(1, 0, 0)], length=20.0, mask=mask))
    world = World(scene)
    world.set_pose("hammer", position=(1, 2, 3), orientation=(1, 0, 0, 0))
    distances = [world.sensor(name).item() for name in ("all", "balls", "walls", "none")]
    np.testing.assert_allclose(distances, [3.5, 3.5, 7.0, 20.0], atol=1e-12)


def test_rays_of_a_foot_that_has_sunk_into_the_ground() -> None:
    for ground in (Plane(), Heightfield(heights=np.zeros((3, 3)), size=(9, 9))):
        scene = Scene(dim=3, gravity=(0, 0, 0))
        scene.add_body("ground", "static", [ground])
        scene.add_body("foot", shapes=[Box(half_extents=(0.5, 0.3, 0.2))], position=(0, 0, 0.1999))
        ways = [(0, 0, -1), (1, 0, 0)]
        scene.add_sensor("foot", RaySensor("foot", position=(0, 0, -0.2), directions=ways, length=2.0))
        scene.add_sensor("higher", RaySensor("foot", directions=ways, length=2.0))
        np.testing.assert_allclose(World(scene).sensors()[0], [0.0, 0.0, 0.1999, 2.0], atol=1e-12)


def test_directions_in_the_plane_are_those_of_angles() -> None:
    from gsenv.solver import planar

    scene = Scene()
    scene.add_body("disk", shapes=[planar.Circle(radius=0.1)])
    scene.add_body("wall", "static", [planar.HalfPlane(normal=(-1, 0.5), offset=-3)])
    angles = np.linspace(-1.0, 1.0, 5)
    ways = 3.0 * np.stack([np.cos(angles), np.sin(angles)], 1)
    scene.add_sensor("by angles", planar.RaySensor("disk", angles=angles, length=9.0))
    scene.add_sensor("by directions", planar.RaySensor("disk", directions=ways, length=9.0))
    world = World(scene)
    np.testing.assert_allclose(world.sensor("by directions"), world.sensor("by angles"), rtol=1e-12)
    with pytest.raises(ValueError, match=r"^sensor 'new': give directions or angles, not both\.$"):
        scene.add_sensor("new", planar.RaySensor("disk", angles=angles, directions=ways, length=9.0))


def test_all_sensors_in_the_order_of_the_scene() -> None:
    scene = hammer(gravity=(0, 0, -9.81))
    scene.add_joint("pin", Ball("wall", "hammer", anchor=(1, 2, 3)))
    scene.add_sensor("eye", RaySensor("hammer", directions=[(1, 0, 0), (0, 1, 0), (0, 0, 1)], length=9.0))
    scene.add_sensor("place", PoseSensor("hammer"))
    scene.add_sensor("joint", JointSensor("pin"))
    scene.add_sensor("touch", ContactSensor("ball"))
    scene.add_sensor("site", FrameSensor("hammer", position=(1, 0, 0)))
    scene.add_sensor("speed", VelocitySensor("ball"))
    scene.add_sensor("load", ContactForceSensor("ball"))
    world = World(scene, world_count=2)
    world.step(10)
    reading = world.sensors()
    slices = world.model.sensor_slices
    widths = [3, 7, 6, 4, 13, 6, 7]
    assert [part.stop - part.start for part in slices.values()] == widths
    assert reading.shape == (2, sum(widths))
    for name, part in slices.items():
        np.testing.assert_array_equal(reading[:, part], world.sensor(name), err_msg=name)


def test_unused_sensors_compile_nothing(tmp_path: Path) -> None:
    code = (
        "from gsenv.solver import Scene, World\n"
        "from gsenv.solver.jit import compiled_kernels\n"
        "from gsenv.solver.spatial import *\n"
        "scene = Scene(dim=3)\n"
        "scene.add_body('box', shapes=[Box(half_extents=(1, 1, 1))])\n"
        "for kind in (PoseSensor, VelocitySensor, ContactSensor, FrameSensor):\n"
        "    scene.add_sensor(kind.__name__, kind('box'))\n"
        "world = World(scene)\n"
        "world.sensors()\n"
        "print(*compiled_kernels())\n"
        "world.cast_rays((0, 0, 9), (0, 0, -1), 1.0)\n"
        "print(*compiled_kernels())\n"
    )
    # unoptimised code is compiled faster; an empty cache, or callees would not be listed
    env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_OPT": "0"}
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=env, capture_output=True, text=True, timeout=300
    )
    before, after = (line.split() for line in done.stdout.splitlines())
    assert any(name.endswith("sensor_readings.read_frame") for name in before)
    unneeded = ("rays.", ".narrowphase.", "read_acceleration", "read_contact_force", ".planar.")
    assert [name for name in before if any(word in name for word in unneeded)] == []
    assert any(name.endswith("rays.box_hit") for name in after)
    others = ("hull", "field_hit", "field_rays.walk", ".planar.")
    assert [name for name in after if any(word in name for word in others)] == []
