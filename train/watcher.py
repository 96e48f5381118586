"""What happens beside the learning: lessons, rows of progress.csv, evaluations, checkpoints and the progress bar."""

from __future__ import annotations

from time import perf_counter, process_time
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from gsenv.train.evaluate import VALIDATION_SEED, evaluate
from gsenv.train.export import export
from gsenv.train.run import Run, notes, save

_SCORE = ("evaluated_success", "evaluated_return")  # of an evaluation, what counts more first


class Watcher(BaseCallback):
    """A callback that follows a run and continues from its rows.

    Args:
        run: whose worlds begin their lesson here, before `learn` resets them.
        progress: of rich, with the bar.
    """

    def __init__(self, run: Run, progress: Any) -> None:
        super().__init__()
        self.run = run
        self.settings = run.settings
        last = run.rows[-1] if run.rows else {}
        self.began = perf_counter() - last.get("seconds", 0.0)
        self.began_cpu = process_time() - last.get("cpu_seconds", 0.0)
        self.logged = run.steps
        self.evaluated = max((int(row["steps"]) for row in run.rows if _is_evaluated(row)), default=0)
        self.curriculum = self.settings.curriculum(int(last.get("lesson", 0)))
        self.progress = progress
        self.bar = progress.add_task(self.settings.env, total=self.settings.steps, completed=run.steps)
        self._begin_lesson()

    def finish(self, evaluates: bool) -> None:
        """Add the row of what has been trained since the last one; without it, `--resume` would repeat lessons."""
        if self.run.steps > self.logged:
            self._add_row(evaluates)

    # ------------------------------------------------- called by Stable-Baselines3

    def _on_training_start(self) -> None:
        if self.settings.staggered:
            self.run.normalize.env_method("stagger", np.random.default_rng(self.settings.seed + self.run.steps))

    def _on_step(self) -> bool:
        self.curriculum.ended += int(np.sum(self.locals["dones"]))
        return True

    def _on_rollout_start(self) -> None:
        if self.curriculum.advance(self._success(), self.run.normalize.num_envs):
            self._begin_lesson()

    def _on_rollout_end(self) -> None:
        if self.run.steps - self.logged >= self.settings.log_every:
            row = self._add_row()
            for name, value in row.items():
                if value != "":
                    self.logger.record(f"gsenv/{name}", value)
            save(self.run)
            description = f"{self.settings.env}  return {row['return']:.2f}  success {row['success']:.0%}"
            self.progress.update(self.bar, description=description)
        self.progress.update(self.bar, completed=self.run.steps)

    # ------------------------------------------------- internal

    def _begin_lesson(self) -> None:
        for name, value in self.curriculum.current().items():
            self.run.normalize.set_attr(name, value)

    def _success(self) -> float:
        return _mean(list(self.run.model.ep_success_buffer or ()))

    def _add_row(self, evaluates: bool = True) -> dict[str, Any]:
        episodes: Any = self.run.model.ep_info_buffer or ()
        row: dict[str, Any] = {
            "steps": self.run.steps,
            "seconds": round(perf_counter() - self.began, 1),
            "cpu_seconds": round(process_time() - self.began_cpu, 1),
            "return": _mean([episode["r"] for episode in episodes]),
            "length": _mean([episode["l"] for episode in episodes]),
            "success": self._success(),
            "lesson": self.curriculum.lesson,
            "evaluated_return": "",
            "evaluated_success": "",
        }
        if evaluates and self.run.steps - self.evaluated >= self.settings.evaluate_every:
            self.evaluated = self.run.steps
            row |= self._evaluate()
        self.run.rows.append(row)
        self.logged = self.run.steps
        return row

    def _evaluate(self) -> dict[str, float]:
        """Return what an evaluation adds to its row, and write best.npz if no other one was better."""
        settings = self.settings
        actor = export(self.run.model, self.run.normalize, notes(self.run))
        result = evaluate(actor, settings.env, settings.watched_episodes, VALIDATION_SEED, settings.arguments)
        scores = {"evaluated_return": result.mean_return, "evaluated_success": result.success_rate}
        if is_best(scores, self.run.rows):
            actor.save(self.run.folder / "best.npz")
        return scores


def is_best(scores: dict[str, float], rows: list[dict[str, Any]]) -> bool:
    """Whether no evaluation in `rows` was better; of equal successes the return decides."""
    score = tuple(scores[name] for name in _SCORE)
    return all(score >= tuple(other[name] for name in _SCORE) for other in rows if _is_evaluated(other))


def _is_evaluated(row: dict[str, Any]) -> bool:
    return row[_SCORE[0]] != "" and row[_SCORE[0]] >= 0.0  # an empty cell is read as NaN


def _mean(values: list[Any]) -> float:
    return float(np.mean(values)) if values else float("nan")
