"""What a scene does not need adds no pairs, no rows, no islands and no compiled code: counted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gsenv.solver
from gsenv.scenes import projectile, stack
from gsenv.scenes.spatial import cube_stack, thrown_box
from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.records.kernel_variants import ONE_KERNEL, OWN_KERNELS
from tests.solver.kernels import all_kernels, name_of

ROOT = Path(__file__).parents[3]
AWAKE = Options(sleep=False)
BOTH = pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
STACK = {2: stack, 3: cube_stack}


def counts(world: World, *names: str) -> tuple[int, ...]:
    d = world.diagnostics()
    return tuple(int(getattr(d, name)[0]) for name in names)


def ball(dim: int, radius: float = 0.5, **material: Any) -> Any:
    return planar.Circle(radius=radius, **material) if dim == 2 else spatial.Sphere(radius=radius, **material)


def ground(dim: int, **material: Any) -> Any:
    return planar.HalfPlane(**material) if dim == 2 else spatial.Plane(**material)


def at(dim: int, x: float, height: float = 0.0) -> tuple[float, ...]:
    return (x, height) if dim == 2 else (x, 0.0, height)


def along_x(dim: int) -> list[float]:
    """Direction of a row of one body."""
    return [1.0] + [0.0] * (2 if dim == 2 else 5)


# ---------------------------------------------------------------- pairs, rows, islands


@BOTH
def test_free_flight_has_no_rows(dim: int) -> None:
    world = World(projectile() if dim == 2 else thrown_box(), options=AWAKE)
    world.step(10)
    assert counts(world, "pairs", "contacts", "rows", "sweeps", "impacts", "islands") == (0, 0, 0, 0, 0, 1)


@pytest.mark.parametrize(
    ("dim", "material", "rows"),
    [
        (2, {"friction": 0.0}, 1), (2, {"friction": 0.5}, 2),
        (3, {"friction": 0.0}, 1), (3, {"friction": 0.5}, 3), (3, {"friction": 0.5, "torsional_friction": 0.01}, 4),
        (3, {"friction": 0.5, "torsional_friction": 0.01, "rolling_friction": 0.01}, 6),
    ],
)  # fmt: skip
def test_a_contact_has_the_rows_that_its_frictions_need(dim: int, material: dict[str, Any], rows: int) -> None:
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[ground(dim, **material)])
    for k in range(3):
        scene.add_body(f"ball_{k}", shapes=[ball(dim, **material)], position=at(dim, 2.0 * k, 0.5))
    world = World(scene, options=AWAKE)
    world.step(2)
    assert counts(world, "contacts", "rows") == (3, 3 * rows)


@BOTH
def test_no_restitution_no_impacts(dim: int) -> None:
    world = World(STACK[dim](1))
    world.set_pose("box_0", position=at(dim, 0.0, 1.5))
    for _ in range(60):
        world.step()
        assert counts(world, "impacts") == (0,)
    assert len(world.contacts()) == {2: 2, 3: 4}[dim]


@BOTH
def test_islands_are_solved_one_by_one(dim: int) -> None:
    # one restless island beside resting ones: only its own rows are swept
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[ground(dim)])
    for k in range(20):
        box: Any = planar.Box(half_extents=(0.5, 0.5)) if dim == 2 else spatial.Box(half_extents=(0.5, 0.5, 0.5))
        scene.add_body(f"box_{k}", shapes=[box], position=at(dim, 3.0 * k, 0.5))
    rolling = (-3.0, 0.0, 0.0)[:dim]
    scene.add_body("ball", shapes=[ball(dim)], position=at(dim, -10.0, 0.5), linear_velocity=rolling)
    world = World(scene)
    world.step(3)
    corners, rows = {2: (2, 2), 3: (4, 3)}[dim]  # of a box, of a contact
    contacts = 20 * corners + 1
    assert counts(world, "islands", "awake", "contacts", "rows") == (21, 21, contacts, rows * contacts)
    world.step(60)
    assert counts(world, "islands", "awake", "pairs", "rows") == (1, 1, 1, rows)
    assert counts(world, "contacts") == (contacts,)  # those of sleepers are kept, not searched for


@BOTH
def test_a_sleeping_world_does_nothing(dim: int) -> None:
    world = World(STACK[dim](5))
    world.step(120)
    assert world.asleep[0, 1:].all()
    before = world.state.bodies.copy()
    world.step(5)
    assert counts(world, "islands", "awake", "pairs", "rows", "sweeps") == (0, 0, 0, 0, 0)
    for name in ("position", "velocity", "angle", "rotation", "sleep_time"):
        np.testing.assert_array_equal(world.state.bodies[name], before[name])


@BOTH
def test_disabled_and_static_things_make_no_pairs(dim: int) -> None:
    scene = Scene(dim=dim)
    spin = 1.0 if dim == 2 else (0.0, 0.0, 1.0)
    for k in range(10):  # static upon static, kinematic among them, moving
        place = at(dim, 0.1 * k)
        scene.add_body(f"rock_{k}", "static", shapes=[ball(dim, 1.0)], position=place)
        scene.add_body(f"sweep_{k}", "kinematic", shapes=[ball(dim, 1.0)], position=place, angular_velocity=spin)
        scene.add_body(f"ghost_{k}", shapes=[ball(dim, 1.0)], position=place, enabled=False)
    world = World(scene)
    world.step(3)
    assert counts(world, "pairs", "contacts", "rows", "islands", "awake") == (0, 0, 0, 0, 0)


@BOTH
def test_shapes_that_are_only_drawn_are_not_placed(dim: int) -> None:
    half = (0.5,) * dim
    box = planar.Box if dim == 2 else spatial.Box
    drawn = [box(half_extents=half, mask=0), box(half_extents=half, category=0)]
    worlds = []
    for others in ([], drawn):
        scene = Scene(dim=dim)
        scene.add_body("floor", "static", shapes=[ground(dim)])
        scene.add_body("block", shapes=[box(half_extents=half)], position=at(dim, 0.0, 0.6), mass=1.0)
        scene.add_body("wall", "static", shapes=others)
        worlds.append(World(scene))
        worlds[-1].step(40)
    np.testing.assert_array_equal(worlds[0].state.bodies["position"], worlds[1].state.bodies["position"])
    assert worlds[1]._scratches[0].geometry["active"].tolist() == [1, 1, 0, 0]


@BOTH
def test_disabled_joints_make_no_rows(dim: int) -> None:
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    for k in range(2):
        scene.add_body(f"b{k}", shapes=[ball(dim)], position=at(dim, 3.0 * k))
    weld = planar.Weld if dim == 2 else spatial.Weld
    scene.add_joint("weld", weld("b0", "b1", enabled=False))
    scene.add_constraint("rule", ["b0"], along_x(dim), enabled=False)
    world = World(scene, options=AWAKE)
    world.step()
    assert counts(world, "rows", "islands") == (0, 2)


# ---------------------------------------------------------------- compiled code

# kernels that a scene of boxes and balls has no use for
UNNEEDED = {
    2: (
        ".planar.joints.", ".core.joint_rows.", ".methods.joint_factor.", ".planar.joint_readings.",  # no joints
        ".planar.rays.", ".core.rays.", ".core.sensor_readings.", ".planar.narrowphase.polygons.polygon_polygon",
        ".planar.narrowphase.half_planes.half_plane_polygon", ".planar.narrowphase.terrains.",
        ".continuous_collision.first_hit", ".planar.continuous_collision.",
        ".broadphase.find_pairs_by_tree",  # few shapes
        ".methods.newton.", ".methods.soft.",  # not the method asked for
    ),
    3: (
        ".spatial.joints.", ".core.joint_rows.", ".methods.joint_factor.", ".spatial.joint_readings.",
        ".narrowphase.gjk.", ".narrowphase.epa.", ".narrowphase.convex.",  # no hulls and cylinders
        ".narrowphase.heightfields.", ".narrowphase.field_bodies.", ".narrowphase.field_rounds.",
        ".continuous_collision.first_hit", ".spatial.continuous_collision.",
        ".broadphase.find_pairs_by_tree", ".methods.newton.", ".methods.soft.",
        ".spatial.rays.", ".spatial.field_rays.", ".core.rays.", ".core.sensor_readings.",
        ".planar.",
    ),
}  # fmt: skip
NEEDED = {
    2: (".core.step.step_worlds", ".planar.narrowphase.boxes.box_box"),
    3: (".core.step.step_worlds", ".spatial.narrowphase.boxes.best_face"),
}
STEPS = 60


def plain_world(dim: int) -> World:
    """A box at rest on the ground and a ball that falls on it, after STEPS."""
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[ground(dim)])
    for k in range(2):
        box: Any = planar.Box(half_extents=(1, 1)) if dim == 2 else spatial.Box(half_extents=(1, 1, 1))
        scene.add_body(f"box_{k}", shapes=[box], position=at(dim, 0.0, 1.0 + 2.0 * k))
    scene.add_body("ball", shapes=[ball(dim)], position=at(dim, 0.3, 5.0))
    world = World(scene)
    world.step(STEPS)
    world.diagnostics()
    return world


@pytest.mark.slow  # it compiles two kernels, one of them with all features
@BOTH
def test_a_plain_scene_compiles_nothing_that_it_does_not_need(dim: int, tmp_path: Path) -> None:
    """And it moves as with the kernel that has everything, which the other tests share."""
    names = [name_of(kernel) for kernel in all_kernels(gsenv.solver)]
    for part in (*UNNEEDED[dim], *NEEDED[dim]):
        assert any(part in name for name in names), f"{part} names nothing any more"
    code = (
        "from gsenv.solver.jit import compiled_kernels\n"
        "from tests.solver.core.test_skipping import plain_world\n"
        f"print(plain_world({dim}).state.bodies.tobytes().hex())\n"
        "print('\\n'.join(compiled_kernels()))\n"
    )
    # an empty cache, or callees would not be listed; optimised, as unoptimised code has other last bits
    env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), OWN_KERNELS: "1"}
    env.pop(ONE_KERNEL, None)
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=env, capture_output=True, text=True, timeout=900
    )
    bits, *compiled = done.stdout.split()
    for part in NEEDED[dim]:
        assert any(name.endswith(part) for name in compiled)
    assert [name for name in compiled if any(part in name for part in UNNEEDED[dim])] == []
    assert plain_world(dim).state.bodies.tobytes().hex() == bits


def test_a_scene_in_2d_loads_nothing_of_3d() -> None:
    code = (
        "import sys\n"
        "from gsenv.solver import Scene, World\n"
        "from gsenv.solver.planar import Box, Circle, HalfPlane\n"
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
