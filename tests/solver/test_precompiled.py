"""Precompiled kernels: found by any process whose sources are the same, never used for others."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest
from llvmlite import binding

from gsenv import pack
from gsenv.scenes import SCENES as SCENES_OF_THE_PACKAGE
from gsenv.solver import precompiled
from gsenv.solver.records.kernel_variants import ONE_KERNEL, OWN_KERNELS
from gsenv.warmup import WAYS
from tests.envs.registered import TASK_IDS
from tests.solver.mini_package import CALLEE, entries, make_package, run

ROOT = Path(__file__).parents[2]
BASELINE = precompiled.BASELINES.get(precompiled.machine())
pytestmark = pytest.mark.skipif(BASELINE is None, reason=f"no baseline CPU for {precompiled.machine()}")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """The small package with a set of its kernels for one float, and an empty cache."""
    made = make_package(tmp_path)
    assert BASELINE is not None
    cache = tmp_path / "cache"
    result, _, _ = run(made, "2.5", NUMBA_CACHE_DIR=str(cache), NUMBA_CPU_NAME=BASELINE.name, NUMBA_CPU_FEATURES="")
    assert result == "35.0"
    pack.write_set(cache, made / "gsenv/assets/kernels")
    return made


def only_file(package: Path) -> Path:
    (file,) = (package / "gsenv/assets/kernels").iterdir()
    return file


def test_the_set_has_what_python_calls_and_nothing_else(package: Path) -> None:
    names = zipfile.ZipFile(only_file(package)).namelist()
    assert [precompiled.function_of(name) for name in names] == ["caller.caller"]


def test_a_fresh_process_compiles_nothing(package: Path) -> None:
    assert run(package, "2.5", quiet=0.0) == ("35.0", "gsenv.solver.caller.caller", "")
    assert entries(package) == []


def test_other_arguments_are_compiled(package: Path) -> None:
    result, _, err = run(package, "2", quiet=0.0)
    assert result == "30"
    assert "the precompiled caller.caller is for other sources or another set of features" in err
    assert len(entries(package)) == 2


@pytest.mark.parametrize("name", ["callee", "constants"])
def test_old_code_is_never_served(package: Path, name: str) -> None:
    text = CALLEE.format(2) if name == "callee" else "FACTOR = 2\n"
    (package / f"gsenv/solver/{name}.py").write_text(text)
    result, _, err = run(package, "2.5", quiet=0.0)
    assert result == ("45.0" if name == "callee" else "60.0")
    assert "is for other sources" in err
    assert err.count("\n") == 1


def test_an_edit_elsewhere_leaves_the_set_valid(package: Path) -> None:
    (package / "gsenv/solver/scene.py").write_text("from .caller import caller\n\nscene = 3\n")
    assert run(package, "2.5", quiet=0.0)[2] == ""


def test_the_cache_comes_first(package: Path) -> None:
    assert run(package, "2.5", quiet=0.0, GSENV_PRECOMPILED="0")[2].count("GSENV_PRECOMPILED is 0") == 1
    assert len(entries(package)) == 2
    only_file(package).unlink()
    assert run(package, "2.5", quiet=0.0)[2] == ""


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ("gone", "there are no precompiled kernels for"),
        ("broken", "the precompiled kernels cannot be read"),
        ("cut", "the precompiled kernels cannot be read"),
    ],
)
def test_without_a_set_kernels_are_compiled(package: Path, what: str, reason: str) -> None:
    file = only_file(package)
    if what == "gone":
        file.rename(file.with_name("other-system.zip"))
    else:
        file.write_bytes(b"no zip" if what == "broken" else file.read_bytes()[:-100])
    result, _, err = run(package, "2.5", quiet=0.0)
    assert result == "35.0"
    assert reason in err
    assert err.count("\n") == 1


def test_a_broken_entry_is_compiled(package: Path) -> None:
    file = only_file(package)
    (name,) = zipfile.ZipFile(file).namelist()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(name, b"no pickle")
    assert run(package, "2.5")[0] == "35.0"
    assert len(entries(package)) == 2


def test_a_cpu_without_a_feature_compiles(monkeypatch: pytest.MonkeyPatch, package: Path) -> None:
    monkeypatch.setattr(precompiled, "FOLDER", package / "gsenv/assets/kernels")
    host = binding.get_host_cpu_features()
    assert isinstance(precompiled.open_set.__wrapped__(), precompiled.KernelSet)
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: {**host, "avx2": False})
    assert precompiled.open_set.__wrapped__() == "this CPU lacks avx2, which the precompiled kernels use"


def test_a_chosen_cpu_compiles(package: Path) -> None:
    _, _, err = run(package, "2.5", quiet=0.0, NUMBA_CPU_NAME="generic")
    assert "NUMBA_CPU_NAME or NUMBA_CPU_FEATURES is set" in err


EPISODE = """
import gymnasium, gsenv, numpy as np
env = gymnasium.make("GStack-v0")
env.reset(seed=0)
total = np.zeros(env.observation_space.shape)
for k in range(60):
    total += env.step(np.sin(np.arange(4) + 0.1 * k).astype(np.float32))[0]
