"""PPO of Stable-Baselines3 at each registered tier, several seeds: success, return, time of training.

Trains what is missing in the folder --runs with the settings of train/ppo.py (`gsenv train ID --seeds ...` writes the
same files), then plays episodes of the split "test" with each policy. Settings and learning curves of the runs are
written to the folder training/ beside the page. Interquartile means over the seeds and their
bootstrapped 95 % intervals as recommended by Agarwal et al. 2021 (Deep RL at the edge of the statistical precipice).
All tiers and seeds take a day: Ctrl-C keeps what is done, and the same command continues. With --trained it trains
nothing and reports the runs that are complete. With --add published seeds stay, and only others are trained and tested;
with --renew those of other environments stay, and the environments of --env are done anew.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from math import isnan
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.files import packed, read_json, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Picture, Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.envs.core.mlp import MlpPolicy
from gsenv.envs.core.policies import trained_actions
from gsenv.files import write_bytes
from gsenv.train import curve, experiment, origin, ppo
from gsenv.train.arguments import positive
from gsenv.train.checkpoint import changed_settings
from gsenv.train.evaluate import TEST_SEED, UNSELECTED_SEED, Evaluation, evaluate, make_actor
from gsenv.train.files import read_object, read_rows
from gsenv.train.run import Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS, EPISODES, OTHER_EPISODES = 5, 100, 300
QUICK_SEEDS, QUICK_STEPS, QUICK_EPISODES = 1, 20_000, 5
SOLVED = 0.9  # success at which the time to learn a task is taken
RESAMPLES = 5_000  # of the bootstrap
UNKNOWN = "not known"
TO_SOLVED = f"CPU s to {SOLVED:.0%} in training"


@dataclass(frozen=True)
class Trained:
    """One seed of one environment.

    Attributes:
        env: its id.
        seed: of the training.
        steps: of all worlds together.
        commit: of the training, or several, separated by ", "; "" if unknown.
        cpu_seconds: of the training, evaluations included.
        solved_seconds: CPU seconds until an evaluation during training reached SOLVED; -1: none did.
        success: share of the test episodes.
        returns: mean of the test episodes.
        tested: commit of these episodes.
        cpu: on which the training ended; "" if unknown.
        wall_seconds: of the training, evaluations included; -1 if unknown.
        others: success of as many as OTHER_EPISODES from UNSELECTED_SEED on; -1 if unknown.
        best: success of `best.npz` in the test episodes; -1 if unknown.
        length: mean steps of the test episodes; -1 if unknown.
        shipped: "policy" or "best", if the package has that policy of the seed.
    """

    env: str
    seed: int
    steps: int
    commit: str
    cpu_seconds: float
    solved_seconds: float
    success: float
    returns: float
    tested: str
    cpu: str = ""
    wall_seconds: float = -1.0
    others: float = -1.0
    best: float = -1.0
    length: float = -1.0
    shipped: str = ""


@dataclass(frozen=True)
class Point:
    """An evaluation during training."""

    env: str
    seed: int
    steps: int
    success: float


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is trained, and where."""
    parser.add_argument(
        "--env",
        nargs="+",
        choices=list(ppo.SETTINGS),
        metavar="ID",
        default=list(ppo.SETTINGS),
        help="only these environments",
    )
    parser.add_argument("--seeds", type=positive, default=SEEDS, help="number of seeds (default: %(default)s)")
    parser.add_argument("--runs", type=Path, default=Path("runs/ppo"), help="folder of the runs (default: %(default)s)")
    parser.add_argument("--trained", action="store_true", help="train nothing: report the runs that are complete")
    keeps = parser.add_mutually_exclusive_group()
    keeps.add_argument("--add", action="store_true", help="keep the published seeds, and do only others")
    keeps.add_argument("--renew", action="store_true", help="keep the published seeds of other environments than --env")


