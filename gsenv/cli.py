"""The `gsenv` command: list, record, train, evaluate, warmup.

Exit codes: 0 success, 1 failure, 2 wrong command line, 130 interrupted (frames recorded so far are kept).
Results go to stdout; progress, and errors in one sentence, go to stderr.
"""

import argparse
import ast
import importlib
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from math import ceil
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, NoReturn

from gsenv import __version__
from gsenv.envs import ENVS, PARALLEL_ENVS

if TYPE_CHECKING:
    import gymnasium
    import numpy as np
    from numpy.typing import NDArray
    from rich.progress import Progress

    from gsenv.render.video import VideoWriter
    from gsenv.scenes import SceneSpec
    from gsenv.train.evaluate import Actor

    Frame = NDArray[np.uint8]
    Policy = Callable[[gymnasium.Env[Any, Any]], Any]

SCENE_PREFIX = "scene:"
SCENE_FPS = 60.0  # largest frame rate of a recorded scene; with a shorter timestep, steps are skipped

POLICY_HELP = "random, scripted, trained, or a trained policy's .npz or .zip file"

OK, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130

EXAMPLES = """\
examples:
  gsenv list                                                  all environments and scenes
  gsenv record GStack-v0 --policy scripted --out tower.mp4    an episode as a video
  gsenv train GStack-v0 --seeds 0 1 2                         train with PPO; needs gsenv[train]
  gsenv evaluate GStack-v0 --policy trained --set blocks=3    success rate on 100 unseen episodes
  gsenv record scene:stack --size 1280x720 --out stack.gif    a scene, without a policy
  gsenv warmup                                                compile kernels ahead of time
"""