print(total.tobytes().hex())
"""


@pytest.mark.slow  # compiles an environment
def test_the_set_of_the_package_gives_the_bits_of_this_cpu(tmp_path: Path) -> None:
    found = precompiled.open_set()
    if isinstance(found, str):
        pytest.skip(found)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "GSENV_"))}
    outputs = []
    for changes in ({"NUMBA_CACHE_DIR": str(tmp_path)}, {precompiled.SWITCH: "0"}):
        command = [sys.executable, "-c", EPISODE]
        result = subprocess.run(
            command, env=environment | changes, cwd=ROOT, capture_output=True, text=True, timeout=600
        )
        assert result.returncode == 0, result.stderr
        if "is for other sources" in result.stderr:
            pytest.skip("the sources have changed since `gsenv pack`")
        outputs.append(result.stdout)
    assert outputs[0] == outputs[1]
    assert not list(tmp_path.rglob("*.nb[ci]"))


def test_the_set_is_of_the_present_sources(tmp_path: Path) -> None:
    """Else the first use of an environment compiles for a minute."""
    current = precompiled.FOLDER / precompiled.set_name()
    if not current.is_file():
        pytest.skip("no set for this Python")
    with zipfile.ZipFile(current) as archive:
        assert pack.keep_current(tmp_path) == len(archive.namelist()), "run `gsenv pack`"


def test_packing_again_keeps_what_is_current(tmp_path: Path) -> None:
    """Kept kernels lie where a process of `gsenv pack` finds them; those of other sources are left behind."""
    current = precompiled.FOLDER / precompiled.set_name()
    if not current.is_file():
        pytest.skip("no set for this Python")
    assert BASELINE is not None
    with zipfile.ZipFile(current) as archive:
        names = archive.namelist()
        with zipfile.ZipFile(tmp_path / current.name, "w") as other:
            for name in names:
                other.writestr(name, archive.read(name))
            base, digest, key, kind = names[0].rsplit(".", 3)
            other.writestr(f"{base}.{'0' * len(digest)}.{key}.{kind}", b"of other sources")
    cache = tmp_path / "cache"
    cache.mkdir()
    count = pack.keep_current(cache, tmp_path)
    kept = {file.name for file in cache.rglob("*.nbc")}
    assert len(kept) == count
    assert kept <= set(names)
    assert pack.keep_current(cache, tmp_path / "nothing") == 0
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "GSENV_"))}
    environment |= {"NUMBA_CACHE_DIR": str(cache), "NUMBA_CPU_NAME": BASELINE.name, "NUMBA_CPU_FEATURES": ""}
    if count < len(names):
        pytest.skip("the sources have changed since `gsenv pack`")
    command = [sys.executable, "-c", EPISODE]
    result = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    assert "compiling" not in result.stderr
    assert {file.name for file in cache.rglob("*.nbc")} == kept


SCENES = """
import json, sys
from gsenv.solver import Options, Scene, World, planar, spatial
options = Options(**json.loads(sys.argv[1]))
for dim in (2,) if options.solver == "newton" else (2, 3):
    kind = planar if dim == 2 else spatial
    half = (0.3,) * dim
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[kind.HalfPlane() if dim == 2 else kind.Plane()])
    for k in range(3):
        at = [0.0] * dim
        at[-1] = 0.4 + 0.7 * k
        scene.add_body(f"box_{k}", shapes=[kind.Box(half_extents=half, restitution=0.2)], position=at)
    hinge = kind.Revolute("box_0", "box_1") if dim == 2 else kind.Hinge("box_0", "box_1", axis=(1, 0, 0))
    rope = kind.Distance("ground", "box_2", length=3.0)
    for joints in ({"hinge": hinge}, {}, {"rope": rope}, {"hinge": hinge, "rope": rope}):
        scene.joints.clear()
        for name, joint in joints.items():
            scene.add_joint(name, joint)
        world = World(scene, 2, options=options)
        world.step(10)
        world.diagnostics()
        world.contacts()
