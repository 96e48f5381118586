"""Random scenes of jointed bodies that try to break the solver.

``random_jointed_case(seed)`` is a function of the seed alone; measure.py says what is promised of it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Circle, Distance, Gear, Revolute, Wheel
from tests.solver.joints import make_joint

from .cases import Array, Build, Case, ground, log_uniform, random_options

CATEGORIES = (
    "chain", "taut", "spinning", "ragdolls", "heap", "ring", "rope", "springs", "sliders", "bouncy",
    "contradictory", "motors", "gears", "cars",
)  # fmt: skip
DRIVEN = ("motors", "gears", "cars")


def random_jointed_case(seed: int, category: str | None = None) -> Case:
    """The case of a seed; its category follows from the seed unless it is given."""
    rng = np.random.default_rng([seed, 3])
    category = CATEGORIES[seed % len(CATEGORIES)] if category is None else category
    options = random_options(rng)
    pull = 0.0 if category == "spinning" else float(rng.choice([9.81, 9.81, 9.81, 9.81, 50.0]))
    build = Build(
        rng,
        Scene(gravity=(0.0, -pull)),
        kinds=("box", "capsule", "circle"),
        size=log_uniform(rng, 0.05, 1.0),
        friction=(0.0, 1.0),
        restitution=(0.0, 1.0) if category == "bouncy" else (0.0, 0.0),
    )
    drive, slack = _BUILDERS[category](build)
    overlapping = category not in ("taut", "spinning", "sliders")
    return Case(seed, category, build.scene, options, category in DRIVEN, overlapping, drive, slack)


def _link(build: Build, length: float, density: float = 1.0) -> Any:
    """A box or capsule along its own y axis, from -length/2 to length/2."""
    width = length * float(build.rng.uniform(0.05, 0.3))
    common = {**build.material(), "density": density}
    if build.rng.random() < 0.5:
        return Box(half_extents=(0.5 * width, 0.5 * length), **common)
    return Capsule(half_length=0.5 * length, radius=0.5 * width, angle=0.5 * math.pi, **common)


def _chain(
    build: Build, start: Array, heading: float, count: int, bend: float, holder: str | None, end_ratio: float = 1.0,
    limits: float | None = None, spin: float = 0.0,
) -> list[str]:  # fmt: skip
    """Links one after another from ``start``, each turned by up to ``bend`` rad; moving as one rigid body."""
    rng = build.rng
    place = np.array(start, float)
    names: list[str] = []
    for k in range(count):
        heading += float(rng.uniform(-bend, bend))
        along = np.array([math.sin(heading), -math.cos(heading)])
        length = build.size * float(rng.uniform(0.7, 1.3))
        middle = place + 0.5 * length * along
        arm = middle - start
        name = f"body_{build.count}"
        density = log_uniform(rng, 1.0, end_ratio) if k < count - 1 else end_ratio
        build.add(
            [_link(build, length, density)],
            position=middle.tolist(),
            angle=heading,
            linear_velocity=(-spin * arm[1], spin * arm[0]),
            angular_velocity=spin,
        )
        before = names[-1] if names else holder
        if before is not None:
            bounds = None if limits is None else (-limits, limits)
            build.scene.add_joint(f"pin_{name}", Revolute(before, name, anchor=place.tolist(), limits=bounds))
        names.append(name)
        place = place + length * along
    return names


def _hook(build: Build, height: float) -> str:
    build.scene.add_body("hook", "static", [], position=(0.0, height))
    return "hook"


def _fill_chain(build: Build) -> tuple[float, float]:
    """Swinging over a floor that they reach, or falling on it."""
    count = int(build.rng.integers(1, 16))
    height = build.size * count * float(build.rng.uniform(0.5, 1.5))
    hook = _hook(build, height) if build.rng.random() < 0.7 else None
    _chain(build, np.array([0.0, height]), float(build.rng.uniform(-2.5, 2.5)), count, 0.3, hook)
    ground(build, 40.0 * build.size, walls=False)
    return 0.0, 0.0


def _fill_taut(build: Build) -> tuple[float, float]:
    """A heavy end on light links."""
    count = int(build.rng.integers(2, 21))
    ratio = log_uniform(build.rng, 10.0, 1e4)
    _chain(build, np.zeros(2), float(build.rng.uniform(-1.6, 1.6)), count, 0.0, _hook(build, 0.0), ratio)
    return 0.0, 0.0


def _fill_spinning(build: Build) -> tuple[float, float]:
    """Free in space, turning fast as a whole."""
    spin = log_uniform(build.rng, 1.0, 100.0)
    for k in range(int(build.rng.integers(1, 4))):
        start = np.array([30.0 * build.size * k, 0.0])
        _chain(build, start, 0.0, int(build.rng.integers(2, 8)), 1.0, None, 10.0, spin=spin)
    return 0.0, 0.0


def _ragdoll(build: Build, start: Array) -> None:
    """A torso with jointed limbs, limits everywhere."""
    rng = build.rng
    limit = float(rng.uniform(0.1, 1.5))
    torso = _chain(build, start, 0.0, 2, 0.1, None, limits=limit)
    for side in (-1.0, 1.0):
        for part in torso:
            heading = side * float(rng.uniform(0.3, 1.5))
            body = build.scene.bodies[part]
            _chain(build, body.position, heading, int(rng.integers(1, 3)), 0.2, part, limits=limit)


def _fill_ragdolls(build: Build) -> tuple[float, float]:
    """Ragdolls that fall, one above the other."""
    for k in range(int(build.rng.integers(1, 4))):
        _ragdoll(build, np.array([float(build.rng.normal(0.0, 0.3)) * build.size, (6.0 + 7.0 * k) * build.size]))
    ground(build, 20.0 * build.size)
    return 0.0, 0.0


def _fill_heap(build: Build) -> tuple[float, float]:
    """Ragdolls and chains that start inside each other."""
    rng = build.rng
    for _ in range(int(rng.integers(2, 5))):
        start = build.size * np.array([rng.normal(0.0, 0.5), 3.0 + abs(rng.normal(0.0, 0.5))])
        if rng.random() < 0.5:
            _ragdoll(build, start)
        else:
            _chain(build, start, float(rng.uniform(-1.5, 1.5)), int(rng.integers(2, 6)), 0.5, None)
    ground(build, 20.0 * build.size)
    return 0.0, 0.0


def _fill_ring(build: Build) -> tuple[float, float]:
    """A closed loop of links, pinned, welded or both; sometimes every joint twice."""
    rng = build.rng
    count = int(rng.integers(3, 13))
    radius = build.size * count / math.tau
    center = np.array([0.0, radius * float(rng.uniform(1.2, 2.0)) + build.size])
    twice = rng.random() < 0.3
    for k in range(count):
        turn = math.tau * k / count
        place = center + radius * np.array([math.cos(turn), math.sin(turn)])
        build.add([_link(build, 0.9 * build.size)], position=place.tolist(), angle=turn)
    for k in range(count):
        turn = math.tau * (k + 0.5) / count
        anchor = (center + radius * np.array([math.cos(turn), math.sin(turn)])).tolist()
        kind = "weld" if rng.random() < 0.2 else "revolute"
        for n in range(2 if twice else 1):
            build.scene.add_joint(
                f"ring_{k}_{n}", make_joint(kind, f"body_{k}", f"body_{(k + 1) % count}", anchor=anchor)
            )
    ground(build, 20.0 * build.size)
    return 0.0, 0.0


def _fill_rope(build: Build) -> tuple[float, float]:
    """Balls on ropes that are slack at first, or on rods; a heavy one at the end."""
    rng = build.rng
    count = int(rng.integers(2, 13))
    height = build.size * count * float(rng.uniform(0.7, 1.5))
    before = _hook(build, height)
    place = np.array([0.0, height])
    rod = rng.random() < 0.3
    for k in range(count):
        heading = float(rng.uniform(-1.5, 1.5))
        place = place + build.size * np.array([math.sin(heading), -math.cos(heading)])
        density = log_uniform(rng, 1.0, 100.0) if k == count - 1 else 1.0
        ball = Circle(radius=0.2 * build.size, density=density, **build.material())
        build.add([ball], position=place.tolist())
        limits = None if rod else (0.0, build.size * float(rng.uniform(1.0, 1.3)))
        build.scene.add_joint(
            f"rope_{k}", Distance(before, f"body_{k}", anchor_a=(0.0, 0.0), anchor_b=(0.0, 0.0), limits=limits)
        )
        before = f"body_{k}"
    ground(build, 40.0 * build.size, walls=False)
    return 0.0, 0.0


def _fill_springs(build: Build) -> tuple[float, float]:
    """A lattice of balls and springs, from soft to far too stiff for the timestep."""
    rng = build.rng
    columns, rows = (int(n) for n in rng.integers(1, 5, 2))
    pitch = build.size
    ball = Circle(radius=0.25 * pitch, **build.material())
    mass = math.pi * (0.25 * pitch) ** 2
    omega = math.tau * log_uniform(rng, 0.3, 300.0)
    stiffness, damping = mass * omega**2, mass * omega * float(rng.choice([0.0, 0.1, 1.0]))
    lift = pitch * float(rng.uniform(0.5, 3.0))
    for k in range((columns + 1) * (rows + 1)):
        i, j = k % (columns + 1), k // (columns + 1)
        build.add([ball], position=(i * pitch, j * pitch + lift))
    for k in range((columns + 1) * (rows + 1)):
        i, j = k % (columns + 1), k // (columns + 1)
        for di, dj in ((1, 0), (0, 1), (1, 1), (-1, 1)):
            if 0 <= i + di <= columns and j + dj <= rows:
                other = (j + dj) * (columns + 1) + i + di
                build.scene.add_joint(
                    f"spring_{k}_{other}",
                    Distance(
                        f"body_{k}",
                        f"body_{other}",
                        anchor_a=(0.0, 0.0),
                        anchor_b=(0.0, 0.0),
                        stiffness=stiffness,
                        damping=damping,
                        collide=True,
                    ),
                )
    ground(build, 20.0 * build.size, walls=False)
    return 0.0, 0.0


def _fill_sliders(build: Build) -> tuple[float, float]:
    """Bodies on rails of bodies on rails, with limits that they run into."""
    rng = build.rng
    build.add([_link(build, 2.0 * build.size)], position=(0.0, 4.0 * build.size))
    if rng.random() < 0.5:
        build.scene.add_joint("pin", Revolute(_hook(build, 5.0 * build.size), "body_0"))
    for k in range(1, int(rng.integers(2, 6))):
        heading = float(rng.uniform(-math.pi, math.pi))
        axis = (math.cos(heading), math.sin(heading))
        place = build.scene.bodies[f"body_{k - 1}"].position + build.size * rng.uniform(-0.5, 0.5, 2)
        build.add([_link(build, build.size)], position=place.tolist(), angle=float(rng.uniform(-1.0, 1.0)))
        limits = (-build.size * float(rng.uniform(0.0, 1.0)), build.size * float(rng.uniform(0.0, 1.0)))
        kind = str(rng.choice(["prismatic", "wheel"]))
        build.scene.add_joint(
            f"rail_{k}", make_joint(kind, f"body_{k - 1}", f"body_{k}", anchor=place.tolist(), axis=axis, limits=limits)
        )
    for a in build.scene.bodies:  # they start inside each other
        for b in build.scene.bodies:
            if a < b:
                build.scene.exclude(a, b)
    ground(build, 20.0 * build.size)
    return 0.0, 0.0


def _fill_bouncy(build: Build) -> tuple[float, float]:
    """Cradles and chains whose links bounce off everything."""
    rng = build.rng
    count = int(rng.integers(2, 7))
    radius = 0.3 * build.size
    height = float(rng.uniform(2.0, 6.0)) * radius
    build.scene.add_body("hook", "static", [], position=(0.0, height))
    for k in range(count):
        swing = float(rng.uniform(-1.0, 0.0)) if k == 0 else 0.0
        x = 2.0 * radius * k
        place = (x + height * math.sin(swing), radius + height - height * math.cos(swing))
        build.add([Circle(radius=radius, **build.material())], position=place, angle=swing)
        build.scene.add_joint(f"pin_{k}", Revolute("hook", f"body_{k}", anchor=(x, radius + height)))
    _chain(build, np.array([-4.0 * build.size, 5.0 * build.size]), 1.0, int(rng.integers(2, 5)), 0.5, None)
    ground(build, 20.0 * build.size)
    return 0.0, 0.0


def _fill_contradictory(build: Build) -> tuple[float, float]:
    """Joints that can't all hold, or whose anchors start apart."""
    rng = build.rng
    names = _chain(build, np.array([0.0, 4.0 * build.size]), 1.2, int(rng.integers(2, 6)), 0.3, None)
    slack = 0.0
    for k in range(int(rng.integers(1, 4))):
        a, b = (str(name) for name in rng.choice(names, 2, replace=False))
        gap = build.size * float(rng.uniform(0.0, 0.5))
        kind = str(rng.choice(["weld", "revolute", "distance"]))
        place = build.scene.bodies[b].position - build.scene.bodies[a].position
        apart = float(np.hypot(*place))
        if kind == "distance":
            build.scene.add_joint(f"odd_{k}", make_joint(kind, a, b, length=apart + gap))
        else:
            build.scene.add_joint(f"odd_{k}", make_joint(kind, a, b, anchor_a=(0.0, 0.0), anchor_b=(gap, 0.0)))
            gap += apart
        slack += gap
    ground(build, 20.0 * build.size)
    return 0.0, slack


