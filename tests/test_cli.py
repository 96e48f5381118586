"""The command line, with small stand-ins for what it runs, and once with the real thing."""

import itertools
import os
import re
import subprocess
import sys
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

import gsenv
from gsenv import cli, envs, scenes, warmup
from gsenv.solver import jit

ROOT = Path(__file__).parent.parent


def test_list_shows_each_environment_and_scene_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    names = [line.split()[0] for line in lines]
    environments = [entry.id for entry in envs.ENVS] + [entry.name for entry in envs.PARALLEL_ENVS]
    assert names == environments + [f"scene:{name}" for name in scenes.SCENES]
    assert all(len(line.split(maxsplit=1)) == 2 and len(line) <= 120 for line in lines)


def test_version_and_help_end_with_success(capsys: pytest.CaptureFixture[str]) -> None:
    for option, text in (("--version", f"gsenv {gsenv.__version__}\n"), ("--help", "gsenv record GStack-v0")):
        with pytest.raises(SystemExit, match=r"^0$"):
            cli.main([option])
        assert text in capsys.readouterr().out


def test_warmup_runs_every_target(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    calls = itertools.count()
    monkeypatch.setattr(jit, "mute_compile_notice", lambda: None)  # would mute it for all tests of this process
    monkeypatch.setattr(warmup, "warmup_targets", lambda: {"one": lambda: next(calls), "two": lambda: next(calls)})
    assert cli.main(["warmup", "--processes", "1"]) == 0
    assert next(calls) == 2
    assert re.fullmatch(r"all kernels are ready \(\d+\.\d s\)\n", capsys.readouterr().out)


@pytest.mark.parametrize(
    ("run", "notice"),
    [("kernel(1.0)", True), ("cli.main(['warmup', '--processes', '1'])", False)],
    ids=["alone", "in a warmup"],
)
def test_the_progress_bar_of_warmup_replaces_the_compile_notice(run: str, notice: bool) -> None:
    code = (
        "from gsenv import cli, warmup\n"
        "from gsenv.solver import jit; jit.QUIET_SECONDS = 0\n"
        "kernel = jit.njit(eval('lambda x: x + 1.0'))\n"  # has no source, so it is compiled in each process
        "warmup.warmup_targets = lambda: {'a kernel': lambda: kernel(1.0)}\n"
        f"{run}\n"
        "assert kernel.signatures, 'it was compiled'"
    )
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    assert ("compiling kernels" in result.stderr) == notice


def test_warmup_covers_every_environment_and_planar_scene() -> None:
    labels = set(warmup.warmup_targets())
    assert {entry.id for entry in envs.ENVS} <= labels
    assert {entry.name for entry in envs.PARALLEL_ENVS} <= labels
    planar = {f"scene:{name}" for name, spec in scenes.SCENES.items() if spec.dim == 2}
    assert planar | {"scene:cube_stack"} <= labels


def test_warmup_leaves_nothing_to_compile() -> None:
    """After a warmup, a new process that plays an episode's start loads all from the cache."""
    subprocess.run([sys.executable, "-m", "gsenv", "warmup"], cwd=ROOT, check=True, timeout=600)
    code = (
        "from gsenv.solver import jit; jit.QUIET_SECONDS = 0\n"
        "import gymnasium, gsenv\n"
        "env = gymnasium.make('GStack-v0', render_mode='rgb_array'); env.reset(seed=1)\n"
        "env.action_space.seed(1)\n"
        "for _ in range(40):\n"
        "    if env.step(env.action_space.sample())[2]: env.reset()\n"
        "env.render()"
    )
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    assert "compiling" not in result.stderr


def test_the_main_job(tmp_path: Path) -> None:
    out = tmp_path / "tower.mp4"
    command = [sys.executable, "-m", "gsenv", "record", "GStack-v0", "--policy", "scripted", "--out", str(out)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    count = int(re.search(r"(\d+) frames", result.stdout)[1])  # type: ignore[index]
    frames = iio.imread(out)
    assert frames.shape == (count, 480, 640, 3)
    assert np.ptp(frames[0]) > 100  # a picture, not a blank
    assert np.any(np.abs(frames[0].astype(int) - frames[-1]) > 50)  # in which something happened


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--size", "100000x100000"], "width must be 16 to 8192 px"),
        (["--seed", "-1"], "'-1' is not a whole number of at least 0"),
    ],
)
def test_the_real_environment_refuses_in_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: list[str], sentence: str
) -> None:
    assert cli.main(["record", "GStack-v0", "--out", str(tmp_path / "x.mp4"), *arguments]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_train_starts_the_script(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from gsenv.train import ppo

    given: list[list[str]] = []
    monkeypatch.setattr(ppo, "main", lambda arguments, prog: given.append(arguments) or 7)  # type: ignore[func-returns-value]
    command = ["train", "GStack-v0", "--seeds", "1", "2", "--steps", "10", "--resume"]
    assert cli.main([*command, "--out", str(tmp_path), "--set", "mass=(2, 3)"]) == 7
    assert given == [[
        "--env", "GStack-v0", "--seeds", "1", "2", "--steps", "10", "--out", str(tmp_path), "--resume",
        "--set", "mass=(2, 3)",
    ]]  # fmt: skip


def test_train_says_what_to_install(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    assert cli.main(["train", "GStack-v0", "--steps", "10"]) == 1
    assert "is missing; pip install 'gsenv[train]' brings it." in capsys.readouterr().err


def test_evaluate_prints_the_success(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["evaluate", "GStack-v0", "--policy", "scripted", "--episodes", "4"]
    assert cli.main([*command, "--set", "blocks=1"]) == 0
    assert capsys.readouterr().out.startswith("success 100% of 4 episodes")


def test_ids_may_have_their_namespace_and_doing_nothing_is_a_policy(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["evaluate", "gsenv:GRagdoll2D-v0", "--policy", "zero", "--episodes", "4"]) == 0
    assert capsys.readouterr().out.startswith("success 0% of 4 episodes")


@pytest.mark.parametrize(("arguments", "exit_code", "message"), [
    (["train", "GStck-v0"], 2, "did you mean GStack-v0?"),
    (["train", "GStack-v0", "--set", "blocks"], 2, "'blocks' is not of the form NAME=VALUE"),
    (["evaluate", "scene:bridge"], 2, "scene:bridge is a scene, and this needs an environment"),
    (["evaluate", "gsenv:GStack-v0", "--policy", "zero", "--set", "blocks=9"], 2, "blocks must be"),
    (["evaluate", "GNothing-v0"], 2, "no environment is called 'GNothing-v0'"),
    (["evaluate", "GStack-v0", "--policy", "best"], 2, "invalid choice: 'best'"),
    (["evaluate", "GStack-v0", "--policy", "missing.npz"], 1, "cannot read missing.npz"),
    (["evaluate", "GStack-v0", "--policy", "random", "--set", "blocks=9"], 2, "blocks must be"),
    (["evaluate", "GStack-v0", "--policy", "random", "--set", "colour=9"], 2, "unexpected keyword argument 'colour'"),
    (["evaluate", "GStack-v0", "--set", "observation=pixels"], 2, "an evaluation needs observation='state'"),
    (["evaluate", "GStack-v0", "--set", "observation=state+pixels"], 2, "an evaluation needs observation='state'"),
    (["evaluate", "GStack-v0", "--set", "render_mode=human"], 2, "'render_mode' is not for --set"),
    (["evaluate", "GStack-v0", "--set", "world_count=3"], 2, "'world_count' is not for --set"),
    (["evaluate", "GStack-v0", "--set", "self=3"], 2, "'self' is not for --set"),
    (["record", "GStack-v0", "--out", "x.mp4", "--set", "id=1"], 2, "'id' is not for --set"),
    (["record", "GStack-v0", "--out", "x.mp4", "--set", "width=64"], 2, "--size does"),
    (["train", "GStack-v0", "--set", "threads=2"], 2, "'threads' is not for --set"),
    (["record", "GStack-v0", "--out", "x.mp4", "--set", "colour=9"], 2, "crack_speed, grasp_offset"),
    (["record", "GStack-v0", "--out", "x.npz", "--set", f"blocks={'-' * 100_000}1"], 2, "longer than 1000 characters"),
    (["record", "GStack-v0", "--out", "x.npz", "--set", f"blocks={'-' * 900}1"], 2, "blocks must be"),
    (["record", "GStack-v0", "--out", "x.npz", "--set", "blocks={[]: 1}"], 2, "blocks must be"),
    (["evaluate", "GStack-v0", "--episodes", "1" + "0" * 25], 2, "is more than 2**62"),
    (["evaluate", "GStack-v0", "--seed", str(2**128)], 2, "is more than 2**62"),
    (["train", "GStack-v0", "--seeds", "0", "9" * 5000], 2, "is more than 2**62"),
])  # fmt: skip
def test_wrong_training_commands_are_one_sentence(
    arguments: list[str], exit_code: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(arguments) == exit_code
    error = capsys.readouterr().err
    assert message in error
    assert error.startswith("gsenv: ")
    assert error.count("\n") == 1
    assert "environment creator" not in error  # of gymnasium


@pytest.mark.parametrize("module", ["gymnasium", "gsenv.cli.parser"])
def test_ctrl_c_while_the_command_loads_is_one_line(module: str, tmp_path: Path) -> None:
    """A stand-in for the module that loads presses Ctrl-C."""
    code = (
        "import sys, runpy\n"
        "class Press:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}: raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Press())\n"
        "from gsenv.cli import main\n"
        "sys.exit(main())\n"
    )
    script = tmp_path / "gsenv"  # as pip names the command
    script.write_text(code)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    result = subprocess.run(
        [sys.executable, "-P", str(script), "list"], env=environment, capture_output=True, text=True, timeout=60
    )
    assert result.stderr == "gsenv: interrupted\n"
    assert result.returncode == 130


def test_ctrl_c_in_a_program_that_imports_gsenv_is_its_own() -> None:
    code = (
        "import sys\n"
        "class Press:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'gymnasium': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Press())\n"
        "try: import gsenv\n"
        "except KeyboardInterrupt: print('caught')\n"
    )
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert result.stdout == "caught\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_an_output_that_is_full_is_one_line() -> None:
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [sys.executable, "-m", "gsenv", "list"], cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert result.returncode == 1
    assert result.stderr == "gsenv: cannot print the result: No space left on device\n"
