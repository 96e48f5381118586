"""What the tasks of balancing figures in 2D and 3D share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.arguments import Quantity, Setting, number_within
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.task import Task
from gsenv.envs.ragdoll2d import scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.lying import NO_POSES
from gsenv.envs.ragdoll2d.privileged import MOST_PUSH, privileged_observations
from gsenv.solver import Options

TOLERANCE = 1e-3  # of "balanced": drives with bounded torques converge slowly, and errors of this size are not seen
RANGES = {  # drawn in each episode, unless `randomize` says otherwise
    "friction": (0.6, 1.2),
    "trunk_mass": (0.85, 1.15),
    "leg_mass": (0.85, 1.15),
    "strength": (0.85, 1.15),
    "delay": (0.0, 1.0),
}


def check_push(push: Any) -> float:
    """Return a push from 0 to 3 m/s as a float; raises ValueError for anything else."""
    return number_within(push, 0.0, MOST_PUSH, f"push must be a speed from 0 to {MOST_PUSH:g} m/s")


class OneOfTasks:
    """An environment whose argument `task` names its rules among `tasks`; ValueError for a name that is not there."""

    tasks: ClassVar[Mapping[str, type[Task]]]
    task_class: type[Task]

    def __init__(self, *args: Any, task: Any = "balance", **kwargs: Any) -> None:
        if not isinstance(task, str) or task not in self.tasks:
            raise ValueError(f"task must be one of {list(self.tasks)}, got {task!r}.")
        self.task_class = self.tasks[task]
        super().__init__(*args, **kwargs)


def push_setting(most: float) -> tuple[Setting, ...]:
    """Return the argument `push` with its default in m/s."""
    return (Setting("push", most, check_push, "m/s, the largest change of velocity by a push; 0: no pushes"),)


def check_assist(assist: Any) -> float:
    """Return a share from 0 to 0.9 as a float; raises ValueError for anything else."""
    return number_within(assist, 0.0, 0.9, "assist must be a share of the weight from 0 to 0.9")


GET_UP_SETTINGS = (
    *push_setting(0.0),
    Setting("assist", 0.0, check_assist, "share of the figure's weight that an upward force at its chest carries"),
)


def stand_term(direction: str) -> RewardTerm:
    """Return the term of standing calmly; `direction` says which speed counts."""
    return RewardTerm(
        "stand",
        f"{shared.STAND_WEIGHT:g} h u exp(-(v / {shared.CALM_SPEED:g} m/s)^2): h the height of the crown over that "
        f"in the stand, at most 1, u the cosine of the chest's tilt, v the speed of the centre of mass {direction}",
    )


POSTURE_TERM = RewardTerm(
    "posture",
    f"{shared.POSTURE_WEIGHT:g} exp(-d^2): d^2 the sum of the squares of the angles from the stand, rad^2",
)
_CALM_TERMS = (
    RewardTerm("smoothness", f"{shared.SMOOTH_WEIGHT:g} times the square of the change of the action"),
    RewardTerm("effort", f"{shared.EFFORT_WEIGHT:g} times the sum of the squares of torques over their nominal bounds"),
)
LAST_TERMS = (*_CALM_TERMS, RewardTerm("fall", f"{shared.FALL_REWARD:g} for a fall"))
GET_UP_TERMS = (
    RewardTerm(
        "stand",
        f"{shared.STAND_WEIGHT:g} s: s the mean of two shares, the height of the crown over that in the stand and the "
        "same of the hips, each at most 1",
    ),
    RewardTerm(
        "posture",
        f"{shared.POSTURE_WEIGHT:g} s^2 exp(-d^2): d^2 the sum of the squares of the angles from the stand, rad^2",
    ),
    *_CALM_TERMS,
    RewardTerm("fall", "0: falls cost nothing"),
)

ARGUMENTS = """{argument_table}

{of_task}

    All environments also have these:

    {shared_arguments}
    - `randomize`: domain randomisation: at each reset each world draws these quantities uniformly from
      (low, high), independently of earlier episodes. Here the default is
      `dict(friction=(0.6, 1.2), trunk_mass=(0.85, 1.15), leg_mass=(0.85, 1.15), strength=(0.85, 1.15), delay=(0, 1))`;
      `{}` draws nothing, and quantities that are not named stay nominal. `env.unwrapped.physics` has the
      values that were drawn.

    {quantity_table}

    - `diagnostics`: True adds these entries to `info`, which describe the last 1/60 s of each step (0 after a reset):

    {diagnostics_table}

    In frames an arrow shows each push; the length of its shaft is proportional to the change of velocity."""


OF_ONE_OF_TASKS = """\
    - `task`: "balance" or "get_up", when the environment is made. With "get_up" it gets the rules, the start and the
      arguments of the id whose name says so, and keeps its own time limit in `gymnasium.make` and `make_vec`.

    `reset(options={"push": p})` sets the largest push for one episode."""
OF_BALANCE = """\
    `reset(options={"push": p})` sets the largest push for one episode."""
OF_GET_UP = """\
    `reset(options={"push": p})` sets the largest push for one episode. `assist` is for curricula: the force acts at
    the chest's centre of mass, at all times."""