def _fill_motors(build: Build) -> tuple[float, float]:
    """Chains with motors and servos at random controls, in a heap and against their limits."""
    rng = build.rng
    names = _chain(build, np.array([0.0, 5.0 * build.size]), 1.0, int(rng.integers(2, 7)), 0.5, None)
    top = 0.0
    for k, name in enumerate(names[1:]):
        speed = log_uniform(rng, 1.0, 30.0)
        effort = log_uniform(rng, 0.1, 100.0) * build.size**3 * 10.0
        joint = f"motor_{k}"
        anchor = build.scene.bodies[name].position.tolist()
        servo = rng.random() < 0.3
        build.scene.add_joint(
            joint,
            Revolute(
                names[k],
                name,
                anchor=anchor,
                motor_effort=effort,
                limits=(-2.0, 2.0),
                frequency=log_uniform(rng, 0.5, 20.0) if servo else 0.0,
                spring_effort=effort,
            ),
        )
        mode = "position" if servo else str(rng.choice(["velocity", "torque"]))
        build.scene.add_actuator(f"act_{k}", joint, mode=mode, lower=-speed, upper=speed)
        top = max(top, speed)
        inertia = build.size**4 * 0.01
        top = max(top, math.sqrt(effort * 4.0 / inertia))
    ground(build, 20.0 * build.size)
    return top * build.size * len(names) * 4.0, 0.0


