"""The same bits for any batch, thread count, history, process and machine."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gsenv.solver import Scene, Snapshot, World
from tests.solver.api.mixed import mixed, randomised
from tests.solver.bits import everything

WORLDS = {2: 64, 3: 8}
ALONE = {2: (0, 7, 63), 3: range(8)}  # worlds of the batch that are compared with ones stepped alone
STEPS = 90
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module", params=[2, 3], ids=["2D", "3D"])
def dim(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture(scope="module")
def batch(dim: int) -> World:
    """All numbers side by side on one thread, after STEPS."""
    world = randomised(World(mixed(dim), WORLDS[dim]), range(WORLDS[dim]))
    world.step(STEPS)
    return world


def test_the_mixed_scene_is_mixed(dim: int, batch: World) -> None:
    d = batch.diagnostics()
    fixed = 2 if dim == 2 else 3  # hills, floor and shelf come first, then two boxes that fall asleep
    contacts, awake, width = {2: (8, 5, 9.0), 3: (20, 7, 5.0)}[dim]
    assert (d.contacts > contacts).all()
    assert (d.awake > awake).all()
    assert batch.asleep[:, fixed : fixed + 2].all()
    assert np.isfinite(batch.position).all()
    assert len({batch.position[w].tobytes() for w in range(WORLDS[dim])}) == WORLDS[dim]
    assert (np.abs(batch.position[:, fixed + 2 :, :2]).max((0, 2)) < width).all(), "something fell off the hills"


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_nothing(dim: int, batch: World, threads: int) -> None:
    world = randomised(World(mixed(dim), WORLDS[dim], threads=threads), range(WORLDS[dim]))
    world.step(STEPS)
    assert everything(world) == everything(batch)


def test_the_batch_changes_nothing(dim: int, batch: World) -> None:
    for number in ALONE[dim]:
        alone = randomised(World(mixed(dim)), range(number, number + 1))
        alone.step(STEPS)
        assert everything(alone, 0) == everything(batch, number)


def test_calls_of_step_change_nothing(dim: int, batch: World) -> None:
    alone = randomised(World(mixed(dim), 2, threads=2), range(2))
    for count in (1, 1, 40, 3, STEPS - 45):
        alone.step(count)
    assert everything(alone) == everything(batch, slice(0, 2))


def test_reset_leaves_no_trace(dim: int, batch: World) -> None:
    world = randomised(World(mixed(dim), 3), range(20, 23))
    world.step(57)
    world.reset()
    randomised(world, range(3))
    world.step(STEPS)
    assert everything(world) == everything(batch, slice(0, 3))


@pytest.mark.parametrize("threads", [1, 2])
def test_reset_of_one_world_leaves_the_others(dim: int, batch: World, threads: int) -> None:
    world = randomised(World(mixed(dim), 3, threads=threads), range(3))
    world.step(30)
    world.reset(1)
    world.step(STEPS - 30)
    assert everything(world, 0) == everything(batch, 0)
    assert everything(world, 2) == everything(batch, 2)
    fresh = World(mixed(dim))
    fresh.step(STEPS - 30)
    assert everything(world, 1) == everything(fresh, 0)


# ---------------------------------------------------------------- snapshots


@pytest.fixture(scope="module")
def halfway(dim: int) -> tuple[Snapshot, bytes]:
    """World 5 saved in mid-contact, and its bits 40 steps later."""
    world = randomised(World(mixed(dim), 8), range(8))
    world.step(50)
    assert world.diagnostics().contacts[5] > {2: 5, 3: 10}[dim]
    assert world.asleep[5].any()
    saved = world.save(5)
    world.step(40)
    return saved, everything(world, 5)


def test_restore_in_place(dim: int, halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    world = World(mixed(dim), 8)
    world.step(7)
    others = everything(world, slice(0, 5))
    world.restore(saved, 5)
    assert everything(world, slice(0, 5)) == others
    for _ in range(2):  # a snapshot is not used up
        world.restore(saved, [5])
        world.step(40)
        assert everything(world, 5) == later


def test_restore_elsewhere(dim: int, halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    many = World(mixed(dim), 4, threads=2)
    many.restore(saved)  # one into many
    many.step(40)
    for w in range(4):
        assert everything(many, w) == later
    single = World(mixed(dim).compile())
    single.restore(saved, 0)
    single.step(40)
    assert everything(single, 0) == later


@pytest.mark.parametrize("threads", [1, 2])
def test_restore_into_smaller_buffers(dim: int, halfway: tuple[Snapshot, bytes], threads: int) -> None:
    saved, later = halfway
    world = World(mixed(dim), threads, threads=threads)
    world.state.contacts = world.state.contacts[:, :2].copy()
    world.restore(saved)
    world.step(40)
    for w in range(threads):
        assert everything(world, w) == later


def test_saving_disturbs_nothing_and_copies(dim: int) -> None:
    world, twin = (randomised(World(mixed(dim), 2), range(2)) for _ in range(2))
    world.step(30)
    saved = world.save()
    before = pickle.dumps(saved)
    world.step(30)
    assert pickle.dumps(saved) == before
    twin.step(60)
    assert everything(world) == everything(twin)


def test_wrong_snapshots_are_refused(dim: int, halfway: tuple[Snapshot, bytes]) -> None:
    saved, _ = halfway
    scene = Scene(dim=dim)
    scene.add_body("other", "static")
    world = World(scene, 2)
    before = everything(world)
    with pytest.raises(ValueError, match="another scene"):
        world.restore(saved)
    two = World(mixed(dim), 2).save()
    three = World(mixed(dim), 3)
    with pytest.raises(ValueError, match="2 saved worlds do not fit into 3"):
        three.restore(two)
    with pytest.raises(ValueError, match="worlds"):
        three.save(9)
    assert everything(world) == before


def test_pickled_and_copied_worlds_go_on(dim: int, batch: World) -> None:
    world = randomised(World(mixed(dim), 2), range(2))
    world.step(40)
    for twin in (pickle.loads(pickle.dumps(world)), copy.deepcopy(world)):
        twin.step(STEPS - 40)
        assert everything(twin) == everything(batch, slice(0, 2))


def test_another_process_continues(dim: int, halfway: tuple[Snapshot, bytes], tmp_path: Path) -> None:
    saved, later = halfway
    (tmp_path / "saved").write_bytes(pickle.dumps(saved))
    code = (
        "import pickle, sys\n"
        "from gsenv.solver import World\n"
        "from tests.solver.api.mixed import mixed\n"
        "from tests.solver.bits import everything\n"
        f"world = World(mixed({dim}), 2)\n"
        "world.restore(pickle.loads(open(sys.argv[1], 'rb').read()), 1)\n"
        "world.step(40)\n"
        "open(sys.argv[2], 'wb').write(everything(world, 1))\n"
    )
    files = [str(tmp_path / "saved"), str(tmp_path / "later")]
    subprocess.run([sys.executable, "-c", code, *files], check=True, cwd=ROOT, timeout=600)
    assert (tmp_path / "later").read_bytes() == later
