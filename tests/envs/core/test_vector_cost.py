"""A vector step runs the same Python code however many worlds there are."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from types import FrameType
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gsenv.solver.api import interrupts
from tests.envs.registered import EACH_TASK, MODES, make_vector, random_actions

LIMIT = 3


def count_instructions(function: Callable[[], Any]) -> tuple[int, Any]:
    """Bytecodes that Python runs, in all functions: a loop cannot hide in one line. And the result."""
    count = 0

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal count
        frame.f_trace_opcodes = True
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        result = function()
    finally:
        sys.settrace(before)
    return count, result


def test_the_counter_sees_loops() -> None:
    def loop(count: int) -> list[int]:
        return [v + 1 for v in range(count)]

    assert count_instructions(partial(loop, 50))[0] > count_instructions(partial(loop, 1))[0] + 49


def instructions(env_id: str, mode: AutoresetMode, count: int) -> tuple[list[int], list[int]]:
    """Of a few steps without and with ended episodes, sorted; growing buffers come before."""
    vector = make_vector(env_id, count, autoreset_mode=mode, max_episode_steps=LIMIT, diagnostics=True)
    vector.reset(seed=0)
    quiet: list[int] = []
    ending: list[int] = []
    for k, actions in enumerate(random_actions(env_id, 0, 10 * LIMIT + 10, count)):
        actions = np.tile(actions[:1], (count, 1))
        done = vector.finished
        spent, result = count_instructions(partial(vector.step, actions))
        ended = result[2] | result[3]
        if k > LIMIT:
            (ending if ended.any() or done.any() else quiet).append(spent)
        if mode == AutoresetMode.DISABLED and ended.any():
            mask = {"reset_mask": ended}
            ending.append(count_instructions(partial(vector.reset, options=mask))[0])
    return sorted(quiet), sorted(ending)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_instructions_do_not_grow_with_the_worlds(
    env_id: str, mode: AutoresetMode, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interrupts, "BLOCK_SECONDS", 1e9)  # blocks of steps would follow the load of the machine
    few, many = instructions(env_id, mode, 4), instructions(env_id, mode, 64)
    assert len(few[0]) == len(many[0])
    assert len(few[1]) == len(many[1]) > 5
    # The same steps one by one but for those in which the batch of 64 outgrows its buffers.
    for one, other in zip(few, many, strict=True):
        assert one[0] == other[0]
        assert abs(np.median(other) - np.median(one)) < 60  # a loop over 60 further worlds takes more
