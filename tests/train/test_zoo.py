import pytest

from gsenv.envs import ENVS
from gsenv.train import zoo


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_files_for_rl_zoo_are_those_of_the_settings(algorithm: str) -> None:
    content = zoo.path(algorithm).read_text()
    assert content == zoo.text(algorithm), "run python -m gsenv.train.zoo"
    for entry in ENVS:
        assert f"\n{entry.id}:\n  normalize: true\n" in content
