"""What is refused in space: one sentence that names what and where, and nothing is changed."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from typing import Any

import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box as FlatBox
from gsenv.solver.planar import Circle, FrameSensor, Gear, RaySensor, Revolute
from gsenv.solver.spatial import Ball, Box, Capsule, Cylinder, Heightfield, Hull, Plane, Sphere, Target
from gsenv.solver.specification.sensors import Sensor
from tests.solver.bits import everything
from tests.solver.joints import make_joint
from tests.solver.small_scenes import handle

NAN, INF = math.nan, math.inf
BALL = Sphere(radius=0.5)
ROW = [1.0] + [0.0] * 5
Make = Callable[[Scene], Any]


def two_balls() -> Scene:
    scene = Scene(dim=3)
    for k in range(2):
        scene.add_body(f"ball_{k}", shapes=[BALL], position=(2.0 * k, 0, 0))
    scene.add_joint("pin", Ball("ball_0", "ball_1"))
    return scene


def flat_scene() -> Scene:
    scene = Scene()
    for k in range(2):
        scene.add_body(f"ball_{k}", shapes=[Circle(radius=0.5)], position=(2.0 * k, 0))
    scene.add_joint("pin", Revolute("ball_0", "ball_1"))
    return scene


def body(**given: Any) -> Make:
    return lambda scene: scene.add_body("new", **{"shapes": [BALL], **given})


def joint(kind: str, **given: Any) -> Make:
    return lambda scene: scene.add_joint("new", make_joint(kind, **{"body_a": "ball_0", "body_b": "ball_1", **given}))


def rule(jacobian: Any, bodies: Any = ("ball_0",), **given: Any) -> Make:
    return lambda scene: scene.add_constraint("new", bodies, jacobian, **given)


def sensor(made: Sensor) -> Make:
    return lambda scene: scene.add_sensor("new", made)


# what, and what the sentence must name besides "new"
AUTHORED: dict[str, tuple[Make, str]] = {
    "flat shape": (body(shapes=[Circle(radius=1)]), "Circle of gsenv.solver.planar has 2 dimensions, the scene 3"),
    "flat box": (body(shapes=[FlatBox(half_extents=(1, 1))]), "has 2 dimensions, the scene 3"),
    "no shape": (body(shapes=[3]), "3 is not a shape"),
    "angle": (body(angle=0.3), "a body in 3D has an orientation"),
    "zero quaternion": (body(orientation=(0, 0, 0, 0)), "orientation must be a quaternion"),
    "tiny quaternion": (body(orientation=(1e-13, 0, 0, 0)), "orientation must be a quaternion"),
    "quaternion of three": (body(orientation=(1, 0, 0)), "orientation must be 4 numbers"),
    "quaternion NaN": (body(orientation=(1, NAN, 0, 0)), "orientation must be finite"),
    "position of two": (body(position=(1, 2)), "position must be 3 numbers"),
    "position NaN": (body(position=(1, NAN, 2)), "position must be finite"),
    "position text": (body(position="here"), "position must be 3 numbers"),
    "velocity of two": (body(linear_velocity=(1, 2)), "linear_velocity must be 3 numbers"),
    "spin of one": (body(angular_velocity=1.0), "angular_velocity must be 3 numbers"),
    "spin inf": (body(angular_velocity=(0, INF, 0)), "angular_velocity must be finite"),
    "mass negative": (body(mass=-1), "mass must be positive"),
    "inertia of one": (body(inertia=1.0), "inertia must be three finite moments"),
    "inertia of two": (body(inertia=(1, 1)), "inertia must be three finite moments"),
    "inertia zero": (body(inertia=(1, 1, 0)), "inertia must be positive"),
    "inertia negative": (body(inertia=(1, 1, -1)), "inertia must be positive"),
    "inertia NaN": (body(inertia=(1, 1, NAN)), "inertia must be three finite moments"),
    "inertia of no body": (body(inertia=(1, 1, 2.1)), "inertia: no body has a moment above the sum"),
    "tensor of no body": (body(inertia=[[1, 0, 0], [0, 1, 0], [0, 0, 2.1]]), "above the sum"),
    "tensor not symmetric": (body(inertia=[[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]), "inertia must be symmetric"),
    "tensor indefinite": (body(inertia=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]), "inertia must be positive"),
    "tensor of 2 x 2": (body(inertia=[[1, 0], [0, 1]]), "inertia must be three finite moments"),
    "plane that moves": (body(shapes=[Plane()]), "a Plane belongs on a static or kinematic body"),
    "field that moves": (
        body(shapes=[Heightfield(heights=[[0, 0], [0, 0]], size=(1, 1))]), "a Heightfield belongs on a static",
    ),
    "plane without a normal": (body(kind="static", shapes=[Plane(normal=(0, 0, 0))]), "Plane normal must not be zero"),
    "plane NaN": (body(kind="static", shapes=[Plane(offset=NAN)]), "Plane offset must be finite"),
    "box of two": (body(shapes=[Box(half_extents=(1, 1))]), "Box half_extents must be three finite numbers"),
    "box flat": (body(shapes=[Box(half_extents=(1, 1, 0))]), "Box half_extents must be positive"),
    "sphere NaN": (body(shapes=[Sphere(radius=NAN)]), "Sphere radius must be positive"),
    "capsule negative": (body(shapes=[Capsule(half_length=-1, radius=1)]), "Capsule half_length must be positive"),
    "cylinder zero": (body(shapes=[Cylinder(half_length=1, radius=0)]), "Cylinder radius must be positive"),
    "hull flat": (body(shapes=[Hull(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])]), "Hull"),
    "hull of three": (body(shapes=[Hull(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)])]), "Hull"),
    "hull NaN": (body(shapes=[Hull(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, NAN)])]), "Hull"),
    "field of one row": (
        body(kind="static", shapes=[Heightfield(heights=[[0, 0]], size=(1, 1))]), "at least 2 x 2",
    ),
    "field NaN": (
        body(kind="static", shapes=[Heightfield(heights=[[0, 0], [NAN, 0]], size=(1, 1))]), r"got nan at \[1, 0\]",
    ),
    "shape turned by 0": (body(shapes=[Sphere(radius=1, orientation=(0, 0, 0, 0))]), "Sphere orientation must not be"),
    "shape's place": (body(shapes=[Sphere(radius=1, position=(0, 0))]), "Sphere position must be three finite numbers"),
    "torsional friction": (body(shapes=[Sphere(radius=1, torsional_friction=-1)]), "torsional_friction"),
    "rolling friction": (body(shapes=[Sphere(radius=1, rolling_friction=NAN)]), "rolling_friction"),
    "restitution": (body(shapes=[Sphere(radius=1, restitution=1.1)]), "restitution must not exceed 1"),
    "revolute": (joint("revolute"), "a Revolute of gsenv.solver.planar has 2 dimensions, the scene 3"),
    "prismatic": (joint("prismatic", axis=(1, 0, 0)), "a Prismatic of gsenv.solver.planar has 2 dimensions"),
    "wheel": (joint("wheel", axis=(0, 0, 1)), "spin_axis is missing"),
    "gear": (lambda s: s.add_joint("new", Gear("pin", "pin")), "a gear couples two different joints"),
    "anchor of two": (joint("ball", anchor=(1, 2)), "anchor must be 3 numbers"),
    "anchor NaN": (joint("weld", anchor_a=(1, 2, NAN)), "anchor_a must be finite"),
    "length negative": (joint("distance", length=-1.0), "length must not be negative"),
    "target frequency": (joint("target", frequency=0.0), "frequency must be positive"),
    "joint to itself": (joint("ball", body_b="ball_0"), "two different bodies"),
    "jacobian of three": (rule([1, 0, 0]), r"jacobian"),
    "jacobian of twelve for one": (rule([0] * 12), r"jacobian"),
    "jacobian of six for two": (rule([0] * 6, ("ball_0", "ball_1")), r"jacobian"),
    "jacobian NaN": (rule([NAN, *ROW[1:]]), "jacobian must be finite"),
    "jacobian of seven rows": (rule([ROW] * 7), "rows"),
    "bias of two": (rule(ROW, bias=[1, 2]), "bias"),
    "softness negative": (rule(ROW, softness=-1.0), "softness must not be negative"),
    "bounds crossed": (rule(ROW, lower=1.0, upper=-1.0), "lower must not be above upper"),
    "frame": (rule(ROW, frame="ball"), "frame 'ball' is unknown"),
    "update": (rule(ROW, update=3), "update must be a function"),
    "rays": (sensor(RaySensor("ball_0", angles=[0.0], length=1.0)), "a RaySensor of gsenv.solver.planar has 2 dim"),
    "frame sensor": (sensor(FrameSensor("ball_0")), "a FrameSensor of gsenv.solver.planar has 2 dimensions"),
    "axis of a target": (lambda s: s.add_actuator("new", "goal", "angle"), "axis 'angle' is unknown"),
    "turn has no position": (lambda s: s.add_actuator("new", "goal", "turn_x", "position"), "turn_x has no position"),
    "motor of a ball": (lambda s: s.add_actuator("new", "pin"), "'pin' has no motor"),
}  # fmt: skip


@pytest.mark.parametrize("case", AUTHORED)
def test_bad_things_are_refused(case: str) -> None:
    scene = two_balls()
    scene.add_joint("goal", Target("ball_1"))
    before = pickle.dumps(scene)
    make, words = AUTHORED[case]
    with pytest.raises(ValueError, match=words) as caught:
        make(scene)
    assert "'new'" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")
    assert pickle.dumps(scene) == before


FLAT: dict[str, tuple[Make, str]] = {
    "solid shape": (body(), "Sphere of gsenv.solver.spatial has 3 dimensions, the scene 2"),
    "solid box": (body(shapes=[Box(half_extents=(1, 1, 1))]), "has 3 dimensions, the scene 2"),
    "orientation": (body(shapes=[Circle(radius=1)], orientation=(1, 0, 0, 0)), "angle"),
    "spin of three": (body(shapes=[Circle(radius=1)], angular_velocity=(0, 0, 1)), "angular_velocity"),
    "inertia of three": (body(shapes=[Circle(radius=1)], inertia=(1, 1, 1)), "inertia must be a number"),
    "position of three": (body(shapes=[Circle(radius=1)], position=(0, 0, 1)), "position must be 2 numbers"),
    "ball": (joint("ball"), "a Ball of gsenv.solver.spatial has 3 dimensions, the scene 2"),
    "jacobian of six": (rule(ROW), "jacobian"),
}


@pytest.mark.parametrize("case", FLAT)
def test_things_of_space_are_refused_in_the_plane(case: str) -> None:
    scene = flat_scene()
    before = pickle.dumps(scene)
    make, words = FLAT[case]
    with pytest.raises(ValueError, match=words) as caught:
        make(scene)
    assert "'new'" in str(caught.value)
    assert pickle.dumps(scene) == before


@pytest.mark.parametrize("argument", ["motor_effort", "limits", "axis"])
def test_a_distance_has_no_motor_and_axis_and_a_weld_no_limits(argument: str) -> None:
    with pytest.raises(TypeError, match=argument):
        make_joint("weld" if argument == "limits" else "distance", "ball_0", "ball_1", **{argument: 1.0})


ACTS: dict[str, Callable[[Any], Any]] = {
    "force of two": lambda w: w.apply_force("ball_0", force=(1, 2)),
    "inertia of no body": lambda w: w.parameters.set("ball_0", friction=0.9, inertia=(1, 1, 5)),
    "spin of one": lambda w: w.set_velocity("ball_0", linear=(1, 0, 0), angular=[1.0]),
    "force NaN": lambda w: w.apply_force("ball_0", force=(1, NAN, 2)),
    "force's point of two": lambda w: w.apply_force("ball_0", force=(1, 0, 0), point=(0, 0)),
    "torque of two": lambda w: w.apply_force("ball_0", force=(1, 0, 0), torque=(1, 2)),
    "torque NaN": lambda w: w.apply_force("ball_0", force=(1, 0, 0), torque=(1, NAN, 2)),
    "forces of three for two": lambda w: w.apply_force("ball_0", force=[[1, 0, 0]] * 3),
    "pose's angle": lambda w: w.set_pose("ball_0", position=(3, 0, 0), angle=0.1),
    "pose of two": lambda w: w.set_pose("ball_0", position=(3, 0)),
    "pose NaN": lambda w: w.set_pose("ball_0", position=(3, 0, NAN)),
    "pose turned by zero": lambda w: w.set_pose("ball_0", position=(3, 0, 0), orientation=(0, 0, 0, 0)),
    "pose turned by zero in one": lambda w: w.set_pose(
        "ball_0", position=(3, 0, 0), orientation=[(1, 0, 0, 0), (0, 0, 0, 0)]
    ),
    "pose turned by three": lambda w: w.set_pose("ball_0", position=(3, 0, 0), orientation=(1, 0, 0)),
    "pose turned by NaN": lambda w: w.set_pose("ball_0", position=(3, 0, 0), orientation=(NAN, 0, 0, 0)),
    "pose's body": lambda w: w.set_pose(99, position=(1, 2, 3)),
    "velocity of two": lambda w: w.set_velocity("ball_0", linear=(1, 2), angular=(0, 0, 0)),
    "spin of four": lambda w: w.set_velocity("ball_0", linear=(1, 0, 0), angular=[1.0, 2.0, 3.0, 4.0]),
    "spin NaN": lambda w: w.set_velocity("ball_0", linear=(1, 0, 0), angular=(NAN, 0, 0)),
    "velocity of a static body": lambda w: w.set_velocity("floor", linear=(1, 0, 0)),
    "target's angle": lambda w: w.set_target("goal", position=(1, 0, 0), angle=0.1),
    "target of two": lambda w: w.set_target("goal", position=(1, 0), orientation=(1, 0, 0, 0)),
    "target turned by zero": lambda w: w.set_target("goal", position=(1, 0, 0), orientation=(0, 0, 0, 0)),
    "target's spin of two": lambda w: w.set_target("goal", position=(1, 0, 0), angular=(1, 2)),
    "target of a ball": lambda w: w.set_target("pin", position=(1, 0, 0)),
    "motor of a ball": lambda w: w.set_motor("pin", speed=1.0),
    "coordinate of a ball": lambda w: w.joint_coordinate("pin"),
    "rate of a ball": lambda w: w.joint_rate("pin"),
    "rays": lambda w: w.cast_rays((0, 0, 0), (1, 0, 0), 1.0),
    "newton": lambda w: setattr(w, "options", Options(solver="newton")),
    "gravity of two": lambda w: w.parameters.set(gravity=(0, 1)),
    "gravity NaN": lambda w: w.parameters.set(gravity=(0, 1, NAN)),
    "mass zero": lambda w: w.parameters.set("ball_0", friction=0.9, mass=0.0),
    "mass in one of two": lambda w: w.parameters.set("ball_0", friction=0.9, mass=[1.0, -1.0]),
    "inertia of two": lambda w: w.parameters.set("ball_0", friction=0.9, inertia=(1, 1)),
    "inertia zero": lambda w: w.parameters.set("ball_0", friction=0.9, inertia=(1, 1, 0)),
    "inertia negative": lambda w: w.parameters.set("ball_0", friction=0.9, inertia=(1, 1, -1)),
    "inertia NaN": lambda w: w.parameters.set("ball_0", friction=0.9, inertia=(1, NAN, 1)),
    "size of two": lambda w: w.parameters.set("box", half_extents=(1, 1)),
    "size zero": lambda w: w.parameters.set("box", half_extents=(1, 1, 0)),
    "size of another shape": lambda w: w.parameters.set("box", radius=1.0),
    "size of a plane": lambda w: w.parameters.set("floor", half_extents=(1.0, 1.0, 1.0)),
    "size of a hull": lambda w: w.parameters.set("hull", half_extents=(1.0, 1.0, 1.0)),
    "size of one of two shapes": lambda w: w.parameters.set("pair", radius=1.0),
    "torsional friction negative": lambda w: w.parameters.set("box", torsional_friction=-1.0),
    "rolling friction NaN": lambda w: w.parameters.set("box", rolling_friction=NAN),
    "restitution": lambda w: w.parameters.set("box", restitution=1.5),
    "mass of a plane": lambda w: w.parameters.set("floor", mass=1.0),
    "vertices of a hull": lambda w: w.parameters.set("hull/0", vertices=[(0, 0, 0)] * 4),
    "length of a ball": lambda w: w.parameters.set(w.pin, length=1.0),
    "target rigid": lambda w: w.parameters.set(w.goal, frequency=0.0),
    "bounds crossed": lambda w: w.parameters.set(w.rule, upper=-6.0),
    "bias of seven": lambda w: w.parameters.set(w.rule, bias=[1.0] * 7),
}


@pytest.mark.parametrize("case", ACTS)
def test_refused_acts_change_nothing(case: str) -> None:
    scene = two_balls()
    scene.add_joint("goal", Target("ball_1"))
    scene.add_constraint("rule", ["ball_0"], ROW, lower=-5, upper=5)
    scene.add_body("floor", "static", shapes=[Plane()])
    scene.add_body("box", shapes=[Box(half_extents=(1, 1, 1))], position=(9, 0, 0))
    scene.add_body("hull", shapes=[Hull(vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])])
    scene.add_body("pair", shapes=[BALL, Sphere(radius=0.1, position=(1, 0, 0))])
    world = World(scene, 2)
    for name in ("pin", "goal", "rule"):
        setattr(world, name, handle("joint", name, world.model.joint_names))
    before, options = everything(world), world.options
    with pytest.raises(ValueError, match=r"^[^\n]+\.$"):
        ACTS[case](world)
    assert everything(world) == before
    assert world.options == options


def test_orientation_is_refused_in_2d() -> None:
    scene = flat_scene()
    scene.add_joint("goal", Target("ball_0"))
    world = World(scene)
    before = everything(world)
    with pytest.raises(ValueError, match="a body in 2D has an angle, not an orientation"):
        world.set_pose("ball_0", position=(1, 2), orientation=(1, 0, 0, 0))
    with pytest.raises(ValueError, match="a body in 2D has an angle, not an orientation"):
        world.set_target("goal", position=(1, 2), orientation=(1, 0, 0, 0))
    with pytest.raises(ValueError, match="torsional_friction"):
        world.parameters.set("ball_0", torsional_friction=0.1)
    assert everything(world) == before


def test_newton_is_refused() -> None:
    with pytest.raises(ValueError, match="newton solver is there in 2D only; 3D has pgs, nncg, subspace and soft"):
        World(two_balls(), options=Options(solver="newton"))


@pytest.mark.parametrize("dim", [1, 4, "3", None])
def test_dimensions(dim: Any) -> None:
    with pytest.raises(ValueError, match="dim must be 2 or 3"):
        Scene(dim=dim)
    with pytest.raises(ValueError, match="gravity must be 3 numbers"):
        Scene(dim=3, gravity=(0, -1))


def test_snapshots_of_the_plane_are_refused() -> None:
    world = World(two_balls())
    before = everything(world)
    with pytest.raises(ValueError, match="another scene"):
        world.restore(World(flat_scene()).save())
    assert everything(world) == before
