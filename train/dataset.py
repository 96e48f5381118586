"""Minari datasets: episodes of a policy, for offline learning and imitation; needs minari."""

from __future__ import annotations

import errno
import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gsenv import __version__
from gsenv.envs import PARALLEL_ENVS
from gsenv.envs.core.policies import make_batch, named_task
from gsenv.envs.core.spec_tables import box_of
from gsenv.files import terminable
from gsenv.train.arguments import check_episodes
from gsenv.train.evaluate import SPLIT, Actor, PolicyError, evaluate, make_actor

if TYPE_CHECKING:
    from minari import MinariDataset

BATCH = 128  # largest number of episodes that run side by side
MOST_NOISE = 100.0
ALMOST_FULL = 2**20  # bytes that are left on a disk
SCORED_EPISODES = 100  # of the split "test", whose mean returns are the reference scores


@dataclass(frozen=True)
class Episode:
    """One episode of T steps.

    `reset(seed=seed)` of the single environment and these actions give the same observations and rewards, bit for bit.
    """

    seed: int
    observations: NDArray[np.float32]  # (T + 1, entry); the first is that of the reset
    actions: NDArray[np.float32]  # (T, entry)
    rewards: NDArray[np.float64]  # (T,)
    terminated: bool  # else truncated by the time limit
    infos: dict[str, NDArray[Any]]  # (T + 1,) each: success, the terms of the reward and so on


def make_dataset(
    policy: str,
    env_id: str,
    name: str,
    episode_count: int = 100,
    *,
    seed: int = 0,
    noise: float = 0.0,
    arguments: Mapping[str, Any] | None = None,
    on_episodes: Callable[[int], None] = lambda ended: None,
    on_scores: Callable[[int, int], None] = lambda ended, all_of_them: None,
) -> MinariDataset:
    """Run a policy on the seeds `seed` .. `seed + episode_count - 1` and write all steps as a Minari dataset.

    The reference scores of Minari's normalised score are mean returns on the split "test": of random actions, and of
    the better of the scripted and the trained policy that come with gsenv.

    Args:
        policy: "trained", "scripted", "random", or an .npz or .zip file.
        env_id: of an environment of one agent, such as "GStack-v0".
        name: id of the dataset, such as "gsenv/GStack-v0/scripted-v0"; there must be none of this name yet.
        episode_count: number of episodes.
        seed: of the first episode, in the split "train" unless `arguments` say otherwise.
        noise: standard deviation of Gaussian noise that is added to the actions, which are then clipped; at most 100.
        arguments: of the environment, such as {"blocks": 3}.
        on_episodes: called with the number of episodes that have ended, at each step.
        on_scores: called, at each step of the episodes for the reference scores that follow, with the number of those
            that have ended, and of all of them.

    Raises:
        ImportError: Minari is not installed.
        PolicyError: there is no such policy, or it does not fit the environment.
        ValueError: several agents, a bad or existing name, a bad noise, or a bad value in `arguments`.
        TypeError: an unknown name in `arguments`.
        OSError: the dataset cannot be written; nothing of it is left.
    """
    import minari
    from minari.dataset.minari_dataset import parse_dataset_id
    from minari.storage.datasets_root_dir import get_dataset_path

    import_module("h5py")  # of Minari's storage: missed before the episodes are run
    if env_id in (entry.name for entry in PARALLEL_ENVS):
        raise ValueError(f"{env_id} has several agents, and a Minari dataset has one.")
    if not 0.0 <= noise <= MOST_NOISE:
        raise ValueError(f"noise must be 0 to {MOST_NOISE:g}, got {noise!r}: actions lie within -1 and 1.")
    try:
        parse_dataset_id(name)
    except (TypeError, ValueError) as error:  # TypeError: it has no version
        raise ValueError(f"a dataset is named like gsenv/{env_id}/own-v0, not {name!r}.") from error
    if Path(get_dataset_path(name)).exists():
        raise ValueError(f"there already is a dataset {name}; `minari delete {name}` deletes it.")
    env_id, arguments = named_task(env_id, arguments or {})
    check_episodes(arguments, "a dataset")
    actor = make_actor(policy, env_id, seed, arguments)
    episodes = list(run_episodes(actor, env_id, episode_count, seed, noise, arguments, on_episodes))
    lowest, highest = reference_scores(env_id, arguments, on_scores)
    texts = {
        "algorithm_name": f"{policy}, noise {noise}" if noise else policy,
        "author": "gsenv",
        "author_email": "-",
        "code_permalink": f"gsenv {__version__}",
        "description": f"Episodes of {env_id} from seed {seed} on; see gsenv.train.dataset.",
        "ref_min_score": lowest,
        "ref_max_score": highest,
        "num_episodes_average_score": SCORED_EPISODES,
        "requirements": [f"gsenv=={__version__}"],
    }
    job = {"env_id": env_id, "name": name, "arguments": arguments, "split": SPLIT, "texts": texts}
    root = Path(get_dataset_path())
    with terminable(), tempfile.TemporaryDirectory(dir=root, prefix=".gsenv-", ignore_cleanup_errors=True) as made:
        _write(job, episodes, Path(made))
        _publish(name, Path(made), root)
    return minari.load_dataset(name)


