"""What README and docs/method.md claim, well inside the tolerances of the reference scenes."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.scenes import mass_ratio_stack, pyramid, stack
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
