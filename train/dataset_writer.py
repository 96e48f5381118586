"""The process that writes a Minari dataset: a full disk may crash h5py, and then it crashes this process alone.

    python -m gsenv.train.dataset_writer

Reads pickles from its parent, `make_dataset`: the arguments of `write`, then each episode. Answers on stdout with
nothing, or with the error in JSON.
"""

from __future__ import annotations

import json
import os
import pickle
import re
import sys
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

if TYPE_CHECKING:
    from gsenv.train.dataset import Episode


def main() -> None:
    """Write what comes on stdin, and leave without Python's clean-up, in which h5py frees what it could not write."""
    code = 1
    try:
        job = pickle.load(sys.stdin.buffer)
        write([pickle.load(sys.stdin.buffer) for _ in range(job.pop("episode_count"))], **job)
        code = 0
    except BaseException as error:
        json.dump({"errno": _number(error), "message": str(error).strip().partition("\n")[0]}, sys.stdout)
        sys.stdout.flush()
    os._exit(code)


def write(
    episodes: list[Episode], env_id: str, name: str, arguments: dict[str, Any], split: str, texts: dict[str, Any]
) -> None:
    """Write a dataset into the folder that MINARI_DATASETS_PATH names, and see whether it can be read."""
    import minari

    minari.create_dataset_from_buffers(
        name,
        [_buffer(episode) for episode in episodes],
        env=gymnasium.make(f"gsenv:{env_id}", **arguments),
        eval_env=gymnasium.make(f"gsenv:{env_id}", **arguments | {"split": split}),
        **texts,
    )
    found = sum(len(episode.rewards) for episode in minari.load_dataset(name).iterate_episodes())
    if found != sum(len(episode.rewards) for episode in episodes):
        raise OSError(f"only {found} steps could be read again")


def _buffer(episode: Episode) -> Any:
    from minari.data_collector import EpisodeBuffer

    last = np.arange(len(episode.rewards)) == len(episode.rewards) - 1
    return EpisodeBuffer(
        seed=episode.seed,
        observations=episode.observations,
        actions=episode.actions,
        rewards=list(episode.rewards),
        terminations=last & episode.terminated,
        truncations=last & (not episode.terminated),
        infos=episode.infos,
    )


def _number(error: BaseException) -> int | None:
    """Return the errno of an error, which h5py gives in the text alone."""
    if isinstance(error, OSError) and error.errno:
        return error.errno
    found = re.search(r"errno = (\d+)", str(error))
    return int(found[1]) if found else None


if __name__ == "__main__":
    main()
