"""Names of sampled functions, and the stages that they belong to."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest

import gsenv.solver
from benchmarks.common.run import Unable
from benchmarks.common.stamp import ROOT
from benchmarks.stages import OTHER, STAGES, stage_of
from benchmarks.stages.sampling import demangled, found
from tests.solver.kernels import all_kernels, name_of


def test_names_of_symbols() -> None:
    mangled = "_ZN5gsenv6solver4core10broadphase9pair_leafB3v42B4c8tJE5ArrayIdLi1E1C7mutable7alignedE"
    assert demangled(mangled) == ("gsenv", "solver", "core", "broadphase", "pair_leaf")
    assert demangled("memcpy") == ("", "memcpy")


def test_the_first_stage_that_fits_counts() -> None:
    core = ("gsenv", "solver", "core")
    assert stage_of((*core, "broadphase", "find_pairs")) == "collision"
    assert stage_of((*core, "kept_pairs", "all_inside")) == "collision"
    assert stage_of((*core, "energy", "apply_warm_start")) == "warm start"
    assert stage_of((*core, "energy", "natural_residual")) == "residual"
    assert stage_of(("gsenv", "solver", "spatial", "narrowphase", "clip", "cut")) == "collision"
    assert stage_of(("", "memcpy")) == OTHER


def test_every_place_of_a_stage_exists() -> None:
    """A module that was renamed would silently be of the rest."""
    paths = [name_of(kernel).split(".") for kernel in all_kernels(gsenv.solver)]
    for places in STAGES.values():
        for place in places:
            module, _, function = place.partition(".")
            assert any(module in path[:-1] and function in ("", path[-1]) for path in paths), place


@pytest.mark.skipif(shutil.which("nm") is None, reason="nm is not installed")
def test_functions_of_a_kernel_in_memory() -> None:
    """Read in a process of its own: here the kernel may have been loaded before."""
    code = """
from benchmarks.stages.sampling import Symbols, machine_code_kept
from gsenv.scenes import stack
from gsenv.solver import World
from gsenv.solver.core.step import step_worlds
with machine_code_kept() as loaded:
    World(stack(2)).step()
    symbols = Symbols.of_steps(loaded)
compiled = next(iter(step_worlds.overloads.values()))  # an address that nothing above was made of
place = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
assert symbols.function_at(place)[-1] == "step_worlds" and place in symbols.starts
k = next(k for k, name in enumerate(symbols.names) if name[-1] == "update_sleep")
assert symbols.function_at(symbols.starts[k]) == symbols.names[k]
assert symbols.function_at(symbols.ends[k] - 1) == symbols.names[k]
assert symbols.function_at(symbols.starts[0] - 1) == symbols.function_at(symbols.ends[-1]) == ("", "")
"""
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, timeout=300).returncode == 0


def test_a_missing_program_is_named() -> None:
    with pytest.raises(Unable, match="no-such-program, which is not installed"):
        found("no-such-program")
