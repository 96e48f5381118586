"""The command line: commands and their options."""

import argparse
from pathlib import Path
from typing import NoReturn, TypeAlias

from gsenv import __version__
from gsenv.train.arguments import add_set_option, not_negative, positive

from .commands import run_dataset, run_evaluate, run_list, run_train
from .compilation import run_pack, run_warmup
from .errors import WRONG_USAGE, CliError
from .recording import run_record
from .replaying import run_replay
from .viewing import run_play, run_view

POLICY_HELP = "zero, random, scripted, trained, or a trained policy's .npz or .zip file"

EXAMPLES = """\
examples:
  gsenv list                                                  all environments and scenes
  gsenv record GStack-v0 --policy scripted --out tower.mp4    an episode as a video
  gsenv view GStack-v0 --policy trained                       a window on an episode; needs gsenv[human]
  gsenv play GCar-v0                                          drive by keys or gamepad; needs gsenv[human]
  gsenv train GStack-v0 --seeds 0 1 2                         train with PPO; needs gsenv[train]
  gsenv evaluate GStack-v0 --policy trained --set blocks=3    success rate on 100 unseen episodes
  gsenv record scene:stack --size 1280x720 --out stack.gif    a scene, without a policy
  gsenv replay run.npz --check other.npz                      where two recordings of states part
  gsenv dataset GStack-v0 --policy scripted --episodes 100    a Minari dataset; needs gsenv[dataset]
  gsenv warmup                                                compile kernels ahead of time
"""


_STYLE = argparse.RawDescriptionHelpFormatter


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        raise CliError(f"{message} (see `{self.prog} --help`)", WRONG_USAGE)


_Commands: TypeAlias = "argparse._SubParsersAction[_Parser]"


