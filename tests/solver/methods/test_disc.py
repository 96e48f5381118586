"""Friction on Coulomb's disc against the conditions of its minimum."""

from __future__ import annotations

import numpy as np

from gsenv.solver.methods.disc import minimise_near, minimise_on_disc


def test_on_the_rim_the_impulse_opposes_what_is_left_of_the_slip() -> None:
    """t minimises t.A t/2 + g.t on |t| <= R: on the rim A t + g = -s t with s >= 0, from any vector near or far."""
    rng = np.random.default_rng(0)
    rims = 0
    for _ in range(300):
        root = rng.normal(size=(2, 2)) * 10.0 ** rng.uniform(-2, 2)
        block = root @ root.T + 1e-6 * np.trace(root @ root.T) * np.eye(2)
        side = rng.normal(size=2) * 10.0 ** rng.uniform(-3, 3)
        free = -np.linalg.solve(block, side)
        bound = rng.uniform(0.05, 0.95) * float(np.linalg.norm(free))
        a, c, d = float(block[0, 0]), float(block[0, 1]), float(block[1, 1])
        g, h = float(side[0]), float(side[1])
        exact = np.array(minimise_on_disc(a, c, d, g, h, bound))
        angle = rng.uniform(0.0, 2.0 * np.pi)
        starts = (exact, exact * 0.8, bound * np.array([np.cos(angle), np.sin(angle)]), np.zeros(2))
        for start in starts:
            t = np.array(minimise_near((a, c, d), (g, h), bound, (float(start[0]), float(start[1]))))
            left = block @ t + side
            s = -float(left @ t) / float(t @ t)
            rims += 1
            assert abs(np.linalg.norm(t) - bound) <= 1e-9 * bound
            assert s >= 0.0
            assert np.linalg.norm(left + s * t) <= 1e-6 * (np.linalg.norm(side) + np.linalg.norm(block @ t))
    assert rims == 1200
