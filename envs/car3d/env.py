"""GCar3D-v0 and GCar3D-hardcore-v0: a car follows a winding road over hills and obstacles against the clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from gymnasium import Env
from gymnasium.vector import VectorEnv

from gsenv.envs import time_limit
from gsenv.envs.car.env import check_difficulty
from gsenv.envs.car3d import observe, rules, scene
from gsenv.envs.car3d.build import NAMES, build_scene
from gsenv.envs.core.arguments import Quantity, Setting, with_defaults
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.steering import Stick, pair
from gsenv.envs.core.task import Array, Task, documented
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.solver import Options, Scene

TOLERANCE = 1e-3  # of "balanced": contacts of many tyres converge slowly, and errors of this size are not seen
HALVINGS = {"fast": 0, "balanced": 0, "accurate": Options().halvings}  # steps in parts take half as long again
AXES = ("forwards", "to the left", "upwards")
KIND_NAMES = ("ramps", "bumps", "balls")


def _wheel_entries() -> list[Entry]:
    names = [(name, name.replace("_", " ")) for name in NAMES]
    return [
        *(Entry(f"{text} wheel, rolling speed", f"{name}_speed", -3, 3, "10 m/s") for name, text in names),
        *(
            Entry(
                f"{text} suspension, compression relative to its travel", f"{name}_travel", -2, 2, f"{scene.TRAVEL} m"
            )
            for name, text in names
        ),
        *(Entry(f"1 while the {text} wheel touches something", f"{name}_touches", 0, 1) for name, text in names),
    ]


def _waypoint_entries() -> list[Entry]:
    return [
        Entry(
            f"centre line {ahead:g} m ahead, {text} of the car",
            f"waypoint_{k}_{axis}",
            -1.5,
            1.5,
            f"{observe.LOOK:g} m",
        )
        for k, ahead in enumerate(observe.AHEAD)
        for axis, text in zip("xyz", AXES, strict=True)
    ]


def _patch_entries() -> list[Entry]:
    entries = []
    for i in range(observe.PATCH_ROWS):
        for j in range(observe.PATCH_COLUMNS):
            forth = observe.FIRST_ROW + observe.ROW_SPACING * i
            aside = observe.COLUMN_SPACING * (observe.PATCH_COLUMNS // 2 - j)
            text = f"surface {forth:.1f} m ahead and {aside:.1f} m to the left, over the chassis' own level ground"
            entries.append(Entry(text, f"height_{i}_{j}", -3, 3, f"{observe.HEIGHT_UNIT:g} m"))
    return entries


class Car3DTask(Task):
    """The rules for many worlds; `settings` has the defaults of a reset."""

    actions = (
        Entry("throttle: positive drives, negative brakes", "throttle", -1, 1),
        Entry("steering: positive to the left", "steering", -1, 1),
    )
    controls = (
        (
            *pair("down", "up", "brake|drive", "throttle"),
            *pair("right", "left", "steer", "steering"),
            *pair("s", "w", "brake|drive", "throttle"),
            *pair("d", "a", "steer", "steering"),
            Stick("triggers", {"throttle": 1.0}),
            Stick("left_x", {"steering": -1.0}),
        ),
    )
    observations = (
        *(Entry(f"chassis, velocity {axis}", f"v{k}", -3, 3, "10 m/s") for k, axis in zip("xyz", AXES, strict=True)),
        *(
            Entry(f"chassis, turning rate about the axis {axis}", f"w{k}", -4, 4, "3 rad/s")
            for k, axis in zip("xyz", AXES, strict=True)
        ),
        *(Entry(f"vertical, {axis} of the car", f"up_{k}", -1, 1) for k, axis in zip("xyz", AXES, strict=True)),
        *_wheel_entries(),
        Entry("angle that the front wheels are steered to", "steered", -1, 1, f"{scene.STEERING:g} rad"),
        Entry("last action, throttle", "last_throttle", -1, 1),
        Entry("last action, steering", "last_steering", -1, 1),
        Entry("distance to the left of the centre line", "aside", -3, 3, f"{scene.ROAD_HALF:g} m"),
        Entry("time since a wheel touched something", "flight", 0, 2, f"{observe.FLIGHT_STEPS / 30:g} s"),
        Entry("distance to the finish, along the centre line", "to_finish", -0.5, 1.5, "100 m"),
        Entry("time since the start", "time", 0, 2, f"{observe.TIME_UNIT / 30:g} s"),
        Entry("distance to the next gate, along the centre line; 2 where there is none", "to_gate", -1, 2, "10 m"),
        *(Entry(f"1 where the next gate belongs to {kind}", f"gate_{kind}", 0, 1) for kind in KIND_NAMES),
        *_waypoint_entries(),
        *(
            Entry(
                f"curvature of the centre line {ahead:g} m ahead, positive to the left", f"bend_{k}", -2, 2, "0.25 / m"
            )
            for k, ahead in enumerate(observe.BENDS_AHEAD)
        ),
        *_patch_entries(),
    )
    max_episode_steps = time_limit("GCar3D-v0")  # of both tiers
    reward_terms = (
        RewardTerm(
            "progress",
            f"{rules.PROGRESS_WEIGHT:g} per m along the centre line at up to {rules.PAID_SPEED:g} m/s, and "
            f"{rules.FAST_WEIGHT:g} per m beyond what that speed gives; less on the way back; nothing beside the road, "
            f"and once no wheel has touched anything for {observe.FLIGHT_STEPS / 30:g} s",
        ),
        RewardTerm("time", f"{rules.TIME_REWARD:g} per step"),
        RewardTerm("finish", f"{rules.FINISH_REWARD:g} at the finish"),
        RewardTerm(
            "failure",
            f"{rules.FAILURE_REWARD:g} for rolling over or straying, and {rules.TIME_REWARD:g} for each step that is "
            f"left of {max_episode_steps}",
        ),
        RewardTerm(
            "gates",
            f"{rules.MISS_REWARD:g} for a missed gate, and {rules.JUMP_WEIGHT:g} per m that the car moves forwards "
            "from there until both axles have touched something at the gate or behind it",
        ),
        RewardTerm(
            "off_road",
            f"{rules.OFF_ROAD_REWARD:g} per step beside the road, and {rules.OFF_ROAD_WEIGHT:g} more for each m "
            "farther out",
        ),
        RewardTerm("smoothness", f"{rules.SMOOTH_WEIGHT:g} times the mean square change of the actions"),
    )
    task_state_fields = rules.TASK_STATE_FIELDS
    info_fields = (
        ("success", "?"), ("is_success", "?"), ("distance", "f8"), ("gates", "i8"),
        ("missed_gates", "i8"), ("rolled_over", "?"), ("off_road", "?"),
        ("off_road_time", "f8"), ("strayed", "?"),
    )  # fmt: skip
    draw_count = rules.DRAW_COUNT
    arguments: ClassVar[tuple[Setting, ...]] = (Setting("difficulty", 0.5, check_difficulty, "0 to 1: see above"),)
    quantities = (
        Quantity("friction", "friction coefficient of everything", scene.FRICTION, 0.05, 2.0),
        Quantity("mass", "mass of the chassis", scene.CHASSIS_MASS, 50.0, 500.0, "kg"),
        Quantity(
            "wheel_torque",
            "torque of each motor at a full action; its brake changes as well",
            scene.TORQUE,
            10.0,
            400.0,
            "N m",
        ),
        Quantity("suspension", "stiffness of each wheel's spring", scene.STIFFNESS, 2000.0, 50000.0, "N/m"),
        Quantity("gravity", "gravity", scene.GRAVITY, 0.5, 30.0, "m/s^2"),
    )

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._paint: Any = None

    def build_scene(self) -> Scene:
        return build_scene()

    def solver_options(self) -> Options:
        options = Options.preset(self.fidelity, halvings=HALVINGS[self.fidelity])
        return replace(options, tolerance=max(options.tolerance, TOLERANCE)) if self.fidelity == "balanced" else options

    def initialize_episode(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        rules.initialize_worlds(self.kernel_world, worlds, options["difficulty"], draws)

    def apply_action(self, actions: Array) -> int:
        return rules.apply_actions(self.kernel_world, actions)

    def evaluate(self) -> None:
        rules.evaluate_worlds(self.kernel_world, self.max_episode_steps)

    def camera(self, world: int, width: int, height: int) -> Any:
        """Return a camera behind and above the car, which looks along the road."""
        from gsenv.render.spatial import SpatialCamera

        *gaze, heading = self.task_state["gaze"][world].tolist()
        ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
        side = np.array([-ahead[1], ahead[0], 0.0])
        target = np.array(gaze) + 2.2 * ahead + np.array([0.0, 0.0, 0.5])
        eye = np.array(gaze) - 5.4 * ahead + 1.6 * side + np.array([0.0, 0.0, 3.3])
        return SpatialCamera(eye, target, fov=0.95, width=width, height=height)

    def decor(self, world: int) -> dict[str, Any]:
        """Return the road, which is painted on the ground."""
        from gsenv.envs.car3d.road_paint import RoadPaint

        if self._paint is None:
            self._paint = RoadPaint()
        return {"stripes": self._paint.stripes(world, self.task_state["path"][world])}

    def captions(self, world: int) -> Sequence[str]:
        velocity = self.world.state.bodies["velocity"][world, scene.CHASSIS_BODY, :3]
        state, info = self.task_state[world], self.infos[world]
        lines = [f"{state['place']:.0f} / {scene.FINISH:.0f} m", f"{3.6 * np.linalg.norm(velocity):.0f} km/h"]
        if info["missed_gates"]:
            lines.append(f"{info['missed_gates']} gate{'s' if info['missed_gates'] > 1 else ''} missed")
        if info["off_road_time"] > 0.0:
            lines.append(f"{info['off_road_time']:.1f} s off the road")
        ends = (("rolled_over", "rolled over"), ("strayed", "off the course"))
        lines += [text for name, text in ends if info[name]]
        return lines


class Car3DHardcoreTask(Car3DTask):
    """Car3DTask at the largest difficulty, against the same clock."""

    arguments = with_defaults(Car3DTask.arguments, difficulty=1.0)


_SPECIFICATION = """Follow a winding road against the clock: {id}.

    ## Description
    A car of 200 kg with four driven wheels on springs, the front ones steered, follows a road of
    122 m over hills to a chequered banner. Between straights the road has three chicanes, each a pair of
    sharp bends that differ in radius and turn, and across the straights stand up to three obstacles:
    ramps, speed bumps, and rows of loose balls. At each obstacle stands a gate, which both axles must
    pass on the ground. A car that is too fast slides off the road in bends and jumps the gates, and one
    that is slow enough everywhere runs out of time: the way to succeed is to brake before bends,
    crests and gates, and nowhere else. More than 8 m/s are never needed, and cost. Control runs at 30 Hz.

    Gates stand shortly behind the middle of ramps, at the last of three bumps and in the row of balls. An
    axle passes where one of its wheels touches something while the axle is within 0.4 m before and behind
    the gate, and the middle of the car within 2 m of the centre line. When both axles have passed, the
    gate's bar turns from red to green; it is missed as soon as an axle is 0.4 m beyond it without.

    At `difficulty` 0 the road is nearly straight and level and empty. With rising difficulty, its bends
    become tighter and turn farther, its climbs and the hills beside it steeper, and obstacles more
    frequent (from 0.4 on all three stand). GCar3D-v0 has 0.5 and GCar3D-hardcore-v0 1. The ground is a
    heightfield of cells of 1 m, of its own in each world and episode.

    ## Action Space
    `Box(-1, 1, (2,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    Throttle, positive: each motor drives its wheel with that fraction of its torque, 110 N m, up to
    36 rad/s (13 m/s). Negative: brakes slow the wheels with that fraction of 200 N m each; there is no
    reverse gear. The steering asks for an angle of the front wheels of up to 0.5 rad, which they turn to at
    2 rad/s at most.

    ## Observation Space
    `Box(low, high, (90,), float32)`, always within its bounds. Vectors are in the frame of the chassis.

    {observation_table}

    The heights of the surface are a patch of 7 x 5 points ahead of the car, turned with its heading, and
    include obstacles. What touches something is known of the last step: in the first observation nothing does.

    ## Rewards
    The sum of these terms; `info` has each as `reward_<term>`:

    {reward_table}

    Progress is a difference of places, so going to and fro earns nothing. A jump over a gate costs more the
    farther it goes, and a slide off the road the longer and farther it goes, so that a car that is too fast
    gains by being a little slower. Who gives up pays for the time that is left, so it saves none; beyond that a
    failure costs little, so that a first attempt to drive costs no more than to stand still.

    ## Starting State
    The car is at rest on level ground at the start of the road; bends and climbs begin after 6 m. The
    middles of the chicanes are at 22, 58 and 94 m, within 2 m to both sides, and chicanes lead back to the
    middle of the ground. Of each, the turn, the radius, the link between its bends and, near the middle,
    the side are drawn. Between them the heading follows a wave of 40 to 56 m. The slope of the road's
    height is the sum of two waves of uniformly drawn lengths (11 to 16 m and 30 to 45 m) and phases.
    Obstacles stand at 40, 76 and 112 m, within 2 m to both sides, where the road is level. Their kinds
    and order, which of them stand, and the places of balls are drawn anew in each episode.

    ## Episode End
    - Termination: the middle of the chassis is at 122 m along the centre line. It is a success if no gate was
      missed and the middle was never beside the drawn road, more than 2.2 m from the centre line.
    - Termination, failure: the car has rolled over (its upward axis has a vertical part below 0.2), or has
      strayed: more than 6 m from the centre line or 5 m behind the start, or beside the road for a whole second.
    - Truncation: after 585 steps (19.5 s), by `gymnasium.make`, `gymnasium.make_vec` and the vector environment.

    `info` has `success` and `is_success` (bool), `distance` (m, the largest along the centre line),
    `gates` (number passed), `missed_gates` (number), `rolled_over` (bool), `off_road` (bool, now beside the
    road), `off_road_time` (s, until now) and `strayed` (bool).

    ## Arguments
    {argument_table}

    `reset(options={"difficulty": d})` sets it for one episode. All environments also have these:

    {shared_arguments}
    - `randomize`: domain randomisation, `dict(friction=(0.4, 0.9))`: at each reset each world draws
      these quantities uniformly from (low, high), independently of earlier episodes; the others
      stay nominal. `env.unwrapped.physics` has the values that were drawn.

    {quantity_table}

    - `diagnostics`: True adds these entries to `info`, which describe the last 1/60 s of each step (0 after a reset):

    {diagnostics_table}

    ## Version History
    - v0: first version.
    """


@documented
class Car3DEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _SPECIFICATION.replace("{id}", "GCar3D-v0")

    task_class = Car3DTask
    difficulty: float


class Car3DVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GCar3D-v0 in one batch; see Car3DEnv for the task, TaskVectorEnv for the rest."""

    task_class = Car3DTask
    difficulty: float


@documented
class Car3DHardcoreEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _SPECIFICATION.replace("{id}", "GCar3D-hardcore-v0")

    task_class = Car3DHardcoreTask
    difficulty: float


class Car3DHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GCar3D-hardcore-v0 in one batch; see Car3DHardcoreEnv for the task, TaskVectorEnv for the rest."""

    task_class = Car3DHardcoreTask
    difficulty: float
