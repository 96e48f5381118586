"""GCar-v0: a car with two driven wheels on springs crosses hills, bridges, see-saws and loose boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gymnasium import Env
from gymnasium.vector import VectorEnv

from gsenv.envs import time_limit
from gsenv.envs.car import rules, scene
from gsenv.envs.car.build import build_scene
from gsenv.envs.core.arguments import Quantity, Setting, number_within
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.steering import Stick, pair
from gsenv.envs.core.task import Array, Task, documented
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.solver import Options, Scene


def check_difficulty(difficulty: Any) -> float:
    """Return a difficulty from 0 to 1 as a float; raises ValueError for anything else."""
    return number_within(difficulty, 0.0, 1.0, "difficulty must be a number from 0 to 1")


def _difficulty_setting(difficulty: float) -> tuple[Setting, ...]:
    return (Setting("difficulty", difficulty, check_difficulty, "0 to 1: see above"),)


def _heights() -> list[Entry]:
    entries = []
    for k in range(rules.HEIGHTS):
        ahead = rules.FIRST_HEIGHT + rules.HEIGHT_SPACING * k
        text = f"ground {ahead:.1f} m ahead, from where the wheels would stand if the car were level here"
        entries.append(Entry(text, f"height_{k}", -2.5, 2.5, f"{rules.HEIGHT_UNIT:g} m"))
    return entries


class CarTask(Task):
    """The rules for many worlds; `settings` has the defaults of a reset."""

    actions = (
        Entry("rear drive: positive drives, negative brakes, then backs up", "rear", -1, 1),
        Entry("front drive, likewise", "front", -1, 1),
    )
    controls = (
        (
            *pair("left", "right", "brake, back|drive", "rear", "front"),
            *pair("a", "d", "rear wheel alone", "rear"),
            *pair("s", "w", "front wheel alone", "front"),
            Stick("triggers", {"rear": 1.0, "front": 1.0}),
            Stick("left_x", {"rear": 1.0, "front": 1.0}),
        ),
    )
    observations = (
        Entry("distance to the finish", "to_finish", -0.5, 1.5, "100 m"),
        Entry("chassis, height over the ground below", "height", -2.5, 5, f"{rules.HEIGHT_UNIT:g} m"),
        Entry("chassis, sine of its pitch (nose up is positive)", "sine", -1, 1),
        Entry("chassis, cosine of its pitch", "cosine", -1, 1),
        Entry("chassis, velocity towards the finish", "vx", -3, 3, "10 m/s"),
        Entry("chassis, velocity upwards", "vy", -3, 3, "10 m/s"),
        Entry("chassis, pitch rate", "w", -4, 4, f"{rules.RATE_UNIT:g} rad/s"),
        Entry("rear wheel, rolling speed forwards", "rear_speed", -3, 3, "10 m/s"),
        Entry("front wheel, rolling speed forwards", "front_speed", -3, 3, "10 m/s"),
        Entry("rear suspension, compression relative to its travel", "rear_travel", -1.5, 1.5, f"{scene.TRAVEL} m"),
        Entry("front suspension, compression relative to its travel", "front_travel", -1.5, 1.5, f"{scene.TRAVEL} m"),
        Entry("rear suspension, rate of compression", "rear_rate", -4, 4, f"{rules.RATE_UNIT:g} m/s"),
        Entry("front suspension, rate of compression", "front_rate", -4, 4, f"{rules.RATE_UNIT:g} m/s"),
        Entry("1 while the rear wheel touches something", "rear_touches", 0, 1),
        Entry("1 while the front wheel touches something", "front_touches", 0, 1),
        Entry("1 while the chassis touches something", "chassis_touches", 0, 1),
        Entry("last action, rear", "last_rear", -1, 1),
        Entry("last action, front", "last_front", -1, 1),
        Entry("1 where the rear wheel alone has touched something below the next gate", "rear_below", 0, 1),
        Entry("1 where the front wheel alone has, so that the rear one must, too", "front_below", 0, 1),
        Entry("middle of the next gate, ahead of the chassis; 2 where there is none", "to_gate", -1, 2, "10 m"),
        Entry("time since a wheel touched something", "flight", 0, 2, f"{rules.FLIGHT_STEPS / 30:g} s"),
        Entry("shock of the last step", "shock", 0, 2, f"{rules.SHOCK_LIMIT:g} g"),
        Entry("time on the roof", "roof_time", 0, 1, "s"),
        *_heights(),
    )
    reward_terms = (
        RewardTerm(
            "progress",
            f"{rules.PROGRESS_WEIGHT:g} per m towards the finish, less on the way back; nothing forwards once no wheel "
            f"has touched anything for {rules.FLIGHT_STEPS / 30:g} s",
        ),
        RewardTerm("time", f"{rules.TIME_REWARD:g} per step"),
        RewardTerm("finish", f"{rules.FINISH_REWARD:g} at the finish"),
        RewardTerm("failure", f"{rules.FAILURE_REWARD:g} for a crash, a missed gate, or 1 s on the roof"),
        RewardTerm(
            "shock",
            f"{rules.SHOCK_WEIGHT:g} times the square of the part of the shock over {rules.FREE_SHOCK:g} of its limit",
        ),
        RewardTerm(
            "energy", f"{rules.ENERGY_WEIGHT:g} per kJ that the motors put in, by their power at the end of the step"
        ),
        RewardTerm("smoothness", f"{rules.SMOOTH_WEIGHT:g} times the mean square change of the actions"),
    )
    task_state_fields = rules.TASK_STATE_FIELDS
    info_fields = (
        ("success", "?"), ("is_success", "?"), ("distance", "f8"), ("gates", "i8"), ("missed_gates", "i8"),
        ("crashed", "?"), ("shock", "f8"), ("roof_time", "f8"),
    )  # fmt: skip
    max_episode_steps = time_limit("GCar-v0")
    draw_count = rules.DRAW_COUNT
    captions_below = True  # over the ground: gates reach into the upper corner
    arguments = _difficulty_setting(0.5)
    quantities = (
        Quantity("friction", "friction coefficient of everything", scene.FRICTION, 0.05, 2.0),
        Quantity("mass", "mass of the chassis", scene.CHASSIS_MASS, 30.0, 300.0, "kg"),
        Quantity(
            "wheel_torque",
            "torque of each motor at a full action; its brake changes as well",
            scene.TORQUE,
            20.0,
            1000.0,
            "N m",
        ),
        Quantity("suspension", "stiffness of each wheel's spring", scene.STIFFNESS, 2000.0, 50000.0, "N/m"),
        Quantity("gravity", "gravity", scene.GRAVITY, 0.5, 30.0, "m/s^2"),
    )

    def build_scene(self) -> Scene:
        return build_scene()

    def solver_options(self) -> Options:
        """The policies were trained by rows."""
        return Options.preset(self.fidelity, articulated=False)

    def initialize_episode(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        rules.initialize_worlds(self.kernel_world, worlds, options["difficulty"], draws)

    def apply_action(self, actions: Array) -> int:
        return rules.apply_actions(self.kernel_world, actions)

    def evaluate(self) -> None:
        rules.evaluate_worlds(self.kernel_world, self.world.timestep)

    def camera(self, world: int, width: int, height: int) -> Any:
        from gsenv.render.camera import Camera

        x, y = self.task_state["gaze"][world].tolist()
        return Camera((x, y + 0.7), max(7.2, 9.6 * height / width))

    def captions(self, world: int) -> Sequence[str]:
        speed = 3.6 * float(self.world.state.bodies["velocity"][world, scene.CHASSIS_BODY, 0])
        info = self.infos[world]
        lines = [f"{self.task_state['place'][world]:.0f} / {scene.FINISH:.0f} m", f"{speed:.0f} km/h"]
        for shown, line in (
            (info["crashed"], f"crash: {info['shock']:.0f} g"),
            (info["missed_gates"] > 0, "gate missed"),
            (info["success"], "finish"),
        ):
            if shown:
                lines.append(line)
        return lines


class CarHardcoreTask(CarTask):
    """The same on harder courses."""

    max_episode_steps = time_limit("GCar-hardcore-v0")
    arguments = _difficulty_setting(1.0)


_SPECIFICATION = """Drive across country: {id}.

    ## Description
    Seen from the side, a car of 124 kg with two wheels on springs crosses 100 m of hills to a flag. On
    its way are up to six obstacles, two of each kind in any order: gaps with bridges of jointed
    planks, see-saws, and loose boxes. Each wheel has its own motor and brake of bounded torque. The
    car is short and high and its tyres are heavy, so it rears up on climbs, leaves the ground at
    crests that it takes too fast, and turns over; in the air, speeding the wheels up lifts the nose
    and braking them lowers it. A landing that is too hard ends the ride, and over each bridge and
    each see-saw stands a gate that must be passed with the wheels on what it spans. So the way to
    the flag in time is to brake before crests, hollows and gates, and nowhere else. Control runs at 30 Hz.

    The tiers differ in the default of `difficulty` and in the time that they give: GCar-v0 has 0.5 and
    {easy_limit} steps, GCar-hardcore-v0 has 1 and {hard_limit} steps. At 0 the course is nearly flat and empty. With
    rising difficulty, hills become steeper (slopes never exceed 39 degrees), obstacles more frequent
    (from 0.4 on there are all six), gaps wider, see-saws higher, and boxes larger and more numerous.

    ## Action Space
    `Box(-1, 1, (2,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    Positive: the motor drives its wheel with that fraction of its torque, 350 N m, up to 50 rad/s
    (20 m/s). Negative: while the car rolls forwards faster than 0.3 m/s, the brake slows its wheel
    with that fraction of 400 N m, until the wheel stands still; at lower speeds, the motor turns the
    wheel backwards, up to 5 rad/s (2 m/s). So the car brakes with full force without a jump backwards,
    and can still back out where it is stuck. 0: the wheel rolls freely.

    ## Observation Space
    `Box(low, high, (40,), float32)`, always within its bounds.

    {observation_table}

    Each height is that of the highest thing that a wheel would meet there: ground, plank, board or
    box. What touches something is known of the last step: in the first observation nothing does.

    ## Rewards
    The sum of these terms; `info` has each as `reward_<term>`:

    {reward_table}

    Progress is a difference of positions, so going to and fro earns nothing.

    ## Starting State
    The car is at rest on flat ground at 0 m; the hills begin at 3 m. They are the sum of three waves
    of uniformly drawn lengths (5.5 to 8, 9 to 14 and 18 to 28 m) and phases, flat around obstacles.
    The order of the obstacles, which of them stand, and their sizes are drawn anew in each episode.
    Obstacles are asleep until something touches them.

    ## Episode End
    - Termination, success: the middle of the chassis is at 100 m.
    - Termination, failure: a crash. The shock of a step, what an accelerometer on the chassis reads on
      average over the 1/30 s, exceeds 10 g (98.1 m/s^2; at rest it is 1 g). Frames show a star.
    - Termination, failure: a missed gate. An axle has left the 2 m below the bar of a gate forwards, and
      its wheel has touched nothing there. The bar turns from red to green when both wheels have.
    - Termination, failure: the car lies on its roof (its upward axis points below the horizon, and
      the chassis touches something) for 1 s in total, bounces not counted, without having been upright
      in between.
    - Truncation: after {limit} steps ({time} s), by `gymnasium.make`, `gymnasium.make_vec` and the vector environment.

    `info` has `success` and `is_success` (bool), `distance` (m, the largest that was reached), `gates`
    (number passed), `missed_gates` (number), `crashed` (bool), `shock` (g) and `roof_time` (s).

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


def _specification(name: str) -> str:
    limit = time_limit(name)
    filled = _SPECIFICATION.replace("{id}", name).replace("{limit}", str(limit)).replace("{time}", f"{limit / 30:.1f}")
    for tier, which in (("{easy_limit}", "GCar-v0"), ("{hard_limit}", "GCar-hardcore-v0")):
        filled = filled.replace(tier, str(time_limit(which)))
    return filled


@documented
class CarEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _specification("GCar-v0")

    task_class = CarTask
    difficulty: float


class CarVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GCar-v0 in one batch; see CarEnv for the task, TaskVectorEnv for the rest."""

    task_class = CarTask
    difficulty: float


@documented
class CarHardcoreEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _specification("GCar-hardcore-v0")

    task_class = CarHardcoreTask
    difficulty: float


class CarHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GCar-hardcore-v0 in one batch; see CarHardcoreEnv for the task, TaskVectorEnv for the rest."""

    task_class = CarHardcoreTask
    difficulty: float