def measure(run: Run) -> dict[str, Any]:
    """Train what is missing and test all."""
    options = run.options
    trained, points = published(run.results_file) if options.add or options.renew else ([], [])
    known = {(one.env, one.seed) for one in trained if options.add}
    seeds = QUICK_SEEDS if run.quick else options.seeds
    with runs_folder(run) as runs:
        jobs = [(settings_of(env_id, seed, run.quick), runs / env_id / f"seed-{seed}")
                for env_id in options.env for seed in range(seeds) if (env_id, seed) not in known]  # fmt: skip
        if options.trained:
            jobs = [(settings, folder) for settings, folder in jobs if complete(folder, settings)]
        new, of_training = [], []
        for settings, folder in track(jobs, "training", len(jobs)):
            if not complete(folder, settings):
                if experiment.run_seed(ppo.EXPERIMENT, settings, folder, resume=True) != experiment.OK:
                    run.interrupted = True
                    break
            one, its_points = test(settings, folder, run.quick)
            new.append(one)
            of_training += its_points
        renewed = {one.env for one in new} if options.renew else set()
        trained = mark_shipped([one for one in trained if one.env not in renewed] + new, runs)
        if run.page is not None:
            publish(new, trained, runs, run.page.parent / "training")
    points = [point for point in points if point.env not in renewed] + of_training
    order = list(ppo.SETTINGS)
    trained.sort(key=lambda one: (order.index(one.env), one.seed))
    points.sort(key=lambda point: order.index(point.env))
    return {"trained": packed(trained), "points": packed(points)}


def published(results_file: Path | None) -> tuple[list[Trained], list[Point]]:
    """Return the seeds in a file of results and the evaluations during their training."""
    if results_file is None or not results_file.is_file():
        return [], []
    results = read_json(results_file)
    return unpacked(Trained, results["trained"]), unpacked(Point, results["points"])