class _CliError(Exception):
    """An error that is reported in one sentence, with the command's exit code."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message)
        self.exit_code = exit_code


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        raise _CliError(f"{message} (see `{self.prog} --help`)", WRONG_USAGE)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line (by default the process's own) and return the exit code."""
    try:
        options = _parser().parse_args(arguments)
        return int(options.run(options))
    except _CliError as error:
        print(f"gsenv: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:  # e.g. `gsenv list | head -1`
        sys.stderr.close()  # or the interpreter reports the broken pipe at exit
        return FAILED
    except KeyboardInterrupt:
        print("gsenv: interrupted", file=sys.stderr)
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
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
    list_parser.set_defaults(run=_list)

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
    record.set_defaults(run=_record)

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
    train.set_defaults(run=_train)

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
    evaluate.set_defaults(run=_evaluate)

    warmup = commands.add_parser(
        "warmup",
        help="compile kernels ahead of time",
        description="Compile the kernels of all environments and 2D scenes, and of one 3D scene, into the cache, so "
        "that later runs start without compiling.",
    )
    warmup.set_defaults(run=_warmup)
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


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        return _positive(width), _positive(height)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 640x480") from None


def _list(options: argparse.Namespace) -> int:
    from gsenv.scenes import SCENES

    rows = [(entry.id, entry.summary) for entry in ENVS]
    rows += [(entry.name, entry.summary) for entry in PARALLEL_ENVS]
    rows += [(f"{SCENE_PREFIX}{name}", spec.summary) for name, spec in SCENES.items()]
    width = max(len(name) for name, _ in rows)
    for name, summary in rows:
        print(f"{name:<{width}}  {summary}")
    return OK


@dataclass
class _Footage:
    """A recording: `frame_count` frames, or fewer if an episode ends early."""

    fps: float
    frame_count: int
    frames: "Iterator[Frame]"


def _record(options: argparse.Namespace) -> int:
    footage = _footage(options)
    video = _video_writer(options.out, footage.fps)
    try:
        with _progress() as progress, video:
            task = progress.add_task(options.target, total=footage.frame_count)
            for frame in footage.frames:
                _write(video, frame)
                progress.advance(task)
            progress.update(task, total=video.frame_count)
    except KeyboardInterrupt:
        written = video.frame_count
        kept = f"{options.out} has the {written} frames so far" if written else "nothing was written"
        print(f"gsenv: interrupted; {kept}", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        raise _unwritable(options.out, error) from error
    print(f"{options.out}: {video.frame_count} frames, {video.frame_count / footage.fps:.1f} s")
    return OK


def _video_writer(path: Path, fps: float) -> "VideoWriter":
    from gsenv.render.video import VideoWriter

    try:
        return VideoWriter(path, fps)
    except ValueError as error:  # an unknown file name extension
        raise _CliError(str(error), WRONG_USAGE) from error
    except OSError as error:
        raise _unwritable(path, error) from error


def _unwritable(path: Path, error: OSError) -> _CliError:
    return _CliError(f"cannot write {path}: {error.strerror or error}", FAILED)


def _write(video: "VideoWriter", frame: "Frame") -> None:
    try:
        with _uninterrupted():
            video.write(frame)
    except ValueError as error:  # a size that the format does not allow
        raise _CliError(str(error), WRONG_USAGE) from error


@contextmanager
def _uninterrupted() -> "Iterator[None]":
    """Delay Ctrl-C to the end of the block; in the middle of a frame it would spoil the whole video."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread receives signals
        return
    pending = False

    def remember(signal_number: int, frame: object) -> None:
        nonlocal pending
        pending = True

    previous = signal.signal(signal.SIGINT, remember)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
    if pending:
        raise KeyboardInterrupt


def _footage(options: argparse.Namespace) -> _Footage:
    if any(entry.id == options.target for entry in ENVS):
        return _env_footage(options)
    if any(entry.name == options.target for entry in PARALLEL_ENVS):
        return _parallel_footage(options)
    from gsenv.scenes import SCENES

    scenes = [f"{SCENE_PREFIX}{name}" for name in SCENES]
    if options.target in scenes:
        if options.policy is not None:
            raise _CliError(f"{options.target} is a scene and takes no --policy", WRONG_USAGE)
        if options.set:
            raise _CliError(f"{options.target} is a scene and takes no --set", WRONG_USAGE)
        return _scene_footage(options)
    names = [entry.id for entry in ENVS] + [entry.name for entry in PARALLEL_ENVS] + scenes
    raise _CliError(
        f"no environment or scene is called {options.target!r}; {_suggestion(options.target, names)}", WRONG_USAGE
    )


def _suggestion(wrong: str, names: list[str]) -> str:
    spellings = {name.lower(): name for name in names}
    spellings |= {name.removeprefix(SCENE_PREFIX).lower(): name for name in names}
    close = get_close_matches(wrong.lower(), spellings, n=1)
    return f"did you mean {spellings[close[0]]}?" if close else "`gsenv list` shows them all"


def _env_footage(options: argparse.Namespace) -> _Footage:
    import gymnasium

    size = {} if options.size is None else dict(zip(("width", "height"), options.size, strict=True))
    try:
        env = gymnasium.make(options.target, render_mode="rgb_array", **size, **dict(options.set))
    except (TypeError, ValueError) as error:
        raise _CliError(str(error), WRONG_USAGE) from None
    policy = _policy(options.target, options.policy or "random")
    assert env.spec is not None  # gymnasium.make sets it
    step_count = options.steps or env.spec.max_episode_steps or 1000
    frames = _env_frames(env, policy, options.seed, step_count, one_episode=options.steps is None)
    return _Footage(env.metadata["render_fps"], step_count + 1, frames)


def _parallel_footage(options: argparse.Namespace) -> _Footage:
    """Return the recording of an environment with several agents."""
    size = {} if options.size is None else dict(zip(("width", "height"), options.size, strict=True))
    try:
        module = importlib.import_module(f"gsenv.envs.{options.target}")
        env = module.parallel_env(render_mode="rgb_array", **size, **dict(options.set))
    except ImportError as error:
        raise _CliError(f"{error}; {options.target} needs pip install 'gsenv[pettingzoo]'", FAILED) from error
    except (TypeError, ValueError) as error:
        raise _CliError(str(error), WRONG_USAGE) from None
    kind = options.policy or "random"
    policy = None if kind == "random" else _actor(kind, options.target, 0)
    step_count = options.steps or env.max_cycles or 1000
    frames = env.film(policy, options.seed, step_count, one_episode=options.steps is None)
    return _Footage(env.metadata["render_fps"], step_count + 1, frames)


def _policy(env_id: str, kind: str) -> "Policy":
    if kind == "random":
        return lambda env: env.action_space.sample()
    import gsenv.envs.core.policies as policies

    try:
        if kind in ("scripted", "trained"):
            return policies.scripted_policy(env_id) if kind == "scripted" else policies.trained_policy(env_id)
        actor = _actor(kind, env_id, 0)
        return lambda env: actor(env.unwrapped.observation)  # type: ignore[attr-defined]
    except LookupError as error:
        raise _CliError(str(error.args[0]), FAILED) from error


def _actor(policy: str, env_id: str, seed: int) -> "Actor":
    from gsenv.train.evaluate import PolicyError, make_actor

    try:
        return make_actor(policy, env_id, seed)
    except PolicyError as error:
        raise _CliError(str(error), FAILED) from error


def _check_env(name: str) -> None:
    names = [entry.id for entry in ENVS] + [entry.name for entry in PARALLEL_ENVS]
    if name not in names:
        raise _CliError(f"no environment is called {name!r}; {_suggestion(name, names)}", WRONG_USAGE)


def _train(options: argparse.Namespace) -> int:
    _check_env(options.env)
    arguments = ["--env", options.env, "--seeds", *map(str, options.seeds)]
    arguments += [] if options.steps is None else ["--steps", str(options.steps)]
    arguments += [] if options.out is None else ["--out", str(options.out)]
    arguments += ["--resume"] if options.resume else []
    for name, value in options.set:
        arguments += ["--set", f"{name}={value!r}"]
    script = importlib.import_module(f"gsenv.train.{options.algorithm}")
    return int(script.main(arguments))


def _evaluate(options: argparse.Namespace) -> int:
    from gsenv.train.evaluate import TEST_SEED, evaluate

    _check_env(options.env)
    seed = TEST_SEED if options.seed is None else options.seed
    actor = _actor(options.policy, options.env, seed)
    try:
        print(evaluate(actor, options.env, options.episodes, seed, dict(options.set)))
    except (TypeError, ValueError) as error:  # a bad --set
        raise _CliError(str(error), WRONG_USAGE) from error
    return OK


def _env_frames(
    env: "gymnasium.Env[Any, Any]", policy: "Policy", seed: int, step_count: int, *, one_episode: bool
) -> "Iterator[Frame]":
    env.action_space.seed(seed)
    env.reset(seed=seed)
    yield _frame(env)
    for step in range(step_count):
        _, _, terminated, truncated, _ = env.step(policy(env.unwrapped))
        yield _frame(env)
        if terminated or truncated:
            if one_episode or step + 1 == step_count:
                break
            env.reset()
    env.close()


def _frame(env: "gymnasium.Env[Any, Any]") -> "Frame":
    frame: Any = env.render()  # typed as a frame or a list of frames; "rgb_array" gives one frame
    return frame


def _scene_footage(options: argparse.Namespace) -> _Footage:
    from gsenv.render import make_renderer
    from gsenv.render.video import GIF_MAX_FPS
    from gsenv.scenes import SCENES, make_world

    name = options.target.removeprefix(SCENE_PREFIX)
    world = make_world(name)
    width, height = options.size or (640, 480)
    renderer = make_renderer(world, width, height)
    _aim(renderer, SCENES[name])
    fps_limit = min(SCENE_FPS, GIF_MAX_FPS) if options.out.suffix.lower() == ".gif" else SCENE_FPS
    steps_per_frame = ceil(1 / (fps_limit * world.timestep) - 1e-9)  # 1e-9: 1/60 s is one step at 60 fps
    step_count = options.steps or round(SCENES[name].duration / world.timestep)

    def frames() -> "Iterator[Frame]":
        yield renderer.render()
        for step in range(1, step_count + 1):
            world.step()
            if step % steps_per_frame == 0:
                yield renderer.render()

    return _Footage(1 / (steps_per_frame * world.timestep), 1 + step_count // steps_per_frame, frames())


def _aim(renderer: Any, spec: "SceneSpec") -> None:
    """Set the renderer's camera if the scene specifies one."""
    from gsenv.render.camera import Bounds, Camera, FollowCamera

    if spec.camera is not None:
        from gsenv.render.spatial import SpatialCamera

        renderer.camera = SpatialCamera(*spec.camera, width=renderer.width, height=renderer.height)
    elif spec.follow is not None:
        renderer.camera = FollowCamera([renderer.world.model.body_names.index(spec.follow)])
    elif spec.view is not None:
        renderer.camera = Camera.fit(Bounds(*spec.view), renderer.width, renderer.height, margin=0.0)


def _warmup(options: argparse.Namespace) -> int:
    from gsenv.solver import jit
    from gsenv.warmup import warmup_targets

    jit.mute_compile_notice()  # the progress bar replaces it
    began = perf_counter()
    targets = warmup_targets()
    with _progress() as progress:
        task = progress.add_task("compiling", total=len(targets))
        for label, run in targets:
            progress.update(task, description=f"compiling for {label}")
            run()
            progress.advance(task)
    print(f"all kernels are ready ({perf_counter() - began:.1f} s)")
    return OK


def _progress() -> "Progress":
    """Return a progress bar on stderr, which is shown only if that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    console.quiet = not console.is_terminal
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=console, transient=True, disable=console.quiet)
