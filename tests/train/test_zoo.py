from gsenv.envs import ENVS
from gsenv.train import zoo


def test_the_file_for_rl_zoo_is_that_of_the_settings() -> None:
    content = zoo.PATH.read_text()
    assert content == zoo.text(), "run python -m gsenv.train.zoo"
    for entry in ENVS:
        assert f"\n{entry.id}:\n  normalize: true\n" in content