def settings_of(env_id: str, seed: int, quick: bool) -> Settings:
    settings = replace(ppo.settings_for(env_id), seed=seed, tests=())  # `test` does it below
    if quick:
        return replace(settings, steps=QUICK_STEPS, evaluate_every=QUICK_STEPS // 2, log_every=1)
    return settings


def complete(folder: Path, settings: Settings) -> bool:
    """Return whether the folder has a policy of all steps, of a run with these settings."""
    progress, own = folder / "progress.csv", folder / "settings.json"
    if not all(path.is_file() for path in (folder / "result.json", progress, own)):
        return False
    of_run = read_object(own)
    return (
        read_rows(progress)[-1]["steps"] >= settings.steps - settings.log_every
        and of_run["steps"] == settings.steps
        and not changed_settings(of_run, asdict(settings))
    )


def test(settings: Settings, folder: Path, quick: bool) -> tuple[Trained, list[Point]]:
    """Return the result of a seed's policies, and what evaluations during its training had."""
    rows = read_rows(folder / "progress.csv")
    evaluated = [row for row in rows if not isnan(row["evaluated_success"])]
    solved = [row["cpu_seconds"] for row in evaluated if row["evaluated_success"] >= SOLVED]

    def score(name: str, episodes: int, seed: int = TEST_SEED) -> Evaluation:
        actor = make_actor(str(folder / f"{name}.npz"), settings.env)
        return evaluate(actor, settings.env, QUICK_EPISODES if quick else episodes, seed)

    result = score("policy", EPISODES)
    known = folder / origin.FILE
    made = json.loads(known.read_text()) if known.is_file() else {}
    one = Trained(
        settings.env,
        settings.seed,
        steps=int(rows[-1]["steps"]),
        commit=made.get("commit", ""),
        cpu_seconds=rows[-1]["cpu_seconds"],
        solved_seconds=solved[0] if solved else -1.0,
        success=result.success_rate,
        returns=result.mean_return,
        tested=origin.commit(),
        cpu=made.get("cpu", ""),
        wall_seconds=rows[-1]["seconds"],
        others=score("policy", OTHER_EPISODES, UNSELECTED_SEED).success_rate,
        best=score("best", EPISODES).success_rate,
        length=result.mean_length,
        shipped=shipped(settings.env, folder),
    )
    return one, [Point(settings.env, settings.seed, int(row["steps"]), row["evaluated_success"]) for row in evaluated]


def mark_shipped(trained: Sequence[Trained], runs: Path) -> list[Trained]:
    """Return the rows with ``shipped`` as it is now, where one of these runs is in the package; else as they were."""
    now = {
        (one.env, one.seed): shipped(one.env, folder)
        for one in trained
        if (folder := runs / one.env / f"seed-{one.seed}").is_dir()
    }
    changed = {env_id for (env_id, _), name in now.items() if name}
    return [replace(one, shipped=now.get((one.env, one.seed), "")) if one.env in changed else one for one in trained]


def shipped(env_id: str, folder: Path) -> str:
    """Return the name of the policy in the folder of a run that the package has, too, or ""."""
    try:
        package = trained_actions(env_id)
    except LookupError:
        return ""
    for name in ("policy", "best"):
        policy = MlpPolicy.load(folder / f"{name}.npz")
        if len(policy.layers) == len(package.layers) and all(
            np.array_equal(one, other) for one, other in zip(_numbers(policy), _numbers(package), strict=True)
        ):
            return name
    return ""


def _numbers(policy: MlpPolicy) -> list[NDArray[np.float32]]:
    return [policy.mean, policy.scale, *(part for layer in policy.layers for part in layer)]


def publish(new: Sequence[Trained], trained: Sequence[Trained], runs: Path, folder: Path) -> None:
    """Write settings and learning curves of new runs, and the pictures of their environments with all that are there.

    Curves of seeds that no row has any more are deleted.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for one in new:
        run = runs / one.env / f"seed-{one.seed}"
        write_bytes(folder / f"{one.env}-seed-{one.seed}.csv", (run / "progress.csv").read_bytes())
    for env_id in {one.env for one in new}:
        settings = min((runs / env_id).glob("seed-*/settings.json"))  # those of the seeds differ in the seed alone
        write_bytes(folder / f"{env_id}-settings.json", settings.read_bytes())
        curves = {one.seed: folder / f"{env_id}-seed-{one.seed}.csv" for one in trained if one.env == env_id}
        for path in set(folder.glob(f"{env_id}-seed-*.csv")) - set(curves.values()):
            path.unlink()
        draw_curves(curves, settings.parent, folder / f"{env_id}.png")


def draw_curves(curves: Mapping[int, Path], run: Path, picture: Path) -> None:
    """Draw the published curves of all seeds, with title and references of one run."""
    with tempfile.TemporaryDirectory() as made:
        for seed, path in curves.items():
            of_seed = Path(made) / f"seed-{seed}"
            of_seed.mkdir()
            copyfile(path, of_seed / "progress.csv")
        for name in ("settings.json", "result.json"):
            if (run / name).is_file():
                copyfile(run / name, Path(made) / f"seed-{min(curves)}" / name)
        curve.plot(Path(made), picture)


@contextmanager
def runs_folder(run: Run) -> Iterator[Path]:
    """Yield the folder of the runs; of a quick run, one that is deleted afterwards."""
    if not run.quick:
        yield run.options.runs
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Return the interquartile mean of one value per seed, and the ends of its 95 % interval."""
    from scipy.stats import bootstrap, trim_mean

    def mean(samples: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
        return np.asarray(trim_mean(samples, 0.25, axis=axis))

    sample = np.array(values, float)
    if len(sample) == 1 or np.ptp(sample) == 0.0:
        return float(sample[0]), float(sample[0]), float(sample[0])
    generator = np.random.default_rng(0)
    ends = bootstrap((sample,), mean, n_resamples=RESAMPLES, method="percentile", rng=generator).confidence_interval
    return float(mean(sample)), float(ends.low), float(ends.high)


def over_seeds(values: Sequence[float], style: str) -> str:
    """Return the interquartile mean with its interval; of fewer than SEEDS the mean with lowest and highest."""
    few = len(values) < SEEDS  # a quarter of three is none, and a bootstrap of three holds the mean in 74 % of cases
    numbers = (float(np.mean(values)), min(values), max(values)) if few else interval(values)
    mean, low, high = (style.format(value) for value in numbers)
    return mean if len(values) == 1 else f"{mean} ({low} to {high}{' of ' + str(len(values)) if few else ''})"


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.0f}" if len(values) == 1 else f"{min(values):.0f} to {max(values):.0f}"


def report(results: Mapping[str, Any]) -> Report:
    trained = unpacked(Trained, results["trained"])
    points = unpacked(Point, results["points"])
    text = (
        f'Each policy plays {EPISODES} episodes of the split "test" with its mean action. Success and return are '
        "interquartile means over the seeds with bootstrapped 95 % intervals (Agarwal et al. 2021), which with five "
        "normally distributed seeds hold the true mean in about 90 % of cases; with fewer seeds they are means with "
        "the lowest and the highest seed. Seconds of the "
        "training are medians of the seeds, evaluations included. The next column has the fastest and the slowest of "
        "the seeds that reached this success in 50 episodes during training, with the arguments of the last lesson, "
        "and their number. The last two columns have commits: the command above "
        "renews the environments it names, and keeps the other rows. Trained on "
        f"{', '.join(sorted({one.cpu or 'CPUs that are not known' for one in trained}))}."
    )
    picture = Picture("Success over the steps of training, a line for each seed", lambda: draw(points))
    seeds = (
        f"## Each seed\n\nThe last policy plays the {EPISODES} episodes of the table above, from seed {TEST_SEED} on, "
        f"and {OTHER_EPISODES} others, from {UNSELECTED_SEED} on, by which no policy was chosen; `best.npz`, the "
        f"policy of the best evaluation during training, plays the {EPISODES}. Steps are means of these episodes. The "
        "last column says which policy the package has; where it has that of another run, no row says so. Up to commit "
        "e3621c3 the seeds of an environment trained on nearly the same episodes (255 of 256 worlds began with seeds "
        "that the next run's had, too), so that they differ in first weights and exploration; from 8412384 on each has "
        "episodes of its own."
    )
    return Report("Baselines of PPO", [text, tasks_table(trained), picture, seeds, seeds_table(trained)])


def tasks_table(trained: Sequence[Trained]) -> Table:
    """Return the table with a row for each environment."""
    rows = []
    for env_id in dict.fromkeys(one.env for one in trained):
        of_env = [one for one in trained if one.env == env_id]
        solved = [one.solved_seconds for one in of_env if one.solved_seconds >= 0]
        known = [one.wall_seconds for one in of_env if one.wall_seconds >= 0]
        rows.append(
            [
                env_id,
                f"{len(of_env)}",
                f"{of_env[0].steps / 1e6:.1f}",
                over_seeds([one.success for one in of_env], "{:.0%}"),
                over_seeds([one.returns for one in of_env], "{:.2f}"),
                f"{np.median([one.cpu_seconds for one in of_env]):.0f}",
                f"{np.median(known):.0f}" if known else UNKNOWN,
                f"{_range(solved)} ({len(solved)} of {len(of_env)})" if solved else "not reached",
                ", ".join(sorted({commit for one in of_env for commit in (one.commit or UNKNOWN).split(", ")})),
                ", ".join(sorted({one.tested for one in of_env})),
            ]
        )
    header = [
        "environment",
        "seeds",
        "million steps",
        "success",
        "return",
        "CPU s of training",
        "wall s of training",
        TO_SOLVED,
        "trained at",
        "tested at",
    ]
    return Table(header, rows, words=2)


def seeds_table(trained: Sequence[Trained]) -> Table:
    """Return the table with a row for each seed of each environment."""

    def known(value: float, style: str) -> str:
        return style.format(value) if value >= 0.0 else UNKNOWN

    rows = [
        [
            one.env,
            f"{one.seed}",
            f"{one.success:.0%}",
            known(one.others, "{:.0%}"),
            known(one.best, "{:.0%}"),
            known(one.length, "{:.0f}"),
            f"{one.solved_seconds:.0f}" if one.solved_seconds >= 0.0 else "not reached",
            f"{one.cpu_seconds:.0f}",
            {"policy": "the last", "best": "`best.npz`"}.get(one.shipped, ""),
        ]
        for one in trained
    ]
    header = [
        "environment",
        "seed",
        f"success of {EPISODES}",
        f"of {OTHER_EPISODES} others",
        "`best.npz`",
        "steps",
        TO_SOLVED,
        "CPU s of training",
        "in the package",
    ]
    return Table(header, rows)


def draw(points: Sequence[Point]) -> Figure:
    """Draw success over steps, a panel for each environment and a line for each seed."""
    from benchmarks.common.plots import plt

    names = list(dict.fromkeys(point.env for point in points))
    columns = min(3, max(1, len(names)))
    count = -(-max(1, len(names)) // columns)
    figure, panels = plt.subplots(count, columns, figsize=(4 * columns, 2.8 * count), squeeze=False, sharey=True)
    for panel, name in zip(panels.flat, names, strict=False):
        for seed in sorted({point.seed for point in points if point.env == name}):
            line = [point for point in points if (point.env, point.seed) == (name, seed)]
            x, y = [p.steps / 1e6 for p in line], [100 * p.success for p in line]
            panel.plot(x, y, marker="o", markersize=2, label=f"seed {seed}")
        panel.set(title=name, ylim=(-3, 103))
        panel.grid(alpha=0.3)
    for panel in panels.flat[len(names) :]:
        panel.set_visible(False)
    for panel in panels[:, 0]:
        panel.set_ylabel("success of 50\nunseen episodes, %")
    panels.flat[0].legend(frameon=False, fontsize=8)
    figure.supxlabel("million steps", fontsize=10)
    figure.tight_layout()
    return figure