def _write(job: dict[str, Any], episodes: Sequence[Episode], folder: Path) -> None:
    """Write a dataset into a folder by a process of its own, which a full disk may crash; see dataset_writer.

    Raises:
        OSError: it could not.
    """
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    child = subprocess.Popen(
        [sys.executable, "-P", "-m", "gsenv.train.dataset_writer"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,  # what HDF5 says of each object that it could not write
        env=os.environ | {"MINARI_DATASETS_PATH": str(folder), "PYTHONPATH": path},
    )
    with child:
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            for part in ({**job, "episode_count": len(episodes)}, *episodes):
                pickle.dump(part, child.stdin)
            child.stdin.close()
            answer = child.stdout.read()
        except BrokenPipeError:  # it has ended
            answer = child.stdout.read()
        except BaseException:  # Ctrl-C or SIGTERM
            child.kill()
            raise
    if child.returncode != 0:
        raise _failure(answer, folder.parent)


def _failure(answer: bytes, root: Path) -> OSError:
    """Return the error of a process that has failed, from its answer if it could give one."""
    try:
        said = json.loads(answer)
    except ValueError:  # it crashed
        said = {"errno": errno.ENOSPC if shutil.disk_usage(root).free < ALMOST_FULL else errno.EIO}
    number = said["errno"]
    return OSError(said["message"]) if number is None else OSError(number, os.strerror(number), str(root))


def _publish(name: str, made: Path, root: Path) -> None:
    """Move a dataset from the folder where it was made to its place: the uppermost folder that is new moves whole."""
    for part in Path(name).parts:
        made, root = made / part, root / part
        if not root.exists():
            made.rename(root)
            return
        for file in made.iterdir():  # Minari's metadata of the namespace
            if file.is_file() and not (root / file.name).exists():
                file.rename(root / file.name)
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(root))


def run_episodes(
    actor: Actor,
    env_id: str,
    episode_count: int,
    seed: int = 0,
    noise: float = 0.0,
    arguments: Mapping[str, Any] | None = None,
    on_episodes: Callable[[int], None] = lambda ended: None,
) -> Iterator[Episode]:
    """Run one episode on each of the seeds `seed` .. `seed + episode_count - 1`; arguments as of `make_dataset`."""
    generator = np.random.default_rng((seed, 2))  # not the stream of the episode of this seed

    def act(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        actions = actor(observations)
        return (actions + generator.normal(0.0, noise, actions.shape)).astype(np.float32) if noise else actions

    for first in range(0, episode_count, BATCH):

        def count_ended(ended: int, before: int = first) -> None:
            on_episodes(before + ended)

        yield from _run_batch(
            act, env_id, min(BATCH, episode_count - first), seed + first, arguments or {}, count_ended
        )


def _run_batch(
    act: Actor,
    env_id: str,
    count: int,
    seed: int,
    arguments: Mapping[str, Any],
    on_episodes: Callable[[int], None],
) -> Iterator[Episode]:
    """Run `count` episodes side by side; steps after the end of an episode are dropped."""
    envs = make_batch(env_id, count, **arguments)
    bounds = box_of(envs.task.actions)
    observation, info = envs.reset(seed=seed)
    observations, infos = [observation.copy()], [_entries(info)]
    actions, rewards = [], []
    lengths, terminated = np.zeros(count, np.int64), np.zeros(count, np.bool_)
    running = np.ones(count, np.bool_)
    while running.any():
        action = np.clip(act(observation), bounds.low, bounds.high)
        observation, reward, ends, truncates, info = envs.step(action)
        observations.append(observation.copy())
        infos.append(_entries(info))
        actions.append(action)
        rewards.append(reward.copy())
        lengths += running
        terminated |= running & ends
        running &= ~(ends | truncates)
        on_episodes(int(count - running.sum()))
    envs.close()
    for w, length in enumerate(lengths):
        yield Episode(
            seed=seed + w,
            observations=np.array([o[w] for o in observations[: length + 1]]),
            actions=np.array([a[w] for a in actions[:length]]),
            rewards=np.array([r[w] for r in rewards[:length]]),
            terminated=bool(terminated[w]),
            infos={key: np.array([i[key][w] for i in infos[: length + 1]]) for key in infos[0]},
        )


def _entries(info: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Return a copy of the numbers of a batch's info, without the masks that Gymnasium adds."""
    return {key: value.copy() for key, value in info.items() if not key.startswith("_") and f"_{key}" in info}


def reference_scores(
    env_id: str,
    arguments: Mapping[str, Any],
    on_scores: Callable[[int, int], None] = lambda ended, all_of_them: None,
) -> tuple[float, float]:
    """Return the mean returns of random actions and of the best policy that comes with gsenv, on the split "test"."""
    given = {name: value for name, value in arguments.items() if name != "split"}
    actors = []
    for policy in ("random", "scripted", "trained"):
        with suppress(PolicyError):  # there is none
            actors.append(make_actor(policy, env_id, arguments=arguments))
    returns = []
    for k, actor in enumerate(actors):

        def count_ended(ended: int, before: int = k * SCORED_EPISODES) -> None:
            on_scores(before + ended, len(actors) * SCORED_EPISODES)

        scores = evaluate(actor, env_id, SCORED_EPISODES, arguments=given, on_episodes=count_ended)
        returns.append(scores.mean_return)
    return returns[0], max(returns)
