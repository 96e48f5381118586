"""What an import brings along, and what registering does."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import gymnasium
import pytest

import gsenv
import gsenv.envs

ROOT = Path(__file__).parent.parent


def python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize("module", ["gsenv", "gsenv.cli"])
def test_import_is_light(module: str) -> None:
    code = f"import sys, {module}; print(*sorted(sys.modules))"
    loaded = python(code).stdout.split()
    assert module in loaded
    assert not {"imageio", "matplotlib", "numba", "pettingzoo", "pygame", "rich", "scipy", "torch"} & set(loaded)


def test_solver_needs_no_package_but_numpy_and_numba() -> None:
    # The parent package imports gymnasium to register; the solver itself must not. (numba imports scipy.)
    code = (
        "import sys, types\n"
        "parent = types.ModuleType('gsenv'); parent.__path__ = ['gsenv']; sys.modules['gsenv'] = parent\n"
        "import gsenv.solver, gsenv.solver.planar, gsenv.solver.spatial\n"
        "print(*sorted(sys.modules))"
    )
    result = python(code)
    assert result.returncode == 0, result.stderr
    assert not {"gymnasium", "imageio", "matplotlib", "rich", "torch"} & set(result.stdout.split())


def test_a_stray_import_of_the_top_level_folder_is_refused() -> None:
    result = python("import envs")
    assert result.returncode == 1
    assert "ImportError: the package is gsenv.envs" in result.stderr


def test_registering_again_changes_nothing_and_says_nothing(recwarn: pytest.WarningsRecorder) -> None:
    before = dict(gymnasium.registry)
    gsenv.envs.register_envs()
    assert gymnasium.registry == before
    assert not recwarn.list


@pytest.mark.parametrize("entry", gsenv.envs.ENVS, ids=lambda entry: entry.id)
def test_every_entry_is_registered_by_strings(entry: gsenv.envs.EnvEntry) -> None:
    spec = gymnasium.spec(entry.id)
    assert spec.max_episode_steps == entry.max_episode_steps
    assert gymnasium.envs.registration.EnvSpec.from_json(spec.to_json()) == spec  # fails on callables


@pytest.mark.parametrize("entry", gsenv.envs.ENVS, ids=lambda entry: entry.id)
def test_every_entry_names_its_classes(entry: gsenv.envs.EnvEntry) -> None:
    for name, base in ((entry.env, gymnasium.Env), (entry.vector_env, gymnasium.vector.VectorEnv)):
        module, _, class_name = name.partition(":")
        assert issubclass(getattr(import_module(f"gsenv.envs.{module}"), class_name), base)
    assert entry.summary


def test_prefixed_name_imports_gsenv_by_itself() -> None:
    result = python("import gymnasium; print(gymnasium.make('gsenv:GStack-v0').spec.id)")
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "GStack-v0"
