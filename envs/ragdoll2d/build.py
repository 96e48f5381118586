"""GRagdoll2D's scene, from the numbers of scene.py."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsenv.envs.ragdoll2d import scene as numbers
from gsenv.scenes.palette import GRAPHITE, Rgb
from gsenv.solver import Scene
from gsenv.solver.planar import Box, HalfPlane, Polygon, Revolute

TRUNK: Rgb = (236, 230, 218)
NEAR: Rgb = (238, 108, 62)  # limbs
FAR: Rgb = (94, 122, 164)
SHOES: tuple[Rgb, Rgb] = (GRAPHITE, (84, 92, 108))  # near, far
ARROW: Rgb = (206, 44, 58)
CORNERS = 5  # of each rounded end of a limb
HEAD_CORNERS = 10


def build_scene() -> Scene:
    """Return the scene: level ground, the figure upright with all angles 0 and its hips at x = 0."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(category=numbers.GROUND)])
    _add_arrow(scene)
    for body, name in enumerate(numbers.BODIES[numbers.FIRST_PART :], numbers.FIRST_PART):
        scene.add_body(name, shapes=_shapes(body), position=_origin(body), color=_color(name))
    for axis in numbers.JOINTS:
        parent, child = numbers.BODIES[axis.parent], numbers.BODIES[axis.child]
        joint = Revolute(
            parent, child, anchor_a=axis.anchor, anchor_b=(0.0, 0.0), limits=axis.limits, rest=axis.stand,
            stiffness=axis.stiffness, damping=numbers.DAMPING * axis.stiffness, spring_effort=axis.effort,
        )  # fmt: skip
        scene.add_joint(axis.name, joint)
    for axis in numbers.AXES:
        scene.add_actuator(axis.name, axis.name, mode="position")
    return scene


def _origin(body: int) -> tuple[float, float]:
    """Return the place in m of a body's own frame in the upright figure."""
    axis = next((axis for axis in numbers.JOINTS if axis.child == body), None)
    if axis is None:  # the pelvis
        return 0.0, numbers.ANKLE + numbers.SHIN + numbers.THIGH
    x, y = _origin(axis.parent)
    return x + axis.anchor[0], y + axis.anchor[1]


def _color(name: str) -> Rgb:
    side, _, part = name.rpartition("_")
    if not side:
        return TRUNK
    if part == "foot":
        return SHOES[side == "far"]
    return NEAR if side == "near" else FAR


def _shapes(body: int) -> list[Any]:
    """Return the shapes of a part of the figure, each with the density that gives it its mass."""
    n = numbers
    if body in n.FEET:
        return [_solid(n.FOOT_MASS, _foot())]
    if body in (n.NEAR_SHIN, n.FAR_SHIN):
        return [_solid(n.SHIN_MASS, _limb((0.0, 0.0), 0.052, (0.0, -n.SHIN), 0.036))]
    if body in (n.NEAR_THIGH, n.FAR_THIGH):
        return [_solid(n.THIGH_MASS, _limb((0.0, 0.0), 0.078, (0.0, -n.THIGH), 0.055))]
    if body in (n.NEAR_ARM, n.FAR_ARM):
        bend = 0.115, -0.52  # the wrist: the elbow is a little bent
        upper = _limb((0.0, 0.0), 0.045, (0.0, -0.29), 0.036)
        lower = _limb((0.0, -0.29), 0.036, bend, 0.026)
        hand = _limb(bend, 0.034, (0.155, -0.61), 0.026)
        masses = 0.55, 0.32, 0.13
        return [_solid(share * n.ARM_MASS, p) for share, p in zip(masses, (upper, lower, hand), strict=True)]
    if body == n.PELVIS:
        return [_solid(n.PELVIS_MASS, _limb((-0.005, 0.0), 0.095, (0.0, n.WAIST), 0.088))]
    neck = _limb((0.005, n.SHOULDER + 0.03), 0.046, (0.02, n.SHOULDER + 0.13), 0.044)
    chest = _limb((0.0, 0.0), 0.092, (-0.005, n.SHOULDER - 0.05), 0.116)
    head = _limb((0.03, n.SHOULDER + 0.145), 0.076, (0.012, n.CROWN - 0.1), 0.1, HEAD_CORNERS)
    face = n.CROWN - 0.13
    nose = [(0.106, face + 0.025), (0.132, face - 0.022), (0.1, face - 0.026)]
    return [
        _solid(0.1 * n.HEAD_MASS, neck), _solid(n.CHEST_MASS, chest),
        Polygon(vertices=nose, density=0.0, mask=n.NOTHING), _solid(0.9 * n.HEAD_MASS, head),
    ]  # fmt: skip


def _foot() -> list[tuple[float, float]]:
    """Return the outline of a foot around its ankle."""
    n = numbers
    return [
        (n.HEEL, -n.ANKLE), (n.TOE, -n.ANKLE), (n.TOE + 0.006, -n.ANKLE + 0.018), (0.145, -0.018),
        (0.04, 0.028), (0.0, 0.036), (-0.036, 0.028), (n.HEEL - 0.006, -0.018), (n.HEEL - 0.006, -n.ANKLE + 0.018),
    ]  # fmt: skip


def _limb(
    a: tuple[float, float], radius_a: float, b: tuple[float, float], radius_b: float, corners: int = CORNERS
) -> list[tuple[float, float]]:
    """Return the outline of two discs and all between them, with corners on both discs."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    along = math.atan2(dy, dx)
    lean = math.acos((radius_a - radius_b) / math.hypot(dx, dy))  # from the axis to the normals of the common tangents
    points = []
    for (x, y), radius, start, end in (
        (b, radius_b, along - lean, along + lean),
        (a, radius_a, along + lean, along + 2.0 * math.pi - lean),
    ):
        for angle in np.linspace(start, end, corners):
            points.append((x + radius * math.cos(angle), y + radius * math.sin(angle)))
    return points


def _solid(mass: float, outline: list[tuple[float, float]]) -> Polygon:
    """Return a polygon of a mass in kg that meets only the ground."""
    x, y = np.array(outline).T
    area = 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))
    return Polygon(vertices=outline, density=mass / area, category=numbers.FIGURE, mask=numbers.GROUND)


def _add_arrow(scene: Scene) -> None:
    """Add the arrow that shows a push, with its tip at the origin of its frame and its shaft along -x."""
    head, half = numbers.ARROW_HEAD, 0.5 * numbers.ARROW_LENGTH
    shaft = Box(half_extents=(half, 0.2 * head), position=(-0.9 * head - half, 0.0), mask=numbers.NOTHING)
    tip = Polygon(vertices=[(0.0, 0.0), (-head, 0.5 * head), (-head, -0.5 * head)], mask=numbers.NOTHING)
    scene.add_body("arrow", "static", [shaft, tip], position=numbers.PARKED, color=ARROW)
