"""Recordings of states: they repeat bit for bit, and what differs is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from gsenv.cli import main
from gsenv.envs.core.policies import scripted_actions
from gsenv.replay import QUANTITIES, Recording, compare, record, replay


def moved(recording: Recording, step: int, body: int, quantity: str) -> Recording:
    """A copy in which one number is off by its last bit from a step on."""
    states = {name: values.copy() for name, values in recording.states.items()}
    states[quantity][step:, body, 1] = np.nextafter(states[quantity][step:, body, 1], np.inf)
    return replace(recording, states=states)


@pytest.fixture(scope="module")
def episode() -> Recording:
    return record("GStack-v0", 40, seed=3, actor=scripted_actions("GStack-v0"), arguments={"blocks": 3})


def test_a_run_repeats_bit_for_bit_from_its_file(episode: Recording, tmp_path: Path) -> None:
    episode.save(tmp_path / "run.npz")
    loaded = Recording.load(tmp_path / "run.npz")
    assert loaded.arguments == {"blocks": 3}
    assert loaded.made_by == episode.made_by
    assert compare(episode, loaded) is None
    again = replay(loaded)
    assert compare(episode, again) is None
    assert len(again.times) == 41
    for name in QUANTITIES:
        assert_array_equal(again.states[name], episode.states[name])


def test_it_runs_over_the_ends_of_episodes_and_with_several_agents() -> None:
    for target in ("GStack-v0", "tower_v0"):
        run = record(target, 30, seed=1, actor=lambda seen: np.ones((*seen.shape[:-1], 4)))
        assert compare(run, replay(run)) is None


def test_without_steps_it_is_one_episode(episode: Recording) -> None:
    run = record("GStack-v0", seed=3, actor=scripted_actions("GStack-v0"), arguments={"blocks": 3})
    assert 40 < len(run.times) < 600
    assert compare(run, episode) is None  # all states that both have


@pytest.mark.parametrize(("step", "body", "quantity"), [(0, 0, "position"), (17, 2, "velocity"), (40, 1, "rotation")])
def test_the_first_step_and_body_that_differ_are_found(episode: Recording, step: int, body: int, quantity: str) -> None:
    parting = compare(episode, moved(episode, step, body, quantity))
    assert parting is not None
    assert (parting.step, parting.body, parting.quantity) == (step, episode.bodies[body], quantity)
    assert parting.bodies == 1
    assert parting.time == episode.times[step]
    assert parting.other == np.nextafter(parting.one, np.inf)


def test_zeros_of_different_signs_differ_and_nans_do_not(episode: Recording) -> None:
    states = {name: values.copy() for name, values in episode.states.items()}
    states["velocity"][5, 0, 0] = np.nan
    one = replace(episode, states=states)
    assert compare(one, replace(one, states={n: v.copy() for n, v in states.items()})) is None
    zero = {name: np.zeros_like(values) for name, values in episode.states.items()}
    parting = compare(replace(episode, states=zero), replace(episode, states={n: -v for n, v in zero.items()}))
    assert parting is not None
    assert parting.step == 0


def test_recordings_of_different_things_are_refused(episode: Recording) -> None:
    with pytest.raises(ValueError, match="of GStack-v0 and of scene:stack"):
        compare(episode, replace(episode, target="scene:stack"))
    with pytest.raises(ValueError, match="different bodies"):
        compare(episode, replace(episode, bodies=[*episode.bodies, "more"]))


def test_the_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, other = tmp_path / "run.npz", tmp_path / "other.npz"
    assert main(["record", "scene:stack", "--steps", "20", "--out", str(run)]) == 0
    assert "scene:stack, 20 steps of" in capsys.readouterr().out
    assert main(["replay", str(run)]) == 0
    assert "equal bit for bit" in capsys.readouterr().out
    moved(Recording.load(run), 12, 3, "position").save(other)
    assert main(["replay", str(run), "--check", str(other)]) == 1
    out = capsys.readouterr().out
    assert "they part at step 12" in out
    assert repr(Recording.load(run).bodies[3]) in out


def test_ctrl_c_keeps_the_steps_so_far(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(done: int, total: int) -> None:
        if done == 7:
            raise KeyboardInterrupt

    run = record("scene:stack", 20, on_step=interrupt)
    assert run.interrupted
    assert len(run.times) == len(run.actions) + 1 == 8
    assert compare(run, replay(run)) is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["replay", "missing.npz"], "cannot read missing.npz: No such file"),
        (["replay", "text.npz"], "text.npz is no recording of gsenv"),
        (["replay", "other.npz"], "other.npz is no recording of gsenv"),
        (["record", "GStak-v0", "--out", "a.npz"], "did you mean GStack-v0?"),
        (["record", "scene:stack", "--policy", "random", "--out", "a.npz"], "takes no --policy"),
        (["record", "GStack-v0", "--size", "64x64", "--out", "a.npz"], "--size is for videos"),
        (["record", "GStack-v0", "--set", "blocks=-1", "--out", "a.npz"], "blocks"),
    ],
)
def test_errors_are_one_sentence(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.npz").write_text("no zip")
    np.savez("other.npz", values=np.zeros(3))
    assert main(arguments) in (1, 2)
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1
    assert not Path("a.npz").exists()
