"""GRagdoll2D-v0: a planar figure with seven driven joints keeps its balance while it is pushed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gymnasium import Env
from gymnasium.vector import VectorEnv

from gsenv.envs import time_limit
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.steering import Stick, pair
from gsenv.envs.core.task import Array, Task, documented
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll2d import rules, scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.build import build_scene
from gsenv.envs.ragdoll2d.lying import lying_poses
from gsenv.envs.ragdoll2d.privileged import entries
from gsenv.envs.ragdoll2d.task import (
    ARGUMENTS,
    BALANCE_ACTION,
    FALL_END,
    GET_UP_ACTION,
    GET_UP_END,
    GET_UP_SETTINGS,
    GET_UP_TERMS,
    LAST_TERMS,
    OF_BALANCE,
    OF_GET_UP,
    OF_ONE_OF_TASKS,
    POSTURE_TERM,
    TIME_END,
    BalanceTask,
    OneOfTasks,
    axis_text,
    filled,
    push_setting,
    stand_term,
)
from gsenv.solver import Scene


def _axis_actions(getting_up: bool = False) -> tuple[Entry, ...]:
    return tuple(
        Entry(axis_text(axis.name, axis.stand, axis.limits, span, getting_up), axis.name, -1, 1)
        for axis, span in zip(scene.AXES, rules._SPAN, strict=True)
    )


def _joint_entries() -> list[Entry]:
    names = [(axis.name, axis.name.replace("_", " ")) for axis in scene.JOINTS]
    return [
        *(Entry(f"{text}, angle from that of the stand", f"{name}_angle", -4, 4, "rad") for name, text in names),
        *(Entry(f"{text}, rate", f"{name}_rate", -5, 5, "10 rad/s") for name, text in names),
        *(Entry(f"last action, {axis.name.replace('_', ' ')}", f"last_{axis.name}", -1, 1) for axis in scene.AXES),
    ]


def _foot_entries(side: str) -> tuple[Entry, ...]:
    return (
        Entry(f"{side} foot, forwards from the centre of mass", f"{side}_foot_x", -4, 4, "0.5 m"),
        Entry(f"{side} foot, height of its centre of mass", f"{side}_foot_y", -1, 10, "0.2 m"),
        Entry(f"{side} foot, sine of its angle (toes up is positive)", f"{side}_foot_sine", -1, 1),
    )


_APART = Entry("time with the feet apart, less the time together since", "apart", 0, 1.1, "2 s")


class RagdollTask(BalanceTask):
    """The rules for many worlds; `settings` has the defaults of a reset."""

    actions = _axis_actions()
    controls = (
        (
            *pair("left", "right", "ankles: lean", "near_ankle", "far_ankle"),
            *pair("down", "up", "knees", "near_knee", "far_knee"),
            *pair("z", "x", "waist", "waist"),
            *pair("q", "w", "near hip", "near_hip"),
            *pair("a", "s", "near knee", "near_knee"),
            *pair("e", "t", "far hip", "far_hip"),
            *pair("d", "g", "far knee", "far_knee"),
            Stick("left_x", {"near_ankle": 1.0, "far_ankle": 1.0}),
            Stick("left_y", {"near_knee": 1.0, "far_knee": 1.0}),
            Stick("right_x", {"near_hip": 1.0, "far_hip": -1.0}),
            Stick("right_y", {"waist": 1.0}),
        ),
    )
    observations = (
        Entry("height of the crown over that in the stand, less 1", "height", -5, 5, "0.2"),
        Entry("pelvis, sine of its tilt (backwards is positive)", "pelvis_sine", -1, 1),
        Entry("chest, sine of its tilt", "chest_sine", -1, 1),
        Entry("pelvis, rate of its tilt", "pelvis_rate", -5, 5, "5 rad/s"),
        Entry("centre of mass, velocity forwards", "vx", -5, 5, "m/s"),
        Entry("centre of mass, velocity upwards", "vy", -5, 5, "m/s"),
        Entry("centre of mass, forwards from the middle of the support", "mass_x", -10, 10, "0.2 m"),
        Entry("capture point, forwards from the middle of the support", "capture_x", -10, 10, "0.2 m"),
        Entry("near foot, load over the weight of the figure", "near_load", 0, 5),
        Entry("far foot, load over the weight of the figure", "far_load", 0, 5),
        *_foot_entries("near"),
        *_foot_entries("far"),
        _APART,
        *_joint_entries(),
    )
    reward_terms = (
        stand_term("forwards"),
        POSTURE_TERM,
        RewardTerm(
            "apart",
            f"{rules.APART_WEIGHT:g} times the part of {rules.STRIDE:g} m by which the distance of the ankles along "
            f"the ground exceeds {rules.FREE_STRIDE:g} m, at most 1",
        ),
        *LAST_TERMS[:-1],
        RewardTerm("fall", f"{shared.FALL_REWARD:g} for a fall or feet that stay apart, which ends the episode"),
    )
    task_state_fields = rules.TASK_STATE_FIELDS
    max_episode_steps = time_limit("GRagdoll2D-v0")
    draw_count = rules.DRAW_COUNT
    privileged = entries(BalanceTask.quantities, ("forwards",))

    def build_scene(self) -> Scene:
        return build_scene()

    def initialize_episode(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        assist = options.get("assist", 0.0)
        rules.initialize_worlds(
            self.kernel_world, worlds, options["push"], self.getting_up, assist, self.lying(), draws,
            self.world.timestep,
        )  # fmt: skip

    def apply_action(self, actions: Array) -> int:
        return rules.apply_actions(self.kernel_world, actions)

    def evaluate(self) -> None:
        rules.evaluate_worlds(self.kernel_world, self.world.timestep)

    def camera(self, world: int, width: int, height: int) -> Any:
        from gsenv.render.camera import Camera

        return Camera((float(self.task_state["gaze"][world]), 0.9), max(2.2, 2.6 * height / width))


class RagdollHardcoreTask(RagdollTask):
    """The same with harder pushes."""

    max_episode_steps = time_limit("GRagdoll2D-hardcore-v0")
    arguments = push_setting(1.0)


class RagdollGetUpTask(RagdollTask):
    """The figure lies on the ground and gets up."""

    max_episode_steps = time_limit("GRagdoll2D-get-up-v0")
    arguments = GET_UP_SETTINGS
    actions = _axis_actions(getting_up=True)
    observations = (
        *(entry for entry in RagdollTask.observations if entry is not _APART),
        Entry("pelvis, cosine of its tilt", "pelvis_cosine", -1, 1),
        Entry("chest, cosine of its tilt", "chest_cosine", -1, 1),
    )
    reward_terms = (*GET_UP_TERMS[:2], RewardTerm("apart", "0: the feet may be apart"), *GET_UP_TERMS[2:])
    getting_up = True

    def lying(self) -> Array:
        return lying_poses("GRagdoll2D-get-up-v0")


TASKS: dict[str, type[Task]] = {"balance": RagdollTask, "get_up": RagdollGetUpTask}


_SPECIFICATION = (
    """{goal}: {id}.

    ## Description
    Seen from the side, a person of 1.7 m and 60 kg {does}.
    Drives at waist, hips, knees and ankles follow the angles that the actions ask for, with bounded torques;
    the arms hang from the shoulders on soft springs. {feet}Control runs at 30 Hz.
    The legs do not collide: the near one passes in front of the far one.

    GRagdoll2D-v0 pushes with up to 0.6 m/s, GRagdoll2D-hardcore-v0 with up to 1 m/s. In
    GRagdoll2D-get-up-v0 the figure lies on its back or its front and gets up; nothing pushes it.

    ## Action Space
    `Box(-1, 1, (7,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    {action} The drive is a spring and damper of 300 N m/rad and 30 N m s/rad
    with at most 150 N m; at the ankles they are 150 N m/rad, 15 N m s/rad and 80 N m. Angles are those of
    the upper body part relative to the lower one at the waist, else of the lower one relative to the
    upper one, counterclockwise: positive bends a hip, lifts the toes, and leans the chest back.

    ## Observation Space
    `Box(low, high, ({entries},), float32)`, always within its bounds.

    {observation_table}

    The support reaches from the rearmost to the foremost point of the soles that carry load. The capture
    point is where the figure would have to step to come to rest: x + v sqrt(h / g), of the centre of
    mass at the height h (J. Pratt et al., "Capture point: a step toward humanoid push recovery", 2006).
    Loads of the soles are those of the last step: in the first observation they are 0, as in the air.

    ## Rewards
    The sum of these terms; `info` has each as `reward_<term>`:

    {reward_table}

    ## Starting State
{start}

    ## Episode End
{end}

    `info` has `success` and `is_success` (bool), `fell` (bool), `time` (s) and `pushes` (their number).

    ## Arguments
    """
    + ARGUMENTS
    + """

    ## Version History
    - v0: first version.
    """
)


_BALANCE = {
    "does": "stands on level ground with bent knees and is pushed at the\n    hips every 2 to 4 s",
    "feet": (
        "The ankles alone hold only light\n    pushes, for the soles are short: harder ones need hips, waist and "
        "steps, and after a step the feet\n    must come together again. "
    ),
    "action": BALANCE_ACTION,
    "entries": "42",
    "start": """\
    The figure stands on one foot or both, each joint within 0.06 rad of the stand, and moves forwards
    or backwards with up to 0.1 m/s. The first push comes after 1 to 4 s, the others 2 to 4 s after the
    one before. A push lasts 0.1 s and changes the velocity of the whole figure by 0.1 m/s to `push`,
    uniformly drawn, forwards or backwards.""",
    "end": f"""{FALL_END}
    - Termination: the ankles are more than 0.2 m apart for 2 s. The clock runs backwards while they are
      nearer, down to 0. (Legs astride, a constant action would hold the pushes.)
{TIME_END}""",
    "of_task": OF_BALANCE,
}
_GET_UP = {
    "does": "lies on level ground, face up or face down, and gets up;\n    nothing pushes it",
    "feet": "",
    "action": GET_UP_ACTION,
    "entries": "43",
    "start": """\
    The figure lies on the ground at rest, face up or face down, as one of 1,024 falls left it.""",
    "end": GET_UP_END,
    "of_task": OF_GET_UP,
}


@documented
class RagdollEnv(OneOfTasks, TaskEnv, Env[Any, Any]):
    __doc__ = filled(
        _SPECIFICATION, "GRagdoll2D-v0", "Keep a figure on its feet", _BALANCE | {"of_task": OF_ONE_OF_TASKS}
    )

    tasks = TASKS
    task_class = RagdollTask
    push: float


class RagdollVectorEnv(OneOfTasks, TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GRagdoll2D-v0 in one batch; see RagdollEnv for the task, TaskVectorEnv for the rest."""

    tasks = TASKS
    task_class = RagdollTask
    push: float


@documented
class RagdollHardcoreEnv(TaskEnv, Env[Any, Any]):
    __doc__ = filled(_SPECIFICATION, "GRagdoll2D-hardcore-v0", "Keep a figure on its feet", _BALANCE)

    task_class = RagdollHardcoreTask
    push: float


class RagdollHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GRagdoll2D-hardcore-v0 in one batch; see RagdollEnv for the task, TaskVectorEnv for the rest."""

    task_class = RagdollHardcoreTask
    push: float


@documented
class RagdollGetUpEnv(TaskEnv, Env[Any, Any]):
    __doc__ = filled(_SPECIFICATION, "GRagdoll2D-get-up-v0", "Get up from the ground", _GET_UP)

    task_class = RagdollGetUpTask
    push: float
    assist: float


class RagdollGetUpVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GRagdoll2D-get-up-v0 in one batch; see RagdollEnv for the task, TaskVectorEnv for the rest."""

    task_class = RagdollGetUpTask
    push: float
    assist: float
