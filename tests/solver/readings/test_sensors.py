"""Sensors: each kind against the World's other readings and closed forms, side by side, refused."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import (
    Box,
    Capsule,
    Circle,
    ContactSensor,
    FrameSensor,
    HalfPlane,
    JointSensor,
    Polygon,
    PoseSensor,
    RaySensor,
    Revolute,
    Terrain,
    VelocitySensor,
    Weld,
)
from gsenv.solver.records.model import Array
from gsenv.solver.specification.sensors import Sensor

ROOT = Path(__file__).parents[3]
NAN = float("nan")


def hammer(gravity: tuple[float, float] = (0, 0)) -> Scene:
    """A body whose centre of mass is beside its own frame, spinning past a wall and a ball."""
    scene = Scene(gravity=gravity)
    head = Circle(radius=0.3, position=(1.0, 0.0))
    handle = Box(half_extents=(0.6, 0.1))
    scene.add_body("hammer", shapes=[handle, head], position=(1, 2), angle=0.6, linear_velocity=(0.5, -1),
                   angular_velocity=3.0)  # fmt: skip
    scene.add_body("ball", shapes=[Circle(radius=0.5, category=2)], position=(5, 2))
    scene.add_body("wall", "static", [HalfPlane(normal=(-1, 0), offset=-8)])
    return scene


# ---------------------------------------------------------------- each kind


@pytest.mark.nojit
def test_pose_and_velocity_are_those_of_the_world() -> None:
    scene = hammer()
    for name in ("hammer", "ball", "wall"):
        scene.add_sensor(f"pose of {name}", PoseSensor(name))
        scene.add_sensor(f"velocity of {name}", VelocitySensor(name))
    world = World(scene, world_count=3)
    world.set_pose("hammer", position=[(0, 0), (1, 1), (2, 2)], angle=[0.0, 8.0, -1.0])
    world.step(2)
    for b, name in enumerate(("hammer", "ball", "wall")):
        pose = np.concatenate([world.position[:, b], world.angle[:, b, None]], 1)
        np.testing.assert_allclose(world.sensor(f"pose of {name}"), pose, atol=1e-15)
        velocity = np.concatenate([world.linear_velocity[:, b], world.angular_velocity[:, b, None]], 1)
        np.testing.assert_array_equal(world.sensor(f"velocity of {name}"), velocity)


def touch(world: World, body: int) -> Array:
    """(world, 3) from the contacts of one world after the other."""
    out = np.zeros((world.world_count, 3))
    for w in range(world.world_count):
        contacts = world.contacts(w)
        sign = (contacts.body_b == body) * 1.0 - (contacts.body_a == body) * 1.0
        force = contacts.force_vector(world.timestep) * sign[:, None]
        out[w, 0] = ((sign != 0.0) & contacts.touching).any()
        out[w, 1:] = force.sum(0)
    return out


@pytest.mark.parametrize("timestep", [1 / 60, 1 / 240])
def test_contact_is_the_sum_of_the_contacts(timestep: float) -> None:
    scene = Scene()
    scene.add_body("ground", "static", [Terrain(vertices=[(-9, 1), (0, 0), (9, 1)])])
    for k in range(6):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.3, 0.3))], position=(0.3 * k - 0.8, 1.0 + 0.4 * k))
    for name in scene.bodies:
        scene.add_sensor(name, ContactSensor(name))
    world = World(scene, world_count=4, options=Options(timestep=timestep))
    world.set_pose("box_0", position=np.random.default_rng(1).uniform((-2, 1), (2, 5), (4, 2)))
    touched = np.zeros(2)
    for _ in range(40):
        world.step()
        for b, name in enumerate(world.model.body_names):
            reading = world.sensor(name)
            np.testing.assert_allclose(reading, touch(world, b), rtol=1e-12, atol=1e-9)
            touched += (reading[:, 0] == 1.0).sum(), (reading[:, 0] == 0.0).sum()
    assert (touched > 100).all()


def test_no_contact_before_a_step_and_after_a_reset() -> None:
    scene = stack(1)
    scene.add_sensor("feet", ContactSensor("box_0"))
    world = World(scene, world_count=2)
    assert not world.sensor("feet").any()
    world.step(30)
    mass = world.parameters.mass[0, 1]
    np.testing.assert_allclose(world.sensor("feet"), [(1, 0, 9.81 * mass)] * 2, rtol=1e-3, atol=1e-3)
    saved = world.save()
    world.reset(worlds=1)
    np.testing.assert_array_equal(world.sensor("feet")[:, 0], [1, 0])
    world.restore(saved)
    np.testing.assert_array_equal(world.sensor("feet")[:, 0], [1, 1])


@pytest.mark.nojit
def test_frame_is_the_site_and_its_velocity_along_the_bodys_axes() -> None:
    scene = hammer()
    site = np.array([0.4, -0.7])
    scene.add_sensor("site", FrameSensor("hammer", position=site))
    scene.add_sensor("middle", FrameSensor("hammer"))
    world = World(scene, world_count=2)
    world.set_pose("hammer", position=[(1, 2), (-3, 5)], angle=[0.6, -2.0])
    world.set_velocity("hammer", linear=[(0.5, -1), (2, 2)], angular=[3.0, -4.0])
    for name, place in (("site", site), ("middle", np.zeros(2))):
        reading = world.sensor(name)
        for w in range(2):
            angle = world.angle[w, 0]
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            spin = world.angular_velocity[w, 0]
            where = world.position[w, 0] + turn @ place
            arm = where - world.center_of_mass[w, 0]
            speed = world.linear_velocity[w, 0] + spin * np.array([-arm[1], arm[0]])
            expected = [*where, np.cos(angle), np.sin(angle), *(turn.T @ speed), spin]
            np.testing.assert_allclose(reading[w], expected, atol=1e-14)


def test_frame_velocity_is_the_rate_of_its_place() -> None:
    scene = hammer()
    scene.add_sensor("site", FrameSensor("hammer", position=(0.4, -0.7)))
    world = World(scene, options=Options(timestep=1e-6))
    before = world.sensor("site")[0]
    world.step()
    after = world.sensor("site")[0]
    rate = (after[:2] - before[:2]) / world.timestep
    c, s = before[2:4]
    np.testing.assert_allclose(before[4:6], [c * rate[0] + s * rate[1], c * rate[1] - s * rate[0]], atol=1e-4)
    np.testing.assert_allclose((after[2:4] - before[2:4]) / world.timestep, 3.0 * np.array([-s, c]), atol=1e-4)


@pytest.mark.nojit
def test_rays_turn_with_the_body_and_do_not_see_it() -> None:
    scene = hammer()
    angles = [-0.5, 0.0, 0.3, 3.0]
    scene.add_sensor("other", RaySensor("ball", angles=[0.1, 0.2], length=1.0))
    scene.add_sensor("eye", RaySensor("hammer", position=(0.2, 0.1), angles=angles, length=6.0))
    world = World(scene, world_count=3)
    world.set_pose("hammer", position=[(1, 2), (2, 2.2), (-9, 0)], angle=[0.0, 0.3, 1.0])
    for w in range(3):
        angle = world.angle[w, 0]
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        origin = world.position[w, 0] + turn @ (0.2, 0.1)
        ways = [(np.cos(angle + a), np.sin(angle + a)) for a in angles]
        hits = world.cast_rays(origin, ways, 6.0, worlds=w, exclude="hammer")
        np.testing.assert_allclose(world.sensor("eye")[w], hits.distance[0], atol=1e-12)
    # the first world, by hand: the ball from (1.2, 2.1) straight ahead
    assert world.sensor("eye")[0, 1] == pytest.approx(3.8 - np.sqrt(0.25 - 0.01), abs=1e-12)
    assert (world.sensor("eye")[2] == 6.0).all()


def test_rays_see_their_mask_only() -> None:
    scene = hammer()
    for name, mask in {"all": -1, "balls": 2, "walls": 1, "none": 4}.items():
        scene.add_sensor(name, RaySensor("hammer", angles=[0.0], length=20.0, mask=mask))
    world = World(scene)
    world.set_pose("hammer", position=(1, 2), angle=0.0)
    distances = [world.sensor(name).item() for name in ("all", "balls", "walls", "none")]
    np.testing.assert_allclose(distances, [3.5, 3.5, 7.0, 20.0], atol=1e-12)


def test_rays_of_a_foot_that_has_sunk_into_the_ground() -> None:
    """0 in the ground, be it a plane or a terrain; each ray sensor has its own carrier's depth."""
    for ground in (HalfPlane(), Terrain(vertices=[(-9, 0), (0, 0), (9, 0)])):
        scene = Scene(gravity=(0, 0))
        scene.add_body("ground", "static", [ground])
        scene.add_body("foot", shapes=[Box(half_extents=(0.5, 0.2))], position=(0, 0.1999))
        scene.add_body("hand", shapes=[Capsule(half_length=0.5, radius=0.2)], position=(3, 1.0))
        scene.add_sensor("foot", RaySensor("foot", position=(0, -0.2), angles=[-np.pi / 2, 0], length=2.0))
        scene.add_sensor("hand", RaySensor("hand", position=(0, -0.2), angles=[-np.pi / 2, 0], length=2.0))
        reading = World(scene).sensors()[0]
        np.testing.assert_allclose(reading, [0.0, 0.0, 0.8, 2.0], atol=1e-12)


