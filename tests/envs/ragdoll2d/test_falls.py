"""The command that makes the poses in which figures lie."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gsenv.envs import falls
from gsenv.envs.ragdoll2d.env import RagdollVectorEnv


@pytest.mark.slow
def test_it_makes_as_many_poses_as_it_is_asked_for(tmp_path: Path) -> None:
    out = tmp_path / "lying.npz"
    assert falls.main(["--poses", "6", "--out", str(out)]) == 0
    with np.load(out) as made:
        assert {name: array.shape for name, array in made.items()} == {
            "GRagdoll2D-get-up-v0": (6, 10),
            "GRagdoll-get-up-v0": (6, 25),
        }


def test_figures_that_were_thrown_lie_still_and_low() -> None:
    vector = RagdollVectorEnv(12, push=0.0, randomize={})
    lying = falls.fall(vector, 0)
    assert lying.mean() > 0.5
    world = vector.task.world
    pelvis = world.model.body_names.index("pelvis")
    assert (world.state.bodies["position"][lying, pelvis, 1] < falls.LOW).all()
    poses = falls.planar_poses(vector)[lying]
    assert poses.shape[1] == 10
    assert (np.abs(np.sin(poses[:, 0])) > 0.7).all()  # on its back or its front
