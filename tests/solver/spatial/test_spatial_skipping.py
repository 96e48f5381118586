"""What a scene in space does not need adds no rows and no compiled code: counted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, jit
from gsenv.solver.spatial import step
from gsenv.solver.spatial.shapes import Box, Plane, Sphere
from tests.solver.spatial.one_kernel import full_world, on_plane, space
from tests.solver.test_skipping import counts

ROOT = Path(__file__).parents[3]


def test_free_flight_has_no_rows() -> None:
    scene = space(9.81)
    scene.add_body("it", shapes=[Box(half_extents=(0.3, 0.2, 0.1))], angular_velocity=(1, 2, 3))
    world = full_world(scene)
    world.step(10)
    assert counts(world, "pairs", "contacts", "rows", "sweeps", "impacts", "islands") == (0, 0, 0, 0, 0, 1)


@pytest.mark.parametrize(
    ("material", "rows"),
    [
        ({"friction": 0.0}, 1), ({"friction": 0.5}, 3), ({"friction": 0.5, "torsional_friction": 0.01}, 4),
        ({"friction": 0.5, "torsional_friction": 0.01, "rolling_friction": 0.01}, 6),
    ],
)  # fmt: skip
def test_a_contact_has_the_rows_that_its_frictions_need(material: dict[str, Any], rows: int) -> None:
    scene = on_plane(**material)
    scene.add_body("ball", shapes=[Sphere(radius=0.5, **material)], position=(0, 0, 0.5))
    world = full_world(scene)
    world.step(2)
    assert counts(world, "contacts", "rows") == (1, rows)


def test_a_sleeping_world_does_nothing() -> None:
    scene = on_plane()
    for k in range(3):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5, 0.5))], position=(0, 0, 0.5 + k))
    world = full_world(scene, options=Options())
    world.step(120)
    assert world.asleep[0, 1:4].all()
    before = world.state.bodies.copy()
    world.step(5)
    assert counts(world, "islands", "awake", "pairs", "rows", "sweeps") == (0, 0, 0, 0, 0)
    for name in ("position", "velocity", "rotation", "sleep_time"):
        np.testing.assert_array_equal(world.state.bodies[name], before[name])


def test_disabled_things_make_no_pairs_and_no_rows() -> None:
    scene = space()
    for k in range(5):
        scene.add_body(f"rock_{k}", "static", shapes=[Sphere(radius=1.0)], position=(0.1 * k, 0, 0))
        scene.add_body(f"ghost_{k}", shapes=[Sphere(radius=1.0)], position=(0.1 * k, 0, 0), enabled=False)
    scene.add_body("a", shapes=[Sphere(radius=0.1)], position=(9, 0, 0))
    scene.add_constraint("rule", ["a"], [1, 0, 0, 0, 0, 0], enabled=False)
    world = full_world(scene)
    world.step(3)
    assert counts(world, "pairs", "contacts", "rows", "islands", "awake") == (0, 0, 0, 1, 1)


# ---------------------------------------------------------------- compiled code

JOINTS = (".spatial.joints.", ".solvers.tree.factorise_equations", ".joint_readings.")
CURVED = (".narrowphase.gjk.", ".narrowphase.epa.", ".narrowphase.convex.")
FIELDS = (".narrowphase.heightfields.", ".narrowphase.field_bodies.", ".narrowphase.field_rounds.")
OTHERS = (".sweep_fast.sweep_fast_bodies", ".broadphase.find_pairs_by_tree", ".solvers.soft.", ".solvers.newton.")
STEPS = 60
PLAIN = "scene.add_body('box', shapes=[Box(half_extents=(1, 1, 1))], position=(0, 0, 1))\n"
FALLING = "scene.add_body('ball', shapes=[Sphere(radius=0.5)], position=(0, 0, 3))\n"


def compiled(code: str, cache: Path) -> list[str]:
    """Names of the kernels that a process compiles, from an empty cache: or callees would not be listed."""
    env = os.environ | {"NUMBA_CACHE_DIR": str(cache), "NUMBA_OPT": "0"}  # unoptimised code is compiled faster
    env.pop("GSENV_ONE_KERNEL", None)
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=env, capture_output=True, text=True, timeout=900
    )
    return done.stdout.split()


def stepping(body: str) -> str:
    return (
        "from gsenv.solver import Scene, World\n"
        "from gsenv.solver.jit import compiled_kernels\n"
        "from gsenv.solver.spatial.shapes import Box, Plane, Sphere\n"
        "scene = Scene(dim=3)\n"
        "scene.add_body('ground', 'static', shapes=[Plane()])\n"
        f"{body}"
        "world = World(scene)\n"
        f"world.step({STEPS})\n"
        "world.diagnostics()\n"
        "print(world.state.bodies.tobytes().hex())\n"
        "print('\\n'.join(compiled_kernels()))\n"
    )


@pytest.mark.skipif("CI" not in os.environ, reason="compiles for two minutes")
def test_a_plain_scene_compiles_nothing_of_joints_hulls_fields_and_sweeps(tmp_path: Path) -> None:
    assert step.step_worlds is not None
    names = [f"{kernel.__module__}.{kernel.__qualname__}" for kernel in jit._kernels]
    for part in (*JOINTS, *CURVED, *FIELDS, *OTHERS[:3]):
        assert any(part in name for name in names), f"{part} names nothing any more"
    bits, *made = compiled(stepping(PLAIN + FALLING), tmp_path)
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[Plane()])
    scene.add_body("box", shapes=[Box(half_extents=(1, 1, 1))], position=(0, 0, 1))
    scene.add_body("ball", shapes=[Sphere(radius=0.5)], position=(0, 0, 3))
    world = World(scene)
    world.step(STEPS)
    assert world.state.bodies.tobytes().hex() == bits  # of the kernel that has all features, unoptimised or not
    assert any(name.endswith(".spatial.step.step_worlds") for name in made)
    assert any(".spatial.narrowphase.boxes." in name for name in made)
    unneeded = [name for name in made if any(part in name for part in (*JOINTS, *CURVED, *FIELDS, *OTHERS, ".planar."))]
    assert unneeded == []


def test_a_scene_of_the_plane_loads_nothing_of_space() -> None:
    code = (
        "import sys\n"
        "from gsenv.solver import Box, Circle, HalfPlane, Scene, World\n"
        "scene = Scene()\n"
        "scene.add_body('ground', 'static', shapes=[HalfPlane()])\n"
        "scene.add_body('box', shapes=[Box(half_extents=(1, 1))], position=(0, 1))\n"
        "world = World(scene)\n"
        "world.step()\n"
        "world.diagnostics()\n"
        "print([name for name in sys.modules if name.startswith('gsenv.solver.spatial')])\n"
    )
    env = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=env, capture_output=True, text=True, timeout=300
    )
    assert done.stdout.strip() == "[]"
