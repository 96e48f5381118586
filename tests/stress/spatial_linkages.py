"""Random linkages in 3D: trees, rings and chains of all joints, with limits, springs, rotors, friction and motors.

``random_linkage_case(seed)`` is a function of the seed alone; measure.py says what is promised of it.  All joints begin
closed, and a linkage begins to move as one rigid body, so that its rotors are at rest: their energy is not measured.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.spatial import (
    Axis,
    Ball,
    Box,
    Capsule,
    Cylinder,
    Distance,
    Gear,
    Hinge,
    SixAxis,
    Slider,
    Universal,
    Weld,
    Wheel,
)
from tests.solver.spatial.one_kernel import complete

from .cases import Array, Case, Rng, log_uniform, random_options
from .spatial import SpatialBuild, ground, random_turn

CATEGORIES = (
    "free", "hung", "spinning", "heavy end", "limits", "bouncing limits", "springs", "rotors", "friction", "rings",
    "doors", "falling", "motors", "drives",
)  # fmt: skip
DRIVEN = ("motors", "drives")
STEPS = 200
FASTEST_TURN = 0.5  # rad in a timestep
SPREAD = 30.0  # sizes between linkages


def random_linkage_case(seed: int, category: str | None = None) -> Case:
    """The case of a seed, in joint coordinates; its category follows from the seed unless it is given."""
    rng = np.random.default_rng([seed, 7])
    category = CATEGORIES[seed % len(CATEGORIES)] if category is None else category
    options = replace(random_options(rng), articulated=True)
    pull = 0.0 if category in ("free", "spinning") else float(rng.choice([9.81, 9.81, 9.81, 50.0]))
    build = SpatialBuild(
        rng,
        Scene(dim=3, gravity=(0.0, 0.0, -pull)),
        kinds=("box", "capsule", "cylinder"),
        size=log_uniform(rng, 0.05, 1.0),
        friction=(0.2, 0.8),
        restitution=(0.0, 0.0),
        density=(0.3, 3.0),
    )
    if category in ("falling", "drives"):
        ground(build, 40.0 * build.size, walls=False)
    drive = 0.0
    for k in range(int(rng.integers(1, 3))):
        drive = max(drive, _add_linkage(build, category, k, FASTEST_TURN / options.timestep))
    return Case(seed, category, complete(build.scene), options, category in DRIVEN, False, drive)


def _add_linkage(build: SpatialBuild, category: str, k: int, fastest: float) -> float:
    """Add a tree of links that turns with at most `fastest` rad/s; returns the speed in m/s of what drives it."""
    rng, size = build.rng, build.size
    count = int(rng.integers(2, 9))
    root = np.array([SPREAD * size * k, 0.0, size * (2.0 + 2.0 * count * float(rng.uniform(0.3, 1.2)))])
    motion = rng.normal(0.0, 1.0, (2, 3)) * (log_uniform(rng, 0.1, 3.0) if category in ("free", "falling") else 0.0)
    if category == "spinning":
        spin = rng.normal(0.0, log_uniform(rng, 1.0, 50.0), 3)
        motion[1] = spin * min(1.0, fastest / float(np.hypot.reduce(spin)))
    hung = category not in ("free", "spinning", "falling", "drives") and rng.random() < 0.7
    names: list[str] = []
    places: list[Array] = []
    for i in range(count):
        branch = int(rng.integers(max(0, i - 2), i)) if i else -1
        start = places[branch] if i else root
        anchor = start + size * rng.normal(0.0, 0.6, 3)
        middle = anchor + size * rng.normal(0.0, 0.6, 3)
        names.append(f"body_{build.count}")
        places.append(middle)
        mass = {"density": 30.0} if category == "heavy end" and i == count - 1 else {}
        arm = middle - root
        build.add(
            [_link(build, **mass)],
            position=middle.tolist(),
            orientation=random_turn(rng),
            linear_velocity=(motion[0] + np.cross(motion[1], arm)).tolist(),
            angular_velocity=motion[1].tolist(),
        )
        if category == "doors" and i == 1:
            _hang_door(build, k, names[0], names[1], anchor)
        elif i or hung:
            if not i:
                build.scene.add_body(f"hook_{k}", "static", position=root.tolist())
            _add_joint(build, f"joint_{k}_{i}", names[branch] if i else f"hook_{k}", names[-1], anchor, category)
    _close(build, category, k, names, places)
    return size * 20.0 * count


def _link(build: SpatialBuild, **given: Any) -> Any:
    rng, size = build.rng, build.size
    # links meet the ground only: else many would begin inside each other
    common = {**build.material(), "density": log_uniform(rng, *build.density), "category": 2, "mask": 1, **given}
    kind = str(rng.choice(build.kinds))
    half, radius = size * rng.uniform(0.2, 0.6), size * rng.uniform(0.05, 0.3)
    if kind == "capsule":
        return Capsule(half_length=half, radius=radius, **common)
    if kind == "cylinder":
        return Cylinder(half_length=half, radius=radius, **common)
    return Box(half_extents=(size * rng.uniform(0.05, 0.5, 3)).tolist(), **common)


def _add_joint(build: SpatialBuild, name: str, a: str, b: str, anchor: Array, category: str) -> None:
    """Add a joint of a random kind at a point, with what the category asks for."""
    rng = build.rng
    axis, other = _two_axes(rng)
    common: dict[str, Any] = {"anchor": anchor.tolist()}
    servo = _servo(build, category)
    kind = str(rng.choice(["hinge", "hinge", "hinge", "slider", "universal", "ball", "six_axis", "wheel", "weld"]))
    joint: Any = {
        "hinge": lambda: Hinge(a, b, axis=axis, **common, **servo),
        "slider": lambda: Slider(a, b, axis=axis, **common, **_in_metres(servo, build.size)),
        "universal": lambda: Universal(
            a, b, axis_a=axis, axis_b=other, turn_a=Axis(**servo), turn_b=Axis(**_servo(build, category)), **common
        ),
        "ball": lambda: _ball(build, a, b, axis, servo, common, category),
        "six_axis": lambda: _six_axis(build, a, b, common, category),
        "wheel": lambda: Wheel(
            a, b, axis=axis, spin_axis=other, **common,
            **(_in_metres({**servo, "motor_effort": 0.0}, build.size) or {"stiffness": 300.0 * build.size**2}),
        ),
        "weld": lambda: Weld(a, b, **common),
    }[kind]()  # fmt: skip
    build.scene.add_joint(name, joint)
    if category == "drives" and kind == "hinge":
        build.scene.add_actuator(f"{name}_drive", name, mode="position", lower=-1.0, upper=1.0)
    elif category == "motors" and kind == "hinge":
        build.scene.add_actuator(f"{name}_drive", name, mode="velocity", lower=-5.0, upper=5.0)


def _two_axes(rng: Rng) -> tuple[list[float], list[float]]:
    """Return two perpendicular directions."""
    axis = rng.normal(size=3)
    axis /= np.hypot.reduce(axis)
    other = np.cross(axis, rng.normal(size=3))
    return axis.tolist(), (other / np.hypot.reduce(other)).tolist()


def _servo(build: SpatialBuild, category: str) -> dict[str, Any]:
    """Return what an Axis of this category has."""
    rng, size = build.rng, build.size
    inertia = 8.0 * size**5  # of a link, about
    frequency = 2.0 * math.pi * log_uniform(rng, 0.5, 10.0)
    spring = {"stiffness": inertia * frequency**2, "damping": inertia * frequency * log_uniform(rng, 0.01, 2.0)}
    limits = {"limits": tuple(sorted(rng.uniform(-0.8, 0.8, 2).tolist()))}
    limits = {"limits": (min(limits["limits"][0], -0.01), max(limits["limits"][1], 0.01))}
    weight = inertia / size**2 * 9.81 * size
    if category == "limits":
        return limits
    if category == "bouncing limits":
        return limits | {"limit_restitution": float(rng.uniform(0.0, 1.0))}
    if category == "soft limits":
        ratio = float(rng.uniform(0.0, 1.5))
        return limits | {"limit_frequency": log_uniform(rng, 1.0, 30.0), "limit_damping_ratio": ratio}
    if category == "springs":
        return spring
    if category == "rotors":
        return {"armature": inertia * log_uniform(rng, 0.01, 30.0)} | (limits if rng.random() < 0.5 else {})
    if category == "friction":
        return {"friction_effort": weight * log_uniform(rng, 0.01, 10.0)}
    if category == "motors":
        gain = {"motor_gain": inertia * log_uniform(rng, 1.0, 100.0)} if rng.random() < 0.5 else {}
        return {"motor_effort": weight * log_uniform(rng, 0.1, 10.0)} | gain | (limits if rng.random() < 0.5 else {})
    if category == "drives":
        return spring | {"armature": 0.1 * inertia, "spring_effort": weight * log_uniform(rng, 0.3, 10.0)} | limits
    return {}


def _in_metres(servo: dict[str, Any], size: float) -> dict[str, Any]:
    """Return a servo for a translation: stiffness and so on of the same frequency, limits of the same number of
    sizes."""
    scaled = dict(servo)
    for name in ("stiffness", "damping", "armature", "motor_gain"):
        if name in scaled:
            scaled[name] /= size**2
    for name in ("friction_effort", "motor_effort", "spring_effort"):
        if name in scaled:
            scaled[name] /= size
    if "limits" in scaled:
        scaled["limits"] = tuple(size * bound for bound in scaled["limits"])
    return scaled


def _ball(
    build: SpatialBuild, a: str, b: str, axis: list[float], servo: dict[str, Any], common: dict[str, Any], category: str
) -> Ball:
    rng = build.rng
    servo = dict(servo)
    if servo.pop("limits", None) is not None:
        kinds: list[dict[str, Any]] = [
            {"axis": axis, "cone": float(rng.uniform(0.05, 2.5))},
            {"axis": axis, "cone": float(rng.uniform(0.05, 2.5)), "twist": (-0.5, float(rng.uniform(0.05, 2.0)))},
            {"angle": float(rng.uniform(0.05, 2.5))},
        ]
        servo |= kinds[int(rng.integers(3))]
    return Ball(a, b, **common, **servo)


def _six_axis(build: SpatialBuild, a: str, b: str, common: dict[str, Any], category: str) -> SixAxis:
    """Two free rotations or translations, or one of each."""
    rng = build.rng
    axes: dict[str, Any] = {}
    for name in rng.choice(["x", "y", "z", "turn_x", "turn_y", "turn_z"], 2, replace=False):
        servo = _servo(build, category)
        axes[str(name)] = Axis(**(servo if "turn" in name else _in_metres(servo, build.size)))
    return SixAxis(a, b, orientation=random_turn(rng), **axes, **common)


def _hang_door(build: SpatialBuild, k: int, a: str, b: str, anchor: Array) -> None:
    """Connect two bodies by two hinges on one axis."""
    axis = _two_axes(build.rng)[0]
    for number in range(2):
        point = anchor + number * 0.3 * build.size * np.array(axis)
        build.scene.add_joint(f"pin_{k}_{number}", Hinge(a, b, axis=axis, anchor=point.tolist()))


def _close(build: SpatialBuild, category: str, k: int, names: list[str], places: list[Array]) -> None:
    """Close rings, add joints that contradict others, add gears."""
    rng = build.rng
    if category == "rings" and len(names) > 4:  # shorter ones cannot move
        kind = str(rng.choice(["ball", "rod"]))
        middle = (0.5 * (places[0] + places[-1])).tolist()
        joints: dict[str, Any] = {
            "ball": lambda: Ball(names[0], names[-1], anchor=middle),
            "rod": lambda: Distance(names[0], names[-1]),
        }
        build.scene.add_joint(f"ring_{k}", joints[kind]())
    elif category == "contradictory":
        _hang_door(build, k, names[0], names[1], places[1])
    elif category == "motors" and rng.random() < 0.5:
        hinges = [name for name, joint in build.scene.joints.items() if isinstance(joint, Hinge)]
        if len(hinges) > 1:
            try:
                build.scene.add_joint(f"gear_{k}", Gear(hinges[0], hinges[1], ratio=float(rng.uniform(-3.0, 3.0))))
            except ValueError:
                return  # they do not share a body
