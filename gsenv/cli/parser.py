"""The command line: commands and their options."""

import argparse
import ast
from pathlib import Path
from typing import Any, NoReturn

from gsenv import __version__

from .commands import run_dataset, run_evaluate, run_list, run_train, run_warmup
from .errors import WRONG_USAGE, CliError
from .recording import run_record

POLICY_HELP = "random, scripted, trained, or a trained policy's .npz or .zip file"

EXAMPLES = """\
examples:
  gsenv list                                                  all environments and scenes
  gsenv record GStack-v0 --policy scripted --out tower.mp4    an episode as a video
  gsenv train GStack-v0 --seeds 0 1 2                         train with PPO; needs gsenv[train]
  gsenv evaluate GStack-v0 --policy trained --set blocks=3    success rate on 100 unseen episodes
  gsenv record scene:stack --size 1280x720 --out stack.gif    a scene, without a policy
  gsenv dataset GStack-v0 --policy scripted --episodes 100    a Minari dataset; needs gsenv[dataset]
  gsenv warmup                                                compile kernels ahead of time
"""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        raise CliError(f"{message} (see `{self.prog} --help`)", WRONG_USAGE)


def make_parser() -> argparse.ArgumentParser:
    style = argparse.RawDescriptionHelpFormatter
    parser = _Parser(
        prog="gsenv",
        description="Physics environments for reinforcement learning: list, record, train and evaluate.",
        epilog=EXAMPLES,
        formatter_class=style,
    )
    parser.add_argument("--version", action="version", version=f"gsenv {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    list_parser = commands.add_parser("list", help="list all environments and scenes")
    list_parser.set_defaults(run=run_list)

    record = commands.add_parser(
        "record",
        help="run an environment or a scene and write a video",
        description="Run an environment with a policy, or a scene, which needs none, and write a video of it.\n"
        "Ctrl-C stops early and keeps the frames recorded so far.",
        epilog=EXAMPLES,
        formatter_class=style,
    )
    record.add_argument("target", metavar="ENV_OR_SCENE", help="a name from `gsenv list`")
    record.add_argument("--out", required=True, type=Path, metavar="FILE", help="video file, .mp4 or .gif")
    record.add_argument(
        "--policy", type=_policy_name, metavar="POLICY", help=f"policy: {POLICY_HELP} (default: random)"
    )
    _add_set(record)
    record.add_argument("--seed", type=_seed, default=0, help="seed of episode and random policy (default: 0)")
    record.add_argument(
        "--steps",
        type=_positive,
        help="number of control steps; new episodes begin as needed (default: one episode, or the scene's duration)",
    )
    record.add_argument("--size", type=_size, metavar="WxH", help="frame size in pixels (default: 640x480)")
    record.set_defaults(run=run_record)

    train = commands.add_parser(
        "train",
        help="train a policy from scratch",
        description="Train a policy with Stable-Baselines3 and test it on unseen episodes.\n"
        "Ctrl-C stops early and keeps the policy trained so far.",
        epilog=EXAMPLES,
        formatter_class=style,
    )
    train.add_argument("env", metavar="ENV", help="a name from `gsenv list`")
    train.add_argument("--algorithm", choices=("ppo", "sac"), default="ppo", help="learning algorithm (default: ppo)")
    train.add_argument("--steps", type=_positive, help="steps, summed over all worlds (default: the environment's)")
    train.add_argument("--seeds", type=_seed, nargs="+", default=[0], help="seeds, one run each (default: 0)")
    train.add_argument("--resume", action="store_true", help="continue the runs in the output folder")
    train.add_argument("--out", type=Path, metavar="FOLDER", help="output folder (default: runs/ALGORITHM/ENV)")
    _add_set(train)
    train.set_defaults(run=run_train)

    evaluate = commands.add_parser(
        "evaluate",
        help="measure a policy's success on unseen episodes",
        description="Run one episode on each of many seeds of the split 'test', whose episodes training never sees,\n"
        "and print the success rate.",
        epilog=EXAMPLES,
        formatter_class=style,
    )
    evaluate.add_argument("env", metavar="ENV", help="a name from `gsenv list`")
    evaluate.add_argument(
        "--policy", type=_policy_name, default="trained", metavar="POLICY", help=f"{POLICY_HELP} (default: trained)"
    )
    evaluate.add_argument("--episodes", type=_positive, default=100, help="number of episodes (default: 100)")
    evaluate.add_argument("--seed", type=_seed, help="seed of the first episode (default: 0)")
    _add_set(evaluate)
    evaluate.set_defaults(run=run_evaluate)

    dataset = commands.add_parser(
        "dataset",
        help="write episodes of a policy as a Minari dataset",
        description="Run a policy on many seeds of the split 'train' and write all steps as a dataset of Minari,\n"
        "into the folder that MINARI_DATASETS_PATH names, by default ~/.minari/datasets.",
        epilog=EXAMPLES,
        formatter_class=style,
    )
    dataset.add_argument("env", metavar="ENV", help="a name from `gsenv list`")
    dataset.add_argument(
        "--policy", type=_policy_name, default="trained", metavar="POLICY", help=f"{POLICY_HELP} (default: trained)"
    )
    dataset.add_argument("--episodes", type=_positive, default=100, help="number of episodes (default: 100)")
    dataset.add_argument("--seed", type=_seed, default=0, help="seed of the first episode (default: 0)")
    dataset.add_argument(
        "--noise", type=_noise, default=0.0, help="standard deviation of noise added to the actions (default: 0)"
    )
    dataset.add_argument("--name", help="id of the dataset (default: gsenv/ENV/POLICY-v0)")
    _add_set(dataset)
    dataset.set_defaults(run=run_dataset)

    warmup = commands.add_parser(
        "warmup",
        help="compile kernels ahead of time",
        description="Compile the kernels of all environments and 2D scenes, and of one 3D scene, into the cache, so "
        "that later runs start without compiling.",
    )
    warmup.set_defaults(run=run_warmup)
    return parser


def _add_set(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        type=_assignment,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set an argument of the environment, such as blocks=3; may be repeated",
    )


def _assignment(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form NAME=VALUE")
    try:
        return name, ast.literal_eval(value)
    except (SyntaxError, ValueError):
        return name, value  # not a literal: a string


def _policy_name(text: str) -> str:
    if text not in ("random", "scripted", "trained") and not text.endswith((".npz", ".zip")):
        raise argparse.ArgumentTypeError(f"invalid choice: {text!r}; it is {POLICY_HELP}")
    return text


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive whole number")
    return int(text)


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 0")
    return int(text)


def _noise(text: str) -> float:
    try:
        noise = float(text)
    except ValueError:
        noise = -1.0
    if not 0.0 <= noise < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of at least 0")
    return noise


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        return _positive(width), _positive(height)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 640x480") from None
