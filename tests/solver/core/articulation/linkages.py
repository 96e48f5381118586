"""Linkages with one degree of freedom, and their motion by Lagrange's equation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Prismatic, Revolute

Array = np.ndarray[Any, Any]
G = 9.81
PINS = np.array([[0.0, 0.0], [0.3, 0.4], [1.2, 0.9], [1.0, 0.0]])  # m, of the four-bar linkage


def add_bar(scene: Scene, name: str, one: Any, other: Any, mass: float = 1.0) -> None:
    """A thin uniform bar between two points."""
    a, b = np.array(one, float), np.array(other, float)
    length = float(np.linalg.norm(b - a))
    angle = float(np.arctan2(b[1] - a[1], b[0] - a[0]))
    shape = Capsule(half_length=0.5 * length, radius=0.02, mask=0)
    inertia = mass * length * length / 12.0
    scene.add_body(name, shapes=[shape], position=0.5 * (a + b), angle=angle, mass=mass, inertia=inertia)


def four_bar() -> Scene:
    """Three uniform bars of 1 kg between two fixed pins; the joint at ``c`` closes the loop."""
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("frame", "static")
    for name, a, b in (("crank", 0, 1), ("coupler", 1, 2), ("rocker", 2, 3)):
        add_bar(scene, name, PINS[a], PINS[b])
    scene.add_joint("a", Revolute("frame", "crank", anchor=PINS[0]))
    scene.add_joint("b", Revolute("crank", "coupler", anchor=PINS[1]))
    scene.add_joint("c", Revolute("coupler", "rocker", anchor=PINS[2]))
    scene.add_joint("d", Revolute("rocker", "frame", anchor=PINS[3]))
    return scene


def four_bar_poses(turn: float) -> Array:
    """(3, 3): x, y and angle of the bars with the crank ``turn`` rad from its initial pose."""
    crank, coupler, rocker = (float(np.linalg.norm(PINS[k + 1] - PINS[k])) for k in range(3))
    angle = np.arctan2(*PINS[1][::-1]) + turn
    b = crank * np.array([np.cos(angle), np.sin(angle)])
    apart = PINS[3] - b
    d = float(np.hypot(*apart))
    along = (coupler**2 - rocker**2 + d * d) / (2.0 * d)
    across = np.sqrt(coupler**2 - along * along)
    u = apart / d
    c = b + along * u + across * np.array([-u[1], u[0]])
    ends = (np.zeros(2), b, c, PINS[3])
    rows = []
    for k in range(3):
        way = ends[k + 1] - ends[k]
        rows.append([*(0.5 * (ends[k] + ends[k + 1])), np.arctan2(way[1], way[0])])
    return np.array(rows)


def slider_crank() -> Scene:
    """A crank of 0.3 m, a rod of 1 m and a piston on the x axis, 1 kg each; the joint ``wrist`` closes the loop."""
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("frame", "static")
    x, y = 0.3 * np.cos(1.0), 0.3 * np.sin(1.0)
    wrist = (x + np.sqrt(1.0 - y * y), 0.0)
    add_bar(scene, "crank", (0.0, 0.0), (x, y))
    add_bar(scene, "rod", (x, y), wrist)
    scene.add_body("piston", shapes=[Box(half_extents=(0.1, 0.05), mask=0)], position=wrist, mass=1.0)
    scene.add_joint("pin", Revolute("frame", "crank", anchor=(0.0, 0.0)))
    scene.add_joint("guide", Prismatic("frame", "piston", axis=(1.0, 0.0), anchor=wrist))
    scene.add_joint("elbow", Revolute("crank", "rod", anchor=(x, y)))
    scene.add_joint("wrist", Revolute("rod", "piston", anchor=wrist))
    return scene


def slider_crank_poses(turn: float) -> Array:
    x, y = 0.3 * np.cos(1.0 + turn), 0.3 * np.sin(1.0 + turn)
    way = np.sqrt(1.0 - y * y)
    return np.array(
        [[0.5 * x, 0.5 * y, 1.0 + turn], [x + 0.5 * way, 0.5 * y, np.arctan2(-y, way)], [x + way, 0.0, 0.0]]
    )


def turn_after(poses: Callable[[float], Array], inertias: Array, seconds: float, steps: int) -> float:
    """Return the turn of the crank, from rest, of bodies of 1 kg: I q'' + I' q'^2 / 2 + V' = 0, by Runge and Kutta."""
    e = 1e-5

    def slopes(q: float) -> tuple[float, float]:
        d = (poses(q + e) - poses(q - e)) / (2.0 * e)
        return float((d[:, :2] ** 2).sum() + (inertias * d[:, 2] ** 2).sum()), float(G * d[:, 1].sum())

    def rate(y: Array) -> Array:
        inertia, pull = slopes(y[0])
        bend = (slopes(y[0] + e)[0] - slopes(y[0] - e)[0]) / (2.0 * e)
        return np.array([y[1], -(0.5 * bend * y[1] ** 2 + pull) / inertia])

    y = np.zeros(2)
    h = seconds / steps
    for _ in range(steps):
        k = rate(y)
        m = rate(y + 0.5 * h * k)
        n = rate(y + 0.5 * h * m)
        y = y + h / 6.0 * (k + 2.0 * m + 2.0 * n + rate(y + h * n))
    return float(y[0])


def ring(count: int = 20) -> Scene:
    """A closed chain of bars of 0.1 m and 0.1 kg, pinned at its top."""
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("frame", "static")
    turns = 2.0 * np.pi * np.arange(count) / count
    pins = 0.05 / np.sin(np.pi / count) * np.stack([np.sin(turns), -np.cos(turns)], -1)
    for k in range(count):
        add_bar(scene, f"bar_{k}", pins[k], pins[(k + 1) % count], mass=0.1)
    for k in range(count):
        scene.add_joint(f"joint_{k}", Revolute(f"bar_{k}", f"bar_{(k + 1) % count}", anchor=pins[(k + 1) % count]))
    scene.add_joint("top", Revolute("frame", f"bar_{count // 2}", anchor=pins[count // 2]))
    return scene
