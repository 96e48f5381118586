"""Masses on springs: a single one, which has a closed-form solution, and a soft block."""

from __future__ import annotations

from itertools import product

from gsenv.solver import Scene
from gsenv.solver.planar import Circle, Distance

from .palette import AMBER, WARM
from .stacks import ground


def spring_mass(
    frequency: float = 2.0,
    damping_ratio: float = 0.0,
    stretch: float = 0.1,
    gravity: float = 9.81,
    length: float = 1.0,
) -> Scene:
    """Build a mass of 1 kg on a spring that hangs from the origin, released at rest.

    The spring has a rest length of ``length`` m and, with the mass, a frequency of ``frequency`` Hz; it starts
    stretched by ``stretch`` m. In equilibrium it is stretched by gravity / (2 pi frequency)^2.
    """
    scene = Scene(gravity=(0.0, -gravity))
    scene.add_body("hook", kind="static")
    scene.add_body("bob", shapes=[Circle(radius=0.1)], position=(0.0, -length - stretch), mass=1.0)
    scene.add_joint(
        "spring",
        Distance(
            "hook",
            "bob",
            anchor_a=(0.0, 0.0),
            anchor_b=(0.0, 0.0),
            length=length,
            frequency=frequency,
            damping_ratio=damping_ratio,
        ),
    )
    return scene


def jelly(
    columns: int = 7,
    rows: int = 5,
    pitch: float = 0.5,
    height: float = 2.5,
    frequency: float = 8.0,
    damping_ratio: float = 0.1,
) -> Scene:
    """Build a block of balls ``pitch`` m apart, joined by springs along rows, columns and diagonals.

    It is dropped with its lowest points at ``height`` m. ``frequency`` in Hz and ``damping_ratio`` are those of a
    single spring between two free balls.
    """
    scene = Scene()
    ground(scene, friction=0.6)
    radius = 0.24 * pitch
    for row in range(rows):
        for column in range(columns):
            position = ((column - 0.5 * (columns - 1)) * pitch, height + radius + row * pitch)
            ball = Circle(radius=radius, friction=0.6)
            inside = 0 < row < rows - 1 and 0 < column < columns - 1
            scene.add_body(_ball(row, column), shapes=[ball], position=position, color=AMBER if inside else WARM)
    for row, column, up, right in product(range(rows), range(columns), (0, 1), (-1, 0, 1)):
        if (up, right) > (0, 0) and row + up < rows and 0 <= column + right < columns:
            scene.add_joint(
                f"spring_{row}_{column}_{up}_{right}",
                Distance(
                    _ball(row, column),
                    _ball(row + up, column + right),
                    anchor_a=(0.0, 0.0),
                    anchor_b=(0.0, 0.0),
                    frequency=frequency,
                    damping_ratio=damping_ratio,
                    collide=True,
                ),
            )
    return scene


def _ball(row: int, column: int) -> str:
    return f"ball_{row}_{column}"
