"""Recordings of states: they repeat bit for bit, and what differs is found."""

from __future__ import annotations

import json
import os
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from gsenv.cli import main
from gsenv.envs.core.policies import scripted_actions
from gsenv.replay import QUANTITIES, Recording, compare, differences, record, replay


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


def damaged(episode: Recording, path: Path, **changes: Any) -> Path:
    """A file of the recording in which arrays have others in their places; settings are changed by name."""
    episode.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    settings = json.loads(str(arrays["settings"]))
    arrays["settings"] = np.array(json.dumps(settings | {k: v for k, v in changes.items() if k in settings}))
    np.savez(path, **(arrays | {k: v for k, v in changes.items() if k not in settings}))
    return path


@pytest.mark.parametrize(
    "changes",
    [
        {"seed": -1},
        {"seed": 2**200},
        {"seed": True},
        {"bodies": "abcdefghijkl"},
        {"position": np.zeros((41, 12, 1))},
        {"position": np.zeros((41, 12))},
        {"rotation": np.zeros((41, 12, 4))},
        {"velocity": np.full((41, 12, 3), "1.0")},
        {"velocity": np.zeros((41, 12, 3), complex)},
        {"times": np.zeros((41, 1))},
        {"actions": np.zeros((40,))},
        {"actions": np.zeros((39, 4))},
        {"target": "GStack-v0\x1b[2J"},
        {"settings": "no json"},
    ],
    ids=str,
)
def test_files_that_hold_no_recording_are_one_sentence(
    episode: Recording, changes: dict[str, Any], tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    assert compare(episode, Recording.load(damaged(episode, tmp_path / "run.npz"))) is None
    path = damaged(episode, tmp_path / "run.npz", **changes)
    with pytest.raises(ValueError, match=r"run\.npz is no recording of gsenv that this version reads\.$"):
        Recording.load(path)
    assert not recwarn.list


def test_a_file_that_would_fill_the_memory_is_not_unpacked(
    episode: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    episode.save(tmp_path / "run.npz")
    monkeypatch.setattr("gsenv.envs.core.mlp.MOST_BYTES", 10_000)
    with pytest.raises(ValueError, match="is no recording"):
        Recording.load(tmp_path / "run.npz")


def test_a_run_that_no_file_can_hold_is_refused_before_it_begins() -> None:
    with pytest.raises(ValueError, match=r"a recording of scene:stack has room for at most \d+ steps, got 10000000"):
        record("scene:stack", 10_000_000, on_step=lambda *_: pytest.fail("it has begun"))


@pytest.mark.parametrize("arguments", [{"observation": "pixels"}, {"render_mode": "human"}])
def test_states_need_no_pictures(arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="GStack-v0: recordings of states take no render_mode, and no observation"):
        record("GStack-v0", 2, actor=lambda seen: seen, arguments=arguments)


def test_everything_else_that_differs_is_told(episode: Recording) -> None:
    assert differences(episode, replay(episode)) == []
    actions, times = episode.actions.copy(), episode.times.copy()
    actions[7, 1] += 1.0
    times[5] += 1.0
    other = replace(episode, seed=4, arguments={}, actions=actions, times=times)
    assert differences(episode, other) == [
        "their seeds differ: 3 and 4",
        "their arguments differ: {'blocks': 3} and {}",
        f"their times differ at step 5: {float(episode.times[5])!r} and {float(times[5])!r} s",
        "their actions differ at step 7",
    ]
    short = {name: values[:1] for name, values in episode.states.items()}
    start = replace(episode, states=short, times=episode.times[:1], actions=episode.actions[:0])
    assert differences(start, episode) == ["their lengths differ: 0 and 40 steps"]
    assert differences(episode, replace(episode, actions=actions[:, :2])) == [
        "their actions have different shapes: (4,) and (2,)"
    ]


def test_renamed_bodies_are_named(episode: Recording) -> None:
    with pytest.raises(ValueError, match=f"different bodies: {episode.bodies[1]!r}, 'new'"):
        compare(episode, replace(episode, bodies=[episode.bodies[0], "new", *episode.bodies[2:]]))


def test_the_command_tells_a_shorter_recording_and_escapes_what_made_it(
    episode: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    states = {name: values[:6] for name, values in episode.states.items()}
    replace(episode, made_by="\x1b[31mred\nline").save(tmp_path / "a.npz")
    replace(episode, states=states, times=episode.times[:6], actions=episode.actions[:5]).save(tmp_path / "b.npz")
    assert main(["replay", str(tmp_path / "a.npz"), "--check", str(tmp_path / "b.npz")]) == 1
    out = capsys.readouterr().out
    assert "made by \\x1b[31mred\\nline\n" in out
    assert out.endswith("their lengths differ: 40 and 5 steps\n")
    assert main(["replay", str(tmp_path / "b.npz"), "--check", str(tmp_path / "b.npz")]) == 0


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("times", [1, 2])
def test_the_first_ctrl_c_while_states_are_written_keeps_them(
    times: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    save = Recording.save

    def slow_save(recording: Recording, path: Path) -> None:
        for _ in range(times):
            os.kill(os.getpid(), signal.SIGINT)
        save(recording, path)

    monkeypatch.setattr(Recording, "save", slow_save)
    out = tmp_path / "run.npz"
    assert main(["record", "scene:stack", "--steps", "3", "--out", str(out)]) == 130
    printed = capsys.readouterr()
    assert out.exists() == (times == 1) == ("3 steps" in printed.out)
    assert ("nothing was written" in printed.err) == (times == 2)