BALANCE_ACTION = (
    "An action a sets the target of each drive to the angle of the stand plus 0.6 of half the joint's\n"
    "    range times a; 0 asks for the stand."
)
GET_UP_ACTION = "An action asks each drive for an angle, as the table says."
FALL_END = """\
    - Termination: a fall. The crown is below 0.6 of its height in the stand, pelvis or chest tilt by
      more than 1 rad, or anything but the feet touches the ground."""
TIME_END = """\
    - Truncation: after 600 steps (20 s), by `gymnasium.make`, `gymnasium.make_vec` and the vector environment.
      `success` says at each step whether the figure still stands; standing at the end is success."""
GET_UP_END = """\
    - Getting up never terminates and is truncated after 300 steps (10 s), by `gymnasium.make`,
      `gymnasium.make_vec` and the vector environment. It is a success at steps where the figure has stood
      for 1 s: the crown at 0.9 of its height in the stand or more, the cosine of the chest's tilt 0.9 or
      more, nothing but the feet on the ground."""


def axis_text(name: str, stand: float, limits: tuple[float, float], span: float, getting_up: bool) -> str:
    """Return what an action does to a drive, for the table of actions; angles in rad."""
    words = f"target of the {name.replace('_', ' ')}"
    if getting_up:
        return f"{words}: from {limits[0]:.2f} (-1) through {stand:g} (0) to {limits[1]:.2f} rad (1)"
    return f"{words}: {stand:g} {span:+.2f} a rad"


def filled(text: str, name: str, goal: str, parts: Mapping[str, str]) -> str:
    """Return the docstring of an environment, where `parts` says what its task does otherwise."""
    for mark, words in {**parts, "id": name, "goal": goal}.items():
        text = text.replace("{" + mark + "}", words)
    return text


class BalanceTask(Task):
    """The rules of keeping a figure on its feet that are the same in 2D and 3D."""

    info_fields = (("success", "?"), ("is_success", "?"), ("fell", "?"), ("time", "f8"), ("pushes", "i8"))
    ranges = RANGES
    engine_steps = shared.ENGINE_STEPS
    arguments = push_setting(0.6)
    quantities = (
        Quantity("friction", "friction coefficient of the soles and of all else", scene.FRICTION, 0.05, 2.0),
        Quantity("trunk_mass", "masses of pelvis, chest, head and arms over their nominal ones", 1.0, 0.5, 2.0),
        Quantity("leg_mass", "masses of legs and feet over their nominal ones", 1.0, 0.5, 2.0),
        Quantity("strength", "bounds of the torques over their nominal ones", 1.0, 0.2, 3.0),
        Quantity("delay", "actions act one step late where this is 0.5 or more", 0.0, 0.0, 1.0, "steps"),
    )
    balanced_substeps: ClassVar[int] = 2
    getting_up: ClassVar[bool] = False  # the figure lies at the start
    privileged: ClassVar[tuple[Entry, ...]]  # of `privileged_observations`

    def lying(self) -> NDArray[np.float64]:
        """Return the poses in which an episode may begin, see lying.py; none where the figure stands."""
        return NO_POSES

    def push_directions(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the directions of the next push and of the last one, seen by the figure, (world, axis)."""
        forwards = np.ones((len(self.task_state), 1))
        return forwards, forwards

    def privileged_observations(self) -> NDArray[np.float32]:
        """Return what `privileged` names, (world, entry)."""
        return privileged_observations(self.task_state, self.physics, *self.push_directions())

    def solver_options(self) -> Options:
        options = Options.preset(self.fidelity)
        if self.fidelity != "balanced":
            return options
        return replace(options, substeps=self.balanced_substeps, tolerance=max(options.tolerance, TOLERANCE))

    def captions(self, world: int) -> Sequence[str]:
        state = self.task_state[world]
        lines = [f"{state['steps'] * shared.CONTROL_TIME:.1f} s"]
        if state["pushed"] < shared.SHOWN_STEPS:
            lines.append(f"push {abs(state['push']):.2f} m/s")
        if self.infos["fell"][world]:
            lines.append("fell")
        if self.getting_up and state["stood"] >= 3:  # not for a moment
            lines.append(f"stands {state['stood'] * shared.CONTROL_TIME:.1f} s")
        return lines
