"""The same bits in space whatever the batch, the threads, the past and the process; golden hashes."""

from __future__ import annotations

import copy
import hashlib
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gsenv.solver import Options, Scene, Snapshot, World
from gsenv.solver.spatial.shapes import Box, Cylinder, Plane, Sphere
from tests.solver.bits import everything
from tests.solver.spatial.mixed import mixed, randomised
from tests.solver.spatial.one_kernel import complete

WORLDS = 8
STEPS = 90
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def batch() -> World:
    """All numbers side by side on one thread, after STEPS."""
    world = randomised(World(mixed(), WORLDS), range(WORLDS))
    world.step(STEPS)
    return world


def test_the_mixed_scene_is_mixed(batch: World) -> None:
    d = batch.diagnostics()
    assert (d.contacts > 20).all()
    assert batch.asleep[:, 3:5].all()
    assert (d.awake > 7).all()
    assert np.isfinite(batch.position).all()
    assert len({batch.position[w].tobytes() for w in range(WORLDS)}) == WORLDS
    assert (np.abs(batch.position[:, 5:, :2]).max((0, 2)) < 5).all(), "something left the bowl"


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_nothing(batch: World, threads: int) -> None:
    world = randomised(World(mixed(), WORLDS, threads=threads), range(WORLDS))
    world.step(STEPS)
    assert everything(world) == everything(batch)


@pytest.mark.parametrize("number", range(WORLDS))
def test_the_batch_changes_nothing(batch: World, number: int) -> None:
    alone = randomised(World(mixed()), range(number, number + 1))
    alone.step(STEPS)
    assert everything(alone, 0) == everything(batch, number)


def test_calls_of_step_change_nothing(batch: World) -> None:
    alone = randomised(World(mixed(), 2, threads=2), range(2))
    for count in (1, 1, 43, STEPS - 45):
        alone.step(count)
    assert everything(alone) == everything(batch, slice(0, 2))


def test_reset_leaves_no_trace(batch: World) -> None:
    world = randomised(World(mixed(), 3), range(20, 23))
    world.step(57)
    world.reset()
    randomised(world, range(3))
    world.step(STEPS)
    assert everything(world) == everything(batch, slice(0, 3))


@pytest.mark.parametrize("threads", [1, 2])
def test_reset_of_one_world_leaves_the_others(batch: World, threads: int) -> None:
    world = randomised(World(mixed(), 3, threads=threads), range(3))
    world.step(30)
    world.reset(1)
    world.step(STEPS - 30)
    assert everything(world, 0) == everything(batch, 0)
    assert everything(world, 2) == everything(batch, 2)
    fresh = World(mixed())
    fresh.step(STEPS - 30)
    assert everything(world, 1) == everything(fresh, 0)


# ---------------------------------------------------------------- snapshots


@pytest.fixture(scope="module")
def halfway() -> tuple[Snapshot, bytes]:
    """World 5 saved in mid-contact, and its bits 40 steps later."""
    world = randomised(World(mixed(), 6), range(6))
    world.step(50)
    assert world.diagnostics().contacts[5] > 10
    assert world.asleep[5].any()
    saved = world.save(5)
    world.step(40)
    return saved, everything(world, 5)


