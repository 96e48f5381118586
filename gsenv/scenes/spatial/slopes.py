"""Sliding, rolling and tipping on planes that slope in any direction."""

from __future__ import annotations

from gsenv.solver import Scene
from gsenv.solver.spatial import Box, Cylinder, Plane, Sphere

from .stacks import ground
from .turning import UPRIGHT, along, level, lying, rolling_axle, uphill_normal


def block_on_incline(
    degrees: float = 35.0,
    heading: float = 0.0,
    turn: float = 0.0,
    friction: float = 0.5,
    half_extents: tuple[float, float, float] = (0.25, 0.25, 0.1),
) -> Scene:
    """Build a box at rest on a plane that slopes down by ``degrees``, in the direction ``heading`` degrees from x.

    The box is rotated on the plane by ``turn`` degrees.
    """
    scene = Scene(dim=3)
    normal = uphill_normal(degrees, heading)
    scene.add_body("slope", kind="static", shapes=[Plane(normal=normal, friction=friction)])
    scene.add_body(
        "box",
        shapes=[Box(half_extents=half_extents, friction=friction)],
        position=along((0.0, 0.0, 0.0), half_extents[2], normal),
        orientation=lying(degrees, heading, turn),
    )
    return scene


def _round(kind: str, radius: float, friction: float) -> Sphere | Cylinder:
    if kind == "sphere":
        return Sphere(radius=radius, friction=friction)
    return Cylinder(radius=radius, half_length=0.4 * radius, friction=friction)


def roller_on_incline(
    kind: str = "sphere", degrees: float = 20.0, heading: float = 0.0, radius: float = 0.5, friction: float = 0.5
) -> Scene:
    """Build a "sphere" or a "cylinder" at rest on a plane that slopes down by ``degrees`` towards ``heading``."""
    scene = Scene(dim=3)
    normal = uphill_normal(degrees, heading)
    scene.add_body("slope", kind="static", shapes=[Plane(normal=normal, friction=friction)])
    scene.add_body(
        kind,
        shapes=[_round(kind, radius, friction)],
        position=along((0.0, 0.0, 0.0), radius, normal),
        orientation=UPRIGHT if kind == "sphere" else rolling_axle(heading),
    )
    return scene


def sliding_roller(
    kind: str = "sphere", speed: float = 3.0, friction: float = 0.3, radius: float = 0.5, heading: float = 0.0
) -> Scene:
    """Build a "sphere" or a "cylinder" that slides without rotation on level ground, until friction makes it roll."""
    scene = Scene(dim=3)
    ground(scene, friction=friction)
    scene.add_body(
        kind,
        shapes=[_round(kind, radius, friction)],
        position=(0.0, 0.0, radius),
        orientation=UPRIGHT if kind == "sphere" else rolling_axle(heading),
        linear_velocity=along((0.0, 0.0, 0.0), speed, level(heading)),
    )
    return scene


def rolling_cylinders(count: int = 5, degrees: float = 12.0) -> Scene:
    """Build cylinders of growing radius that roll down a slope side by side; all arrive together."""
    scene = Scene(dim=3)
    normal = uphill_normal(degrees, 0.0)
    scene.add_body("slope", kind="static", shapes=[Plane(normal=normal, friction=0.6)])
    for k in range(count):
        radius = 0.15 + 0.08 * k
        x, _, z = along((0.0, 0.0, 0.0), radius, normal)
        cylinder = Cylinder(radius=radius, half_length=0.25, friction=0.6)
        position = (x, 0.7 * (k - 0.5 * (count - 1)), z)
        scene.add_body(f"cylinder_{k}", shapes=[cylinder], position=position, orientation=rolling_axle(0.0))
    return scene
