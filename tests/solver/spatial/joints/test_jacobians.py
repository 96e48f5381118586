"""The rows of 3D joints at random poses: Jacobians against differences of constraint functions in plain numpy."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, World
from gsenv.solver.spatial import Axis, Ball, Box, Hinge, SixAxis, Slider, Universal, Wheel
from tests.solver.spatial.joints.rigs import Array, matrix, multiplied, quaternion
from tests.solver.spatial.one_kernel import full_world, space

TINY = Options(
    timestep=1e-7, substeps=1, sleep=False, articulated=False
)  # the pose half a substep ahead is the present one
SPRING = Axis(stiffness=3.0)
AXIS = (0.48, 0.6, -0.64)
ACROSS = (0.8, 0.0, 0.6)  # perpendicular to AXIS

Frames = tuple[Array, Array, Array]  # axes of a and of b as columns, anchor_b - anchor_a

JOINTS: dict[str, Any] = {
    "hinge": Hinge("a", "b", axis=AXIS, stiffness=3.0),
    "slider": Slider("a", "b", axis=AXIS, stiffness=3.0),
    "universal": Universal("a", "b", axis_a=AXIS, axis_b=ACROSS, turn_a=SPRING, turn_b=SPRING),
    "wheel": Wheel("a", "b", axis=AXIS, spin_axis=ACROSS, steering=SPRING, stiffness=3.0, friction_effort=1.0),
    "free turns": SixAxis("a", "b", turn_x=SPRING, turn_y=SPRING, turn_z=SPRING),
    "two turns": SixAxis("a", "b", turn_x=SPRING, turn_z=SPRING, x=SPRING),
    "one turn": SixAxis("a", "b", turn_x=SPRING, y=SPRING, z=SPRING, orientation=(0.8, 0, 0.6, 0)),
    "slides": SixAxis("a", "b", x=SPRING, y=SPRING, z=SPRING, orientation=(0.8, 0, 0.6, 0)),
    "ball": Ball("a", "b", axis=AXIS, cone=0.001, twist=(0.9, 0.91), stiffness=3.0),
}
# ranges of the six coordinates of the frames, Cardan angles of axes 0, 1, 2 and translations
FREE = {
    "hinge": (0, 0, 2.5, 0, 0, 0),
    "slider": (0, 0, 0, 0, 0, 0.4),
    "universal": (2.5, 0, 2.5, 0, 0, 0),
    "wheel": (1.5, 0, 2.5, 0.4, 0, 0),
    "free turns": (2.5, 1.2, 2.5, 0, 0, 0),
    "two turns": (2.5, 0, 2.5, 0, 0, 0),
    "one turn": (0, 0, 2.5, 0, 0, 0),
    "slides": (0, 0, 0, 0.4, 0.4, 0.4),
    "ball": (1.0, 0.7, 1.0, 0, 0, 0),
}


def linked(name: str) -> World:
    """Two free bodies on a joint at oblique initial poses."""
    scene = space()
    scene.add_body("a", shapes=[Box(half_extents=(0.3, 0.2, 0.1), mask=0)], orientation=(0.7, 0.1, -0.5, 0.2))
    scene.add_body(
        "b", shapes=[Box(half_extents=(0.1, 0.2, 0.2), mask=0)], position=(1, 0, 0.2), orientation=(1, 2, 0, 3)
    )
    joint = JOINTS[name]
    scene.add_joint("joint", type(joint)(**{**vars(joint), "anchor": (0.4, 0.1, 0.2)}))
    return full_world(scene, options=TINY)


def frames_of(world: World, bodies: Any, j: int) -> Frames:
    """The joint's frames at poses (centre, quaternion) of both bodies."""
    p = world.parameters.joints[0, j]
    w, x, y, z = p["reference"]
    sides = (p["frame"], multiplied((w, -x, -y, -z), p["frame"]))
    made, points = [], []
    for side, anchor, k in zip(sides, ("anchor_a", "anchor_b"), (0, 1), strict=True):
        center, q = bodies[k]
        made.append(matrix(multiplied(q, side)))
        points.append(center + matrix(q) @ (p[anchor] - world.parameters.bodies[0, k]["center"]))
    return made[0], made[1], points[1] - points[0]


def cardan(f: Frames) -> Array:
    """Angles of A^T B = R_x R_y R_z."""
    r = f[0].T @ f[1]
    return np.array([math.atan2(-r[1, 2], r[2, 2]), math.asin(r[0, 2]), math.atan2(-r[0, 1], r[0, 0])])


def twist(f: Frames) -> float:
    r = f[0].T @ f[1]
    return 2.0 * math.atan2(r[1, 0] - r[0, 1], 1.0 + np.trace(r))


def slide(k: int) -> Callable[[Frames], float]:
    return lambda f: float(f[0][:, k] @ f[2])


def turn_about(k: int) -> Callable[[Frames], float]:
    return lambda f: float(cardan(f)[k])


def swing(f: Frames) -> float:
    return math.acos(f[0][:, 2] @ f[1][:, 2])


CONSTRAINTS: dict[int, Callable[[Frames], float]] = {  # by number of the coordinate
    **{k: slide(k) for k in range(3)},
    **{3 + k: turn_about(k) for k in range(3)},
    6: swing,
    7: twist,
}


