"""Splits of the seeds: scenes to train on, and scenes that training never sees."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.utils import seeding

SPLITS = ("train", "test")
TEST_KEY = 0x67736E76  # the word that the split "test" adds to a seed
MOST_SEED = 2**128 - 1  # larger seeds have a fifth word of their own, which could be TEST_KEY


def check_same_split(saved: str, own: str) -> None:
    """Raise ValueError unless a snapshot is of the split of the environment that is to restore it."""
    if saved != own:
        raise ValueError(f"restore: the snapshot is of the split {saved!r}, this environment is of {own!r}.")


def check_split(split: Any) -> str:
    if not isinstance(split, str) or split not in SPLITS:
        raise ValueError(f"split must be one of {list(SPLITS)}, got {split!r}.")
    return split


def make_generator(seed: int | None, split: str) -> tuple[np.random.Generator, int]:
    """Return the random generator of a seed in a split, and the seed.

    "train" gives Gymnasium's generator, `PCG64(SeedSequence(seed))`. "test" gives
    `PCG64(SeedSequence(seed, spawn_key=(TEST_KEY,)))`, the method by which NumPy makes streams that are independent
    of one another: no seed gives in one split the stream that some seed gives in the other.

    Args:
        seed: 0 to 2**128 - 1, or None for entropy of the operating system.

    Raises:
        ValueError: a larger seed.
        gymnasium.error.Error: a seed that is no whole number, or negative.
    """
    if isinstance(seed, np.integer):  # Gymnasium's generator takes Python's only, its vector environments both
        seed = int(seed)
    if isinstance(seed, int) and seed > MOST_SEED:
        raise ValueError(f"reset: a seed must be below 2**128, got {seed}.")
    generator, used = seeding.np_random(seed)
    if split == "test":
        sequence = np.random.SeedSequence(used, spawn_key=(TEST_KEY,))
        generator = np.random.Generator(np.random.PCG64(sequence))
    return generator, used