def test_joint_is_what_the_world_says_of_it() -> None:
    scene = hammer()
    scene.add_joint("hinge", Revolute("wall", "hammer", anchor=(1, 2)))
    scene.add_sensor("pose", PoseSensor("ball"))
    scene.add_sensor("hinge", JointSensor("hinge"))
    world: Any = World(scene, world_count=2)
    world.step(5)
    reading = world.sensors()
    np.testing.assert_array_equal(reading[:, 3], world.joint_coordinate("hinge"))
    np.testing.assert_array_equal(reading[:, 4], world.joint_rate("hinge"))
    np.testing.assert_array_equal(reading[:, 5:], world.joint_reaction("hinge"))
    assert np.abs(reading[:, 3:5]).min() > 0.01
    np.testing.assert_array_equal(world.sensor("hinge"), reading[:, 3:])


# ---------------------------------------------------------------- side by side


def all_kinds() -> Scene:
    scene = hammer(gravity=(0, -9.81))
    scene.add_body("wedge", "static", [Polygon(vertices=[(-3, -1), (6, -1), (6, 0)])])
    scene.add_sensor("eye", RaySensor("hammer", angles=[-2.0, -1.5, -1.0], length=3.0))
    scene.add_sensor("place", PoseSensor("hammer"))
    scene.add_sensor("touch", ContactSensor("ball"))
    scene.add_sensor("back", RaySensor("ball", angles=np.linspace(2, 4, 5), length=9.0, position=(0.1, 0)))
    scene.add_sensor("site", FrameSensor("hammer", position=(1, 0)))
    scene.add_sensor("speed", VelocitySensor("ball"))
    return scene