def locked_constraint(world: World, j: int, slot: int) -> Callable[[Frames], float]:
    """The constraint of a locked axis, of a row in slot 0 to 5."""
    locked = int(world.model.joints["locked"][j])
    if slot < 3:
        if locked & 7 == 7 or world.model.joints["kind"][j] == 8:
            return lambda f: float(f[2][slot])
        return CONSTRAINTS[slot]
    if locked >> 3 == 3:  # swing of the last axis of b towards an axis of a
        return lambda f: float(np.cross(f[0][:, 2], f[1][:, 2]) @ f[0][:, slot - 3])
    if locked >> 3 == 2:
        return CONSTRAINTS[4]

    def turn(f: Frames) -> float:  # of small rotations
        r = f[1] @ f[0].T
        return 0.5 * float((r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1])[slot - 3])

    return turn


def moved(poses: Any, k: int, shift: Array) -> Any:
    """Poses after a small motion (6,) of body k."""
    angle = float(np.linalg.norm(shift[3:]))
    turn = quaternion(shift[3:] / angle, angle) if angle else np.array((1.0, 0, 0, 0))
    return [(c + shift[:3], multiplied(turn, q)) if i == k else (c, q) for i, (c, q) in enumerate(poses)]


@pytest.mark.parametrize("name", JOINTS)
def test_jacobians_are_differences_of_the_constraints(name: str) -> None:
    random = np.random.default_rng(4)
    world = linked(name)
    numbers = world.model.joints["coordinate"]
    joints = [j for j, joint in enumerate(world.model.joint_names) if joint != "far_ball"]
    seen = 0
    for _ in range(6):
        place(world, random, FREE[name])
        poses = [(b["position"].copy(), b["rotation"].copy()) for b in world.state.bodies[0, :2]]
        world.step()
        rows = world._scratches[0].rows
        for row in rows[: world.state.worlds["row_count"][0]]:
            j = int(row["source"])
            slot = int(row["slot"]) if row["slot"] >= 0 else -1 - int(row["slot"])
            sign = 1.0 if row["slot"] >= 0 else -1.0
            if j not in joints or numbers[j] >= 8:
                continue
            constraint = locked_constraint(world, j, slot)
            if slot >= 6:
                constraint = CONSTRAINTS[
                    int(world.model.joints["motor_coordinate" if slot in (7, 9) else "coordinate"][j])
                ]
            for k, side in enumerate(("jacobian_a", "jacobian_b")):
                frame = world._scratches[0].substep_bodies["frame"][k]
                given = np.concatenate([row[side][:3], frame.T @ row[side][3:]])
                found = [difference(world, constraint, poses, j, k, d) for d in range(6)]
                assert_allclose(sign * given, found, atol=2e-6, err_msg=f"{world.model.joint_names[j]} {slot} {side}")
            seen += 1
    assert seen >= 6 * 5


def difference(world: World, constraint: Callable[[Frames], float], poses: Any, j: int, k: int, d: int) -> float:
    """Central difference of a constraint along direction d of body k, 1 or m/rad."""
    step = 1e-5 * np.eye(6)[d]
    ahead, behind = (frames_of(world, moved(poses, k, s * step), j) for s in (1.0, -1.0))
    return (constraint(ahead) - constraint(behind)) / 2e-5


def place(world: World, random: np.random.Generator, ranges: Any) -> None:
    """Set random poses that satisfy the joint, with coordinates in these ranges."""
    q = random.normal(size=4)
    world.set_pose("a", position=random.normal(size=3), orientation=q)
    angles = np.asarray(ranges[:3]) * random.uniform(-1, 1, 3)
    slides = np.asarray(ranges[3:]) * random.uniform(-1, 1, 3)
    p = world.parameters.joints[0, 0]
    frame = world.parameters.joints[0, part_with_frame(world)]["frame"]
    turn = np.array((1.0, 0, 0, 0))
    for k in range(3):
        turn = multiplied(turn, quaternion(np.eye(3)[k], angles[k]))
    w, x, y, z = frame
    own = world.orientation[0, 0]
    b = multiplied(multiplied(multiplied(multiplied(own, frame), turn), (w, -x, -y, -z)), p["reference"])
    anchor = world.position[0, 0] + matrix(own) @ (p["anchor_a"] + matrix(frame) @ slides)
    world.set_pose("b", orientation=b, position=anchor - matrix(b) @ p["anchor_b"])
    for name in world.model.joint_names[:-1]:  # turns counted from here
        j = world.model.joint_names.index(name)
        world.state.joints["angle"][0, j] = 0.0


def part_with_frame(world: World) -> int:
    """Index of an entry of the joint whose frame is that of its axes; the frame of a ball is in its parts."""
    return 1 if world.model.joints["kind"][0] == 8 else 0


@pytest.mark.parametrize("name", JOINTS)
def test_rates_are_changes_of_coordinates(name: str) -> None:
    """Central differences of what is read, on bodies that tumble freely with the joint disabled."""
    random = np.random.default_rng(7)
    world = linked(name)
    world.options = Options(timestep=1e-4, substeps=1, sleep=False, articulated=False)
    readable = [n for n, k in zip(world.model.joint_names, world.model.joints["coordinate"], strict=True) if 0 <= k < 8]
    assert readable
    for _ in range(3):
        place(world, random, FREE[name])
        world.parameters.set("joint", enabled=False)
        for body in ("a", "b"):
            world.set_velocity(body, linear=random.normal(size=3), angular=random.normal(size=3))
        before = {n: world.joint_coordinate(n)[0] for n in readable}
        world.step()
        rates = {n: world.joint_rate(n)[0] for n in readable}
        world.step()
        for n in readable:
            change = (world.joint_coordinate(n)[0] - before[n] + math.pi) % (2.0 * math.pi) - math.pi
            assert rates[n] == pytest.approx(change / 2e-4, abs=1e-5 * (1 + abs(rates[n])))
