"""What counts as a number in the arguments of an environment is the same in all of them."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from gsenv.envs import ENVS
from gsenv.envs.core.arguments import number, numbers
from gsenv.envs.core.policies import make_batch
from gsenv.envs.tower_v0 import parallel_env

NO_NUMBERS = ["0.5", True, None, np.nan, 10**400, 0.5 + 0j, np.array(0.5), np.array([0.5]), [0.5], b"1"]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: repr(value)[:12])
def test_texts_truth_values_and_arrays_are_no_numbers(value: Any) -> None:
    assert number(value) is None


@pytest.mark.parametrize("value", [1, 0.5, np.float32(0.5), np.int64(2)])
def test_numbers_of_numpy_are_numbers(value: Any) -> None:
    assert number(value) == value
    assert numbers((value, value)) == numbers([value, value]) == numbers(np.array([value, value])) == (value, value)


@pytest.mark.parametrize("values", ["12", 1.0, np.array(0.5), np.ones((2, 2)), {1.0, 2.0}, (1.0, "2"), None])
def test_what_is_no_vector_has_no_numbers(values: Any) -> None:
    assert numbers(values) == ()


@pytest.mark.parametrize("entry", ENVS, ids=lambda entry: str(entry.id))
def test_no_setting_takes_a_text_or_an_array_for_a_number(entry: Any) -> None:
    task = make_batch(entry.id, 1).task
    settings = [s for s in task.arguments if s.name not in ("task", "reward_weights")]
    for setting in settings:
        for wrong in (str(setting.default), np.array(0.5), np.zeros((2, 2)), 10**400):
            with pytest.raises(ValueError, match=f"^{setting.name} must be") as error:
                make_batch(entry.id, 1, **{setting.name: wrong})
            assert "\n" not in str(error.value)
            assert len(str(error.value)) < 300
    for quantity in task.quantities:
        with pytest.raises(ValueError, match=f"^randomize: {quantity.name} must be a pair"):
            make_batch(entry.id, 1, randomize={quantity.name: "12"})


@pytest.mark.parametrize("blocks", [4.0, True, "4", np.array([2, 4]), 5, 10**400])
def test_blocks_of_two_grippers_are_a_whole_number(blocks: Any) -> None:
    with pytest.raises(ValueError, match="blocks must be 2, 4, 6 or 8, got"):
        parallel_env(blocks=blocks)


def test_a_near_name_is_a_question() -> None:
    with pytest.raises(TypeError, match=r"did you mean 'blocks'\? was raised"):
        gymnasium.make("gsenv:GStack-v0", block=3)