def make_parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="gsenv",
        description="Physics environments for reinforcement learning: list, record, view, play, train and evaluate.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    parser.add_argument("--version", action="version", version=f"gsenv {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    for add in (
        _add_list,
        _add_record,
        _add_replay,
        _add_view,
        _add_play,
        _add_train,
        _add_evaluate,
        _add_dataset,
        _add_kernels,
    ):
        add(commands)
    return parser


def _add_list(commands: _Commands) -> None:
    list_parser = commands.add_parser("list", help="list all environments and scenes")
    list_parser.set_defaults(run=run_list)


def _add_record(commands: _Commands) -> None:
    record = commands.add_parser(
        "record",
        help="run an environment or a scene and write a video",
        description="Run an environment with a policy, or a scene, which needs none, and write a video of it, or the\n"
        "states of its bodies for `gsenv replay`. Ctrl-C stops early and keeps what is recorded so far.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    record.add_argument("target", type=_target, metavar="ENV_OR_SCENE", help="a name from `gsenv list`")
    record.add_argument("--out", required=True, type=Path, metavar="FILE", help="video, .mp4 or .gif, or states, .npz")
    record.add_argument(
        "--policy", type=_policy_name, metavar="POLICY", help=f"policy: {POLICY_HELP} (default: random)"
    )
    add_set_option(record)
    record.add_argument("--seed", type=not_negative, default=0, help="seed of episode and random policy (default: 0)")
    record.add_argument(
        "--steps",
        type=positive,
        help="number of control steps; new episodes begin as needed (default: one episode, or the scene's duration)",
    )
    record.add_argument("--size", type=_size, metavar="WxH", help="frame size in pixels (default: 640x480)")
    record.set_defaults(run=run_record)


def _add_replay(commands: _Commands) -> None:
    replay = commands.add_parser(
        "replay",
        help="run recorded states again and find where they part",
        description="Run what `gsenv record --out FILE.npz` has recorded again, with the same actions, and compare\n"
        "all states bit for bit; with --check, compare two recordings. Exit code 1 where they part.",
        formatter_class=_STYLE,
    )
    replay.add_argument("file", type=Path, metavar="FILE", help="recording, .npz")
    replay.add_argument("--check", type=Path, metavar="OTHER", help="compare with this recording, and run nothing")
    replay.set_defaults(run=run_replay)


def _add_view(commands: _Commands) -> None:
    view = commands.add_parser(
        "view",
        help="watch an environment or a scene in a window, and drag its bodies",
        description="Open a window on an environment or a scene. The mouse drags bodies and turns the view, space\n"
        "pauses, and h shows all keys. Needs gsenv[human] and a display.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    view.add_argument(
        "target",
        type=_target,
        metavar="ENV_OR_SCENE",
        help="a name from `gsenv list`, or a MuJoCo (.xml) or URDF (.urdf) file",
    )
    view.add_argument(
        "--policy",
        type=_policy_name,
        metavar="POLICY",
        help=f"policy: {POLICY_HELP} (default: zero, which does nothing)",
    )
    view.add_argument("--worlds", type=positive, default=1, metavar="N", help="number of worlds (default: 1)")
    _add_window(view)
    view.set_defaults(run=run_view)


def _add_play(commands: _Commands) -> None:
    play = commands.add_parser(
        "play",
        help="steer an environment by keys or a gamepad",
        description="Open a window on an environment and steer it by keys or a gamepad; h shows the keys.\n"
        "Needs gsenv[human] and a display.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    play.add_argument("target", type=_target, metavar="ENV", help="a name from `gsenv list`")
    play.add_argument(
        "--policy",
        type=_policy_name,
        metavar="POLICY",
        help=f"acts for all agents but the first, where an environment has several: {POLICY_HELP} (default: keys)",
    )
    _add_window(play)
    play.set_defaults(run=run_play)


def _add_train(commands: _Commands) -> None:
    train = commands.add_parser(
        "train",
        help="train a policy from scratch",
        description="Train a policy with Stable-Baselines3's PPO and test it on unseen episodes.\n"
        "Ctrl-C stops early and keeps the policy trained so far.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    train.add_argument("env", type=_target, metavar="ENV", help="a name from `gsenv list`")
    train.add_argument("--steps", type=positive, help="steps, summed over all worlds (default: the environment's)")
    train.add_argument("--seeds", type=not_negative, nargs="+", default=[0], help="seeds, one run each (default: 0)")
    train.add_argument("--resume", action="store_true", help="continue the runs in the output folder")
    train.add_argument("--out", type=Path, metavar="FOLDER", help="output folder (default: runs/ppo/ENV)")
    add_set_option(train)
    train.set_defaults(run=run_train)


def _add_evaluate(commands: _Commands) -> None:
    evaluate = commands.add_parser(
        "evaluate",
        help="measure a policy's success on unseen episodes",
        description="Run one episode on each of many seeds of the split 'test', whose episodes training never sees,\n"
        "and print the success rate.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    evaluate.add_argument("env", type=_target, metavar="ENV", help="a name from `gsenv list`")
    _add_episodes(evaluate)
    add_set_option(evaluate)
    evaluate.set_defaults(run=run_evaluate)


def _add_dataset(commands: _Commands) -> None:
    dataset = commands.add_parser(
        "dataset",
        help="write episodes of a policy as a Minari dataset",
        description="Run a policy on many seeds of the split 'train' and write all steps as a dataset of Minari,\n"
        "into the folder that MINARI_DATASETS_PATH names, by default ~/.minari/datasets.",
        epilog=EXAMPLES,
        formatter_class=_STYLE,
    )
    dataset.add_argument("env", type=_target, metavar="ENV", help="a name from `gsenv list`")
    _add_episodes(dataset)
    dataset.add_argument(
        "--noise", type=_noise, default=0.0, help="standard deviation of noise added to the actions (default: 0)"
    )
    dataset.add_argument("--name", help="id of the dataset (default: gsenv/ENV/POLICY-v0)")
    add_set_option(dataset)
    dataset.set_defaults(run=run_dataset)


def _add_kernels(commands: _Commands) -> None:
    """Add `warmup` and `pack`."""
    warmup = commands.add_parser(
        "warmup",
        help="compile kernels ahead of time",
        description="Compile the kernels of all environments and 2D scenes, and of one 3D scene, into the cache, so "
        "that later runs start without compiling.",
    )
    warmup.add_argument("names", nargs="*", metavar="NAME", help="environments or scenes (default: all)")
    _add_processes(warmup)
    warmup.set_defaults(run=run_warmup)

    pack = commands.add_parser(
        "pack",
        help="compile kernels for all CPUs of this kind",
        description="Compile the kernels of all environments for a baseline CPU, into one file for this system,\n"
        "Python and numba, which is part of the package: with it, environments start without compiling.",
        formatter_class=_STYLE,
    )
    pack.add_argument("--out", type=Path, metavar="FOLDER", help="output folder (default: that of the package)")
    pack.add_argument("--fresh", action="store_true", help="compile all anew, those too whose sources have not changed")
    _add_processes(pack)
    pack.set_defaults(run=run_pack)


def _add_processes(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--processes", type=positive, metavar="N", help="compile in N processes (default: all cores)")


def _add_window(parser: argparse.ArgumentParser) -> None:
    """Add the options that `view` and `play` share."""
    add_set_option(parser)
    parser.add_argument("--seed", type=not_negative, default=0, help="seed of the first episode (default: 0)")
    parser.add_argument("--size", type=_size, metavar="WxH", help="window size in pixels (default: 640x480 or more)")
    parser.add_argument("--paused", action="store_true", help="begin paused")


def _add_episodes(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose a policy and the seeds of its episodes."""
    parser.add_argument(
        "--policy", type=_policy_name, default="trained", metavar="POLICY", help=f"{POLICY_HELP} (default: trained)"
    )
    parser.add_argument("--episodes", type=positive, default=100, help="number of episodes (default: 100)")
    parser.add_argument("--seed", type=not_negative, default=0, help="seed of the first episode (default: 0)")


def _policy_name(text: str) -> str:
    if text not in ("zero", "random", "scripted", "trained") and not text.endswith((".npz", ".zip")):
        raise argparse.ArgumentTypeError(f"invalid choice: {text!r}; it is {POLICY_HELP}")
    return text


def _target(text: str) -> str:
    return text.removeprefix("gsenv:")  # the namespace of Gymnasium's ids


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
        return positive(width), positive(height)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 640x480") from None
