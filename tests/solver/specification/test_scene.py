"""Scene: what is refused and how, and what follows from shapes: mass, inertia, centre of mass."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World
from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon, PoseSensor, Target, Terrain, Weld
from tests.solver.joints import make_joint

NAN, INF = math.nan, math.inf
DISK = Circle(radius=0.5)


def base() -> Scene:
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    scene.add_body("crate", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 1))
    scene.add_body("ball", shapes=[DISK], position=(2, 1))
    scene.add_joint("glue", Weld("crate", "ball"))
    scene.add_joint("pull", Target("ball"))
    scene.add_constraint("rule", ["crate", "ball"], [1, 0, 0, -1, 0, 0])
    scene.add_actuator("drive", "pull", "x")
    scene.add_sensor("eye", PoseSensor("ball"))
    return scene


def body(**given: Any) -> Callable[[Scene], Any]:
    given.setdefault("shapes", [DISK])
    return lambda scene: scene.add_body(given.get("name", "new"), **{k: v for k, v in given.items() if k != "name"})


def shape(made: Any, **given: Any) -> Callable[[Scene], Any]:
    return body(shapes=[made], **given)


def joint(kind: str = "weld", a: Any = "crate", b: Any = "ball", **given: Any) -> Callable[[Scene], Any]:
    name = given.pop("name", "new")
    return lambda scene: scene.add_joint(name, make_joint(kind, a, b, **given))


def rule(bodies: Any = ("crate", "ball"), jacobian: Any = (1, 0, 0, -1, 0, 0), **given: Any) -> Callable[[Scene], Any]:
    name = given.pop("name", "new")
    return lambda scene: scene.add_constraint(name, bodies, jacobian, **given)


def actuator(joint: Any = "pull", axis: str = "x", **given: Any) -> Callable[[Scene], Any]:
    name = given.pop("name", "new")
    return lambda scene: scene.add_actuator(name, joint, axis, **given)


def strange() -> Any:
    """Handle of a body that the base scene does not have."""
    return Scene().add_body("stranger", shapes=[DISK])


# (what is done to the scene, what the sentence must contain)
REFUSED: dict[str, tuple[Callable[[Scene], Any], tuple[str, ...]]] = {
    "name empty": (body(name=""), ("body", "name")),
    "name not a string": (body(name=7), ("body", "7")),
    "name taken": (body(name="crate"), ("body 'crate'", "exists")),
    "kind unknown": (body(kind="dynamo"), ("body 'new'", "kind 'dynamo'", "did you mean 'dynamic'")),
    "position NaN": (body(position=(NAN, 0)), ("body 'new'", "position", "finite")),
    "position 3D": (body(position=(0, 0, 0)), ("body 'new'", "position", "2 numbers")),
    "position text": (body(position="up"), ("body 'new'", "position")),
    "position ragged": (body(position=[[1], [1, 2]]), ("body 'new'", "position")),
    "angle inf": (body(angle=INF), ("body 'new'", "angle", "finite")),
    "angle text": (body(angle="left"), ("body 'new'", "angle", "number")),
    "velocity NaN": (body(linear_velocity=(0, NAN)), ("body 'new'", "linear_velocity")),
    "spin NaN": (body(angular_velocity=NAN), ("body 'new'", "angular_velocity")),
    "mass zero": (body(mass=0), ("body 'new'", "mass", "positive", "0")),
    "mass negative": (body(mass=-2.5), ("body 'new'", "mass", "-2.5")),
    "mass NaN": (body(mass=NAN), ("body 'new'", "mass", "finite")),
    "mass inf": (body(mass=INF), ("body 'new'", "mass", "finite")),
    "mass an array": (body(mass=[1, 2]), ("body 'new'", "mass")),
    "inertia zero": (body(inertia=0.0), ("body 'new'", "inertia", "positive")),
    "inertia NaN": (body(inertia=NAN), ("body 'new'", "inertia")),
    "damping negative": (body(linear_damping=-1), ("body 'new'", "linear_damping")),
    "spin damping NaN": (body(angular_damping=NAN), ("body 'new'", "angular_damping")),
    "gravity scale inf": (body(gravity_scale=INF), ("body 'new'", "gravity_scale")),
    "color of two": (body(color=(1, 2)), ("body 'new'", "color")),
    "color beyond 255": (body(color=(0, 0, 256)), ("body 'new'", "color")),
    "no mass": (body(shapes=[]), ("body 'new'", "mass")),
    "no inertia": (body(shapes=[], mass=1.0), ("body 'new'", "inertia")),
    "no density": (shape(Circle(radius=1, density=0)), ("body 'new'", "density")),
    "only a sensor": (shape(Circle(radius=1, sensor=True)), ("body 'new'", "mass")),
    "shape is a number": (shape(3.0), ("body 'new'", "3.0", "not a shape")),
    "shape is a class": (shape(Circle), ("body 'new'", "not a shape")),
    "radius zero": (shape(Circle(radius=0)), ("body 'new'", "Circle radius", "0")),
    "radius negative": (shape(Circle(radius=-1)), ("body 'new'", "Circle radius", "-1")),
    "radius NaN": (shape(Circle(radius=NAN)), ("body 'new'", "Circle radius", "nan")),
    "radius text": (shape(Circle(radius="big")), ("body 'new'", "Circle radius")),  # type: ignore[arg-type]
    "box flat": (shape(Box(half_extents=(1, 0))), ("body 'new'", "Box half_extents")),
    "box of one number": (shape(Box(half_extents=(1,))), ("body 'new'", "Box half_extents")),
    "box inf": (shape(Box(half_extents=(1, INF))), ("body 'new'", "Box half_extents")),
    "capsule thin": (shape(Capsule(half_length=1, radius=0)), ("body 'new'", "Capsule radius")),
    "capsule short": (shape(Capsule(half_length=-1, radius=1)), ("body 'new'", "Capsule half_length")),
    "density negative": (shape(Circle(radius=1, density=-1)), ("body 'new'", "Circle density")),
    "friction negative": (shape(Circle(radius=1, friction=-0.1)), ("body 'new'", "friction", "-0.1")),
    "friction NaN": (shape(Circle(radius=1, friction=NAN)), ("body 'new'", "friction")),
    "restitution NaN": (shape(Circle(radius=1, restitution=NAN)), ("body 'new'", "restitution")),
    "shape's place NaN": (shape(Circle(radius=1, position=(NAN, 0))), ("body 'new'", "position")),
    "shape's angle NaN": (shape(Box(half_extents=(1, 1), angle=NAN)), ("body 'new'", "angle")),
    "mask beyond 64 bits": (shape(Circle(radius=1, mask=2**64)), ("body 'new'", "mask")),
    "polygon of two": (shape(Polygon(vertices=[(0, 0), (1, 0)])), ("body 'new'", "Polygon", "3")),
    "polygon repeated": (
        shape(Polygon(vertices=[(0, 0), (1, 0), (1, 0), (0, 1)])), ("body 'new'", "Polygon", "twice"),
    ),
    "polygon flat": (shape(Polygon(vertices=[(0, 0), (1, 0), (2, 0)])), ("body 'new'", "Polygon", "line")),
    "polygon dented": (
        shape(Polygon(vertices=[(0, 0), (2, 0), (1, 0.5), (2, 2), (0, 2)])), ("body 'new'", "Polygon", "convex"),
    ),
    "polygon crossed": (
        shape(Polygon(vertices=[(0, 0), (1, 1), (1, 0), (0, 1)])), ("body 'new'", "Polygon", "convex"),
    ),
    "pentagram": (
        shape(Polygon(vertices=[(math.cos(k * 0.8 * math.pi), math.sin(k * 0.8 * math.pi)) for k in range(5)])),
        ("body 'new'", "Polygon", "convex"),
    ),
    "polygon NaN": (shape(Polygon(vertices=[(0, 0), (1, NAN), (0, 1)])), ("body 'new'", "Polygon", "finite")),
    "polygon in 3D": (shape(Polygon(vertices=[(0, 0, 0)] * 3)), ("body 'new'", "Polygon")),
    "plane that moves": (shape(HalfPlane()), ("body 'new'", "HalfPlane", "static")),
    "terrain that moves": (shape(Terrain(vertices=[(0, 0), (1, 0)]), mass=1, inertia=1), ("body 'new'", "Terrain")),
    "plane without normal": (shape(HalfPlane(normal=(0, 0)), kind="static"), ("body 'new'", "HalfPlane normal")),
    "plane NaN": (shape(HalfPlane(offset=NAN), kind="static"), ("body 'new'", "HalfPlane offset")),
    "terrain of one": (shape(Terrain(vertices=[(0, 0)]), kind="static"), ("body 'new'", "Terrain", "2")),
    "terrain repeated": (
        shape(Terrain(vertices=[(0, 0), (0, 0), (1, 0)]), kind="static"), ("body 'new'", "Terrain", "twice"),
    ),
    "joint name taken": (joint(name="glue"), ("joint 'glue'", "exists")),
    "joint by name": (lambda s: s.add_joint("new", "weld"), ("joint 'new'", "'weld' is not a joint")),  # type: ignore[arg-type]
    "joint as a class": (lambda s: s.add_joint("new", Weld), ("joint 'new'", "is not a joint")),  # type: ignore[arg-type]
    "joint body unknown": (joint(a="crat"), ("joint 'new'", "'crat'", "did you mean 'crate'")),
    "joint body number": (joint(a=99), ("joint 'new'", "99")),
    "joint body negative": (joint(a=-1), ("joint 'new'", "-1")),
    "joint of a stranger": (lambda s: s.add_joint("new", Weld(strange(), "ball")), ("joint 'new'", "'stranger'")),
    "joint to itself": (joint(a="ball"), ("joint 'new'", "two different", "ball")),
    "joint without a": (joint(a=None), ("joint 'new'", "body_a")),
    "joint without b": (joint(b=None), ("joint 'new'", "body_b")),
    "joint of a joint": (
        lambda s: s.add_joint("new", Weld(s.add_joint("temporary", Weld("crate", "ball")), "ball")),
        ("joint 'new'", "'temporary'"),
    ),
    "anchor NaN": (joint(anchor=(NAN, 0)), ("joint 'new'", "anchor")),
    "anchor_a 3D": (joint(anchor_a=(0, 0, 0)), ("joint 'new'", "anchor_a")),
    "frequency negative": (joint(frequency=-1), ("joint 'new'", "frequency")),
    "target rigid": (joint(kind="target", frequency=0), ("joint 'new'", "frequency", "positive")),
    "target of nothing": (joint(kind="target", b=None), ("joint 'new'", "body is missing")),
    "target of a static body": (joint(kind="target", b="ground"), ("joint 'new'", "dynamic", "'ground'")),
    "two anchors": (joint(anchor=(0, 0), anchor_a=(0, 0)), ("joint 'new'", "not both")),
    "two anchors of a target": (
        joint(kind="target", anchor=(0, 0), local_anchor=(0, 0)), ("joint 'new'", "local_anchor, not both"),
    ),
    "axis 3D": (joint(kind="prismatic", axis=(0, 0, 1)), ("joint 'new'", "axis", "2 numbers")),
    "axis None": (joint(kind="wheel", axis=None), ("joint 'new'", "axis", "2 numbers")),
    "axis zero": (joint(kind="wheel", axis=(0, 0)), ("joint 'new'", "axis", "direction")),
    "limits of one": (joint(kind="revolute", limits=1.0), ("joint 'new'", "limits must be two numbers")),
    "limits crossed": (joint(kind="revolute", limits=(1, -1)), ("joint 'new'", "lower limit")),
    "motor without a bound": (joint(kind="revolute", motor_speed=1.0), ("joint 'new'", "motor_effort")),
    "two springs": (joint(frequency=1.0, stiffness=1.0), ("joint 'new'", "not both")),
    "damping ratio NaN": (joint(damping_ratio=NAN), ("joint 'new'", "damping_ratio")),
    "force negative": (joint(kind="target", max_force=-1), ("joint 'new'", "max_force")),
    "torque NaN": (joint(kind="target", max_torque=NAN), ("joint 'new'", "max_torque")),
    "rule name taken": (rule(name="rule"), ("constraint 'rule'", "exists")),
    "rule name of a joint": (rule(name="glue"), ("constraint 'glue'", "exists")),
    "rule of three": (rule(bodies=("ground", "crate", "ball"), jacobian=[1] * 9), ("constraint 'new'", "3")),
    "rule of none": (rule(bodies=(), jacobian=[]), ("constraint 'new'", "0")),
    "rule of a body twice": (rule(bodies=("ball", "ball")), ("constraint 'new'", "different")),
    "rule's body unknown": (rule(bodies=("ball", "bal")), ("constraint 'new'", "'bal'", "did you mean 'ball'")),
    "jacobian too short": (rule(jacobian=[1, 0, 0]), ("constraint 'new'", "jacobian", "6")),
    "jacobian too tall": (rule(jacobian=np.ones((4, 6))), ("constraint 'new'", "jacobian", "(4, 6)")),
    "jacobian 3D": (rule(jacobian=np.ones((1, 1, 6))), ("constraint 'new'", "jacobian")),
    "jacobian NaN": (rule(jacobian=[NAN, 0, 0, 0, 0, 0]), ("constraint 'new'", "jacobian", "finite")),
    "jacobian text": (rule(jacobian="abc"), ("constraint 'new'", "jacobian")),
    "bounds crossed": (rule(lower=1, upper=-1), ("constraint 'new'", "lower", "upper")),
    "bound NaN": (rule(lower=NAN), ("constraint 'new'", "lower", "NaN")),
    "bound text": (rule(upper="much"), ("constraint 'new'", "upper")),
    "bounds of two": (rule(lower=[0, 0]), ("constraint 'new'", "lower")),
    "lower bound inf": (rule(lower=INF), ("constraint 'new'", "lower")),
    "upper bound -inf": (rule(upper=-INF), ("constraint 'new'", "upper")),
    "bias inf": (rule(bias=INF), ("constraint 'new'", "bias")),
    "softness negative": (rule(softness=-1), ("constraint 'new'", "softness")),
    "actuator name taken": (actuator(name="drive"), ("actuator 'drive'", "exists")),
    "actuator on a weld": (actuator(joint="glue"), ("actuator 'new'", "motor", "glue")),
    "actuator on a rule": (actuator(joint="rule"), ("actuator 'new'", "motor", "rule")),
    "actuator joint unknown": (actuator(joint="pul"), ("actuator 'new'", "did you mean 'pull'")),
    "actuator axis": (actuator(axis="z"), ("actuator 'new'", "axis 'z'")),
    "actuator mode": (actuator(mode="force"), ("actuator 'new'", "mode 'force'")),
    "actuator range crossed": (actuator(lower=1, upper=-1), ("actuator 'new'", "lower")),
    "actuator range NaN": (actuator(lower=NAN), ("actuator 'new'", "lower")),
    "actuator range text": (actuator(upper="far"), ("actuator 'new'", "upper")),
    "sensor name taken": (lambda s: s.add_sensor("eye", PoseSensor("ball")), ("sensor 'eye'", "exists")),
    "sensor by name": (lambda s: s.add_sensor("new", "pose"), ("sensor 'new'", "'pose' is not a sensor")),  # type: ignore[arg-type]
    "sensor body": (lambda s: s.add_sensor("new", PoseSensor("bell")), ("sensor 'new'", "did you mean 'ball'")),
    "exclude itself": (lambda s: s.exclude("ball", "ball"), ("exclude", "ball")),
    "exclude unknown": (lambda s: s.exclude("ball", "crates"), ("exclude", "did you mean 'crate'")),
    "exclude a joint": (lambda s: s.exclude("ball", s.add_joint("temporary", Weld("crate", "ball"))), ("exclude",)),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_sentence_and_unchanged(case: str) -> None:
    act, words = REFUSED[case]
    scene = base()
    if "temporary" in str(words) or case == "exclude a joint":
        before = None  # these make a joint on purpose first
    else:
        before = pickle.dumps(scene)
    with pytest.raises(ValueError, match=r"^[^\n]+\.$") as caught:
        act(scene)
    for word in words:
        assert word in str(caught.value), str(caught.value)
    assert before is None or pickle.dumps(scene) == before


@pytest.mark.parametrize(
    ("kind", "argument"),
    [("weld", "max_force"), ("distance", "rest"), ("revolute", "axis"), ("target", "collide"), ("target", "limits")],
)
def test_a_joint_has_the_arguments_of_its_kind_alone(kind: str, argument: str) -> None:
    with pytest.raises(TypeError, match=argument):
        make_joint(kind, "crate", "ball", **{argument: 1.0})


@pytest.mark.parametrize("kind", ["prismatic", "wheel"])
def test_a_sliding_joint_needs_an_axis(kind: str) -> None:
    with pytest.raises(TypeError, match="axis"):
        make_joint(kind, "crate", "ball")


def test_refused_scenes() -> None:
    with pytest.raises(ValueError, match="dim"):
        Scene(dim=4)
    for gravity in ((0, NAN), (0, 0, -9.81), "down", 9.81):
        with pytest.raises(ValueError, match="gravity"):
            Scene(gravity=gravity)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no body"):
        Scene().compile()
    with pytest.raises(ValueError, match="no body"):
        World(Scene())
    with pytest.raises(ValueError, match="Scene"):
        World("scene.xml")  # type: ignore[arg-type]


def test_arguments_are_copied() -> None:
    # one buffer for many calls is common in loops that build scenes
    scene = Scene()
    place, velocity = np.zeros(2), np.zeros(2)
    row = np.array([[1.0, 0, 0]])
    for k in range(3):
        place[0] = k
        velocity[1] = 10 * k
        scene.add_body(f"b{k}", shapes=[DISK], position=place, linear_velocity=velocity)
    anchor = np.array([0.5, 0.0])
    scene.add_joint("j", Weld("b0", "b1", anchor_a=anchor, anchor_b=anchor))
    scene.add_constraint("c", ["b2"], row)
    anchor[:] = 99.0
    row[:] = 99.0
    model = scene.compile()
    np.testing.assert_array_equal(model.start_bodies["position"][:, 0], [0, 1, 2])
    np.testing.assert_array_equal(model.start_bodies["velocity"][:, 1], [0, 10, 20])
    np.testing.assert_array_equal(model.nominal_joints["anchor_a"][0], [0.5, 0])
    np.testing.assert_array_equal(model.nominal_rows["jacobian_b"][0], [1, 0, 0])


# ---------------------------------------------------------------- mass


def nominal(**given: Any) -> Any:
    scene = Scene()
    scene.add_body("body", **given)
    return scene.compile().nominal_bodies[0]


def test_single_shapes() -> None:
    box = nominal(shapes=[Box(half_extents=(0.3, 0.2), density=5.0)])
    assert box["mass"] == pytest.approx(5 * 0.6 * 0.4, rel=1e-15)
    assert box["inertia"] == pytest.approx(box["mass"] * (0.6**2 + 0.4**2) / 12, rel=1e-15)
    disk = nominal(shapes=[Circle(radius=0.7, density=2.0)])
    assert disk["mass"] == pytest.approx(2 * math.pi * 0.49, rel=1e-15)
    assert disk["inertia"] == pytest.approx(0.5 * disk["mass"] * 0.49, rel=1e-15)
    # right triangle, legs a and b: centroid (a/3, b/3), I = m (a^2 + b^2) / 18
    triangle = nominal(shapes=[Polygon(vertices=[(0, 0), (3, 0), (0, 2)])])
    assert triangle["mass"] == pytest.approx(3.0, rel=1e-14)
    np.testing.assert_allclose(triangle["center"], (1, 2 / 3), rtol=1e-14)
    assert triangle["inertia"] == pytest.approx(3.0 * 13 / 18, rel=1e-13)


def test_capsule_against_a_numerical_integral() -> None:
    # strips across: at x from the middle, half-height r on the segment, the circle's beyond it
    h, r = 0.5, 0.2
    x = np.linspace(-h - r, h + r, 2_000_001)
    over = np.clip(np.abs(x) - h, 0.0, r)
    y = np.sqrt(r**2 - over**2)
    area = np.trapezoid(2 * y, x)
    inertia = np.trapezoid(2 * y * x**2 + 2 * y**3 / 3, x)
    capsule = nominal(shapes=[Capsule(half_length=h, radius=r, density=3.0)])
    assert capsule["mass"] == pytest.approx(3 * area, rel=1e-8)
    assert capsule["inertia"] == pytest.approx(3 * inertia, rel=1e-8)


def test_many_shapes_by_the_parallel_axis_theorem() -> None:
    # a hammer: a handle 1.0 x 0.1 of density 2, a head 0.2 x 0.4 of density 10 turned by 30 degrees at
    # its right end, a disk r = 0.1 of density 1 at the left; the sensor weighs nothing
    shapes = [
        Box(half_extents=(0.5, 0.05), density=2.0),
        Box(half_extents=(0.1, 0.2), density=10.0, position=(0.6, 0.1), angle=math.pi / 6),
        Circle(radius=0.1, position=(-0.55, -0.2)),
        Circle(radius=3.0, density=100.0, sensor=True),
    ]
    parts = [  # mass, centre, own inertia
        (0.2, (0.0, 0.0), 0.2 * (1.0 + 0.01) / 12),
        (0.8, (0.6, 0.1), 0.8 * (0.04 + 0.16) / 12),
        (0.01 * math.pi, (-0.55, -0.2), 0.5 * 0.01 * math.pi * 0.01),
    ]
    mass = sum(m for m, _, _ in parts)
    center = [sum(m * c[i] for m, c, _ in parts) / mass for i in (0, 1)]
    inertia = sum(i + m * ((c[0] - center[0]) ** 2 + (c[1] - center[1]) ** 2) for m, c, i in parts)
    made = nominal(shapes=shapes)
    assert made["mass"] == pytest.approx(mass, rel=1e-14)
    np.testing.assert_allclose(made["center"], center, rtol=1e-14)
    assert made["inertia"] == pytest.approx(inertia, rel=1e-14)
    assert made["inv_mass"] == pytest.approx(1 / mass, rel=1e-14)
    assert made["inv_inertia"] == pytest.approx(1 / inertia, rel=1e-14)

    heavy = nominal(shapes=shapes, mass=5.0)  # the same form, other mass
    assert heavy["mass"] == 5.0
    assert heavy["inertia"] == pytest.approx(inertia * 5 / mass, rel=1e-14)
    np.testing.assert_allclose(heavy["center"], center, rtol=1e-14)
    given = nominal(shapes=shapes, inertia=9.0)
    assert (given["mass"], given["inertia"]) == (made["mass"], 9.0)


def test_a_body_may_lack_shapes() -> None:
    point = nominal(shapes=[], mass=2.0, inertia=0.5)
    assert (point["mass"], point["inertia"], point["inv_mass"], point["inv_inertia"]) == (2, 0.5, 0.5, 2)


def test_only_dynamic_enabled_bodies_move() -> None:
    for given in ({"kind": "static"}, {"kind": "kinematic"}, {"enabled": False}):
        made = nominal(shapes=[DISK], **given)
        assert made["inv_mass"] == made["inv_inertia"] == 0.0


# ---------------------------------------------------------------- frames


def lollipop(**given: Any) -> World:
    """A body whose centre of mass is at (1, 0) of its own frame: a disk there and nothing else."""
    scene = Scene(gravity=(0, 0))
    scene.add_body("off", shapes=[Circle(radius=0.5, position=(1.0, 0.0))], **given)
    return World(scene)


def test_position_is_the_own_frame() -> None:
    world = lollipop(position=(3, 4), angle=math.pi / 2)
    np.testing.assert_allclose(world.position[0, 0], (3, 4), atol=1e-15)
    np.testing.assert_allclose(world.center_of_mass[0, 0], (3, 5), atol=1e-15)
    world.set_pose("off", position=(-2, 7), angle=math.pi)
    np.testing.assert_allclose(world.position[0, 0], (-2, 7), atol=1e-15)
    np.testing.assert_allclose(world.center_of_mass[0, 0], (-3, 7), atol=1e-15)
    world.set_pose("off", angle=0.0)  # turns about the own frame's origin
    np.testing.assert_allclose(world.center_of_mass[0, 0], (-1, 7), atol=1e-15)
    world.set_pose("off", position=(0, 0))  # keeps the angle
    assert world.angle[0, 0] == 0.0
    np.testing.assert_allclose(world.center_of_mass[0, 0], (1, 0), atol=1e-15)


def test_linear_velocity_is_of_the_centre_of_mass() -> None:
    # free flight: the centre of mass goes straight, the own frame circles around it
    world = lollipop(linear_velocity=(2, 0), angular_velocity=3.0)
    world.step(30)
    t = world.time[0]
    assert t == pytest.approx(0.5)
    np.testing.assert_allclose(world.linear_velocity[0, 0], (2, 0), atol=1e-14)
    np.testing.assert_allclose(world.center_of_mass[0, 0], (1 + 2 * t, 0), atol=1e-12)
    assert world.angle[0, 0] == pytest.approx(3 * t, rel=1e-13)
    turned = np.array([math.cos(3 * t), math.sin(3 * t)])
    np.testing.assert_allclose(world.position[0, 0], np.array([1 + 2 * t, 0]) - turned, atol=1e-12)


def test_anchor_of_a_joint_is_a_world_point() -> None:
    scene = Scene()
    scene.add_body("a", shapes=[DISK], position=(1, 2), angle=math.pi / 2)
    scene.add_body("b", shapes=[DISK], position=(3, 2), angle=math.pi)
    scene.add_joint("mid", Weld("a", "b", anchor=(2, 2)))
    scene.add_joint("origin of b", Weld("a", "b"))
    joints = scene.compile().nominal_joints
    np.testing.assert_allclose(joints["anchor_a"], [(0, -1), (0, -2)], atol=1e-15)
    np.testing.assert_allclose(joints["anchor_b"], [(1, 0), (0, 0)], atol=1e-15)
    np.testing.assert_allclose(joints["reference"], [(0, 1), (0, 1)], atol=1e-15)


def test_black_is_a_colour_and_none_is_none() -> None:
    scene = base()
    scene.add_body("coal", shapes=[DISK], position=(5, 1), color=(0, 0, 0))
    colors = scene.compile().shape_colors
    assert colors is not None
    assert colors.any(1).tolist() == [False, False, False, True]
