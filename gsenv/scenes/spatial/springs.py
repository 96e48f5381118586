"""A soft cube of balls and springs."""

from __future__ import annotations

from itertools import product

from gsenv.solver import Scene
from gsenv.solver.spatial import Distance, Sphere

from ..palette import AMBER, WARM
from .stacks import ground

Place = tuple[int, int, int]


def soft_cube(
    side: int = 4, pitch: float = 0.5, height: float = 1.5, frequency: float = 8.0, damping_ratio: float = 0.1
) -> Scene:
    """Build ``side``^3 balls ``pitch`` m apart, joined by springs along edges and diagonals.

    The cube is dropped with its lowest points at ``height`` m. ``frequency`` in Hz and ``damping_ratio`` are those of
    a single spring between two free balls.
    """
    scene = Scene(dim=3)
    ground(scene, friction=0.6)
    radius = 0.24 * pitch
    middle = 0.5 * (side - 1)
    places = list(product(range(side), range(side), range(side)))
    for i, j, k in places:
        position = ((i - middle) * pitch, (j - middle) * pitch, height + radius + k * pitch)
        inside = all(0 < n < side - 1 for n in (i, j, k))
        ball = Sphere(radius=radius, friction=0.6)
        scene.add_body(_ball((i, j, k)), shapes=[ball], position=position, color=AMBER if inside else WARM)
    for place, step in product(places, product((-1, 0, 1), repeat=3)):
        other = (place[0] + step[0], place[1] + step[1], place[2] + step[2])
        if step > (0, 0, 0) and all(0 <= n < side for n in other):
            scene.add_joint(
                f"spring_{_ball(place)}_{_ball(other)}",
                Distance(
                    _ball(place),
                    _ball(other),
                    anchor_a=(0.0, 0.0, 0.0),
                    anchor_b=(0.0, 0.0, 0.0),
                    frequency=frequency,
                    damping_ratio=damping_ratio,
                    collide=True,
                ),
            )
    return scene


def _ball(place: Place) -> str:
    return "ball_" + "_".join(map(str, place))
