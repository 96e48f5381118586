"""Random streams of many worlds against NumPy's own generators."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.utils import seeding

from gsenv.envs.core.streams import Streams


def numbers(streams: Streams, worlds: list[int], count: int) -> np.ndarray:
    out = np.full((len(worlds), count), np.nan)
    streams.draw(np.array(worlds, np.intp), out)
    return out


@pytest.mark.nojit
def test_numbers_are_numpys() -> None:
    generators = [seeding.np_random(seed)[0] for seed in (0, 1, 2**40, 12345)]
    streams = Streams(generators)
    for worlds, count in (([0, 1, 2, 3], 300), ([2], 7), ([3, 0], 5), ([0, 1, 2, 3], 40)):
        expected = [generators[w].random(count) for w in worlds]
        np.testing.assert_array_equal(numbers(streams, worlds, count), expected)


@pytest.mark.nojit
def test_extreme_states_are_numpys() -> None:
    """Carries of every kind: words of all ones and all zeros."""
    words = (0, 1, 2**64 - 1, 2**63, 2**32 - 1, 2**32)
    bits: Any = np.random.PCG64(0)
    generator = np.random.Generator(bits)
    streams = Streams([generator])
    for high in words:
        for low in words:
            for add in (1, 2**64 - 1, 2**128 - 1):
                state = {"state": high << 64 | low, "inc": add}
                bits.state = {"bit_generator": "PCG64", "state": state, "has_uint32": 0, "uinteger": 0}
                streams.seed(0, generator)
                np.testing.assert_array_equal(numbers(streams, [0], 6)[0], generator.random(6))


def test_generator_is_a_copy() -> None:
    original = seeding.np_random(5)[0]
    streams = Streams([original, seeding.np_random(6)[0]])
    copied = streams.generator(0)
    assert copied.bit_generator.state == original.bit_generator.state
    copied.random(3)
    np.testing.assert_array_equal(numbers(streams, [0], 4)[0], original.random(4))
