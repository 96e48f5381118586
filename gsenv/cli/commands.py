"""`gsenv list`, `train`, `evaluate` and `dataset`."""

import argparse
import importlib
from pathlib import Path

from gsenv.envs import ENVS, PARALLEL_ENVS

from .errors import FAILED, OK, WRONG_USAGE, CliError
from .names import SCENE_PREFIX, check_env, find_actor
from .progress import make_progress


def run_list(options: argparse.Namespace) -> int:
    from gsenv.scenes import SCENES

    rows = [(entry.id, entry.summary) for entry in ENVS]
    rows += [(entry.name, entry.summary) for entry in PARALLEL_ENVS]
    rows += [(f"{SCENE_PREFIX}{name}", spec.summary) for name, spec in SCENES.items()]
    width = max(len(name) for name, _ in rows)
    for name, summary in rows:
        print(f"{name:<{width}}  {summary}")
    return OK


def run_train(options: argparse.Namespace) -> int:
    check_env(options.env)
    arguments = ["--env", options.env, "--seeds", *map(str, options.seeds)]
    arguments += [] if options.steps is None else ["--steps", str(options.steps)]
    arguments += [] if options.out is None else ["--out", str(options.out)]
    arguments += ["--resume"] if options.resume else []
    for name, value in options.set:
        arguments += ["--set", f"{name}={value!r}"]
    script = importlib.import_module(f"gsenv.train.{options.algorithm}")
    return int(script.main(arguments))


def run_evaluate(options: argparse.Namespace) -> int:
    from gsenv.train.evaluate import evaluate

    check_env(options.env)
    actor = find_actor(options.policy, options.env, options.seed)
    try:
        with make_progress() as progress:
            task = progress.add_task(f"{options.env}, {options.episodes} episodes", total=options.episodes)
            result = evaluate(
                actor,
                options.env,
                options.episodes,
                options.seed,
                dict(options.set),
                on_episodes=lambda done: progress.update(task, completed=done),
            )
    except (TypeError, ValueError) as error:  # a bad --set
        raise CliError(str(error), WRONG_USAGE) from error
    print(result)
    return OK


def run_dataset(options: argparse.Namespace) -> int:
    check_env(options.env)
    try:
        from gsenv.train.dataset import make_dataset
        from gsenv.train.evaluate import PolicyError

        name = options.name or f"gsenv/{options.env}/{Path(options.policy).stem}-v0"
        with make_progress() as progress:
            task = progress.add_task(f"{options.env}, {options.episodes} episodes", total=options.episodes)
            dataset = make_dataset(
                options.policy,
                options.env,
                name,
                options.episodes,
                seed=options.seed,
                noise=options.noise,
                arguments=dict(options.set),
                on_episodes=lambda done: progress.update(task, completed=done),
            )
    except ImportError as error:
        raise CliError(f"{error.name} is missing; pip install 'gsenv[dataset]' brings it", FAILED) from error
    except PolicyError as error:
        raise CliError(str(error), FAILED) from error
    except (TypeError, ValueError) as error:  # a bad --set or --name
        raise CliError(str(error), WRONG_USAGE) from error
    except OSError as error:
        raise CliError(f"cannot write the dataset: {error.strerror or error}", FAILED) from error
    print(f"{dataset.spec.dataset_id}: {dataset.total_episodes} episodes, {dataset.total_steps} steps")
    return OK
