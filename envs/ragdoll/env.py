"""GRagdoll-v0: a figure with 21 driven joints keeps its balance in 3D while it is pushed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import Env
from gymnasium.vector import VectorEnv

from gsenv.envs import time_limit
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.spec_tables import Entry
from gsenv.envs.core.steering import Stick, pair
from gsenv.envs.core.task import Array, Task, documented
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll import figure, rules
from gsenv.envs.ragdoll.build import build_scene, paint
from gsenv.envs.ragdoll2d.lying import lying_poses
from gsenv.envs.ragdoll2d.privileged import entries, next_push
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
from gsenv.solver.spatial.joint_readings import rotated

EYE = (-1.55, -2.75, 0.5)  # m, of the camera, from where it looks
SHOWN_HEIGHT = 0.86  # m, where the camera looks


def _axis_actions(getting_up: bool = False) -> tuple[Entry, ...]:
    return tuple(
        Entry(axis_text(axis.name, axis.stand, axis.limits, axis.span, getting_up), axis.name, -1, 1)
        for axis in figure.AXES
    )


def _words(name: str) -> str:
    return name.replace("_", " ")


def _joint_entries() -> tuple[Entry, ...]:
    names = [axis.name for axis in figure.AXES]
    return (
        *(Entry(f"{_words(name)}, angle from that of the stand", f"{name}_angle", -4, 4, "rad") for name in names),
        *(Entry(f"{_words(name)}, rate", f"{name}_rate", -5, 5, "10 rad/s") for name in names),
        *(Entry(f"last action, {_words(name)}", f"last_{name}", -1, 1) for name in names),
    )


def _limb_entries() -> tuple[Entry, ...]:
    entries = []
    for limb in ("left_foot", "right_foot", "left_hand", "right_hand"):
        words = _words(limb)
        entries.append(Entry(f"{words}, forwards from the centre of mass", f"{limb}_x", -4, 4, "0.5 m"))
        entries.append(Entry(f"{words}, to the left of it", f"{limb}_y", -4, 4, "0.5 m"))
        if limb.endswith("foot"):
            entries.append(Entry(f"{words}, height of the sole", f"{limb}_z", -1, 10, "0.2 m"))
        else:
            entries.append(Entry(f"{words}, upwards from the centre of mass", f"{limb}_z", -4, 4, "0.5 m"))
    return tuple(entries)


def _directions(angles: Array) -> Array:
    return np.stack([np.cos(angles), np.sin(angles)], 1)


class RagdollTask(BalanceTask):
    """The rules for many worlds; `settings` has the defaults of a reset."""

    actions = _axis_actions()
    controls = (
        (
            *pair("down", "up", "ankles: lean", "left_ankle", "right_ankle"),
            *pair("left", "right", "ankles: lean", "left_ankle_side", "right_ankle_side"),
            *pair("z", "x", "waist", "waist"),
            *pair("q", "w", "left hip", "left_hip"),
            *pair("a", "s", "left knee", "left_knee"),
            *pair("e", "t", "right hip", "right_hip"),
            *pair("d", "g", "right knee", "right_knee"),
            *pair("o", "p", "arms", "left_shoulder", "right_shoulder"),
            *pair("k", "l", "spread the legs", "left_hip_spread", "right_hip_spread"),
            Stick("left_x", {"left_ankle_side": 1.0, "right_ankle_side": 1.0}),
            Stick("left_y", {"left_ankle": 1.0, "right_ankle": 1.0}),
            Stick("right_y", {"waist": 1.0}),
        ),
    )
    observations = (
        Entry("height of the crown over that in the stand, less 1", "height", -5, 5, "0.2"),
        Entry("direction of gravity, along the pelvis' forward axis", "down_x", -1, 1),
        Entry("direction of gravity, along the pelvis' axis to the left", "down_y", -1, 1),
        Entry("direction of gravity, along the pelvis' upward axis", "down_z", -1, 1),
        Entry("centre of mass, velocity forwards", "vx", -5, 5, "m/s"),
        Entry("centre of mass, velocity to the left", "vy", -5, 5, "m/s"),
        Entry("centre of mass, velocity upwards", "vz", -5, 5, "m/s"),
        Entry("pelvis, angular velocity about the forward axis", "wx", -5, 5, "5 rad/s"),
        Entry("pelvis, angular velocity about the axis to the left", "wy", -5, 5, "5 rad/s"),
        Entry("pelvis, angular velocity about the vertical", "wz", -5, 5, "5 rad/s"),
        Entry("centre of mass, forwards from the middle of the support", "mass_x", -10, 10, "0.2 m"),
        Entry("centre of mass, to the left of it", "mass_y", -10, 10, "0.2 m"),
        Entry("capture point, forwards from the middle of the support", "capture_x", -10, 10, "0.2 m"),
        Entry("capture point, to the left of it", "capture_y", -10, 10, "0.2 m"),
        Entry("left foot, load over the weight of the figure", "left_load", 0, 5),
        Entry("right foot, load over the weight of the figure", "right_load", 0, 5),
        *_limb_entries(),
        *_joint_entries(),
    )
    reward_terms = (stand_term("along the ground"), POSTURE_TERM, *LAST_TERMS)
    task_state_fields = rules.TASK_STATE_FIELDS
    max_episode_steps = time_limit("GRagdoll-v0")
    draw_count = rules.DRAW_COUNT
    privileged = entries(BalanceTask.quantities, ("forwards", "to the left"))
    shown_height = SHOWN_HEIGHT
    balanced_substeps = 1  # of 1/60 s: overlaps stay below 0.5 mm in 99 of 100 steps of random drives

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        paint(self.world.model)
        self.figure = figure.tables(self.world.model, self._names, self.lying())

    def build_scene(self) -> Scene:
        built, self._names = build_scene()
        return built

    def initialize_episode(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        rules.initialize_worlds(
            self.kernel_world, self.figure, worlds, options["push"], self.getting_up, options.get("assist", 0.0),
            draws, self.world.timestep,
        )  # fmt: skip

    def apply_action(self, actions: Array) -> int:
        return rules.apply_actions(self.kernel_world, self.figure, actions)

    def evaluate(self) -> None:
        rules.evaluate_worlds(self.kernel_world, self.figure, self.world.timestep)

    def push_directions(self) -> tuple[Array, Array]:
        """Return the directions of the next push and of the last one from the pelvis' heading, (world, 2)."""
        state, facing = self.task_state, self._headings()
        following = np.take_along_axis(state["headings"], next_push(state), 1)[:, 0]
        return _directions(following - facing), _directions(state["heading"] - facing)

    def _headings(self) -> Array:
        """Return the heading of the pelvis' forward axis in rad, (world,)."""
        bodies: Any = self.world.state.bodies
        figure: Any = self.figure
        forward = rotated(bodies["rotation"][:, int(figure.parts["pelvis"])], np.array([1.0, 0.0, 0.0]))
        return np.asarray(np.arctan2(forward[:, 1], forward[:, 0]))

    def camera(self, world: int, width: int, height: int) -> Any:
        """Return a camera that follows the hips and sees the figure from its right front."""
        from gsenv.render.spatial import SpatialCamera

        x, y = (float(at) for at in self.task_state["gaze"][world])
        eye = (x + EYE[0], y + EYE[1], self.shown_height + EYE[2])
        return SpatialCamera(eye, (x, y, self.shown_height), width=width, height=height)

    def decor(self, world: int) -> dict[str, Any]:
        """Return the arrow of a push, which has no length while there is none."""
        from gsenv.envs.ragdoll.push_arrow import find_arrow

        if self.getting_up:
            return {}
        figure: Any = self.figure
        return {"arrows": [find_arrow(self.world, world, figure.parts, float(self.task_state["push"][world]))]}


