"""Shared by the training scripts: the command line, and training and testing of one seed after another.

Each seed has its own folder, and a new run begins in none that holds one. Its files are replaced atomically, those of a
checkpoint together, so they are complete and fit one another at any time:

    policy.npz       the policy with its observation normalisation, which needs only numpy to run
    best.npz         the same as it was at the best evaluation so far
    policy.zip, normalize.npz   the same for Stable-Baselines3; `--resume` continues from them
    progress.csv     a row every `log_every` steps; TensorBoard events are written too if it is installed
    settings.json    the settings of the run
    origin.json      version, commit and processor
    result.json      success and return on unseen seeds, after the run
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from gsenv.envs import PARALLEL_ENVS
from gsenv.envs.core.policies import named_task
from gsenv.train.arguments import (
    Parser,
    add_set_option,
    check_env_id,
    check_training,
    not_negative,
    positive,
)
from gsenv.train.checkpoint import AS_TRAINED, COLUMNS, NORMALIZE, check_folder
from gsenv.train.evaluate import TEST_SEED, PolicyError, evaluate, make_actor
from gsenv.train.files import read_rows, reason, write_json
from gsenv.train.origin import write_origin
from gsenv.train.progress import counting, make_progress
from gsenv.train.run import Run, Settings, save

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecEnv, VecNormalize

OK, FAILED, INTERRUPTED = 0, 1, 130


@dataclass(frozen=True)
class Experiment:
    """An algorithm: its settings for each environment, how to build its model, and what wraps the worlds for it."""

    name: str
    settings_for: Callable[[str], Settings]
    make_model: Callable[[Any, VecNormalize], BaseAlgorithm]
    wrap: Callable[[Any, VecEnv], VecEnv] = lambda _, envs: envs


class Linear:
    """A learning rate that decreases linearly from `start`, but not below the fraction `end_share` of it."""

    def __init__(self, start: float, end_share: float = 0.05) -> None:
        self.start = start
        self.end_share = end_share

    def __call__(self, progress_remaining: float) -> float:
        return self.start * max(progress_remaining, self.end_share)


def main(experiment: Experiment, arguments: Sequence[str] | None = None, prog: str | None = None) -> int:
    """Train the seeds that the command line asks for; return the exit code. Messages begin with `prog`."""
    prog = prog or experiment.name
    settings, seeds, folder, resume = _parse(experiment, arguments, prog)
    try:
        import stable_baselines3  # noqa: F401
        import torch
    except ImportError as error:
        print(f"{prog}: {error.name} is missing; pip install 'gsenv[train]' brings it.", file=sys.stderr)
        return FAILED
    torch.set_num_threads(settings.torch_threads)
    try:
        for seed in seeds:  # all of them before the first one trains
            check_folder(_seed_folder(folder, seed), asdict(settings), resume)
        for seed in seeds:
            code = run_seed(experiment, replace(settings, seed=seed), _seed_folder(folder, seed), resume)
            if code != OK:
                return code
        from gsenv.train.curve import plot

        plot(folder)
    except KeyboardInterrupt:  # before the first checkpoint, or during the test
        print(f"{prog}: interrupted", file=sys.stderr)
        return INTERRUPTED
    except (OSError, TypeError, ValueError) as error:  # a full disk, a bad argument of the environment
        print(f"{prog}: {reason(error)}", file=sys.stderr)
        return FAILED
    print(f"the learning curves are in {folder / 'curve.png'}")
    return OK


def _seed_folder(folder: Path, seed: int) -> Path:
    return folder / f"seed-{seed}"


def _parse(
    experiment: Experiment, arguments: Sequence[str] | None, prog: str
) -> tuple[Settings, list[int], Path, bool]:
    parser = Parser(prog=prog, description=f"Train {experiment.name.upper()}.")
    parser.add_argument("--env", default="GStack-v0", help="id of the environment (default: %(default)s)")
    parser.add_argument("--steps", type=positive, help="steps, summed over all worlds (default: the environment's)")
    parser.add_argument("--seeds", type=not_negative, nargs="+", default=[0], help="seeds, one run each (default: 0)")
    parser.add_argument("--resume", action="store_true", help="continue the runs in the output folder")
    parser.add_argument("--out", type=Path, help=f"output folder (default: runs/{experiment.name}/ENV)")
    add_set_option(parser)
    given = parser.parse_args(arguments)
    check_env_id(parser, given.env)
    own = dict(given.set)
    try:
        check_training(given.env, given.seeds, own)
    except (TypeError, ValueError) as error:
        parser.error(str(error))
    name, own = named_task(given.env.rpartition(":")[2], own)
    settings = experiment.settings_for(name)
    settings = with_arguments(replace(settings, env=name, steps=given.steps or settings.steps), own)
    folder = given.out or Path("runs") / experiment.name / name
    return settings, given.seeds, folder, given.resume


def with_arguments(settings: Settings, own: dict[str, Any]) -> Settings:
    """Return settings where these arguments of the environment hold in all lessons and in the tests."""
    lessons = [{name: value for name, value in lesson.items() if name not in own} for lesson in settings.lessons]
    lessons = [lesson for k, lesson in enumerate(lessons) if lesson and lesson not in lessons[k - 1 : k]]
    own = {name: value for name, value in own.items() if name != "split"}  # evaluations have the other one
    tests = [test | own for test in settings.tests]
    tests = [test for k, test in enumerate(tests) if test not in tests[:k]]
    return replace(settings, arguments=settings.arguments | own, lessons=tuple(lessons), tests=tuple(tests))


def run_seed(experiment: Experiment, settings: Settings, folder: Path, resume: bool = False) -> int:
    """Train and test one seed; return the exit code."""
    run = prepare(experiment, settings, folder, resume)
    began, before = perf_counter(), run.steps
    finished = train(run)
    rate = (run.steps - before) / (perf_counter() - began)
    how = "trained" if finished else "interrupted after"
    print(f"seed {settings.seed}: {how} {run.steps} steps, {rate:.0f}/s; the policy is in {folder / 'policy.npz'}")
    if not finished:
        return INTERRUPTED
    write_json(folder / "result.json", test(run))
    return OK


def prepare(experiment: Experiment, settings: Settings, folder: Path, resume: bool = False) -> Run:
    """Return a new run or, with `resume`, the run that the folder's files hold, if there are any.

    A run that continues begins new episodes and draws other random numbers, so it differs from one that never stopped.

    Raises:
        ValueError: without `resume`, the folder holds a run; else its files are broken, of other settings, or pickles.
    """
    from stable_baselines3.common.vec_env import VecNormalize

    from gsenv.train.export import load_normalize, refuse_pickle, restore

    if resume:
        refuse_pickle(folder / "policy.zip")
    saved = check_folder(folder, asdict(settings), resume)
    envs = experiment.wrap(settings, make_envs(settings))
    rows: list[dict[str, Any]] = []
    if saved:
        normalize = load_normalize(folder / NORMALIZE, envs, gamma=settings.discount)
        model = experiment.make_model(settings, normalize)
        restore(model, folder / "policy.zip")
        model.set_random_seed(_first_seed(settings.seed, model.num_timesteps))  # else its first exploration repeats
        if (folder / "progress.csv").is_file():
            known = read_rows(folder / "progress.csv", COLUMNS)
            rows = [dict(row) for row in known if row["steps"] <= model.num_timesteps]
    else:
        normalize = VecNormalize(envs, gamma=settings.discount)
        model = experiment.make_model(settings, normalize)
    normalize.seed(_first_seed(settings.seed, model.num_timesteps))  # after the model, which seeds its worlds as well
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / "settings.json", asdict(settings))
    write_origin(folder)
    return Run(settings, folder, model, normalize, rows)


def make_envs(settings: Settings) -> Any:
    """Return the batch of worlds as a VecEnv."""
    from stable_baselines3.common.env_util import make_vec_env

    from gsenv.adapters.sb3 import BatchedVecEnv
    from gsenv.adapters.sb3_agents import AgentVecEnv

    if settings.env in {entry.name for entry in PARALLEL_ENVS}:  # all agents learn one policy
        return AgentVecEnv(settings.env, settings.world_count, **settings.arguments)
    env_id = settings.env if ":" in settings.env else f"gsenv:{settings.env}"
    return make_vec_env(
        env_id,
        n_envs=settings.world_count,
        vec_env_cls=BatchedVecEnv,  # type: ignore[arg-type]
        env_kwargs={"render_mode": None, **settings.arguments},
    )


def _first_seed(seed: int, steps: int) -> int:
    """Return the first world's seed, from which the others count on; evaluations have a split of their own.

    It is drawn, so that other runs, and this one when it is continued, play other episodes.
    """
    return int(np.random.SeedSequence((seed, steps)).generate_state(1)[0])


def train(run: Run) -> bool:
    """Train with a progress bar; return False if Ctrl-C ended it. The policy is saved in any case."""
    from gsenv.train.watcher import Watcher

    left = run.settings.steps - run.steps
    finished = True
    if left > 0:
        run.model.set_logger(_logger(run.folder))
        with make_progress(transient=False) as progress:
            watcher = Watcher(run, progress)
            try:
                run.model.learn(left, callback=watcher, reset_num_timesteps=False)
            except KeyboardInterrupt:
                finished = False
            watcher.finish(evaluates=finished)  # an evaluation takes seconds, too long for Ctrl-C
    save(run)
    return finished


def test(run: Run) -> dict[str, Any]:
    """Evaluate the policy on unseen seeds, and the scripted and random ones for comparison; print and return it."""
    results = {}
    count = run.settings.test_episodes
    files = {"trained": run.folder / "policy.npz", "best": run.folder / "best.npz"}
    for name, arguments, kind in _tests(run.settings):
        if kind == "best" and not files[kind].is_file():
            continue  # there was no evaluation
        try:
            actor = make_actor(str(files.get(kind, kind)), run.settings.env, arguments=arguments)
        except PolicyError:
            continue  # not every environment has a scripted policy
        with counting(f"testing: {name}, {kind}", count) as follow:
            result = evaluate(actor, run.settings.env, count, TEST_SEED, arguments, follow)
        results[f"{name}: {kind}"] = asdict(result)
        print(f"  {name}, {kind}: {result}")
    return results


def _tests(settings: Settings) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yield name, arguments of the environment, and kind of policy of each test."""
    for arguments in settings.tests:
        name = ", ".join(f"{key} {value}" for key, value in arguments.items()) or "default"
        for kind in ("trained", "best", "scripted", "random"):
            yield name, arguments, kind
    for kind in ("scripted", "random"):  # beside the learning curves
        yield AS_TRAINED, settings.arguments, kind


def _logger(folder: Path) -> Any:
    from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat

    try:
        return Logger(str(folder), [TensorBoardOutputFormat(str(folder / "tensorboard"))])
    except AssertionError:  # tensorboard is not installed
        return Logger(str(folder), [])
