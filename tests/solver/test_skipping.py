"""What a scene does not need adds no pairs, no rows, no islands and no compiled code: counted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from gsenv.scenes import projectile, stack
from gsenv.solver import Box, Circle, HalfPlane, Options, Scene, World, jit

ROOT = Path(__file__).parents[2]


def counts(world: World, *names: str) -> tuple[int, ...]:
    d = world.diagnostics()
    return tuple(int(getattr(d, name)[0]) for name in names)


def test_free_flight_has_no_rows() -> None:
    world = World(projectile())
    world.step(10)
    assert counts(world, "pairs", "contacts", "rows", "sweeps", "impacts", "islands") == (0, 0, 0, 0, 0, 1)


def test_a_frictionless_contact_is_one_row() -> None:
    rough, smooth = World(stack(3, friction=0.5)), World(stack(3, friction=0.0))
    for world in (rough, smooth):
        world.step(2)
        assert counts(world, "contacts") == (6,)
    assert counts(rough, "rows") == (12,)
    assert counts(smooth, "rows") == (6,)


def test_no_restitution_no_impacts() -> None:
    world = World(stack(1))
    world.set_pose("box_0", (0, 1.5))
    for _ in range(60):
        world.step()
        assert counts(world, "impacts") == (0,)
    assert len(world.contacts()) == 2


def test_islands_are_solved_one_by_one() -> None:
    # one restless island beside resting ones: only its own rows are swept
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    for k in range(20):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(3.0 * k, 0.5))
    scene.add_body("ball", shapes=[Circle(radius=0.5)], position=(-10, 0.5), linear_velocity=(-3, 0))
    world = World(scene)
    world.step(3)
    assert counts(world, "islands", "awake", "contacts", "rows") == (21, 21, 41, 82)
    world.step(60)
    assert counts(world, "islands", "awake", "pairs", "rows") == (1, 1, 1, 2)
    assert counts(world, "contacts") == (41,)  # those of sleepers are kept, not searched for


def test_a_sleeping_world_does_nothing() -> None:
    world = World(stack(5))
    world.step(120)
    assert world.asleep[0, 1:].all()
    before = world.state.bodies.copy()
    world.step(5)
    assert counts(world, "islands", "awake", "pairs", "rows", "sweeps") == (0, 0, 0, 0, 0)
    for name in ("position", "velocity", "angle", "sleep_time"):
        np.testing.assert_array_equal(world.state.bodies[name], before[name])


def test_disabled_and_static_things_make_no_pairs() -> None:
    scene = Scene()
    for k in range(10):  # static upon static
        scene.add_body(f"rock_{k}", kind="static", shapes=[Circle(radius=1.0)], position=(0.1 * k, 0))
    for k in range(10):  # kinematic among them, moving
        scene.add_body(
            f"sweep_{k}", kind="kinematic", shapes=[Circle(radius=1.0)], position=(0.1 * k, 0), angular_velocity=1
        )
    for k in range(10):
        scene.add_body(f"ghost_{k}", shapes=[Circle(radius=1.0)], position=(0.1 * k, 0), enabled=False)
    world = World(scene)
    world.step(3)
    assert counts(world, "pairs", "contacts", "rows", "islands", "awake") == (0, 0, 0, 0, 0)


def test_disabled_joints_make_no_rows() -> None:
    scene = Scene(gravity=(0, 0))
    for k in range(2):
        scene.add_body(f"b{k}", shapes=[Circle(radius=0.5)], position=(3.0 * k, 0))
    scene.add_joint("weld", "weld", "b0", "b1", enabled=False)
    scene.add_constraint("rule", ["b0"], [1, 0, 0], enabled=False)
    world = World(scene, options=Options(sleep=False))
    world.step()
    assert counts(world, "rows", "islands") == (0, 2)


# kernels that a scene of boxes and circles has no use for
UNNEEDED = (
    ".planar.joints.", ".solvers.tree.factorise_equations", ".joint_readings.",  # no joints
    ".planar.rays.",  # no rays are cast
    ".narrowphase.polygons.polygon_polygon", ".half_planes.half_plane_polygon", ".narrowphase.terrains.",
    ".sweep_fast.sweep_fast_bodies",  # no body marked fast
    ".broadphase.find_pairs_by_tree",  # few shapes
    ".solvers.newton.", ".solvers.soft.",  # not the solver asked for
)  # fmt: skip


def test_a_plain_scene_compiles_no_joint_polygon_terrain_or_sweep_kernel(tmp_path: Path) -> None:
    names = [f"{kernel.__module__}.{kernel.__qualname__}" for kernel in jit._kernels]
    for part in UNNEEDED:
        assert any(part in name for name in names), f"{part} names nothing any more"
    code = (
        "from gsenv.scenes import stack\n"
        "from gsenv.solver import World\n"
        "from gsenv.solver.jit import compiled_kernels\n"
        "world = World(stack(3))\n"
        "world.step()\n"
        "world.diagnostics()\n"
        "print('\\n'.join(compiled_kernels()))\n"
    )
    # unoptimised code is compiled faster; an empty cache, or callees would not be listed
    env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_OPT": "0"}
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=env, capture_output=True, text=True, timeout=900
    )
    compiled = done.stdout.split()
    assert any(name.endswith(".step_worlds") for name in compiled)
    assert any(name.endswith(".boxes.box_box") for name in compiled)
    unneeded = [name for name in compiled if any(part in name for part in UNNEEDED)]
    assert unneeded == []
