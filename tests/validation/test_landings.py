"""Impacts without restitution of bodies that stand on something else: they happen at their own time in the step."""

from __future__ import annotations

import math
from typing import Any

import pytest

from gsenv.solver import Options, Scene, World, planar, spatial

G = 9.81


def tilted_block(dim: int, half_width: float, ratio: float, angle: float) -> World:
    """A block, ``ratio`` times as high as it is wide, that stands on one corner (2D) or edge (3D) without sliding."""
    half_height = ratio * half_width
    height = half_width * math.sin(angle) + half_height * math.cos(angle)
    scene = Scene(dim=dim)
    if dim == 2:
        scene.add_body("ground", "static", shapes=[planar.HalfPlane(friction=4.0)])
        flat = planar.Box(half_extents=(half_width, half_height), friction=4.0)
        scene.add_body("block", shapes=[flat], position=(0.0, height), angle=angle)
    else:
        scene.add_body("ground", "static", shapes=[spatial.Plane(friction=4.0)])
        solid = spatial.Box(half_extents=(half_width, 0.3, half_height), friction=4.0)
        turn = (math.cos(0.5 * angle), 0.0, -math.sin(0.5 * angle), 0.0)
        scene.add_body("block", shapes=[solid], position=(0.0, 0.0, height), orientation=turn)
    return World(scene, options=Options(sleep=False))


def tilt(world: World) -> float:
    if world.model.dim == 2:
        return float(world.angle[0, 1])
    q: Any = world.orientation[0, 1]
    return float(-2.0 * math.atan2(q[2], q[0]))


def energies_at_impacts(world: World, rest: float, count: int) -> list[tuple[float, float]]:
    """Return the energies above ``rest`` before and after the steps in which the block changes its corner."""
    found: list[tuple[float, float]] = []
    before, last = float(world.diagnostics().energy[0]) - rest, tilt(world)
    for _ in range(400):
        world.step()
        after, now = float(world.diagnostics().energy[0]) - rest, tilt(world)
        if now * last < 0.0:
            found.append((before, after))
        if len(found) == count:
            break
        before, last = after, now
    return found


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("ratio", "tolerance"), [(4.0, 0.02), (2.0, 0.035)])
@pytest.mark.parametrize("lean", [0.5, 0.55, 0.6, 0.65, 0.7])
def test_rocking_block_loses_the_energy_of_housner(dim: int, ratio: float, tolerance: float, lean: float) -> None:
    """Kept in an impact: (1 - 3/2 sin^2 alpha)^2, tan alpha = width over height (Housner, BSSA 53, 1963)."""
    alpha = math.atan(1.0 / ratio)
    kept = (1.0 - 1.5 * math.sin(alpha) ** 2) ** 2
    world = tilted_block(dim, 0.25, ratio, lean * alpha)
    rest = float(world.parameters.mass[0, 1]) * G * 0.25 * ratio
    impacts = energies_at_impacts(world, rest, 3 if ratio > 3.0 else 2)
    assert len(impacts) >= 2
    for before, after in impacts:
        assert after / before == pytest.approx(kept, abs=tolerance)


def fall_of_dominoes(dim: int, rate: int) -> float:
    """Seconds until the last of 20 dominoes of 2 x 10 cm, 5 cm apart, leans by 0.3 rad; the first starts to tip."""
    scene = Scene(dim=dim)
    ground = planar.HalfPlane(friction=0.4) if dim == 2 else spatial.Plane(friction=0.4)
    scene.add_body("ground", "static", shapes=[ground])
    for k in range(20):
        x = 0.05 * k
        if dim == 2:
            scene.add_body(f"d{k}", shapes=[planar.Box(half_extents=(0.01, 0.05), friction=0.4)], position=(x, 0.05))
        else:
            piece = spatial.Box(half_extents=(0.01, 0.03, 0.05), friction=0.4)
            scene.add_body(f"d{k}", shapes=[piece], position=(x, 0.0, 0.05))
    world = World(scene, options=Options(timestep=1.0 / rate))
    if dim == 2:
        world.set_velocity("d0", linear=(0.2, 0.0), angular=-4.0)
    else:
        world.set_velocity("d0", linear=(0.2, 0.0, 0.0), angular=(0.0, 4.0, 0.0))
    for _ in range(3 * rate):
        world.step()
        lean = world.angle[0, -1] if dim == 2 else 2.0 * math.acos(min(1.0, abs(world.orientation[0, -1, 0])))
        if abs(lean) > 0.3:
            break
    return float(world.time[0])


@pytest.mark.parametrize("dim", [2, 3])
def test_dominoes_fall_as_fast_as_at_small_timesteps(dim: int) -> None:
    assert fall_of_dominoes(dim, 60) == pytest.approx(fall_of_dominoes(dim, 960), rel=0.01)
