"""Learning curves of an experiment: one line per seed, with the scripted and the random policy for reference.

python -m gsenv.train.curve runs/ppo/GStack-v0
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gsenv.files import replacing
from gsenv.train.checkpoint import AS_TRAINED, COLUMNS
from gsenv.train.files import read_object, read_rows, reason

_STYLES = {"trained": ("o", "#2a6fbb"), "scripted": ("--", "#46ae90"), "random": (":", "#8a8f98")}


def plot(folder: Path, out: Path | None = None) -> None:
    """Plot success and return over steps, one line per seed-* folder, to `out` (default: curve.png in `folder`)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    FigureCanvasAgg(figure)
    success, returns = figure.subplots(1, 2)
    title = folder.name
    for seed in _seed_folders(folder):
        if not (seed / "progress.csv").is_file():
            continue
        rows = read_rows(seed / "progress.csv", COLUMNS)
        if (seed / "settings.json").is_file():
            title = read_object(seed / "settings.json").get("env", title)
        label = seed.name.replace("-", " ")
        (line,) = returns.plot([row["steps"] for row in rows], [row["return"] for row in rows], label=label)
        evaluated = [row for row in rows if not math.isnan(row["evaluated_success"])]
        success.plot(
            [row["steps"] for row in evaluated],
            [100 * row["evaluated_success"] for row in evaluated],
            color=line.get_color(), marker="o", markersize=3, label=label,
        )  # fmt: skip
        _add_references(seed, success, returns)
    success.set(xlabel="steps", ylabel="success, %, mean action, unseen seeds", ylim=(-3, 103))
    returns.set(xlabel="steps", ylabel="return, with exploration")
    for axes in (success, returns):
        axes.grid(alpha=0.3)
        axes.set_xlim(left=0)
    handles, labels = returns.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    if unique:  # seeds first, then the reference policies
        order = sorted(unique, key=lambda label: label in _STYLES)
        returns.legend([unique[label] for label in order], order, fontsize=8)
    figure.suptitle(title)
    with replacing(out or folder / "curve.png") as partial:
        figure.savefig(partial, dpi=110)


def _seed_folders(folder: Path) -> list[Path]:
    """Return the folders seed-0, seed-1 and so on; others, such as seed-old, are the user's."""
    found = [path for path in folder.glob("seed-*") if path.name.removeprefix("seed-").isdecimal()]
    return sorted(found, key=lambda path: int(path.name.removeprefix("seed-")))


def _add_references(seed: Path, success: Any, returns: Any) -> None:
    """Add horizontal lines for the scripted and the random policy, with the arguments of the evaluations."""
    if not (seed / "result.json").is_file():
        return
    results = read_object(seed / "result.json")
    for policy in ("scripted", "random"):
        result = results.get(f"{AS_TRAINED}: {policy}")
        if result is not None:
            style, color = _STYLES[policy]
            success.axhline(100 * result["success_rate"], linestyle=style, color=color, label=policy)
            returns.axhline(result["mean_return"], linestyle=style, color=color, label=policy)


def main(arguments: Sequence[str] | None = None) -> int:
    """Plot as the command line says; return the exit code."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    if len(given) not in (1, 2):
        print("curve: expected an experiment's folder and, optionally, the picture's path", file=sys.stderr)
        return 2
    try:
        plot(Path(given[0]), Path(given[1]) if len(given) == 2 else None)
    except (OSError, ValueError) as error:
        print(f"curve: {reason(error)}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