"""


@pytest.mark.parametrize("options", WAYS.values(), ids=str)
def test_a_scene_of_ones_own_runs_at_once_on_the_general_kernel(options: dict[str, Any], tmp_path: Path) -> None:
    if isinstance(precompiled.open_set(), str):
        pytest.skip(str(precompiled.open_set()))
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "GSENV_"))}
    environment["NUMBA_CACHE_DIR"] = str(tmp_path)
    command = [sys.executable, "-c", SCENES, json.dumps(options)]
    result = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    if "is for other sources" in result.stderr:
        pytest.skip("the sources have changed since `gsenv pack`")
    assert result.stderr.count("\n") == 1
    assert "runs on the kernel of all scenes" in result.stderr
    assert not list(tmp_path.rglob("*.nb[ci]"))


OWN_SCENES = """
import hashlib, sys
from gsenv.scenes import make_world
for name in sys.argv[1:]:
    world = make_world(name)
    world.step(120)
    print(name, hashlib.sha256(world.state.bodies.tobytes()).hexdigest())
"""
OWN_ENVS = """
import sys
from tests.envs.registered import digest, make_vector, play, random_actions
for name in sys.argv[1:]:
    envs = make_vector(name, 2)
    envs.reset(seed=5)
    print(name, digest([play(envs, random_actions(name, 1, 40, 2))]))
"""
ALL = [*(name for name, spec in SCENES_OF_THE_PACKAGE.items() if spec.dim == 2), "cube_stack"]


@pytest.mark.parametrize(
    ("code", "names"),
    [(OWN_ENVS, TASK_IDS), pytest.param(OWN_SCENES, ALL, marks=pytest.mark.slow)],
    ids=["environments", "scenes"],
)
def test_the_general_kernel_gives_the_bits_of_those_of_single_scenes(
    code: str, names: list[str], tmp_path: Path
) -> None:
    """Environments have trees, loops, springs and terrain, and their kernels are in the set; see also test_skipping."""
    if isinstance(precompiled.open_set(), str):
        pytest.skip(str(precompiled.open_set()))
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "GSENV_"))}
    environment["NUMBA_CACHE_DIR"] = str(tmp_path)
    outputs = []
    for changes in ({ONE_KERNEL: "2,3"}, {OWN_KERNELS: "1"}):
        command = [sys.executable, "-c", code, *names]
        result = subprocess.run(
            command, env=environment | changes, cwd=ROOT, capture_output=True, text=True, timeout=1200
        )
        assert result.returncode == 0, result.stderr
        if ONE_KERNEL in changes and "is for other sources" in result.stderr:
            pytest.skip("the sources have changed since `gsenv pack`")
        outputs.append(result.stdout)
    assert outputs[0].count("\n") == len(names)
    assert outputs[0] == outputs[1]
