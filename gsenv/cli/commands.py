"""`gsenv list`, `train`, `evaluate` and `dataset`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.envs.core.policies import named_task
from gsenv.train.arguments import check_training

from .errors import FAILED, OK, WRONG_USAGE, CliError
from .interrupts import say
from .names import SCENE_PREFIX, check_env, find_actor
from .progress import counting, make_progress

if TYPE_CHECKING:
    from minari import MinariDataset


def run_list(options: argparse.Namespace) -> int:
    from gsenv.scenes import SCENES

    rows = [(entry.id, entry.summary) for entry in ENVS]
    rows += [(entry.name, entry.summary) for entry in PARALLEL_ENVS]
    rows += [(f"{SCENE_PREFIX}{name}", spec.summary) for name, spec in SCENES.items()]
    width = max(len(name) for name, _ in rows)
    say("\n".join(f"{name:<{width}}  {summary}" for name, summary in rows))
    return OK


def run_train(options: argparse.Namespace) -> int:
    from gsenv.train import ppo

    check_env(options.env)
    try:
        check_training(options.env, options.seeds, dict(options.set))
    except (TypeError, ValueError) as error:
        raise CliError(str(error), WRONG_USAGE) from error
    arguments = ["--env", options.env, "--seeds", *map(str, options.seeds)]
    arguments += [] if options.steps is None else ["--steps", str(options.steps)]
    arguments += [] if options.out is None else ["--out", str(options.out)]
    arguments += ["--resume"] if options.resume else []
    for name, value in options.set:
        arguments += ["--set", f"{name}={value!r}"]
    return ppo.main(arguments, "gsenv train")


def run_evaluate(options: argparse.Namespace) -> int:
    from gsenv.train.evaluate import evaluate

    check_env(options.env)
    actor = find_actor(options.policy, options.env, options.seed, dict(options.set))
    try:
        with counting(f"{options.env}, {options.episodes} episodes", options.episodes) as follow:
            result = evaluate(actor, options.env, options.episodes, options.seed, dict(options.set), follow)
    except (TypeError, ValueError) as error:  # a bad --set
        raise CliError(str(error), WRONG_USAGE) from error
    say(str(result))
    return OK


def run_dataset(options: argparse.Namespace) -> int:
    from gsenv.train.files import reason

    check_env(options.env)
    try:
        dataset = _make_dataset(options)
    except ImportError as error:
        raise CliError(f"{error.name} is missing; pip install 'gsenv[dataset]' brings it", FAILED) from error
    except (TypeError, ValueError) as error:  # a bad --set or --name
        raise CliError(str(error), WRONG_USAGE) from error
    except OSError as error:
        raise CliError(f"cannot write the dataset: {reason(error)}", FAILED) from error
    say(f"{dataset.spec.dataset_id}: {dataset.total_episodes} episodes, {dataset.total_steps} steps")
    return OK


def _make_dataset(options: argparse.Namespace) -> "MinariDataset":
    """Make the dataset with a bar for its episodes, and one for those of its reference scores."""
    from gsenv.train.dataset import make_dataset
    from gsenv.train.evaluate import PolicyError

    env_id, _ = named_task(options.env, dict(options.set))
    default = f"gsenv/{env_id}/{Path(options.policy).stem}-v0"
    with make_progress() as progress:
        task = progress.add_task(f"{options.env}, {options.episodes} episodes", total=options.episodes)
        scores = progress.add_task("reference scores of random, scripted and trained", total=None, visible=False)
        try:
            return make_dataset(
                options.policy,
                options.env,
                default if options.name is None else options.name,
                options.episodes,
                seed=options.seed,
                noise=options.noise,
                arguments=dict(options.set),
                on_episodes=lambda done: progress.update(task, completed=done),
                on_scores=lambda done, count: progress.update(scores, completed=done, total=count, visible=True),
            )
        except PolicyError as error:
            raise CliError(str(error), FAILED) from error
