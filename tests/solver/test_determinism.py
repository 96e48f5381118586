"""The same bits for any batch, thread count, history, process and machine."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gsenv.scenes import pyramid, stack
from gsenv.solver import Box, Capsule, Circle, HalfPlane, Options, Polygon, Scene, Snapshot, Terrain, World
from tests.solver.bits import everything, motion_hash

WORLDS = 64
STEPS = 90
ROOT = Path(__file__).parents[2]


def mixed() -> Scene:
    """One of everything: all shapes, terrain, restitution, welds, a drive, islands that fall asleep."""
    scene = Scene()
    x = np.linspace(-6.0, 6.0, 25)
    hills = np.stack([x, 0.2 * (x / 3.0) ** 2 * (1.0 - (x / 9.0) ** 2)], 1)
    scene.add_body("hills", kind="static", shapes=[Terrain(vertices=hills, friction=0.8)])
    scene.add_body("shelf", kind="static", shapes=[Box(half_extents=(2, 0.1))], position=(-20, 0))
    for k in range(2):  # asleep after half a second
        scene.add_body(f"idle_{k}", shapes=[Box(half_extents=(0.2, 0.2))], position=(-20, 0.3 + 0.4 * k))
    for k in range(3):
        box = Box(half_extents=(0.3, 0.2))
        scene.add_body(f"box_{k}", shapes=[box], position=(0.1 * k, 1.0 + 0.5 * k), angle=0.3 * k)
    for k in range(2):
        ball = Circle(radius=0.2, restitution=0.6)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(1.0 - 2.2 * k, 2.5 + k), linear_velocity=(1 - k, -2))
    pill = Capsule(half_length=0.3, radius=0.1)
    scene.add_body("pill", shapes=[pill], position=(-1.0, 1.5), angle=0.7, angular_velocity=4.0)
    scene.add_body("rock", shapes=[Polygon(vertices=[(-0.3, -0.2), (0.3, -0.2), (0.1, 0.3)])], position=(1.4, 1.2))
    scene.add_joint("stick", "weld", "pill", "rock", collide=True, enabled=False)
    scene.add_body("tail", shapes=[Box(half_extents=(0.1, 0.1))], position=(-1.5, 1.5))
    scene.add_joint("spring", "weld", "pill", "tail", frequency=4.0, damping_ratio=0.3)
    hand = Box(half_extents=(0.2, 0.05), friction=1.0)
    scene.add_body("hand", shapes=[hand], position=(3.0, 1.5), gravity_scale=0.0)
    scene.add_joint("arm", "target", body_b="hand", max_force=60.0, max_torque=10.0)
    scene.add_actuator("arm_x", "arm", "x")
    scene.add_actuator("arm_y", "arm", "y", lower=-1.0, upper=1.0)
    return scene


def randomised(world: World, numbers: range) -> World:
    """World w gets the parameters and the control of number numbers[w]."""
    for w, number in enumerate(numbers):
        random = np.random.default_rng(number)
        friction, mass, gravity, half, pull, x, y = random.uniform(0.0, 1.0, 7)
        world.parameters.set("box_1", friction=friction, worlds=w)
        world.parameters.set("box_2", mass=0.1 + 5.0 * mass, worlds=w)
        world.parameters.set("box_0", half_extents=(0.2 + 0.2 * half, 0.2), worlds=w)
        world.parameters.set(gravity=(0.0, -5.0 - 6.0 * gravity), worlds=w)
        if number % 3 == 0:
            world.parameters.set("ball_1", enabled=False, worlds=w)
        world.apply_force("pill", (20.0 * pull, 0.0), worlds=w)
        world.control[w] = (-2.0 * x, 1.0 - 2.0 * y)
    return world


@pytest.fixture(scope="module")
def batch() -> World:
    """All numbers side by side on one thread, after STEPS."""
    world = randomised(World(mixed(), WORLDS), range(WORLDS))
    world.step(STEPS)
    return world


def test_the_mixed_scene_is_mixed(batch: World) -> None:
    d = batch.diagnostics()
    assert (d.contacts > 8).all()
    assert batch.asleep[:, 2:4].all()
    assert (d.awake > 5).all()
    assert np.isfinite(batch.position).all()
    assert len({batch.position[w].tobytes() for w in range(WORLDS)}) == WORLDS
    reach = np.abs(batch.position[:, 4:]).max((0, 2))
    assert (reach < 9).all(), "something fell off the hills"


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_nothing(batch: World, threads: int) -> None:
    world = randomised(World(mixed(), WORLDS, threads=threads), range(WORLDS))
    world.step(STEPS)
    assert everything(world) == everything(batch)


def test_the_batch_changes_nothing(batch: World) -> None:
    for number in (0, 7, WORLDS - 1):
        alone = randomised(World(mixed()), range(number, number + 1))
        alone.step(STEPS)
        assert everything(alone, 0) == everything(batch, number)


def test_calls_of_step_change_nothing(batch: World) -> None:
    alone = randomised(World(mixed(), 2, threads=2), range(2))
    for count in (1, 1, 40, 3, STEPS - 45):
        alone.step(count)
    assert everything(alone) == everything(batch, slice(0, 2))


def test_reset_leaves_no_trace(batch: World) -> None:
    world = randomised(World(mixed(), 3), range(20, 23))
    world.step(57)
    world.reset()
    randomised(world, range(3))
    world.step(STEPS)
    assert everything(world) == everything(batch, slice(0, 3))


def test_reset_of_one_world_leaves_the_others(batch: World) -> None:
    world = randomised(World(mixed(), 3), range(3))
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
    world = randomised(World(mixed(), 8), range(8))
    world.step(50)
    assert world.diagnostics().contacts[5] > 5
    assert world.asleep[5].any()
    saved = world.save(5)
    world.step(40)
    return saved, everything(world, 5)


def test_restore_in_place(halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    world = World(mixed(), 8)
    world.step(7)
    others = everything(world, slice(0, 5))
    world.restore(saved, 5)
    assert everything(world, slice(0, 5)) == others
    for _ in range(2):  # a snapshot is not used up
        world.restore(saved, [5])
        world.step(40)
        assert everything(world, 5) == later


def test_restore_elsewhere(halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    many = World(mixed(), 4, threads=2)
    many.restore(saved)  # one into many
    many.step(40)
    for w in range(4):
        assert everything(many, w) == later
    single = World(mixed().compile())
    single.restore(saved, 0)
    single.step(40)
    assert everything(single, 0) == later


def test_saving_disturbs_nothing_and_copies() -> None:
    world, twin = (randomised(World(mixed(), 2), range(2)) for _ in range(2))
    world.step(30)
    saved = world.save()
    before = pickle.dumps(saved)
    world.step(30)
    assert pickle.dumps(saved) == before
    twin.step(60)
    assert everything(world) == everything(twin)


def test_restore_into_smaller_buffers(halfway: tuple[Snapshot, bytes]) -> None:
    saved, later = halfway
    world = World(mixed())
    world.state.contacts = world.state.contacts[:, :2].copy()
    world.restore(saved)
    world.step(40)
    assert everything(world, 0) == later


def test_wrong_snapshots_are_refused(halfway: tuple[Snapshot, bytes]) -> None:
    saved, _ = halfway
    world = World(stack(2), 2)
    before = everything(world)
    with pytest.raises(ValueError, match="another scene"):
        world.restore(saved)
    two = World(mixed(), 2).save()
    three = World(mixed(), 3)
    with pytest.raises(ValueError, match="2 saved worlds do not fit into 3"):
        three.restore(two)
    with pytest.raises(ValueError, match="worlds"):
        three.save(9)
    assert everything(world) == before


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
        "from tests.solver.test_determinism import mixed\n"
        "world = World(mixed(), 2)\n"
        "world.restore(pickle.loads(open(sys.argv[1], 'rb').read()), 1)\n"
        "world.step(40)\n"
        "open(sys.argv[2], 'wb').write(everything(world, 1))\n"
    )
    files = [str(tmp_path / "saved"), str(tmp_path / "later")]
    subprocess.run([sys.executable, "-c", code, *files], check=True, cwd=ROOT, timeout=300)
    assert (tmp_path / "later").read_bytes() == later


# ---------------------------------------------------------------- golden hashes


def tumble() -> World:
    """Turned boxes and balls fall onto each other: chaotic enough to show a change of one bit."""
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    for k in range(12):
        shape = Circle(radius=0.3, restitution=0.5) if k % 3 == 0 else Box(half_extents=(0.4, 0.25))
        scene.add_body(f"b{k}", shapes=[shape], position=(0.15 * (k % 4), 0.6 + 0.7 * k), angle=0.4 * k)
    return World(scene)


# After an intended change of the physics: python -m tests.solver.test_determinism
GOLDEN = {
    "mixed": "f39f8e008a8f26dc1a1f448bbfa6bca3382f756415c2b9f7c7b13b0a05a7d9ff",
    "tumble": "659645b10ca249396ae0c409ca3012d315ce194dc1c330f736b45113393f7f46",
    "pyramid": "edb5f93318832ff604f2b0f0c3f8760b3a8dd4c42e721d2a0531ba6bb7c82121",
}


def golden(name: str) -> str:
    if name == "mixed":
        world, steps = randomised(World(mixed(), 2), range(2)), 120
    elif name == "tumble":
        world, steps = tumble(), 180
    else:
        world, steps = World(pyramid(6), options=Options(sleep=False)), 120
    world.step(steps)
    return motion_hash(world)


@pytest.mark.parametrize("name", GOLDEN)
def test_golden_hash(name: str) -> None:
    # no libm, no FMA, no fastmath: these bits are the same on every machine
    assert golden(name) == GOLDEN[name]


if __name__ == "__main__":
    for each in GOLDEN:
        print(f'    "{each}": "{golden(each)}",')
