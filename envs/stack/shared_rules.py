"""Rules that GStack-v0, GStack3D-v0 and tower_v0 share; they know no geometry.

`task`, `info` and `term` are one world's records of task state, info and reward terms. `order` has the block at each
level of the tower. Sets of blocks are bit masks.
"""

from __future__ import annotations

from typing import Any

from gsenv.envs.stack import impacts
from gsenv.solver.core.edit import disable_joint, set_mass
from gsenv.solver.jit import njit

CONTROL_TIME = 1.0 / 30.0  # s
ARRIVAL_MARGIN = 0.05  # m, free space around an arriving block

REST_SPEED = 0.08  # m/s, and rad/s half as much again: what counts as standing
TOUCH = 1e-3  # m, nearer counts as touching
TIPPED = 0.5  # rad
SUNK = 0.5  # of its half-height: a block this far below its level has fallen

# Fields of the task state of a task with one gripper.
GRIPPER_FIELDS: list[tuple[Any, ...]] = [
    ("blocks", "i8"),  # levels of the goal
    ("arrived", "i8"),  # blocks that are or were in the gripper
    ("held", "i8"),  # block in the gripper, or -1
    ("placed", "i8"),  # blocks that came to rest at their level
    ("stand", "i8"),  # control steps that the released blocks have stood
    ("distance", "f8"),  # to go, as the approach term sees it; negative: not yet known
    ("effort", "f8"),  # mean square of the last action
    *impacts.FIELDS,
]


def setting_fields(grasp: tuple[str, str]) -> list[tuple[Any, ...]]:
    """Return the fields of the settings of an episode; `grasp`: that of the largest angle in the gripper, rad."""
    return [
        ("half_width", "f8", (2,)),  # m, lowest and highest
        ("half_height", "f8", (2,)),  # m
        ("mass", "f8", (2,)),  # kg
        ("friction", "f8", (2,)),
        ("grasp_offset", "f8"),  # of the half-width, at most
        grasp,
        ("crack_speed", "f8"),  # m/s
        ("stand_steps", "i8"),  # control steps that a whole tower must stand
    ]


def weight_fields(*terms: str) -> list[tuple[Any, ...]]:
    """Return the fields of the weights of reward terms."""
    return [(f"{term}_weight", "f8") for term in terms]


# ---------------------------------------------------------------- initialize


@njit
def apply_physics(physics, parameters, first_block, first_shape, block_count, drive_count):  # type: ignore[no-untyped-def]
    """Write the quantities of the episode to the parameters of a world whose blocks have just been made.

    Joints 0 to drive_count - 1 are drives; the last axis is vertical.
    """
    friction, mass, force, gravity = physics[0], physics[1], physics[2], physics[3]
    for k in range(block_count):
        shape = parameters.shapes[first_shape + k]
        shape.friction *= friction
        shape.density *= mass
        body = parameters.bodies[first_block + k]
        set_mass(body, body.mass * mass)
    for j in range(drive_count):
        parameters.joints[j].max_force *= force
        parameters.joints[j].max_torque *= force
    vertical = len(parameters.world.gravity) - 1
    parameters.world.gravity[vertical] = -gravity


@njit
def take(task, k):  # type: ignore[no-untyped-def]
    """Note that the only gripper holds block k."""
    task.held = k
    task.arrived = k + 1
    task.distance = -1.0


# ---------------------------------------------------------------- apply actions


@njit
def clipped_effort(action, moves):  # type: ignore[no-untyped-def]
    """Clip an action to [-1, 1] in place; return the mean square of its first `moves` entries."""
    effort = 0.0
    for a in range(len(action)):
        action[a] = min(max(action[a], -1.0), 1.0)
        if a < moves:
            effort += action[a] * action[a] / float(moves)
    return effort


@njit
def within(speed, limit, here, low, high):  # type: ignore[no-untyped-def]
    """Return the speed, reduced so that a target at `here` stays in [low, high], or leaves it no further."""
    speed = min(speed, max((high - here) / CONTROL_TIME, 0.0))
    speed = max(speed, min((low - here) / CONTROL_TIME, 0.0))
    return min(max(speed, -limit), limit)


@njit
def release(world, gripper, block, weld):  # type: ignore[no-untyped-def]
    """Release a block from the gripper."""
    disable_joint(world.parameters.joints[weld], world.state.bodies[gripper], world.state.bodies[block])


@njit
def release_held(world, gripper, first_block, first_weld):  # type: ignore[no-untyped-def]
    """Release the block that the only gripper holds."""
    task = world.task.state
    release(world, gripper, first_block + task.held, first_weld + task.held)
    task.held = -1
    task.stand = 0
    task.distance = -1.0


# ---------------------------------------------------------------- evaluate


@njit
def approach(task, distance):  # type: ignore[no-untyped-def]
    """Return by how much the distance has fallen since the last step, in m; 0 in the first step of a phase."""
    before = task.distance
    task.distance = distance
    return before - distance if before >= 0.0 else 0.0


@njit
def is_touching(contact):  # type: ignore[no-untyped-def]
    """Whether the two bodies of a contact touch."""
    return contact.total_impulse[0] > 0.0 or contact.separation <= TOUCH


@njit
def standing(first, last, order, steady):  # type: ignore[no-untyped-def]
    """Whether the blocks of levels first..last-1 are all `steady`."""
    for level in range(first, last):
        if steady & (1 << order[level]) == 0:
            return False
    return True


@njit
def evaluate_tower(task, info, released, order, steady, failed):  # type: ignore[no-untyped-def]
    """Update task state and info with the blocks that stand; return (newly placed, success).

    `steady`: the blocks that rest on the level below, slow, with no gripper on them; `failed`: whether a block has
    fallen or cracked.
    """
    placed = released > task.placed and not failed and standing(task.placed, released, order, steady)
    if placed:
        task.placed = released
    stands = released > 0 and not failed and standing(0, released, order, steady)
    task.stand = task.stand + 1 if stands else 0
    success = task.placed == task.blocks and task.stand >= task.stand_steps
    info.success = success
    info.is_success = success
    info.placed = task.placed
    info.stand_time = task.stand * CONTROL_TIME
    info.cracked = task.cracked != 0
    info.impact = task.impact
    return placed, success


@njit
def write_terms(task, term, nearer, placed, fallen, success):  # type: ignore[no-untyped-def]
    """Set the reward terms of a task with one gripper; return their sum."""
    term.approach = task.approach_weight * nearer
    term.placed = task.placed_weight if placed else 0.0
    term.success = task.success_weight if success else 0.0
    term.fall = task.fall_weight if fallen else 0.0
    term.crack = task.crack_weight if task.cracked != 0 else 0.0
    term.time = task.time_weight
    term.effort = task.effort_weight * task.effort
    return term.approach + term.placed + term.success + term.fall + term.crack + term.time + term.effort


@njit
def is_due(task, failed):  # type: ignore[no-untyped-def]
    """Whether the next block of the only gripper comes as soon as there is room for it."""
    k = task.arrived
    return task.held < 0 and task.placed == k and k < task.blocks and not failed


# ---------------------------------------------------------------- observe


@njit
def observe_progress(out, first, task, most):  # type: ignore[no-untyped-def]
    """Write three entries: blocks placed and to go, of `most`, and the time that the tower has stood."""
    out[first] = task.placed / most
    out[first + 1] = (task.blocks - task.placed) / most
    out[first + 2] = min(task.stand / task.stand_steps, 1.0)
