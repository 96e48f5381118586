"""Hashes of motions: no libm, no FMA, no fastmath, so these bits are the same on every machine.

After an intended change of the physics: python -m tests.solver.api.test_golden_hashes
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from gsenv.scenes import pyramid
from gsenv.solver import Options, Scene, World, planar, spatial
from tests.solver.api.mixed import mixed, randomised
from tests.solver.bits import motion_hash
from tests.solver.spatial.one_kernel import complete

AWAKE = Options(sleep=False)


def planar_tumble() -> Scene:
    """Turned boxes and balls fall onto each other: chaotic enough to show a change of one bit."""
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[planar.HalfPlane()])
    ball, box = planar.Circle(radius=0.3, restitution=0.5), planar.Box(half_extents=(0.4, 0.25))
    for k in range(12):
        shape = ball if k % 3 == 0 else box
        scene.add_body(f"b{k}", shapes=[shape], position=(0.15 * (k % 4), 0.6 + 0.7 * k), angle=0.4 * k)
    return scene


def spatial_tumble() -> Scene:
    """The same with drums."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[spatial.Plane()])
    shapes = (
        spatial.Sphere(radius=0.3, restitution=0.5),
        spatial.Box(half_extents=(0.4, 0.25, 0.3)),
        spatial.Cylinder(half_length=0.3, radius=0.2),
    )
    for k in range(12):
        place = (0.15 * (k % 4), 0.1 * (k % 3), 0.6 + 0.7 * k)
        scene.add_body(f"b{k}", shapes=[shapes[k % 3]], position=place, orientation=(1, 0.3 * k, 0.2, -0.1 * k))
    return complete(scene)


def spatial_chain() -> Scene:
    """Links on ball joints that swing and turn, and a soft weld at the end."""
    scene = Scene(dim=3)
    scene.add_body("top", "static")
    last = "top"
    for k in range(8):
        link = spatial.Box(half_extents=(0.2, 0.05, 0.03))
        scene.add_body(f"link_{k}", shapes=[link], position=(0.4 * k + 0.2, 0, 0), angular_velocity=(k, 0, 1))
        scene.add_joint(f"pin_{k}", spatial.Ball(last, f"link_{k}", anchor=(0.4 * k, 0, 0)))
        last = f"link_{k}"
    scene.add_body("end", shapes=[spatial.Sphere(radius=0.1)], position=(3.3, 0, 0.2))
    scene.add_joint("soft", spatial.Weld(last, "end", frequency=3.0, damping_ratio=0.1))
    return complete(scene)


WORLDS: dict[str, tuple[Callable[[], World], int]] = {  # and how many steps
    "2D mixed": (lambda: randomised(World(mixed(2), 2), range(2)), 120),
    "2D tumble": (lambda: World(planar_tumble()), 180),
    "2D pyramid": (lambda: World(pyramid(6), options=AWAKE), 120),
    "3D mixed": (lambda: randomised(World(mixed(3), 2), range(2)), 120),
    "3D tumble": (lambda: World(spatial_tumble()), 120),
    "3D chain": (lambda: World(spatial_chain(), options=AWAKE), 120),
}
GOLDEN = {
    "2D mixed": "6cbe50d4b05028318199aa2002a63cb19f83fead0299c635b0d2aaae52746539",
    "2D tumble": "b3d4a2844400e6bc52d9185d459a738a4046fe90f74ff7884e1ce245194ac0a6",
    "2D pyramid": "b16dae00c99eac503e1e2c3e23eb4902c3185eec3b7079e54e65fa10bdb98f5f",
    "3D mixed": "94f206de8d3e42001787427a130bb11e83dfc6e56a5108cc7068c9db7e7e7ed2",
    "3D tumble": "b4791f673b6a2be5879c95d7e6002b4f1ff88a2b4ea76e8d982ec00ada8e99b4",
    "3D chain": "13a3abbf82d14d4c38ee9162d142d15f9872b1245f27ceae8cd3c9d7be09d53e",
}


def motion_after(name: str) -> str:
    build, steps = WORLDS[name]
    world = build()
    world.step(steps)
    return motion_hash(world)


@pytest.mark.parametrize("name", GOLDEN)
def test_golden_hash(name: str) -> None:
    assert motion_after(name) == GOLDEN[name]


if __name__ == "__main__":
    for each in GOLDEN:
        print(f'    "{each}": "{motion_after(each)}",')