def test_restore_in_place(halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    world = World(mixed(), 3)
    world.step(7)
    others = everything(world, slice(0, 2))
    world.restore(saved, 2)
    assert everything(world, slice(0, 2)) == others
    for _ in range(2):  # a snapshot is not used up
        world.restore(saved, [2])
        world.step(40)
        assert everything(world, 2) == later


def test_restore_into_many_and_into_smaller_buffers(halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    many = World(mixed(), 3, threads=2)
    many.state.contacts = many.state.contacts[:, :2].copy()
    many.restore(saved)
    many.step(40)
    for w in range(3):
        assert everything(many, w) == later


def test_pickled_and_copied_worlds_go_on(batch: World) -> None:
    world = randomised(World(mixed(), 2), range(2))
    world.step(40)
    for twin in (pickle.loads(pickle.dumps(world)), copy.deepcopy(world)):
        twin.step(STEPS - 40)
        assert everything(twin) == everything(batch, slice(0, 2))


def test_another_process_continues(halfway: tuple[Snapshot, bytes], tmp_path: Path) -> None:
    saved, later = halfway
    (tmp_path / "saved").write_bytes(pickle.dumps(saved))
    code = (
        "import pickle, sys\n"
        "from gsenv.solver import World\n"
        "from tests.solver.bits import everything\n"
        "from tests.solver.spatial.mixed import mixed\n"
        "world = World(mixed(), 2)\n"
        "world.restore(pickle.loads(open(sys.argv[1], 'rb').read()), 1)\n"
        "world.step(40)\n"
        "open(sys.argv[2], 'wb').write(everything(world, 1))\n"
    )
    files = [str(tmp_path / "saved"), str(tmp_path / "later")]
    subprocess.run([sys.executable, "-c", code, *files], check=True, cwd=ROOT, timeout=600)
    assert (tmp_path / "later").read_bytes() == later


# ---------------------------------------------------------------- golden hashes


def tumble() -> World:
    """Turned boxes, drums and balls fall onto each other: chaotic enough to show a change of one bit."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[Plane()])
    shapes = (
        Sphere(radius=0.3, restitution=0.5),
        Box(half_extents=(0.4, 0.25, 0.3)),
        Cylinder(half_length=0.3, radius=0.2),
    )
    for k in range(12):
        place = (0.15 * (k % 4), 0.1 * (k % 3), 0.6 + 0.7 * k)
        scene.add_body(f"b{k}", shapes=[shapes[k % 3]], position=place, rotation=(1, 0.3 * k, 0.2, -0.1 * k))
    return World(complete(scene))


def chain() -> World:
    """Links on ball joints that swing and turn, and a soft weld at the end."""
    scene = Scene(dim=3)
    scene.add_body("top", "static")
    last = "top"
    for k in range(8):
        link = Box(half_extents=(0.2, 0.05, 0.03))
        scene.add_body(f"link_{k}", shapes=[link], position=(0.4 * k + 0.2, 0, 0), angular_velocity=(k, 0, 1))
        scene.add_joint(f"pin_{k}", "ball", last, f"link_{k}", anchor=(0.4 * k, 0, 0))
        last = f"link_{k}"
    scene.add_body("end", shapes=[Sphere(radius=0.1)], position=(3.3, 0, 0.2))
    scene.add_joint("soft", "weld", last, "end", frequency=3.0, damping_ratio=0.1)
    return World(complete(scene), options=Options(sleep=False))


# After an intended change of the physics: python -m tests.solver.spatial.test_spatial_determinism
GOLDEN = {
    "mixed": "5575593dcd035742df5b63900d58c5f3c9e01e698203fa491519c8646569b378",
    "tumble": "1855bac1a2e5754e184b644d2227e9fd343bdf70dde0066e9f1ca924c2a79ae7",
    "chain": "f9c4b673bcff1071d829dd41dc8a7bdc242b16222dee737ab0c9f3ff954749a3",
}


def golden(name: str) -> str:
    """sha256 of where all bodies are and how they move."""
    world = {"mixed": lambda: randomised(World(mixed(), 2), range(2)), "tumble": tumble, "chain": chain}[name]()
    world.step(120)
    bodies = world.state.bodies
    parts = [np.ascontiguousarray(bodies[field], "<f8").tobytes() for field in ("position", "rotation", "velocity")]
    return hashlib.sha256(b"".join(parts)).hexdigest()


@pytest.mark.parametrize("name", GOLDEN)
def test_golden_hash(name: str) -> None:
    # no libm, no FMA, no fastmath: these bits are the same on every machine
    assert golden(name) == GOLDEN[name]


if __name__ == "__main__":
    for each in GOLDEN:
        print(f'    "{each}": "{golden(each)}",')
