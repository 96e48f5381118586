"""Two slender bodies welded at an angle tumble as the one body that they form, in body coordinates too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Box, Capsule, Weld

SPIN = np.array([6.0, 1.0, 3.0])  # rad/s
PLACE = np.array([0.3, 0.1, 0.2])  # m, of the second body
TURN = (np.cos(0.55), 0.0, np.sin(0.55) / 1.09**0.5, 0.3 * np.sin(0.55) / 1.09**0.5)
TIME = 0.5  # s


def rod(length: float, **place: Any) -> Capsule:
    return Capsule(half_length=length, radius=0.05, density=100.0, **place)


def tumbled(timestep: float, stiffness: float = 0.0) -> tuple[Any, float, float]:
    """(rotation of the first body, gain of energy, of it that in the springs, both over that of the start)."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    scene.add_body("a", shapes=[rod(0.3)], angular_velocity=SPIN)
    velocity = np.cross(SPIN, PLACE)
    scene.add_body(
        "b", shapes=[rod(0.2)], position=PLACE, orientation=TURN, linear_velocity=velocity, angular_velocity=SPIN
    )
    weld = Weld("a", "b", anchor=tuple(0.5 * PLACE), stiffness=stiffness, damping=1e-3 * stiffness)
    scene.add_joint("weld", weld)
    world = World(scene, options=Options(timestep=timestep, articulated=False, sleep=False))
    start = float(world.diagnostics().energy[0])
    stored = 0.0
    for _ in range(round(TIME / timestep)):
        world.step()
        stored = max(stored, float(world.diagnostics().spring_energy[0]))
    gain = float(world.diagnostics().energy[0]) - start
    return world.state.bodies["rotation"][0, 0].copy(), gain / start, stored / start


def one_body() -> Any:
    """The rotation of one body of both shapes, whose free rotation is exact."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    shapes = [rod(0.3), rod(0.2, position=PLACE, orientation=TURN)]
    scene.add_body("both", shapes=shapes, angular_velocity=SPIN)
    world = World(scene)
    world.step(round(60 * TIME))
    return world.state.bodies["rotation"][0, 0].copy()


def angle_between(a: Any, b: Any) -> float:
    return 2.0 * float(np.arccos(min(1.0, abs(float(a @ b)))))


def test_a_weld_is_of_second_order() -> None:
    """Before its rows knew how the bodies' own inertia turns their velocities, it was of first: 7 % of energy lost."""
    exact = one_body()
    errors = [angle_between(tumbled(1.0 / rate)[0], exact) for rate in (60, 120, 240)]
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] > 3.0
    assert errors[1] / errors[2] > 3.0
    assert abs(tumbled(1.0 / 60.0)[1]) < 1e-3


def test_springs_too_stiff_to_resolve_store_little() -> None:
    """What they store are errors of the rotations within a substep: it falls with the fourth power of the timestep."""
    _, gain, stored = tumbled(1.0 / 240.0, 1e6)
    assert gain < 2e-3  # 1e-2 before
    assert tumbled(1.0 / 120.0, 1e6)[2] > 10.0 * stored > 0.0


@pytest.mark.parametrize(
    ("spin", "stiffness", "timestep"), [(1000.0, 1e4, 1 / 60), (300.0, 1e2, 1 / 20), (300.0, 1e6, 1 / 20)]
)
def test_spins_beyond_what_a_substep_resolves_stay_bounded(spin: float, stiffness: float, timestep: float) -> None:
    """With all of the change by the bodies' own inertia in the rows, the energy grew to 1e26 times the first."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
        direction = rng.normal(size=3)
        for name in ("a", "b"):
            shape = Box(half_extents=rng.uniform(0.05, 0.4, 3).tolist())
            w = spin * direction / np.sqrt(direction @ direction)
            scene.add_body(name, shapes=[shape], mass=1.0, angular_velocity=w, orientation=rng.normal(size=4))
        scene.add_joint("weld", Weld("a", "b", stiffness=stiffness, damping=1e-3 * stiffness))
        world = World(scene, options=Options(timestep=timestep, sleep=False))
        start = float(world.diagnostics().energy[0])
        for _ in range(150):
            world.step()
            assert world.diagnostics().kinetic_energy[0] < 10.0 * start
