import re

import numpy as np
import pytest

from gsenv.envs.core.spec_tables import Entry, RewardTerm, box_of, entry_table, fill_docstring, reward_table
from gsenv.envs.stack import scene, settings
from gsenv.envs.stack import shared_rules as rules

ENTRIES = (Entry("how far", "distance", -2.5, 3, "m"), Entry("yes or no", "flag", 0, 1))


def test_box_has_the_bounds_of_the_entries() -> None:
    box = box_of(ENTRIES)
    assert box.dtype == np.float32
    np.testing.assert_array_equal(box.low, np.array([-2.5, 0], np.float32))
    np.testing.assert_array_equal(box.high, np.array([3, 1], np.float32))


def test_entry_table_has_one_aligned_row_an_entry() -> None:
    lines = entry_table("Observation", ENTRIES).split("\n")
    assert lines[0] == "| Num | Observation | Min  | Max | Name     | Unit |"
    assert lines[2] == "| 0   | how far     | -2.5 | 3   | distance | m    |"
    assert lines[3] == "| 1   | yes or no   | 0    | 1   | flag     | -    |"
    assert len({len(line) for line in lines}) == 1


def test_reward_table() -> None:
    assert "| fall | -2 when it falls |" in reward_table([RewardTerm("fall", "-2 when it falls")])


def test_fill_docstring_keeps_the_indent_and_other_braces() -> None:
    class Documented:
        """Text {table} in a line.

        {table}
        {unknown}
        """

    doc = fill_docstring(Documented, table="a\nb").__doc__
    assert doc is not None
    assert "        a\n        b\n        {unknown}" in doc
    assert "Text {table} in a line." in doc


@pytest.mark.parametrize("heading", [
    "Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End",
    "Arguments", "Version History",
])  # fmt: skip
def test_docstring_of_the_env_is_its_specification(heading: str) -> None:
    from gsenv.envs.stack.env import StackEnv, StackTask

    doc = StackEnv.__doc__
    assert doc is not None
    assert f"## {heading}\n" in doc
    assert not re.search(r"\{\w+\}", doc)  # every placeholder is filled
    for entry in (*StackTask.actions, *StackTask.observations):
        assert f"| {entry.name} " in doc
    for term in StackTask.reward_terms:
        assert f"| {term.name} " in doc


@pytest.mark.parametrize(
    "text",
    [
        f"a body of {scene.GRIPPER_MASS:g} kg",
        f"at most {scene.MAX_FORCE:g} N along each axis and {scene.MAX_TORQUE:g} N m",
        f"slower than {rules.REST_SPEED:g} m/s and {1.5 * rules.REST_SPEED:g} rad/s",
        f"{100 * rules.ARRIVAL_MARGIN:g} cm wider than the block",
        f"within {scene.REACH_X:g} m of the middle, between {scene.REACH_Y[0]:g} and "
        f"{scene.REACH_Y[1]:g} m high, and within {scene.REACH_ANGLE:g} rad",
        f"up to {scene.START_X:g} m left or right",
        f"{scene.START_Y[0]:g} to {scene.START_Y[1]:g} m high",
        f"| m, of blocks: (lowest, highest), within 0.1 to 0.4 | {scene.HALF_WIDTH} |",
        f"| m, of blocks: (lowest, highest), within 0.05 to 0.25 | {scene.HALF_HEIGHT} |",
        f"| kg, of blocks: (lowest, highest), within 0.5 to 20 | {scene.MASS} |",
        f"| coefficient, of blocks: (lowest, highest), within 0 to 1 | {scene.FRICTION} |",
        f"of its half-width, within 0 to 0.8 | {scene.GRASP_OFFSET:g} |",
        f"| rad, how far a block is tilted in the gripper, within 0 to 0.5 | {scene.GRASP_TILT:g} |",
        f"| m/s, of the slowest impact that cracks a block, within 0.05 to 100 | {settings.CRACK_SPEED:g} |",
        f"tilted by more than {rules.TIPPED:g} rad",
        f"s that the whole tower must stand, within 0.1 to 10 | {settings.SUCCESS_TIME}",
    ],
)
def test_docstring_agrees_with_the_constants(text: str) -> None:
    from gsenv.envs.stack.env import StackEnv

    assert text in " ".join((StackEnv.__doc__ or "").split())