def test_all_sensors_in_the_order_of_the_scene() -> None:
    world = World(all_kinds(), world_count=3)
    world.set_velocity("ball", linear=[(0, 0), (1, 0), (0, 3)])
    world.step(40)
    reading = world.sensors()
    widths = {"eye": 3, "place": 3, "touch": 3, "back": 5, "site": 7, "speed": 3}
    slices = world.model.sensor_slices
    assert reading.shape == (3, sum(widths.values()))
    assert {name: part.stop - part.start for name, part in slices.items()} == widths
    assert [part.start for part in slices.values()] == [0, 3, 6, 9, 14, 21]
    for name, part in slices.items():
        np.testing.assert_array_equal(reading[:, part], world.sensor(name), err_msg=name)
        assert reading[:, part].any(), name
    assert (reading[0] != reading[1]).any()


def test_a_scene_without_sensors_has_none() -> None:
    world = World(hammer(), world_count=2)
    assert world.sensors().shape == (2, 0)
    assert world.model.sensor_slices == {}


def test_a_reading_is_of_the_state_alone() -> None:
    """Bit for bit after a restore, in any batch; reading changes nothing."""
    world = World(all_kinds(), world_count=3)
    world.set_velocity("ball", linear=[(0, 0), (1, 0), (0, 3)])
    world.step(30)
    saved = world.save()
    before = [array.tobytes() for array in (world.state.bodies, world.state.worlds, world.state.contacts)]
    reading = world.sensors()
    assert [array.tobytes() for array in (world.state.bodies, world.state.worlds, world.state.contacts)] == before
    alone = World(world.model)
    for w in range(3):
        alone.restore(world.save(w))
        assert alone.sensors()[0].tobytes() == reading[w].tobytes()
    world.step(10)
    assert world.sensors().tobytes() != reading.tobytes()
    world.restore(saved)
    assert world.sensors().tobytes() == reading.tobytes()
    reading += 1.0
    assert not np.array_equal(world.sensors(), reading)


# ---------------------------------------------------------------- refused


