"""Rules that the 2D and the 3D figure share: pushes, actions, loads of the feet, reward. Kernels know no geometry.

The figure keeps its balance, or gets up where the task state's `getting_up` is set.
"""

from __future__ import annotations

from typing import Any

from gsenv.envs.core.kernels import between
from gsenv.solver.core.trig import exp_minus
from gsenv.solver.jit import njit

CONTROL_TIME = 1.0 / 30.0  # s
ENGINE_STEPS = 2

PUSHES = 10  # of a schedule, which then begins again
PUSH_DRAWS = 2 * PUSHES  # that `plan_pushes` uses
PUSH_STEPS = 3
SHOWN_STEPS = 14  # how long a push's arrow is shown
FEWEST_GAP, MOST_GAP = 60, 120  # steps from the begin of a push to the next
FIRST_GAP = 30  # steps before the first push, at least
LEAST_PUSH = 0.1  # m/s

NEVER = 1 << 40  # step
STOOD_HEIGHT = 0.9  # of the height of the stand: it has got up
STOOD_UPRIGHT = 0.9  # cosine of the chest's tilt
STOOD_STEPS = 30  # in a row

FALL_HEIGHT = 0.6  # of the height of the stand
FALL_TILT = 1.0  # rad
STAND_WEIGHT = 0.03
POSTURE_WEIGHT = 0.01
CALM_SPEED = 0.5  # m/s
SMOOTH_WEIGHT = -0.002
EFFORT_WEIGHT = -0.0005
FALL_REWARD = -0.5


def task_state_fields(actions: int) -> list[tuple[Any, ...]]:
    """Return the fields of the task state that the kernels below use, for a number of actions."""
    return [
        ("steps", "i8"),
        ("action", "f8", (actions,)),  # the last one
        ("change", "f8"),  # sum of the squares of its change
        ("mass", "f8"),  # kg, of the figure
        ("gaps", "i8", (PUSHES,)),  # steps before each push
        ("pushes", "f8", (PUSHES,)),  # m/s, what each changes the velocity by
        ("next_push", "i8"),  # step
        ("push_count", "i8"),
        ("push", "f8"),  # m/s, the last push
        ("pushed", "i8"),  # steps since it began
        ("getting_up", "i8"),  # 1: the task is to get up
        ("stood", "i8"),  # steps in a row that the figure has stood since
        ("assist", "f8"),  # share of the weight that a force at the chest carries
    ]


# ---------------------------------------------------------------- pushes and actions


@njit
def plan_pushes(task, most, draws):  # type: ignore[no-untyped-def]
    """Draw when and how hard the figure is pushed; `most` m/s, no pushes where it is 0."""
    least = min(LEAST_PUSH, most)
    for k in range(PUSHES):
        first = FIRST_GAP if k == 0 else FEWEST_GAP
        task.gaps[k] = int(between(float(first), float(MOST_GAP), draws[2 * k]))
        side = 2.0 * draws[2 * k + 1] - 1.0
        size = between(least, most, abs(side))
        task.pushes[k] = size if side >= 0.0 else -size
    task.next_push = task.gaps[0] if most > 0.0 else NEVER
    task.pushed = SHOWN_STEPS


@njit
def begin_push(task):  # type: ignore[no-untyped-def]
    """Begin the next push where it is due."""
    if task.steps >= task.next_push:
        task.push = task.pushes[task.push_count % PUSHES]
        task.push_count += 1
        task.pushed = 0
        task.next_push += max(task.gaps[task.push_count % PUSHES], FEWEST_GAP)  # where the schedule begins again


@njit
def push_force(task):  # type: ignore[no-untyped-def]
    """Return the force in N that changes the figure's velocity evenly over PUSH_STEPS, and count the step.

    A force acts in the first engine step only.
    """
    force = 0.0
    if task.pushed < PUSH_STEPS:
        force = task.mass * task.push / (PUSH_STEPS * CONTROL_TIME / ENGINE_STEPS)
    task.pushed = min(task.pushed + 1, SHOWN_STEPS)
    return force