class RagdollHardcoreTask(RagdollTask):
    """The same with harder pushes."""

    max_episode_steps = time_limit("GRagdoll-hardcore-v0")
    arguments = push_setting(1.0)


class RagdollGetUpTask(RagdollTask):
    """The figure lies on the ground and gets up."""

    max_episode_steps = time_limit("GRagdoll-get-up-v0")
    arguments = GET_UP_SETTINGS
    actions = _axis_actions(getting_up=True)
    reward_terms = GET_UP_TERMS
    getting_up = True
    shown_height = 0.7  # a limb towards the camera is far down in the picture where the figure lies

    def lying(self) -> Array:
        return lying_poses("GRagdoll-get-up-v0")


TASKS: dict[str, type[Task]] = {"balance": RagdollTask, "get_up": RagdollGetUpTask}


_SPECIFICATION = (
    """{goal}: {id}.

    ## Description
    A person of 1.7 m and 60 kg {does}.
    21 drives in waist, shoulders, elbows, hips, knees and ankles follow the angles that the actions ask for,
    with bounded torques. Each foot is a box of 26 x 9 cm{feet}.
    Control runs at 30 Hz. The left leg collides with the right one; arms and trunk touch only the ground. The
    figure is the file `assets/ragdoll.xml`, in MuJoCo's format.

    GRagdoll-v0 pushes with up to 0.6 m/s, GRagdoll-hardcore-v0 with up to 1 m/s. In GRagdoll-get-up-v0
    the figure lies on any side and gets up; nothing pushes it.

    ## Action Space
    `Box(-1, 1, (21,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    {action} The drive is a spring and damper of 300 N m/rad and 30 N m s/rad
    with at most 150 N m at waist, hips and knees; 150 N m/rad, 15 N m s/rad and 80 N m at the ankles;
    60 N m/rad, 6 N m s/rad and 50 N m in the arms. Positive angles bend a hip or an elbow, lift the toes,
    lean the chest back or to the right, turn it to the left, lift an arm forwards, spread a leg or an arm,
    turn the toes outwards, and lift the outer edge of a sole.

    ## Observation Space
    `Box(low, high, (91,), float32)`, always within its bounds. Forwards is the direction of the pelvis
    along the ground.

    {observation_table}

    The middle of the support is the mean of the middles of the soles that carry load. The capture point
    is where the figure would have to step to come to rest: x + v sqrt(h / g), of the centre of mass at the
    height h (J. Pratt et al., "Capture point: a step toward humanoid push recovery", 2006).
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
    "does": "stands on level ground with bent knees and is pushed at the hips every 2 to 4 s,\n    from all sides",
    "feet": (", so the ankles\n    alone hold only light pushes: harder ones need hips, waist, arms and steps"),
    "action": BALANCE_ACTION,
    "start": """\
    The figure looks along -y and stands on one foot or both, each joint within 0.04 rad of the stand, and
    moves with up to 0.1 m/s along x and y. The first push comes after 1 to 4 s, the others 2 to 4 s after
    the one before. A push lasts 0.1 s and changes the velocity of the whole figure by 0.1 m/s to `push`,
    uniformly drawn, in any direction along the ground.""",
    "end": f"{FALL_END}\n{TIME_END}",
    "of_task": OF_BALANCE,
}
_GET_UP = {
    "does": "lies on level ground and gets up; nothing pushes it",
    "feet": "",
    "action": GET_UP_ACTION,
    "start": """\
    The figure lies on the ground at rest, on its back, front or a side, as one of 1,024 falls left it, and
    heads in any direction.""",
    "end": GET_UP_END,
    "of_task": OF_GET_UP,
}


@documented
class RagdollEnv(OneOfTasks, TaskEnv, Env[Any, Any]):
    __doc__ = filled(
        _SPECIFICATION, "GRagdoll-v0", "Keep a figure on its feet in 3D", _BALANCE | {"of_task": OF_ONE_OF_TASKS}
    )

    tasks = TASKS
    task_class = RagdollTask
    push: float


class RagdollVectorEnv(OneOfTasks, TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GRagdoll-v0 in one batch; see RagdollEnv for the task, TaskVectorEnv for the rest."""

    tasks = TASKS
    task_class = RagdollTask
    push: float


@documented
class RagdollHardcoreEnv(TaskEnv, Env[Any, Any]):
    __doc__ = filled(_SPECIFICATION, "GRagdoll-hardcore-v0", "Keep a figure on its feet in 3D", _BALANCE)

    task_class = RagdollHardcoreTask
    push: float


class RagdollHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GRagdoll-hardcore-v0 in one batch; see RagdollEnv for the task, TaskVectorEnv for the rest."""

    task_class = RagdollHardcoreTask
    push: float


@documented
class RagdollGetUpEnv(TaskEnv, Env[Any, Any]):
    __doc__ = filled(_SPECIFICATION, "GRagdoll-get-up-v0", "Get up from the ground in 3D", _GET_UP)

    task_class = RagdollGetUpTask
    push: float
    assist: float


class RagdollGetUpVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GRagdoll-get-up-v0 in one batch; see RagdollEnv for the task, TaskVectorEnv for the rest."""

    task_class = RagdollGetUpTask
    push: float
    assist: float
