"""Random streams of many worlds, drawn from in one call: NumPy's PCG64, bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit

Array = NDArray[Any]

_LOW_HALF = np.uint64(0xFFFFFFFF)
_32 = np.uint64(32)
_MULTIPLIER_HIGH = np.uint64(2549297995355413924)
_MULTIPLIER_LOW = np.uint64(4865540595714422341)
_63 = np.uint64(63)
_64 = np.uint64(64)
_58 = np.uint64(58)
_11 = np.uint64(11)
_UNIT = 2.0**-53


@njit
def _high_product(a, b):  # type: ignore[no-untyped-def]
    """Return the upper 64 bits of the product of two 64-bit numbers."""
    a_low, a_high = a & _LOW_HALF, a >> _32
    b_low, b_high = b & _LOW_HALF, b >> _32
    middle = a_high * b_low + ((a_low * b_low) >> _32)
    other = a_low * b_high + (middle & _LOW_HALF)
    return a_high * b_high + (middle >> _32) + (other >> _32)


@njit
def _draw(words, worlds, out):  # type: ignore[no-untyped-def]
    """Fill row k with uniform numbers in [0, 1) from the stream of worlds[k], as `Generator.random` gives them."""
    for k in range(len(worlds)):
        word = words[worlds[k]]
        high, low, add_high, add_low = word[0], word[1], word[2], word[3]
        for n in range(out.shape[1]):
            high = _high_product(low, _MULTIPLIER_LOW) + high * _MULTIPLIER_LOW + low * _MULTIPLIER_HIGH
            low = low * _MULTIPLIER_LOW + add_low
            high += add_high
            if low < add_low:  # carry
                high += np.uint64(1)
            turn = high >> _58
            mixed = high ^ low
            mixed = (mixed >> turn) | (mixed << ((_64 - turn) & _63))
            out[k, n] = float(mixed >> _11) * _UNIT
        word[0], word[1] = high, low


class Streams:
    """One random stream for each world, equal to the `Generator.random` of a single environment with its seed.

    Attributes:
        words: (world, 4) uint64, the state and the increment of each stream, upper halves first.
    """

    def __init__(self, generators: Sequence[np.random.Generator]) -> None:
        self.words = np.zeros((len(generators), 4), np.uint64)
        for world, generator in enumerate(generators):
            self.seed(world, generator)

    def seed(self, world: int, generator: np.random.Generator) -> None:
        """Set a world's stream to the state of a generator (PCG64, as gymnasium makes them)."""
        state = generator.bit_generator.state["state"]
        numbers = (state["state"], state["inc"])
        self.words[world] = [word for number in numbers for word in divmod(number, 2**64)]

    def draw(self, worlds: Array, out: Array) -> None:
        """Fill (chosen world, number) with uniform numbers in [0, 1)."""
        with np.errstate(over="ignore"):  # said by NumPy where the kernel runs uncompiled
            _draw(self.words, worlds, out)

    def generator(self, world: int) -> np.random.Generator:
        """Return a NumPy generator with the state of a world's stream."""
        high, low, add_high, add_low = self.words[world].tolist()
        bits: Any = np.random.PCG64(0)
        numbers = {"state": high << 64 | low, "inc": add_high << 64 | add_low}
        bits.state = {"bit_generator": "PCG64", "state": numbers, "has_uint32": 0, "uinteger": 0}
        return np.random.Generator(bits)