@njit
def assist_force(task, gravity):  # type: ignore[no-untyped-def]
    """Return the upward force in N that carries a share of the figure's weight; it acts in the first engine step."""
    return task.assist * task.mass * gravity * ENGINE_STEPS


@njit
def act(task, control, action, stand, below, above, delay):  # type: ignore[no-untyped-def]
    """Set the targets of the drives in rad; the action before that where `delay` is 1.

    An action of -1, 0, 1 asks for stand - below, stand, stand + above.
    """
    late = delay >= 0.5
    task.change = 0.0
    for a in range(len(action)):
        new = min(max(action[a], -1.0), 1.0)
        last = task.action[a]
        task.change += (new - last) * (new - last)
        task.action[a] = new
        asked = last if late else new
        control[a] = stand[a] + (above[a] if asked > 0.0 else below[a]) * asked


# ---------------------------------------------------------------- evaluate


@njit
def foot_loads(contacts, feet, timestep):  # type: ignore[no-untyped-def]
    """Return the mean forces in N between the ground, body 0, and either foot, and whether other parts touch it."""
    first, second, others = 0.0, 0.0, False
    for i in range(len(contacts)):
        push = contacts[i].total_impulse[0] / timestep
        a, b = contacts[i].body_a, contacts[i].body_b
        if push <= 0.0 or (a != 0 and b != 0):
            continue
        if a == feet[0] or b == feet[0]:
            first += push
        elif a == feet[1] or b == feet[1]:
            second += push
        else:
            others = True
    return first, second, others


@njit
def effort(joints, numbers, slot, bounds, timestep):  # type: ignore[no-untyped-def]
    """Return the sum of the squares of the drives' torques over their bounds, N m.

    `numbers` are those of the driven joints, `slot` is where the impulse of their springs is.
    """
    total = 0.0
    for j in range(len(numbers)):
        share = joints[numbers[j]].total_impulse[slot] / (timestep * bounds[j])
        total += share * share
    return total


@njit
def bell(x):  # type: ignore[no-untyped-def]
    """Return e^-x for x >= 0, at least e^-16."""
    root = exp_minus(0.25 * min(x, 16.0))
    root *= root
    return root * root


@njit
def write_terms(task, term, motion, failed):  # type: ignore[no-untyped-def]
    """Set the shared reward terms.

    `motion` is the height of the crown over that in the stand, the same of the hips, the cosine of the chest's tilt,
    the square of the horizontal speed in m^2/s^2, the squared deviation from the stand in rad^2, and the `effort`.
    """
    crown, hips, upright, square, posture, efforts = motion
    crown = min(max(crown, 0.0), 1.0)
    if task.getting_up != 0:  # which takes speed and other postures; upright and seated is no way to the stand
        up = 0.5 * (crown + min(max(hips, 0.0), 1.0))
        term.stand = STAND_WEIGHT * up
        term.posture = POSTURE_WEIGHT * up * up * bell(posture)
    else:
        term.stand = STAND_WEIGHT * crown * max(upright, 0.0) * bell(square / (CALM_SPEED * CALM_SPEED))
        term.posture = POSTURE_WEIGHT * bell(posture)
    term.smoothness = SMOOTH_WEIGHT * task.change
    term.effort = EFFORT_WEIGHT * efforts
    term.fall = FALL_REWARD if failed else 0.0


@njit
def count_stood(task, height, upright, others):  # type: ignore[no-untyped-def]
    """Count the steps in a row that the figure has stood, upright and on nothing but its feet."""
    stands = height >= STOOD_HEIGHT and upright >= STOOD_UPRIGHT and not others
    task.stood = task.stood + 1 if stands else 0


@njit
def write_info(task, info, fell, failed):  # type: ignore[no-untyped-def]
    """Set the info of a step."""
    info.success = not failed if task.getting_up == 0 else task.stood >= STOOD_STEPS
    info.is_success = info.success
    info.fell = fell
    info.time = task.steps * CONTROL_TIME
    info.pushes = task.push_count