def _fill_gears(build: Build) -> tuple[float, float]:
    """A train of gears on a frame, driven at the first and jammed at the last."""
    rng = build.rng
    count = int(rng.integers(2, 6))
    frame = Box(half_extents=(build.size * count, 0.1 * build.size), **build.material())
    place = (0.0, 6.0 * build.size)
    loose = rng.random() < 0.5
    build.scene.add_body("frame", "dynamic" if loose else "static", [frame], position=place)
    speed = log_uniform(rng, 1.0, 30.0)
    for k in range(count):
        radius = build.size * float(rng.uniform(0.3, 0.9))
        spot = (place[0] + 2.0 * build.size * (k - 0.5 * (count - 1)), place[1])
        build.add([Circle(radius=radius, **build.material())], position=spot)
        effort = build.size**3 * log_uniform(rng, 1.0, 100.0) if k == 0 else 0.0
        build.scene.add_joint(
            f"axle_{k}",
            Revolute(
                "frame",
                f"body_{k}",
                anchor=spot,
                motor_effort=effort,
                motor_speed=speed if effort else 0.0,
                limits=(-1.0, 1.0) if k == count - 1 and rng.random() < 0.3 else None,
            ),
        )
        if k > 0:
            ratio = float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.3, 3.0))
            build.scene.add_joint(f"gear_{k}", Gear(f"axle_{k - 1}", f"axle_{k}", ratio=ratio))
    ground(build, 20.0 * build.size)
    return speed * build.size * 3.5**count, 0.0


