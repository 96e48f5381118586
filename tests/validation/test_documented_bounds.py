"""What README and docs/method.md claim, well inside the tolerances of the reference scenes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gsenv.scenes import mass_ratio_stack, pyramid, stack
from gsenv.scenes.spatial import cube_pyramid
from gsenv.solver import Options, Scene, World


@pytest.mark.parametrize(
    ("scene", "bound"),
    [(stack(50), 1e-4), (mass_ratio_stack(1000.0), 2e-5), (pyramid(10), 1e-5)],
    ids=["tower of 50", "1000 kg on 1 kg", "pyramid"],
)
def test_overlap_and_height(scene: Scene, bound: float) -> None:
    world = World(scene, options=Options(sleep=False))
    start = world.position[0]
    world.step(600)
    assert world.diagnostics().penetration[0] < bound
    assert np.abs(world.position[0] - start)[1:, 1].max() < 50 * bound


@pytest.mark.parametrize("build", [pyramid, cube_pyramid])
@pytest.mark.parametrize(("fidelity", "speed", "overlap"), [("balanced", 1e-4, 1e-5), ("fast", 3e-3, 3e-4)])
def test_large_pyramids_come_to_rest(
    build: Callable[[int], Scene], fidelity: str, speed: float, overlap: float
) -> None:
    """210 boxes; swept alone those in space jittered at 3 cm/s with "fast" and did not converge."""
    world = World(build(20), options=Options.preset(fidelity, sleep=False))
    for _ in range(3):
        world.step(60)
    assert np.abs(world.linear_velocity).max() < speed
    assert world.diagnostics().penetration[0] < overlap
    sleepy = World(build(20), options=Options.preset(fidelity))
    sleepy.step(180)
    assert sleepy.asleep[0, 1:].all()