def ray(**change: Any) -> Sensor:
    given: dict[str, Any] = {"angles": [0.0, 1.0], "length": 2.0}
    return RaySensor("ball", **(given | change))


REFUSED: dict[str, tuple[Any, str]] = {
    "not a sensor": ("pose", "'pose' is not a sensor"),
    "a class": (PoseSensor, "is not a sensor"),
    "no body": (PoseSensor(None), "body None is unknown"),  # type: ignore[arg-type]
    "body unknown": (PoseSensor("bell"), "did you mean 'ball'"),
    "joint unknown": (JointSensor("knee"), "'knee' is unknown"),
    "a joint's body": (JointSensor("ball"), "'ball' is unknown"),
    "site NaN": (ray(position=(0, NAN)), "position must be finite"),
    "site 3D": (FrameSensor("ball", position=(0, 0, 0)), "position must be 2 numbers"),
    "no angles": (ray(angles=None), "angles must be"),
    "no ray": (ray(angles=[]), "angles must be a list of numbers"),
    "angle alone": (ray(angles=1.0), "angles must be a list of numbers"),
    "angles in a table": (ray(angles=[[0.0]]), "angles must be a list of numbers"),
    "angles NaN": (ray(angles=[0.0, NAN]), "angles must be finite"),
    "angles text": (ray(angles="ahead"), "angles must be numbers"),
    "no length": (ray(length=None), "length must be a number"),
    "length zero": (ray(length=0.0), "length must be positive"),
    "length inf": (ray(length=float("inf")), "length must be finite"),
    "mask a list": (ray(mask=[1, 2]), "mask must be an integer"),
    "mask too large": (ray(mask=2**64), "mask must be an integer"),
}


@pytest.mark.parametrize("argument", ["position", "angles", "length", "mask"])
def test_a_sensor_has_the_arguments_of_its_kind_alone(argument: str) -> None:
    made: Any = PoseSensor
    with pytest.raises(TypeError, match=argument):
        made("ball", **{argument: 1.0})


def test_a_sensor_needs_a_name_of_its_own() -> None:
    with pytest.raises(ValueError, match=r"^sensor 'eye' exists already\.$"):
        all_kinds().add_sensor("eye", PoseSensor("ball"))


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_sentence_and_unchanged(case: str) -> None:
    sensor, words = REFUSED[case]
    scene = all_kinds()
    scene.add_joint("glue", Weld("hammer", "ball"))
    before = pickle.dumps(scene)
    with pytest.raises(ValueError, match=r"^sensor 'new'[^\n]+\.$") as error:
        scene.add_sensor("new", sensor)
    assert words in str(error.value)
    assert pickle.dumps(scene) == before


def test_angles_are_copied() -> None:
    scene = hammer()
    angles = np.zeros(1)
    scene.add_sensor("eye", RaySensor("hammer", angles=angles, length=9.0))
    angles[:] = np.pi
    np.testing.assert_array_equal(World(scene).model.sensor_rays, [(1.0, 0.0)])


# ---------------------------------------------------------------- compiled code


def test_no_ray_kernel_is_compiled_where_none_is_used(tmp_path: Path) -> None:
    code = (
        "from gsenv.scenes import stack\n"
        "from gsenv.solver import World\n"
        "from gsenv.solver.jit import compiled_kernels\n"
        "from gsenv.solver.planar import ContactSensor, FrameSensor, PoseSensor, VelocitySensor\n"
        "scene = stack(1)\n"
        "for kind in (PoseSensor, VelocitySensor, ContactSensor, FrameSensor):\n"
        "    scene.add_sensor(kind.__name__, kind('box_0'))\n"
        "world = World(scene)\n"
        "world.sensors()\n"
        "print(*compiled_kernels())\n"
        "world.cast_rays((0, 9), (0, -1), 1.0)\n"
        "print(*compiled_kernels())\n"
    )
    # unoptimised code is compiled faster; an empty cache, or callees would not be listed
    env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_OPT": "0"}
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=env, capture_output=True, text=True, timeout=300
    )
    before, after = (line.split() for line in done.stdout.splitlines())
    assert any(name.endswith("sensor_readings.read_frame") for name in before)
    assert [name for name in before if "rays." in name or ".narrowphase." in name] == []
    assert any(name.endswith("rays.box_hit") for name in after)
    assert [name for name in after if "polygon" in name or "terrain" in name] == []