def _fill_cars(build: Build) -> tuple[float, float]:
    """Cars on sprung wheels that drive into walls and each other."""
    rng = build.rng
    top = 0.0
    for k in range(int(rng.integers(1, 4))):
        x = 6.0 * build.size * k
        body = Box(half_extents=(1.5 * build.size, 0.3 * build.size), **build.material())
        chassis = f"body_{build.count}"
        build.add([body], position=(x, 1.5 * build.size))
        for side in (-1.0, 1.0):
            wheel = f"body_{build.count}"
            spot = (x + side * build.size, 0.7 * build.size)
            build.add([Circle(radius=0.5 * build.size, **build.material())], position=spot)
            joint = f"axle_{wheel}"
            speed = log_uniform(rng, 1.0, 100.0)
            build.scene.add_joint(
                joint,
                Wheel(
                    chassis,
                    wheel,
                    anchor=spot,
                    axis=(0.0, 1.0),
                    frequency=log_uniform(rng, 1.0, 15.0),
                    damping_ratio=0.7,
                    limits=(-0.3 * build.size, 0.3 * build.size),
                    motor_effort=build.size**3 * log_uniform(rng, 1.0, 100.0),
                ),
            )
            build.scene.add_actuator(f"drive_{wheel}", joint, lower=-speed, upper=speed)
            top = max(top, speed)
    ground(build, 20.0 * build.size)
    return top * build.size, 0.0


_BUILDERS = {
    "chain": _fill_chain,
    "taut": _fill_taut,
    "spinning": _fill_spinning,
    "ragdolls": _fill_ragdolls,
    "heap": _fill_heap,
    "ring": _fill_ring,
    "rope": _fill_rope,
    "springs": _fill_springs,
    "sliders": _fill_sliders,
    "bouncy": _fill_bouncy,
    "contradictory": _fill_contradictory,
    "motors": _fill_motors,
    "gears": _fill_gears,
    "cars": _fill_cars,
}
