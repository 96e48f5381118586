"""Bodies that are hit within a step meet others on their new ways in the same step."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.records.scratch import Scratch
from gsenv.solver.spatial import Plane, Sphere

RADIUS = 0.05


def shot(gaps: list[float], speed: float = 5.0, restitution: float = 0.0, mass: float = 1.0) -> Scene:
    """A ball of ``mass`` hits the first of a row of balls at rest, ``gaps`` m apart; no gravity."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    ball = Sphere(radius=RADIUS, friction=0.0, restitution=restitution)
    x = 0.0
    scene.add_body("cue", shapes=[ball], position=(x, 0.0, 0.0), mass=mass, linear_velocity=(speed, 0.0, 0.0))
    for k, gap in enumerate(gaps):
        x += 2.0 * RADIUS + gap
        scene.add_body(f"ball_{k}", shapes=[ball], position=(x, 0.0, 0.0), mass=1.0)
    return scene


def overlap(world: World) -> float:
    """m, deepest of any two neighbours of the row."""
    x = world.position[0, :, 0]
    return float((2.0 * RADIUS - np.diff(x)).max())


@pytest.mark.parametrize("substeps", [1, 2, 8])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("mass", [0.5, 1.0, 20.0])
def test_a_ball_that_is_hit_meets_its_neighbour_in_the_same_step(
    substeps: int, restitution: float, mass: float
) -> None:
    world = World(shot([0.01, 0.01], 5.0, restitution, mass), options=Options(substeps=substeps))
    for _ in range(3):
        world.step()
        assert overlap(world) < 0.01 * RADIUS


def test_what_passes_by_is_no_contact() -> None:
    """Side by side in free flight, and past a ball at rest: neither contacts nor islands."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, -9.81))
    for k in range(3):
        speed = (5.0 * (k > 0), 0.0, 0.0)
        y = k * (2.0 * RADIUS + 0.01)
        ball = Sphere(radius=RADIUS)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0.0, y, 1.0), linear_velocity=speed)
    world = World(scene)
    world.step()
    assert world.diagnostics().contacts[0] == 0
    assert world.diagnostics().islands[0] == 3


def test_falling_layers_land_on_each_other() -> None:
    """A column with gaps, whose lowest ball stops on the ground: those above stop in the same step."""
    scene = Scene(dim=3)
    scene.add_body("ground", kind="static", shapes=[Plane(friction=0.0)])
    for k in range(4):
        z = 1.001 * RADIUS + 2.1 * RADIUS * k
        ball = Sphere(radius=RADIUS, friction=0.0)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0.0, 0.0, z), linear_velocity=(0.0, 0.0, -4.0))
    world = World(scene)
    world.step()
    heights = world.position[0, 1:, 2]
    assert (2.0 * RADIUS - np.diff(heights)).max() < 0.01 * RADIUS


def test_impulses_of_the_step_are_the_change_of_momentum() -> None:
    world = World(shot([0.01, 0.01]))
    before = np.array(world.linear_velocity[0, :, 0])
    world.step()
    change = world.linear_velocity[0, :, 0] - before
    contacts = world.contacts(0)
    pushed = np.zeros(3)
    np.add.at(pushed, contacts.body_b, contacts.impulse[:, 0])
    np.add.at(pushed, contacts.body_a, -contacts.impulse[:, 0])
    assert len(contacts) == 2
    np.testing.assert_allclose(pushed, change, atol=1e-9)  # balls of 1 kg


def test_more_contacts_than_fit_in_the_second_look() -> None:
    """The ball behind is found only when what is hit is looked at again; the step is then taken anew, the same."""
    scene = shot([0.01, 0.01, 0.01])
    plenty = World(scene)
    tight = World(scene)
    tight.state.contacts = tight.state.contacts[:, :1].copy()
    for _ in range(4):
        plenty.step()
        tight.step()
        for name in ("bodies", "worlds"):
            assert getattr(tight.state, name).tobytes() == getattr(plenty.state, name).tobytes()
    assert tight.state.contacts.shape[1] > 1


def test_more_pairs_than_fit_in_the_second_look(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same of pairs of shapes."""
    scene = shot([0.01, 0.01, 0.01])
    asked = []
    grow = Scratch.grow_pairs

    def grow_from_one(scratch: Scratch, capacity: int) -> None:
        asked.append(capacity)
        grow(scratch, 1 if len(asked) == 1 else capacity)

    plenty = World(scene)
    plenty.step(4)
    monkeypatch.setattr(Scratch, "grow_pairs", grow_from_one)
    tight = World(scene)
    tight.step(4)
    assert len(asked) > 1
    for name in ("bodies", "worlds"):
        assert getattr(tight.state, name).tobytes() == getattr(plenty.state, name).tobytes()


def test_worlds_threads_and_restored_worlds_keep_the_bits() -> None:
    scene = shot([0.01, 0.02])
    one = World(scene)
    many = World(scene, world_count=3, threads=2)
    many.set_velocity("cue", linear=(-5.0, 0.0, 0.0), worlds=[1])  # another state in between
    for _ in range(2):
        one.step()
        many.step()
    restored = World(scene)
    restored.restore(many.save(2))
    for world in (one, many, restored):
        world.step(2)
    for w in (0, 2):
        assert many.state.bodies[w].tobytes() == one.state.bodies[0].tobytes()
    assert restored.state.bodies.tobytes() == one.state.bodies.tobytes()
