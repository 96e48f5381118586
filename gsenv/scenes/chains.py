"""Chains, a rope and a plank bridge."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Circle

from .links import Point, add_links, direction, straight
from .palette import AMBER, COOL, HEMP, SAGE, WARM, WOOD

Array = NDArray[np.float64]


def chain(count: int = 20, link: float = 0.25, degrees: float = 30.0, last_mass: float = 1.0) -> Scene:
    """Build a chain that hangs from the origin and is released straight, ``degrees`` from the vertical.

    It has ``count`` uniform rods of length ``link`` m and mass 1 kg; the last one has ``last_mass`` kg.
    """
    scene = Scene()
    scene.add_body("hook", kind="static")
    points = straight((0.0, 0.0), degrees, link, count)
    masses = [1.0] * (count - 1) + [last_mass]
    half_widths = [0.2 * link * mass**0.25 for mass in masses]  # heavier links are drawn thicker
    add_links(scene, points, half_widths, start="hook", masses=masses)
    return scene


def heavy_chain(ratio: float = 100.0) -> Scene:
    """Build a chain of 20 links, released at 30 degrees, whose last link is ``ratio`` times as heavy as the others."""
    return chain(last_mass=ratio)


def hanging_mode(count: int) -> tuple[float, Array]:
    """Return the slowest normal mode of small oscillations of a hanging chain of equal uniform rods.

    Let t be the rods' angles, and c_ik = 1 for rods k above i and 1/2 for k = i. For rods of unit mass and
    length, the kinetic energy is t' M t' / 2 with M = c^T c + 1/12, and the potential energy g t K t / 2 with K
    the diagonal matrix of c's column sums.

    Returns:
        Angular frequency over sqrt(g / length of the chain), and the rods' angles (count,) from the top, scaled
        so that the lowest is 1.
    """
    arms = np.tril(np.ones((count, count)), -1) + 0.5 * np.eye(count)
    inertia = arms.T @ arms + np.eye(count) / 12.0
    scale = 1.0 / np.sqrt(arms.sum(0))
    inverse_squares, modes = np.linalg.eigh(scale[:, None] * inertia * scale)
    shape = scale * modes[:, -1]
    return math.sqrt(count / inverse_squares[-1]), shape / shape[-1]


def hanging_chain(count: int = 10, length: float = 1.0, degrees: float = 0.5) -> Scene:
    """Build a hanging chain of ``count`` equal rods, ``length`` m long in total, in its slowest normal mode.

    It is released at rest with the lowest rod ``degrees`` from the vertical. The closed form of its motion holds
    for small angles.
    """
    scene = Scene()
    scene.add_body("hook", kind="static")
    link = length / count
    points: list[Point] = [(0.0, 0.0)]
    for share in hanging_mode(count)[1]:
        x, y = direction(degrees * float(share))
        points.append((points[-1][0] + link * x, points[-1][1] + link * y))
    add_links(scene, points, 0.015 * length, start="hook", masses=[1.0] * count)
    return scene


def rope(count: int = 36, link: float = 0.2, radius: float = 1.0, offset: float = 0.4) -> Scene:
    """Build a rope that falls onto a static drum of ``radius`` m and drapes over it.

    It has ``count`` links of ``link`` m; its midpoint starts ``offset`` m to the right of the drum's centre.
    """
    scene = Scene()
    drum = Circle(radius=radius, friction=0.8)
    scene.add_body("drum", kind="static", shapes=[drum])
    left = (offset - 0.5 * count * link, radius + 1.5 * link)
    points = straight(left, 90.0, link, count)
    add_links(scene, points, 0.3 * link, friction=0.8, damping=0.05, drag=0.4, colors=HEMP)
    return scene


def plank_bridge(count: int = 14, span: float = 8.4, slack: float = 0.03, loads: int = 4) -> Scene:
    """Build a bridge of ``count`` hinged planks between two cliffs, and ``loads`` boxes of 0.8 m that fall onto it.

    The cliffs are ``span`` m apart; the bridge is (1 + ``slack``) times as long.
    """
    scene = Scene()
    half = 0.5 * span
    for side, x in (("left", -half - 4.0), ("right", half + 4.0)):
        cliff = Box(half_extents=(4.0, 3.0), friction=0.6)
        scene.add_body(f"cliff_{side}", kind="static", shapes=[cliff], position=(x, -3.0))
    add_links(
        scene,
        _sagging(count, span, slack),
        0.1,
        start="cliff_left",
        end="cliff_right",
        name="plank",
        density=2.0,
        friction=0.6,
        damping=0.05,
        colors=WOOD,
    )
    for k in range(loads):
        box = Box(half_extents=(0.4, 0.4), density=2.0, friction=0.6)
        position = (1.1 * (k - 0.5 * (loads - 1)), 1.2 + 0.8 * k)
        color = (WARM, AMBER, SAGE, COOL)[k % 4]
        scene.add_body(f"box_{k}", shapes=[box], position=position, angle=0.4 * k, color=color)
    return scene


def _sagging(count: int, span: float, slack: float) -> list[Point]:
    """Return the ends of ``count`` equal links on a circular arc through (-span/2, 0) and (span/2, 0).

    The links are (1 + slack) span long in total.
    """
    # bisection for a, half the arc's angle: on a unit circle the links' total length is 2 count sin(a/count), and
    # the span 2 sin(a)
    low, high = 1e-9, math.pi
    for _ in range(60):
        a = 0.5 * (low + high)
        low, high = (a, high) if count * math.sin(a / count) < (1.0 + slack) * math.sin(a) else (low, a)
    radius = 0.5 * span / math.sin(a)
    angles = a * np.linspace(-1.0, 1.0, count + 1)
    return [(radius * math.sin(t), radius * (math.cos(a) - math.cos(t))) for t in angles]
