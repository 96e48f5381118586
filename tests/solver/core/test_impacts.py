"""Many impacts in one island: no ball waits for another's."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Circle, HalfPlane

G = 9.81


@pytest.mark.parametrize("count", [10, 70])
def test_elastic_balls_that_share_an_island_bounce_exactly(count: int) -> None:
    """Neighbours 1 mm apart are contacts to come, so all are one island; they never touch."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(friction=0.3)])
    start = 0.2 + 0.0005 * (np.arange(count) % 7)  # they land one after another within a substep
    for k in range(count):
        ball = Circle(radius=0.1, restitution=1.0, friction=0.3)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0.201 * k, 0.1 + start[k]))
    world = World(scene, options=Options(sleep=False))
    impacts = 0
    for _ in range(20):
        world.step()
        impacts += int(world.diagnostics().impacts[0])
        height = world.position[0, 1:, 1] - 0.1
        energy = G * height + 0.5 * world.linear_velocity[0, 1:, 1] ** 2
        np.testing.assert_allclose(energy, G * start, rtol=1e-9)
        assert world.diagnostics().penetration[0] < 1e-12
    assert impacts >= count
    assert world.diagnostics().islands[0] == 1
