"""Minari datasets: episodes of a policy, for offline learning and imitation; needs minari."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from gsenv import __version__
from gsenv.envs import PARALLEL_ENVS
from gsenv.envs.core.policies import make_batch
from gsenv.envs.core.spec_tables import box_of
from gsenv.files import terminable
from gsenv.train.evaluate import SPLIT, Actor, PolicyError, evaluate, make_actor

if TYPE_CHECKING:
    from minari import MinariDataset

BATCH = 128  # largest number of episodes that run side by side
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
        noise: standard deviation of Gaussian noise that is added to the actions, which are then clipped.
        arguments: of the environment, such as {"blocks": 3}.
        on_episodes: called with the number of episodes that have ended, at each step.

    Raises:
        ImportError: Minari is not installed.
        PolicyError: there is no such policy, or it does not fit the environment.
        ValueError: several agents, a bad or existing name, or a bad value in `arguments`.
        TypeError: an unknown name in `arguments`.
        OSError: the dataset cannot be written; nothing of it is left.
    """
    import minari
    from minari.dataset.minari_dataset import parse_dataset_id
    from minari.storage.datasets_root_dir import get_dataset_path

    if env_id in (entry.name for entry in PARALLEL_ENVS):
        raise ValueError(f"{env_id} has several agents, and a Minari dataset has one.")
    parse_dataset_id(name)  # raises ValueError
    folder = Path(get_dataset_path(name))
    if folder.exists():
        raise ValueError(f"there already is a dataset {name}; `minari delete {name}` deletes it.")
    arguments = dict(arguments or {})
    if arguments.get("observation", "state") != "state":
        raise ValueError("the policies of gsenv observe the state, so a dataset needs observation='state'.")
    actor = make_actor(policy, env_id, seed)
    episodes = list(run_episodes(actor, env_id, episode_count, seed, noise, arguments, on_episodes))
    lowest, highest = reference_scores(env_id, arguments)
    with terminable():
        try:
            return minari.create_dataset_from_buffers(
                name,
                [_buffer(episode) for episode in episodes],
                env=gymnasium.make(f"gsenv:{env_id}", **arguments),
                eval_env=gymnasium.make(f"gsenv:{env_id}", **arguments | {"split": SPLIT}),
                algorithm_name=f"{policy}, noise {noise}" if noise else policy,
                author="gsenv",
                author_email="-",
                code_permalink=f"gsenv {__version__}",
                description=f"Episodes of {env_id} from seed {seed} on; see gsenv.train.dataset.",
                ref_min_score=lowest,
                ref_max_score=highest,
                num_episodes_average_score=SCORED_EPISODES,
                requirements=[f"gsenv=={__version__}"],
            )
        except BaseException:  # a full disk or Ctrl-C: half a dataset could neither be loaded nor overwritten
            rmtree(folder, ignore_errors=True)
            raise


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
    generator = np.random.default_rng(seed)

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


def reference_scores(env_id: str, arguments: Mapping[str, Any]) -> tuple[float, float]:
    """Return the mean returns of random actions and of the best policy that comes with gsenv, on the split "test"."""
    given = {name: value for name, value in arguments.items() if name != "split"}
    returns = []
    for policy in ("random", "scripted", "trained"):
        try:
            actor = make_actor(policy, env_id)
        except PolicyError:  # there is none
            continue
        returns.append(evaluate(actor, env_id, SCORED_EPISODES, arguments=given).mean_return)
    return returns[0], max(returns)
